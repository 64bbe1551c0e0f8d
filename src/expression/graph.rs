//! Formulas as graphs of operations on numbers, without repeated parts.

use super::LARGEST;
use super::error::{ExpressionError, Spot};
use crate::scalar::Number;
use std::collections::HashMap;

/// A node, by its number.
pub(super) type Id = u16;

/// An operation on one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Negative,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Abs,
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Atan2,
}

/// A node of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// The k-th of the inputs.
    Input(Id),
    /// The k-th of the constants.
    Constant(Id),
    /// π.
    Pi,
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
}

/// Where a node comes from: which text, and the byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Origin {
    pub text: usize,
    pub at: usize,
}

/// The nodes, each after those that it uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Graph {
    pub nodes: Vec<Node>,
    pub origins: Vec<Origin>,
    /// The values of nodes that depend on no quantity.
    pub values: Vec<Option<f64>>,
    /// The places of the quantities that are used.
    pub inputs: Vec<usize>,
    pub constants: Vec<Number>,
    pub outputs: Vec<Id>,
    /// The texts that origins are in: the formula, and definitions with their names.
    pub texts: Vec<(Option<String>, String)>,
}

impl Graph {
    pub fn spot(&self, origin: Origin) -> Spot {
        let (definition, text) = self.texts[origin.text].clone();
        Spot { text, definition, at: origin.at }
    }

    pub fn is_smooth(&self) -> bool {
        let constant = |id: &Id| self.values[usize::from(*id)].is_some();
        let smooth = |node: &Node| match node {
            Node::Unary(Unary::Sqrt | Unary::Abs | Unary::Asin | Unary::Acos, a) => constant(a),
            Node::Binary(Binary::Atan2, a, b) => constant(a) && constant(b),
            _ => true,
        };
        self.nodes.iter().all(smooth)
    }
}

/// A graph that grows: it finds parts that are there already.
#[derive(Default)]
pub(super) struct Builder {
    pub graph: Graph,
    known: HashMap<Node, Id>,
}

impl Builder {
    /// The value of a node that depends on no quantity.
    pub fn value(&self, id: Id) -> Option<f64> {
        self.graph.values[usize::from(id)]
    }

    /// Whether a node is that integer, written as such: a value in `f64` says nothing of more digits.
    fn is_exactly(&self, id: Id, n: i64) -> bool {
        matches!(self.graph.nodes[usize::from(id)], Node::Constant(k) if self.graph.constants[usize::from(k)] == Number::from(n))
    }

    fn refused(&self, origin: Origin, message: String) -> ExpressionError {
        ExpressionError { spot: self.graph.spot(origin), message }
    }

    fn add(&mut self, node: Node, origin: Origin, value: Option<f64>) -> Result<Id, ExpressionError> {
        if let Some(id) = self.known.get(&node) {
            return Ok(*id);
        }
        if self.graph.nodes.len() >= LARGEST {
            let message = format!("the formula has more than {LARGEST} operations");
            return Err(self.refused(origin, message));
        }
        if value.is_some_and(|value| !value.is_finite()) {
            return Err(self.refused(origin, "this constant is too large".into()));
        }
        let id = self.graph.nodes.len() as Id;
        self.graph.nodes.push(node);
        self.graph.origins.push(origin);
        self.graph.values.push(value);
        self.known.insert(node, id);
        Ok(id)
    }

    pub fn input(&mut self, place: usize, origin: Origin) -> Result<Id, ExpressionError> {
        let inputs = &mut self.graph.inputs;
        let k = inputs.iter().position(|found| *found == place).unwrap_or_else(|| {
            inputs.push(place);
            inputs.len() - 1
        });
        self.add(Node::Input(k as Id), origin, None)
    }

    pub fn number(&mut self, number: Number, origin: Origin) -> Result<Id, ExpressionError> {
        let value = number.eval::<f64>().map_err(|error| self.refused(origin, error.to_string()))?;
        let constants = &mut self.graph.constants;
        let k = constants.iter().position(|found| *found == number).unwrap_or_else(|| {
            constants.push(number);
            constants.len() - 1
        });
        self.add(Node::Constant(k as Id), origin, Some(value))
    }

    pub fn integer(&mut self, n: i64, origin: Origin) -> Result<Id, ExpressionError> {
        self.number(Number::from(n), origin)
    }

    pub fn pi(&mut self, origin: Origin) -> Result<Id, ExpressionError> {
        self.add(Node::Pi, origin, Some(std::f64::consts::PI))
    }

    pub fn unary(&mut self, operation: Unary, a: Id, origin: Origin) -> Result<Id, ExpressionError> {
        let value = self.value(a).map(|x| unary(operation, x));
        if let (Some(x), Some(value)) = (self.value(a), value)
            && let Some(why) = undefined_unary(operation, x, value)
        {
            return Err(self.refused(origin, why));
        }
        self.add(Node::Unary(operation, a), origin, value)
    }

    pub fn binary(&mut self, operation: Binary, a: Id, b: Id, origin: Origin) -> Result<Id, ExpressionError> {
        let (x, y) = (self.value(a), self.value(b));
        if operation == Binary::Div && y == Some(0.0) {
            return Err(self.refused(origin, "division by a constant that is zero".into()));
        }
        // What is exact for every number: x + 0, 0 + x, x − 0, 1 x, x 1, x/1.
        match operation {
            Binary::Add if self.is_exactly(a, 0) => return Ok(b),
            Binary::Mul if self.is_exactly(a, 1) => return Ok(b),
            Binary::Add | Binary::Sub if self.is_exactly(b, 0) => return Ok(a),
            Binary::Mul | Binary::Div if self.is_exactly(b, 1) => return Ok(a),
            _ => {}
        }
        let value = x.zip(y).map(|(x, y)| binary(operation, x, y));
        // Equal sums and products are one, whatever the order.
        let (a, b) = if matches!(operation, Binary::Add | Binary::Mul) && a > b { (b, a) } else { (a, b) };
        self.add(Node::Binary(operation, a, b), origin, value)
    }

    /// a^n by repeated squares; 1 for n = 0.
    pub fn power(&mut self, a: Id, n: u32, origin: Origin) -> Result<Id, ExpressionError> {
        let (mut square, mut rest, mut product) = (a, n, None);
        while rest > 0 {
            if rest & 1 == 1 {
                product = Some(match product {
                    None => square,
                    Some(product) => self.binary(Binary::Mul, product, square, origin)?,
                });
            }
            rest >>= 1;
            if rest > 0 {
                square = self.binary(Binary::Mul, square, square, origin)?;
            }
        }
        product.map_or_else(|| self.integer(1, origin), Ok)
    }
}

/// The value in any scalar.
pub(super) fn unary<S: crate::scalar::Scalar>(operation: Unary, x: S) -> S {
    match operation {
        Unary::Negative => -x,
        Unary::Sqrt => x.sqrt(),
        Unary::Exp => x.exp(),
        Unary::Log => x.ln(),
        Unary::Sin => x.sin(),
        Unary::Cos => x.cos(),
        Unary::Tan => x.tan(),
        Unary::Asin => x.asin(),
        Unary::Acos => x.acos(),
        Unary::Atan => x.atan(),
        Unary::Sinh => x.sinh(),
        Unary::Cosh => x.cosh(),
        Unary::Tanh => x.tanh(),
        Unary::Abs => x.abs(),
    }
}

/// The value in any scalar.
pub(super) fn binary<S: crate::scalar::Scalar>(operation: Binary, x: S, y: S) -> S {
    match operation {
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div => x / y,
        Binary::Atan2 => x.atan2(y),
    }
}

/// A number as it is written by hand, unless that would be long.
fn plain(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// Why the value of an operation at x is none.
pub(super) fn undefined_unary(operation: Unary, x: f64, value: f64) -> Option<String> {
    match operation {
        Unary::Sqrt if x < 0.0 => Some(format!("the square root of {}, which is negative", plain(x))),
        Unary::Log if x <= 0.0 => Some(format!("the logarithm of {}, which is not positive", plain(x))),
        Unary::Asin | Unary::Acos if x.abs() > 1.0 => {
            Some(format!("an angle whose sine or cosine is {}, beyond 1", plain(x)))
        }
        _ if !value.is_finite() => Some("the value is too large".into()),
        _ => None,
    }
}
