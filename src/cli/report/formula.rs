//! Formulas in sentences, as MathML: what laws say in plain Unicode (`dτ_ξ⁻¹`, `C^c_ab`, `h^{p+1}`), typeset.
//!
//! A text is cut into tokens, and maximal runs of tokens that can only be mathematics become formulas; all else stays
//! text. A formula is broken before relations and sums, where a line may end. Spaces are kept.

mod token;

use maud::{Markup, PreEscaped};
use std::fmt::Write;
use token::{Token, TokenKind, tokens};

/// A sentence with its formulas typeset.
pub fn typeset(text: &str) -> Markup {
    let tokens = tokens(text);
    let mut out = String::new();
    let mut at = 0;
    for run in runs(&tokens) {
        plain(&tokens[at..run.start], &mut out);
        formula(&tokens[run.clone()], &mut out);
        at = run.end;
    }
    plain(&tokens[at..], &mut out);
    PreEscaped(out)
}

type Run = std::ops::Range<usize>;

/// Tokens that are text.
fn plain(tokens: &[Token], out: &mut String) {
    for token in tokens {
        match token.kind {
            TokenKind::Code => {
                let _ = write!(out, "<code>{}</code>", escaped(&token.text));
            }
            _ => out.push_str(&escaped(&token.raw)),
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Where the formulas are.
fn runs(tokens: &[Token]) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut start = 0;
    while start < tokens.len() {
        let end =
            (start..tokens.len()).find(|&i| tokens[i].kind == TokenKind::Prose || tokens[i].kind == TokenKind::Code);
        let end = end.unwrap_or(tokens.len());
        for balanced in balanced(tokens, start..end) {
            let run = trimmed(tokens, balanced);
            if !run.is_empty()
                && tokens[run.clone()].iter().enumerate().any(|(k, token)| letter(tokens, run.start + k, token))
            {
                runs.push(run);
            }
        }
        start = end + 1;
    }
    runs
}

/// Whether a token makes its run a formula: a symbol, or a number with a power.
fn letter(tokens: &[Token], at: usize, token: &Token) -> bool {
    match token.kind {
        TokenKind::Symbol => true,
        TokenKind::Number => tokens.get(at + 1).is_some_and(Token::is_mark),
        _ => false,
    }
}

/// The parts of a run between brackets without a partner, and between commas that are in no bracket.
fn balanced(tokens: &[Token], run: Run) -> Vec<Run> {
    let paired = paired(tokens, run.clone());
    let (mut parts, mut start, mut depth) = (Vec::new(), run.start, Depth::default());
    for i in run.clone() {
        let cut = match tokens[i].kind {
            TokenKind::Open | TokenKind::Close | TokenKind::Bar => !paired[i],
            TokenKind::Comma => depth.is_zero(),
            _ => false,
        };
        if cut {
            parts.push(start..i);
            start = i + 1;
        } else {
            depth.pass(&tokens[i]);
        }
    }
    parts.push(start..run.end);
    parts
}

/// Which tokens of a run are brackets with a partner in it.
fn paired(tokens: &[Token], run: Run) -> Vec<bool> {
    let mut open: Vec<usize> = Vec::new();
    let mut paired = vec![false; tokens.len()];
    for i in run {
        let closes = match tokens[i].kind {
            TokenKind::Close => true,
            // A bar closes one that is open, within the same bracket.
            TokenKind::Bar => open.last().is_some_and(|&o| tokens[o].kind == TokenKind::Bar),
            _ => false,
        };
        if closes {
            if let Some(place) = open.iter().rposition(|&o| tokens[o].closing() == tokens[i].text) {
                paired[open[place]] = true;
                paired[i] = true;
                open.truncate(place);
            }
        } else if matches!(tokens[i].kind, TokenKind::Open | TokenKind::Bar) {
            open.push(i);
        }
    }
    paired
}

/// How many brackets are open.
#[derive(Default)]
struct Depth {
    brackets: usize,
    bar: bool,
}

impl Depth {
    fn pass(&mut self, token: &Token) {
        match token.kind {
            TokenKind::Open => self.brackets += 1,
            TokenKind::Close => self.brackets = self.brackets.saturating_sub(1),
            TokenKind::Bar => self.bar = !self.bar,
            _ => {}
        }
    }

    fn is_zero(&self) -> bool {
        self.brackets == 0 && !self.bar
    }
}

/// Without spaces at the ends, nor operators that lack a side there.
fn trimmed(tokens: &[Token], run: Run) -> Run {
    let Run { mut start, mut end } = run;
    while start < end {
        let space = |i: usize| tokens.get(i).is_some_and(|token| token.kind == TokenKind::Space);
        if space(start) || (tokens[start].kind == TokenKind::Operator && (space(start + 1) || start + 1 == end)) {
            start += 1;
        } else if space(end - 1) || tokens[end - 1].kind == TokenKind::Operator {
            end -= 1;
        } else {
            break;
        }
    }
    start..end
}

/// A run as formulas, one for each piece that stays on a line.
fn formula(tokens: &[Token], out: &mut String) {
    let (mut start, mut depth) = (0, Depth::default());
    for (i, token) in tokens.iter().enumerate() {
        let operator = token.kind == TokenKind::Operator && token.breaks() && depth.is_zero();
        if operator && i > start + 1 && follows_term(&tokens[..i]) {
            piece(&tokens[start..i - 1], start > 0, out);
            out.push(' ');
            start = i;
        }
        depth.pass(token);
    }
    piece(&tokens[start..], start > 0, out);
}

/// Whether a term and a space come last.
fn follows_term(tokens: &[Token]) -> bool {
    match tokens {
        [.., term, space] => space.kind == TokenKind::Space && term.kind != TokenKind::Operator,
        _ => false,
    }
}

fn piece(tokens: &[Token], continued: bool, out: &mut String) {
    out.push_str("<math>");
    let mut writer = Writer { tokens, at: 0, after: if continued { After::Break } else { After::Nothing }, out };
    writer.row(None);
    out.push_str("</math>");
}

/// What stands before a token, which tells a sign from a difference.
#[derive(Clone, Copy, PartialEq)]
enum After {
    /// The start of a formula or bracket, an operator, a comma.
    Nothing,
    /// The end of a line, in a formula that goes on.
    Break,
    /// Something that can be added to.
    Term,
}

struct Writer<'a> {
    tokens: &'a [Token],
    at: usize,
    after: After,
    out: &'a mut String,
}

impl Writer<'_> {
    /// Everything up to the end, or to this closing bracket.
    fn row(&mut self, until: Option<&str>) {
        while let Some(token) = self.tokens.get(self.at) {
            if until.is_some_and(|end| matches!(token.kind, TokenKind::Close | TokenKind::Bar) && token.text == end) {
                return;
            }
            match token.kind {
                TokenKind::Space => self.space(),
                TokenKind::Operator => self.operator(),
                TokenKind::Comma => {
                    self.element("mo", "", &token.text);
                    self.at += 1;
                    self.after = After::Nothing;
                }
                _ => self.term(),
            }
        }
    }

    /// Between two terms a space is seen; beside an operator the operator has its own.
    fn space(&mut self) {
        self.out.push(' ');
        self.at += 1;
        let next = self.tokens.get(self.at).map(|token| token.kind);
        let beside = matches!(next, None | Some(TokenKind::Operator | TokenKind::Comma | TokenKind::Close));
        if self.after == After::Term && !beside {
            self.out.push_str("<mspace width=\"0.2em\"/>");
        }
    }

    fn element(&mut self, name: &str, attributes: &str, text: &str) {
        let _ = write!(self.out, "<{name}{attributes}>{}</{name}>", escaped(text));
    }

    fn operator(&mut self) {
        let text = self.tokens[self.at].text.as_str();
        let attributes = match (text, self.after) {
            ("/" | "∘", _) => " lspace=\"0\" rspace=\"0\"",
            ("−" | "+" | "±", After::Nothing) => " form=\"prefix\" lspace=\"0\" rspace=\"0\"",
            (_, After::Break) => " form=\"infix\" lspace=\"0\"",
            _ => " form=\"infix\"",
        };
        self.element("mo", attributes, text);
        self.at += 1;
        self.after = After::Nothing;
    }

    /// A symbol, number or bracket with its marks.
    fn term(&mut self) {
        let mark = self.out.len();
        let token = &self.tokens[self.at];
        match token.kind {
            TokenKind::Open => self.group(token.closing()),
            TokenKind::Bar => self.group("|"),
            TokenKind::Number => {
                self.element("mn", "", &token.text);
                self.at += 1;
            }
            _ => {
                self.at += 1;
                let last = self.letters(&token.text);
                return self.marks(last);
            }
        }
        self.marks(mark);
    }

    /// A bracket with what is in it.
    fn group(&mut self, closing: &str) {
        self.out.push_str("<mrow>");
        let opening = self.tokens[self.at].text.as_str();
        self.element("mo", " stretchy=\"false\" form=\"prefix\"", opening);
        self.at += 1;
        self.after = After::Nothing;
        self.row(Some(closing));
        if self.at < self.tokens.len() {
            self.element("mo", " stretchy=\"false\" form=\"postfix\"", closing);
            self.at += 1;
        }
        self.out.push_str("</mrow>");
    }

    /// The letters of a symbol, each by itself unless they are a name; where the last of them starts.
    fn letters(&mut self, text: &str) -> usize {
        if token::is_name(text) {
            let start = self.out.len();
            self.element("mi", " mathvariant=\"normal\"", text);
            return start;
        }
        let mut start = self.out.len();
        for (base, accents) in token::letters(text) {
            start = self.out.len();
            for _ in &accents {
                self.out.push_str("<mover accent=\"true\">");
            }
            match base {
                'Σ' | '∫' if text.chars().count() == 1 && !self.ends() => {
                    self.element("mo", " lspace=\"0\" rspace=\"0.1em\" movablelimits=\"false\"", &base.to_string());
                }
                // Capital Greek letters stand upright.
                'Α'..='Ω' | '∂' | '∞' | '…' | '·' | '∫' => {
                    self.element("mi", " mathvariant=\"normal\"", &base.to_string());
                }
                _ => self.element("mi", "", &base.to_string()),
            }
            for accent in accents {
                self.element("mo", " stretchy=\"false\"", &accent.to_string());
                self.out.push_str("</mover>");
            }
        }
        start
    }

    /// Whether nothing follows within the bracket.
    fn ends(&self) -> bool {
        self.tokens.get(self.at).is_none_or(|token| matches!(token.kind, TokenKind::Close | TokenKind::Comma))
    }

    /// Puts the marks that follow on what was written from `start` on.
    fn marks(&mut self, start: usize) {
        let (mut below, mut above, mut primes) = (Vec::new(), Vec::new(), 0);
        while let Some(token) = self.tokens.get(self.at) {
            match token.kind {
                TokenKind::Script { up: false } => below.push(inner(&token.text)),
                TokenKind::Script { up: true } => above.push(inner(&token.text)),
                TokenKind::Prime => primes += token.text.len(),
                TokenKind::Star => above.push("<mo>∗</mo>".into()),
                TokenKind::Arrow => {
                    self.out.insert_str(start, "<mover accent=\"true\">");
                    let _ = write!(self.out, "<mo stretchy=\"false\">{}</mo></mover>", token.text);
                }
                _ => break,
            }
            self.at += 1;
        }
        if primes > 0 {
            // In text fonts a prime is raised by itself: it belongs to what other marks stand on.
            self.out.insert_str(start, "<mrow>");
            let _ = write!(self.out, "<mo lspace=\"0\" rspace=\"0\">{}</mo></mrow>", "′".repeat(primes));
        }
        let name = match (below.is_empty(), above.is_empty()) {
            (true, true) => "",
            (false, true) => "msub",
            (true, false) => "msup",
            (false, false) => "msubsup",
        };
        if !name.is_empty() {
            self.out.insert_str(start, &format!("<{name}>"));
            for marks in [below, above].iter().filter(|marks| !marks.is_empty()) {
                let _ = write!(self.out, "<mrow>{}</mrow>", marks.concat());
            }
            let _ = write!(self.out, "</{name}>");
        }
        self.after = After::Term;
    }
}

/// What is in a subscript or superscript.
fn inner(text: &str) -> String {
    let mut out = String::new();
    let tokens = token::all_symbols(text);
    Writer { tokens: &tokens, at: 0, after: After::Nothing, out: &mut out }.row(None);
    out
}
