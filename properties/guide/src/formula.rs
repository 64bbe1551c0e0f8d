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

/// Abbreviations for the notation of the crate.
const MACROS: [(&str, &str); 12] = [
    ("g", r"\mathfrak{g}"),
    ("gd", r"\mathfrak{g}^*"),
    ("R", r"\mathbb{R}"),
    ("ad", r"\mathrm{ad}"),
    ("Ad", r"\mathrm{Ad}"),
    ("cay", r"\operatorname{cay}"),
    ("dtau", r"\mathrm{d}\tau"),
    ("ddtau", r"\mathrm{dd}\tau"),
    ("D", r"\mathrm{d}"),
    ("hata", r"\hat{a}"),
    ("tr", r"\mathsf{T}"),
    ("pair", r"\langle #1, #2 \rangle"),
];

/// The formula as MathML on one line.
///
/// # Errors
/// What is wrong with the LaTeX.
pub fn convert(latex: &str, place: Place) -> Result<String, String> {
    let macros = MACROS.map(|(name, definition)| (name.to_owned(), definition.to_owned())).to_vec();
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
    mathml
        .replace("<mrow><mspace/><mi mathvariant=\"normal\">d</mi></mrow>", "<mi mathvariant=\"normal\">d</mi>")
        .replace("<mspace/>", "")
        .replace("0.16666667em", ".17em")
        .replace("0.1667em", ".17em")
        .replace("0.2222em", ".22em")
        .replace("justify-items: end;", "")
        .replace("justify-items: start;", "")
        .replace("text-align: right;padding-right: 0;", "text-align:right;padding-right:0")
        .replace("text-align: left;padding-left: 0;", "text-align:left;padding-left:0")
        // Without a mathematical font an accent would touch its letter.
        .replace("<mo>˙</mo></mover>", "<mo style=\"padding-bottom:.1em\">˙</mo></mover>")
        .replace("<mo stretchy=\"false\">ˆ</mo></mover>", "<mo style=\"padding-bottom:.1em\">ˆ</mo></mover>")
        .replace("<mo stretchy=\"false\">˜</mo></mover>", "<mo style=\"padding-bottom:.1em\">˜</mo></mover>")
        // Without a mathematical font the index below a sum would touch it.
        .replace("<mo>∑</mo><mi>", "<mo>∑</mo><mi style=\"padding-top:.2em\">")
        .replace("<mo>∑</mo><mrow>", "<mo>∑</mo><mrow style=\"padding-top:.2em\">")
        .replace("<mo>∏</mo><mrow>", "<mo>∏</mo><mrow style=\"padding-top:.2em\">")
        .replace("\n", "")
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
