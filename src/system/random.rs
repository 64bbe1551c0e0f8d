//! Random cases: a proptest strategy with knobs.
//!
//! Cases are valid by construction, with steps small enough for their rates, and shrink towards ℝ¹ or the smallest
//! algebra that the knobs admit, its standard basis, unit inertia, no force, one stage and the smallest step.

use super::case::{Algebra, Case, Force, Lagrangian, Potential, Start, Structure, Tau};
use super::fixed::Fixed;
use super::rates::Rates;
use super::restriction::Restriction;
use crate::algebra::catalogue::Entry;
use crate::scalar::Number;
use crate::tableau::{Classic, Description};
use proptest::strategy::{BoxedStrategy, Just, Strategy, Union};
use std::fmt;
use std::sync::Arc;

pub use super::labels::labels;

/// Exponents of the largest and of the smallest step 2⁻ᵏ, where nothing else is asked for.
pub(super) const USUAL_STEPS: (u32, u32) = (2, 6);

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

/// What is found of a case, if anything.
type OfCase<T> = Arc<dyn Fn(&Case) -> Option<T> + Send + Sync>;

/// What is not drawn, because a user's own types give it.
#[derive(Clone)]
pub(crate) struct Given {
    /// The algebra: [`Structure::Given`].
    pub structure: Structure,
    /// Whether the Lagrangian is given.
    pub lagrangian: bool,
    /// Whether the force is given.
    pub force: bool,
    /// The rates of a case on these types.
    pub rates: OfCase<Rates>,
}

impl fmt::Debug for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} of a user", self.structure)
    }
}

/// The strategy for cases; each method fixes a part. Build one with [`cases`].
///
/// ```
/// use euler_poincare::algebra::Entry;
/// use euler_poincare::system::replay::Replay;
/// use euler_poincare::system::shares::{SHARES, Share};
/// use euler_poincare::system::{Cases, cases, labels};
/// use proptest::strategy::{Strategy, ValueTree};
/// use proptest::test_runner::TestRunner;
///
/// // Random cases, here: forced, on so(3) or se(3), in the catalogue's basis.
/// let bodies: Cases = cases().algebras(&[Entry::So3, Entry::Se3]).forced().changed_basis(false);
/// let case = bodies.new_tree(&mut TestRunner::deterministic()).expect("a case").current();
/// assert!(bodies.admits(&case) && case.check().is_ok());
///
/// // What it is an example of; the shares of all cases are declared.
/// assert!(labels(&case).iter().any(|(category, label)| *category == "algebra" && (label == "so3" || label == "se3")));
/// let share: &Share = SHARES.iter().find(|share| (share.category, share.label) == ("algebra", "so3")).expect("so(3)");
/// assert!(share.least <= share.most);
///
/// // As a file, for `replay`.
/// let replay = Replay { module: None, law: "energy-balance".into(), seed: 1, index: 0, fault: None, case };
/// assert_eq!(Replay::from_json(&replay.to_json()?)?, replay);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cases {
    pub(super) algebras: Option<Vec<Entry>>,
    pub(super) with_group: bool,
    pub(super) with_casimirs: bool,
    pub(super) nonabelian: bool,
    pub(super) most: usize,
    pub(super) main_dimensions: bool,
    pub(super) changed_basis: Option<bool>,
    pub(super) forcing: Forcing,
    pub(super) potentials: Vec<&'static str>,
    pub(super) smooth: bool,
    pub(super) showing_order: bool,
    pub(super) quadratic: bool,
    pub(super) kinetic: bool,
    pub(super) fast: bool,
    pub(super) retraction: Option<Tau>,
    pub(super) exponents: (u32, u32),
    pub(super) given: Option<Given>,
    pub(super) fixed: Fixed,
    pub(super) restriction: Restriction,
    pub(super) tableaux: BoxedStrategy<Description>,
    pub(super) image: Image,
}

/// What is made of a case that was drawn; itself where nothing is.
#[derive(Clone, Default)]
pub(super) struct Image(Option<Arc<dyn Fn(Case) -> Case + Send + Sync>>);

impl Image {
    pub fn of(&self, case: Case) -> Case {
        match &self.0 {
            Some(image) => image(case),
            None => case,
        }
    }
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "an image" } else { "the case itself" })
    }
}

/// All cases: every algebra of the catalogue, products and algebras by constants; bases; Lagrangians; forces; tableaux;
/// retractions; states; steps 1/4 to 1/64.
pub fn cases() -> Cases {
    Cases {
        algebras: None,
        with_group: false,
        with_casimirs: false,
        nonabelian: false,
        most: super::case::MAX_DIMENSION,
        main_dimensions: false,
        changed_basis: None,
        forcing: Forcing::Any,
        potentials: Vec::new(),
        smooth: false,
        showing_order: false,
        quadratic: false,
        kinetic: false,
        fast: false,
        retraction: None,
        exponents: USUAL_STEPS,
        given: None,
        fixed: Fixed::default(),
        restriction: Restriction::default(),
        tableaux: tableaux(),
        image: Image::default(),
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

/// All cases, see [`cases`].
impl Default for Cases {
    fn default() -> Self {
        cases()
    }
}

impl Cases {
    /// Only these algebras, with equal weights.
    pub fn algebras(mut self, entries: &[Entry]) -> Self {
        self.algebras = Some(entries.to_vec());
        self
    }

    /// Of the algebras that there are, only these.
    pub(crate) fn among(mut self, entries: &[Entry]) -> Self {
        self.algebras = Some(match self.algebras {
            Some(mut allowed) => {
                allowed.retain(|entry| entries.contains(entry));
                allowed
            }
            None => entries.to_vec(),
        });
        self
    }

    /// A user's own algebra and group, and what else is given; the knobs on algebras and on τ do nothing then.
    pub(crate) fn given(mut self, given: Given) -> Self {
        self.given = Some(given);
        self
    }

    /// The rates of a case.
    pub(super) fn rates(&self, case: &Case) -> Option<Rates> {
        self.given.as_ref().map_or_else(|| Rates::of(case), |given| (given.rates)(case))
    }

    /// Only algebras with a group: no algebras by constants alone.
    pub fn with_group(mut self) -> Self {
        self.with_group = true;
        self
    }

    /// Only algebras that are not abelian and have Casimirs that are known.
    pub fn with_casimirs(mut self) -> Self {
        self.with_casimirs = true;
        self.nonabelian()
    }

    /// No abelian algebras.
    pub fn nonabelian(mut self) -> Self {
        self.nonabelian = true;
        self
    }

    /// Only algebras of dimension at most `n` (1 to 10).
    pub fn dimension_at_most(mut self, n: usize) -> Self {
        self.most = n.clamp(1, super::case::MAX_DIMENSION);
        self
    }

    /// Only algebras of dimension up to 6 ([`MAIN_DIMENSIONS`](super::case::MAIN_DIMENSIONS)), which every law knows.
    pub fn main_dimensions(mut self) -> Self {
        self.main_dimensions = true;
        self
    }

    /// Whether the knobs admit this dimension.
    pub(super) fn admits_dimension(&self, n: usize) -> bool {
        self.fixed.fits(n)
            && self.restriction.has_dimension(n)
            && (1..=self.most).contains(&n)
            && (!self.main_dimensions || super::case::MAIN_DIMENSIONS.contains(&n))
    }

    /// Only standard bases (`false`), or only changed ones (`true`).
    pub fn changed_basis(mut self, changed: bool) -> Self {
        self.changed_basis = Some(changed);
        self
    }

    /// No force.
    pub(crate) fn without_force(mut self) -> Self {
        self.forcing = Forcing::Free;
        self
    }

    /// No force, and no potential.
    pub fn force_free(self) -> Self {
        let mut free = self.without_force();
        free.potentials.clear();
        free
    }

    /// Systems with potentials, too: one or two of these [kinds](Potential::KINDS) in half of the cases. Those of bodies are drawn on so(3)
    /// and se(3); `formula` is a bounded function of entries of g, on any group. Without this knob there are none.
    pub fn potentials(mut self, kinds: &[impl AsRef<str>]) -> Self {
        let known = |name: &&'static str| kinds.iter().any(|kind| kind.as_ref() == *name);
        self.potentials = Potential::KINDS.into_iter().filter(known).collect();
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

    /// Only motions that show the order of a method, with forces that show its errors: of size about 1, not nearly steady (but
    /// without force on an abelian algebra, where all are), and with quadratic drag only away from rest, where it is smooth.
    /// Drag and matrices without symmetry are drawn more often than else, and several forces at once.
    pub fn showing_order(mut self) -> Self {
        self.showing_order = true;
        self
    }

    /// Only Lagrangians l(η) = ½⟨Iη, η⟩.
    pub fn quadratic(mut self) -> Self {
        self.quadratic = true;
        self
    }

    /// Only Lagrangians l(η) = ½ q + ¼ κ q² with q = ⟨Iη, η⟩ and I positive definite: no gyrostat terms, no metric of their own, no
    /// indefinite inertias.
    pub fn kinetic(mut self) -> Self {
        self.kinetic = true;
        self
    }

    /// Only what [`integrators::lanes`](crate::integrators::lanes) have a step for (up to the stages of the tableau): an algebra of the
    /// catalogue of dimension up to 6, a quadratic Lagrangian, the Cayley map, on so(3) in its standard basis also exp, and forces with a form
    /// in lanes. One case in two is on so(3) or se(3), which have closed forms.
    pub fn fast(mut self) -> Self {
        let others = Entry::NAMED.iter().filter(|entry| entry.dimension() <= 6);
        let others: Vec<_> = others.cloned().chain([Entry::Abelian(2)]).collect();
        // Where there is another retraction a case is drawn again.
        self.algebras =
            Some(others.iter().flat_map(|other| [other.clone(), Entry::So3, Entry::Se3, other.clone()]).collect());
        self.fast = true;
        self.quadratic()
    }

    /// Only this retraction, not after an odd map; Cayley implies a group.
    pub fn retraction(mut self, tau: Tau) -> Self {
        self.retraction = Some(tau);
        self.with_group |= tau.known().of_matrices;
        self
    }

    /// Only what a user's method knows.
    pub(crate) fn restricted(mut self, restriction: Restriction) -> Self {
        self.restriction = restriction;
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

    /// What `image` makes of the cases that the knobs ask for.
    pub fn mapped(mut self, image: impl Fn(Case) -> Case + Send + Sync + 'static) -> Self {
        let before = self.image;
        self.image = Image(Some(Arc::new(move |case| image(before.of(case)))));
        self
    }

    /// Whether `case` could have been drawn, its tableau apart: the knobs admit it, and it is its own image.
    pub fn could_draw(&self, case: &Case) -> bool {
        self.admits(case) && self.image.of(case.clone()) == *case
    }

    /// Whether a case has all that the knobs ask for (the tableau is not looked at).
    pub fn admits(&self, case: &Case) -> bool {
        let abelian = super::labels::abelian(&case.algebra);
        let entry = match &case.algebra.structure {
            Structure::Named(entry) => Some(entry),
            _ => None,
        };
        let forced = case.forces.iter().any(|force| !force.vanishes(abelian));
        let rates = (self.forcing == Forcing::Forced || self.showing_order).then(|| self.rates(case)).flatten();
        let algebra = match &self.given {
            Some(given) => {
                given.structure == case.algebra.structure && case.algebra.basis.is_none() && given.admits(case)
            }
            None => {
                self.algebras.as_ref().is_none_or(|allowed| entry.is_some_and(|entry| allowed.contains(entry)))
                    && (!self.with_group || case.matrix_size() > 0)
                    && (!self.with_casimirs || case.casimir_count() > 0)
                    && super::dispatch::has_class(case.dimension(), case.matrix_size(), self.main_dimensions)
                    && self.retraction.is_none_or(|tau| case.algebra.structure.admits(tau))
                    && (case.matrix_size() == 0 || case.algebra.structure.admits(case.method.retraction))
                    && self.admits_dimension(case.dimension())
                    && self.changed_basis.is_none_or(|changed| changed == case.algebra.basis.is_some())
            }
        };
        algebra
            && self.fixed.admits(case)
            && self.restriction.admits(case)
            && !(self.nonabelian && abelian)
            && (self.forcing != Forcing::Free || case.forces.is_empty())
            && (self.forcing != Forcing::Forced || forced)
            && case.potentials.iter().all(|potential| self.potentials.contains(&potential.kind()))
            && (!self.smooth || smooth(case))
            && (!self.quadratic || case.lagrangian.is_quadratic())
            && (!self.kinetic || case.lagrangian.is_kinetic())
            && (!self.fast || has_fast_step(case))
            && (self.retraction.is_none_or(|tau| tau == case.method.retraction) || case.matrix_size() == 0)
            && (self.retraction.is_none() || case.method.argument.is_empty())
            && (self.forcing != Forcing::Forced || rates.as_ref().is_some_and(|rates| rates.driven))
            && (!self.showing_order || rates.is_some_and(|rates| self.tells(case, abelian, &rates)))
    }

    /// Whether a motion is what [`Cases::showing_order`] asks for.
    fn tells(&self, case: &Case, abelian: bool, rates: &Rates) -> bool {
        let step = case.step.eval::<f64>().map_or(0.0, f64::abs);
        let dragged = !smooth(case);
        let steady = rates.unsteadiness() < UNSTEADY;
        // What the user chose is as it is.
        let chosen = self.given.is_some() || self.fixed.any() || abelian;
        (chosen || !steady) && !(dragged && step * rates.braking > BRAKED)
    }
}

/// A part that is fixed is neither drawn nor shrunk. Motions and forces that are random are still slowed down until the step is
/// small enough for them; what is fixed is taken as it is, also where it is too fast for its step.
impl Cases {
    /// Only this algebra: of the catalogue or by its constants, in its own basis or in another.
    pub fn algebra(mut self, algebra: Algebra) -> Self {
        self.fixed.algebra = Some(algebra);
        self
    }

    /// Only this Lagrangian, on algebras of its dimension.
    pub fn lagrangian(mut self, lagrangian: Lagrangian) -> Self {
        self.fixed.lagrangian = Some(lagrangian);
        self
    }

    /// Only the sum of these forces (none: no force), on algebras of their dimension.
    pub fn forces(mut self, forces: Vec<Force>) -> Self {
        self.fixed.forces = Some(forces);
        self
    }

    /// Only this initial state, on algebras of its dimension.
    pub fn start(mut self, start: Start) -> Self {
        self.fixed.start = Some(start);
        self
    }

    /// Only this step.
    pub fn step(mut self, step: Number) -> Self {
        self.fixed.step = Some(step);
        self
    }

    /// Only this tableau.
    pub fn tableau(self, tableau: Description) -> Self {
        self.with_tableaux(Just(tableau))
    }
}

/// The least [`Rates::unsteadiness`] of a motion that shows an order.
const UNSTEADY: f64 = 1.0 / 32.0;

/// The largest relative change of the velocity in a step where a force is smooth away from rest only.
const BRAKED: f64 = 1.0 / 8.0;

impl Given {
    /// Whether what is given is the only one of its kind in the case.
    fn admits(&self, case: &Case) -> bool {
        (!self.force || case.forces.is_empty() || case.forces == [Force::Given])
            && (!self.lagrangian || case.lagrangian == Lagrangian::unit(case.dimension()))
    }
}

/// Whether all forces are smooth, at rest too.
fn smooth(case: &Case) -> bool {
    case.forces.iter().all(|force| force.description().smooth)
}

/// Whether the retraction and the forces have a form in lanes on the group.
fn has_fast_step(case: &Case) -> bool {
    let closed = case.algebra.structure == Structure::Named(Entry::So3)
        && case.algebra.basis.is_none()
        && case.method.retraction.closed::<f64>().is_some();
    (closed || case.method.retraction == Tau::Cayley)
        && case.method.argument.is_empty()
        && case.forces.iter().all(|force| force.description().lanes)
}
