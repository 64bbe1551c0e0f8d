//! Members that share the registers of [`EnsembleSo3`].

use super::member::Member;
use crate::integrators::EnsembleError;
use crate::integrators::State;
use crate::integrators::lanes::{LANES, Terms, UnfitTableau};
use crate::integrators::so3::HalfAngle;
use crate::integrators::so3::{EnsembleSo3, Member as Body};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::retraction::beside::Core;
use crate::retraction::{AnyRetraction, CayleySo3, ExponentialSo3};
use crate::scalar::Real;
use crate::system::case::Case;
use crate::system::dispatch::System;
use crate::tableau::Tableau;
use std::any::Any;

/// Bodies that are moved on together, with either retraction.
trait Together: Send + Sync {
    fn advance(&mut self, h: f64, steps: usize) -> Result<(), EnsembleError>;
    fn state(&self, lane: usize) -> Option<State<f64, 3, 3>>;
}

impl<R: HalfAngle + Send + Sync> Together for EnsembleSo3<Terms, R> {
    fn advance(&mut self, h: f64, steps: usize) -> Result<(), EnsembleError> {
        self.advance(h, steps)
    }

    fn state(&self, lane: usize) -> Option<State<f64, 3, 3>> {
        self.state(lane)
    }
}

/// A group in lanes.
pub struct Lanes {
    start: Start,
    tableau: Tableau<f64>,
    /// All members of the group, where they were when they were last put into lanes.
    bodies: Vec<Body<Terms>>,
    /// The members that are in the lanes.
    going: Vec<usize>,
    together: Box<dyn Together>,
}

impl Lanes {
    /// The group in lanes, where that is the same method to round-off: SO(3) in `f64`, a quadratic Lagrangian, at most
    /// eight stages, and a force and potentials that have a form in lanes.
    pub fn new<T: Real, const N: usize, const D: usize>(
        case: &Case,
        systems: &[&System<T, N, D>],
        members: &[Member<T, N, D>],
    ) -> Option<Self> {
        let mut bodies = Vec::with_capacity(systems.len());
        for (system, member) in systems.iter().zip(members) {
            let system = (*system as &dyn Any).downcast_ref::<System<f64, 3, 4>>()?;
            let State { time, momentum, attitude } = (&member.state as &dyn Any).downcast_ref::<State<f64, 3, 4>>()?;
            let attitude = attitude.fixed_view::<3, 3>(0, 0).into_owned();
            let state = State { time: *time, momentum: *momentum, attitude };
            let AnyLagrangian::Quadratic(lagrangian) = system.lagrangian.kinetic() else { return None };
            if system.tableau.stages() > LANES {
                return None;
            }
            let mut force = Terms::new(&system.force, lagrangian, &system.algebra).ok()?;
            force.0.extend(case.loads()?);
            bodies.push(Body { lagrangian: lagrangian.clone(), force, state });
        }
        let first = (*systems.first()? as &dyn Any).downcast_ref::<System<f64, 3, 4>>()?;
        let AnyRetraction::Beside(retraction) = &first.retraction else { return None };
        let start: Start = match retraction.core() {
            Core::Cayley(_) => together::<CayleySo3<f64>>,
            Core::Exponential(_) => together::<ExponentialSo3<f64>>,
            Core::Given(_) => return None,
        };
        let tableau = first.tableau.clone();
        let together = start(&bodies, &tableau).ok()?;
        Some(Self { going: (0..bodies.len()).collect(), start, tableau, bodies, together })
    }

    /// `steps` steps for all members that are going; those that fail leave the lanes, and the others go on.
    pub fn advance<T: Real, const N: usize, const D: usize>(
        &mut self,
        members: &mut [Member<T, N, D>],
        h: T,
        mut steps: u64,
    ) {
        while steps > 0 && !self.going.is_empty() {
            let outcome = self.together.advance(h.to_f64(), steps as usize);
            let done = outcome.as_ref().map_or_else(|error| error.step as u64, |()| steps);
            for (lane, &k) in self.going.iter().enumerate() {
                let Some(state) = self.together.state(lane) else { continue };
                let member = &mut members[k];
                member.state.momentum.iter_mut().zip(state.momentum.iter()).for_each(|(x, y)| *x = T::exact(*y));
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    member.state.attitude[(r, c)] = T::exact(state.attitude[(r, c)]);
                }
                member.took(done);
                self.bodies[k].state = state;
            }
            steps -= done;
            let Err(error) = outcome else { continue };
            members[self.going[error.member]].fail(error.source);
            self.going.remove(error.member);
            let left: Vec<_> = self.going.iter().map(|&k| self.bodies[k].clone()).collect();
            match (self.start)(&left, &self.tableau) {
                Ok(together) => self.together = together,
                Err(error) => self.going.drain(..).for_each(|k| members[k].fail(error)),
            }
        }
    }
}

/// How bodies are put into lanes.
type Start = fn(&[Body<Terms>], &Tableau<f64>) -> Result<Box<dyn Together>, UnfitTableau>;

fn together<R: HalfAngle + Default + Send + Sync + 'static>(
    bodies: &[Body<Terms>],
    tableau: &Tableau<f64>,
) -> Result<Box<dyn Together>, UnfitTableau> {
    Ok(Box::new(EnsembleSo3::new(bodies, R::default(), tableau.clone())?))
}
