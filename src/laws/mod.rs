//! The laws: what the theory promises, each with an independent oracle and with planted faults that it catches.
//!
//! One file per module that is judged. A law is checked on a [`Case`]; identities are evaluated twice, in `f64` and in
//! 32 digits, and judged by how the defect scales with round-off (`precision.rs`); orders are measured in 32 digits.
//!
//! | file | judges |
//! |---|---|
//! | [`retraction`] | [`crate::retraction`] |
//! | [`accuracy`] | [`crate::retraction`], [`crate::integrators`]: values in `f64` against those in 32 digits |
//! | [`groupoid`], [`algebroid`], [`poisson`] | [`crate::groupoid`] |
//! | [`lie_poisson`], [`orbits`] | [`crate::mechanics::lie_poisson`], [`crate::mechanics::equations`] |
//! | [`flow`] | [`crate::mechanics::equations`] along solutions, and [`crate::integrators`] along runs |
//! | [`mechanics`], [`euler_lagrange`], [`legendre`] | [`crate::mechanics::doubled`], its equations, its Legendre transform |
//! | [`hamiltonian`], [`two_hamiltonians`] | [`crate::mechanics::hamiltonian`], [`crate::mechanics::forced_hamiltonian`] |
//! | [`discrete`] | [`crate::discrete`] |
//! | [`integrators`], [`doubled`] | [`crate::integrators`], one step or a few |
//! | [`branch`] | [`crate::integrators::Variational`] at large steps: no root but the one that continues from h = 0 |
//! | [`solve`] | [`crate::integrators::Solve`]: results within the tolerance, between the steps too |
//! | [`configuration`] | [`crate::integrators`] with potentials and forces that depend on the attitude |
//! | [`order`], [`predicted`] | [`crate::integrators`], convergence |
//! | [`munthe_kaas`] | [`crate::integrators::MuntheKaas`], one step |
//! | [`variational_error`] | [`crate::discrete`] and [`crate::integrators`]: one order for three things |
//! | [`fast`] | [`crate::integrators::lanes`], [`crate::integrators::so3`]: the fast steps, ensembles and solvers |
//! | [`method`] | any one-step method: of this crate, of its user, of another program |
//! | [`user`] | a user's own types; `parts`: the algebra, group, Lagrangian and force of a case by the same laws |
//! | [`replay`] | nothing: a saved case under its law again |
//! | [`trial`] | nothing: the order of one tableau on one case, for the command |
//! | `derivative`, `drift`, `frames` | derivatives of a step, drift of invariants, motions in other frames |
//! | `question`, `precision`, `probe` | nothing: from a law's question to its verdict; random draws of a law |
//! | `planted`, `step` | nothing: what faults are planted in; the step under test |
//! | `instances` | nothing: the groupoids of a case, in which faults are planted |
//! | `differences` | nothing: derivatives by differences, with their errors |
//! | `polynomial` | nothing: random functions |
//! | `source` | nothing: where the systems come from that laws judge |

pub mod accuracy;
pub mod algebroid;
pub mod branch;
pub mod configuration;
mod derivative;
mod differences;
pub mod discrete;
pub mod doubled;
mod drift;
pub mod euler_lagrange;
pub mod fast;
pub mod flow;
pub mod frames;
pub mod groupoid;
pub mod hamiltonian;
mod instances;
pub mod integrators;
pub mod legendre;
pub mod lie_poisson;
pub mod mechanics;
pub mod method;
pub mod munthe_kaas;
pub mod orbits;
pub mod order;
mod parts;
#[doc(hidden)]
pub mod planted;
pub mod poisson;
mod polynomial;
mod precision;
pub mod predicted;
mod probe;
mod question;
pub mod replay;
pub mod retraction;
mod sizes;
pub mod solve;
mod source;
mod step;
pub mod trial;
pub mod two_hamiltonians;
pub mod user;
pub mod variational_error;

#[doc(hidden)]
pub use source::Source;

use crate::harness::{About, Fault, Law, Verdict};
use crate::system::dispatch::PLACED;
use crate::system::{Case, CaseError, CaseProblem, Cases, cases};
use proptest::strategy::{BoxedStrategy, Strategy};

/// A law on cases: its description, its generator and its check.
///
/// ```
/// use euler_poincare::harness::{Campaign, Law, shrink};
/// use euler_poincare::laws;
/// use euler_poincare::laws::replay::Replayed;
/// use euler_poincare::system::{Case, Replay};
///
/// let law = laws::named("retraction-adjoint").expect("a law");
/// let report = Campaign::new(7, 5).run(&[law as &dyn Law<Case>]);
/// assert!(report.holds());
///
/// // A case that was saved: judged again, here with a fault planted that the law sees.
/// let fault = law.fault("adjoint-inverted").expect("a fault");
/// let case = shrink(law, Some(fault), 7, 0, 100).expect("seen on the first case").case;
/// let replay = Replay { module: None, law: law.about.name.into(), seed: 7, index: 0, fault: Some(fault.name.into()), case };
/// let again = Replayed::of(replay, None)?;
/// assert!(again.verdict.is_broken() && again.passes(), "a planted fault has to be seen");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct CaseLaw<S = Case> {
    /// What it says.
    pub about: About,
    /// Draws cases from all, or from those that the caller restricted further.
    pub cases: fn(Cases) -> Cases,
    /// Judges one.
    pub check: fn(&S, Option<&Fault>) -> Verdict,
}

impl Law<Case> for CaseLaw {
    fn about(&self) -> &About {
        &self.about
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        (self.cases)(cases()).boxed()
    }

    fn check(&self, case: &Case, fault: Option<&Fault>) -> Verdict {
        (self.check)(case, fault)
    }

    fn simpler(&self, case: &Case, visit: &mut dyn FnMut(Case) -> bool) {
        let _ = (self.cases)(cases()).simpler(case).any(visit);
    }
}

/// What it means that a case cannot be built: an error in how it was drawn, but for a system of a user's own types that the law is not about.
pub(crate) fn unbuilt(error: &CaseError) -> Verdict {
    match &error.problem {
        CaseProblem::NotApplicable { what, .. } if *what == PLACED => Verdict::not_applicable(error.to_string()),
        _ => Verdict::broken(format!("the case cannot be built: {error}")),
    }
}

/// A law as it is asked: with a fault planted in its subject, or with none; judged in all its digits, or in some alone.
#[derive(Clone, Copy)]
pub struct PlantedLaw {
    /// The law.
    pub law: &'static CaseLaw,
    /// What is planted.
    pub fault: Option<&'static Fault>,
    /// The decimal digits of the only arithmetic that it is judged in.
    pub digits: Option<u32>,
}

impl Law<Case> for PlantedLaw {
    fn about(&self) -> &About {
        &self.law.about
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        self.law.cases()
    }

    fn check(&self, case: &Case, fault: Option<&Fault>) -> Verdict {
        let fault = fault.or(self.fault);
        match self.digits {
            None => self.law.check(case, fault),
            digits => replay::judged(self.law, fault, case, digits).0,
        }
    }

    fn simpler(&self, case: &Case, visit: &mut dyn FnMut(Case) -> bool) {
        self.law.simpler(case, visit);
    }
}

/// Every law, in the order in which they are listed.
pub fn all() -> Vec<&'static CaseLaw> {
    [
        retraction::laws(),
        accuracy::laws(),
        groupoid::laws(),
        algebroid::laws(),
        poisson::laws(),
        lie_poisson::LAWS,
        lie_poisson::laws(),
        orbits::laws(),
        flow::laws(),
        mechanics::laws(),
        euler_lagrange::laws(),
        euler_lagrange::LAWS,
        legendre::laws(),
        hamiltonian::laws(),
        two_hamiltonians::laws(),
        discrete::action::laws(),
        discrete::equations::LAWS,
        discrete::group::LAWS,
        discrete::exact::laws(),
        discrete::perturbed::LAWS,
        integrators::laws(),
        doubled::laws(),
        branch::laws(),
        solve::laws(),
        order::laws(),
        munthe_kaas::laws(),
        predicted::laws(),
        variational_error::laws(),
        method::library::LAWS,
    ]
    .into_iter()
    .flatten()
    .chain(configuration::shared())
    .chain(configuration::laws())
    .chain(drift::laws())
    .chain(frames::shared())
    .chain(frames::laws())
    .chain(derivative::laws())
    .chain(fast::laws())
    .chain(parts::laws())
    .collect()
}

/// The law called `name`.
pub fn named(name: &str) -> Option<&'static CaseLaw> {
    all().into_iter().find(|law| law.about.name == name)
}
