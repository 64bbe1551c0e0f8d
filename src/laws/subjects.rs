//! The continuous theory with faults planted in it: what the laws of [`super::mechanics`], [`super::euler_lagrange`],
//! [`super::legendre`] and [`super::hamiltonian`] judge. Without a fault each is the library's function.

use super::planted::retraction::Plant;
use super::planted::{blend, blend_scalar};
use super::precision::{Check, Measured, alone, digits};
use super::probe::{Probe, unit_of};
pub use super::user::part::Answer;
use super::{Source, unbuilt};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use crate::group::MatrixGroup;
use crate::harness::{Fault, Verdict};
use crate::mechanics::doubled::{
    Both, DoubledLagrangian, Forced, MomentumPoint, Partials, Point, VelocityError, velocity_hessian_by_duals,
};
use crate::mechanics::euler_lagrange;
use crate::mechanics::force::AnyForce;
use crate::mechanics::forced_hamiltonian::ForcedHamiltonian;
use crate::mechanics::hamiltonian::{
    self, DoubledHamiltonian, MomentumPartials, modified_legendre, momentum_partials_by_duals,
};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::{Force as _, Lagrangian as _, LegendreError};
use crate::retraction::{AnyRetraction, Retraction as _, RetractionError};
use crate::scalar::{Real, Scalar};
use crate::system::dispatch::Main;
use crate::system::{Case, System, Visitor};
use std::fmt::Debug;

/// k_f with the force of the first copy alone.
pub const FIRST_COPY_ONLY: Fault = Fault::new("first-copy-only", "k_f = −⟨f(η), τ⁻¹(U)⟩", "velocity-dependent forces");
/// k_f with a wrong sign.
pub const COUPLING_SUM: Fault = Fault::new(
    "sum",
    "k_f = ½(⟨f(ψ), τ⁻¹(U⁻¹)⟩ + ⟨f(η), τ⁻¹(U)⟩), the sign of the second term flipped",
    "forced systems",
);
/// k_f with two times.
pub const TIME_SHIFT: Fault =
    Fault::new("time-shift", "k_f with f(t + ¼, ψ) instead of f(t, ψ)", "time-dependent forces");
/// l_f with a wrong sign.
pub const PLUS: Fault = Fault::new("plus", "l(ψ) + l(η) − k_f", "every system");
/// ∂l_f/∂U on one side.
pub const LEFT_FOR_RIGHT: Fault =
    Fault::new("left-for-right", "R*_U ∂l_f/∂U replaced by L*_U ∂l_f/∂U", "forced systems on non-abelian groups");
/// ∂l_f/∂η incomplete.
pub const NO_FORCE_DERIVATIVE: Fault =
    Fault::new("no-force-derivative", "∂l_f/∂η without the derivative of f", "velocity-dependent forces");
/// ∂l_f/∂U halved.
pub const HALF_FORCE: Fault = Fault::new("half-force", "∂l_f/∂U halved", "forced systems");

/// A Lagrangian that is not odd under the inversion.
pub const EVEN_PART: Fault =
    Fault::new("lagrangian-even-part", "l instead of ½(l − l∘ι), its even part left in", "every group");

/// ½(l − l∘ι) from l and l∘ι, or with the even part left in.
pub fn odd_part<S: Scalar>(here: S, there: S, fault: Option<&Fault>) -> S {
    blend_scalar((here - there) * S::half(), here, EVEN_PART.size_in(fault))
}

/// l_f, with a fault or without.
#[derive(Clone, Copy)]
pub struct PlantedForced<'a, T: Real, const N: usize, const D: usize> {
    /// l_f.
    pub doubled: Forced<&'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>>,
    /// What is planted.
    pub fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> PlantedForced<'a, T, N, D> {
    /// That of a system.
    pub fn of(system: &'a System<T, N, D>, fault: Option<&'a Fault>) -> Self {
        Self { doubled: Forced::new(&system.lagrangian, &system.force, &system.retraction), fault }
    }

    /// k_f.
    pub fn coupling<S: Scalar<Base = T>>(&self, at: &Point<S, N, D>) -> Result<S, RetractionError> {
        let right = self.doubled.coupling(at)?;
        if self.fault.is_none() {
            return Ok(right);
        }
        let x = self.doubled.retraction.tau_inv(&at.u)?;
        let force = |t: S, eta: &Vector<S, N>| pair(&self.doubled.force.force(t, eta), &x);
        let (here, there) = (force(at.time, &at.eta), force(at.time, &at.psi));
        let late = force(at.time + S::exact(0.25), &at.psi);
        let value = blend_scalar(right, -here, FIRST_COPY_ONLY.size_in(self.fault));
        let value = blend_scalar(value, (here - there) * S::half(), COUPLING_SUM.size_in(self.fault));
        Ok(blend_scalar(value, -(here + late) * S::half(), TIME_SHIFT.size_in(self.fault)))
    }
}

impl<T: Real, const N: usize, const D: usize> DoubledLagrangian<T, N, D> for PlantedForced<'_, T, N, D> {
    fn value<S: Scalar<Base = T>>(&self, at: &Point<S, N, D>) -> Result<S, RetractionError> {
        if self.fault.is_none() {
            return self.doubled.value(at);
        }
        let first = self.doubled.lagrangian.value(&at.eta);
        let first = blend_scalar(-first, first, PLUS.size_in(self.fault));
        Ok(self.doubled.lagrangian.value(&at.psi) + first - self.coupling(at)?)
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.doubled.hat(xi)
    }

    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<Both<Vector<T, N>>, LegendreError> {
        DoubledLagrangian::<T, N, D>::unit_velocities(&self.doubled, lambda, mu)
    }

    /// In closed form; with a fault in the partial derivatives, from them.
    fn velocity_hessian(&self, at: &Point<T, N, D>) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        match self.fault {
            None => self.doubled.velocity_hessian(at),
            Some(_) => velocity_hessian_by_duals(self, at),
        }
    }

    fn partials<S: Scalar<Base = T>>(&self, at: &Point<S, N, D>) -> Result<Partials<S, N>, RetractionError> {
        let mut partials = self.doubled.partials(at)?;
        if self.fault.is_none() {
            return Ok(partials);
        }
        let half = HALF_FORCE.size_in(self.fault);
        let incomplete = -self.doubled.lagrangian.gradient(&at.eta);
        partials.right = blend(partials.right, partials.left, LEFT_FOR_RIGHT.size_in(self.fault));
        partials.eta = blend(partials.eta, incomplete, NO_FORCE_DERIVATIVE.size_in(self.fault));
        partials.left = blend(partials.left, partials.left * S::half(), half);
        partials.right = blend(partials.right, partials.right * S::half(), half);
        Ok(partials)
    }
}

/// The Euler–Lagrange equations with ad* of the wrong sign.
pub const EL_BRACKET_SIGN: Fault =
    Fault::new("euler-lagrange-bracket-sign", "−ad*_η ∂l/∂η instead of ad*_η ∂l/∂η", "non-abelian groups");
/// The Euler–Lagrange equations with the sides of ∂l/∂U exchanged.
pub const EL_SIDES: Fault = Fault::new(
    "euler-lagrange-sides",
    "L*_U ∂l/∂U in the first equation, R*_U ∂l/∂U in the second",
    "non-abelian groups, off the units",
);
/// The Euler–Lagrange equations with one term of the wrong sign.
pub const EL_POTENTIAL_SIGN: Fault =
    Fault::new("euler-lagrange-potential-sign", "+R*_U ∂l/∂U in the first equation", "every group");
/// The arrow equation from the other side.
pub const ARROW_SIDES: Fault = Fault::new("arrow-sides", "U̇ = ψU − Uη", "non-abelian groups, off the units");

/// [`euler_lagrange::residual`].
pub fn residual<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &Point<T, N, D>,
    rates: Both<&Vector<T, N>>,
    fault: Option<&Fault>,
) -> Result<Both<Covector<T, N>>, RetractionError> {
    let (mut first, mut second) = euler_lagrange::residual(doubled, algebra, at, rates)?;
    if fault.is_some() {
        let p = doubled.partials(at)?;
        let size = |planted: Fault| T::exact(Fault::size_of(fault, planted.name));
        let sign = size(EL_BRACKET_SIGN) * T::int(2);
        first += algebra.coad(&at.eta, &p.eta) * sign + (p.left - p.right) * size(EL_SIDES);
        first -= p.right * (size(EL_POTENTIAL_SIGN) * T::int(2));
        second += algebra.coad(&at.psi, &p.psi) * sign + (p.left - p.right) * size(EL_SIDES);
    }
    Ok((first, second))
}

/// [`euler_lagrange::rates`].
pub fn rates<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &Point<T, N, D>,
    fault: Option<&Fault>,
) -> Result<Point<T, N, D>, VelocityError> {
    if fault.is_none() {
        return euler_lagrange::rates(doubled, algebra, at);
    }
    let zero = Vector::zeros();
    let (first, second) = residual(doubled, algebra, at, (&zero, &zero), fault)?;
    let (eta, psi) = euler_lagrange::accelerations(doubled, at, &-first, &-second)?;
    let wrong = doubled.hat(&at.psi)? * at.u - at.u * doubled.hat(&at.eta)?;
    let u = blend(euler_lagrange::arrow_rate(doubled, at)?, wrong, ARROW_SIDES.size_in(fault));
    Ok(Point { time: T::one(), eta, u, psi })
}

/// The modified Legendre transform with a wrong sign.
pub const LEGENDRE_SIGN: Fault = Fault::new("legendre-first-sign", "λ = +∂l/∂η", "every system");
/// The modified Legendre transform without the coupling.
pub const LEGENDRE_ON_UNITS: Fault = Fault::new(
    "legendre-on-units",
    "the derivatives taken at U = e",
    "velocity-dependent forces and potentials, off the units",
);

/// [`modified_legendre`].
pub fn legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    at: &Point<S, N, D>,
    fault: Option<&Fault>,
) -> Result<MomentumPoint<S, N, D>, RetractionError> {
    let mut momenta = modified_legendre(doubled, at)?;
    if fault.is_some() {
        let size = |planted: Fault| Fault::size_of(fault, planted.name);
        let unit = modified_legendre(doubled, &Point { u: Matrix::identity(), ..*at })?;
        momenta.lambda = blend(momenta.lambda, -momenta.lambda, size(LEGENDRE_SIGN));
        momenta.lambda = blend(momenta.lambda, unit.lambda, size(LEGENDRE_ON_UNITS));
        momenta.mu = blend(momenta.mu, unit.mu, size(LEGENDRE_ON_UNITS));
    }
    Ok(momenta)
}

/// Hamilton's equations with a wrong sign.
pub const HAMILTON_SIGN: Fault =
    Fault::new("hamilton-lambda-sign", "λ̇ = +ad*_{∂h/∂λ} λ − R*_U ∂h/∂U", "non-abelian groups");
/// Hamilton's equations with the sides of ∂h/∂U exchanged.
pub const HAMILTON_SIDES: Fault = Fault::new(
    "hamilton-sides",
    "L*_U ∂h/∂U in the first equation, R*_U ∂h/∂U in the second",
    "non-abelian groups, off the units",
);
/// Hamilton's equations with a wrong arrow.
pub const HAMILTON_ARROW: Fault = Fault::new("hamilton-arrow", "U̇ = U(∂h/∂μ − Ad_{U⁻¹} ∂h/∂λ)", "every group");

/// [`hamiltonian::hamilton_rates`].
pub fn hamilton_rates<T: Real, const N: usize, const D: usize>(
    h: &impl DoubledHamiltonian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &MomentumPoint<T, N, D>,
    fault: Option<&Fault>,
) -> Result<MomentumPoint<T, N, D>, VelocityError> {
    let mut rates = hamiltonian::hamilton_rates(h, algebra, at)?;
    if fault.is_some() {
        let p = h.partials(at)?;
        let size = |planted: Fault| T::exact(Fault::size_of(fault, planted.name));
        rates.lambda += algebra.coad(&p.lambda, &at.lambda) * (size(HAMILTON_SIGN) * T::int(2));
        rates.lambda += (p.right - p.left) * size(HAMILTON_SIDES);
        rates.mu += (p.left - p.right) * size(HAMILTON_SIDES);
        rates.u -= h.hat(&p.lambda)? * at.u * (size(HAMILTON_ARROW) * T::int(2));
    }
    Ok(rates)
}

/// Fh× with a wrong sign.
pub const FIBRE_SIGN: Fault = Fault::new("hamiltonian-legendre-sign", "Fh× = (+∂h/∂λ, U, ∂h/∂μ)", "every system");

/// [`hamiltonian::hamiltonian_legendre`].
pub fn hamiltonian_legendre<T: Real, const N: usize, const D: usize>(
    h: &impl DoubledHamiltonian<T, N, D>,
    at: &MomentumPoint<T, N, D>,
    fault: Option<&Fault>,
) -> Result<Point<T, N, D>, VelocityError> {
    let found = hamiltonian::hamiltonian_legendre(h, at)?;
    Ok(Point { eta: blend(found.eta, -found.eta, FIBRE_SIGN.size_in(fault)), ..found })
}

/// k_f̃ with the force of the first copy alone.
pub const H_FORCE_ONCE: Fault =
    Fault::new("forced-hamiltonian-force-once", "k_f̃ = −⟨f̃(λ), τ⁻¹(U)⟩", "velocity-dependent forces, λ ≠ μ");
/// k_f̃ with the wrong sign.
pub const H_SIGN: Fault = Fault::new("forced-hamiltonian-sign", "h_f = h(μ) − h(λ) − k_f̃", "forced systems");
/// h_f with a wrong sign.
pub const H_PLUS: Fault = Fault::new("forced-hamiltonian-plus", "h_f = h(μ) + h(λ) + k_f̃", "every system");
/// ∂h_f/∂λ incomplete.
pub const H_NO_FORCE_DERIVATIVE: Fault = Fault::new(
    "forced-hamiltonian-no-force-derivative",
    "∂h_f/∂λ without the derivative of f̃",
    "velocity-dependent forces, off the units",
);

/// h_f, with a fault or without.
#[derive(Clone, Copy)]
pub struct PlantedHamiltonian<'a, T: Real, const N: usize, const D: usize> {
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

/// A case as a problem: its system, further numbers that the case determines, and what is planted.
pub struct Problem<'a, T: Real, const N: usize, const D: usize> {
    /// The system.
    pub system: &'a System<T, N, D>,
    /// The case, of which the draws are made.
    pub case: &'a dyn Debug,
    /// The numbers; of a law without a stream there are none.
    pub probe: Probe,
    /// What is planted.
    pub fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> Problem<'a, T, N, D> {
    /// The system of a case, with numbers from one of its streams or without.
    pub fn new(
        system: &'a System<T, N, D>,
        case: &'a dyn Debug,
        stream: Option<u64>,
        fault: Option<&'a Fault>,
    ) -> Self {
        let probe = stream.map_or_else(Probe::none, |stream| Probe::new(case, stream));
        Self { system, case, probe, fault }
    }

    /// The numbers of another stream of the case.
    pub fn draws(&self, stream: u64) -> Probe {
        Probe::new(self.case, stream)
    }

    /// A point off the units: η of the state, ψ that differs from it by shares `apart` of its size, U = τ(x) with |x| up to `far`.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform and of τ.
    pub fn off_the_units(&mut self, apart: f64, far: f64) -> Result<Point<T, N, D>, VelocityError> {
        let (system, probe) = (self.system, &mut self.probe);
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros())?;
        let psi = eta + probe.vector::<T, N>() * (unit_of(&eta) * T::exact(apart));
        let u = system.retraction.tau(&(probe.vector::<T, N>() * T::exact(far)))?;
        Ok(Point { time: system.state.time, eta, u, psi })
    }

    /// The group.
    ///
    /// # Errors
    /// There is none.
    pub fn group(&self) -> Result<&'a MatrixGroup<T, N, D>, Measured> {
        self.system.group.as_ref().ok_or_else(no_group)
    }

    /// [`turning`] on the algebra.
    pub fn turning(&self, xi: &Vector<T, N>, mu: &Covector<T, N>) -> T {
        turning(&self.system.algebra, xi, mu)
    }

    /// Units of round-off per dimension.
    pub fn floor(&self, units: f64) -> f64 {
        units * self.system.dimension as f64
    }
}

/// U = τ(x) with x made smaller until `change`, which is about proportional to x, is 1 at most.
///
/// # Errors
/// Those of `change` and of τ.
pub fn near_enough<T: Real, const N: usize, const D: usize>(
    tau: &AnyRetraction<T, N, D>,
    (mut u, mut x): (Matrix<T, D>, Vector<T, N>),
    change: impl Fn(&Matrix<T, D>) -> Result<T, VelocityError>,
) -> Result<Matrix<T, D>, VelocityError> {
    loop {
        let change = change(&u)?;
        if change <= T::one() || x.amax() < T::unit_roundoff() {
            return Ok(u);
        }
        x *= T::half() / change;
        u = tau.tau(&x)?;
    }
}

/// A group element that has no inverse.
pub fn singular() -> Measured {
    Measured::Broken("τ(x) is a singular matrix".into())
}

fn no_group() -> Measured {
    Measured::NotApplicable("the algebra has no group".into())
}

/// Which of the laws of a file.
pub trait Question: Copy {
    /// The stream of the case; `None` where nothing is drawn.
    const STREAM: Option<u64> = None;

    /// [`Visitor::LARGE`].
    const LARGE: bool = false;

    /// [`Visitor::KNOWS_CONFIGURATION`].
    const KNOWS_CONFIGURATION: bool = false;

    /// What the law measures.
    ///
    /// # Errors
    /// What it means that nothing can be measured: see [`refused`].
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer;
}

impl<T: Real, Q: Question> Visitor<T> for Check<'_, Q> {
    type Output = Measured;

    const LARGE: bool = Q::LARGE;

    const KNOWS_CONFIGURATION: bool = Q::KNOWS_CONFIGURATION;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Measured {
        let problem = Problem::new(&system, self.case, Q::STREAM, self.fault);
        self.which.measure(problem).unwrap_or_else(|refused| refused)
    }
}

/// A question that is judged in one scalar, by a bound of its own.
pub trait Trial<T: Real>: Copy {
    /// The stream of the case; `None` where nothing is drawn.
    const STREAM: Option<u64> = None;

    /// The verdict.
    ///
    /// # Errors
    /// What it means that there is none.
    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Result<Verdict, Measured>;
}

/// A [`Trial`] of a case.
struct Tried<'a, Q>(Check<'a, Q>);

impl<T: Real, Q: Trial<T>> Visitor<T> for Tried<'_, Q> {
    type Output = Verdict;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Verdict {
        let problem = Problem::new(&system, self.0.case, Q::STREAM, self.0.fault);
        self.0.which.judge(problem).unwrap_or_else(|measured| alone(digits::<T>(), measured))
    }
}

/// The verdict of a [`Trial`] on a case.
pub fn tried<T: Real, S: Source>(case: &S, fault: Option<&Fault>, which: impl Trial<T>) -> Verdict {
    case.visit::<T, _>(&Plant(fault), Tried(Check { case, fault, which })).unwrap_or_else(|e| unbuilt(&e))
}

/// The verdict on the system of a case in the main dimensions, in one scalar.
pub fn on_main<T: Real>(
    case: &Case,
    fault: Option<&Fault>,
    judge: impl FnOnce(&Main<T>) -> Result<Verdict, Measured>,
) -> Verdict {
    match case.main::<T>(&Plant(fault)) {
        Ok(system) => judge(&system).unwrap_or_else(|measured| alone(digits::<T>(), measured)),
        Err(e) => unbuilt(&e),
    }
}

/// What an error means for a law near the units: a group element off the domain says nothing, a Legendre transform that
/// cannot be inverted is a failure.
pub fn refused(error: VelocityError) -> Measured {
    match error {
        VelocityError::Legendre(error) => Measured::Broken(error.to_string()),
        VelocityError::Domain(RetractionError::NoGroup { .. }) => no_group(),
        VelocityError::Domain(_) => {
            Measured::NotApplicable("a group element is outside the domain of the retraction".into())
        }
    }
}

macro_rules! refusals {
    ($($error:ty),*) => {$(
        impl From<$error> for Measured {
            fn from(error: $error) -> Self {
                refused(error.into())
            }
        }
    )*};
}

refusals!(VelocityError, LegendreError, RetractionError);

/// n max|C| |ξ| |μ|, which ad*_ξ μ does not exceed: the size of its terms, also where they cancel; n is the last index of a constant
/// that is not 0.
pub fn turning<T: Real, const N: usize>(algebra: &LieAlgebra<T, N>, xi: &Vector<T, N>, mu: &Covector<T, N>) -> T {
    let (mut largest, mut last) = (T::zero(), 0);
    for a in 0..N {
        for b in 0..N {
            for c in 0..N {
                let constant = algebra.constant(a, b, c).abs();
                if constant > T::zero() {
                    (largest, last) = (largest.max(constant), last.max(a).max(b).max(c));
                }
            }
        }
    }
    largest * xi.amax() * mu.amax() * T::int(last as i64 + 1)
}

/// Π_ab = −C^d_ab μ_d, and the largest sum of the absolute values of its terms.
pub fn poisson<T: Real, const N: usize>(algebra: &LieAlgebra<T, N>, mu: &Covector<T, N>) -> (Matrix<T, N>, T) {
    let terms = |a: usize, b: usize| (0..N).map(move |d| algebra.constant(a, b, d) * mu[d]);
    let pi = Matrix::from_fn(|a, b| terms(a, b).fold(T::zero(), |sum, term| sum - term));
    let sizes = (0..N * N).map(|k| terms(k / N, k % N).fold(T::zero(), |sum, term| sum + term.abs()));
    (pi, sizes.fold(T::zero(), |size, v| size.max(v)))
}

/// |f| + |ad*_η μ| (1 + |ad_η| + |ad*_· μ|), by their [`turning`]: the size of a force f and of the terms that it is made
/// of. Forces of one or two brackets with coefficients up to 1 may vanish identically (an isotropic body on so(3)), and
/// are then rounding of terms of this size.
pub fn forcing<T: Real, const N: usize>(
    algebra: &LieAlgebra<T, N>,
    force: &Covector<T, N>,
    eta: &Vector<T, N>,
    mu: &Covector<T, N>,
) -> T {
    let ones = (Vector::from_element(T::one()), Covector::from_element(T::one()));
    let further = turning(algebra, eta, &ones.1) + turning(algebra, &ones.0, mu);
    force.amax() + turning(algebra, eta, mu) * (T::one() + further)
}
