//! Errors at T for step sizes h = 1, ½, ¼, …

use super::reference::{casimir, energy};
use super::{ExperimentError, Method, Problem, Reference};
use crate::harness::parallel;
use crate::integrators::{StepError, trajectory};
use crate::scalar::{Dd, Real, convert};
use crate::study::{Findings, Reading, Row};
use nalgebra::ComplexField;

/// The finest step of the table is 2⁻⁸ = 1/256.
pub const FINEST: u32 = 8;

/// What is compared at T: |M − M(T)|, the 2-norm; |E − E(T)|; |C − C(T)| with C = |M|².
pub const QUANTITIES: [&str; 3] = ["momentum", "energy", "Casimir"];

/// How far the trajectories of a method are from the reference at T.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Errors {
    /// The problem.
    pub problem: Problem,
    /// The method.
    pub method: Method,
    /// `f64` or `dd`.
    pub scalar: &'static str,
    /// The errors of the [quantities](QUANTITIES), the largest step first.
    pub findings: Findings,
}

/// The errors at T = 1 of a method with h = 2^−level in the scalar `T`; none where a step has no root.
///
/// They are differences taken in 32 digits, whatever `T` is.
///
/// # Errors
/// A step that fails for another reason than a fold; no such tableau.
pub fn errors<T: Real>(reference: &Reference, method: Method, level: u32) -> Result<Row, ExperimentError> {
    let problem = reference.problem;
    let mut integrator = method.on::<T>(problem)?;
    let mut state = problem.state::<T>();
    let (steps, h) = (1 << level, 0.5f64.powi(level as i32));
    let readings = match trajectory::integrate(&mut integrator, &mut state, T::exact(h), steps, |_, _, _| {}) {
        Ok(_) => {
            let momentum = state.momentum.map(convert);
            let errors = [
                casimir(&(momentum - reference.momentum)).sqrt(),
                energy(&reference.model.system, &momentum)? - reference.energy,
                casimir(&momentum) - reference.casimir,
            ];
            let none = Dd::exact(0.0);
            Ok(errors.map(|error| Reading::new(error.abs(), none, none)).to_vec())
        }
        Err(failed) if matches!(failed.source, StepError::Fold { .. }) => Err(failed.source),
        Err(failed) => return Err(problem.failed(method, T::exact(h))(failed)),
    };
    Ok(Row { steps, h, readings })
}

/// The errors of each method on a problem, in `f64` and in 32 digits, h = 1, …, 2^−finest.
///
/// In parallel; `tick` is called after each of the 2 · methods · (finest + 1) runs.
///
/// # Errors
/// Those of [`errors`].
pub fn table(
    reference: &Reference,
    methods: &[Method],
    finest: u32,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Errors>, ExperimentError> {
    let columns = || methods.iter().flat_map(|&method| [f64::NAME, Dd::NAME].map(|scalar| (method, scalar)));
    let runs: Vec<_> =
        columns().flat_map(|(method, scalar)| (0..=finest).map(move |level| (method, scalar, level))).collect();
    let rows = parallel(runs.len(), |k| {
        let (method, scalar, level) = runs[k];
        let row = if scalar == Dd::NAME { errors::<Dd> } else { errors::<f64> }(reference, method, level)?;
        tick();
        Ok(row)
    });
    let rows = rows.into_iter().collect::<Result<Vec<_>, ExperimentError>>()?;
    let column = |((method, scalar), rows): ((Method, &'static str), &[Row])| {
        let mut findings = Findings::new(QUANTITIES.map(str::to_owned).to_vec(), QUANTITIES.len());
        rows.iter().for_each(|row| findings.push(row.clone()));
        Errors { problem: reference.problem, method, scalar, findings }
    };
    Ok(columns().zip(rows.chunks(finest as usize + 1)).map(column).collect())
}
