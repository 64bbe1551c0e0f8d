//! The extremal action of a described system, as a discrete Lagrangian: with the claim that it is antisymmetric.

use super::super::user::discrete::{DiscreteLaws, OnGroup};
use super::super::user::part::{Answers, Part};
use super::Described;
use crate::discrete::StageLagrangian;
use crate::harness::{About, Cost};
use crate::mechanics::doubled::Forced;
use crate::scalar::{Dd, Real};
use crate::system::dispatch::{Main, System};
use crate::system::{Case, Cases};

/// The largest number s N of unknowns judged in 32 digits too: an evaluation of l_d is a Newton iteration.
const MOST_UNKNOWNS: usize = 3;

/// l_d of the tableau for the forced system.
fn action<T: Real, const N: usize, const D: usize>(
    system: System<T, N, D>,
) -> Option<impl Answers<T, DiscreteLaws<N, D>>> {
    let retraction = system.retraction;
    let forced = Forced::new(system.lagrangian, system.force, retraction.clone());
    let lagrangian = StageLagrangian::new(forced, retraction.clone(), system.tableau, system.step);
    Some(OnGroup { lagrangian: lagrangian.at_time(system.state.time), group: system.group?, retraction })
}

impl Described for DiscreteLaws<6, 8> {
    /// Slopes, antisymmetry and units: `discrete`, on actions and on random polynomials.
    const ELSEWHERE: usize = 3;

    /// An evaluation is an iteration of Newton's, and a law takes some fifty of them.
    const COST: Option<Cost> = Some(Cost::Expensive);

    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        // V, U and W as near to e as those of motions with a velocity of at most 1.
        let largest = double.step.abs();
        let quad = match case.unknowns() {
            Ok(unknowns) if unknowns <= MOST_UNKNOWNS => action(quad),
            _ => None,
        };
        let double = action(double)?;
        let part = match quad {
            Some(quad) => Part::at_both(double, quad),
            None => Part::in_double(double),
        };
        Some(part.antisymmetric().within(largest))
    }

    fn cases(_: &About, cases: Cases) -> Cases {
        cases.main_dimensions().with_group().forced()
    }
}
