//! The crate `diffsol`: Tsitouras's method of order 5(4), on its vectors from nalgebra.

use crate::contender::Packaged;
use crate::fields::Field;
use crate::problem::{Reached, Solve};
use diffsol::{NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};

/// `tsit45`.
pub struct Tsit45;

impl Solve for Tsit45 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, tolerance: f64) -> Reached<K> {
        let start = *start;
        let rates = move |y: &[f64], _: &[f64], _t, rate: &mut [f64]| {
            if let (Some(y), Some(rate)) = (y.first_chunk(), rate.first_chunk_mut()) {
                field.rates(y, rate);
            }
        };
        let initial = move |_: &[f64], _t, y: &mut [f64]| y.copy_from_slice(&start);
        let problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(tolerance)
            .atol([tolerance])
            .rhs(rates)
            .init(initial, K)
            .build()
            .map_err(|e| e.to_string())?;
        let mut solver = problem.tsit45().map_err(|e| e.to_string())?;
        solver.set_stop_time(end).map_err(|e| e.to_string())?;
        let mut steps = 1;
        while !matches!(solver.step().map_err(|e| e.to_string())?, OdeSolverStopReason::TstopReached) {
            steps += 1;
        }
        let reached =
            solver.state().y.batch_as_slice(0).first_chunk().copied().ok_or("the state has another length")?;
        Ok((reached, steps))
    }
}

impl Packaged for Tsit45 {
    const NAME: &'static str = "diffsol tsit45";
}
