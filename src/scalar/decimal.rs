//! Decimal numbers in and out.

use multidouble::qd::QD;
use std::fmt;

/// The number that `text` spells, rounded to four parts (2⁻²¹² relative); `None` if it is none or overflows `f64`.
pub(super) fn parse(text: &str) -> Option<QD> {
    // The f64 first: what is finite there and not 0 has an exponent that the exact parser can work with.
    let nearest = text.parse().ok().filter(|x: &f64| x.is_finite())?;
    if nearest == 0.0 { Some(QD::from_f64(nearest)) } else { QD::parse(text).ok() }
}

/// As many digits are printed.
const DIGITS: usize = 32;

/// 32 digits, trailing zeros dropped; with a precision, that many digits after the point.
pub(super) fn display(x: QD, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if !has_digits(x) {
        return fmt::Display::fmt(&x.to_f64(), f);
    }
    let positive = x.x[0] > 0.0;
    let (all, exponent) = rounded(x, DIGITS);
    let Some(precision) = f.precision() else {
        let kept = all.trim_end_matches('0');
        let text = if (-5..DIGITS as i32).contains(&exponent) {
            positional(kept, exponent)
        } else {
            scientific(kept, exponent)
        };
        return f.pad_integral(positive, "", &text);
    };
    let significant = exponent + 1 + precision as i32;
    if significant < 1 {
        // Less than one digit is left, and the leading part decides it.
        return fmt::Display::fmt(&x.x[0], f);
    }
    let (mut all, exponent) = rounded(x, significant as usize);
    // 9.99 can have become 10.0, which takes one digit more.
    let missing = (exponent + 1 + precision as i32).max(0) as usize;
    all.extend(std::iter::repeat_n('0', missing.saturating_sub(all.len())));
    f.pad_integral(positive, "", &positional(&all, exponent))
}

/// The same with an exponent.
pub(super) fn lower_exp(x: QD, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if !has_digits(x) {
        return fmt::LowerExp::fmt(&x.to_f64(), f);
    }
    let (all, exponent) = rounded(x, f.precision().map_or(DIGITS, |p| p + 1));
    let kept = if f.precision().is_some() { &all } else { all.trim_end_matches('0') };
    f.pad_integral(x.x[0] > 0.0, "", &scientific(kept, exponent))
}

/// Whether x is finite and not 0; what is not is printed as an `f64`.
fn has_digits(x: QD) -> bool {
    x.x.iter().all(|part| part.is_finite()) && x.x[0] != 0.0
}

/// (digits, e) with |x| = d.ddd × 10^e rounded to `count` digits; x finite, not 0.
fn rounded(x: QD, count: usize) -> (String, i32) {
    let text = x.to_sci(count);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.chars().filter(char::is_ascii_digit).collect(), exponent.parse().unwrap_or(0))
}

/// d.ddd × 10^exponent without an exponent.
pub(super) fn positional(digits: &str, exponent: i32) -> String {
    let point = exponent + 1;
    if point <= 0 {
        format!("0.{}{digits}", "0".repeat(-point as usize))
    } else if digits.len() <= point as usize {
        format!("{digits}{}", "0".repeat(point as usize - digits.len()))
    } else {
        format!("{}.{}", &digits[..point as usize], &digits[point as usize..])
    }
}

/// d.ddd × 10^exponent.
pub(super) fn scientific(digits: &str, exponent: i32) -> String {
    let (first, rest) = digits.split_at(1.min(digits.len()));
    let point = if rest.is_empty() { "" } else { "." };
    format!("{first}{point}{rest}e{exponent}")
}
