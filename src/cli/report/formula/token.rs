//! The tokens of a sentence, and which of them are mathematics.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// Words, and all that is never in a formula.
    Prose,
    /// A name of the program, between backquotes.
    Code,
    /// White space.
    Space,
    /// One or more letters, each a symbol; or the name of a function.
    Symbol,
    /// Digits, or a fraction in one character.
    Number,
    /// A relation, or what joins two terms.
    Operator,
    /// An opening bracket.
    Open,
    /// A closing bracket.
    Close,
    /// A bar, which opens or closes.
    Bar,
    /// A comma, colon or semicolon.
    Comma,
    /// A subscript or superscript.
    Script {
        /// Whether it is a superscript.
        up: bool,
    },
    /// Primes.
    Prime,
    /// The star of a dual.
    Star,
    /// An arrow above.
    Arrow,
}

/// A piece of a sentence.
#[derive(Clone, Debug)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// What is shown in a formula.
    pub text: String,
    /// As it is written.
    pub raw: String,
}

impl Token {
    /// Whether it belongs to what stands before it.
    pub fn is_mark(&self) -> bool {
        matches!(self.kind, TokenKind::Script { .. } | TokenKind::Prime | TokenKind::Star | TokenKind::Arrow)
    }

    /// The bracket that closes this one.
    pub fn closing(&self) -> &'static str {
        match self.text.as_str() {
            "(" => ")",
            "[" => "]",
            "{" => "}",
            "⟨" => "⟩",
            "⟦" => "⟧",
            _ => "|",
        }
    }

    /// Whether a line may end before this operator.
    pub fn breaks(&self) -> bool {
        !matches!(self.text.as_str(), "/" | "∘" | "·" | "×" | "⋊" | "∈")
    }
}

/// Names of functions, written upright.
const NAMES: [&str; 5] = ["Ad", "ad", "dim", "diag", "det"];

/// Names of functions that are words as well: of functions only before a bracket.
const WORDS: [&str; 9] = ["exp", "log", "hat", "vee", "max", "min", "sin", "cos", "tanh"];

/// Words of two letters; others are products or differentials.
const SHORT: [&str; 55] = [
    "am", "an", "as", "at", "be", "by", "do", "go", "he", "if", "in", "is", "it", "me", "my", "no", "of", "on", "or",
    "so", "to", "up", "us", "we", "An", "As", "At", "By", "If", "In", "Is", "It", "No", "Of", "On", "Or", "So", "To",
    "Up", "We", "dd", "II", "IV", "VI", "IX", "ch", "Eq", "eq", "vs", "de", "SO", "SE", "SU", "GL", "SL",
];

/// Whether this is the name of a function.
pub fn is_name(text: &str) -> bool {
    NAMES.contains(&text) || WORDS.contains(&text)
}

/// Letters with an accent, and the same with the accent apart.
const ACCENTED: [(char, char, char); 14] = [
    ('â', 'a', 'ˆ'),
    ('ê', 'e', 'ˆ'),
    ('ŷ', 'y', 'ˆ'),
    ('ẑ', 'z', 'ˆ'),
    ('ĝ', 'g', 'ˆ'),
    ('ĥ', 'h', 'ˆ'),
    ('ġ', 'g', '˙'),
    ('ḣ', 'h', '˙'),
    ('ẋ', 'x', '˙'),
    ('ẏ', 'y', '˙'),
    ('Ḟ', 'F', '˙'),
    ('Ċ', 'C', '˙'),
    ('Ė', 'E', '˙'),
    ('ũ', 'u', '˜'),
];

/// What stands above a letter for a combining accent.
fn accent(c: char) -> Option<char> {
    Some(match c {
        '\u{302}' => 'ˆ',
        '\u{303}' => '˜',
        '\u{304}' | '\u{305}' => '‾',
        '\u{307}' => '˙',
        '\u{308}' => '¨',
        '\u{30c}' => 'ˇ',
        _ => return None,
    })
}

/// Letters, each with its accents.
pub fn letters(text: &str) -> Vec<(char, Vec<char>)> {
    let mut letters: Vec<(char, Vec<char>)> = Vec::new();
    for c in text.chars() {
        match (accent(c), letters.last_mut()) {
            (Some(accent), Some((_, accents))) => accents.push(accent),
            _ => match ACCENTED.iter().find(|(whole, ..)| *whole == c) {
                Some((_, base, accent)) => letters.push((*base, vec![*accent])),
                None => letters.push((c, Vec::new())),
            },
        }
    }
    letters
}

/// A raised or lowered character, and the one that it stands for.
fn script(c: char) -> Option<(bool, char)> {
    const UP: (&str, &str) = ("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁼⁽⁾ᵀⁿⁱᵃᵇᵈᵍʰᵏᵐᵖʳˢᵗ", "0123456789+−=()TniabdghkmprstT");
    const DOWN: (&str, &str) = ("₀₁₂₃₄₅₆₇₈₉₊₋₌₍₎ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜₓ", "0123456789+−=()aehijklmnoprstx");
    let find = |(from, to): (&str, &str)| from.chars().position(|f| f == c).and_then(|k| to.chars().nth(k));
    find(UP).map(|plain| (true, plain)).or_else(|| find(DOWN).map(|plain| (false, plain)))
}

fn is_letter(c: char) -> bool {
    (c.is_alphabetic() || matches!(c, '∂' | '∞')) && script(c).is_none()
}

fn is_greek(c: char) -> bool {
    ('\u{370}'..='\u{3ff}').contains(&c) || matches!(c, '∂' | '∞' | 'ℝ' | 'ℓ')
}

/// The tokens of a sentence.
pub fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Lexer { rest: text, tokens: Vec::new() }.run();
    for at in 0..tokens.len() {
        if tokens[at].kind == TokenKind::Symbol && !is_symbol(&tokens, at) {
            tokens[at].kind = TokenKind::Prose;
            // Its marks are then text as well.
            let marks = tokens[at + 1..].iter().take_while(|token| token.is_mark()).count();
            tokens[at + 1..=at + marks].iter_mut().for_each(|token| token.kind = TokenKind::Prose);
        }
    }
    tokens
}

/// The tokens of a script, in which every letter is a symbol.
pub fn all_symbols(text: &str) -> Vec<Token> {
    Lexer { rest: text, tokens: Vec::new() }.run()
}

/// Whether letters are symbols rather than a word.
fn is_symbol(tokens: &[Token], at: usize) -> bool {
    let text = tokens[at].raw.as_str();
    let (before, after) = (at.checked_sub(1).map(|k| &tokens[k]), tokens.get(at + 1));
    let marked = after.is_some_and(Token::is_mark);
    let called = after.is_some_and(|token| matches!(token.raw.as_str(), "(" | "|"));
    let hyphen =
        |token: Option<&Token>| token.is_some_and(|token| token.raw.starts_with('-') && token.kind == TokenKind::Prose);
    let count = letters(text).len();
    if text.chars().any(is_greek) {
        return true;
    }
    match count {
        // Of a name like `sum-v-sides`.
        _ if hyphen(before) || hyphen(after) => false,
        _ if NAMES.contains(&text) => true,
        1 => match text {
            "a" | "A" | "I" => marked || is_between(tokens, at),
            // The V of a chapter "V.1".
            _ => {
                after.is_none_or(|token| token.raw != ".")
                    || tokens.get(at + 2).is_none_or(|t| t.kind != TokenKind::Number)
            }
        },
        _ if WORDS.contains(&text) => called || marked,
        2 => !SHORT.contains(&text) && letters(text).iter().all(|(base, _)| base.is_ascii_alphabetic()),
        3 => marked && !tokens[at + 1].raw.starts_with('\''),
        _ => false,
    }
}

/// Whether a letter that is a word as well stands where only a symbol can.
fn is_between(tokens: &[Token], at: usize) -> bool {
    let next = tokens[at + 1..].iter().find(|token| token.kind != TokenKind::Space);
    let last = tokens[..at].iter().rev().find(|token| token.kind != TokenKind::Space);
    let opened = last.is_some_and(|token| {
        matches!(token.kind, TokenKind::Open | TokenKind::Comma | TokenKind::Operator | TokenKind::Bar)
    });
    match next {
        None => opened,
        Some(token) => match token.kind {
            TokenKind::Operator => true,
            TokenKind::Close | TokenKind::Comma | TokenKind::Bar => opened,
            _ => false,
        },
    }
}

struct Lexer<'a> {
    rest: &'a str,
    tokens: Vec<Token>,
}

impl Lexer<'_> {
    fn run(mut self) -> Vec<Token> {
        while let Some(c) = self.rest.chars().next() {
            self.next(c);
        }
        self.tokens
    }

    /// Takes so many bytes as a token of this kind.
    fn take(&mut self, kind: TokenKind, bytes: usize) {
        let (raw, rest) = self.rest.split_at(bytes);
        self.rest = rest;
        self.tokens.push(Token { kind, text: raw.into(), raw: raw.into() });
    }

    fn mark(&mut self, kind: TokenKind, bytes: usize, text: String) {
        self.take(kind, bytes);
        if let Some(token) = self.tokens.last_mut() {
            token.text = text;
        }
    }

    /// How many bytes satisfy a condition.
    fn while_(&self, condition: impl Fn(char) -> bool) -> usize {
        self.rest.find(|c| !condition(c)).unwrap_or(self.rest.len())
    }

    /// Whether the last token is something that marks belong to.
    fn has_base(&self) -> bool {
        self.tokens.last().is_some_and(|token| {
            token.is_mark()
                || matches!(token.kind, TokenKind::Symbol | TokenKind::Number | TokenKind::Close | TokenKind::Bar)
        })
    }

    fn next(&mut self, c: char) {
        let second = self.rest.chars().nth(1);
        let size = c.len_utf8();
        match c {
            _ if c.is_whitespace() => self.take(TokenKind::Space, self.while_(char::is_whitespace)),
            '`' => self.code(),
            '0'..='9' => self.number(),
            '½' | '⅓' | '¼' | '⅛' | '¾' | '⅔' => self.take(TokenKind::Number, size),
            '(' | '[' | '{' | '⟨' | '⟦' => self.take(TokenKind::Open, size),
            ')' | ']' | '}' | '⟩' | '⟧' => self.take(TokenKind::Close, size),
            '|' => self.take(TokenKind::Bar, size),
            ',' | ';' | ':' => self.take(TokenKind::Comma, size),
            '_' | '^' if self.has_base() => self.script(c == '^'),
            '\'' if self.has_base() => {
                let count = self.while_(|c| c == '\'');
                self.take(TokenKind::Prime, count);
            }
            '*' if self.has_base() => self.mark(TokenKind::Star, size, "*".into()),
            '→' | '←' if self.tokens.last().is_some_and(|token| token.kind == TokenKind::Symbol) => {
                self.take(TokenKind::Arrow, size)
            }
            '×' | '±' if self.has_base() && !second.is_some_and(|c| is_letter(c) || c.is_ascii_digit() || c == '⟨') =>
            {
                self.mark(TokenKind::Script { up: true }, size, c.to_string());
            }
            '+' | '−' | '±' | '×' | '·' | '∘' | '/' | '=' | '≠' | '≤' | '≥' | '<' | '>' | '→' | '←' | '↦' | '∈'
            | '≈' | '≡' | '∼' | '⋊' | '*' => self.take(TokenKind::Operator, size),
            '…' | '∫' => self.take(TokenKind::Symbol, size),
            _ if script(c).is_some() && self.has_base() => self.raised(),
            _ if is_letter(c) => self.word(),
            _ => self.take(TokenKind::Prose, size),
        }
    }

    fn code(&mut self) {
        match self.rest[1..].find('`') {
            Some(end) => {
                let text = self.rest[1..=end].to_owned();
                self.mark(TokenKind::Code, end + 2, text);
            }
            None => self.take(TokenKind::Prose, 1),
        }
    }

    /// `12`, `2.5`, `1e-14`.
    fn number(&mut self) {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') && digits(end + 1) > 0 {
            end += 1 + digits(end + 1);
        }
        if bytes.get(end) == Some(&b'e') {
            let sign = usize::from(bytes.get(end + 1) == Some(&b'-'));
            if end + 1 + sign < bytes.len() && digits(end + 1 + sign) > 0 {
                end += 1 + sign + digits(end + 1 + sign);
            }
        }
        self.take(TokenKind::Number, end);
    }

    /// Letters with their accents; with digits behind them (`f64`) or a possessive it is a word for certain.
    fn word(&mut self) {
        let end = self.while_(|c| is_letter(c) || accent(c).is_some());
        let (word, rest) = self.rest.split_at(end);
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        if digits > 0 && word.is_ascii() {
            return self.take(TokenKind::Prose, end + digits);
        }
        let possessive = rest.strip_prefix("'s").is_some_and(|rest| !rest.starts_with(is_letter));
        if possessive && letters(word).len() > 1 && !word.chars().any(is_greek) {
            return self.take(TokenKind::Prose, end + 2);
        }
        self.take(TokenKind::Symbol, end);
        if possessive {
            self.take(TokenKind::Prose, 2);
        }
    }

    /// Characters that are raised or lowered by themselves.
    fn raised(&mut self) {
        let Some((up, _)) = self.rest.chars().next().and_then(script) else { return };
        let end = self.while_(|c| script(c).is_some_and(|(other, _)| other == up));
        let text = self.rest[..end].chars().filter_map(|c| script(c).map(|(_, plain)| plain)).collect();
        self.mark(TokenKind::Script { up }, end, text);
    }

    /// `_ab`, `_{i,j}`, `^2.5`.
    fn script(&mut self, up: bool) {
        let after = &self.rest[1..];
        if after.starts_with('{')
            && let Some(end) = group(after)
        {
            let text = after[1..end].to_owned();
            return self.mark(TokenKind::Script { up }, end + 2, text);
        }
        let number = after.starts_with(|c: char| c.is_ascii_digit());
        let belongs = |c: char| {
            if number {
                c.is_ascii_digit() || c == '.'
            } else {
                is_letter(c) || accent(c).is_some() || c.is_ascii_digit()
            }
        };
        let mut end = after.find(|c| !belongs(c)).unwrap_or(after.len());
        // The full stop of a sentence is not part of a number.
        end -= usize::from(after[..end].ends_with('.'));
        if end == 0 {
            end = after.chars().next().filter(|c| matches!(c, '×' | '±' | '+' | '−' | '*')).map_or(0, char::len_utf8);
        }
        match end {
            0 => self.take(TokenKind::Prose, 1),
            _ => {
                let text = after[..end].to_owned();
                self.mark(TokenKind::Script { up }, end + 1, text);
            }
        }
    }
}

/// Where the brace that opens a text is closed.
fn group(text: &str) -> Option<usize> {
    let mut depth = 0;
    text.char_indices().find_map(|(at, c)| {
        depth += match c {
            '{' => 1,
            '}' => -1,
            _ => 0,
        };
        (depth == 0).then_some(at)
    })
}
