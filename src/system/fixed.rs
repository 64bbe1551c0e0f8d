//! Parts of a case that the user has chosen: everything else stays random.

use super::case::{Algebra, Case, Force, Lagrangian, Motion, Start};
use crate::scalar::Number;

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
        lagrangian && start && self.forces.iter().flatten().all(|force: &Force| force.fits(n))
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
