//! Formulas with constants in one scalar, evaluated and differentiated without allocation.

use super::error::ExpressionError;
use super::graph::{Binary, Graph, Id, Node, Unary, binary, unary, undefined_unary};
use crate::scalar::{NumberError, Real, Scalar};
use std::sync::Arc;

/// A formula with constants in `T`.
///
/// Each node of the graph that is used has a register: they are numbered without gaps, in the order of the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Program<T> {
    /// Registers of the quantities, with their places.
    inputs: Vec<(Id, usize)>,
    constants: Vec<(Id, T)>,
    /// The operations, each after those whose results it takes.
    operations: Vec<(Id, Node)>,
    /// Registers of the results.
    outputs: Vec<Id>,
    /// The node of each register.
    nodes: Vec<Id>,
    graph: Arc<Graph>,
}

/// Registers on the stack for small formulas, for most, and for the largest.
const SIZES: [usize; 3] = [32, 256, super::LARGEST];

impl<T: Real> Program<T> {
    pub(super) fn new(graph: &Graph) -> Result<Self, ExpressionError> {
        let mut values: Vec<Option<T>> = Vec::with_capacity(graph.nodes.len());
        for (node, origin) in graph.nodes.iter().zip(&graph.origins) {
            let of = |id: Id| values[usize::from(id)];
            values.push(match *node {
                Node::Input(_) => None,
                Node::Pi => Some(T::pi()),
                Node::Constant(k) => {
                    let refused =
                        |error: NumberError| ExpressionError { spot: graph.spot(*origin), message: error.to_string() };
                    Some(graph.constants[usize::from(k)].eval::<T>().map_err(refused)?)
                }
                Node::Unary(operation, a) => of(a).map(|x| unary(operation, x)),
                Node::Binary(operation, a, b) => of(a).zip(of(b)).map(|(x, y)| binary(operation, x, y)),
            });
        }
        // What is used: from the outputs backwards, not further than constants.
        let mut used = vec![false; graph.nodes.len()];
        graph.outputs.iter().for_each(|id| used[usize::from(*id)] = true);
        for k in (0..graph.nodes.len()).rev() {
            if used[k] && values[k].is_none() {
                match graph.nodes[k] {
                    Node::Unary(_, a) => used[usize::from(a)] = true,
                    Node::Binary(_, a, b) => (used[usize::from(a)], used[usize::from(b)]) = (true, true),
                    Node::Input(_) | Node::Constant(_) | Node::Pi => {}
                }
            }
        }
        let mut program = Self {
            inputs: Vec::new(),
            constants: Vec::new(),
            operations: Vec::new(),
            outputs: Vec::new(),
            nodes: Vec::new(),
            graph: Arc::new(graph.clone()),
        };
        let mut registers: Vec<Id> = vec![0; graph.nodes.len()];
        for (k, value) in values.into_iter().enumerate().filter(|(k, _)| used[*k]) {
            let id = program.nodes.len() as Id;
            let register = |id: Id| registers[usize::from(id)];
            match (graph.nodes[k], value) {
                (_, Some(value)) => program.constants.push((id, value)),
                (Node::Input(input), None) => program.inputs.push((id, graph.inputs[usize::from(input)])),
                (Node::Unary(operation, a), None) => {
                    program.operations.push((id, Node::Unary(operation, register(a))));
                }
                (Node::Binary(operation, a, b), None) => {
                    program.operations.push((id, Node::Binary(operation, register(a), register(b))));
                }
                (Node::Constant(_) | Node::Pi, None) => {}
            }
            registers[k] = id;
            program.nodes.push(k as Id);
        }
        program.outputs = graph.outputs.iter().map(|id| registers[usize::from(*id)]).collect();
        Ok(program)
    }

    /// Whether the quantity with that place, from 0, occurs in it.
    pub fn uses(&self, place: usize) -> bool {
        self.graph.inputs.contains(&place)
    }

    /// Whether it has all derivatives wherever it is defined: no `abs`, no `atan2`, no root or norm, which have none at 0, and no `asin` or
    /// `acos`, which have none at 1.
    pub fn is_smooth(&self) -> bool {
        self.graph.is_smooth()
    }

    /// Fills the registers; `inputs` gives the quantity with a place.
    fn run<S: Scalar<Base = T>>(&self, inputs: &[S], registers: &mut [S]) {
        for &(id, place) in &self.inputs {
            registers[usize::from(id)] = inputs.get(place).copied().unwrap_or_else(|| S::exact(f64::NAN));
        }
        for &(id, constant) in &self.constants {
            registers[usize::from(id)] = S::lift(constant);
        }
        for &(id, operation) in &self.operations {
            let of = |id: Id| registers[usize::from(id)];
            registers[usize::from(id)] = match operation {
                Node::Unary(operation, a) => unary(operation, of(a)),
                Node::Binary(operation, a, b) => binary(operation, of(a), of(b)),
                Node::Input(_) | Node::Constant(_) | Node::Pi => continue,
            };
        }
    }

    // Apart from callers, whose frames would hold the registers.
    #[inline(never)]
    fn eval_in<S: Scalar<Base = T>, const SIZE: usize>(&self, inputs: &[S], out: &mut [S]) {
        let mut registers = [S::zero(); SIZE];
        self.run(inputs, &mut registers);
        out.iter_mut().zip(&self.outputs).for_each(|(out, register)| *out = registers[usize::from(*register)]);
    }

    /// The values at these quantities, in the order of their places; those that are not used are not looked at, and those that are
    /// missing count as NaN.
    pub fn eval<S: Scalar<Base = T>>(&self, inputs: &[S], out: &mut [S]) {
        match self.nodes.len() {
            n if n <= SIZES[0] => self.eval_in::<S, { SIZES[0] }>(inputs, out),
            n if n <= SIZES[1] => self.eval_in::<S, { SIZES[1] }>(inputs, out),
            _ => self.eval_in::<S, { SIZES[2] }>(inputs, out),
        }
    }

    /// Sets `out` to the derivatives of the first number with respect to every quantity, by its place; 0 for those that are not used.
    pub fn gradient<S: Scalar<Base = T>>(&self, inputs: &[S], out: &mut [S]) {
        match self.nodes.len() {
            n if n <= SIZES[0] => self.gradient_in::<S, { SIZES[0] }>(inputs, out),
            n if n <= SIZES[1] => self.gradient_in::<S, { SIZES[1] }>(inputs, out),
            _ => self.gradient_in::<S, { SIZES[2] }>(inputs, out),
        }
    }

    // Apart from callers, whose frames would hold the registers.
    #[inline(never)]
    fn gradient_in<S: Scalar<Base = T>, const SIZE: usize>(&self, inputs: &[S], out: &mut [S]) {
        let (mut registers, mut slopes) = ([S::zero(); SIZE], [S::zero(); SIZE]);
        self.run(inputs, &mut registers);
        self.backwards(&registers, &mut slopes, out);
    }

    /// Sets `out` to the derivatives, by those with respect to each register, which are 0 before.
    fn backwards<S: Scalar<Base = T>>(&self, registers: &[S], slopes: &mut [S], out: &mut [S]) {
        out.fill(S::zero());
        let Some(output) = self.outputs.first() else { return };
        slopes[usize::from(*output)] = S::one();
        for &(id, operation) in self.operations.iter().rev() {
            let (slope, value) = (slopes[usize::from(id)], registers[usize::from(id)]);
            if slope.vanishes() {
                continue;
            }
            match operation {
                Node::Unary(operation, a) => {
                    let x = registers[usize::from(a)];
                    slopes[usize::from(a)] += slope * derivative(operation, x, value);
                }
                Node::Binary(operation, a, b) => {
                    let (a, b) = (usize::from(a), usize::from(b));
                    let (x, y) = (registers[a], registers[b]);
                    let (by_x, by_y) = match operation {
                        Binary::Add => (slope, slope),
                        Binary::Sub => (slope, -slope),
                        Binary::Mul => (slope * y, slope * x),
                        Binary::Div => (slope / y, -slope * value / y),
                        Binary::Atan2 => {
                            let square = x * x + y * y;
                            (slope * y / square, -slope * x / square)
                        }
                    };
                    slopes[a] += by_x;
                    slopes[b] += by_y;
                }
                Node::Input(_) | Node::Constant(_) | Node::Pi => {}
            }
        }
        for &(id, place) in &self.inputs {
            if let Some(out) = out.get_mut(place) {
                *out = slopes[usize::from(id)];
            }
        }
    }

    /// The first operation without a finite value at these quantities; `None` if all have one.
    pub fn undefined(&self, inputs: &[T]) -> Option<ExpressionError> {
        let mut registers = vec![T::zero(); self.nodes.len()];
        self.run(inputs, &mut registers);
        let of = |id: Id| registers[usize::from(id)].to_f64();
        let &(id, operation) = self.operations.iter().find(|(id, _)| !registers[usize::from(*id)].all_finite())?;
        let large = || "the value is too large".to_owned();
        let why = match operation {
            Node::Unary(operation, a) => undefined_unary(operation, of(a), of(id)).unwrap_or_else(large),
            Node::Binary(Binary::Div, _, b) if of(b) == 0.0 => "division by zero".into(),
            _ => large(),
        };
        let origin = self.graph.origins[usize::from(self.nodes[usize::from(id)])];
        Some(ExpressionError { spot: self.graph.spot(origin), message: why })
    }
}

/// The derivative of an operation at x, where its value is known.
fn derivative<S: Scalar>(operation: Unary, x: S, value: S) -> S {
    match operation {
        Unary::Negative => -S::one(),
        Unary::Sqrt => S::half() / value,
        Unary::Exp => value,
        Unary::Log => S::one() / x,
        Unary::Sin => x.cos(),
        Unary::Cos => -x.sin(),
        Unary::Tan => S::one() + value * value,
        // As a product: 1 − x² loses digits near ±1.
        Unary::Asin => S::one() / ((S::one() - x) * (S::one() + x)).sqrt(),
        Unary::Acos => -S::one() / ((S::one() - x) * (S::one() + x)).sqrt(),
        Unary::Atan => S::one() / (S::one() + x * x),
        Unary::Sinh => x.cosh(),
        Unary::Cosh => x.sinh(),
        // Not 1 − tanh²x, of which nothing is left at large x.
        Unary::Tanh => {
            let sech = S::one() / x.cosh();
            sech * sech
        }
        Unary::Abs if x < S::zero() => -S::one(),
        Unary::Abs => S::one(),
    }
}
