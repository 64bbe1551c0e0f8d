//! Laws of one reduced Lagrangian: any [`Lagrangian`] that a user writes, with or without derivatives of its own.

use super::super::differences::{compared, slope};
use super::super::planted::{blend, blend_scalar};
use super::super::precision::Measured;
use super::part::{Answer, Answers, Asked, Kind, Part, off, part_laws};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, elimination, pair};
use crate::harness::{About, Cost, Fault};
use crate::mechanics::{Lagrangian, LegendreError};
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Real, Scalar};

const EVERY: &str = "every Lagrangian";
const SOURCE: &str = "definition of the Legendre transform; Martín de Diego and Sato Martín de Almagro 2019, §2";
const BOUND: &str = "two precisions; floor 2⁶ N u relative to |l'| + N |l''| (|η| + v), v a quarter of the largest velocity; times \
                     N |l''⁻¹| for velocities";
const DIFFERENCES: &str = "2⁸ times the estimated error of the differences with 2⁶ N u; in each precision by itself";

const VALUE_CONSTANT: Fault =
    Fault::new("value-constant", "l evaluated on values alone: its derivatives by duals are 0", EVERY);
const VALUE_NAN: Fault = Fault::new("value-nan", "l is NaN where η_1 > 0", EVERY);
const GRADIENT_DOUBLED: Fault = Fault::new("gradient-doubled", "l' doubled", EVERY);
const GRADIENT_SWAPPED: Fault =
    Fault::new("gradient-swapped", "l' with the first two components exchanged", "dimension 2 and more");
const HESSIAN_DOUBLED: Fault = Fault::new("hessian-doubled", "l'' doubled", EVERY);
const HESSIAN_ASYMMETRIC: Fault =
    Fault::new("hessian-asymmetric", "|l''| added to the entry (1, 2) of l''", "dimension 2 and more");
const HESSIAN_SINGULAR: Fault = Fault::new("hessian-singular", "the first row and column of l'' replaced by 0", EVERY);
const VELOCITY_DOUBLED: Fault = Fault::new("velocity-doubled", "(l')⁻¹ doubled", EVERY);
const VELOCITY_CONSTANT: Fault =
    Fault::new("velocity-constant", "(l')⁻¹ evaluated on values alone: its derivative is 0", EVERY);
const ENERGY_SIGN: Fault = Fault::new("energy-sign", "⟨l', η⟩ + l instead of ⟨l', η⟩ − l", EVERY);

const fn about(
    statement: &'static str,
    oracle: &'static str,
    bound: &'static str,
    needs: &'static str,
    faults: &'static [Fault],
) -> About {
    About { name: "", statement, source: SOURCE, oracle, bound, needs, faults, cost: Cost::Cheap }
}

part_laws! {
    /// The laws of this file.
    LAWS FIELDS __own_lagrangian;
    every {
        lagrangian_value "eta along" about(
            "l is finite, and the same on dual numbers; its derivative by duals is that of its values",
            "differences of l, extrapolated to fourth order",
            DIFFERENCES,
            "",
            &[VALUE_CONSTANT, VALUE_NAN],
        );
        lagrangian_gradient "eta" about(
            "`gradient` is l'",
            "l on dual numbers",
            BOUND,
            "",
            &[GRADIENT_DOUBLED, GRADIENT_SWAPPED, VALUE_CONSTANT, VALUE_NAN],
        );
        lagrangian_hessian "eta" about(
            "`hessian` is l'', and symmetric",
            "l on dual numbers of dual numbers",
            BOUND,
            "",
            &[HESSIAN_DOUBLED, HESSIAN_ASYMMETRIC, HESSIAN_SINGULAR, VALUE_CONSTANT],
        );
        lagrangian_regular "eta" about(
            "l''(η) is regular to working precision",
            "elimination with pivoting, by the condition number of Skeel",
            "none: regular or not",
            "regular everywhere (unless `not_regular` says otherwise)",
            &[HESSIAN_SINGULAR],
        );
        lagrangian_velocity "eta mu along" about(
            "velocity(l'(η), η) = η, l'(velocity(μ, 0)) = μ, and the derivative of `velocity` is l''⁻¹",
            "`gradient` and `hessian`",
            BOUND,
            "regular everywhere (unless `not_regular` says otherwise)",
            &[VELOCITY_DOUBLED, VELOCITY_CONSTANT, GRADIENT_DOUBLED, GRADIENT_SWAPPED, HESSIAN_DOUBLED, HESSIAN_ASYMMETRIC],
        );
        lagrangian_energy "eta" about(
            "`energy` is E(η) = d/ds l(s η) − l(η) at s = 1",
            "l on dual numbers",
            BOUND,
            "",
            &[ENERGY_SIGN, VALUE_NAN],
        );
    }
}

/// A user's Lagrangian. The largest number of a case is that of velocities and momenta.
#[doc(hidden)]
pub type UserLagrangian<const N: usize> = Part<LagrangianLaws<N>>;

/// The laws on Lagrangians.
#[derive(Default)]
#[doc(hidden)]
pub struct LagrangianLaws<const N: usize> {
    singular: bool,
}

impl<const N: usize> UserLagrangian<N> {
    /// l'' may be singular: the laws of regularity and of the inverse Legendre transform are switched off.
    pub fn not_regular(mut self) -> Self {
        self.kind.singular = true;
        self
    }
}

impl<const N: usize> Kind for LagrangianLaws<N> {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const DIMENSION: usize = N;
    const LARGEST: f64 = 4.0;
    const APART: &'static [&'static str] = &["lagrangian-value"];

    fn missing(&self, law: &str) -> Option<&'static str> {
        let needed = matches!(law, "lagrangian-regular" | "lagrangian-velocity");
        (needed && self.singular).then_some("the Lagrangian is said not to be regular")
    }
}

impl<T: Real, L, const N: usize> Answers<T, LagrangianLaws<N>> for L
where
    L: Lagrangian<T, N> + Send + Sync + 'static,
{
    fn answer(&self, asked: &Asked<'_, LagrangianLaws<N>>) -> Answer {
        let l = Planted { lagrangian: self, fault: asked.fault };
        let judge = Judge { l, asked, eta: asked.case.vector("eta")?, typical: T::exact(asked.largest / 4.0) };
        match asked.law.name {
            "lagrangian-value" => judge.value(),
            "lagrangian-gradient" => judge.gradient(),
            "lagrangian-hessian" => judge.hessian(),
            "lagrangian-regular" => judge.regular(),
            "lagrangian-velocity" => judge.velocity(),
            "lagrangian-energy" => judge.energy(),
            _ => asked.unknown("Lagrangians"),
        }
    }
}

/// A Lagrangian with a fault planted in it.
struct Planted<'a, L> {
    lagrangian: &'a L,
    fault: Option<&'a Fault>,
}

impl<T: Real, L: Lagrangian<T, N>, const N: usize> Lagrangian<T, N> for Planted<'_, L> {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let right = self.lagrangian.value(eta);
        if VALUE_NAN.size_in(self.fault) > 0.0 && eta[0] > S::zero() {
            return S::exact(f64::NAN);
        }
        blend_scalar(right, S::lift(right.base()), VALUE_CONSTANT.size_in(self.fault))
    }

    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        let right = self.lagrangian.gradient(eta);
        let right = blend(right, right * S::int(2), GRADIENT_DOUBLED.size_in(self.fault));
        let swapped = GRADIENT_SWAPPED.size_in(self.fault);
        if swapped > 0.0 && N > 1 {
            let mut wrong = right;
            wrong.swap_columns(0, 1);
            return blend(right, wrong, swapped);
        }
        right
    }

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        let right = self.lagrangian.hessian(eta);
        let right = blend(right, right * S::int(2), HESSIAN_DOUBLED.size_in(self.fault));
        let asymmetric = HESSIAN_ASYMMETRIC.size_in(self.fault);
        if asymmetric > 0.0 && N > 1 {
            let mut wrong = right;
            wrong[(0, 1)] += right.amax();
            return blend(right, wrong, asymmetric);
        }
        let singular = Matrix::from_fn(|a, b| if a == 0 || b == 0 { S::zero() } else { right[(a, b)] });
        blend(right, singular, HESSIAN_SINGULAR.size_in(self.fault))
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        let right = self.lagrangian.velocity(mu, guess)?;
        let right = blend(right, right * S::int(2), VELOCITY_DOUBLED.size_in(self.fault));
        Ok(blend(right, right.map(|v| S::lift(v.base())), VELOCITY_CONSTANT.size_in(self.fault)))
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let right = self.lagrangian.energy(eta);
        let value = self.lagrangian.value(eta);
        blend_scalar(right, right + value + value, ENERGY_SIGN.size_in(self.fault))
    }
}

struct Judge<'a, T: Real, L, const N: usize> {
    l: Planted<'a, L>,
    asked: &'a Asked<'a, LagrangianLaws<N>>,
    eta: Vector<T, N>,
    /// A velocity of the middle of the domain.
    typical: T,
}

impl<T: Real, L: Lagrangian<T, N>, const N: usize> Judge<'_, T, L, N> {
    fn floor(&self) -> f64 {
        64.0 * N as f64
    }

    fn defect(&self, off: T, size: T, witness: impl FnOnce() -> String) -> Measured {
        Measured::defect(off, size, self.floor(), witness)
    }

    /// |l'| + N |l''| (|η| + v), v typical: what cancels in l for small η (as in 1 − √(1 − |η|²)) is of this size.
    fn size(&self, eta: &Vector<T, N>) -> T {
        let raw = self.l.lagrangian;
        raw.gradient(eta).amax() + raw.hessian(eta).amax() * (eta.amax() + self.typical) * T::int(N as i64)
    }

    fn value(&self) -> Answer {
        let value = self.l.value(&self.eta);
        if !value.all_finite() {
            return Ok(Measured::Broken(format!("l(η) = {}", value.to_f64())));
        }
        let direction = self.asked.case.vector::<T, N>("along")?;
        let dual = self.l.value(&moving(&self.eta, &direction));
        let same = self.l.value(&moving(&self.eta, &Vector::zeros()));
        let (scale, length) = (self.eta.amax().max(self.typical), direction.amax());
        let constant = same.eps == T::zero() && same.re == value && dual.re == value;
        if !constant {
            let near = (dual.re - value).abs().max((same.re - value).abs()).max(same.eps.abs());
            let size = value.abs().max(self.size(&self.eta) * scale);
            let allowed = T::exact(self.floor()) * T::unit_roundoff() * size;
            let small = near <= allowed;
            if !small {
                return Ok(Measured::Broken("l differs on dual numbers, or has a derivative on constants".into()));
            }
        }
        if length == T::zero() {
            return Ok(Measured::exact());
        }
        let value = |s: T| Some(self.l.lagrangian.value(&(self.eta + direction * s))).filter(|v| v.all_finite());
        let size = self.size(&self.eta) * length;
        let slope = slope(value, scale / length, size);
        let slope = slope.ok_or(Measured::NotApplicable("l is not finite nearby".into()))?;
        Ok(compared(dual.eps, &slope, size, T::zero(), self.floor(), "l along a direction"))
    }

    fn gradient(&self) -> Answer {
        let mine = self.l.gradient(&self.eta);
        let expected = Covector::<T, N>::from_fn(|_, a| self.l.value(&moving(&self.eta, &basis_vector::<T, N>(a))).eps);
        Ok(self.defect(off(&mine, &expected), self.size(&self.eta), || {
            format!("gradient {}, by duals {}", list(mine.iter()), list(expected.iter()))
        }))
    }

    fn hessian(&self) -> Answer {
        let mine = self.l.hessian(&self.eta);
        let expected = Matrix::<T, N>::from_fn(|a, b| {
            let inner = moving(&self.eta, &basis_vector::<T, N>(a));
            let outer = basis_vector::<T, N>(b).map(Dual::constant);
            self.l.value(&moving(&inner, &outer)).eps.eps
        });
        let size = self.l.lagrangian.hessian(&self.eta).amax();
        let symmetric = self.defect(off(&mine, &mine.transpose()), size, || "l'' is not symmetric".into());
        Ok(symmetric.and(self.defect(off(&mine, &expected), size, || "hessian differs from that by duals".into())))
    }

    fn regular(&self) -> Answer {
        match elimination::regular_inverse(&self.l.hessian(&self.eta)) {
            Ok(_) => Ok(Measured::exact()),
            Err(why) => Ok(Measured::Broken(format!("l''(η) is not regular: {why}"))),
        }
    }

    fn velocity(&self) -> Answer {
        let l = &self.l;
        let refused = |error: LegendreError| match error {
            LegendreError::Singular { .. } => Measured::Inconclusive("the Hessian is singular".into()),
            LegendreError::NotConverged { .. } => Measured::Inconclusive("`velocity` did not converge".into()),
            LegendreError::BadInertia { .. } | LegendreError::BadTerm { .. } => Measured::Broken(error.to_string()),
        };
        let finite = |v: &Vector<T, N>| match v.iter().all(|v| v.all_finite()) {
            true => Ok(()),
            false => Err(Measured::Broken("`velocity` is not finite".into())),
        };
        let count = T::int(N as i64);
        let back = l.velocity(&l.gradient(&self.eta), &self.eta).map_err(refused)?;
        finite(&back)?;
        let hessian = l.lagrangian.hessian(&self.eta);
        let inverse = elimination::inverse(&hessian);
        let inverse = inverse.ok_or_else(|| Measured::Inconclusive("the Hessian is singular".into()))?;
        let size = inverse.amax() * self.size(&self.eta) * count;
        let forth = self.defect(off(&back, &self.eta), size, || format!("velocity(l'(η), η) = {}", list(back.iter())));

        let mu = self.asked.case.covector::<T, N>("mu")?;
        let eta = l.velocity(&mu, &Vector::zeros()).map_err(refused)?;
        finite(&eta)?;
        let again = l.gradient(&eta);
        let size = mu.amax() + self.size(&eta);
        let round = self.defect(off(&again, &mu), size, || format!("l'(velocity(μ, 0)) = {}", list(again.iter())));

        let direction = self.asked.case.covector::<T, N>("along")?;
        let moved = moving(&mu, &direction);
        let slopes = l.velocity(&moved, &eta.map(Dual::constant)).map_err(refused)?.map(|v| v.eps);
        let hessian = l.lagrangian.hessian(&eta);
        let turned = (l.hessian(&eta) * slopes).transpose();
        let inverse = elimination::inverse(&hessian).map_or(T::zero(), |inverse| inverse.amax());
        let size = direction.amax() * (T::one() + count * hessian.amax() * inverse);
        let slope = self.defect(off(&turned, &direction), size, || "l'' times the derivative of `velocity` ≠ 1".into());
        Ok(forth.and(round).and(slope))
    }

    fn energy(&self) -> Answer {
        let mine = self.l.energy(&self.eta);
        let scaled = self.l.value(&moving(&self.eta, &self.eta));
        let terms = pair(&self.l.lagrangian.gradient(&self.eta).abs(), &self.eta.abs());
        let size = terms + scaled.re.abs() + self.size(&self.eta) * (self.eta.amax() + self.typical);
        let expected = scaled.eps - scaled.re;
        Ok(self.defect((mine - expected).abs(), size, || {
            format!("energy {:e}, by duals {:e}", mine.to_f64(), expected.to_f64())
        }))
    }
}

/// Numbers as they are printed in a witness.
pub(super) fn list<'a, T: Real>(entries: impl Iterator<Item = &'a T>) -> String {
    let entries: Vec<String> = entries.map(|v| format!("{:.6e}", v.to_f64())).collect();
    format!("[{}]", entries.join(", "))
}
