//! Numbers as people read them.

/// `1,234,567`.
pub fn integer(number: usize) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && k % 3 == first {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 line`, `2 lines`.
pub fn counted(number: usize, noun: &str) -> String {
    format!("{} {noun}{}", integer(number), if number == 1 { "" } else { "s" })
}

/// `1 case`, `2 cases`.
pub fn cases(number: usize) -> String {
    counted(number, "case")
}

/// `12.5 %`, which no line divides.
pub fn share(part: usize, whole: usize) -> String {
    percent(part, whole) + "\u{a0}%"
}

/// `12.5`, `0.03`; never `0` or `100` for what is neither.
fn percent(part: usize, whole: usize) -> String {
    if part == 0 || whole == 0 {
        return "0".into();
    }
    if part == whole {
        return "100".into();
    }
    match 100.0 * part as f64 / whole as f64 {
        share if share < 0.005 => "<\u{a0}0.01".into(),
        share if share < 9.95 => format!("{share:.2}"),
        share if share > 99.95 => ">\u{a0}99.9".into(),
        share => format!("{share:.1}"),
    }
}

/// `0`, `0.25`, `3.1e-5`, `∞`.
pub fn scientific(number: f64) -> String {
    match number {
        x if x.is_nan() => "–".into(),
        x if x.is_infinite() => "∞".into(),
        0.0 => "0".into(),
        x if (0.01..1e4).contains(&x.abs()) => {
            let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 4) as usize;
            let text = format!("{x:.digits$}");
            if digits == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
        }
        x => format!("{x:.1e}"),
    }
}
