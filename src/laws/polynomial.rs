//! Random functions of which only the value is written down: on g×G×g, on g*×G×g* and on g*.

use super::planted::blend_scalar;
use super::probe::Probe;
use crate::algebra::{Covector, Matrix, Vector, elimination};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::Fault;
use crate::mechanics::doubled::{DoubledLagrangian, MomentumPoint, VelocityError, VelocityPoint};
use crate::mechanics::hamiltonian::DoubledHamiltonian;
use crate::mechanics::lie_poisson::MomentumFunction;
use crate::retraction::RetractionError;
use crate::scalar::{Real, Scalar};

/// A Lagrangian that is not odd under the inversion.
pub const EVEN_PART: Fault =
    Fault::new("lagrangian-even-part", "l instead of ½(l − l∘ι), its even part left in", "every group");

/// ½(l − l∘ι) from l and l∘ι, or with the even part left in.
pub fn odd_part<S: Scalar>(here: S, there: S, fault: Option<&Fault>) -> S {
    blend_scalar((here - there) * S::half(), here, EVEN_PART.size_in(fault))
}

/// ½ xᵀAx + ½ yᵀBy + xᵀCy + tr(PU) + ⟨κ, x⟩ tr(QU) + t ⟨ρ, y⟩, with (x, y) = (η, ψ) or (λ, μ).
///
/// Of no symmetry; regular, because the diagonals of −A and B outweigh everything else in their rows. Or, on g×G×g, the odd part of it
/// under (η, U, ψ) ↦ (ψ, U⁻¹, η).
#[derive(Clone, Debug)]
pub struct Polynomial<'a, T: Real, const N: usize, const D: usize> {
    group: &'a MatrixGroup<T, N, D>,
    quadratic: [Matrix<T, N>; 3],
    potential: [Matrix<T, D>; 2],
    kappa: Covector<T, N>,
    rho: Covector<T, N>,
    odd: bool,
    fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> Polynomial<'a, T, N, D> {
    /// One with coefficients from a probe.
    pub fn new(group: &'a MatrixGroup<T, N, D>, probe: &mut Probe) -> Self {
        let quarter = T::exact(0.25);
        let mut square = || Matrix::<T, N>::from_fn(|_, _| probe.unit::<T>() * quarter);
        let [a, b, c] = [square(), square(), square()];
        let one = Matrix::<T, N>::identity() * T::int(1 + N as i64);
        let mut potential = || Matrix::<T, D>::from_fn(|_, _| probe.unit::<T>() * T::half());
        let potential = [potential(), potential()];
        Self {
            group,
            quadratic: [(a + a.transpose()) * T::half() - one, (b + b.transpose()) * T::half() + one, c],
            potential,
            kappa: probe.covector(),
            rho: probe.covector(),
            odd: false,
            fault: None,
        }
    }

    /// Its odd part, or what the fault makes of that.
    pub fn odd(self, fault: Option<&'a Fault>) -> Self {
        Self { odd: true, fault, ..self }
    }

    fn evaluate<S: Scalar<Base = T>>(&self, t: S, x: &[S], u: &Matrix<S, D>, y: &[S]) -> S {
        let half = S::half();
        let mut sum = S::zero();
        let (mut kappa, mut rho) = (S::zero(), S::zero());
        for a in 0..N {
            for b in 0..N {
                let [on_x, on_y, mixed] = self.quadratic.each_ref().map(|m| S::lift(m[(a, b)]));
                sum += half * (x[a] * on_x * x[b] + y[a] * on_y * y[b]) + x[a] * mixed * y[b];
            }
            kappa += S::lift(self.kappa[a]) * x[a];
            rho += S::lift(self.rho[a]) * y[a];
        }
        let trace = |m: &Matrix<T, D>| {
            (0..D * D).fold(S::zero(), |sum, k| sum + S::lift(m[(k / D, k % D)]) * u[(k % D, k / D)])
        };
        sum + trace(&self.potential[0]) + kappa * trace(&self.potential[1]) + t * rho
    }
}

impl<T: Real, const N: usize, const D: usize> DoubledLagrangian<T, N, D> for Polynomial<'_, T, N, D> {
    fn value<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<S, RetractionError> {
        let here = self.evaluate(at.time, at.eta.as_slice(), &at.u, at.psi.as_slice());
        if !self.odd {
            return Ok(here);
        }
        let singular = RetractionError::NoPreimage { retraction: "the inverse", why: "U is singular" };
        let inverse = elimination::inverse(&at.u).ok_or(singular)?;
        Ok(odd_part(here, self.evaluate(at.time, at.psi.as_slice(), &inverse, at.eta.as_slice()), self.fault))
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        Ok(self.group.hat(xi))
    }
}

impl<T: Real, const N: usize, const D: usize> DoubledHamiltonian<T, N, D> for Polynomial<'_, T, N, D> {
    fn value<S: Scalar<Base = T>>(&self, at: &MomentumPoint<S, N, D>) -> Result<S, VelocityError> {
        Ok(self.evaluate(at.time, at.lambda.as_slice(), &at.u, at.mu.as_slice()))
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        Ok(self.group.hat(xi))
    }
}

/// ⟨μ, a⟩ + ½ ⟨μ, b⟩⟨μ, c⟩ + ¼ ⟨μ, d⟩³ on g*.
#[derive(Clone, Debug)]
pub struct Cubic<T: Real, const N: usize> {
    vectors: [Vector<T, N>; 4],
}

impl<T: Real, const N: usize> Cubic<T, N> {
    /// One with coefficients from a probe.
    pub fn new(probe: &mut Probe) -> Self {
        Self { vectors: [probe.vector(), probe.vector(), probe.vector(), probe.vector()] }
    }
}

impl<T: Real, const N: usize> MomentumFunction<T, N> for Cubic<T, N> {
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        let on = |v: &Vector<T, N>| (0..N).fold(S::zero(), |sum, a| sum + mu[a] * S::lift(v[a]));
        let [a, b, c, d] = self.vectors.each_ref().map(on);
        a + S::half() * b * c + S::exact(0.25) * d * d * d
    }
}
