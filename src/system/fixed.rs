//! Parts of a case that somebody has chosen: everything else stays random.

use super::case::{Algebra, Case, Force, Lagrangian, Motion, Start};
use super::random::Cases;
use crate::scalar::Number;
use crate::tableau::Description;
use proptest::strategy::Just;

/// The parts that are the same in every case.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Fixed {
    pub algebra: Option<Algebra>,
    pub lagrangian: Option<Lagrangian>,
    pub forces: Option<Vec<Force>>,
    pub start: Option<Start>,
    pub step: Option<Number>,
}

impl Fixed {
    /// Whether there is any.
    pub fn any(&self) -> bool {
        *self != Self::default()
    }

    /// Whether a system of this dimension can have them all.
    pub fn fits(&self, n: usize) -> bool {
        let lagrangian = self.lagrangian.as_ref().is_none_or(|lagrangian| lagrangian.dimension() == n);
        let start = self.start.as_ref().is_none_or(|start| match &start.motion {
            Motion::Velocity(list) | Motion::Momentum(list) => list.len() == n,
        });
        let force = |force: &Force| force.dimension().is_none_or(|m| m == n);
        lagrangian && start && self.forces.iter().flatten().all(force)
    }

    /// Whether the case has them.
    pub fn admits(&self, case: &Case) -> bool {
        fn same<T: PartialEq>(fixed: &Option<T>, found: &T) -> bool {
            fixed.as_ref().is_none_or(|fixed| fixed == found)
        }
        same(&self.algebra, &case.algebra)
            && same(&self.lagrangian, &case.lagrangian)
            && same(&self.forces, &case.forces)
            && same(&self.start, &case.start)
            && same(&self.step, &case.step)
    }
}

/// A part that is fixed is neither drawn nor shrunk. Motions and forces that are random are still slowed down until the step is
/// small enough for them; what is fixed is taken as it is, also where it is too fast for its step.
impl Cases {
    /// Only this algebra: of the catalogue or by its constants, in its own basis or in another.
    ///
    /// ```
    /// use euler_poincare::scalar::Number;
    /// use euler_poincare::system::case::{Algebra, Constant, Structure};
    /// use euler_poincare::system::{Case, cases};
    /// use proptest::strategy::{Strategy, ValueTree};
    ///
    /// // Bianchi VII with parameter 1/2: [e_1, e_2] = e_2/2 + e_3, [e_1, e_3] = −e_2 + e_3/2.
    /// let constant = |a, b, c, value| Constant { a, b, c, value };
    /// let half = || Number::ratio(1, 2);
    /// let constants = vec![
    ///     constant(1, 2, 2, half()), constant(1, 2, 3, 1.into()),
    ///     constant(1, 3, 2, (-1).into()), constant(1, 3, 3, half()),
    /// ];
    /// let bianchi = Algebra { structure: Structure::Constants { dimension: 3, constants }, basis: None };
    /// let mine = cases().algebra(bianchi.clone()).forced();
    /// let mut runner = proptest::test_runner::TestRunner::deterministic();
    /// let case: Case = mine.new_tree(&mut runner)?.current();
    /// assert!(case.algebra == bianchi && !case.forces.is_empty());
    /// # Ok::<(), proptest::test_runner::Reason>(())
    /// ```
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
