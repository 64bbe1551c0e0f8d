//! Laws of forces that keep the coadjoint orbits.

use super::lie_poisson::{COAD_SIGN, rates, with_casimirs};
use super::planted::blend;
use super::question::{Answer, Measured, Problem, Question, law, singular, stream};
use super::sizes::turning;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::Fault;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::lie_poisson::{OrbitField, OrbitForce};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, Scalar, dual, max_abs};

const ORBIT_TRANSPOSED: Fault =
    Fault::new("orbit-force-transposed", "f = (ad_ζ μᵀ)ᵀ", "algebras and bases in which ad_ζ is not antisymmetric");
const ORBIT_OTHER: Fault = Fault::new("orbit-force-other", "f = ad*_ζ l'(ζ)", "non-abelian algebras");

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "coadjoint-orbit-force",
                statement: "with f = ad*_ζ μ: d/dt (Ad*_{k⁻¹} μ) = 0 for k̇ = k(η + ζ); with another force f₂ added, Ad*_{k⁻¹} f₂",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2",
                oracle: "Ad of matrices of the group, on dual numbers",
                bound: both("floor 2⁸ N u relative to the terms"),
                needs: "a group; an algebra that is not abelian",
                faults: &[ORBIT_TRANSPOSED, ORBIT_OTHER, COAD_SIGN],
                cases: |cases| cases.main_dimensions().with_group().nonabelian(),
                asks: Casimirs(false),
            }),
            law!(Law {
                name: "orbit-force-casimirs",
                statement: "with f = ad*_ζ μ every Casimir is kept: dC/dt = 0",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2",
                oracle: "the value of C on dual numbers along the rates",
                bound: both("floor 2⁸ N u relative to the terms"),
                needs: "Casimir functions that are known",
                faults: &[ORBIT_TRANSPOSED, ORBIT_OTHER],
                cases: |cases| with_casimirs(cases),
                asks: Casimirs(true),
            }),
        ]
    }
}

/// Whether Casimirs are kept; else whether the orbit is.
#[derive(Clone, Copy)]
struct Casimirs(bool);

/// ζ(t, η) = Zη + z + t w.
#[derive(Clone)]
struct RandomField<T: Real, const N: usize> {
    matrix: Matrix<T, N>,
    vectors: [Vector<T, N>; 2],
}

impl<T: Real, const N: usize> OrbitField<T, N> for RandomField<T, N> {
    fn zeta<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Vector<S, N> {
        let [constant, rate] = self.vectors.map(|v| v.map(S::lift));
        self.matrix.map(S::lift) * eta + constant + rate * t
    }
}

/// An orbit force, with a fault or without, and another force.
struct PlantedOrbit<'a, T: Real, const N: usize, L, F> {
    orbit: OrbitForce<T, N, L, RandomField<T, N>>,
    other: Option<&'a F>,
    fault: Option<&'a Fault>,
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>, F: Force<T, N>> Force<T, N> for PlantedOrbit<'_, T, N, L, F> {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let mut force = self.orbit.force(t, eta);
        if self.fault.is_some() {
            let zeta = self.orbit.field.zeta(t, eta);
            let mu = self.orbit.lagrangian.gradient(eta);
            let transposed = self.orbit.algebra.bracket(&zeta, &mu.transpose()).transpose();
            let other = self.orbit.algebra.coad(&zeta, &self.orbit.lagrangian.gradient(&zeta));
            force = blend(force, transposed, ORBIT_TRANSPOSED.size_in(self.fault));
            force = blend(force, other, ORBIT_OTHER.size_in(self.fault));
        }
        self.other.map_or(force, |other| force + other.force(t, eta))
    }
}

impl Question for Casimirs {
    const STREAM: Option<u64> = Some(stream::ORBITS);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault, probe) = (problem.system, problem.fault, &mut problem.probe);
        let (time, mu) = (system.state.time, system.state.momentum);
        let matrix = Matrix::from_fn(|_, _| probe.unit::<T>());
        let field = RandomField { matrix, vectors: [probe.vector(), probe.vector()] };
        let orbit = OrbitForce::new(system.algebra.clone(), &system.lagrangian, field);
        let with = |other| PlantedOrbit { orbit: orbit.clone(), other, fault };
        let flow = EulerPoincare::new(system.algebra.clone(), &system.lagrangian, with(None));
        let alone = rates(&flow, time, &mu, fault)?;
        let zeta = orbit.field.zeta(time, &alone.velocity);
        let floor = 256.0 * system.dimension as f64;
        let size = turning(&system.algebra, &alone.velocity, &mu) + turning(&system.algebra, &zeta, &mu);
        if self.0 {
            let moved = dual::moving(&mu, &alone.momentum);
            let none = Measured::NotApplicable("the algebra has no Casimirs".into());
            return Ok(system.casimirs.iter().fold(none, |found, casimir| {
                let rate = casimir.value(&moved).eps;
                found.and(Measured::defect(rate.abs(), size * casimir.gradient_terms(&mu).amax(), floor, || {
                    format!("dC/dt = {:e}", rate.to_f64())
                }))
            }));
        }
        let (Some(group), Ok(k)) = (&system.group, system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.25))))
        else {
            return Ok(Measured::NotApplicable("no group element".into()));
        };
        let forced = EulerPoincare::new(system.algebra.clone(), &system.lagrangian, with(Some(&system.force)));
        let total = rates(&forced, time, &mu, fault)?;
        // Ad*_{k⁻¹} μ with k moving along k(η + ζ).
        let moving = dual::moving(&k, &(k * group.hat(&(alone.velocity + zeta))));
        let adjoint = group.inverse(&moving).and_then(|inverse| group.adjoint(&inverse));
        let adjoint = adjoint.ok_or_else(singular)?;
        let change = |momentum: &Covector<T, N>| (dual::moving(&mu, momentum) * adjoint).map(|v| v.eps);
        let still = change(&alone.momentum).amax();
        let other = system.force.force(time, &alone.velocity);
        let expected = other * adjoint.map(|v| v.re);
        let defect = max_abs(&(change(&total.momentum) - expected));
        let scale = adjoint.map(|v| v.re).amax();
        let kept = Measured::defect(still, size * scale, floor, || {
            format!("d/dt Ad*_{{k⁻¹}} μ = {:e} with the orbit force alone", still.to_f64())
        });
        Ok(kept.and(Measured::defect(defect, (size + other.amax()) * scale, floor, || {
            format!("d/dt Ad*_{{k⁻¹}} μ is off Ad*_{{k⁻¹}} f by {:e}", defect.to_f64())
        })))
    }
}
