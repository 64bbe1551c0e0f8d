//! What takes part.

use crate::dop853::Dop853;
use crate::hindsight::Hindsight;
use crate::problem::{Problem, Solve, State};
use crate::rk4::Rk4;
use crate::{differential_equations, ivp, ode_solvers, ours};

/// The three sorts of contenders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// This crate: told the tolerance, and judged by the run with that tolerance.
    Ours,
    /// A solver as published: told the tolerance; judged by its fastest run that turned out to be accurate enough.
    Packaged,
    /// Steps of a size that is known to be the right one, because it was tried before.
    ByHand,
}

/// The state at T.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// μ and the attitude.
    pub state: State,
    /// Steps taken, accepted or not where the solver tells.
    pub steps: usize,
}

impl From<(State, usize)> for Answer {
    fn from((state, steps): (State, usize)) -> Self {
        Self { state, steps }
    }
}

/// Something that solves the problems.
pub trait Contender {
    /// Its name in tables and figures.
    fn name(&self) -> &str;

    /// Its sort.
    fn kind(&self) -> Kind;

    /// Whether it solves a problem of this kind at all.
    fn takes(&self, _problem: &Problem) -> bool {
        true
    }

    /// Before the clock runs: whatever does not depend on the initial value.
    fn prepare(&mut self, _problem: &Problem, _tolerances: &[f64]) {}

    /// From the initial value to the state at T.
    ///
    /// # Errors
    /// Whatever the solver says.
    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String>;
}

/// A solver as published.
pub trait Packaged: Solve {
    /// Its name in tables and figures.
    const NAME: &'static str;
}

impl<P: Packaged> Contender for P {
    fn name(&self) -> &str {
        P::NAME
    }

    fn kind(&self) -> Kind {
        Kind::Packaged
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        problem.solve_with(self, tolerance).map(Answer::from)
    }
}

/// Everything that takes part, ours first.
pub fn all() -> Vec<Box<dyn Contender>> {
    vec![
        Box::new(ours::EulerPoincare::new(ours::Way::Listed)),
        Box::new(ours::EulerPoincare::new(ours::Way::Own)),
        Box::new(ours::EulerPoincare::new(ours::Way::General)),
        Box::new(ode_solvers::Dop853),
        Box::new(ivp::Dop853),
        Box::new(differential_equations::Dop853),
        Box::new(differential_equations::Verner98),
        #[cfg(feature = "russell")]
        Box::new(crate::russell::DoPri8),
        #[cfg(feature = "diffsol")]
        Box::new(crate::diffsol::Tsit45),
        Box::new(differential_equations::Gauss6),
        Box::new(Hindsight::<Dop853>::default()),
        Box::new(Hindsight::<Rk4>::default()),
    ]
}
