//! The exact discrete Lagrangian is antisymmetric.

use super::super::precision::{Measured, settle_main_small};
use super::super::probe::{Probe, stream};
use super::super::subjects::{COUPLING_SUM, FIRST_COPY_ONLY, PLUS, PlantedForced};
use super::super::{CaseLaw, Source};
use crate::algebra::{Vector, elimination};
use crate::discrete::exact::{ExactError, ExactSolution, Start};
use crate::harness::{About, Cost, Fault};
use crate::mechanics::Force;
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::{DoubledLagrangian, Forced, VelocityError};
use crate::retraction::Retraction;
use crate::scalar::Real;
use crate::system::{System, Visitor};
use std::fmt::Debug;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[CaseLaw {
            about: About {
                name: "exact-antisymmetry",
                statement: "l_d^e(W, U⁻¹, V) = −l_d^e(V, U, W) along solutions: from (ψ, U⁻¹, η) they have V and W exchanged and the \
                opposite action",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 5.2",
                oracle: "a second solution, from the inverse arrow",
                bound: "two precisions; floor 2¹¹ N u: 8 stages of a collocation iterated to a few u",
                needs: "a group; a force",
                cost: Cost::Expensive,
                faults: &[PLUS, FIRST_COPY_ONLY, COUPLING_SUM],
            },
            cases: |cases| cases.main_dimensions().forced().with_group(),
            check: |case, fault| settle_main_small(case, fault, Check { case, fault }, 6),
        }]
    }
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a dyn Debug,
    fault: Option<&'a Fault>,
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        self,
        system: System<T, N, D, R, L, F>,
    ) -> Measured {
        match self.antisymmetry(&system) {
            Ok(measured) => measured,
            Err(ExactError::Equations { source: VelocityError::Domain(_), .. }) => {
                Measured::NotApplicable("the solution leaves the domain of the retraction".into())
            }
            Err(ExactError::Equations { source: VelocityError::Legendre(_), .. }) => {
                Measured::NotApplicable("l_f is not regular so far off the units".into())
            }
            Err(ExactError::NotConverged { .. }) => Measured::Inconclusive("the collocation did not converge".into()),
            Err(ExactError::Tableau(error)) => Measured::Broken(error.to_string()),
        }
    }
}

impl Check<'_> {
    fn antisymmetry<
        T: Real,
        const N: usize,
        const D: usize,
        R: Retraction<T, N, D>,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    >(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, ExactError> {
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let time = system.state.time;
        let outside = |source: VelocityError| ExactError::Equations { time: time.to_f64(), source };
        let mut probe = Probe::new(self.case, stream::EXACT_SOLUTION);
        let eta = l.velocity(&system.state.momentum, &Vector::zeros()).map_err(|e| outside(e.into()))?;
        let psi = eta + probe.vector::<T, N>() * (eta.amax() * T::exact(0.125));
        let u = r.tau(&(probe.vector::<T, N>() * T::exact(1.0 / 16.0))).map_err(|e| outside(e.into()))?;
        let Some(inverse) = elimination::inverse(&u) else {
            return Ok(Measured::Broken("τ(x) is a singular matrix".into()));
        };
        let forced = Forced::new(l, f, r);
        let planted = PlantedForced { doubled: &forced, fault: self.fault };
        let exact = ExactSolution::new::<D>(planted, r, 8)?;
        let there = exact.at(&Start { time, eta, u, psi }, &[system.step])?;
        let back = exact.at(&Start { time, eta: psi, u: inverse, psi: eta }, &[system.step])?;
        let ([there], [back]) = (there.as_slice(), back.as_slice()) else {
            return Ok(Measured::Broken("one time gave another number of points".into()));
        };
        let floor = 2048.0 * N as f64;
        let rate = planted.value(time, &eta, &u, &psi).map_err(|e| outside(e.into()))?.abs();
        let energies = l.value(&eta).abs() + l.value(&psi).abs() + rate;
        let action = Measured::defect((there.action + back.action).abs(), energies * system.step.abs(), floor, || {
            format!("actions {:e} and {:e}", there.action.to_f64(), back.action.to_f64())
        });
        let ends = (there.v - back.w).amax().max((there.w - back.v).amax());
        let size = there.v.amax().max(there.w.amax());
        Ok(action.and(Measured::defect(ends, size, floor, || "V and W are not exchanged".into())))
    }
}
