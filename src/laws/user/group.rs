//! Laws of one Lie group in matrices: any [`LieGroup`] that a user writes.
//!
//! Group elements are exp(x̂), by a Taylor series of the laws themselves, of vectors x of the case: nothing of the group is trusted
//! but that `hat` gives matrices of its algebra, and that is a law as well.

use super::super::method::exponential;
use super::super::planted::blend;
use super::super::precision::Measured;
use super::part::{Answer, Answers, Asked, Kind, Part, off, part_laws};
use super::values::ValuesError;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, basis_vector, elimination, pair};
use crate::group::LieGroup;
use crate::harness::{About, Cost, Fault};
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Real, Scalar};

const NONABELIAN: &str = "non-abelian groups";
const EVERY: &str = "every group";
const SOURCE: &str = "definition of a matrix Lie group with a basis of its algebra (Hall 2015, ch. 3)";
const BOUND: &str = "two precisions; floor 2⁶ N D u relative to |g| |g⁻¹| |ê_a| and the largest coefficient of vee";

/// A basis in another order than vee has.
const HAT_INDEX: Fault =
    Fault::new("hat-index", "x̂ with the first two coordinates exchanged", "groups of dimension 2 and more");
const HAT_QUADRATIC: Fault = Fault::new("hat-quadratic", "x̂ replaced by hat(x + ½|x|² e_1)", EVERY);
const VEE_DOUBLED: Fault = Fault::new("vee-doubled", "vee doubled", EVERY);
const CONSTANTS_SIGN: Fault = Fault::new("constants-sign", "C^c_ab replaced by C^c_ba", NONABELIAN);
/// The inverse of an orthogonal group.
const INVERSE_TRANSPOSED: Fault =
    Fault::new("inverse-transposed", "g⁻¹ replaced by gᵀ", "groups that are not orthogonal");
const INVERSE_MISSING: Fault = Fault::new("inverse-missing", "g⁻¹ replaced by g", EVERY);
const PRODUCT_SWAPPED: Fault = Fault::new("product-swapped", "g h replaced by h g", NONABELIAN);
const SECOND_TRANSPOSED: Fault = Fault::new("second-transposed", "g h replaced by g hᵀ", EVERY);
const IDENTITY_DOUBLED: Fault = Fault::new("identity-doubled", "e replaced by twice e", EVERY);
/// Rows for columns.
const ADJOINT_TRANSPOSED: Fault = Fault::new("adjoint-transposed", "Ad_g replaced by its transpose", NONABELIAN);
const ADJOINT_INVERTED: Fault = Fault::new("group-adjoint-inverted", "Ad_g replaced by Ad_{g⁻¹}", NONABELIAN);
/// The other convention.
const COADJOINT_INVERTED: Fault =
    Fault::new("group-coadjoint-inverted", "Ad*_g μ = μ Ad_{g⁻¹} instead of μ Ad_g", NONABELIAN);
/// Duals lost.
const ADJOINT_CONSTANT: Fault =
    Fault::new("adjoint-constant", "Ad_g evaluated on values alone: its derivative is 0", NONABELIAN);
const INVERSE_CONSTANT: Fault =
    Fault::new("inverse-constant", "g⁻¹ evaluated on values alone: its derivative is 0", EVERY);
const DISTANCE_ONE_SIDED: Fault = Fault::new("distance-one-sided", "the largest entry of g − h, not of |g − h|", EVERY);
const DISTANCE_SQUARED: Fault = Fault::new("distance-squared", "the square of the distance", EVERY);
const DISTANCE_ZERO: Fault = Fault::new("distance-zero", "the distance 0 between any two elements", EVERY);

const fn about(statement: &'static str, oracle: &'static str, faults: &'static [Fault]) -> About {
    About { name: "", statement, source: SOURCE, oracle, bound: BOUND, needs: "", faults, cost: Cost::Cheap }
}

part_laws! {
    /// The laws of this file.
    LAWS FIELDS __own_group;
    every {
        group_hat_linear "a# x y" about("hat(a x + y) = a x̂ + ŷ", "hat itself, at other vectors", &[HAT_QUADRATIC]);
        group_vee_hat "x" about(
            "vee(x̂) = x",
            "the vector that the matrix was made from",
            &[HAT_INDEX, HAT_QUADRATIC, VEE_DOUBLED],
        );
        group_bracket "x y" about(
            "hat([x, y]) = x̂ŷ − ŷx̂",
            "the commutator of matrices, against the structure constants of `algebra`",
            &[CONSTANTS_SIGN, HAT_INDEX, HAT_QUADRATIC],
        );
        group_algebra_invariant "g y" about(
            "g⁻¹ŷg = hat(vee(g⁻¹ŷg)) for g = exp(x̂): the span of hat is an algebra, and exp(x̂) normalises it",
            "conjugation of matrices, the inverse by elimination",
            &[HAT_QUADRATIC, VEE_DOUBLED],
        );
        group_product "g h" about(
            "compose(g, h) is the matrix product",
            "the product of nalgebra",
            &[PRODUCT_SWAPPED, SECOND_TRANSPOSED],
        );
        group_associative "g h k" about("g(hk) = (gh)k", "compose itself, in another order", &[SECOND_TRANSPOSED]);
        group_identity "g" about(
            "e g = g = g e, and e = exp(0)",
            "the element itself",
            &[IDENTITY_DOUBLED, SECOND_TRANSPOSED],
        );
        group_inverse "g h" about(
            "g⁻¹g = e = g g⁻¹, (gh)⁻¹ = h⁻¹g⁻¹",
            "identity and compose",
            &[INVERSE_TRANSPOSED, INVERSE_MISSING, SECOND_TRANSPOSED, IDENTITY_DOUBLED],
        );
        group_adjoint "g x" about(
            "Ad_g x = vee(g x̂ g⁻¹)",
            "conjugation of matrices, the inverse by elimination",
            &[ADJOINT_TRANSPOSED, ADJOINT_INVERTED],
        );
        group_adjoint_product "g h" about(
            "Ad_{gh} = Ad_g Ad_h",
            "the product of matrices N×N",
            &[ADJOINT_TRANSPOSED, ADJOINT_INVERTED, PRODUCT_SWAPPED],
        );
        group_adjoint_automorphism "g x y" about(
            "Ad_g[x, y] = [Ad_g x, Ad_g y]",
            "the structure constants of `algebra`",
            &[ADJOINT_TRANSPOSED],
        );
        group_adjoint_exponential "g" about(
            "Ad_{exp x̂} = exp(ad_x)",
            "the series of exp in N×N, from the structure constants of `algebra`",
            &[ADJOINT_TRANSPOSED, ADJOINT_INVERTED, CONSTANTS_SIGN],
        );
        group_coadjoint "g mu x" about("Ad*_g μ = μ Ad_g, and ⟨Ad*_g μ, x⟩ = ⟨μ, Ad_g x⟩", "`adjoint`", &[COADJOINT_INVERTED]);
        group_derivatives "g h x y" about(
            "along g(1 + ε x̂): g⁻¹ has the derivative −x̂g⁻¹, Ad_g the derivative Ad_g ad_x, gh the derivative g x̂ h",
            "these formulas; the group on dual numbers",
            &[ADJOINT_CONSTANT, INVERSE_CONSTANT, INVERSE_TRANSPOSED, INVERSE_MISSING, PRODUCT_SWAPPED],
        );
        group_distance "g h k" about(
            "d(g, g) = 0 < d(g, h) = d(h, g) ≤ d(g, k) + d(k, h) for g ≠ h",
            "the axioms of a metric",
            &[DISTANCE_ONE_SIDED, DISTANCE_SQUARED, DISTANCE_ZERO],
        );
    }
}

/// A user's group. Its elements are exp(x̂) with |x_a| of at most the largest number of a case.
#[doc(hidden)]
pub type UserGroup<const N: usize, const D: usize> = Part<GroupLaws<N, D>>;

/// The laws on groups.
#[derive(Default)]
#[doc(hidden)]
pub struct GroupLaws<const N: usize, const D: usize>;

impl<const N: usize, const D: usize> Kind for GroupLaws<N, D> {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const DIMENSION: usize = N;
    const LARGEST: f64 = 2.0 * std::f64::consts::PI;
}

impl<T: Real, G, const N: usize, const D: usize> Answers<T, GroupLaws<N, D>> for G
where
    G: LieGroup<T, N, D> + Send + Sync + 'static,
{
    fn answer(&self, asked: &Asked<'_, GroupLaws<N, D>>) -> Answer {
        let mut gains = Vector::<T, N>::zeros();
        for entry in 0..D * D {
            let mut unit = Matrix::<T, D>::zeros();
            unit[entry] = T::one();
            gains += self.vee(&unit).abs();
        }
        let hats = Vector::<T, N>::from_fn(|a, _| self.hat(&basis_vector::<T, N>(a)).amax());
        let planted = Planted::new(self, asked.fault);
        let judge = Judge { group: planted, asked, hats, gain: gains.amax(), floor: 64.0 * (N * D) as f64 };
        match asked.law.name {
            "group-hat-linear" => judge.hat_linear(),
            "group-vee-hat" => judge.vee_hat(),
            "group-bracket" => judge.bracket(),
            "group-algebra-invariant" => judge.algebra_invariant(),
            "group-product" => judge.product(),
            "group-associative" => judge.associative(),
            "group-identity" => judge.identity(),
            "group-inverse" => judge.inverse(),
            "group-adjoint" => judge.adjoint(),
            "group-adjoint-product" => judge.adjoint_product(),
            "group-adjoint-automorphism" => judge.adjoint_automorphism(),
            "group-adjoint-exponential" => judge.adjoint_exponential(),
            "group-coadjoint" => judge.coadjoint(),
            "group-derivatives" => judge.derivatives(),
            "group-distance" => judge.distance(),
            _ => asked.unknown("groups"),
        }
    }
}

/// Elements beyond this size say more about overflow than about the group.
const LARGEST: f64 = 65536.0;

/// A group with a fault planted in it.
struct Planted<'a, T: Real, G, const N: usize> {
    group: &'a G,
    algebra: LieAlgebra<T, N>,
    fault: Option<&'a Fault>,
}

impl<'a, T: Real, G, const N: usize> Planted<'a, T, G, N> {
    fn new<const D: usize>(group: &'a G, fault: Option<&'a Fault>) -> Self
    where
        G: LieGroup<T, N, D>,
    {
        let right = group.algebra();
        let sign = T::one() - T::exact(2.0 * CONSTANTS_SIGN.size_in(fault));
        let algebra = match Fault::planted(fault, CONSTANTS_SIGN.name) {
            true => LieAlgebra::unchecked(|a, b, c| right.constant(a, b, c) * sign),
            false => right.clone(),
        };
        Self { group, algebra, fault }
    }
}

fn constant<S: Scalar, const R: usize, const C: usize>(m: nalgebra::SMatrix<S, R, C>) -> nalgebra::SMatrix<S, R, C> {
    m.map(|v| S::lift(v.base()))
}

impl<T: Real, G: LieGroup<T, N, D>, const N: usize, const D: usize> LieGroup<T, N, D> for Planted<'_, T, G, N> {
    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, D> {
        let right = self.group.hat(xi);
        let (index, quadratic) = (HAT_INDEX.size_in(self.fault), HAT_QUADRATIC.size_in(self.fault));
        if index > 0.0 && N > 1 {
            let mut swapped = *xi;
            swapped.swap_rows(0, 1);
            return blend(right, self.group.hat(&swapped), index);
        }
        if quadratic > 0.0 {
            let shifted = xi + basis_vector::<S, N>(0) * (xi.dot(xi) * S::half());
            return blend(right, self.group.hat(&shifted), quadratic);
        }
        right
    }

    fn vee<S: Scalar<Base = T>>(&self, matrix: &Matrix<S, D>) -> Vector<S, N> {
        let right = self.group.vee(matrix);
        blend(right, right * S::int(2), VEE_DOUBLED.size_in(self.fault))
    }

    fn identity<S: Scalar<Base = T>>(&self) -> Matrix<S, D> {
        let right = self.group.identity();
        blend(right, right * S::int(2), IDENTITY_DOUBLED.size_in(self.fault))
    }

    fn compose<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, h: &Matrix<S, D>) -> Matrix<S, D> {
        let right = self.group.compose(g, h);
        let right = blend(right, self.group.compose(h, g), PRODUCT_SWAPPED.size_in(self.fault));
        blend(right, self.group.compose(g, &h.transpose()), SECOND_TRANSPOSED.size_in(self.fault))
    }

    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Option<Matrix<S, D>> {
        let right = self.group.inverse(g)?;
        let right = blend(right, g.transpose(), INVERSE_TRANSPOSED.size_in(self.fault));
        let right = blend(right, *g, INVERSE_MISSING.size_in(self.fault));
        Some(blend(right, constant(right), INVERSE_CONSTANT.size_in(self.fault)))
    }

    fn adjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Option<Matrix<S, N>> {
        let right = self.group.adjoint(g)?;
        let inverted = ADJOINT_INVERTED.size_in(self.fault);
        if inverted > 0.0 {
            return Some(blend(right, self.group.adjoint(&self.group.inverse(g)?)?, inverted));
        }
        let right = blend(right, right.transpose(), ADJOINT_TRANSPOSED.size_in(self.fault));
        Some(blend(right, constant(right), ADJOINT_CONSTANT.size_in(self.fault)))
    }

    fn coadjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, mu: &Covector<S, N>) -> Option<Covector<S, N>> {
        let right = self.group.coadjoint(g, mu)?;
        let inverted = COADJOINT_INVERTED.size_in(self.fault);
        if inverted > 0.0 {
            return Some(blend(right, self.group.coadjoint(&self.group.inverse(g)?, mu)?, inverted));
        }
        Some(right)
    }

    fn distance<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, h: &Matrix<S, D>) -> T {
        let right = self.group.distance(g, h);
        let mix = |wrong: T, fault: &Fault| (wrong - right) * T::exact(fault.size_in(self.fault));
        let one_sided = (g - h).iter().fold(T::zero(), |size, v| size.max(v.base()));
        right
            + mix(one_sided, &DISTANCE_ONE_SIDED)
            + mix(right * right, &DISTANCE_SQUARED)
            + mix(T::zero(), &DISTANCE_ZERO)
    }
}

/// A group under test with the sizes of its maps.
struct Judge<'a, T: Real, G, const N: usize, const D: usize> {
    group: Planted<'a, T, G, N>,
    asked: &'a Asked<'a, GroupLaws<N, D>>,
    /// |ê_a|.
    hats: Vector<T, N>,
    /// max_a Σ_rc |vee(E_rc)_a|.
    gain: T,
    floor: f64,
}

impl<T: Real, G: LieGroup<T, N, D>, const N: usize, const D: usize> Judge<'_, T, G, N, D> {
    fn vector(&self, name: &str) -> Result<Vector<T, N>, ValuesError> {
        self.asked.case.vector(name)
    }

    /// exp of the vector called `name`.
    fn element(&self, name: &str) -> Result<Matrix<T, D>, Measured> {
        let g = exponential(&self.group.group.hat(&self.vector(name)?));
        match g.iter().all(|v| v.all_finite()) {
            true if g.amax() <= T::exact(LARGEST) => Ok(g),
            true => Err(Measured::NotApplicable("a group element is too large".into())),
            false => Err(Measured::NotApplicable("a group element is not finite".into())),
        }
    }

    /// Σ_a |x_a| |ê_a|.
    fn hat_size(&self, x: &Vector<T, N>) -> T {
        x.abs().dot(&self.hats)
    }

    fn defect(&self, off: T, size: T, witness: impl FnOnce() -> String) -> Measured {
        Measured::defect(off, size, self.floor, witness)
    }

    /// g⁻¹ by elimination.
    fn eliminated(&self, g: &Matrix<T, D>) -> Result<Matrix<T, D>, Measured> {
        elimination::inverse(g).ok_or_else(|| Measured::Broken("exp(x̂) is a singular matrix".into()))
    }

    fn inverse_of<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Matrix<S, D>, Measured> {
        self.group.inverse(g).ok_or_else(|| Measured::Broken("`inverse` gives None for exp(x̂)".into()))
    }

    fn adjoint_of<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Matrix<S, N>, Measured> {
        self.group.adjoint(g).ok_or_else(|| Measured::Broken("`adjoint` gives None for exp(x̂)".into()))
    }

    /// |g| |g⁻¹|.
    fn conditioned(&self, g: &Matrix<T, D>) -> Result<T, Measured> {
        Ok(g.amax() * self.eliminated(g)?.amax())
    }

    /// The size of the terms of Ad_g by conjugation.
    fn adjoint_size(&self, g: &Matrix<T, D>) -> Result<T, Measured> {
        Ok(self.conditioned(g)? * self.hats.amax() * self.gain)
    }

    fn hat_linear(&self) -> Answer {
        let a = self.asked.case.number::<T>("a")?;
        let (x, y) = (self.vector("x")?, self.vector("y")?);
        let (mine, sum) = (self.group.hat(&(x * a + y)), self.group.hat(&x) * a + self.group.hat(&y));
        let size = self.hat_size(&x) * a.abs() + self.hat_size(&y);
        Ok(self.defect(off(&mine, &sum), size, || "hat(a x + y) ≠ a x̂ + ŷ".into()))
    }

    fn vee_hat(&self) -> Answer {
        let x = self.vector("x")?;
        let back = self.group.vee(&self.group.hat(&x));
        let size = self.hat_size(&x) * self.gain;
        Ok(self.defect(off(&back, &x), size, || format!("vee(x̂) = {back:.6e}").replace('\n', " ")))
    }

    fn bracket(&self) -> Answer {
        let (x, y) = (self.vector("x")?, self.vector("y")?);
        let (hat_x, hat_y) = (self.group.hat(&x), self.group.hat(&y));
        let bracket = self.group.algebra().bracket::<T>(&x, &y);
        let commutator = hat_x * hat_y - hat_y * hat_x;
        let size = self.hat_size(&x) * self.hat_size(&y) + self.hat_size(&bracket);
        Ok(self.defect(off(&self.group.hat(&bracket), &commutator), size, || "hat([x, y]) ≠ x̂ŷ − ŷx̂".into()))
    }

    fn algebra_invariant(&self) -> Answer {
        let (g, y) = (self.element("g")?, self.vector("y")?);
        let turned = self.eliminated(&g)? * self.group.hat(&y) * g;
        let projected = self.group.hat(&self.group.vee(&turned));
        let size = self.conditioned(&g)? * self.hat_size(&y);
        let size = size.max(size * self.gain * self.hats.amax());
        Ok(self.defect(off(&projected, &turned), size, || "g⁻¹ŷg is not in the span of hat".into()))
    }

    fn product(&self) -> Answer {
        let (g, h) = (self.element("g")?, self.element("h")?);
        let off = off(&self.group.compose(&g, &h), &(g * h));
        Ok(self.defect(off, g.amax() * h.amax(), || "compose(g, h) is not the matrix product".into()))
    }

    fn associative(&self) -> Answer {
        let (g, h, k) = (self.element("g")?, self.element("h")?, self.element("k")?);
        let by = |a: &Matrix<T, D>, b: &Matrix<T, D>| self.group.compose(a, b);
        let off = off(&by(&g, &by(&h, &k)), &by(&by(&g, &h), &k));
        Ok(self.defect(off, g.amax() * h.amax() * k.amax(), || "g(hk) ≠ (gh)k".into()))
    }

    fn identity(&self) -> Answer {
        let (g, e) = (self.element("g")?, self.group.identity::<T>());
        let zero = exponential(&self.group.hat(&Vector::<T, N>::zeros()));
        let near = |m: &Matrix<T, D>, what: &'static str| self.defect(off(m, &g), g.amax(), || what.into());
        let unit = self.defect(off(&e, &zero), T::one(), || "e ≠ exp(0)".into());
        Ok(near(&self.group.compose(&e, &g), "e g ≠ g").and(near(&self.group.compose(&g, &e), "g e ≠ g")).and(unit))
    }

    fn inverse(&self) -> Answer {
        let (g, h, e) = (self.element("g")?, self.element("h")?, self.group.identity::<T>());
        let (back, back_h) = (self.inverse_of(&g)?, self.inverse_of(&h)?);
        let (size, size_h) = (self.conditioned(&g)?, self.conditioned(&h)?);
        let left = self.defect(off(&self.group.compose(&back, &g), &e), size, || "g⁻¹g ≠ e".into());
        let right = self.defect(off(&self.group.compose(&g, &back), &e), size, || "g g⁻¹ ≠ e".into());
        let both = self.inverse_of(&self.group.compose(&g, &h))?;
        let turned = self.group.compose(&back_h, &back);
        let terms = back.amax() * back_h.amax() * size * size_h;
        Ok(left.and(right).and(self.defect(off(&both, &turned), terms, || "(gh)⁻¹ ≠ h⁻¹g⁻¹".into())))
    }

    fn adjoint(&self) -> Answer {
        let (g, x) = (self.element("g")?, self.vector("x")?);
        let conjugated = self.group.vee(&(g * self.group.hat(&x) * self.eliminated(&g)?));
        let size = self.adjoint_size(&g)? * x.amax();
        Ok(self.defect(off(&(self.adjoint_of(&g)? * x), &conjugated), size, || "Ad_g x ≠ (g x̂ g⁻¹)^∨".into()))
    }

    fn adjoint_product(&self) -> Answer {
        let (g, h) = (self.element("g")?, self.element("h")?);
        let whole = self.adjoint_of(&self.group.compose(&g, &h))?;
        let parts = self.adjoint_of(&g)? * self.adjoint_of(&h)?;
        let size = self.conditioned(&g)? * self.conditioned(&h)? * self.hats.amax() * self.gain;
        let size = size.max(self.adjoint_size(&g)? * self.adjoint_size(&h)?);
        Ok(self.defect(off(&whole, &parts), size, || "Ad_{gh} ≠ Ad_g Ad_h".into()))
    }

    fn adjoint_automorphism(&self) -> Answer {
        let (g, x, y) = (self.element("g")?, self.vector("x")?, self.vector("y")?);
        let ad = self.adjoint_of(&g)?;
        let algebra = self.group.algebra();
        let (outside, inside) = (ad * algebra.bracket(&x, &y), algebra.bracket(&(ad * x), &(ad * y)));
        let size = self.adjoint_size(&g)?;
        let size = algebra.size() * x.amax() * y.amax() * (size + size * size);
        Ok(self.defect(off(&outside, &inside), size, || "Ad_g[x, y] ≠ [Ad_g x, Ad_g y]".into()))
    }

    fn adjoint_exponential(&self) -> Answer {
        let (g, x) = (self.element("g")?, self.vector("g")?);
        let ad = self.group.algebra().ad(&x);
        let (series, half) = (exponential(&ad), exponential(&(ad * T::half())).amax());
        let size = self.adjoint_size(&g)? + half * half;
        Ok(self.defect(off(&self.adjoint_of(&g)?, &series), size, || "Ad_{exp x̂} ≠ exp(ad_x)".into()))
    }

    fn coadjoint(&self) -> Answer {
        let (g, x) = (self.element("g")?, self.vector("x")?);
        let mu = self.asked.case.covector::<T, N>("mu")?;
        let turned = self.group.coadjoint(&g, &mu);
        let turned = turned.ok_or_else(|| Measured::Broken("`coadjoint` gives None for exp(x̂)".into()))?;
        let ad = self.adjoint_of(&g)?;
        let size = self.adjoint_size(&g)? * mu.amax();
        let paired = (pair(&turned, &x) - pair(&mu, &(ad * x))).abs();
        let matrix = self.defect(off(&turned, &(mu * ad)), size, || "Ad*_g μ ≠ μ Ad_g".into());
        Ok(matrix.and(self.defect(paired, size * x.amax(), || "⟨Ad*_g μ, x⟩ ≠ ⟨μ, Ad_g x⟩".into())))
    }

    fn derivatives(&self) -> Answer {
        let (g, h, x, y) = (self.element("g")?, self.element("h")?, self.vector("x")?, self.vector("y")?);
        let hat = self.group.hat(&x);
        let moved = moving(&g, &(g * hat));
        let slope = |m: &Matrix<Dual<T>, D>| m.map(|v| v.eps);
        let along = self.group.hat(&moving(&x, &y));
        let hats =
            self.defect(off(&slope(&along), &self.group.hat(&y)), self.hat_size(&y), || "the derivative of hat".into());
        let back = self.group.vee(&along).map(|v| v.eps);
        let vees = self.defect(off(&back, &y), self.hat_size(&y) * self.gain, || "the derivative of vee".into());
        let inverse = self.eliminated(&g)?;
        let size = self.conditioned(&g)? * inverse.amax() * self.hat_size(&x);
        let turned = slope(&self.inverse_of(&moved)?);
        let inverses = self.defect(off(&turned, &-(hat * inverse)), size, || "the derivative of g⁻¹".into());
        let products = slope(&self.group.compose(&moved, &h.map(Dual::constant)));
        let size = g.amax() * self.hat_size(&x) * h.amax();
        let products = self.defect(off(&products, &(g * hat * h)), size, || "the derivative of g h".into());
        let ad = self.adjoint_of(&moved)?.map(|v| v.eps);
        let expected = self.adjoint_of(&g)? * self.group.algebra().ad(&x);
        // By the derivative of g⁻¹, which rounding moves by |g| |g⁻¹| as much as in `inverses`, the terms are larger than Ad_g.
        let size = self.adjoint_size(&g)?
            * (self.conditioned(&g)? * self.hat_size(&x) + self.group.algebra().size() * x.amax());
        let adjoints = self.defect(off(&ad, &expected), size, || "the derivative of Ad_g".into());
        Ok(hats.and(vees).and(inverses).and(products).and(adjoints))
    }

    fn distance(&self) -> Answer {
        let (g, h, k) = (self.element("g")?, self.element("h")?, self.element("k")?);
        let d = |a: &Matrix<T, D>, b: &Matrix<T, D>| self.group.distance(a, b);
        let size = g.amax().max(h.amax()).max(k.amax());
        let (direct, way) = (d(&g, &h), d(&g, &k) + d(&k, &h));
        let itself = self.defect(d(&g, &g).abs(), size, || "d(g, g) ≠ 0".into());
        let turned = self.defect((direct - d(&h, &g)).abs(), size + direct, || "d(g, h) ≠ d(h, g)".into());
        let excess = (direct - way).max(T::zero());
        let excess = if (direct - way).all_finite() { excess } else { T::exact(f64::INFINITY) };
        let triangle = self.defect(excess, size + direct, || "d(g, h) > d(g, k) + d(k, h)".into());
        // Far enough apart for any metric on matrices that is not made to hide it.
        let apart = off(&g, &h) > size * T::unit_roundoff().sqrt();
        let positive = direct > T::zero();
        if direct < T::zero() || (apart && !positive) {
            return Ok(Measured::Broken(format!("d(g, h) = {:e} for g ≠ h", direct.to_f64())));
        }
        Ok(itself.and(turned).and(triangle))
    }
}
