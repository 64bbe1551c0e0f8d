//! The terms of a force. What is said of a kind is said once: in [`mechanics::force`](crate::mechanics::force) beside its type, or in this file
//! where it is a formula.
//!
//! Files, random cases, shrinking, changes of basis, ensembles and the protocol of `probe` go by the [`Role`] of a
//! parameter, not by the kind of the force; so do they for the [potentials](super::potential). What forms there are in lanes
//! is said in [`integrators::lanes`](crate::integrators::lanes).

use super::case::Inertia;
use super::error::{CaseError, CaseProblem, Place};
use super::numbers::{index, list, number, rows, square, symmetric, vector};
use super::scope::Scope;
use super::shares::Share;
use crate::algebra::{Covector, LieAlgebra, Matrix};
// Every type of the catalogue.
use crate::mechanics::force::Monomial as TypedMonomial;
use crate::mechanics::force::*;
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
    pub(super) fn typed<T: Real>(&self, n: usize, place: &Place, last: usize) -> Result<TypedMonomial<T>, CaseError> {
        let factors = self.factors.iter().enumerate().map(|(j, i)| index(*i, n, place.index(last).index(j)));
        Ok(TypedMonomial {
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

/// What kind of quantity a parameter of a force or of a potential is, or another part of a case (the start, the forms and the gyrostat of the Lagrangian, the
/// argument of the retraction). How it is read and written, drawn, shrunk, sent to a program, and changed with the basis depends on its role
/// alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A number to which the force is proportional.
    Strength,
    /// A number to which the potential is proportional.
    Weight,
    /// A rate of rotation, on whose square the potential depends.
    Rate,
    /// A covector to which the force is proportional, or a vector of the body to which the potential is.
    Amplitude,
    /// A vector of g; of a potential one of the body or of space.
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

/// A parameter of a kind of force or of potential.
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

    /// Whether the force or the potential vanishes where the parameter does.
    pub fn scales(&self) -> bool {
        !matches!(self.role, Role::Frequency | Role::Phase | Role::Vector | Role::Formula)
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

impl<'a> Mut<'a> {
    /// Its numbers.
    pub fn numbers(self) -> Vec<&'a mut Number> {
        match self {
            Self::Number(k) | Self::Drag(Drag::Coefficient(k)) => vec![k],
            Self::List(list) | Self::Form(Inertia::Diagonal(list)) => list.iter_mut().collect(),
            Self::Form(Inertia::Full(rows)) | Self::Drag(Drag::Matrix(rows)) => rows.iter_mut().flatten().collect(),
            Self::Polynomial(terms) => terms.iter_mut().map(|term| &mut term.value).collect(),
            Self::Formula(_) => Vec::new(),
        }
    }
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

/// For which groups a formula is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    /// For any.
    Any,
    /// For so(3) and se(3): it is about the rotation R and the position x.
    Body,
    /// The same in the standard basis: it names coordinates.
    StandardBody,
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
    /// Whether it has a form in lanes, a `Term` in `integrators/lanes/terms.rs`.
    pub lanes: bool,
    /// A formula, with the names of parameters in braces; where it is one.
    pub formula: &'static str,
    /// Of the formula.
    pub domain: Domain,
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
    lanes: false,
    formula: "",
    domain: Domain::Any,
    zero: || Force::Given,
};

/// An enum of terms by their kinds, with what is said of each kind and what follows from the roles of parameters. Of the entry
///
/// ```text
/// DoubleBracket(DoubleBracket<T, N>) "double bracket" {
///     { alpha: Number as Strength "α." }
///     is { name: "double-bracket", keeps_casimirs: true };
///     makes (algebra, lagrangian) { DoubleBracket::new(algebra.clone(), lagrangian.clone(), alpha) }
/// }
/// ```
///
/// it makes a variant of the term, one of the kinds, and what is said of the kind:
///
/// ```text
/// pub enum Force { DoubleBracket { alpha: Number }, … }
/// enum Kind { DoubleBracket, … }
/// ForceKind { name: "double-bracket", parameters: &[Parameter { name: "alpha", role: Role::Strength }], keeps_casimirs: true, ..USUAL }
/// ```
///
/// A parameter without a key of its own, such as the matrix of a drag, stands in parentheses: `(drag: Drag as Drag)` makes `LinearDrag(Drag)`.
/// `$each` gets for each entry its pattern, the names and roles of its parameters, and what stands after `makes`.
macro_rules! terms {
    (
        $(#[$attribute:meta])* enum $term:ident;
        $(#[$of_kinds:meta])* enum $kinds:ident;
        $(#[$of_shares:meta])* $shares:ident of $category:literal;
        $said:ident, $each:ident;
        $(
            $(#[$about:meta])*
            $variant:ident $(($core:ty) $called:literal)? {
                $(($only:ident: $type:ty as $its_role:ident))?
                $({ $($field:ident: $value:ty as $role:ident $what:literal),* $(,)? })?
                is { $($key:ident: $known:expr),* $(,)? };
                $(share $least:literal, $most:literal;)?
                $(makes $($rest:tt)*)?
            }
        )*
    ) => {
        $(#[$attribute])*
        pub enum $term {
            $($(#[$about])* $variant $(($type))? $({ $(#[doc = $what] $field: $value,)* })?,)*
        }

        /// The kinds by their variants, as in files.
        $(#[$of_kinds])*
        pub(crate) enum $kinds {
            $($variant),*
        }

        impl $kinds {
            /// All of them.
            #[allow(clippy::needless_update, reason = "some entries say everything")]
            pub const ALL: &'static [$said] = &[$($said {
                parameters: &[
                    $(Parameter { name: stringify!($only), role: Role::$its_role },)?
                    $($(Parameter { name: stringify!($field), role: Role::$role },)*)?
                ],
                zero: || {
                    $(let $only = Default::default();)?
                    $($(let $field = Default::default();)*)?
                    $term::$variant $(($only))? $({ $($field),* })?
                },
                $($key: $known,)*
                ..USUAL
            }),*];

            /// Their names in files.
            pub const NAMES: [&'static str; Self::ALL.len()] = [$($kinds::$variant.description().name),*];

            /// What is said of it.
            pub const fn description(self) -> &'static $said {
                &Self::ALL[self as usize]
            }
        }

        $(#[$of_shares])*
        pub const $shares: &[Share] =
            &[$($(Share::within($category, $kinds::$variant.description().name, $least, $most),)?)*];

        impl $said {
            /// The kind of that name.
            pub fn named(name: &str) -> Option<&'static Self> {
                $kinds::ALL.iter().find(|kind| kind.name == name)
            }

            /// The term with these values of its parameters, in their order; 0 for those that are not there.
            pub fn with(&self, values: impl IntoIterator<Item = Value>) -> $term {
                let mut term = (self.zero)();
                values.into_iter().enumerate().for_each(|(k, value)| term.set(k, value));
                term
            }
        }

        impl $term {
            /// The kind, as in files.
            pub fn kind(&self) -> &'static str {
                self.description().name
            }

            /// What is said of its kind.
            pub(crate) fn description(&self) -> &'static $said {
                match self {
                    $(Self::$variant { .. } => $kinds::$variant.description(),)*
                }
            }

            fn values_mut(&mut self) -> Vec<Mut<'_>> {
                match self {
                    $(Self::$variant $(($only))? $({ $($field),* })? => vec![$($only.into())? $($($field.into()),*)?],)*
                }
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

            /// Changes every number to which it is proportional.
            pub(super) fn scale(&mut self, change: impl FnMut(&mut Number)) {
                let scales = self.parameters_mut().filter(|(parameter, _)| parameter.scales());
                scales.map(|(_, value)| value).flat_map(Mut::numbers).for_each(change);
            }
        }

        $each! { $(
            { Self::$variant $(($only))? $({ $($field),* })? } [$($only as $its_role)? $($($field as $role)*)?] { $($($rest)*)? }
        )* }
    };
}
pub(super) use terms;

/// The force of an entry of the catalogue, by its constructor from the values of its parameters in `T`; or else by a formula.
macro_rules! typed {
    (
        $formula:ident, ($n:ident, $algebra:ident, $lagrangian:ident, $place:ident, $refused:ident), [$($field:ident as $role:ident)*],
        ($($its_algebra:ident, $its_lagrangian:ident)?) $core:block
    ) => {{
        $(let ($its_algebra, $its_lagrangian) = ($algebra, $lagrangian);)?
        $(
            let parameter = &Parameter { name: stringify!($field), role: Role::$role };
            let $field = Typed::<T, N>::typed($field, $n, parameter, $place)?;
        )*
        Result::map_err($core, $refused)?.into()
    }};
    ($formula:ident, $of:tt, [$($field:ident as $role:ident)*],) => {{
        let _ = ($($field,)*);
        $formula()?
    }};
}

macro_rules! construction {
    ($({ $($of:tt)* } $parameters:tt { $($made:tt)* })*) => {
        impl Force {
            /// The force with numbers in `T`, of n-dimensional `algebra` beside spectators.
            pub(super) fn typed<T: Real, const N: usize>(
                &self,
                n: usize,
                algebra: &LieAlgebra<T, N>,
                lagrangian: &AnyLagrangian<T, N>,
                scope: &Scope,
                place: &Place,
            ) -> Result<AnyForce<T, N>, CaseError> {
                let refused = |e: ForceError| {
                    // A matrix is what can be wrong.
                    let matrix = self.parameters().find_map(|(_, value)| match value {
                        Value::Drag(drag) => Some(drag.key()),
                        _ => None,
                    });
                    matrix.map_or(place.clone(), |key| place.key(key)).error(CaseProblem::Force(e))
                };
                let formula = || match self.description() {
                    ForceKind { formula: "", .. } => Err(place.error(CaseProblem::given("the force"))),
                    kind => {
                        let formula = (kind.name, kind.domain, kind.formula);
                        let (text, place) = scope.formula(formula, self.parameters(), place)?;
                        scope.force(&text, lagrangian, &place)
                    }
                };
                Ok(match self {
                    $($($of)* => typed!(formula, (n, algebra, lagrangian, place, refused), $parameters, $($made)*),)*
                })
            }
        }
    };
}

crate::mechanics::force::catalogue! { terms {
    /// One term of the force f(t, η).
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    enum Force;
    #[derive(Clone, Copy, Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Kind;
    /// The shares of the kinds that are drawn.
    FORCE_SHARES of "force";
    ForceKind, construction;
} {
    /// A formula in t, η, μ and g with n components.
    Formula {
        { components: String as Formula "Its text, in the names of [`Case::names`](super::case::Case::names)." }
        is { name: "formula", argument: Argument::Configuration, smooth: false, formula: "{components}" };
    }
    /// −k (R − Rᵀ)^∨/2 − d ω on so(3) and se(3), with the rotation R and its angular velocity ω: proportional-derivative control that turns
    /// the body to R = 1.
    AttitudeControl {
        {
            stiffness: Number as Strength "k.",
            damping: Number as Strength "d.",
        }
        is {
            name: "attitude-control", argument: Argument::Configuration, domain: Domain::StandardBody,
            formula: "[-({stiffness})*vee(R)[1] - ({damping})*eta_1, -({stiffness})*vee(R)[2] - ({damping})*eta_2, \
                      -({stiffness})*vee(R)[3] - ({damping})*eta_3{rest}]",
        };
    }
    /// A force of a user's own type ([`crate::laws::user`]), which the case does not describe.
    Given {
        is { name: "given", lanes: true };
    }
} }

impl ForceKind {
    /// The names of the kinds that people write: all but that of a user's own types.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Kind::NAMES.into_iter().filter(|name| *name != Kind::Given.description().name)
    }
}

impl Force {
    /// Every number to which the force is proportional.
    fn scales(&self) -> Vec<Number> {
        let mut found = Vec::new();
        self.clone().scale(|k| found.push(k.clone()));
        found
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

    /// Whether it is no f(t, η) of the kinds that laws know.
    pub(crate) fn is_general(&self) -> bool {
        self.description().argument == Argument::Configuration
    }

    /// Whether it is zero whatever the state, on an abelian algebra or any.
    pub(super) fn vanishes(&self, abelian: bool) -> bool {
        let zero = |x: &Number| x.eval::<f64>() == Ok(0.0);
        let scales = self.scales();
        (abelian && self.description().argument == Argument::Momentum)
            || (!scales.is_empty() && scales.iter().all(zero))
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
}

/// The value of a parameter with numbers in `T`, of the first n of N components; `place` is that of the force.
trait Typed<T: Real, const N: usize> {
    type Value;

    fn typed(&self, n: usize, parameter: &Parameter, place: &Place) -> Result<Self::Value, CaseError>;
}

impl<T: Real, const N: usize> Typed<T, N> for Number {
    type Value = T;

    fn typed(&self, _: usize, parameter: &Parameter, place: &Place) -> Result<T, CaseError> {
        number(self, &place.key(parameter.name))
    }
}

impl<T: Real, const N: usize> Typed<T, N> for Vec<Number> {
    type Value = Covector<T, N>;

    fn typed(&self, n: usize, parameter: &Parameter, place: &Place) -> Result<Covector<T, N>, CaseError> {
        Ok(vector::<T, N>(self, n, &place.key(parameter.name))?.transpose())
    }
}

impl<T: Real, const N: usize> Typed<T, N> for Vec<Monomial> {
    type Value = Polynomial<T, N>;

    fn typed(&self, n: usize, parameter: &Parameter, place: &Place) -> Result<Polynomial<T, N>, CaseError> {
        let place = place.key(parameter.name);
        if self.is_empty() {
            return Err(place.range("empty", "at least one term"));
        }
        let typed = |(k, term): (usize, &Monomial)| {
            let place = place.index(k);
            let degree = |position: usize, degree: usize| match degree <= MAX_DEGREE {
                true => Ok(()),
                false => {
                    Err(place.index(position).range(format!("of degree {degree}"), format!("at most {MAX_DEGREE}")))
                }
            };
            degree(2, term.cos)?;
            degree(3, term.sin)?;
            degree(FACTORS, term.factors.len())?;
            term.typed(n, &place, FACTORS)
        };
        let terms = self.iter().enumerate().map(typed).collect::<Result<_, CaseError>>()?;
        Polynomial::new(terms).map_err(|e| place.error(CaseProblem::Force(e)))
    }
}

/// The place of the factors in the list that is a term in files.
const FACTORS: usize = 4;

impl<T: Real, const N: usize> Typed<T, N> for Drag {
    type Value = Matrix<T, N>;

    /// K, n×n beside zeros for spectators.
    fn typed(&self, n: usize, parameter: &Parameter, place: &Place) -> Result<Matrix<T, N>, CaseError> {
        let place = &place.key(self.key());
        match self {
            Self::Coefficient(k) => {
                let k = number(k, place)?;
                Ok(Matrix::from_fn(|r, c| if r == c && r < n { k } else { T::zero() }))
            }
            Self::Matrix(rows) => {
                let matrix = square(rows, n, T::zero(), place)?;
                if parameter.role == Role::SymmetricDrag {
                    symmetric(&matrix, rows, place)?;
                }
                Ok(matrix)
            }
        }
    }
}

impl Drag {
    /// Its key.
    pub(crate) fn key(&self) -> &'static str {
        match self {
            Self::Coefficient(_) => COEFFICIENT,
            Self::Matrix(_) => MATRIX,
        }
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
