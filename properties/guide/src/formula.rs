//! One formula: LaTeX to MathML that survives rustdoc's Markdown.

use math_core::{LatexToMathML, MathCoreConfig, MathDisplay};

/// Where a formula stands.
#[derive(Clone, Copy, PartialEq)]
pub enum Place {
    /// In a line of text.
    Line,
    /// On its own.
    Block,
}

/// Abbreviations for the notation of the crate: a name, and what it stands for.
const MACROS: &str = include_str!("macros.txt");

/// What becomes shorter, and how.
const SHORTER: &str = include_str!("shorter.txt");

/// The formula as MathML on one line.
///
/// # Errors
/// What is wrong with the LaTeX.
pub fn convert(latex: &str, place: Place) -> Result<String, String> {
    let macros = MACROS.lines().filter_map(|row| row.split_once(' '));
    let macros: Vec<_> = macros.map(|(name, definition)| (name.to_owned(), definition.to_owned())).collect();
    assert_eq!(macros.len(), 12, "macros");
    let macros = macros.into_iter().collect();
    let config = MathCoreConfig { macros, ..MathCoreConfig::default() };
    let converter = LatexToMathML::new(config).map_err(|error| format!("in the macros: {error:?}"))?;
    let display = if place == Place::Block { MathDisplay::Block } else { MathDisplay::Inline };
    let mathml = converter.convert_with_local_counter(latex, display).map_err(|error| format!("{error} in {latex}"))?;
    let mathml = escaped(&primed(primed(shortened(&mathml), "msup", ""), "msubsup", "msub"));
    Ok(match place {
        Place::Line => mathml,
        Place::Block => format!("<div style=\"overflow:auto hidden;margin:1em 0;padding:.2em 0\">{mathml}</div>"),
    })
}

/// Without what says nothing.
fn shortened(mathml: &str) -> String {
    let rows = SHORTER.lines().filter(|row| !row.starts_with('#')).filter_map(|row| row.split_once(" →"));
    assert_eq!(rows.clone().count(), 15, "what becomes shorter");
    rows.fold(mathml.to_owned(), |text, (long, short)| text.replace(long, short.trim_start())).replace('\n', "")
}

/// With primes beside their letters: a prime is raised already, and as an exponent it would be too small to read.
///
/// `script` is the element whose last child is the prime, `base` the one that takes its other children.
fn primed(mut mathml: String, script: &str, base: &str) -> String {
    let (open, close) = (format!("<{script}>"), format!("<mo>′</mo></{script}>"));
    let (before, after) =
        if base.is_empty() { (String::new(), String::new()) } else { (format!("<{base}>"), format!("</{base}>")) };
    while let Some(end) = mathml.find(&close) {
        let Some(start) = mathml[..end].rfind(&open) else { break };
        let inner = &mathml[start + open.len()..end];
        let beside = format!("<mrow>{before}{inner}{after}<mo lspace=\"0\" rspace=\"0\">′</mo></mrow>");
        mathml.replace_range(start..end + close.len(), &beside);
    }
    mathml
}

/// Numeric entities for the characters that Markdown would read. Only text is escaped, not tags.
fn escaped(mathml: &str) -> String {
    let mut text = String::with_capacity(mathml.len());
    let mut in_tag = false;
    for c in mathml.chars() {
        match c {
            '<' => in_tag = true,
            '>' => in_tag = false,
            _ => {}
        }
        if !in_tag && "*_[]\\|`~$'\"!".contains(c) {
            text.push_str(&format!("&#{};", u32::from(c)));
        } else {
            text.push(c);
        }
    }
    text
}
