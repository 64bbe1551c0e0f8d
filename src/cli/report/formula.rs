//! Formulas in sentences: what laws say in plain Unicode (`dτ_ξ⁻¹`, `C^c_ab`, `h^{p+1}`), with raised and lowered parts.

use maud::{Markup, PreEscaped};

/// A sentence as HTML: what stands between backquotes is code; a `_` or `^` lowers or raises the braces, the letters and digits, or
/// the sign behind it.
pub fn typeset(text: &str) -> Markup {
    let mut out = String::new();
    for (k, part) in text.split('`').enumerate() {
        if k % 2 == 1 {
            out += &format!("<code>{}</code>", escaped(part));
        } else {
            set(part, &mut out);
        }
    }
    PreEscaped(out)
}

fn set(text: &str, out: &mut String) {
    let mut rest = text;
    while let Some(at) = rest.find(['_', '^']) {
        let tag = if rest[at..].starts_with('_') { "sub" } else { "sup" };
        *out += &escaped(&rest[..at]);
        let (part, after) = argument(&rest[at + 1..]);
        *out += &format!("<{tag}>");
        set(part, out);
        *out += &format!("</{tag}>");
        rest = after;
    }
    *out += &escaped(rest);
}

/// What is raised or lowered, and what follows it.
fn argument(text: &str) -> (&str, &str) {
    if !text.starts_with('{') {
        let word = text.find(|c: char| !c.is_alphanumeric()).unwrap_or(text.len());
        let sign = text.chars().next().map_or(0, char::len_utf8);
        return text.split_at(word.max(sign));
    }
    let mut depth = 0;
    for (at, sign) in text.char_indices() {
        depth += i32::from(sign == '{') - i32::from(sign == '}');
        if depth == 0 {
            return (&text[1..at], &text[at + 1..]);
        }
    }
    (&text[1..], "")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
