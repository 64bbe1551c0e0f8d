//! Laws of any one-step method for a described system: of this crate, of its user, or of another program.
//!
//! The subject is a setup: a system as the theory knows it (`Theory`) and a method that steps on it ([`Stepper`]). A
//! method that has 16 digits only is judged in these; one that has 32 as well is judged by them, identities by both. What is
//! asked beyond consistency are [`Claims`]: where nothing is claimed, a defect need only be of the method's order.
//!
//! | law | without a claim | with it |
//! |---|---|---|
//! | `method-order` | at least 1; the slope is reported | as claimed, on both sides |
//! | `method-casimirs` | the balance closes at the order | |
//! | `method-energy` | the balance closes at the order | |
//! | `method-reversibility` | Φ_{−h}∘Φ_h − 1 falls at the order | nothing but rounding |
//! | `method-momentum` | the balance of Ad*_{g⁻¹} μ closes at the order | |
//! | `method-conserves-casimirs` | | without force and potential: no drift but rounding, at any step |
//! | `method-conserves-energy` | | without force, with a potential V(g) at most: no drift but rounding, at any step |
//! | `method-conserves-momentum` | | without force and potential: no drift of Ad*_{g⁻¹} μ but rounding, at any step |
//! | `method-noether` | | the spatial momentum changes by the impulses at the stages that the method tells, at any step |
//! | `method-poisson` | | without force and potential: μ ↦ μ' is a Poisson map, at any step |
//! | `method-variational` | | a step is that of the variational scheme of a tableau and a retraction, at any size |
//! | `method-equivariance` | left translations that are symmetries, time translations, repetition: nothing but rounding | |
//! | `method-presentation` | a change of basis of the algebra: nothing but rounding | |
//! | `method-smoothness` | h ↦ Φ_h is smooth: nothing but rounding, or the tolerance that is claimed | |
//!
//! [`LAWS`] has them by name, [`check_case`] judges one on a system, described or of a user's own types. `library` has the same
//! laws as [`CaseLaw`](super::CaseLaw)s of this crate's integrator, with planted faults.

mod form;
mod kept;
mod levels;
pub(in crate::laws) mod library;
mod noether;
mod slopes;
mod smoothness;
mod symmetry;
mod theory;
mod variational;

pub use form::StateForm;
use kept::Kept;
pub(crate) use theory::Solved;
pub(in crate::laws) use theory::exponential;
pub use theory::{Point, Stage, Stepper, Untyped};
use theory::{Quantity, SystemParts, Theory, Value};
pub(crate) use variational::Scheme;

use super::planted::retraction::Plant;
use super::precision::{AGREEMENT, alone, compare};
use super::question::Answer;
use super::source::Source;
use crate::harness::convergence::Estimate;
use crate::harness::{About, Cost, Verdict};
use crate::integrators::StepError;
use crate::laws::unbuilt;
use crate::scalar::{Dd, Real, larger};
use crate::study::Findings;
use crate::system::case::Method;
use crate::system::{Case, CaseError, Cases, System, Visitor};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// What is claimed of a method.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// Its order, neither more nor less. `None`: at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<u32>,
    /// Without force and potential it keeps Casimirs to round-off.
    #[serde(default)]
    pub casimirs: bool,
    /// Without force, with a potential V(g) at most, it keeps the energy to round-off.
    #[serde(default)]
    pub energy: bool,
    /// Without force and potential it keeps the spatial momentum Ad*_{g⁻¹} μ to round-off.
    #[serde(default)]
    pub momentum: bool,
    /// Without force and potential μ ↦ μ' is a Poisson map.
    #[serde(default)]
    pub poisson: bool,
    /// The impulses at the stages that it tells change the spatial momentum.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stages: bool,
    /// Its step is that of the variational scheme of this tableau and this retraction; on one's own types, of their retraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variational: Option<Method>,
    /// Φ_{−h}∘Φ_h = 1 to round-off.
    #[serde(default)]
    pub reversible: bool,
    /// How well a step solves its equations, relative to the state; 0: to round-off.
    #[serde(default)]
    pub tolerance: f64,
}

impl Claims {
    /// The order that every defect must fall at.
    pub fn least_order(&self) -> u32 {
        self.order.unwrap_or(1).max(1)
    }
}

/// A law of one-step methods: a header, and functions of a setup and of what is claimed.
#[derive(Clone, Copy, Debug)]
pub struct MethodLaw {
    /// What it says.
    pub about: About,
    cases: fn(Cases) -> Cases,
    /// The claim that it judges, where that is made.
    claim: fn(&Claims) -> Option<String>,
    /// Whether it says nothing where its claim is not made.
    needs_claim: bool,
    judge: fn(&Setup<'_>, &Claims) -> Judged,
}

/// Laws are told apart by what they say.
impl PartialEq for MethodLaw {
    fn eq(&self, other: &Self) -> bool {
        self.about == other.about
    }
}

/// What a defect is called that more or smaller steps do not explain, and a solver of the stage equations that stops early does.
#[doc(hidden)]
pub const LOOSE: &str = "loose solver";

/// What a defect is called that is above rounding, and neither the error of an order nor far above.
#[doc(hidden)]
pub const LOST_DIGITS: &str = "digits are lost";

const SLOPE: &str = "confirmed at a quarter off the order (half the way to the point that is as near to the next integer), or where at \
                     most a quarter of the finest errors is of lower order; refuted where half of them is, from two starts";
const KEPT: &str = "over eight steps of eight sizes from h pace = 1 down, 16 n (1 + h |C||η|) u a step of the size of the terms (products \
                    and an exponential of n×n matrices, structure constants off by u), or 16 times the tolerance that is claimed; refuted \
                    where a larger drift falls with the step, or is 256 times as large";
const ROUNDING: &str = "two precisions, or in f64 alone 2¹⁴ u of the size of the terms, what a solver of stage equations may \
                        leave; 16 times the tolerance that is claimed";

/// What most of the headers have in common.
const ABOUT: About = About {
    name: "",
    statement: "",
    source: "",
    oracle: "",
    bound: SLOPE,
    needs: "",
    cost: Cost::Moderate,
    faults: &[],
};

/// Groups whose motion shows the order; with forces, which show more, unless they are excluded.
fn moving(base: Cases) -> Cases {
    let base = if base.is_force_free() { base.nonabelian() } else { base.forced_nonabelian() };
    base.showing_order()
}

/// Convergence at an order.
pub const ORDER: MethodLaw = MethodLaw {
    about: About {
        name: "method-order",
        statement: "the method converges to the solution, in μ and in g, at the order that it claims (at least at 1)",
        source: "Hairer, Nørsett and Wanner 1993, II.3, Thm 3.4; Martín de Diego and Sato Martín de Almagro 2019, §3",
        oracle: "a classical Gauss method of order 16 or more on the vector field of (μ, g), in 32 digits",
        ..ABOUT
    },
    cases: moving,
    claim: |claims| claims.order.map(|order| format!("order {order}")),
    needs_claim: false,
    judge: slopes::order,
};

/// Casimir functions.
pub const CASIMIRS: MethodLaw = MethodLaw {
    about: About {
        name: "method-casimirs",
        statement: "C(μ_n) − C(μ_0) − ∫⟨f, C'(μ)⟩dt is 0 up to the order of the method",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2: dC/dt = ⟨f, C'(μ)⟩ for every Casimir C",
        oracle: "Casimirs from the catalogue of algebras, at the solution in 32 digits: there the balance is exact",
        ..ABOUT
    },
    cases: |base| base.with_casimirs().showing_order(),
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| slopes::balance(setup, claims, &slopes::known_casimirs(setup)?),
};

/// Energy.
pub const ENERGY: MethodLaw = MethodLaw {
    about: About {
        name: "method-energy",
        statement: "E(μ_n) − E(μ_0) − ∫⟨f, η⟩dt is 0 up to the order of the method",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2: dE/dt = ⟨f(η), η⟩",
        oracle: "the energy at the solution in 32 digits: there the balance is exact",
        ..ABOUT
    },
    cases: Cases::showing_order,
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| slopes::balance(setup, claims, &[Quantity::Energy]),
};

/// Φ_{−h} inverts Φ_h.
pub const REVERSIBILITY: MethodLaw = MethodLaw {
    about: About {
        name: "method-reversibility",
        statement: "Φ_{−h}∘Φ_h = 1 up to O(h^{p+1}) for a method of order p; if claimed, to round-off",
        source: "Hairer, Lubich and Wanner 2006, II.3, Thm 3.1 and V.1; consistency at h and at −h",
        oracle: "the state itself",
        ..ABOUT
    },
    cases: moving,
    claim: |claims| claims.reversible.then(|| "reversible".into()),
    needs_claim: false,
    judge: |setup, claims| match claims.reversible {
        true => setup.settle(claims, symmetry::reversibility, symmetry::reversibility),
        false => slopes::reversibility(setup, claims),
    },
};

/// The spatial momentum.
pub const MOMENTUM: MethodLaw = MethodLaw {
    about: About {
        name: "method-momentum",
        statement: "J = Ad*_{g⁻¹} μ: J_n − J_0 − ∫Ad*_{g⁻¹} f dt is 0 up to the order of the method",
        source: "Marsden and Ratiu 1999, §13.5: Noether's theorem of left translations; of variational methods Marsden and West \
                 2001, §1.3.3",
        oracle: "μ Ad_{g⁻¹} by products of matrices, at the solution in 32 digits: there the balance is exact",
        needs: "a group",
        ..ABOUT
    },
    cases: |base| base.with_group().nonabelian().showing_order(),
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| slopes::balance(setup, claims, slopes::momentum(setup)?),
};

/// Casimir functions without force. Without the claim it says nothing.
pub const CONSERVES_CASIMIRS: MethodLaw = MethodLaw {
    about: About {
        name: "method-conserves-casimirs",
        statement: "without force and potential, if claimed, C(μ_n) = C(μ_0) to round-off, at any step",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5.3.1: dC/dt = 0 for every Casimir C",
        oracle: "Casimirs from the catalogue of algebras, at the start",
        bound: KEPT,
        needs: "no force and no potential",
        ..ABOUT
    },
    cases: |base| base.force_free().with_casimirs().showing_order(),
    claim: |claims| claims.casimirs.then(|| "conserves casimirs".into()),
    needs_claim: true,
    judge: |setup, claims| {
        slopes::unforced(setup.theory.is_free())?;
        kept::judge(setup, Kept::Values(&slopes::known_casimirs(setup)?), claims.tolerance)
    },
};

/// Energy without force. Without the claim it says nothing.
pub const CONSERVES_ENERGY: MethodLaw = MethodLaw {
    about: About {
        name: "method-conserves-energy",
        statement: "without force, with a potential V(g) at most, if claimed, E_n = E_0 to round-off, at any step",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2: dE/dt = ⟨f(η), η⟩",
        oracle: "the energy at the start",
        bound: KEPT,
        needs: "no force, a potential that does not depend on time",
        ..ABOUT
    },
    cases: |base| base.without_force().showing_order(),
    claim: |claims| claims.energy.then(|| "conserves energy".into()),
    needs_claim: true,
    judge: |setup, claims| {
        slopes::unforced(setup.theory.keeps_energy())?;
        kept::judge(setup, Kept::Values(&[Quantity::Energy]), claims.tolerance)
    },
};

/// The spatial momentum without force. Without the claim it says nothing.
pub const CONSERVES_MOMENTUM: MethodLaw = MethodLaw {
    about: About {
        name: "method-conserves-momentum",
        statement: "without force and potential, if claimed, J_n = J_0 to round-off with J = Ad*_{g⁻¹} μ, at any step",
        source: "Marsden and Ratiu 1999, §13.5: Noether's theorem of left translations; of variational methods Marsden and West \
                 2001, §1.3.3",
        oracle: "μ Ad_{g⁻¹} by products of matrices, at the start",
        bound: KEPT,
        needs: "a group; no force and no potential",
        ..ABOUT
    },
    cases: |base| base.force_free().with_group().nonabelian().showing_order(),
    claim: |claims| claims.momentum.then(|| "conserves momentum".into()),
    needs_claim: true,
    judge: |setup, claims| {
        slopes::unforced(setup.theory.is_free())?;
        kept::judge(setup, Kept::Values(slopes::momentum(setup)?), claims.tolerance)
    },
};

/// The impulses at the stages. Without the claim it says nothing.
pub const NOETHER: MethodLaw = MethodLaw {
    about: About {
        name: "method-noether",
        statement: "if claimed, Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ b_j Ad*_{g_j⁻¹} f(t_j, g_j, η_j) at the stages that the method tells, and \
                    Σ b_j = 1, at any step",
        source: "Marsden and West 2001, §3.2, the forced discrete Noether theorem; Martín de Diego and Sato Martín de Almagro 2019, §5.2",
        oracle: "Ad by products of matrices, and the force of the system at the stages",
        bound: ROUNDING,
        needs: "a group; stages",
        ..ABOUT
    },
    cases: |base| match base.is_force_free() {
        true => base.with_group().nonabelian(),
        false => base.with_group().forced_nonabelian(),
    },
    claim: |claims| claims.stages.then(|| "stages".into()),
    needs_claim: true,
    judge: |setup, claims| setup.settle(claims, noether::balance, noether::balance),
};

/// The Lie–Poisson bracket. Without the claim it says nothing.
pub const POISSON: MethodLaw = MethodLaw {
    about: About {
        name: "method-poisson",
        statement: "without force, if claimed, μ ↦ μ' is a Poisson map: D Π(μ) Dᵀ = Π(μ') with D = ∂μ'/∂μ and Π_ab = C^c_ab μ_c",
        source: "Marsden and Ratiu 1999, §10.7 and §13.1: reduced symplectic maps preserve the Lie–Poisson bracket",
        oracle: "structure constants, and central differences of fourth order of the method's own answers",
        bound: "after a step of eight sizes from h pace = 1 down: differences over ε = u^{1/5} of the momentum make 3/ε of the rounding \
                of a step, 16 n (1 + h |C||η|) u, or of 16 times the tolerance that is claimed; refuted where a larger defect falls \
                with the step, or is 256 times as large",
        ..ABOUT
    },
    cases: |base| base.force_free().nonabelian().showing_order(),
    claim: |claims| claims.poisson.then(|| "conserves poisson".into()),
    needs_claim: true,
    judge: slopes::poisson,
};

/// Equality with the variational scheme. Without the claim it says nothing.
pub const VARIATIONAL: MethodLaw = MethodLaw {
    about: About {
        name: "method-variational",
        statement: "if claimed, (g', μ') after a step is that of the forced variational scheme of a tableau and a retraction, at any size \
                    of the step",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2, restricted to the identities",
        oracle: "the variational integrator of this crate, in 32 digits",
        bound: "after a step of eight sizes from h pace = 1 down: each component of the stage equations left with 16 n (1 + A h |C||η|) u, \
                or 16 times the tolerance that is claimed, of its terms and of Σ |∂r/∂H||H|, times what J⁻¹ makes of it in μ' and g' (A: \
                row sums of the tableau); and as much of μ' and g' again; refuted where a larger difference falls with the step, or is 256 \
                times as large at two sizes",
        needs: "a step of the scheme",
        ..ABOUT
    },
    cases: |base| base.nonabelian().showing_order(),
    claim: |claims| {
        let of = |method: &Method| format!("variational {} with {}", method.tableau, method.retraction.name());
        claims.variational.as_ref().map(of)
    },
    needs_claim: true,
    judge: slopes::variational,
};

/// What is the same elsewhere, later or again.
pub const EQUIVARIANCE: MethodLaw = MethodLaw {
    about: About {
        name: "method-equivariance",
        statement: "Φ(kg, μ) = (k g', μ') for k ∈ G; without explicit time Φ does not see t; asked again, Φ answers the same",
        source: "Marsden and Ratiu 1999, §13.5: reduction by left translations; equations on g* do not know g",
        oracle: "the method's own answer from the translated state",
        bound: ROUNDING,
        ..ABOUT
    },
    cases: |base| base,
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| setup.settle(claims, symmetry::equivariance, symmetry::equivariance),
};

/// What is the same in another basis.
pub const PRESENTATION: MethodLaw = MethodLaw {
    about: About {
        name: "method-presentation",
        statement: "in another basis e'_a = e_b B^b_a of g the same step: Φ'(μ B) = Φ(μ) B, and the same g",
        source: "the equations have no preferred basis: Marsden and Ratiu 1999, §13.1 and §13.5",
        oracle: "the method's own answer on the transformed description",
        bound: ROUNDING,
        ..ABOUT
    },
    cases: |base| base,
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| setup.settle(claims, symmetry::presentation, symmetry::presentation),
};

/// The step as a function of its length.
pub const SMOOTHNESS: MethodLaw = MethodLaw {
    about: About {
        name: "method-smoothness",
        statement: "h ↦ Φ_h(t, μ, g) is smooth: its Chebyshev coefficients on [H/8, H] that a smooth function does not have are \
                    rounding",
        source: "Trefethen 2013, Approximation Theory and Approximation Practice, Thm 8.1: coefficients of analytic functions fall \
                 geometrically; Hairer, Lubich and Wanner 2006, VIII.6, on iterations that stop early",
        oracle: "the method's own answers at 24 lengths, 48 in 32 digits; where they are not smooth, at lengths up to H/2 and H/4 as well",
        bound: ROUNDING,
        ..ABOUT
    },
    cases: Cases::showing_order,
    claim: |_| None,
    needs_claim: false,
    judge: |setup, claims| setup.settle(claims, smoothness::smooth, smoothness::smooth),
};

/// The laws.
pub const LAWS: &[MethodLaw] = &[
    ORDER,
    CASIMIRS,
    ENERGY,
    REVERSIBILITY,
    MOMENTUM,
    CONSERVES_CASIMIRS,
    CONSERVES_ENERGY,
    CONSERVES_MOMENTUM,
    NOETHER,
    POISSON,
    VARIATIONAL,
    EQUIVARIANCE,
    PRESENTATION,
    SMOOTHNESS,
];

impl MethodLaw {
    /// The cases that the law is checked on, of those that `base` admits.
    pub fn cases(&self, base: Cases) -> Cases {
        (self.cases)(base)
    }

    /// The claim that this law judges, where it is made: `order 4`, `conserves casimirs`, `conserves energy`, `conserves momentum`,
    /// `conserves poisson`, `variational gauss-2 with exp`, `reversible`.
    pub fn claim(&self, claims: &Claims) -> Option<String> {
        (self.claim)(claims)
    }

    /// Whether it says nothing where its claim is not made.
    pub fn needs_claim(&self) -> bool {
        self.needs_claim
    }
}

/// The law called `name`.
pub fn named(name: &str) -> Option<&'static MethodLaw> {
    LAWS.iter().find(|law| law.about.name == name)
}

/// A method, to be made for the systems of a source: described ones, or those of a user's own types.
///
/// A typed [`OneStep`](crate::integrators::OneStep) becomes a [`Stepper`] by [`Untyped`].
///
/// ```
/// use euler_poincare::integrators::StepError;
/// use euler_poincare::laws::method::{
///     Claims, MethodLaw, MethodSource, Outcome, Point, Stage, Stepper, Untyped, check_case, named,
/// };
/// use euler_poincare::study::problem;
/// use euler_poincare::system::Case;
///
/// /// Nothing ever moves.
/// struct Still;
///
/// impl Stepper<f64> for Still {
///     fn step(&mut self, point: &Point<f64>, h: f64) -> Result<Point<f64>, StepError> {
///         Ok(Point { time: point.time + h, ..point.clone() })
///     }
///
///     /// For the claim of stages, which it does not make.
///     fn stages(&self, _: &Point<f64>, _: f64) -> Option<Vec<Stage<f64>>> {
///         None
///     }
/// }
///
/// impl MethodSource for Still {
///     fn double<'a>(&'a self, _: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
///         Ok(Box::new(Still)) // a typed method becomes a stepper as `Untyped(method)`
///     }
/// }
///
/// let law: &MethodLaw = named("method-order").expect("a law");
/// let claims = Claims { order: Some(1), ..Claims::default() };
/// let outcome: Outcome = check_case(law, &Still, &problem::generic()?.case, &claims);
/// assert!(!outcome.verdict.holds(), "{}", outcome.verdict);
/// # let _ = Untyped::<Still, 3, 3>(Still);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait MethodSource<S = Case> {
    /// The method on a system.
    ///
    /// # Errors
    /// [`StepError::Unsupported`] where it does not apply: that switches the case off.
    fn double<'a>(&'a self, system: &S) -> Result<Box<dyn Stepper<f64> + 'a>, StepError>;

    /// The same in 32 digits, where the method has them.
    fn quad<'a>(&'a self, _system: &S) -> Option<Result<Box<dyn Stepper<Dd> + 'a>, StepError>> {
        None
    }

    /// What its state is.
    fn form(&self) -> StateForm {
        StateForm::default()
    }

    /// Whether it knows a system, as far as it has said so: the others are not asked about.
    fn knows(&self, _system: &S) -> bool {
        true
    }

    /// A system that it knows instead of another one of the same algebra; `None` where there is none.
    fn adapted(&self, system: S) -> Option<S> {
        self.knows(&system).then_some(system)
    }
}

/// Another setup; `None` where there is none.
type OtherSetup<'a> = Result<Option<Setup<'a>>, StepError>;

/// That in another basis, with B by rows.
type Presented<'a> = (OtherSetup<'a>, Vec<Vec<f64>>);

/// What a law of methods is checked on.
struct Setup<'a> {
    /// The system.
    theory: Box<dyn Theory<f64>>,
    /// The system in 32 digits.
    known: Box<dyn Theory<Dd>>,
    /// The method in 16 digits.
    method: RefCell<Box<dyn Stepper<f64> + 'a>>,
    /// The method in 32 digits, where it has them.
    quad: Option<RefCell<Box<dyn Stepper<Dd> + 'a>>>,
    /// The same in another basis.
    presented: Box<dyn Fn() -> Presented<'a> + 'a>,
    /// The k-th other system that such a method is asked on, where this one hides its order.
    other: Box<dyn Fn(i64) -> OtherSetup<'a> + 'a>,
    /// The variational scheme of a tableau and a retraction on the system.
    #[allow(clippy::type_complexity, reason = "one function, named by its field")]
    scheme: Box<dyn Fn(&Method) -> Result<Scheme, StepError> + 'a>,
}

/// Builds the [`Theory`] of a case.
struct Build(StateForm);

impl<T: Real> Visitor<T> for Build {
    type Output = Box<dyn Theory<T>>;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Self::Output {
        Box::new(SystemParts::of(system, self.0))
    }
}

/// What the theory knows about a system, for a method with this state.
///
/// # Errors
/// A system that cannot be built.
#[doc(hidden)]
pub fn theory_of<T: Real>(source: &impl Source, form: &StateForm) -> Result<Box<dyn Theory<T>>, CaseError> {
    source.visit::<T, _>(&Plant(None), Build(form.clone()))
}

/// Why there is no setup: the case cannot be built, or the method does not apply.
enum SetupError {
    Case(CaseError),
    Method(StepError),
}

impl<'a> Setup<'a> {
    /// The setup of a method on a system of any source, with its other bases and its variations.
    fn of<S: Source>(source: &S, subject: &'a dyn MethodSource<S>) -> Result<Self, SetupError> {
        let form = subject.form();
        let theory = theory_of::<f64>(source, &form).map_err(SetupError::Case)?;
        let method = RefCell::new(subject.double(source).map_err(SetupError::Method)?);
        let known = theory_of::<Dd>(source, &form).map_err(SetupError::Case)?;
        let quad = subject.quad(source).transpose().map_err(SetupError::Method)?.map(RefCell::new);
        let again = |other: S| match Setup::of(&other, subject) {
            Ok(setup) => Ok(Some(setup)),
            Err(SetupError::Method(error)) => Err(error),
            Err(SetupError::Case(_)) => Ok(None),
        };
        let [given, varied, claimed] = [(); 3].map(|()| source.clone());
        let presented = move || match given.presented().filter(|(other, _)| subject.knows(other)) {
            Some((other, basis)) => (again(other), basis),
            None => (Ok(None), Vec::new()),
        };
        let other = move |k| varied.other(k).and_then(|other| subject.adapted(other)).map_or(Ok(None), again);
        let scheme = move |method: &Method| Scheme::of(&claimed, method, &form);
        let (presented, other, scheme) = (Box::new(presented), Box::new(other), Box::new(scheme));
        Ok(Self { theory, known, method, quad, presented, other, scheme })
    }

    /// An identity in the precisions that the method has, `double` and `quad`, judged by how its defect scales with round-off.
    fn settle(&self, claims: &Claims, double: OnView<f64>, quad: OnView<Dd>) -> Judged {
        let measured = |answer: Answer| answer.unwrap_or_else(|refused| refused);
        let double = measured(double(&View::double(self, claims.tolerance, 0)));
        let verdict = match View::quad(self, 0) {
            Some(view) => compare(double, measured(quad(&view))),
            None => alone(16, double),
        };
        Ok(verdict.into())
    }
}

/// What holds for a step to round-off.
type OnView<T> = fn(&View<'_, '_, T>) -> Answer;

/// One side of a setup.
struct View<'s, 'a, T> {
    setup: &'s Setup<'a>,
    theory: &'s dyn Theory<T>,
    method: &'s RefCell<Box<dyn Stepper<T> + 'a>>,
    tolerance: f64,
    /// Which start: 0 is that of the system.
    from: usize,
    /// The same side of another setup.
    alike: for<'o> fn(&'o Setup<'a>) -> Option<View<'o, 'a, T>>,
}

impl<'s, 'a> View<'s, 'a, f64> {
    fn double(setup: &'s Setup<'a>, tolerance: f64, from: usize) -> Self {
        let (theory, method) = (&*setup.theory, &setup.method);
        Self { setup, theory, method, tolerance, from, alike: |other| Some(View::double(other, 0.0, 0)) }
    }
}

impl<'s, 'a> View<'s, 'a, Dd> {
    /// Where the method has 32 digits. What is claimed of its solver is about 16.
    fn quad(setup: &'s Setup<'a>, from: usize) -> Option<Self> {
        let (theory, method) = (&*setup.known, setup.quad.as_ref()?);
        Some(Self { setup, theory, method, tolerance: 0.0, from, alike: |other| View::quad(other, 0) })
    }
}

impl<T: Real> View<'_, '_, T> {
    /// Where a law starts: where the system does, or at the k-th other state, of which the components of the momentum are multiplied by
    /// numbers from 11/16 to 21/16, set where they are all 0, and with other signs: those of the second, fourth, …, of the first, third,
    /// …, or of all.
    ///
    /// With the same signs the starts are too much alike: where the leading term of an error is small at one, it is at the others.
    /// A change of sign turns the terms of odd degree in the momentum against those of even degree.
    fn start(&self) -> Point<T> {
        let (start, k) = (self.theory.start(), self.from);
        if k == 0 {
            return start;
        }
        let number = |a: usize| T::ratio(((7 * a + 3 * k) % 11) as i64 - 5, 16);
        let sign = |a: usize| if (k >> ((a + 1) % 2)) & 1 == 1 { -T::one() } else { T::one() };
        let rest = start.momentum.iter().all(|x| *x == T::zero());
        let moved = |(a, x): (usize, &T)| if rest { number(a) } else { *x * sign(a) * (T::one() + number(a)) };
        Point { momentum: start.momentum.iter().enumerate().map(moved).collect(), ..start }
    }

    /// A step of the method.
    fn step(&self, point: &Point<T>, h: T) -> Result<Point<T>, StepError> {
        let next = self.method.borrow_mut().step(point, h)?;
        let alike = (next.momentum.len(), next.attitude.len()) == (point.momentum.len(), point.attitude.len());
        match (alike, next.is_finite()) {
            (true, true) => Ok(next),
            // A step larger than that of the system is one that no user wants: there a method may diverge.
            (true, false) if h.abs() > self.theory.step().abs() => {
                Err(StepError::Refused { step: h.to_f64(), why: levels::DIVERGES.into() })
            }
            _ => Err(StepError::NoAnswer { why: "the state after the step is not finite, or not of its size".into() }),
        }
    }

    /// What rounding, or the claimed tolerance, may do in `steps` steps, relative.
    fn noise(&self, steps: usize) -> T {
        T::int(steps as i64) * (T::unit_roundoff() * T::int(64)).max(T::exact(self.tolerance))
    }

    /// A floor in units of u that leaves room for the claimed tolerance.
    fn floor(&self, floor: f64) -> f64 {
        floor.max(16.0 * self.tolerance / T::unit_roundoff().to_f64() / AGREEMENT)
    }
}

/// The largest |x − y|, and the largest |x|, |y|.
pub(crate) fn difference<T: Real>(x: &[T], y: &[T]) -> (T, T) {
    x.iter().zip(y).fold((T::zero(), T::zero()), |(defect, size), (x, y)| {
        (larger(defect, (*x - *y).abs()), larger(larger(size, x.abs()), y.abs()))
    })
}

/// A verdict, and what it rests on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// The verdict.
    pub verdict: Verdict,
    /// The slope that decides, less what local errors have in excess.
    pub slope: Option<Estimate>,
    /// The errors that were measured, where the law asks for a slope: those of the system that decided.
    pub findings: Option<Findings>,
    /// Which of their quantities decided, where one did.
    pub deciding: Option<usize>,
    /// The number of the other system ([`other`](crate::study::problem::other)) that decided, where the one that was asked about did not.
    pub decided_by: Option<i64>,
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        Self { verdict, slope: None, findings: None, deciding: None, decided_by: None }
    }
}

/// What a law finds, or the verdict where it cannot look.
type Judged = Result<Outcome, Verdict>;

/// What a step error means to a law that asks for a slope.
pub(super) fn without(error: StepError) -> Verdict {
    alone(16, error.into())
}

/// Judges a method by a law on a system of any source: with its other bases, where it has them.
pub fn check_case<S: Source>(law: &MethodLaw, subject: &dyn MethodSource<S>, source: &S, claims: &Claims) -> Outcome {
    let judged = match Setup::of(source, subject) {
        Ok(_) if law.needs_claim && law.claim(claims).is_none() => Err(Verdict::not_applicable("it is not claimed")),
        Ok(setup) => (law.judge)(&setup, claims),
        Err(SetupError::Method(error)) => Err(without(error)),
        Err(SetupError::Case(error)) => Err(unbuilt(&error)),
    };
    judged.unwrap_or_else(Outcome::from)
}
