//! From text to a graph.

use super::Shape::{self, Matrix, Scalar, Vector};
use super::error::{ExpressionError, Spot};
use super::graph::{Binary, Builder, Graph, Id, Origin, Unary};
use super::names::{FUNCTIONS, Function, Meaning, Names};
use super::{DEEPEST, LONGEST};
use crate::scalar::Number;
use std::collections::BTreeMap;

/// The largest exponent that becomes products.
const MOST_FACTORS: f64 = 1024.0;

/// A number, a vector or a matrix of nodes, by rows.
#[derive(Clone, Debug)]
struct Item {
    shape: Shape,
    nodes: Vec<Id>,
}

impl Item {
    fn scalar(node: Id) -> Self {
        Self { shape: Scalar, nodes: vec![node] }
    }

    fn vector(nodes: Vec<Id>) -> Self {
        Self { shape: Vector(nodes.len()), nodes }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'a> {
    Number(&'a str),
    Name(&'a str),
    Sign(char),
    End,
}

impl Token<'_> {
    fn said(self) -> String {
        match self {
            Self::Number(text) | Self::Name(text) => format!("`{text}`"),
            Self::Sign(sign) => format!("`{sign}`"),
            Self::End => "the end".into(),
        }
    }
}

/// The state of reading one text; definitions have one of their own.
struct Reader<'a> {
    text: &'a str,
    /// Its number among the texts of the graph.
    number: usize,
    at: usize,
}

struct Parser<'a> {
    names: &'a Names,
    builder: Builder,
    /// Definitions that have been read.
    read: BTreeMap<String, Item>,
    /// Those that are being read, outermost first.
    open: Vec<String>,
    depth: usize,
}

type Read<T> = Result<T, ExpressionError>;

pub(super) fn parse(text: &str, names: &Names) -> Read<(Shape, Graph)> {
    let mut parser = Parser { names, builder: Builder::default(), read: BTreeMap::new(), open: Vec::new(), depth: 0 };
    let Item { shape, nodes } = parser.whole(text, None)?;
    parser.builder.graph.outputs = nodes;
    Ok((shape, parser.builder.graph))
}

impl<'a> Reader<'a> {
    fn skip(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// The next token, and its length.
    fn look(&mut self) -> (Token<'a>, usize) {
        self.skip();
        let rest = &self.text[self.at..];
        let Some(first) = rest.chars().next() else { return (Token::End, 0) };
        if first.is_ascii_digit() || (first == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())) {
            let length = number_length(rest);
            return (Token::Number(&rest[..length]), length);
        }
        if first.is_alphabetic() {
            let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            return (Token::Name(&rest[..length]), length);
        }
        (Token::Sign(first), first.len_utf8())
    }

    fn eat(&mut self, sign: char) -> bool {
        let (token, length) = self.look();
        let found = token == Token::Sign(sign);
        self.at += if found { length } else { 0 };
        found
    }

    /// Where the next token is.
    fn origin(&mut self) -> Origin {
        self.skip();
        Origin { text: self.number, at: self.at }
    }
}

/// How long the decimal at the start of a text is, with fraction and exponent.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| text[from..].find(|c: char| !c.is_ascii_digit()).map_or(text.len(), |n| from + n);
    let mut end = digits(0);
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    end
}

impl Parser<'_> {
    fn refused<T>(&self, origin: Origin, message: impl Into<String>) -> Read<T> {
        Err(ExpressionError { spot: self.builder.graph.spot(origin), message: message.into() })
    }

    /// A whole text.
    fn whole(&mut self, text: &str, definition: Option<&str>) -> Read<Item> {
        let spot = |at| Spot { text: text.into(), definition: definition.map(String::from), at };
        if text.len() > LONGEST {
            let message = format!("a formula of {} bytes is too long; allowed: at most {LONGEST}", text.len());
            return Err(ExpressionError { spot: Spot { text: String::new(), ..spot(0) }, message });
        }
        let texts = &mut self.builder.graph.texts;
        texts.push((definition.map(String::from), text.into()));
        let mut reader = Reader { text, number: texts.len() - 1, at: 0 };
        if reader.look().0 == Token::End {
            return Err(ExpressionError { spot: spot(0), message: "the formula is empty".into() });
        }
        let item = self.sum(&mut reader)?;
        match reader.look().0 {
            Token::End => Ok(item),
            token => {
                let origin = reader.origin();
                self.refused(origin, format!("{} does not belong here; expected an operation or the end", token.said()))
            }
        }
    }

    fn deeper(&mut self, origin: Origin) -> Read<()> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.refused(origin, format!("nested more than {DEEPEST} deep"));
        }
        Ok(())
    }

    fn sum(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let mut left = self.product(reader)?;
        loop {
            let origin = reader.origin();
            let operation = if reader.eat('+') {
                Binary::Add
            } else if reader.eat('-') {
                Binary::Sub
            } else {
                return Ok(left);
            };
            let right = self.product(reader)?;
            left = self.added(operation, left, right, origin)?;
        }
    }

    fn product(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let mut left = self.signed(reader)?;
        loop {
            let origin = reader.origin();
            if reader.eat('*') {
                let right = self.signed(reader)?;
                left = self.times(left, right, origin)?;
            } else if reader.eat('/') {
                let right = self.signed(reader)?;
                left = self.over(left, right, origin)?;
            } else if reader.look().0 == Token::Name("deg") {
                let degree = self.atom(reader)?;
                left = self.times(left, degree, origin)?;
            } else {
                return Ok(left);
            }
        }
    }

    fn signed(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let origin = reader.origin();
        if !reader.eat('-') {
            return self.power(reader);
        }
        self.deeper(origin)?;
        let item = self.signed(reader)?;
        self.depth -= 1;
        self.each(item, |builder, id| builder.unary(Unary::Negative, id, origin))
    }

    fn power(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let base = self.indexed(reader)?;
        let origin = reader.origin();
        if !reader.eat('^') {
            return Ok(base);
        }
        self.deeper(origin)?;
        let exponent = self.signed(reader)?;
        self.depth -= 1;
        match (base.shape, exponent.shape) {
            (Scalar, Scalar) => self.raised(base.nodes[0], exponent.nodes[0], origin).map(Item::scalar),
            (base, exponent) => self.refused(origin, format!("`^` takes numbers, not {base} and {exponent}")),
        }
    }

    /// x^y: products for integers, roots for halves, else exp(y log x).
    fn raised(&mut self, x: Id, y: Id, origin: Origin) -> Read<Id> {
        let builder = &mut self.builder;
        if let Some(n) = builder.value(y) {
            let halves = n * 2.0;
            if halves == halves.round() && n.abs() <= MOST_FACTORS {
                let whole = builder.power(x, n.abs().floor() as u32, origin)?;
                let mut value = whole;
                if n != n.trunc() {
                    let root = builder.unary(Unary::Sqrt, x, origin)?;
                    value = if n.abs() < 1.0 { root } else { builder.binary(Binary::Mul, whole, root, origin)? };
                }
                if n >= 0.0 {
                    return Ok(value);
                }
                let one = builder.integer(1, origin)?;
                return builder.binary(Binary::Div, one, value, origin);
            }
        }
        let log = builder.unary(Unary::Log, x, origin)?;
        let product = builder.binary(Binary::Mul, y, log, origin)?;
        builder.unary(Unary::Exp, product, origin)
    }

    fn indexed(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let mut item = self.atom(reader)?;
        loop {
            let origin = reader.origin();
            if !reader.eat('[') {
                return Ok(item);
            }
            let mut indices = vec![self.index(reader)?];
            while reader.eat(',') {
                indices.push(self.index(reader)?);
            }
            self.close(reader, ']', origin)?;
            item = match (item.shape, indices.as_slice()) {
                (Vector(n), [k]) => Item::scalar(item.nodes[self.place(n, *k)?]),
                (Matrix(rows, columns), [r, c]) => {
                    let (r, c) = (self.place(rows, *r)?, self.place(columns, *c)?);
                    Item::scalar(item.nodes[r * columns + c])
                }
                (shape, indices) => {
                    let indices =
                        if indices.len() == 1 { "one index".into() } else { format!("{} indices", indices.len()) };
                    return self.refused(origin, format!("{shape} has no entry with {indices}"));
                }
            };
        }
    }

    /// An index, which counts from 1, and where it is.
    fn index(&mut self, reader: &mut Reader<'_>) -> Read<(usize, Origin)> {
        let origin = reader.origin();
        let (token, length) = reader.look();
        match token {
            Token::Number(text) if text.parse::<usize>().is_ok_and(|k| k > 0) => {
                reader.at += length;
                Ok((text.parse().unwrap_or_default(), origin))
            }
            token => self.refused(origin, format!("{} is no index; expected an integer from 1", token.said())),
        }
    }

    /// An index of n, from 0.
    fn place(&self, n: usize, (k, origin): (usize, Origin)) -> Read<usize> {
        if k <= n { Ok(k - 1) } else { self.refused(origin, format!("the index {k} is too large; allowed: 1 to {n}")) }
    }

    fn close(&self, reader: &mut Reader<'_>, bracket: char, opened: Origin) -> Read<()> {
        if reader.eat(bracket) {
            return Ok(());
        }
        match reader.look().0 {
            Token::End => self.refused(opened, format!("this bracket is not closed; expected `{bracket}`")),
            token => {
                let origin = reader.origin();
                let said = token.said();
                self.refused(origin, format!("{said} does not belong here; expected an operation, `,` or `{bracket}`"))
            }
        }
    }

    fn list(&mut self, reader: &mut Reader<'_>, bracket: char, opened: Origin) -> Read<Vec<Item>> {
        let mut items = Vec::new();
        if reader.eat(bracket) {
            return Ok(items);
        }
        loop {
            items.push(self.sum(reader)?);
            if !reader.eat(',') {
                self.close(reader, bracket, opened)?;
                return Ok(items);
            }
        }
    }

    fn atom(&mut self, reader: &mut Reader<'_>) -> Read<Item> {
        let origin = reader.origin();
        let (token, length) = reader.look();
        reader.at += length;
        match token {
            Token::Number(text) => match Number::parse(text) {
                Ok(number) => self.builder.number(number, origin).map(Item::scalar),
                Err(error) => self.refused(origin, error.to_string()),
            },
            Token::Name("pi") => self.builder.pi(origin).map(Item::scalar),
            Token::Name("deg") => self.builder.number(Number::degree(), origin).map(Item::scalar),
            Token::Name(name) => match FUNCTIONS.iter().find(|function| function.name == name) {
                Some(function) => self.function(reader, function, origin),
                None => self.named(reader, name, origin),
            },
            Token::Sign('(') => {
                self.deeper(origin)?;
                let item = self.sum(reader)?;
                self.depth -= 1;
                self.close(reader, ')', origin)?;
                Ok(item)
            }
            Token::Sign('[') => {
                self.deeper(origin)?;
                let items = self.list(reader, ']', origin)?;
                self.depth -= 1;
                self.bracketed(items, origin)
            }
            Token::Sign(_) | Token::End => {
                let said = token.said();
                self.refused(origin, format!("{said} does not belong here; expected a number, a name, `(` or `[`"))
            }
        }
    }

    /// A vector of numbers, or a matrix of vectors.
    fn bracketed(&mut self, items: Vec<Item>, origin: Origin) -> Read<Item> {
        let has = |wanted: fn(Shape) -> bool| items.iter().any(|item| wanted(item.shape));
        let (numbers, rows) = (has(|shape| shape == Scalar), has(|shape| shape != Scalar));
        let shape = match items.first().map(|item| item.shape) {
            None | Some(Vector(0)) => return self.refused(origin, "a list needs at least one entry"),
            _ if has(|shape| matches!(shape, Matrix(..))) => {
                return self.refused(origin, "a list cannot hold matrices");
            }
            _ if numbers && rows => {
                return self.refused(origin, "a list holds numbers, or rows of equal length, not both");
            }
            Some(Vector(n)) if items.iter().all(|item| item.shape == Vector(n)) => Matrix(items.len(), n),
            Some(Vector(_)) => return self.refused(origin, "the rows of this matrix have different lengths"),
            Some(_) => Vector(items.len()),
        };
        Ok(Item { shape, nodes: items.into_iter().flat_map(|item| item.nodes).collect() })
    }

    /// A quantity, a parameter or a definition.
    fn named(&mut self, reader: &mut Reader<'_>, name: &str, origin: Origin) -> Read<Item> {
        if let Some(item) = self.read.get(name) {
            return Ok(item.clone());
        }
        let Some(meaning) = self.names.get(name) else {
            let function = reader.look().0 == Token::Sign('(');
            let what = if function { "function" } else { "name" };
            let hint = match self.names.like(name) {
                Some(known) => format!("did you mean `{known}`?"),
                None if function => {
                    let functions: Vec<&str> = FUNCTIONS.iter().map(|function| function.name).collect();
                    format!("known: {}", functions.join(", "))
                }
                None => format!("known: {}", self.names.list()),
            };
            return self.refused(origin, format!("unknown {what} `{name}`; {hint}"));
        };
        let builder = &mut self.builder;
        let (shape, nodes): (&Shape, Read<Vec<Id>>) = match meaning {
            Meaning::Places(shape, places) => (shape, places.iter().map(|k| builder.input(*k, origin)).collect()),
            Meaning::Numbers(shape, list) => (shape, list.iter().map(|x| builder.number(x.clone(), origin)).collect()),
            Meaning::Definition(text) => {
                if self.open.iter().any(|open| open == name) {
                    let chain: Vec<String> = self.open.iter().map(|name| format!("`{name}`")).collect();
                    return self
                        .refused(origin, format!("`{name}` is defined by itself, through {}", chain.join(", ")));
                }
                self.deeper(origin)?;
                self.open.push(name.into());
                let item = self.whole(text, Some(name))?;
                self.open.pop();
                self.depth -= 1;
                self.read.insert(name.into(), item.clone());
                return Ok(item);
            }
        };
        Ok(Item { shape: *shape, nodes: nodes? })
    }

    fn function(&mut self, reader: &mut Reader<'_>, function: &Function, origin: Origin) -> Read<Item> {
        let Function { name, arguments: count, .. } = *function;
        let opened = reader.origin();
        if !reader.eat('(') {
            let arguments = if count == 1 { "(…)" } else { "(…, …)" };
            return self.refused(origin, format!("`{name}` is a function; expected `{name}{arguments}`"));
        }
        self.deeper(origin)?;
        if matches!(name, "row" | "column") {
            let item = self.sum(reader)?;
            if !reader.eat(',') {
                return self.refused(reader.origin(), format!("`{name}` takes {}", function.takes));
            }
            let index = self.index(reader)?;
            self.close(reader, ')', opened)?;
            self.depth -= 1;
            return self.part(name, item, index, origin);
        }
        let items = self.list(reader, ')', opened)?;
        self.depth -= 1;
        if items.len() != count {
            let arguments = if count == 1 { "argument" } else { "arguments" };
            return self.refused(origin, format!("`{name}` takes {count} {arguments}, not {}", items.len()));
        }
        self.call(function, items, origin)
    }

    fn part(&mut self, name: &str, item: Item, index: (usize, Origin), origin: Origin) -> Read<Item> {
        let Matrix(rows, columns) = item.shape else {
            return self.refused(origin, format!("`{name}` takes a matrix, not {}", item.shape));
        };
        if name == "row" {
            let row = self.place(rows, index)?;
            return Ok(Item::vector(item.nodes[row * columns..(row + 1) * columns].to_vec()));
        }
        Ok(Item::vector(column(&item.nodes, columns, self.place(columns, index)?)))
    }

    fn call(&mut self, function: &Function, items: Vec<Item>, origin: Origin) -> Read<Item> {
        let Function { name, takes, unary, .. } = *function;
        let shapes: Vec<Shape> = items.iter().map(|item| item.shape).collect();
        let nodes: Vec<&[Id]> = items.iter().map(|item| item.nodes.as_slice()).collect();
        if let (Some(unary), [Scalar]) = (unary, shapes.as_slice()) {
            return self.builder.unary(unary, nodes[0][0], origin).map(Item::scalar);
        }
        // Of a vector with three components, each by the indices of the other two.
        let three = |entry: &mut dyn FnMut(usize, usize) -> Read<Id>| {
            (0..3).map(|a| entry((a + 1) % 3, (a + 2) % 3)).collect::<Read<_>>().map(Item::vector)
        };
        match (name, shapes.as_slice()) {
            ("atan2", [Scalar, Scalar]) => {
                self.builder.binary(Binary::Atan2, nodes[0][0], nodes[1][0], origin).map(Item::scalar)
            }
            ("norm", [Vector(_)]) => {
                let square = self.dot(nodes[0], nodes[0], origin)?;
                self.builder.unary(Unary::Sqrt, square, origin).map(Item::scalar)
            }
            ("dot", [Vector(m), Vector(n)]) if m == n => self.dot(nodes[0], nodes[1], origin).map(Item::scalar),
            ("cross", [Vector(3), Vector(3)]) => three(&mut |b, c| {
                let (u, v) = (nodes[0], nodes[1]);
                let plus = self.builder.binary(Binary::Mul, u[b], v[c], origin)?;
                let minus = self.builder.binary(Binary::Mul, u[c], v[b], origin)?;
                self.builder.binary(Binary::Sub, plus, minus, origin)
            }),
            ("transpose", [Matrix(r, c)]) => {
                let transposed = (0..*c).flat_map(|k| column(nodes[0], *c, k)).collect();
                Ok(Item { shape: Matrix(*c, *r), nodes: transposed })
            }
            ("trace", [Matrix(r, c)]) if r == c => {
                let mut diagonal = nodes[0].iter().step_by(r + 1);
                let first = diagonal.next().copied().unwrap_or_default();
                diagonal.try_fold(first, |sum, x| self.builder.binary(Binary::Add, sum, *x, origin)).map(Item::scalar)
            }
            // The vector of the antisymmetric part: ½ (m − mᵀ)^∨.
            ("vee", [Matrix(3, 3)]) => {
                let two = self.builder.integer(2, origin)?;
                three(&mut |b, c| {
                    let (above, below) = (nodes[0][3 * b + c], nodes[0][3 * c + b]);
                    let twice = self.builder.binary(Binary::Sub, below, above, origin)?;
                    self.builder.binary(Binary::Div, twice, two, origin)
                })
            }
            _ => {
                let shapes: Vec<String> = shapes.iter().map(Shape::to_string).collect();
                self.refused(origin, format!("`{name}` takes {takes}, not {}", shapes.join(" and ")))
            }
        }
    }

    fn dot(&mut self, u: &[Id], v: &[Id], origin: Origin) -> Read<Id> {
        let mut sum = None;
        for (x, y) in u.iter().zip(v) {
            let product = self.builder.binary(Binary::Mul, *x, *y, origin)?;
            sum = Some(match sum {
                None => product,
                Some(sum) => self.builder.binary(Binary::Add, sum, product, origin)?,
            });
        }
        sum.map_or_else(|| self.builder.integer(0, origin), Ok)
    }

    /// The same operation on every entry.
    fn each(&mut self, item: Item, mut on: impl FnMut(&mut Builder, Id) -> Read<Id>) -> Read<Item> {
        let nodes = item.nodes.into_iter().map(|id| on(&mut self.builder, id)).collect::<Read<_>>()?;
        Ok(Item { nodes, ..item })
    }

    fn added(&mut self, operation: Binary, left: Item, right: Item, origin: Origin) -> Read<Item> {
        if left.shape != right.shape {
            let what = if operation == Binary::Add { "added to" } else { "subtracted from" };
            return self.refused(origin, format!("{} cannot be {what} {}", right.shape, left.shape));
        }
        let mut others = right.nodes.into_iter();
        self.each(left, |builder, id| {
            let other = others.next().unwrap_or(id);
            builder.binary(operation, id, other, origin)
        })
    }

    fn times(&mut self, left: Item, right: Item, origin: Origin) -> Read<Item> {
        let (shape, columns) = match (left.shape, right.shape) {
            (Scalar, _) => {
                return self.each(right, |builder, id| builder.binary(Binary::Mul, left.nodes[0], id, origin));
            }
            (_, Scalar) => {
                return self.each(left, |builder, id| builder.binary(Binary::Mul, right.nodes[0], id, origin));
            }
            (Matrix(r, k), Vector(n)) if k == n => (Vector(r), 1),
            (Vector(n), Matrix(k, c)) if n == k => (Vector(c), c),
            (Matrix(r, k), Matrix(n, c)) if k == n => (Matrix(r, c), c),
            (left, right) => {
                let hint = match (left, right) {
                    (Vector(_), Vector(_)) => "; use `dot` or `cross`",
                    _ => "",
                };
                return self.refused(origin, format!("{left} cannot be multiplied by {right}{hint}"));
            }
        };
        let turned: Vec<Vec<Id>> = (0..columns).map(|k| column(&right.nodes, columns, k)).collect();
        let mut nodes = Vec::new();
        for row in left.nodes.chunks(turned[0].len()) {
            for column in &turned {
                nodes.push(self.dot(row, column, origin)?);
            }
        }
        Ok(Item { shape, nodes })
    }

    fn over(&mut self, left: Item, right: Item, origin: Origin) -> Read<Item> {
        if right.shape != Scalar {
            return self.refused(origin, format!("{} cannot be divided by {}", left.shape, right.shape));
        }
        self.each(left, |builder, id| builder.binary(Binary::Div, id, right.nodes[0], origin))
    }
}

/// Column k of a matrix that is given by rows.
fn column(nodes: &[Id], columns: usize, k: usize) -> Vec<Id> {
    nodes.iter().copied().skip(k).step_by(columns).collect()
}
