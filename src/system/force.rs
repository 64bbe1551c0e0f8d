//! The terms of a force, each described once: its name, its parameters and what they are, where it is smooth, how often it is
//! drawn, what is simpler.
//!
//! Files, random cases, shrinking, changes of basis, ensembles and the protocol of `probe` go by the [`Role`] of a
//! parameter, not by the kind of the force. A new force has its formula in [`mechanics::force`](crate::mechanics::force),
//! and here a variant of [`Force`], an entry of the catalogue and an arm of [`Force::typed`]. What forms there are in lanes
//! is said in [`integrators::so3`](crate::integrators::so3) and [`integrators::se3`](crate::integrators::se3).

use super::case::Inertia;
use super::error::{CaseError, Place, Problem};
use super::numbers::{index, list, number, rows, square, symmetric, vector};
use super::scope::Scope;
use crate::algebra::catalogue::Entry;
use crate::algebra::{LieAlgebra, Matrix};
use crate::mechanics::force::{
    AnyForce, Constant, CubicDrag, DoubleBracket, ForceError, LinearDrag, MAX_DEGREE, Metriplectic, Monomial as Typed,
    Periodic, Polynomial, QuadraticDrag,
};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::lie_poisson::OrbitForce;
use crate::scalar::{Number, Real};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The matrix K of a drag.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Drag {
    /// K = k 1.
    Coefficient(Number),
    /// K by rows.
    Matrix(Vec<Vec<Number>>),
}

impl Default for Drag {
    /// K = 0.
    fn default() -> Self {
        Self::Coefficient(Number::default())
    }
}

/// The key of k, where K = k 1.
pub(crate) const COEFFICIENT: &str = "coefficient";

/// The key of the rows of K.
pub(crate) const MATRIX: &str = "matrix";

/// One term of a polynomial in (cos t, sin t, η): value cos(t)^p sin(t)^q η^i η^j … in one component.
#[derive(Clone, Debug, PartialEq)]
pub struct Monomial {
    /// Which component, from 1.
    pub component: usize,
    /// The coefficient.
    pub value: Number,
    /// p.
    pub cos: usize,
    /// q.
    pub sin: usize,
    /// i, j, …, from 1: an index as often as it is a factor.
    pub factors: Vec<usize>,
}

impl Monomial {
    /// `[component, value, [i, j, k]]`: without powers of cos t and sin t.
    pub(crate) fn odd(&self) -> String {
        format!("[{}, {}, {:?}]", self.component, self.value, self.factors)
    }

    /// The term with numbers in `T`, of n components; `last` is where its factors are in the list that it is in files.
    pub(super) fn typed<T: Real>(&self, n: usize, place: &Place, last: usize) -> Result<Typed<T>, CaseError> {
        let factors = self.factors.iter().enumerate().map(|(j, i)| index(*i, n, place.index(last).index(j)));
        Ok(Typed {
            component: index(self.component, n, place.index(0))?,
            coefficient: number(&self.value, &place.index(1))?,
            cos: self.cos,
            sin: self.sin,
            factors: factors.collect::<Result<_, _>>()?,
        })
    }

    /// The largest index.
    pub(crate) fn largest(&self) -> usize {
        self.factors.iter().fold(self.component, |m, i| m.max(*i))
    }
}

/// One term of the force f(t, η).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Force {
    /// Double-bracket dissipation with coefficient α: keeps Casimirs, lowers the energy (LLG on so(3)).
    DoubleBracket {
        /// α.
        alpha: Number,
    },
    /// Metriplectic relaxation with coefficient β: keeps the energy, moves Casimirs.
    Metriplectic {
        /// β.
        beta: Number,
    },
    /// f = −(K η)ᵀ.
    LinearDrag(Drag),
    /// f = −√(ηᵀ K η) (K η)ᵀ, K symmetric and positive semidefinite.
    QuadraticDrag(Drag),
    /// f = −q (ηᵀη) ηᵀ.
    CubicDrag {
        /// q.
        q: Number,
    },
    /// A constant covector.
    Constant {
        /// Its n components.
        value: Vec<Number>,
    },
    /// f(t) = value cos(ωt + φ).
    Periodic {
        /// The n amplitudes.
        value: Vec<Number>,
        /// ω.
        frequency: Number,
        /// φ.
        phase: Number,
    },
    /// A polynomial in (cos t, sin t, η) with values in g*.
    Polynomial {
        /// Its terms.
        terms: Vec<Monomial>,
    },
    /// f = ad*_ζ l'(η): keeps coadjoint orbits.
    Orbit {
        /// ζ, a polynomial in (cos t, sin t, η) with values in g.
        zeta: Vec<Monomial>,
    },
    /// A formula in t, η, μ and g with n components.
    Formula {
        /// Its text, in the names of [`Case::names`](super::case::Case::names).
        components: String,
    },
    /// −k (R − Rᵀ)^∨/2 − d ω on so(3) and se(3), with the rotation R and its angular velocity ω: proportional-derivative control that turns
    /// the body to R = 1.
    AttitudeControl {
        /// k.
        stiffness: Number,
        /// d.
        damping: Number,
    },
    /// A force of a user's own type ([`crate::laws::user`]), which the case does not describe.
    Given,
}

/// What kind of quantity a parameter of a force is, or another part of a case (the start, the forms and the gyrostat of the Lagrangian, the
/// argument of the retraction). How it is read and written, drawn, shrunk, sent to a program, and changed with the basis depends on its role
/// alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A number to which the force is proportional.
    Strength,
    /// A covector to which the force is proportional.
    Amplitude,
    /// A vector of g.
    Vector,
    /// A symmetric form on g.
    Form,
    /// A linear map K: g → g*, any.
    Drag,
    /// A linear map K: g → g*, symmetric and positive semidefinite.
    SymmetricDrag,
    /// ω of cos(ωt + φ).
    Frequency,
    /// φ of cos(ωt + φ), next to ω; 0 where a file has none.
    Phase,
    /// A polynomial with values in g*, to whose coefficients the force is proportional.
    CovectorPolynomial,
    /// The same with values in g.
    VectorPolynomial,
    /// The same of odd degrees in η alone.
    OddPolynomial,
    /// The text of a formula.
    Formula,
}

/// A parameter of a kind of force.
#[derive(Debug)]
pub(crate) struct Parameter {
    /// The name, which is the key in files; drags have two keys of their own.
    pub name: &'static str,
    /// What it is.
    pub role: Role,
}

impl Parameter {
    /// Its keys in files, of which one is given.
    pub fn keys(&'static self) -> &'static [&'static str] {
        match self.role {
            Role::Drag | Role::SymmetricDrag => &[COEFFICIENT, MATRIX],
            _ => std::slice::from_ref(&self.name),
        }
    }

    /// Whether the force vanishes where the parameter does.
    fn scales(&self) -> bool {
        !matches!(self.role, Role::Frequency | Role::Phase | Role::Formula)
    }
}

/// The value of a parameter: a number, a vector or a covector, a symmetric form, the matrix of a drag, the terms of a polynomial, or the text
/// of a formula.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Value<N = Number, L = Vec<Number>, S = Inertia, D = Drag, P = Vec<Monomial>, F = String> {
    Number(N),
    List(L),
    Form(S),
    Drag(D),
    Polynomial(P),
    Formula(F),
}

/// A value to be changed.
pub(crate) type Mut<'a> =
    Value<&'a mut Number, &'a mut Vec<Number>, &'a mut Inertia, &'a mut Drag, &'a mut Vec<Monomial>, &'a mut String>;

macro_rules! value {
    ($($variant:ident $of:ty),*) => {
        $(impl<'a> From<&'a mut $of> for Mut<'a> {
            fn from(value: &'a mut $of) -> Self {
                Self::$variant(value)
            }
        })*

        impl Mut<'_> {
            /// The value as it is.
            pub fn get(self) -> Value {
                match self {
                    $(Self::$variant(value) => Value::$variant(value.clone()),)*
                }
            }

            /// Gives it that value, if it is one of its type.
            pub fn put(self, value: Value) {
                match (self, value) {
                    $((Self::$variant(place), Value::$variant(value)) => *place = value,)*
                    _ => {}
                }
            }
        }
    };
}

value!(Number Number, List Vec<Number>, Form Inertia, Drag Drag, Polynomial Vec<Monomial>, Formula String);

/// What a force is a function of, beside the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Argument {
    /// Of the velocity and of M = l'(η), by brackets: it vanishes on abelian algebras.
    Momentum,
    /// Of the velocity.
    Velocity,
    /// Of neither.
    Nothing,
    /// Of the configuration too, or a formula of whatever there is.
    Configuration,
}

/// What is known of ⟨f, η⟩.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Power {
    /// Nothing.
    Any,
    /// It is at most 0, where the strengths are at least 0.
    Lost,
    /// It is 0.
    None,
}

/// A kind of force.
#[derive(Debug)]
pub(crate) struct ForceKind {
    /// The name in files.
    pub name: &'static str,
    /// In the order of files.
    pub parameters: &'static [Parameter],
    /// What it is a function of.
    pub argument: Argument,
    /// What it does to the energy.
    pub power: Power,
    /// Whether it keeps Casimir functions at l'(η): it is tangent to coadjoint orbits.
    pub keeps_casimirs: bool,
    /// Whether it is smooth everywhere, at rest too.
    pub smooth: bool,
    /// Whether its formula identifies g* with g by the basis, so that it keeps its form under orthogonal changes of basis only.
    pub orthogonal: bool,
    /// How often it is drawn: its weight beside those of the other kinds.
    pub weight: usize,
    /// The same for [`Cases::showing_order`](super::Cases::showing_order).
    pub showing_order: usize,
    /// A simpler kind that has parameters of the same names.
    pub simpler: Option<&'static str>,
    /// The groups on which laws judge its form in lanes, a `Term` in `integrators/so3/terms.rs`. Without such a form: `&[]`.
    pub lanes: &'static [Entry],
    /// One of this kind with all parameters 0.
    zero: fn() -> Force,
}

/// What most kinds have in common.
const USUAL: ForceKind = ForceKind {
    name: "",
    parameters: &[],
    argument: Argument::Velocity,
    power: Power::Any,
    keeps_casimirs: false,
    smooth: true,
    orthogonal: false,
    weight: 0,
    showing_order: 0,
    simpler: None,
    lanes: &[Entry::So3, Entry::Se3],
    zero: || Force::Given,
};

/// For each variant: its fields, what they are, and the description.
macro_rules! catalogue {
    ($($variant:ident $fields:tt [$($field:ident: $role:ident),*] $kind:expr;)*) => {
        /// The kinds by their variants, as in files.
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub(crate) enum Kind {
            $($variant),*
        }

        /// All kinds; that of a user's own types is the last.
        pub(crate) static KINDS: &[ForceKind] = &[$(ForceKind {
            parameters: &[$(Parameter { name: stringify!($field), role: Role::$role }),*],
            zero: || {
                $(let $field = Default::default();)*
                Force::$variant $fields
            },
            ..$kind
        }),*];

        impl Force {
            /// The description of its kind.
            pub(crate) fn description(&self) -> &'static ForceKind {
                match self {
                    $(Self::$variant { .. } => Kind::$variant.description(),)*
                }
            }

            fn values_mut(&mut self) -> Vec<Mut<'_>> {
                match self {
                    $(Self::$variant $fields => vec![$($field.into()),*],)*
                }
            }
        }
    };
}

catalogue! {
    DoubleBracket { alpha } [alpha: Strength] ForceKind {
        name: "double-bracket", argument: Argument::Momentum, power: Power::Lost, keeps_casimirs: true, orthogonal: true, weight: 18,
        showing_order: 11, lanes: &[Entry::So3], ..USUAL
    };
    Metriplectic { beta } [beta: Strength] ForceKind {
        name: "metriplectic", argument: Argument::Momentum, power: Power::None, weight: 18, showing_order: 11, lanes: &[Entry::So3], ..USUAL
    };
    LinearDrag (drag) [drag: Drag] ForceKind { name: "linear-drag", power: Power::Lost, weight: 14, showing_order: 22, ..USUAL };
    QuadraticDrag (drag) [drag: SymmetricDrag] ForceKind {
        name: "quadratic-drag", power: Power::Lost, smooth: false, weight: 12, showing_order: 17, ..USUAL
    };
    CubicDrag { q } [q: Strength] ForceKind {
        name: "cubic-drag", orthogonal: true, power: Power::Lost, weight: 6, showing_order: 6, lanes: &[], ..USUAL
    };
    Constant { value } [value: Amplitude] ForceKind {
        name: "constant", argument: Argument::Nothing, weight: 7, showing_order: 6, ..USUAL
    };
    Periodic { value, frequency, phase } [value: Amplitude, frequency: Frequency, phase: Phase] ForceKind {
        name: "periodic", argument: Argument::Nothing, weight: 7, showing_order: 11, simpler: Some("constant"), ..USUAL
    };
    Polynomial { terms } [terms: CovectorPolynomial] ForceKind {
        name: "polynomial", weight: 11, showing_order: 10, lanes: &[], ..USUAL
    };
    Orbit { zeta } [zeta: VectorPolynomial] ForceKind {
        name: "orbit", argument: Argument::Momentum, keeps_casimirs: true, weight: 7, showing_order: 6, lanes: &[], ..USUAL
    };
    Formula { components } [components: Formula] ForceKind {
        name: "formula", argument: Argument::Configuration, smooth: false, lanes: &[], ..USUAL
    };
    AttitudeControl { stiffness, damping } [stiffness: Strength, damping: Strength] ForceKind {
        name: "attitude-control", argument: Argument::Configuration, lanes: &[], ..USUAL
    };
    Given {} [] ForceKind { name: "given", ..USUAL };
}

impl Kind {
    /// What is said of it.
    pub fn description(self) -> &'static ForceKind {
        &KINDS[self as usize]
    }
}

impl ForceKind {
    /// The kind of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        KINDS.iter().find(|kind| kind.name == name)
    }

    /// The names of the kinds that people write: all but that of a user's own types.
    pub fn names() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|kind| kind.name).filter(|name| *name != Kind::Given.description().name)
    }

    /// The force with these values of its parameters, in their order; 0 for those that are not there.
    pub fn force(&self, values: impl IntoIterator<Item = Value>) -> Force {
        let mut force = (self.zero)();
        values.into_iter().enumerate().for_each(|(k, value)| force.set(k, value));
        force
    }
}

impl Force {
    /// The kind, as in files.
    pub fn kind(&self) -> &'static str {
        self.description().name
    }

    /// The parameters, in the order of files.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, Value)> + use<> {
        let values: Vec<Value> = self.clone().values_mut().into_iter().map(Mut::get).collect();
        self.description().parameters.iter().zip(values)
    }

    /// The same, to be changed.
    pub(crate) fn parameters_mut(&mut self) -> impl Iterator<Item = (&'static Parameter, Mut<'_>)> {
        self.description().parameters.iter().zip(self.values_mut())
    }

    /// Gives parameter k, from 0, that value; its role says of which type that is.
    pub(crate) fn set(&mut self, k: usize, value: Value) {
        if let Some(place) = self.values_mut().into_iter().nth(k) {
            place.put(value);
        }
    }

    /// Every number to which the force is proportional.
    fn scales(&self) -> Vec<Number> {
        let mut found = Vec::new();
        self.clone().scale(|k| found.push(k.clone()));
        found
    }

    /// Changes every number to which the force is proportional.
    pub(super) fn scale(&mut self, mut change: impl FnMut(&mut Number)) {
        for (_, value) in self.parameters_mut().filter(|(parameter, _)| parameter.scales()) {
            match value {
                Value::Number(k) | Value::Drag(Drag::Coefficient(k)) => change(k),
                Value::List(list) => list.iter_mut().for_each(&mut change),
                Value::Drag(Drag::Matrix(rows)) => rows.iter_mut().flatten().for_each(&mut change),
                Value::Polynomial(terms) => terms.iter_mut().for_each(|term| change(&mut term.value)),
                Value::Form(_) | Value::Formula(_) => {}
            }
        }
    }

    /// Whether ⟨f, η⟩ ≤ 0. Of a matrix without symmetry nothing is known.
    pub(crate) fn dissipates(&self) -> bool {
        let positive = |x: &Number| x.eval::<f64>().is_ok_and(|x| x >= 0.0);
        match self.description().power {
            Power::Any => false,
            Power::None => true,
            Power::Lost => self.parameters().all(|(parameter, value)| match value {
                _ if parameter.role == Role::SymmetricDrag => true,
                Value::Number(k) | Value::Drag(Drag::Coefficient(k)) => positive(&k),
                _ => false,
            }),
        }
    }

    /// Whether ⟨f, η⟩ = 0.
    pub(crate) fn is_workless(&self) -> bool {
        self.description().power == Power::None
    }

    /// Whether it keeps Casimir functions at l'(η).
    pub(crate) fn keeps_casimirs(&self) -> bool {
        self.description().keeps_casimirs
    }

    /// Whether it is made of brackets with the momentum.
    pub(crate) fn is_bracket(&self) -> bool {
        self.description().argument == Argument::Momentum
    }

    /// Whether it is no f(t, η) of the kinds that laws know.
    pub(crate) fn is_general(&self) -> bool {
        self.description().argument == Argument::Configuration
    }

    /// Whether it depends on the time alone.
    pub(crate) fn is_load(&self) -> bool {
        self.description().argument == Argument::Nothing
    }

    /// Whether it is zero whatever the state, on an abelian algebra or any.
    pub(super) fn vanishes(&self, abelian: bool) -> bool {
        let zero = |x: &Number| x.eval::<f64>() == Ok(0.0);
        let scales = self.scales();
        (abelian && self.is_bracket()) || (!scales.is_empty() && scales.iter().all(zero))
    }

    /// Whether there is such a force in dimension n.
    pub(super) fn fits(&self, n: usize) -> bool {
        self.parameters().all(|(_, value)| match value {
            Value::List(list) => list.len() == n,
            Value::Drag(Drag::Matrix(rows)) => rows.len() == n,
            Value::Polynomial(terms) => terms.iter().all(|term| term.largest() <= n),
            _ => true,
        })
    }

    /// The largest coefficient in absolute value; NaN where it is no number; 0 where the case does not describe the force.
    pub(super) fn strength(&self) -> f64 {
        let size = |x: &Number| x.eval::<f64>().map_or(f64::NAN, f64::abs);
        self.scales().iter().map(size).fold(0.0, |m, x| if x > m || x.is_nan() { x } else { m })
    }

    /// The force with numbers in `T`, of n-dimensional `algebra` beside spectators.
    pub(super) fn typed<T: Real, const N: usize>(
        &self,
        n: usize,
        algebra: &LieAlgebra<T, N>,
        lagrangian: &AnyLagrangian<T, N>,
        scope: &Scope,
        place: &Place,
    ) -> Result<AnyForce<T, N>, CaseError> {
        let refused = |e: ForceError| place.error(Problem::Force(e));
        let scalar = |key: &'static str, x: &Number| number::<T>(x, &place.key(key));
        let covector = |list: &[Number]| Ok(vector::<T, N>(list, n, &place.key("value"))?.transpose());
        let parts = || (algebra.clone(), lagrangian.clone());
        Ok(match self {
            Self::DoubleBracket { alpha } => {
                let (algebra, lagrangian) = parts();
                DoubleBracket::new(algebra, lagrangian, scalar("alpha", alpha)?).map_err(refused)?.into()
            }
            Self::Metriplectic { beta } => {
                let (algebra, lagrangian) = parts();
                Metriplectic::new(algebra, lagrangian, scalar("beta", beta)?).map_err(refused)?.into()
            }
            Self::LinearDrag(drag) => LinearDrag::new(drag.typed(n, false, place)?.0).map_err(refused)?.into(),
            Self::QuadraticDrag(drag) => {
                let (matrix, place) = drag.typed(n, true, place)?;
                QuadraticDrag::new(matrix).map_err(|e| place.error(e))?.into()
            }
            Self::CubicDrag { q } => CubicDrag::new(scalar("q", q)?).map_err(refused)?.into(),
            Self::Constant { value } => Constant::new(covector(value)?).map_err(refused)?.into(),
            Self::Periodic { value, frequency, phase } => {
                let (frequency, phase) = (scalar("frequency", frequency)?, scalar("phase", phase)?);
                Periodic::new(covector(value)?, frequency, phase).map_err(refused)?.into()
            }
            Self::Polynomial { terms } => polynomial(terms, n, &place.key("terms"))?.into(),
            Self::Orbit { zeta } => {
                let (algebra, lagrangian) = parts();
                OrbitForce::new(algebra, lagrangian, polynomial(zeta, n, &place.key("zeta"))?).into()
            }
            Self::Formula { components } => scope.force(components, lagrangian, &place.key("components"))?,
            Self::AttitudeControl { stiffness, damping } => {
                let text = scope.attitude_control(stiffness, damping, place)?;
                scope.force(&text, lagrangian, place)?
            }
            Self::Given => return Err(place.error(Problem::given("the force"))),
        })
    }
}

/// The polynomial with numbers in `T`, of the first n components.
fn polynomial<T: Real, const N: usize>(
    terms: &[Monomial],
    n: usize,
    place: &Place,
) -> Result<Polynomial<T, N>, CaseError> {
    if terms.is_empty() {
        return Err(place.range("empty", "at least one term"));
    }
    let typed = |(k, term): (usize, &Monomial)| {
        let place = place.index(k);
        let degree = |position: usize, degree: usize| match degree <= MAX_DEGREE {
            true => Ok(()),
            false => Err(place.index(position).range(format!("of degree {degree}"), format!("at most {MAX_DEGREE}"))),
        };
        degree(2, term.cos)?;
        degree(3, term.sin)?;
        degree(FACTORS, term.factors.len())?;
        term.typed(n, &place, FACTORS)
    };
    let terms = terms.iter().enumerate().map(typed).collect::<Result<_, CaseError>>()?;
    Polynomial::new(terms).map_err(|e| place.error(Problem::Force(e)))
}

/// The place of the factors in the list that is a term in files.
const FACTORS: usize = 4;

impl Drag {
    /// Its key.
    pub(crate) fn key(&self) -> &'static str {
        match self {
            Self::Coefficient(_) => COEFFICIENT,
            Self::Matrix(_) => MATRIX,
        }
    }

    /// K, n×n beside zeros for spectators, and its place.
    fn typed<T: Real, const N: usize>(
        &self,
        n: usize,
        is_symmetric: bool,
        place: &Place,
    ) -> Result<(Matrix<T, N>, Place), CaseError> {
        let place = place.key(self.key());
        let matrix = match self {
            Self::Coefficient(k) => {
                let k = number(k, &place)?;
                Matrix::from_fn(|r, c| if r == c && r < n { k } else { T::zero() })
            }
            Self::Matrix(rows) => square(rows, n, T::zero(), &place)?,
        };
        match self {
            Self::Matrix(rows) if is_symmetric => symmetric(&matrix, rows, &place)?,
            _ => {}
        }
        Ok((matrix, place))
    }
}

/// `[component, value, p, q, [i, j]]`, as in files.
impl fmt::Display for Monomial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}, {}, {}, {:?}]", self.component, self.value, self.cos, self.sin, self.factors)
    }
}

impl fmt::Display for Force {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kind())?;
        for (parameter, value) in self.parameters() {
            match (parameter.role, value) {
                (Role::Frequency, Value::Number(omega)) => write!(f, " cos({omega} t")?,
                (Role::Phase, Value::Number(phi)) => write!(f, " + {phi})")?,
                (_, Value::Number(k)) => write!(f, " {} = {k}", parameter.name)?,
                (_, Value::List(value)) => write!(f, " {}", list(&value))?,
                (_, Value::Form(form)) => write!(f, " {form}")?,
                (_, Value::Drag(Drag::Coefficient(k))) => write!(f, " k = {k}")?,
                (_, Value::Drag(Drag::Matrix(k))) => write!(f, " K = {}", rows(&k))?,
                (_, Value::Formula(text)) => write!(f, " {text}")?,
                (_, Value::Polynomial(terms)) => {
                    let terms: Vec<String> = terms.iter().map(ToString::to_string).collect();
                    write!(f, " {} = [{}]", parameter.name, terms.join(", "))?;
                }
            }
        }
        Ok(())
    }
}
