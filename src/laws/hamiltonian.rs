//! Laws of Hamiltonians on g*×G×g*: their equations, h_f on and off the units, its regularity, and the Hamiltonian that
//! the Legendre transform of l_f defines.

use super::planted::{blend, blend_scalar};
use super::polynomial::Polynomial;
use super::probe::{stream, unit_of};
use super::question::near_enough;
use super::question::{Answer, Measured, Problem, Question, law, singular};
use super::sizes::forcing;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, elimination, pair};
use crate::group::{LieGroup, MatrixGroup};
use crate::groupoid::{Arrow, DenseGroup, poisson_bivector};
use crate::harness::{Cost, Fault};
use crate::mechanics::doubled::{MomentumPoint, VelocityError, VelocityPoint};
use crate::mechanics::force::AnyForce;
use crate::mechanics::forced_hamiltonian::ForcedHamiltonian;
use crate::mechanics::hamiltonian::{
    self, DoubledHamiltonian, MomentumPartials, hamiltonian_legendre_jacobian, hamiltonian_momenta,
    momentum_partials_by_duals,
};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{AnyRetraction, Retraction, RetractionError};
use crate::scalar::{Real, Scalar, larger, max_abs};
use crate::system::System;
use nalgebra::{DMatrix, DVector};

// What may be wrong with Hamilton's equations, Fh× and h_f.
pub(super) const HAMILTON_SIGN: Fault =
    Fault::new("hamilton-lambda-sign", "λ̇ = +ad*_{∂h/∂λ} λ − R*_U ∂h/∂U", "non-abelian groups");
pub(super) const HAMILTON_SIDES: Fault = Fault::new(
    "hamilton-sides",
    "L*_U ∂h/∂U in the first equation, R*_U ∂h/∂U in the second",
    "non-abelian groups, off the units",
);
pub(super) const HAMILTON_ARROW: Fault = Fault::new("hamilton-arrow", "U̇ = U(∂h/∂μ − Ad_{U⁻¹} ∂h/∂λ)", "every group");
pub(super) const FIBRE_SIGN: Fault =
    Fault::new("hamiltonian-legendre-sign", "Fh× = (+∂h/∂λ, U, ∂h/∂μ)", "every system");
pub(super) const H_FORCE_ONCE: Fault =
    Fault::new("forced-hamiltonian-force-once", "k_f̃ = −⟨f̃(λ), τ⁻¹(U)⟩", "velocity-dependent forces, λ ≠ μ");
pub(super) const H_SIGN: Fault = Fault::new("forced-hamiltonian-sign", "h_f = h(μ) − h(λ) − k_f̃", "forced systems");
pub(super) const H_PLUS: Fault = Fault::new("forced-hamiltonian-plus", "h_f = h(μ) + h(λ) + k_f̃", "every system");
const H_NO_FORCE_DERIVATIVE: Fault = Fault::new(
    "forced-hamiltonian-no-force-derivative",
    "∂h_f/∂λ without the derivative of f̃",
    "velocity-dependent forces, off the units",
);

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "hamilton-equations",
                statement: "Ḟ = {F, h} along λ̇, U̇, μ̇, for any functions F and h on g*×G×g*",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §4.3, (4.5)",
                oracle: "the bracket as a bivector; Ḟ by the value of F on dual numbers along the rates; F and h are random \
                 polynomials of no symmetry",
                bound: both("floor 2⁸ N u relative to the terms"),
                needs: "a group",
                faults: &[HAMILTON_SIGN, HAMILTON_SIDES, HAMILTON_ARROW],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Equations,
            }),
            law!(Law {
                name: "hamiltonian-conserved",
                statement: "dh_f/dt = ∂h_f/∂t along its own equations, off the units",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §4.3",
                oracle: "the value of h_f on dual numbers along the rates, with and without the rate of time",
                bound: small(12, "floor 2⁸ N u relative to the terms"),
                needs: "a group; a force",
                faults: &[HAMILTON_SIDES, HAMILTON_ARROW, H_NO_FORCE_DERIVATIVE],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Conserved,
            }),
            law!(Law {
                name: "forced-hamiltonian-partials",
                statement: "∂h_f/∂λ, L*_U ∂h_f/∂U, R*_U ∂h_f/∂U, ∂h_f/∂μ in closed form",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 4.11",
                oracle: "the value of h_f on dual numbers along a random direction, with U moved from either side",
                bound: small(12, "floor 2⁸ N u relative to the terms"),
                needs: "a group",
                faults: &[H_FORCE_ONCE, H_SIGN, H_PLUS, H_NO_FORCE_DERIVATIVE],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Partials,
            }),
            law!(Law {
                name: "free-hamiltonian-units",
                statement: "h = h(μ) − h(λ): h∘ι = −h, and on (μ, e, μ) its vector field is (ad*_η μ, 0, ad*_η μ), η = h'(μ)",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 4.9 and Lemma 4.10",
                oracle: "the free Lie–Poisson equations on g*; the value at the inverse arrow",
                bound: small(12, "floor 2⁸ N u relative to the terms"),
                needs: "a group; no force",
                faults: &[HAMILTON_SIGN, HAMILTON_ARROW, H_PLUS],
                cases: |cases| cases.main_dimensions().with_group().force_free(),
                asks: Which::Units,
            }),
            law!(Law {
                name: "forced-hamiltonian-units",
                statement: "h_f∘ι = −h_f, both forms of k_f̃ agree, and on (μ, e, μ) the vector field of h_f is forced Lie–Poisson",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 4.11",
                oracle: "the forced equations on g*; the value at the inverse arrow and the form with τ⁻¹(U⁻¹)",
                bound: small(12, "floor 2⁸ N u relative to the terms"),
                needs: "a group; a force",
                faults: &[HAMILTON_SIGN, HAMILTON_ARROW, H_FORCE_ONCE, H_SIGN, H_PLUS],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Units,
            }),
            law!(Law {
                name: "hamiltonian-regularity",
                statement: "the Jacobian of Fh_f× on (μ, e, μ) is diag(h'', h''); near the units Fh_f× has an inverse",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 4.12",
                oracle: "the inverse of l''; the momenta that the velocities were made from, where U is so close to e that the \
                 Jacobian changes by less than 1/16 of itself",
                bound: small(5, "floor 2¹⁴ N u (where Newton's method may stop) relative to the terms"),
                needs: "a group",
                cost: Cost::Expensive,
                faults: &[FIBRE_SIGN],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Regularity,
            }),
        ]
    }
}

/// [`hamiltonian::hamilton_rates`].
pub(super) fn hamilton_rates<T: Real, const N: usize, const D: usize>(
    h: &impl DoubledHamiltonian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &MomentumPoint<T, N, D>,
    fault: Option<&Fault>,
) -> Result<MomentumPoint<T, N, D>, VelocityError> {
    let mut rates = hamiltonian::hamilton_rates(h, algebra, at)?;
    if fault.is_some() {
        let p = h.partials(at)?;
        let size = |planted: Fault| T::exact(planted.size_in(fault));
        rates.lambda += algebra.coad(&p.lambda, &at.lambda) * (size(HAMILTON_SIGN) * T::int(2));
        rates.lambda += (p.right - p.left) * size(HAMILTON_SIDES);
        rates.mu += (p.left - p.right) * size(HAMILTON_SIDES);
        rates.u -= h.hat(&p.lambda)? * at.u * (size(HAMILTON_ARROW) * T::int(2));
    }
    Ok(rates)
}

/// [`hamiltonian::hamiltonian_legendre`].
pub(super) fn hamiltonian_legendre<T: Real, const N: usize, const D: usize>(
    h: &impl DoubledHamiltonian<T, N, D>,
    at: &MomentumPoint<T, N, D>,
    fault: Option<&Fault>,
) -> Result<VelocityPoint<T, N, D>, VelocityError> {
    let found = hamiltonian::hamiltonian_legendre(h, at)?;
    Ok(VelocityPoint { eta: blend(found.eta, -found.eta, FIBRE_SIGN.size_in(fault)), ..found })
}

/// h_f, with a fault or without.
#[derive(Clone, Copy)]
pub(super) struct PlantedHamiltonian<'a, T: Real, const N: usize, const D: usize> {
    /// h_f.
    pub hamiltonian: ForcedHamiltonian<&'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>>,
    /// What is planted.
    pub fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> PlantedHamiltonian<'a, T, N, D> {
    /// That of a system.
    pub fn of(system: &'a System<T, N, D>, fault: Option<&'a Fault>) -> Self {
        Self { hamiltonian: ForcedHamiltonian::new(&system.lagrangian, &system.force, &system.retraction), fault }
    }
}

impl<T: Real, const N: usize, const D: usize> DoubledHamiltonian<T, N, D> for PlantedHamiltonian<'_, T, N, D> {
    fn value<S: Scalar<Base = T>>(&self, at: &MomentumPoint<S, N, D>) -> Result<S, VelocityError> {
        let right = self.hamiltonian.value(at)?;
        if self.fault.is_none() {
            return Ok(right);
        }
        let (system, point) = (&self.hamiltonian.system, self.hamiltonian.velocities(at)?);
        let (k, eta) = (system.coupling(&point)?, point.eta);
        let once = -pair(&system.force.force(at.time, &eta), &system.retraction.tau_inv(&at.u)?);
        let energy = pair(&at.lambda, &eta) - system.lagrangian.value(&eta);
        let value = blend_scalar(right, right - k + once, H_FORCE_ONCE.size_in(self.fault));
        let value = blend_scalar(value, value - k - k, H_SIGN.size_in(self.fault));
        Ok(blend_scalar(value, value + energy + energy, H_PLUS.size_in(self.fault)))
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.hamiltonian.hat(xi)
    }

    /// In closed form; with a fault in the value, by dual numbers from it.
    fn partials<S: Scalar<Base = T>>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        if [H_FORCE_ONCE, H_SIGN, H_PLUS].into_iter().any(|fault| fault.size_in(self.fault) != 0.0) {
            return momentum_partials_by_duals(self, at);
        }
        let mut partials = self.hamiltonian.partials(at)?;
        let incomplete = H_NO_FORCE_DERIVATIVE.size_in(self.fault);
        if incomplete != 0.0 {
            let eta = self.hamiltonian.system.lagrangian.velocity(&at.lambda, &Vector::zeros())?;
            partials.lambda = blend(partials.lambda, -eta, incomplete);
        }
        Ok(partials)
    }
}

#[derive(Clone, Copy)]
enum Which {
    Equations,
    Conserved,
    Partials,
    Units,
    Regularity,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::HAMILTONIAN);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (state, group) = (&problem.system.state, problem.group()?);
        let mu = state.momentum;
        let lambda = mu + problem.probe.covector::<T, N>() * (T::exact(0.25) * unit_of(&mu));
        let x = problem.probe.vector::<T, N>() * T::exact(0.25);
        let u = problem.system.retraction.tau(&x)?;
        let inverse = group.inverse(&u).ok_or_else(singular)?;
        let planted = PlantedHamiltonian::of(problem.system, problem.fault);
        let mut off = OffUnits { p: MomentumPoint { time: state.time, lambda, u, mu }, inverse, x, planted, problem };
        match self {
            Self::Equations => off.equations(group),
            Self::Conserved => off.conserved(),
            Self::Partials => off.partials(),
            Self::Units => off.units(),
            Self::Regularity => off.regularity(),
        }
    }
}

/// h_f at (t; λ, U, μ), U = τ(x), with U⁻¹.
struct OffUnits<'a, T: Real, const N: usize, const D: usize> {
    problem: Problem<'a, T, N, D>,
    planted: PlantedHamiltonian<'a, T, N, D>,
    p: MomentumPoint<T, N, D>,
    inverse: Matrix<T, D>,
    x: Vector<T, N>,
}

impl<T: Real, const N: usize, const D: usize> OffUnits<'_, T, N, D> {
    /// What the count of operations allows.
    const FLOOR: f64 = 256.0 * N as f64;

    fn equations(&mut self, group: &MatrixGroup<T, N, D>) -> Answer {
        let (p, probe) = (&self.p, &mut self.problem.probe);
        let (f, h) = (Polynomial::new(group, probe), Polynomial::new(group, probe));
        let rates = hamilton_rates(&h, group.algebra(), p, self.problem.fault)?;
        let along = f.value(&p.moving(&MomentumPoint { time: T::zero(), ..rates }))?.eps;
        let at = |of: &Polynomial<'_, T, N, D>| of.partials(p);
        let (df, dh) = (at(&f)?, at(&h)?);
        let list = |entries: &[T]| DVector::from_column_slice(entries);
        let u = DMatrix::from_column_slice(D, D, p.u.as_slice());
        let arrow = Arrow { source: list(p.lambda.as_slice()), group: u, target: list(p.mu.as_slice()) };
        let bivector = poisson_bivector(&DenseGroup::of(group), &arrow).ok_or_else(singular)?;
        let differential = |of: &MomentumPartials<T, N>| {
            DVector::from_iterator(3 * N, of.lambda.iter().chain(&of.left).chain(&of.mu).copied())
        };
        let bracket = differential(&df).dot(&(bivector * differential(&dh)));
        let size = rates.lambda.amax() * df.lambda.amax()
            + rates.mu.amax() * df.mu.amax()
            + df.left.amax() * (dh.lambda.amax() + dh.mu.amax());
        let size = size * p.u.amax().max(T::one()) * self.inverse.amax().max(T::one());
        Ok(Measured::defect((along - bracket).abs(), size, Self::FLOOR, || {
            format!("Ḟ = {:e}, {{F, h}} = {:e}", along.to_f64(), bracket.to_f64())
        }))
    }

    fn conserved(&self) -> Answer {
        let (h, p, algebra) = (&self.planted, &self.p, &self.problem.system.algebra);
        let rates = hamilton_rates(h, algebra, p, self.problem.fault)?;
        let total = h.value(&p.moving(&rates))?.eps;
        let waiting = MomentumPoint { time: T::one(), ..p.map(|_| T::zero()) };
        let explicit = h.value(&p.moving(&waiting))?.eps;
        let partials = h.partials(p)?;
        let on_lambda = forcing(algebra, &partials.right, &partials.lambda, &p.lambda);
        let terms = on_lambda + forcing(algebra, &partials.left, &partials.mu, &p.mu);
        let size = rates.lambda.amax() * partials.lambda.amax()
            + rates.mu.amax() * partials.mu.amax()
            + terms * (partials.lambda.amax() + partials.mu.amax())
            + total.abs();
        Ok(Measured::defect((total - explicit).abs(), size, Self::FLOOR, || {
            format!("dh_f/dt = {:e}, ∂h_f/∂t = {:e}", total.to_f64(), explicit.to_f64())
        }))
    }

    fn partials(&mut self) -> Answer {
        let (h, p, probe) = (&self.planted.hamiltonian, &self.p, &mut self.problem.probe);
        let (first, second, xi) = (probe.covector::<T, N>(), probe.covector::<T, N>(), probe.vector::<T, N>());
        let hat = h.hat(&xi)?;
        let mine = self.planted.partials(p)?;
        let ends = first * mine.lambda + second * mine.mu;
        let size = mine.lambda.amax() + mine.mu.amax() + mine.left.amax() + mine.right.amax();
        let size = size * p.u.amax().max(T::one()) * self.inverse.amax().max(T::one());
        let side = |what: &'static str, mine: T, u: Matrix<T, D>| -> Answer {
            let direction = MomentumPoint { time: T::zero(), lambda: first, u, mu: second };
            let oracle = h.value(&p.moving(&direction))?.eps;
            Ok(Measured::defect((mine - oracle).abs(), size, Self::FLOOR, || {
                format!("{what}: {:e}, by dual numbers {:e}", mine.to_f64(), oracle.to_f64())
            }))
        };
        let left = side("dh_f with L*_U ∂h_f/∂U", (ends + mine.left * xi)[0], p.u * hat)?;
        Ok(left.and(side("dh_f with R*_U ∂h_f/∂U", (ends + mine.right * xi)[0], hat * p.u)?))
    }

    fn units(&self) -> Answer {
        let (planted, p, flow) = (&self.planted, &self.p, self.problem.system.equations());
        let on_base = flow.rates(p.time, &p.mu, &Vector::zeros())?;
        let unit = MomentumPoint { lambda: p.mu, u: Matrix::identity(), ..*p };
        let field = hamilton_rates(planted, &self.problem.system.algebra, &unit, self.problem.fault)?;
        let size = self.problem.turning(&on_base.velocity, &p.mu) + on_base.force.amax();
        let near = |what: &'static str, off: T, size: T| Measured::defect(off, size, Self::FLOOR, || what.into());
        let tangent = near("λ̇ on a unit", max_abs(&(field.lambda - on_base.momentum)), size)
            .and(near("μ̇ on a unit", max_abs(&(field.mu - on_base.momentum)), size))
            .and(near("U̇ on a unit", field.u.amax(), on_base.velocity.amax()));

        let here = planted.value(p)?;
        let there = planted.value(&MomentumPoint { time: p.time, lambda: p.mu, u: self.inverse, mu: p.lambda })?;
        let free = flow.hamiltonian(&p.mu, &on_base.velocity)?;
        let other = flow.hamiltonian(&p.lambda, &on_base.velocity)?;
        let velocities = planted.hamiltonian.velocities(p)?;
        let defined = planted.hamiltonian.system.coupling_as_defined(&velocities)?;
        let scale = p.u.amax().max(T::one()) * self.inverse.amax().max(T::one());
        let size = free.abs() + other.abs() + on_base.force.amax() * scale + defined.abs();
        let inverse = near("h_f at the inverse arrow", (here + there).abs(), size);
        let forms = near("h(μ) − h(λ) + k_f̃ as defined", (here - (free - other + defined)).abs(), size);
        Ok(tangent.and(inverse).and(forms))
    }

    fn regularity(&self) -> Answer {
        let (h, p, system, fault) = (&self.planted.hamiltonian, &self.p, self.problem.system, self.problem.fault);
        let floor = self.problem.floor(16.0 * 1024.0);
        let eta = system.lagrangian.velocity(&p.mu, &Vector::zeros())?;
        let hessian = system.lagrangian.hessian(&eta);
        let inverse = elimination::inverse(&hessian);
        let inverse = inverse.ok_or_else(|| Measured::Inconclusive("l'' is singular".into()))?;
        let sign = T::one() - T::int(2) * T::exact(FIBRE_SIGN.size_in(fault));
        let jacobian = |lambda: Covector<T, N>, u: Matrix<T, D>| -> Result<DMatrix<T>, VelocityError> {
            let mut jacobian = hamiltonian_legendre_jacobian(h, &MomentumPoint { lambda, u, ..*p })?;
            jacobian.rows_mut(0, N).scale_mut(sign);
            Ok(jacobian)
        };
        let on_units = jacobian(p.mu, Matrix::identity())?;
        let expected =
            DMatrix::from_fn(2 * N, 2 * N, |i, j| if i / N == j / N { inverse[(i % N, j % N)] } else { T::zero() });
        let blocks = Measured::defect(max_abs(&(&on_units - &expected)), inverse.amax(), floor, || {
            "the Jacobian on a unit is not diag(h'', h'')".into()
        });

        let at_e = jacobian(p.lambda, Matrix::identity())?;
        let scale = at_e.clone().try_inverse().map_or(T::zero(), |m| m.amax()) * T::int(32 * system.dimension as i64);
        let change = |u: &Matrix<T, D>| Ok(max_abs(&(jacobian(p.lambda, *u)? - &at_e)) * scale);
        let u = near_enough(&system.retraction, (p.u, self.x), change)?;
        let velocities = hamiltonian_legendre(h, &MomentumPoint { u, ..*p }, fault)?;
        let guess = (system.lagrangian.gradient(&velocities.eta), system.lagrangian.gradient(&velocities.psi));
        let found = hamiltonian_momenta(h, &velocities, (&guess.0, &guess.1))?;
        let off = larger(max_abs(&(found.lambda - p.lambda)), max_abs(&(found.mu - p.mu)));
        Ok(blocks.and(Measured::defect(off, p.lambda.amax().max(p.mu.amax()), floor, || {
            format!("the momenta of the velocities are off by {:e}", off.to_f64())
        })))
    }
}
