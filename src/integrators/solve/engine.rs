//! What a run needs of the steps that it is made of.

use super::Method;
use super::control::Statistics;
use super::dense::Piece;
use super::error::SolveError;
use crate::integrators::variational::Exchange;
use crate::integrators::{State, StepError};
use crate::retraction::Retraction;
use crate::scalar::Real;
use crate::tableau::{Tableau, TableauError};

/// What a run asks for.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Task<T> {
    /// When it begins and ends.
    pub start: T,
    /// The end, before the start or after it.
    pub end: T,
    /// The tolerance.
    pub tolerance: T,
    /// The size of the first steps, without sign, if it is given.
    pub first_step: Option<T>,
    /// The largest size of a step.
    pub max_step: Option<T>,
    /// How many steps may be tried.
    pub most_steps: usize,
    /// Whether anything is asked for that lies within a step: only then there are [`piece`](Engine::piece) and [`exchange`](Engine::exchange).
    pub within: bool,
}

/// Takes the steps of a run, chooses their sizes and judges their errors. [`Solve`](super::Solve) does all else.
#[doc(hidden)]
pub trait Engine<T: Real, const N: usize, const D: usize>: Sized {
    /// A Lagrangian, a force and a retraction.
    type Parts;

    /// The retraction, in whose chart states lie between the ends of a step.
    type Retraction: Retraction<T, N, D> + Clone;

    /// What takes steps to a tolerance.
    ///
    /// # Errors
    /// There is no such tableau.
    fn new(parts: &Self::Parts, method: &Method<T>, tolerance: T, start: &State<T, N, D>)
    -> Result<Self, TableauError>;

    /// Begins a run.
    ///
    /// # Errors
    /// The equations have no value at the start.
    fn begin(&mut self, start: &State<T, N, D>, task: &Task<T>) -> Result<(), SolveError>;

    /// Whether the end is reached.
    fn ended(&self) -> bool;

    /// Tries steps, and says how many were taken: none where they were refused.
    ///
    /// # Errors
    /// There is no going on.
    fn advance(&mut self, task: &Task<T>, statistics: &mut Statistics<T>) -> Result<usize, SolveError>;

    /// The states at both ends of the step k of those taken last.
    fn ends(&self, k: usize) -> [&State<T, N, D>; 2];

    /// The relative residual of the steps taken last.
    fn residual(&self) -> T;

    /// The states between the ends of step k.
    ///
    /// # Errors
    /// There is no such state.
    fn piece(&mut self, k: usize, tolerance: T, piece: &mut Piece<T, N, D>) -> Result<(), StepError>;

    /// The energy taken up in step k, by the quadrature of the tableau.
    fn exchange(&mut self, k: usize) -> Exchange<T>;

    /// The energy taken up in a unit of time, at a state in step k.
    ///
    /// # Errors
    /// There is no velocity.
    fn power(&self, k: usize, state: &State<T, N, D>) -> Result<Exchange<T>, StepError>;

    /// The retraction.
    fn retraction(&self) -> &Self::Retraction;

    /// The tableau.
    fn tableau(&self) -> &Tableau<T>;

    /// The steps taken last are done with.
    fn kept(&mut self);

    /// The size of the steps that would come next, with sign.
    fn next_step(&self) -> T;
}
