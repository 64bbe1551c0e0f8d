//! The crate `ivp`: DOP853, through the method itself, which keeps nothing but what its observer keeps.

use crate::contender::Packaged;
use crate::fields::Field;
use crate::problem::{Reached, Solve};
use ivp::dense::StepInterpolant;
use ivp::methods::{DOP853, Tolerance};
use ivp::prelude::{ControlFlag, FirstOrderSystem};
use ivp::solout::SolOut;

struct Equation<F, const K: usize>(F);

impl<F: Field<K>, const K: usize> FirstOrderSystem for Equation<F, K> {
    #[inline]
    fn derivative(&self, _t: f64, y: &[f64], rate: &mut [f64]) {
        if let (Some(y), Some(rate)) = (y.first_chunk(), rate.first_chunk_mut()) {
            self.0.rates(y, rate);
        }
    }
}

/// The last state.
struct Last<const K: usize>(f64, [f64; K]);

impl<const K: usize> SolOut for Last<K> {
    #[inline]
    fn solout(&mut self, _: f64, t: &mut f64, y: &mut [f64], _: Option<&StepInterpolant<'_>>) -> ControlFlag {
        self.0 = *t;
        self.1.copy_from_slice(y);
        ControlFlag::Continue
    }
}

/// `DOP853`.
pub struct Dop853;

impl Solve for Dop853 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, tolerance: f64) -> Reached<K> {
        let solver = DOP853 { dense_output: false, max_steps: 1_000_000, ..DOP853::default() };
        let mut last = Last(0.0, *start);
        let tolerance = || Tolerance::Scalar(tolerance);
        let equation = Equation::<F, K>(field);
        let result = solver
            .solve(&equation, 0.0, start, end, tolerance(), tolerance(), Some(&mut last))
            .map_err(|e| e.to_string())?;
        if result.status.is_success() && (last.0 - end).abs() <= 1e-14 * end {
            Ok((last.1, result.steps.total))
        } else {
            Err(format!("{:?} at t = {}", result.status, last.0))
        }
    }
}

impl Packaged for Dop853 {
    const NAME: &'static str = "ivp dop853";
}
