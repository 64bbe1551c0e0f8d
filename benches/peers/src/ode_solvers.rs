//! The crate `ode_solvers`: DOP853.
//!
//! Its dense output extrapolates the first step to T when the points are asked for at a distance T, and then keeps that
//! as the last point; the output of accepted steps (`Sparse`) is right, and costs three evaluations a step less.

use crate::contender::Packaged;
use crate::fields::Field;
use crate::problem::{Reached, Solve};
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{SVector, System};

struct Equation<F>(F);

impl<F: Field<K>, const K: usize> System<f64, SVector<f64, K>> for Equation<F> {
    fn system(&self, _t: f64, y: &SVector<f64, K>, rate: &mut SVector<f64, K>) {
        self.0.rates(&y.data.0[0], &mut rate.data.0[0]);
    }
}

/// `Dop853`.
pub struct Dop853;

impl Solve for Dop853 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, tolerance: f64) -> Reached<K> {
        let start = SVector::from(*start);
        let mut solver = ode_solvers::Dop853::new(Equation(field), 0.0, end, end, start, tolerance, tolerance);
        solver.set_output(OutputType::Sparse);
        let stats = solver.integrate().map_err(|e| e.to_string())?;
        match (solver.x_out().last(), solver.y_out().last()) {
            (Some(t), Some(y)) if (t - end).abs() <= 1e-14 * end => {
                Ok((y.data.0[0], (stats.accepted_steps + stats.rejected_steps) as usize))
            }
            (t, _) => Err(format!("ended at t = {t:?}")),
        }
    }
}

impl Packaged for Dop853 {
    const NAME: &'static str = "ode_solvers dop853";
}
