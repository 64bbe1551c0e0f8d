//! The classical Runge–Kutta method of order 4, written out, in fixed steps.

use crate::fields::Field;
use crate::hindsight::FixedSteps;
use crate::problem::{Reached, Solve};

/// So many equal steps.
#[derive(Default)]
pub struct Rk4(usize);

impl FixedSteps for Rk4 {
    const NAME: &'static str = "RK4 by hand, best step";

    fn with_steps(steps: usize) -> Self {
        Self(steps)
    }
}

impl Solve for Rk4 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, _: f64) -> Reached<K> {
        let h = end / self.0 as f64;
        let mut y = *start;
        let (mut k1, mut k2, mut k3, mut k4) = ([0.0; K], [0.0; K], [0.0; K], [0.0; K]);
        let mut stage = [0.0; K];
        for _ in 0..self.0 {
            field.rates(&y, &mut k1);
            for i in 0..K {
                stage[i] = y[i] + 0.5 * h * k1[i];
            }
            field.rates(&stage, &mut k2);
            for i in 0..K {
                stage[i] = y[i] + 0.5 * h * k2[i];
            }
            field.rates(&stage, &mut k3);
            for i in 0..K {
                stage[i] = y[i] + h * k3[i];
            }
            field.rates(&stage, &mut k4);
            for i in 0..K {
                y[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
            }
        }
        Ok((y, self.0))
    }
}
