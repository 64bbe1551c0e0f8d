//! The fewest fixed steps that turn out to be accurate enough: what no user knows beforehand.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{Problem, Solve};
use std::marker::PhantomData;

/// The most steps in a unit of time.
const FINEST: f64 = 4096.0;

/// Numbers of steps are tried up to a difference of a given part.
const RESOLUTION: usize = 32;

/// M with the number of steps that was found for each tolerance.
#[derive(Clone, Debug, Default)]
pub struct Hindsight<M>(Vec<(f64, usize)>, PhantomData<M>);

/// A method with a fixed number of steps.
pub trait FixedSteps: Default + Solve {
    /// Its name in tables and figures.
    const NAME: &'static str;

    /// A solver with a number of steps.
    fn with_steps(steps: usize) -> Self;
}

impl<M: FixedSteps> Contender for Hindsight<M> {
    fn name(&self) -> &str {
        M::NAME
    }

    fn kind(&self) -> Kind {
        Kind::ByHand
    }

    /// Tries M with more and more steps until each of the tolerances has been reached.
    fn prepare(&mut self, problem: &Problem, tolerances: &[f64]) {
        let suffice = |steps: usize, tolerance: f64| {
            let answer = problem.solve_with(&mut M::with_steps(steps), f64::NAN);
            answer.is_ok_and(|(state, _)| problem.error(&state) <= tolerance)
        };
        let finest = (FINEST * problem.end) as usize;
        let (mut found, mut below, mut steps) = (Vec::new(), 0, 1);
        let mut sorted = tolerances.to_vec();
        sorted.sort_by(|x, y| y.total_cmp(x));
        for tolerance in sorted {
            while steps <= finest && !suffice(steps, tolerance) {
                (below, steps) = (steps, (steps + 1).max(steps * 5 / 4));
            }
            if steps > finest {
                break;
            }
            while steps - below > 1 + steps / RESOLUTION {
                let middle = below + (steps - below) / 2;
                if suffice(middle, tolerance) {
                    steps = middle;
                } else {
                    below = middle;
                }
            }
            found.push((tolerance, steps));
        }
        self.0 = found;
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        match self.0.iter().find(|(known, _)| *known == tolerance) {
            Some(&(_, steps)) => problem.solve_with(&mut M::with_steps(steps), tolerance).map(Answer::from),
            None => Err("no step size is small enough, or none is worth trying".into()),
        }
    }
}
