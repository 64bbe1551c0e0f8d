//! Many trajectories of one system: initial states, and coefficients if wanted, that differ from member to member.
//!
//! [`Ensemble::run`] builds a batch of members and hands it to the caller, who moves it on and looks at it. On SO(3) with a
//! quadratic Lagrangian and a tableau of at most eight stages, eight members share the registers
//! ([`crate::integrators::EnsembleSo3`]); every other system goes through [`crate::integrators::Variational`], member by
//! member. Groups of eight are spread over rayon's threads; which members share a group depends on their order alone, so
//! the results are the same bits at any number of threads.

mod group;
mod lanes;
mod member;
mod parameter;
mod statistics;

pub use parameter::Parameter;
pub use statistics::{Moments, Statistics};

use super::case::{Case, Structure};
use super::dispatch::{System, Visitor};
use super::error::CaseError;
use crate::group::departure;
use crate::harness::parallel;
use crate::scalar::{Number, Real};
use group::Groups;
use std::sync::OnceLock;

/// Members that share a group.
pub(super) const WIDTH: usize = crate::integrators::lanes::LANES;

/// An attitude is refused that is further than this from its group (see [`departure()`]).
pub const FAR_FROM_GROUP: f64 = 1e-8;

/// Where a member starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin<T> {
    /// t; that of the case where there is none.
    pub time: Option<T>,
    /// μ, n numbers.
    pub momentum: Vec<T>,
    /// g by rows, m×m numbers; that of the case where there is none.
    pub attitude: Option<Vec<T>>,
    /// The values of the ensemble's parameters, in their order.
    pub parameters: Vec<Number>,
}

/// Why a member is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OriginError {
    /// A list of another length than the system's.
    #[error("{found} numbers for the {what}, where the system has {wanted}")]
    Length {
        /// Which list.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A NaN or an infinity.
    #[error("the {what} is not finite")]
    NotFinite {
        /// Of what.
        what: &'static str,
    },
    /// An attitude that is not in the group.
    #[error(
        "the attitude is not in the group: its equations (g'g = 1 for rotations) are violated by {departure:e}, where \
         {FAR_FROM_GROUP:e} is allowed"
    )]
    Attitude {
        /// By how much; infinite for a reflection.
        departure: f64,
    },
    /// The case with the parameters of the member cannot be built.
    #[error(transparent)]
    Case(#[from] CaseError),
}

/// A member that is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("member {member}: {source}")]
#[non_exhaustive]
pub struct MemberError {
    /// Which one of those given, from 0.
    pub member: usize,
    /// Why.
    pub source: OriginError,
}

/// What is known of a member where it is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample<T> {
    /// t; μ; η and the energy, NaN where the Legendre transform fails; the Casimirs that are known; g by rows, none without a group.
    pub values: Vec<T>,
    /// Steps taken.
    pub steps: u64,
    /// The largest relative residual and the iterations of all steps; none where members share registers: there every
    /// step has the residual that [`crate::integrators::variational::Settings`] want, and no count.
    pub work: Option<(T, u64)>,
    /// Why the member stopped before the others, if it did.
    pub failure: Option<String>,
}

/// Members that are being moved on.
pub trait Batch<T: Real> {
    /// `steps` steps of size `h` for every member that has not failed. One that fails keeps its last state.
    fn advance(&mut self, h: T, steps: u64);

    /// How many members have not failed.
    fn going(&self) -> usize;

    /// Every member, in their order.
    fn samples(&self) -> Vec<Sample<T>>;

    /// Statistics of the members that have not failed.
    fn statistics(&self) -> Statistics<T>;
}

/// Many members of one system.
#[derive(Clone, Debug)]
pub struct Ensemble {
    case: Case,
    parameters: Vec<Parameter>,
    general: bool,
}

impl Ensemble {
    /// Members of `case`, of which the initial state is replaced.
    pub fn new(case: &Case) -> Self {
        Self { case: case.clone(), parameters: Vec::new(), general: false }
    }

    /// The same with coefficients that differ from member to member.
    pub fn with_parameters(mut self, parameters: Vec<Parameter>) -> Self {
        self.parameters = parameters;
        self
    }

    /// The same by the general engine everywhere: slower where members could share registers, but it counts iterations.
    pub fn general(mut self) -> Self {
        self.general = true;
        self
    }

    /// How many members are worth having at a time: enough for many threads, few enough for some megabytes.
    pub fn batch(&self) -> usize {
        let unknowns = self.case.unknowns().unwrap_or(1).max(1);
        ((1 << 21) / (unknowns * unknowns + 512) / WIDTH * WIDTH).clamp(16 * WIDTH, 512 * WIDTH)
    }

    /// Whether a member can be built.
    ///
    /// # Errors
    /// Why not.
    pub fn check<T: Real>(&self, origin: &Origin<T>) -> Result<(), OriginError> {
        let length = |what, found: usize, wanted| match found == wanted {
            true => Ok(()),
            false => Err(OriginError::Length { what, found, wanted }),
        };
        let finite = |what, list: &[T]| match list.iter().all(|v| v.all_finite()) {
            true => Ok(()),
            false => Err(OriginError::NotFinite { what }),
        };
        length("momentum", origin.momentum.len(), self.case.dimension())?;
        length("parameters", origin.parameters.len(), self.parameters.len())?;
        finite("momentum", &origin.momentum)?;
        finite("time", origin.time.as_slice())?;
        if let Some(attitude) = &origin.attitude {
            let size = self.case.matrix_size();
            length("attitude", attitude.len(), size * size)?;
            finite("attitude", attitude)?;
            if let Structure::Named(entry) = &self.case.algebra.structure {
                let departure = departure(entry, &|r, c| attitude[r * size + c]).to_f64();
                if departure > FAR_FROM_GROUP {
                    return Err(OriginError::Attitude { departure });
                }
            }
        }
        if !self.parameters.is_empty() {
            self.member(origin).check()?;
        }
        Ok(())
    }

    /// The case with the parameters of a member.
    fn member<T>(&self, origin: &Origin<T>) -> Case {
        let mut case = self.case.clone();
        for (parameter, value) in self.parameters.iter().zip(&origin.parameters) {
            parameter.set(&mut case, value);
        }
        case
    }

    /// [`Ensemble::run`], for every scalar.
    pub(super) fn run_in<T: Real>(
        &self,
        origins: &[Origin<T>],
        drive: &mut dyn FnMut(&mut dyn Batch<T>),
    ) -> Result<(), MemberError> {
        first_refused(origins.len(), &|k| self.check(&origins[k]))?;
        let case = |source: CaseError| MemberError { member: 0, source: source.into() };
        self.case.run(Run { ensemble: self, origins, drive }).map_err(case)?
    }
}

/// The first refusal of the members, looked at in parallel.
fn first_refused(members: usize, check: &(dyn Fn(usize) -> Result<(), OriginError> + Sync)) -> Result<(), MemberError> {
    let refused = |(member, check): (usize, Result<(), _>)| check.map_err(|source| MemberError { member, source });
    parallel(members, check).into_iter().enumerate().try_for_each(refused)
}

/// Builds the members, whatever their dimension, and drives them.
struct Run<'a, T> {
    ensemble: &'a Ensemble,
    origins: &'a [Origin<T>],
    drive: &'a mut dyn FnMut(&mut dyn Batch<T>),
}

impl<T: Real> Visitor<T> for Run<'_, T> {
    type Output = Result<(), MemberError>;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Self::Output {
        let Self { ensemble, origins, drive } = self;
        // One system for all, unless parameters make one of each.
        let own = if ensemble.parameters.is_empty() { 0 } else { origins.len() };
        let own: Vec<OnceLock<System<T, N, D>>> = (0..own).map(|_| OnceLock::new()).collect();
        first_refused(own.len(), &|k| {
            let system = ensemble.member(&origins[k]).system(&())?;
            own[k].get_or_init(|| system);
            Ok(())
        })?;
        let of = |k: usize| own.get(k).and_then(OnceLock::get).unwrap_or(&system);
        let members: Vec<_> = origins.iter().enumerate().map(|(k, origin)| (of(k), origin)).collect();
        drive(&mut Groups::new(&members, &ensemble.case, ensemble.case.matrix_size(), !ensemble.general));
        Ok(())
    }
}
