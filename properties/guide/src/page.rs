//! One page: Markdown with LaTeX to Markdown with MathML.

use crate::formula::{Place, convert};
use pulldown_cmark::{Event, Options, Parser};

/// Blocks of the documentation scroll sideways, so accents and indices that reach below the last line would give them a vertical
/// scroll bar as well.
const STYLE: &str = "\n<style>.docblock>p,.docblock>ul,.docblock>ol,.docblock>div{overflow-y:hidden}</style>\n";

/// Replaces the formulas of a page. Code is left alone.
///
/// # Errors
/// A formula that is no LaTeX, with its line.
pub fn render(text: &str) -> Result<String, String> {
    let options = Options::ENABLE_MATH | Options::ENABLE_TABLES;
    let mut page = String::with_capacity(4 * text.len());
    let mut end = 0;
    for (event, range) in Parser::new_ext(text, options).into_offset_iter() {
        let (latex, place) = match event {
            Event::InlineMath(latex) => (latex, Place::Line),
            Event::DisplayMath(latex) => (latex, Place::Block),
            _ => continue,
        };
        let line = 1 + text[..range.start].matches('\n').count();
        page.push_str(&text[end..range.start]);
        page.push_str(&convert(&latex, place).map_err(|error| format!("line {line}: {error}"))?);
        end = range.end;
    }
    page.push_str(&text[end..]);
    if end > 0 {
        page.push_str(STYLE);
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::render;

    #[test]
    fn code_is_left_alone() {
        let text = "Say `$x$`:\n\n```sh\necho $x $y\n```\n";
        assert_eq!(render(text).unwrap(), text);
    }

    #[test]
    fn what_markdown_would_read_is_escaped() {
        let page = render("| a |\n|---|\n| $a^* [b^*]$ |\n").unwrap();
        assert!(page.contains("<math>") && !page.contains('*') && !page.contains("[b"), "{page}");
    }

    #[test]
    fn a_prime_stands_beside_its_letter() {
        let page = render("$l'(x)$ and $l_d'$\n").unwrap();
        assert!(page.contains("<mrow><mi>l</mi><mo lspace=\"0\" rspace=\"0\">′</mo></mrow>"), "{page}");
        assert!(
            page.contains("</msub><mo lspace=\"0\" rspace=\"0\">′</mo></mrow>") && !page.contains("sup>"),
            "{page}"
        );
    }

    #[test]
    fn a_display_is_one_line() {
        let page = render("so\n\n$$\nx = 1\n$$\n\nand\n").unwrap();
        let lines: Vec<_> = page.lines().collect();
        assert_eq!((lines[1], lines[3]), ("", ""));
        assert!(lines[2].starts_with("<div") && lines[2].ends_with("</math></div>"), "{page}");
    }

    #[test]
    fn an_unknown_command_is_an_error_with_its_line() {
        let error = render("one\n\n$\\nonsense$\n").unwrap_err();
        assert!(error.starts_with("line 3: "), "{error}");
    }
}
