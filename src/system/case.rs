//! The case as a plain value: what the file holds, what the generators make, what a failure prints.
//!
//! All numbers are [`Number`] expressions, so a case means exactly the same system in every scalar. Every coordinate
//! (constants, inertia, forces, state) refers to the basis of the case: the catalogue's, or the changed one.

use super::error::{CaseError, Place};
use super::force::{Domain, Mut, Role};
use super::numbers::{list, rows};
use crate::algebra::catalogue::Entry;
use crate::algebra::families::named;
use crate::algebra::rational::RationalAlgebra;
use crate::algebra::{AlgebraFamily, AlgebraInvariants, MatrixAlgebra, known};
use crate::scalar::Number;
use crate::tableau::Description;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

pub use super::force::{Drag, Force, Monomial};
pub use super::potential::Potential;
pub use crate::retraction::named::Tau;

/// The largest algebra dimension that is compiled in.
pub const MAX_DIMENSION: usize = 10;

/// The dimensions that every law is compiled for; [`Visitor::LARGE`](super::Visitor::LARGE) says which know larger ones.
pub const MAIN_DIMENSIONS: std::ops::RangeInclusive<usize> = 1..=6;

/// C^c_ab = value, indices from 1; C^c_ba = −value follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// First lower index, from 1.
    pub a: usize,
    /// Second lower index, from 1.
    pub b: usize,
    /// Upper index, from 1.
    pub c: usize,
    /// C^c_ab.
    pub value: Number,
}

/// Where the algebra's structure comes from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Structure {
    /// An algebra of the catalogue, with its group.
    Named(Entry),
    /// The span of rational matrices, with the group that they generate.
    Matrices {
        /// The family that it was drawn from, if it was.
        family: Option<AlgebraFamily>,
        /// The algebra.
        algebra: MatrixAlgebra,
    },
    /// Structure constants alone. The group is that of the adjoint representation where the constants are rational and the centre is
    /// trivial; else there is none, so the momentum step with exp only.
    Constants {
        /// n.
        dimension: usize,
        /// The non-zero constants, one of each antisymmetric pair.
        constants: Vec<Constant>,
    },
    /// An algebra and a group of a user's own types ([`crate::laws::user`]), which the case does not describe.
    Given {
        /// n.
        dimension: usize,
        /// Whether all brackets vanish.
        abelian: bool,
    },
}

/// The algebra g, in its basis.
#[derive(Clone, Debug, PartialEq)]
pub struct Algebra {
    /// Which algebra.
    pub structure: Structure,
    /// The new basis vectors e'_a = e_b B^b_a, one list of n coordinates each (the columns of B); `None`: unchanged.
    pub basis: Option<Vec<Vec<Number>>>,
}

impl Structure {
    /// The number of rows of the matrices of its group, without padding; 0 without a group that the case describes.
    pub fn matrix_size(&self) -> usize {
        match self {
            Self::Named(entry) => entry.matrix_size(),
            Self::Matrices { algebra, .. } => algebra.matrix_size(),
            Self::Constants { .. } => self.adjoint().map_or(0, |algebra| algebra.matrix_size()),
            Self::Given { .. } => 0,
        }
    }

    /// How many Casimirs are known.
    pub fn casimir_count(&self) -> usize {
        match self {
            Self::Named(entry) => entry.casimir_count(),
            Self::Matrices { algebra, .. } => algebra.casimir_count(),
            Self::Constants { .. } => self.rational().map_or(0, |algebra| algebra.casimir_count()),
            Self::Given { .. } => 0,
        }
    }

    /// What it is, where constants are rational.
    pub fn invariants(&self) -> Option<AlgebraInvariants> {
        Some(AlgebraInvariants::of(&self.rational()?))
    }

    /// Whether the retraction is defined for its group, or for the algebra.
    pub(super) fn admits(&self, tau: Tau) -> bool {
        match self {
            _ if !tau.known().of_matrices => true,
            Self::Named(_) => true,
            Self::Matrices { algebra, .. } => algebra.admits_cayley(),
            Self::Constants { .. } => self.adjoint().is_some_and(|algebra| algebra.admits_cayley()),
            Self::Given { .. } => false,
        }
    }

    /// Its structure constants, where they are rational and obey Jacobi exactly.
    pub(super) fn rational(&self) -> Option<RationalAlgebra> {
        let of = |k: &Constant| Some(([k.a, k.b, k.c].map(|index| index.wrapping_sub(1)), k.value.rational()?));
        match self {
            Self::Named(entry) => RationalAlgebra::of_matrices(&named(entry)).ok(),
            Self::Matrices { algebra, .. } => Some(algebra.algebra().clone()),
            Self::Constants { dimension, constants } => {
                RationalAlgebra::of_constants(*dimension, constants.iter().map(of).collect::<Option<Vec<_>>>()?)
            }
            Self::Given { .. } => None,
        }
    }

    /// The algebra of structure constants by its adjoint representation, where its centre is trivial.
    pub(super) fn adjoint(&self) -> Option<MatrixAlgebra> {
        self.rational()?.of_adjoint()
    }
}

impl Algebra {
    /// n = dim g.
    pub fn dimension(&self) -> usize {
        match &self.structure {
            Structure::Named(entry) => entry.dimension(),
            Structure::Matrices { algebra, .. } => algebra.dimension(),
            Structure::Constants { dimension, .. } | Structure::Given { dimension, .. } => *dimension,
        }
    }
}

/// The inertia I of l(η) = ½⟨Iη, η⟩ + …, or the metric K of a quartic term: symmetric, n×n.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Inertia {
    /// Its diagonal.
    Diagonal(Vec<Number>),
    /// Its rows.
    Full(Vec<Vec<Number>>),
}

impl Inertia {
    /// The number of rows.
    pub(crate) fn dimension(&self) -> usize {
        match self {
            Self::Diagonal(list) => list.len(),
            Self::Full(rows) => rows.len(),
        }
    }

    /// An entry; 0 where there is none.
    pub(crate) fn entry(&self, r: usize, c: usize) -> Number {
        let found = match self {
            Self::Diagonal(list) => list.get(r).filter(|_| r == c),
            Self::Full(rows) => rows.get(r).and_then(|row| row.get(c)),
        };
        found.cloned().unwrap_or_default()
    }
}

/// The value of a parameter of formulas and numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Parameter {
    /// A number.
    Number(Number),
    /// A constant vector.
    Vector(Vec<Number>),
}

/// What formulas of a case may name, beside its quantities t, eta, mu and g.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dictionary {
    /// Parameters.
    pub parameters: BTreeMap<String, Parameter>,
    /// Formulas with names.
    pub definitions: BTreeMap<String, String>,
}

impl Dictionary {
    /// The number of a text such as `0.01*spin`, which may name the parameters.
    ///
    /// # Errors
    /// A name that is no parameter, and what is no number.
    pub fn number(&self, text: &str) -> Result<Number, String> {
        super::parameters::number(text, &self.parameters).map_err(|refused| refused.message)
    }
}

/// The orientation of a body, of so(3) or se(3), or the matrix of any group.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Orientation {
    /// The axis times the angle.
    RotationVector(Vec<Number>),
    /// (w, x, y, z), of any length.
    Quaternion(Vec<Number>),
    /// By rows; rounded entries of a rotation are corrected.
    Matrix(Vec<Vec<Number>>),
    /// Rotations about axes of the body, one after the other.
    Euler {
        /// The angles.
        angles: Vec<Number>,
        /// The axes, such as `zyx` (yaw, pitch, roll) or `zxz`.
        axes: String,
    },
}

/// The reduced Lagrangian l(η) = ½⟨Iη, η⟩ + ⟨b, η⟩ + ¼ κ ⟨Kη, η⟩², or a formula.
#[derive(Clone, PartialEq)]
pub struct Lagrangian {
    /// I.
    pub inertia: Inertia,
    /// Whether I may have negative directions; where it may not, they are an error.
    pub indefinite: bool,
    /// b, where there is a gyrostat term.
    pub gyrostat: Option<Vec<Number>>,
    /// κ, where there is a quartic term.
    pub quartic: Option<Number>,
    /// K, where it is not I.
    pub metric: Option<Inertia>,
    /// The text of a formula in t, η and g: then it is the whole Lagrangian.
    pub formula: Option<String>,
}

impl Lagrangian {
    /// l(η) = ½⟨Iη, η⟩, I positive definite.
    pub fn new(inertia: Inertia) -> Self {
        Self { inertia, indefinite: false, gyrostat: None, quartic: None, metric: None, formula: None }
    }

    /// l(η) = ½|η|².
    pub(super) fn unit(n: usize) -> Self {
        Self::new(Inertia::Diagonal(vec![Number::from(1); n]))
    }

    /// n, of the algebras that it is for.
    pub fn dimension(&self) -> usize {
        self.inertia.dimension()
    }

    /// Whether l(η) = ½⟨Iη, η⟩.
    pub(crate) fn is_quadratic(&self) -> bool {
        self.quartic.is_none() && self.gyrostat.is_none() && self.formula.is_none()
    }

    /// Whether l(η) = ½ q + ¼ κ q² with q = ⟨Iη, η⟩ ≥ 0: a function of a kinetic energy.
    pub(crate) fn is_kinetic(&self) -> bool {
        !self.indefinite && self.gyrostat.is_none() && self.metric.is_none() && self.formula.is_none()
    }
}

/// The integrator: a tableau and a retraction. In JSON, the keys of `[method]` in a system file.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// (a, b).
    pub tableau: Description,
    /// τ, or τ₀ of τ = τ₀∘φ.
    pub retraction: Tau,
    /// The terms of φ(x) − x, an odd polynomial with values in g; their powers of cos t and sin t are 0. None: φ(x) = x.
    pub argument: Vec<Monomial>,
}

impl Method {
    /// φ(x) in `f64`, and a bound of ‖φ'(s x) − 1‖ for 0 ≤ s ≤ 1: below 1 there is no fold of φ on the way to x. `None` where a number has no
    /// value or an index is out of range.
    pub(crate) fn argument(&self, x: &[f64]) -> Option<(Vec<f64>, f64)> {
        let (mut value, mut rows) = (x.to_vec(), vec![0.0; x.len()]);
        for term in &self.argument {
            let (a, coefficient) = (term.component.checked_sub(1)?, term.value.eval::<f64>().ok()?);
            let factors = term.factors.iter().map(|i| x.get(i.checked_sub(1)?).copied());
            let factors = factors.collect::<Option<Vec<f64>>>()?;
            let others = |k: usize| factors.iter().enumerate().filter(move |(l, _)| *l != k).map(|(_, v)| v.abs());
            let sum: f64 = (0..factors.len()).map(|k| others(k).product::<f64>()).sum();
            *value.get_mut(a)? += coefficient * factors.iter().product::<f64>();
            *rows.get_mut(a)? += coefficient.abs() * sum;
        }
        Some((value, rows.into_iter().fold(0.0, f64::max)))
    }
}

/// The initial motion: η or μ.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// η; then μ = l'(η).
    Velocity(Vec<Number>),
    /// μ.
    Momentum(Vec<Number>),
}

/// The initial state.
#[derive(Clone, PartialEq)]
pub struct Start {
    /// η or μ.
    pub motion: Motion,
    /// x with g = τ(x), in the case's basis and with its retraction; `None`: g = e, or `orientation` and `position`.
    pub attitude: Option<Vec<Number>>,
    /// The orientation, whatever the retraction.
    pub orientation: Option<Orientation>,
    /// The position, on se(3).
    pub position: Option<Vec<Number>>,
    /// t.
    pub time: Number,
}

impl Start {
    /// At g = e and t = 0.
    pub fn moving(motion: Motion) -> Self {
        Self { motion, attitude: None, orientation: None, position: None, time: Number::default() }
    }
}

/// One plain value that describes a forced Euler–Poincaré system, a method, an initial state and a step.
#[derive(Clone, PartialEq)]
pub struct Case {
    /// g.
    pub algebra: Algebra,
    /// l.
    pub lagrangian: Lagrangian,
    /// V, the sum of these: L = l − V.
    pub potentials: Vec<Potential>,
    /// f, the sum of these.
    pub forces: Vec<Force>,
    /// What formulas may name.
    pub names: Dictionary,
    /// Tableau and τ.
    pub method: Method,
    /// Where it starts.
    pub start: Start,
    /// h.
    pub step: Number,
}

impl Case {
    /// All that is in coordinates of the algebra but its basis and formulas, and all parameters of forces; to be changed.
    pub(crate) fn parts_mut(&mut self) -> Vec<(Role, Mut<'_>)> {
        let (lagrangian, start) = (&mut self.lagrangian, &mut self.start);
        let mut found: Vec<(Role, Mut<'_>)> = vec![match &mut start.motion {
            Motion::Velocity(eta) => (Role::Vector, eta.into()),
            Motion::Momentum(mu) => (Role::Amplitude, mu.into()),
        }];
        found.extend(start.attitude.iter_mut().map(|x| (Role::Vector, x.into())));
        let forms = [&mut lagrangian.inertia].into_iter().chain(&mut lagrangian.metric);
        found.extend(forms.map(|form| (Role::Form, form.into())));
        found.extend(lagrangian.gyrostat.iter_mut().map(|b| (Role::Amplitude, b.into())));
        found.push((Role::OddPolynomial, (&mut self.method.argument).into()));
        let parameters = self.forces.iter_mut().flat_map(Force::parameters_mut);
        found.extend(parameters.map(|(parameter, value)| (parameter.role, value)));
        found
    }

    /// n = dim g.
    pub fn dimension(&self) -> usize {
        self.algebra.dimension()
    }

    /// Whether the force, the potential or the Lagrangian is a formula, or depends on the configuration: what laws of systems f(t, η), l(η)
    /// do not speak of.
    pub fn is_general(&self) -> bool {
        !self.potentials.is_empty() || self.lagrangian.formula.is_some() || self.forces.iter().any(Force::is_general)
    }

    /// Whether a formula, a force or a potential refers to the basis of the algebra by the names of coordinates: then the system has no
    /// [presentation](Case::presented) in another one.
    pub fn names_basis(&self) -> bool {
        self.lagrangian.formula.is_some()
            || self.forces.iter().any(Force::is_general)
            || self.potentials.iter().any(|potential| potential.description().domain == Domain::StandardBody)
    }

    /// s N, the number of unknowns of a step.
    ///
    /// # Errors
    /// A tableau that cannot be built.
    pub fn unknowns(&self) -> Result<usize, CaseError> {
        let tableau = self.method.tableau.build::<f64>();
        let tableau = tableau.map_err(|e| Place::root().key("method").key("tableau").error(e))?;
        Ok(tableau.stages() * self.dimension())
    }
}

/// The text of `Debug` decides the numbers that laws draw beyond a case: what most cases do not have is left out where it is not there, so that
/// records meet the same numbers as before it was known.
macro_rules! debug {
    ($name:ident: $($always:ident),*; $($rare:ident is $none:expr),*) => {
        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let mut text = f.debug_struct(stringify!($name));
                $(text.field(stringify!($always), &self.$always);)*
                $(if self.$rare != $none {
                    text.field(stringify!($rare), &self.$rare);
                })*
                text.finish()
            }
        }
    };
}

debug!(Lagrangian: inertia, indefinite, gyrostat, quartic, metric; formula is None);
debug!(Start: motion, attitude, time; orientation is None, position is None);
debug!(Case: algebra, lagrangian, forces, method, start, step; potentials is Vec::new(), names is Dictionary::default());

impl fmt::Display for Algebra {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.structure {
            Structure::Named(entry) => write!(f, "{entry}")?,
            Structure::Matrices { family: None, algebra } if known::name_of(algebra).is_some() => {
                f.write_str(known::name_of(algebra).unwrap_or_default())?;
            }
            Structure::Matrices { family, algebra } => {
                let matrices: Vec<String> = algebra.matrices().iter().map(|matrix| rows(matrix)).collect();
                let family = family.map(|family| format!(" ({family})")).unwrap_or_default();
                write!(f, "of matrices{family} {}", matrices.join(", "))?;
            }
            Structure::Given { dimension, .. } => write!(f, "given, of dimension {dimension}")?,
            Structure::Constants { dimension, constants } => {
                write!(f, "dimension {dimension} with")?;
                if constants.is_empty() {
                    f.write_str(" no brackets")?;
                }
                for (i, k) in constants.iter().enumerate() {
                    let comma = if i == 0 { "" } else { "," };
                    write!(f, "{comma} C^{}_{}{} = {}", k.c, k.a, k.b, k.value)?;
                }
            }
        }
        match &self.basis {
            Some(basis) => write!(f, ", in the basis {}", rows(basis)),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Inertia {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diagonal(diagonal) => write!(f, "diag{}", list(diagonal)),
            Self::Full(matrix) => f.write_str(&rows(matrix)),
        }
    }
}

impl fmt::Display for Lagrangian {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(formula) = &self.formula {
            return write!(f, "L = {formula}");
        }
        write!(f, "{}inertia {}", if self.indefinite { "indefinite " } else { "" }, self.inertia)?;
        if let Some(rotor) = &self.gyrostat {
            write!(f, ", gyrostat {}", list(rotor))?;
        }
        if let Some(kappa) = &self.quartic {
            write!(f, ", quartic {kappa}")?;
        }
        match &self.metric {
            Some(metric) => write!(f, " in the metric {metric}"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "algebra    {}", self.algebra)?;
        writeln!(f, "lagrangian {}", self.lagrangian)?;
        if !self.potentials.is_empty() {
            let potentials: Vec<String> = self.potentials.iter().map(ToString::to_string).collect();
            writeln!(f, "potential  {}", potentials.join(" + "))?;
        }
        let forces: Vec<String> = self.forces.iter().map(ToString::to_string).collect();
        writeln!(f, "force      {}", if forces.is_empty() { "none".into() } else { forces.join(" + ") })?;
        for (name, value) in &self.names.parameters {
            match value {
                Parameter::Number(value) => writeln!(f, "parameter  {name} = {value}")?,
                Parameter::Vector(values) => writeln!(f, "parameter  {name} = {}", list(values))?,
            }
        }
        for (name, text) in &self.names.definitions {
            writeln!(f, "definition {name} = {text}")?;
        }
        write!(f, "method     {}, {}", self.method.tableau, self.method.retraction.name())?;
        if !self.method.argument.is_empty() {
            let terms: Vec<String> = self.method.argument.iter().map(Monomial::odd).collect();
            write!(f, " of x + [{}]", terms.join(", "))?;
        }
        writeln!(f)?;
        match &self.start.motion {
            Motion::Velocity(eta) => write!(f, "start      velocity {}", list(eta))?,
            Motion::Momentum(mu) => write!(f, "start      momentum {}", list(mu))?,
        }
        if let Some(x) = &self.start.attitude {
            write!(f, ", attitude tau({})", list(x))?;
        }
        match &self.start.orientation {
            None => {}
            Some(Orientation::RotationVector(x)) => write!(f, ", rotation vector {}", list(x))?,
            Some(Orientation::Quaternion(q)) => write!(f, ", quaternion {}", list(q))?,
            Some(Orientation::Matrix(matrix)) => write!(f, ", attitude {}", rows(matrix))?,
            Some(Orientation::Euler { angles, axes }) => write!(f, ", Euler angles {} ({axes})", list(angles))?,
        }
        if let Some(x) = &self.start.position {
            write!(f, ", position {}", list(x))?;
        }
        writeln!(f, ", t = {}", self.start.time)?;
        write!(f, "step       {}", self.step)
    }
}
