//! Errors at T for step sizes h = 1, ½, ¼, …

use super::reference::{casimir, energy};
use super::{ExperimentError, Method, Problem, Reference};
use crate::integrators::{StepError, trajectory};
use crate::scalar::{Dd, Real, Scalar, convert};
use nalgebra::ComplexField;
use rayon::prelude::*;

/// The finest step of the table is 2⁻⁸ = 1/256.
pub const FINEST: u32 = 8;

/// How far a trajectory is from the reference at T.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Errors {
    /// |M − M(T)|, the 2-norm.
    pub momentum: f64,
    /// |E − E(T)|.
    pub energy: f64,
    /// |C − C(T)| with C = |M|².
    pub casimir: f64,
}

/// One line of the table of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// The problem.
    pub problem: Problem,
    /// The method.
    pub method: Method,
    /// `f64` or `dd`.
    pub scalar: &'static str,
    /// h = 2^−level.
    pub level: u32,
    /// The errors.
    pub errors: Errors,
}

impl Row {
    /// h, exactly.
    pub fn step(&self) -> f64 {
        step_size(self.level)
    }
}

/// 2^−level.
fn step_size(level: u32) -> f64 {
    0.5f64.powi(level as i32)
}

/// The errors at T = 1 of a method with h = 2^−level in the scalar `T`; `None` where a step has no root.
///
/// They are differences taken in 32 digits, whatever `T` is.
///
/// # Errors
/// A step that fails for another reason than a fold; no such tableau.
pub fn errors<T: Real>(reference: &Reference, method: Method, level: u32) -> Result<Option<Errors>, ExperimentError> {
    let problem = reference.problem;
    let mut integrator = method.on::<T>(problem)?;
    let mut state = problem.state::<T>();
    let h = step_size(level);
    match trajectory::integrate(&mut integrator, &mut state, T::exact(h), 1 << level, |_, _, _| {}) {
        Ok(_) => {}
        Err(failed) if matches!(failed.source, StepError::Fold { .. }) => return Ok(None),
        Err(failed) => return Err(problem.failed(method, T::exact(h))(failed)),
    }
    let momentum = state.momentum.map(convert);
    let distance = |a: Dd, b: Dd| Scalar::to_f64(a - b).abs();
    Ok(Some(Errors {
        momentum: Scalar::to_f64(casimir(&(momentum - reference.momentum)).sqrt()),
        energy: distance(energy(&reference.model.system, &momentum)?, reference.energy),
        casimir: distance(casimir(&momentum), reference.casimir),
    }))
}

/// The rows of a problem: each method, in `f64` and in 32 digits, h = 1, …, 2^−finest; none where no root exists.
///
/// In parallel; `tick` is called after each of the 2 · methods · (finest + 1) runs. The order of the rows is that of
/// the arguments, f64 first, coarse steps first.
///
/// # Errors
/// Those of [`errors`].
pub fn table(
    reference: &Reference,
    methods: &[Method],
    finest: u32,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Row>, ExperimentError> {
    let runs: Vec<_> = methods
        .iter()
        .flat_map(|&method| [false, true].map(|wide| (method, wide)))
        .flat_map(|(method, wide)| (0..=finest).map(move |level| (method, wide, level)))
        .collect();
    let rows = runs.into_par_iter().with_max_len(1).map(|(method, wide, level)| {
        let measured = if wide { errors::<Dd> } else { errors::<f64> }(reference, method, level)?;
        tick();
        let scalar = if wide { Dd::NAME } else { f64::NAME };
        Ok(measured.map(|errors| Row { problem: reference.problem, method, scalar, level, errors }))
    });
    Ok(rows.collect::<Result<Vec<_>, ExperimentError>>()?.into_iter().flatten().collect())
}
