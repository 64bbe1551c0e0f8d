//! The step under test, and states seen from its end.

use super::planted::blend;
use super::planted::step::{self, PlantedStep};
use super::planted::tableau;
use super::precision::Measured;
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::Fault;
use crate::integrators::derivative::Variation;
use crate::integrators::{OneStep, Report, State, StepError};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::Real;
use crate::system::System;
use crate::system::dispatch::Scheme;

/// The step under test: the library's, with what the plain one makes of a fault blended in.
pub(super) struct TestedMethod<'a, T: Real, const N: usize, const D: usize> {
    library: Scheme<'a, T, N, D>,
    planted: Option<(PlantedStep<'a, T, N, D>, f64)>,
}

impl<T, const N: usize, const D: usize> OneStep<T, N, D> for TestedMethod<'_, T, N, D>
where
    T: Real,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let Some((planted, size)) = &mut self.planted else { return self.library.step(state, h) };
        let mut wrong = state.clone();
        let report = planted.step(&mut wrong, h)?;
        if *size < 1.0 {
            self.library.step(state, h)?;
            wrong.momentum = blend(state.momentum, wrong.momentum, *size);
            wrong.attitude = blend(state.attitude, wrong.attitude, *size);
        }
        *state = wrong;
        Ok(report)
    }
}

impl<T: Real, const N: usize, const D: usize> TestedMethod<'_, T, N, D> {
    /// Ξ_i and η_i of the last step.
    pub(super) fn displacements_and_velocities(&self) -> Vec<[Vector<T, N>; 2]> {
        let right = self.library.stage_displacements().zip(self.library.stage_velocities());
        let right = right.map(|(displacement, velocity)| [displacement, velocity]);
        let Some((planted, size)) = &self.planted else { return right.collect() };
        let wrong = planted.displacements_and_velocities();
        if *size == 1.0 {
            return wrong.collect();
        }
        right.zip(wrong).map(|([x, eta], [y, zeta])| [blend(x, y, *size), blend(eta, zeta, *size)]).collect()
    }
}

/// The integrator of a system, with the fault planted in it if it is one of [`step::ALL`], or in its tableau.
pub(super) fn subject<'a, T: Real, const N: usize, const D: usize>(
    system: &'a System<T, N, D>,
    fault: Option<&Fault>,
) -> TestedMethod<'a, T, N, D> {
    let planted = fault.filter(|fault| step::ALL.iter().any(|known| known.name == fault.name));
    TestedMethod {
        library: system.scheme_of(tableau::planted(&system.tableau, fault)),
        planted: planted.map(|fault| (PlantedStep::new(system, Some(*fault)), fault.size)),
    }
}

/// Where states near the end of a step or a run are seen from.
pub(super) struct End<'a, T: Real, const N: usize, const D: usize> {
    group: &'a MatrixGroup<T, N, D>,
    /// g⁻¹.
    pub back: Matrix<T, D>,
    /// Of μ and g.
    pub size: T,
}

impl<'a, T: Real, const N: usize, const D: usize> End<'a, T, N, D> {
    /// From this state of a system.
    pub fn of(system: &'a System<T, N, D>, state: &State<T, N, D>) -> Result<Self, Measured> {
        let size = state.momentum.amax().max(state.attitude.amax());
        let inverted =
            |group: &'a MatrixGroup<T, N, D>| Some(Self { group, back: group.inverse(&state.attitude)?, size });
        let singular = || Measured::NotApplicable("the attitude is singular to working precision".into());
        system.group.as_ref().and_then(inverted).ok_or_else(singular)
    }

    /// (a − b)/over, left-trivialised.
    pub fn difference(&self, a: &State<T, N, D>, b: &State<T, N, D>, over: T) -> Variation<T, N> {
        Variation {
            attitude: self.group.vee(&(self.back * (a.attitude - b.attitude) / over)),
            momentum: (a.momentum - b.momentum) / over,
        }
    }
}

/// The start of a system, moved along a variation.
pub(super) fn displaced<T: Real, const N: usize, const D: usize>(
    system: &System<T, N, D>,
    along: &Variation<T, N>,
    by: T,
) -> Result<State<T, N, D>, StepError> {
    let turn = system.retraction.tau(&(along.attitude * by)).map_err(|source| outside(system, source))?;
    let State { time, momentum, attitude } = system.state;
    Ok(State { time, momentum: momentum + along.momentum * by, attitude: attitude * turn })
}

/// A group element or an algebra element outside the domain, as an error of the step of a system.
pub(super) fn outside<T: Real, const N: usize, const D: usize>(
    system: &System<T, N, D>,
    source: RetractionError,
) -> StepError {
    StepError::Domain { step: system.step.to_f64(), stage: None, source }
}

pub(super) fn show<T: Real, const N: usize>(mu: &Covector<T, N>) -> String {
    show_list(mu.as_slice())
}

pub(super) fn show_list<T: Real>(values: &[T]) -> String {
    let list: Vec<String> = values.iter().map(|v| format!("{:.17e}", v.to_f64())).collect();
    format!("({})", list.join(", "))
}
