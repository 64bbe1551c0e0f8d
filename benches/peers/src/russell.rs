//! The crate `russell_ode`: its Dormand–Prince method of order 8(5,3).
//!
//! Its default first step, 1e-4, is left: there is no automatic one.

use crate::contender::Packaged;
use crate::fields::Field;
use crate::problem::{Reached, Solve};
use russell_lab::Vector;
use russell_ode::prelude::{Method, NoArgs, OdeSolver, Params, System};

/// `Method::DoPri8`.
pub struct DoPri8;

impl Solve for DoPri8 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, tolerance: f64) -> Reached<K> {
        let system = System::new(K, move |rate: &mut Vector, _t, y: &Vector, _: &mut NoArgs| {
            match (y.as_data().first_chunk(), rate.as_mut_data().first_chunk_mut()) {
                (Some(y), Some(rate)) => field.rates(y, rate),
                _ => return Err("the state has another length"),
            }
            Ok(())
        });
        let mut params = Params::new(Method::DoPri8);
        params.set_tolerances(tolerance, tolerance, None)?;
        params.step.n_step_max = 1_000_000;
        let mut solver = OdeSolver::new(params, system)?;
        let mut y = Vector::from(start);
        solver.solve(&mut y, 0.0, end, None, &mut 0, None)?;
        let reached = *y.as_data().first_chunk().ok_or("the state has another length")?;
        Ok((reached, solver.stats().n_steps))
    }
}

impl Packaged for DoPri8 {
    const NAME: &'static str = "russell_ode dopri8";
}
