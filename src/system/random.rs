//! Random cases: a proptest strategy with knobs.
//!
//! Cases are valid by construction, with steps small enough for their rates, and shrink towards ℝ¹ or the smallest
//! algebra that the knobs admit, its standard basis, unit inertia, no force, one stage and the smallest step.

use super::case::{Case, Force, Structure, Tau};
use super::generate::{self, Draw};
use super::rates::Rates;
use super::shrink;
use crate::algebra::catalogue::Entry;
use crate::tableau::{Classic, Description};
use proptest::strategy::{BoxedStrategy, NewTree, Strategy, Union, ValueTree};
use proptest::test_runner::TestRunner;

pub use super::labels::labels;

/// Which forces are generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Forcing {
    /// None in a quarter of the cases.
    Any,
    /// None.
    Free,
    /// At least one that does not vanish identically.
    Forced,
}

/// The strategy for cases; each method fixes a part. Build one with [`cases`].
#[derive(Clone, Debug)]
pub struct Cases {
    pub(super) algebras: Option<Vec<Entry>>,
    pub(super) with_group: bool,
    pub(super) nonabelian: bool,
    pub(super) most: usize,
    pub(super) main_dimensions: bool,
    pub(super) changed_basis: Option<bool>,
    pub(super) forcing: Forcing,
    pub(super) smooth: bool,
    pub(super) quadratic: bool,
    pub(super) retraction: Option<Tau>,
    pub(super) exponents: (u32, u32),
    tableaux: BoxedStrategy<Description>,
}

/// All cases: every algebra of the catalogue, products and algebras by constants; bases; inertias; forces; tableaux;
/// retractions; states; steps 1/4 to 1/64.
pub fn cases() -> Cases {
    Cases {
        algebras: None,
        with_group: false,
        nonabelian: false,
        most: super::case::MAX_DIMENSION,
        main_dimensions: false,
        changed_basis: None,
        forcing: Forcing::Any,
        smooth: false,
        quadratic: false,
        retraction: None,
        exponents: (2, 6),
        tableaux: tableaux(),
    }
}

/// Any tableau, with the classical ones (a twentieth of the named) at a fair share.
///
/// Built once for each thread: the list of collocation tableaux behind it takes longer than a case.
fn tableaux() -> BoxedStrategy<Description> {
    thread_local! {
        static ANY: BoxedStrategy<Description> = {
            let classic = proptest::sample::select(Classic::DRAWN.to_vec()).prop_map(Description::Classic);
            Union::new_weighted(vec![(24, crate::tableau::random::any()), (1, classic.boxed())]).boxed()
        };
    }
    ANY.with(Clone::clone)
}

impl Cases {
    /// Only these algebras, with equal weights.
    pub fn algebras(mut self, entries: &[Entry]) -> Self {
        self.algebras = Some(entries.to_vec());
        self
    }

    /// Only algebras with a group: no algebras by constants alone.
    pub fn with_group(mut self) -> Self {
        self.with_group = true;
        self
    }

    /// No abelian algebras.
    pub fn nonabelian(mut self) -> Self {
        self.nonabelian = true;
        self
    }

    /// Only algebras of dimension at most `n` (1 to 8).
    pub fn dimension_at_most(mut self, n: usize) -> Self {
        self.most = n.clamp(1, super::case::MAX_DIMENSION);
        self
    }

    /// Only algebras of dimension 2, 3, 4 and 6 ([`MAIN_DIMENSIONS`](super::case::MAIN_DIMENSIONS)), which
    /// [`Case::dispatch_main_with`] admits.
    pub fn main_dimensions(mut self) -> Self {
        self.main_dimensions = true;
        self
    }

    /// Whether the knobs admit this dimension.
    pub(super) fn admits_dimension(&self, n: usize) -> bool {
        (1..=self.most).contains(&n) && (!self.main_dimensions || super::case::MAIN_DIMENSIONS.contains(&n))
    }

    /// Only standard bases (`false`), or only changed ones (`true`).
    pub fn changed_basis(mut self, changed: bool) -> Self {
        self.changed_basis = Some(changed);
        self
    }

    /// No force.
    pub fn force_free(mut self) -> Self {
        self.forcing = Forcing::Free;
        self
    }

    /// Whether only systems without force are drawn.
    pub fn is_force_free(&self) -> bool {
        self.forcing == Forcing::Free
    }

    /// At least one force that does not vanish identically.
    pub fn forced(mut self) -> Self {
        self.forcing = Forcing::Forced;
        self
    }

    /// Forced, and on an algebra that is not abelian.
    pub fn forced_nonabelian(self) -> Self {
        self.forced().nonabelian()
    }

    /// Only forces that are smooth everywhere (quadratic drag is not, at rest): what order tests need.
    pub fn smooth(mut self) -> Self {
        self.smooth = true;
        self
    }

    /// Only quadratic Lagrangians.
    pub fn quadratic(mut self) -> Self {
        self.quadratic = true;
        self
    }

    /// Only this retraction; Cayley implies a group.
    pub fn retraction(mut self, tau: Tau) -> Self {
        self.retraction = Some(tau);
        self.with_group |= tau == Tau::Cayley;
        self
    }

    /// Tableaux from this strategy.
    pub fn with_tableaux(mut self, tableaux: impl Strategy<Value = Description> + 'static) -> Self {
        self.tableaux = tableaux.boxed();
        self
    }

    /// Steps 2^−largest to 2^−smallest, before they are made smaller (down to the latter) for fast cases.
    pub fn steps(mut self, largest: u32, smallest: u32) -> Self {
        self.exponents = (largest.min(30), smallest.clamp(largest.min(30), 30));
        self
    }

    /// Whether a case has all that the knobs ask for (the tableau is not looked at).
    pub fn admits(&self, case: &Case) -> bool {
        let abelian = super::labels::abelian(&case.algebra);
        let entry = match &case.algebra.structure {
            Structure::Named(entry) => Some(entry),
            Structure::Constants { .. } => None,
        };
        let forced = case.forces.iter().any(|force| !shrink::vanishes(force, abelian));
        self.algebras.as_ref().is_none_or(|allowed| entry.is_some_and(|entry| allowed.contains(entry)))
            && (!self.with_group || entry.is_some())
            && !(self.nonabelian && abelian)
            && self.admits_dimension(case.dimension())
            && self.changed_basis.is_none_or(|changed| changed == case.algebra.basis.is_some())
            && (self.forcing != Forcing::Free || case.forces.is_empty())
            && (self.forcing != Forcing::Forced || forced)
            && !(self.smooth && case.forces.iter().any(|force| matches!(force, Force::QuadraticDrag(_))))
            && !(self.quadratic && case.lagrangian.quartic.is_some())
            && (self.retraction.is_none_or(|tau| tau == case.method.retraction) || entry.is_none())
            && (self.forcing != Forcing::Forced || Rates::of(case).is_some_and(|rates| rates.driven()))
    }
}

/// How many draws are tried before the knobs are declared to exclude everything.
const ATTEMPTS: usize = 200;

impl Strategy for Cases {
    type Tree = CaseTree;
    type Value = Case;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let tableau = self.tableaux.new_tree(runner)?;
        for _ in 0..ATTEMPTS {
            let drawn = generate::case(&mut Draw(runner.rng()), self, tableau.current());
            if let Some(case) = drawn.filter(|case| self.admits(case)) {
                return Ok(CaseTree {
                    knobs: self.clone(),
                    best: case.clone(),
                    current: case,
                    tableau,
                    tableau_done: false,
                    candidates: Vec::new().into_iter(),
                });
            }
        }
        Err("the knobs exclude every case".into())
    }
}

/// A case and the way to simpler ones: first its tableau, by the tree of its strategy; then everything else, by
/// candidates that depend on the case alone.
pub struct CaseTree {
    knobs: Cases,
    best: Case,
    current: Case,
    tableau: Box<dyn ValueTree<Value = Description>>,
    tableau_done: bool,
    candidates: std::vec::IntoIter<Case>,
}

impl CaseTree {
    fn with_tableau(&self) -> Case {
        let mut case = self.best.clone();
        case.method.tableau = self.tableau.current();
        case
    }

    /// The next candidate, or back to the best case.
    fn next(&mut self) -> bool {
        for candidate in self.candidates.by_ref() {
            if self.knobs.admits(&candidate) && shrink::sound(&candidate) {
                self.current = candidate;
                return true;
            }
        }
        self.current = self.best.clone();
        false
    }

    fn restart(&mut self) -> bool {
        self.tableau_done = true;
        self.candidates = shrink::candidates(&self.best, 1 << self.knobs.exponents.1).into_iter();
        self.next()
    }
}

impl ValueTree for CaseTree {
    type Value = Case;

    fn current(&self) -> Case {
        self.current.clone()
    }

    fn simplify(&mut self) -> bool {
        self.best = self.current.clone();
        if !self.tableau_done && self.tableau.simplify() {
            self.current = self.with_tableau();
            return true;
        }
        self.restart()
    }

    fn complicate(&mut self) -> bool {
        if self.tableau_done {
            return self.next();
        }
        if self.tableau.complicate() {
            self.current = self.with_tableau();
            return true;
        }
        self.restart()
    }
}
