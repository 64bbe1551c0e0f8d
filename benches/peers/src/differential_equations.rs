//! The crate `differential-equations`: DOP853, Verner's method of order 9(8), and Gauss's of order 6.
//!
//! States are arrays; every step's state is kept, as its output does by default (asking for the last one alone makes it
//! interpolate). The Newton iteration of its implicit method is told 1e-12 whatever the tolerance: of 1e-6 … 1e-14 that was
//! the fastest by far for the accuracies compared here, since what the iteration leaves reaches the error estimate.

use crate::contender::Packaged;
use crate::fields::Field;
use crate::problem::{Reached, Solve};
use differential_equations::interpolate::Interpolation;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::prelude::{ExplicitRungeKutta, IVP, ImplicitRungeKutta};

struct Equation<F>(F);

impl<F: Field<K>, const K: usize> ODE<f64, [f64; K]> for Equation<F> {
    fn diff(&self, _t: f64, y: &[f64; K], rate: &mut [f64; K]) {
        self.0.rates(y, rate);
    }
}

fn solve<F: Field<K>, M, const K: usize>(field: F, start: &[f64; K], end: f64, method: M) -> Reached<K>
where
    M: OrdinaryNumericalMethod<f64, [f64; K]> + Interpolation<f64, [f64; K]>,
{
    let equation = Equation(field);
    let solution = IVP::ode(&equation, 0.0, end, *start).method(method).solve().map_err(|e| format!("{e:?}"))?;
    match (solution.t.last(), solution.y.last()) {
        (Some(t), Some(y)) if (t - end).abs() <= 1e-14 * end => Ok((*y, solution.steps.total())),
        (t, _) => Err(format!("ended at t = {t:?}")),
    }
}

macro_rules! contender {
    ($(#[$doc:meta])* $type:ident, $name:literal, |$tolerance:ident, $end:ident| $method:expr) => {
        $(#[$doc])*
        pub struct $type;

        impl Solve for $type {
            fn run<F: Field<K>, const K: usize>(
                &mut self,
                field: F,
                start: &[f64; K],
                $end: f64,
                $tolerance: f64,
            ) -> Reached<K> {
                solve(field, start, $end, $method)
            }
        }

        impl Packaged for $type {
            const NAME: &'static str = $name;
        }
    };
}

contender! {
    /// `ExplicitRungeKutta::dop853`.
    Dop853, "differential-equations dop853",
    |tolerance, end| ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(1_000_000)
}

contender! {
    /// `ExplicitRungeKutta::rkv988e`.
    Verner98, "differential-equations rkv98",
    |tolerance, end| ExplicitRungeKutta::rkv988e().rtol(tolerance).atol(tolerance).max_steps(1_000_000)
}

contender! {
    /// `ImplicitRungeKutta::gauss_legendre_6`.
    Gauss6, "differential-equations gauss6",
    |tolerance, end| ImplicitRungeKutta::gauss_legendre_6()
        .rtol(tolerance)
        .atol(tolerance)
        .newton_tol(1e-12)
        .max_steps(1_000_000)
}
