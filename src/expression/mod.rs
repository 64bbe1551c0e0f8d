//! Formulas in named quantities: from text to values in any scalar.
//!
//! A formula is parsed once, with a table of [`Names`], into an [`Expression`]: a graph without repeated parts, whose constants are
//! exact. [`Expression::compile`] puts its constants into a scalar. A [`Program`] is evaluated with values of the quantities in that
//! scalar or in duals over it, and differentiates itself in reverse mode. Nothing is allocated for that.
//!
//! | | |
//! |---|---|
//! | numbers | `2`, `0.5`, `1.2e-3`, `pi`, `deg` = π/180: exact, correct in every scalar |
//! | degrees | `30 deg`, `[10, 20, 30] deg`: the unit multiplies the product before it |
//! | operations | `+` `-` `*` `/`, `^` (it binds most and to the right: `-x^2` is `-(x^2)`) |
//! | functions | `sqrt` `exp` `log` `sin` `cos` `tan` `asin` `acos` `atan` `atan2(y, x)` `sinh` `cosh` `tanh` `abs` |
//! | vectors | `[a, b, c]`, `v[2]` and `v_2`, `dot(u, v)`, `cross(u, v)`, `norm(v)`, sums, products with scalars |
//! | matrices | `[[a, b], [c, d]]`, `m[1, 2]`, `row(m, 1)`, `column(m, 1)`, `transpose(m)`, `trace(m)`, products, `m*v` |
//!
//! Indices count from 1.

mod error;
mod graph;
mod names;
mod parse;
mod program;

pub use error::ExpressionError;
pub use names::Names;
#[doc(hidden)]
pub use names::{like, nearest};
pub use program::Program;

use crate::scalar::Real;
use graph::Graph;
use std::fmt;

/// The longest text, in bytes.
pub const LONGEST: usize = 10_000;
/// The deepest nesting of brackets, signs and definitions.
pub const DEEPEST: usize = 100;
/// The most quantities, constants and operations of one formula.
pub const LARGEST: usize = 4096;

/// What a formula gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A number.
    Scalar,
    /// A vector of this many components.
    Vector(usize),
    /// A matrix of this many rows and columns.
    Matrix(usize, usize),
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scalar => f.write_str("a number"),
            Self::Vector(n) => write!(f, "a vector of {n} components"),
            Self::Matrix(r, c) => write!(f, "a {r}×{c} matrix"),
        }
    }
}

/// A formula that has been read and checked.
///
/// ```
/// use euler_poincare::expression::{Expression, ExpressionError, Names, Program, Shape};
/// use euler_poincare::scalar::{Dd, Dual, Number, Scalar};
///
/// // The quantities have places in one list of numbers: here t, eta_1, eta_2, eta_3.
/// let mut names = Names::new();
/// names.scalar("t")?.vector("eta", 3)?;
/// names.parameter("k", Number::ratio(1, 10))?.definition("speed2", "dot(eta, eta)")?;
/// let drag = Expression::parse("-k*speed2*eta", &names)?;
/// assert_eq!((drag.shape(), drag.uses(0), drag.uses(1)), (Shape::Vector(3), false, true));
///
/// let program: Program<f64> = drag.compile()?;
/// let mut force = [0.0; 3];
/// program.eval(&[0.0, 1.0, 2.0, 0.0], &mut force);
/// assert_eq!(force, [-0.5, -1.0, 0.0]);
/// // The same in 32 digits, with derivatives.
/// let mut precise = [Dual::constant(Dd::int(0)); 3];
/// let one = Dual::variable(Dd::int(1));
/// drag.compile::<Dd>()?.eval(&[one, one, one, one], &mut precise);
///
/// // The gradient of a number, in reverse mode.
/// let energy: Program<f64> = Expression::parse("speed2/2", &names)?.compile()?;
/// let mut gradient = [0.0; 4];
/// energy.gradient(&[0.0, 1.0, 2.0, 0.0], &mut gradient);
/// assert_eq!(gradient, [0.0, 1.0, 2.0, 0.0]);
///
/// let refused: ExpressionError = Expression::parse("-k*etta", &names).unwrap_err();
/// assert_eq!(
///     refused.to_string(),
///     "column 4: unknown name `etta`; did you mean `eta`?\n    -k*etta\n       ^"
/// );
/// let root: Program<f64> = Expression::parse("sqrt(t - 1)", &names)?.compile()?;
/// let why: ExpressionError = root.undefined(&[0.0; 4]).expect("a reason");
/// assert_eq!(why.to_string(), "column 1: the square root of -1, which is negative\n    sqrt(t - 1)\n    ^");
/// # Ok::<(), ExpressionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    shape: Shape,
    graph: Graph,
}

impl PartialEq for Expression {
    /// Whether it is the same text, with the same meaning.
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text && self.graph == other.graph
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Expression {
    /// Reads a formula.
    ///
    /// # Errors
    /// An [`ExpressionError`] with the place: syntax, unknown names, wrong arguments or shapes, a constant that has no value, a formula
    /// that is too long, too deep or too large. No text panics.
    pub fn parse(text: &str, names: &Names) -> Result<Self, ExpressionError> {
        let (shape, graph) = parse::parse(text, names)?;
        Ok(Self { text: text.into(), shape, graph })
    }

    /// What it gives.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// How many numbers it gives: components of a vector; entries of a matrix, row by row.
    pub fn outputs(&self) -> usize {
        self.graph.outputs.len()
    }

    /// Whether the quantity with that place, from 0, occurs in it.
    pub fn uses(&self, place: usize) -> bool {
        self.graph.inputs.contains(&place)
    }

    /// The program with constants in `T`.
    ///
    /// # Errors
    /// A constant that is out of the range of `T`.
    pub fn compile<T: Real>(&self) -> Result<Program<T>, ExpressionError> {
        Program::new(&self.graph)
    }
}
