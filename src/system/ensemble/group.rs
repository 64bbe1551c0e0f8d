//! Groups of members, in whatever dimension: by the general engine, or in lanes.

use super::lanes::Lanes;
use super::member::Member;
use super::{Batch, Origin, Sample, Statistics, WIDTH};
use crate::algebra::Vector;
use crate::group::departure;
use crate::harness::parallel;
use crate::integrators::OneStep;
use crate::mechanics::Lagrangian;
use crate::mechanics::configuration::Configuration;
use crate::scalar::Real;
use crate::system::case::{Case, Structure};
use crate::system::dispatch::{Scheme, System};
use crate::system::trajectory::values;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Who takes the steps of a group.
enum Engine<'a, T: Real, const N: usize, const D: usize> {
    General(Vec<Scheme<'a, T, N, D>>),
    Lanes(Box<Lanes>),
}

/// At most eight members.
struct Group<'a, T: Real, const N: usize, const D: usize> {
    systems: Vec<&'a System<T, N, D>>,
    members: Vec<Member<T, N, D>>,
    engine: Engine<'a, T, N, D>,
    case: &'a Case,
    /// The number of rows of the attitudes in samples.
    size: usize,
}

impl<'a, T: Real, const N: usize, const D: usize> Group<'a, T, N, D> {
    fn new(members: &[(&'a System<T, N, D>, &Origin<T>)], case: &'a Case, size: usize, may_share: bool) -> Self {
        let systems: Vec<_> = members.iter().map(|(system, _)| *system).collect();
        let members: Vec<_> = members.iter().map(|(system, origin)| Member::new(&system.state, origin, size)).collect();
        let lanes = if may_share { Lanes::new(case, &systems, &members).map(Box::new) } else { None };
        let engine = lanes.map_or_else(|| Engine::General(systems.iter().map(|s| s.scheme()).collect()), Engine::Lanes);
        Self { systems, members, engine, case, size }
    }

    /// η and the energy of member k; NaN where η is not found.
    fn motion(&self, k: usize) -> (Vector<T, N>, T) {
        let (system, state) = (self.systems[k], &self.members[k].state);
        let (t, g, nan) = (state.time, Configuration::of(&state.attitude), T::exact(f64::NAN));
        match system.lagrangian.velocity_at(t, g, &state.momentum, &Vector::zeros()) {
            Ok(eta) => (eta, system.lagrangian.energy_at(t, g, &eta)),
            Err(_) => (Vector::from_element(nan), nan),
        }
    }

    fn sample(&self, k: usize) -> Sample<T> {
        let (system, member) = (self.systems[k], &self.members[k]);
        let (velocity, energy) = self.motion(k);
        Sample {
            values: values(&member.state, &velocity, &[energy], &system.casimirs, (system.dimension, self.size)),
            steps: member.steps,
            work: matches!(self.engine, Engine::General(_)).then_some((member.residual, member.iterations)),
            failure: member.failure.clone(),
        }
    }
}

impl<T, const N: usize, const D: usize> Batch<T> for Group<'_, T, N, D>
where
    T: Real,
{
    fn advance(&mut self, h: T, steps: u64) {
        self.members.iter_mut().for_each(|member| member.start(h));
        let methods = match &mut self.engine {
            Engine::General(methods) => methods,
            Engine::Lanes(lanes) => return lanes.advance(&mut self.members, h, steps),
        };
        for (member, method) in self.members.iter_mut().zip(methods) {
            for _ in 0..steps {
                if member.failure.is_some() {
                    break;
                }
                match method.step(&mut member.state, h) {
                    Ok(report) => {
                        member.reported(&report);
                        member.took(1);
                    }
                    Err(error) => member.fail(error),
                }
            }
        }
    }

    fn going(&self) -> usize {
        self.members.iter().filter(|member| member.failure.is_none()).count()
    }

    fn samples(&self) -> Vec<Sample<T>> {
        (0..self.members.len()).map(|k| self.sample(k)).collect()
    }

    fn statistics(&self) -> Statistics<T> {
        let (n, casimirs) = (self.case.dimension(), self.systems.first().map_or(0, |system| system.casimirs.len()));
        let mut all = Statistics::none(n + 1 + casimirs);
        for (k, member) in self.members.iter().enumerate().filter(|(_, member)| member.failure.is_none()) {
            all.members += 1;
            let momentum = &member.state.momentum;
            let casimirs = self.systems[k].casimirs.iter().map(|casimir| casimir.value(momentum));
            let counted = momentum.iter().take(n).copied().chain([self.motion(k).1]).chain(casimirs).enumerate();
            // An energy without a velocity is not counted.
            for (i, value) in counted.filter(|(i, value)| *i != n || value.all_finite()) {
                all.moments[i].add(value);
            }
            if let Structure::Named(entry) = &self.case.algebra.structure {
                let attitude = &member.state.attitude;
                all.departure = all.departure.max(departure(entry, &|r, c| attitude[(r, c)]));
            }
        }
        all
    }
}

/// At most eight members, whatever their dimension and retraction.
type AnyGroup<'a, T> = Box<dyn Batch<T> + Send + 'a>;

/// The groups of a batch: each is moved on by one thread at a time.
pub struct Groups<'a, T>(Vec<Mutex<AnyGroup<'a, T>>>);

impl<'a, T: Real> Groups<'a, T> {
    /// Groups of the members in their order, of a case with attitudes of this size.
    pub fn new<const N: usize, const D: usize>(
        members: &[(&'a System<T, N, D>, &Origin<T>)],
        case: &'a Case,
        size: usize,
        may_share: bool,
    ) -> Self {
        let make = |k: usize| -> Mutex<AnyGroup<'a, T>> {
            let members = &members[k * WIDTH..members.len().min((k + 1) * WIDTH)];
            Mutex::new(Box::new(Group::new(members, case, size, may_share)))
        };
        Self(parallel(members.len().div_ceil(WIDTH), make))
    }

    fn group(&self, k: usize) -> MutexGuard<'_, AnyGroup<'a, T>> {
        self.0[k].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T: Real> Batch<T> for Groups<'_, T> {
    fn advance(&mut self, h: T, steps: u64) {
        parallel(self.0.len(), |k| self.group(k).advance(h, steps));
    }

    fn going(&self) -> usize {
        (0..self.0.len()).map(|k| self.group(k).going()).sum()
    }

    fn samples(&self) -> Vec<Sample<T>> {
        parallel(self.0.len(), |k| self.group(k).samples()).concat()
    }

    fn statistics(&self) -> Statistics<T> {
        let parts = parallel(self.0.len(), |k| self.group(k).statistics());
        let mut all = Statistics::none(parts.first().map_or(0, |part| part.moments.len()));
        parts.iter().for_each(|part| all.merge(part));
        all
    }
}
