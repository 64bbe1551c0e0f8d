//! Laws of one Lie algebra: a bracket in code, or structure constants that nothing has validated yet.
//!
//! ```
//! use euler_poincare::laws::user::{algebra::{Constants, UserAlgebra}, part};
//!
//! // so(3) with a wrong index: [e_3, e_1] = e_1 instead of e_2.
//! let wrong = Constants::<f64, 3>::new(|a, b, c| match (a, b, c) {
//!     (0, 1, 2) | (1, 2, 0) | (2, 0, 0) => 1.0,
//!     (1, 0, 2) | (2, 1, 0) | (0, 2, 0) => -1.0,
//!     _ => 0.0,
//! });
//! let report = part::run(UserAlgebra::in_double(wrong), 1, 20);
//! let broken: Vec<_> = report.laws.iter().filter(|law| !law.broken.is_empty()).map(|law| law.law).collect();
//! assert_eq!(broken, ["algebra-jacobi", "algebra-ad"]);
//! ```

use super::super::planted::{blend, blend_scalar};
use super::super::precision::Measured;
use super::part::{Answer, Answers, Asked, Kind, Part, off, part_laws};
use crate::algebra::{Casimir, Covector, LieAlgebra, Matrix, Vector, basis_vector, pair};
use crate::harness::{About, Cost, Fault};
use crate::scalar::dual::{along, moving};
use crate::scalar::{Dual, Real, Scalar, larger, max_abs};

/// A Lie algebra by its bracket, with whatever else is known about it. Nothing is validated: that is what the laws are for.
pub trait Bracket<T: Real, const N: usize> {
    /// [x, y].
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N>;

    /// The matrix of ad_x; by default from `bracket`, a basis vector at a time.
    fn ad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        let mut ad = Matrix::<S, N>::zeros();
        for b in 0..N {
            ad.set_column(b, &self.bracket(x, &basis_vector(b)));
        }
        ad
    }

    /// ad*_x μ = μ ad_x.
    fn coad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        mu * self.ad(x)
    }

    /// How many Casimir functions are declared.
    fn casimirs(&self) -> usize {
        0
    }

    /// The k-th declared Casimir function, k < `casimirs()`.
    fn casimir<S: Scalar<Base = T>>(&self, k: usize, mu: &Covector<S, N>) -> S {
        let _ = (k, mu);
        S::zero()
    }
}

impl<T: Real, const N: usize> Bracket<T, N> for LieAlgebra<T, N> {
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
        self.bracket(x, y)
    }

    fn ad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        self.ad(x)
    }

    fn coad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        self.coad(x, mu)
    }
}

/// With Casimir functions that are known.
impl<T: Real, const N: usize> Bracket<T, N> for (LieAlgebra<T, N>, Vec<Casimir<T, N>>) {
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
        self.0.bracket(x, y)
    }

    fn ad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        self.0.ad(x)
    }

    fn coad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        self.0.coad(x, mu)
    }

    fn casimirs(&self) -> usize {
        self.1.len()
    }

    fn casimir<S: Scalar<Base = T>>(&self, k: usize, mu: &Covector<S, N>) -> S {
        self.1.get(k).map_or(S::zero(), |casimir| casimir.value(mu))
    }
}

/// Structure constants as they are given, not antisymmetrised and not validated, with declared Casimir functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants<T: Real, const N: usize> {
    /// Entry (c, b) of the a-th is C^c_ab.
    ad_basis: [Matrix<T, N>; N],
    casimirs: Vec<Casimir<T, N>>,
}

impl<T: Real, const N: usize> Constants<T, N> {
    /// [e_a, e_b] = C^c_ab e_c with C^c_ab = `constants(a, b, c)`.
    pub fn new(constants: impl Fn(usize, usize, usize) -> T) -> Self {
        let ad_basis = std::array::from_fn(|a| Matrix::from_fn(|c, b| constants(a, b, c)));
        Self { ad_basis, casimirs: Vec::new() }
    }

    /// Declares Casimir functions.
    pub fn casimirs(self, casimirs: Vec<Casimir<T, N>>) -> Self {
        Self { casimirs, ..self }
    }
}

impl<T: Real, const N: usize> Bracket<T, N> for Constants<T, N> {
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
        let mut sum = Vector::<S, N>::zeros();
        for a in 0..N {
            for b in 0..N {
                for c in 0..N {
                    sum[c] += x[a] * y[b] * S::lift(self.ad_basis[a][(c, b)]);
                }
            }
        }
        sum
    }

    fn casimirs(&self) -> usize {
        self.casimirs.len()
    }

    fn casimir<S: Scalar<Base = T>>(&self, k: usize, mu: &Covector<S, N>) -> S {
        self.casimirs.get(k).map_or(S::zero(), |casimir| casimir.value(mu))
    }
}

/// At how many momenta the size of the terms of a Casimir function is looked for.
const PLACES: usize = 4;

/// A momentum of the same size with other ratios and other signs of its components; the momentum itself at place 0.
fn displaced<T: Real, const N: usize>(mu: &Covector<T, N>, place: usize) -> Covector<T, N> {
    Covector::from_fn(|_, a| {
        let factor = T::ratio(16 + ((7 * a + 3 * place) % 11) as i64 - 5, 16);
        let turned = if (place >> (a % 2)) & 1 == 1 { -factor } else { factor };
        mu[a] * if place == 0 { T::one() } else { turned }
    })
}

const SOURCE: &str = "definition of a Lie algebra; Martín de Diego and Sato Martín de Almagro 2019, §2";
const BOUND: &str =
    "two precisions; floor 2⁶ N² u relative to max|C|, its square where brackets are nested, and the vectors";
const NONABELIAN: &str = "non-abelian algebras";

/// Not bilinear.
const BRACKET_QUADRATIC: Fault = Fault::new("bracket-quadratic", "[x, y] with |x|²y added", "every algebra");
/// Not antisymmetric.
const BRACKET_SYMMETRIC: Fault = Fault::new("bracket-symmetric", "[x, y] with x_1 y_1 e_1 added", "every algebra");
/// No Jacobi identity.
const BRACKET_EXTRA: Fault = Fault::new(
    "bracket-extra",
    "[x, y] with Σ_{a<b} (x_a y_b − x_b y_a) (e_1 + … + (a + 2b) e_a + …) added",
    "algebras of dimension 3 and more",
);
const AD_TRANSPOSED: Fault = Fault::new("ad-transposed", "ad_x replaced by its transpose", NONABELIAN);
const COAD_SIGN: Fault = Fault::new("coad-sign", "ad*_x μ = −μ ad_x", NONABELIAN);
const CASIMIR_EXTRA: Fault =
    Fault::new("casimir-extra", "(μ_1 + … + N μ_N)² added to each Casimir function", NONABELIAN);

const fn about(statement: &'static str, oracle: &'static str, needs: &'static str, faults: &'static [Fault]) -> About {
    About { name: "", statement, source: SOURCE, oracle, bound: BOUND, needs, faults, cost: Cost::Cheap }
}

part_laws! {
    /// The laws of this file.
    LAWS FIELDS __own_algebra;
    every {
        algebra_bilinear "a# x y z" about(
            "[a x + y, z] = a[x, z] + [y, z], and the same in the second place",
            "the bracket itself, at other vectors",
            "",
            &[BRACKET_QUADRATIC],
        );
        algebra_antisymmetric "x y" about(
            "[x, y] = −[y, x] and [x, x] = 0",
            "the bracket itself",
            "",
            &[BRACKET_SYMMETRIC, BRACKET_QUADRATIC],
        );
        algebra_jacobi "x y z" about(
            "[x, [y, z]] + [y, [z, x]] + [z, [x, y]] = 0",
            "the bracket itself, nested",
            "",
            &[BRACKET_EXTRA],
        );
        algebra_ad "x y z" about(
            "ad_x y = [x, y], and ad_{[x, y]} = ad_x ad_y − ad_y ad_x",
            "the bracket, and the commutator of matrices",
            "",
            &[AD_TRANSPOSED, BRACKET_EXTRA, BRACKET_SYMMETRIC],
        );
        algebra_coad "x y mu" about("⟨ad*_x μ, y⟩ = ⟨μ, [x, y]⟩", "the bracket", "", &[COAD_SIGN, AD_TRANSPOSED]);
        algebra_derivatives "x y z" about(
            "[x + ε y, z] has the derivative [y, z]",
            "the bracket on values; the bracket on dual numbers",
            "",
            &[BRACKET_QUADRATIC],
        );
    }
    claimed {
        algebra_casimirs "x mu" about(
            "d/ds C(μ + s μ ad_x) = 0 for each declared C",
            "C on dual numbers, along coadjoint orbits by the bracket",
            "Casimir functions: `Bracket::casimirs` and `Bracket::casimir`",
            &[CASIMIR_EXTRA],
        );
    }
}

/// A user's algebra.
#[doc(hidden)]
pub type UserAlgebra<const N: usize> = Part<AlgebraLaws<N>>;

/// The laws on algebras.
#[derive(Default)]
#[doc(hidden)]
pub struct AlgebraLaws<const N: usize>;

impl<const N: usize> Kind for AlgebraLaws<N> {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const DIMENSION: usize = N;
    const LARGEST: f64 = 2.0 * std::f64::consts::PI;
}

impl<T: Real, G, const N: usize> Answers<T, AlgebraLaws<N>> for G
where
    G: Bracket<T, N> + Send + Sync + 'static,
{
    fn answer(&self, asked: &Asked<'_, AlgebraLaws<N>>) -> Answer {
        judge(self, asked)
    }
}

/// An algebra with a fault planted in it.
struct Planted<'a, G> {
    algebra: &'a G,
    fault: Option<&'a Fault>,
}

/// Antisymmetric, and no Lie bracket together with another.
fn extra<S: Scalar, const N: usize>(x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
    let mut sum = Vector::<S, N>::zeros();
    for a in 0..N {
        for b in a + 1..N {
            let area = x[a] * y[b] - x[b] * y[a];
            sum += Vector::from_fn(|c, _| if c == a { area * S::int((a + 2 * b) as i64) } else { area });
        }
    }
    sum
}

impl<T: Real, G: Bracket<T, N>, const N: usize> Bracket<T, N> for Planted<'_, G> {
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
        let right = self.algebra.bracket(x, y);
        let right = blend(right, right + y * x.dot(x), BRACKET_QUADRATIC.size_in(self.fault));
        let symmetric = right + basis_vector::<S, N>(0) * (x[0] * y[0]);
        let right = blend(right, symmetric, BRACKET_SYMMETRIC.size_in(self.fault));
        blend(right, right + extra(x, y), BRACKET_EXTRA.size_in(self.fault))
    }

    fn ad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        let right = self.algebra.ad(x);
        blend(right, right.transpose(), AD_TRANSPOSED.size_in(self.fault))
    }

    fn coad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        let right = self.algebra.coad(x, mu);
        let right = blend(right, mu * self.algebra.ad(x).transpose(), AD_TRANSPOSED.size_in(self.fault));
        blend(right, -right, COAD_SIGN.size_in(self.fault))
    }

    fn casimirs(&self) -> usize {
        self.algebra.casimirs()
    }

    fn casimir<S: Scalar<Base = T>>(&self, k: usize, mu: &Covector<S, N>) -> S {
        let right = self.algebra.casimir(k, mu);
        let sum = (0..N).fold(S::zero(), |sum, a| sum + mu[a] * S::int(a as i64 + 1));
        blend_scalar(right, right + sum * sum, CASIMIR_EXTRA.size_in(self.fault))
    }
}

/// max |C^c_ab|, by the bracket and not less than by ad.
fn largest_constant<T: Real, G: Bracket<T, N>, const N: usize>(algebra: &G) -> T {
    let mut constants = T::zero();
    for a in 0..N {
        let e = basis_vector::<T, N>(a);
        constants = constants.max(algebra.ad(&e).amax());
        for b in 0..N {
            constants = constants.max(algebra.bracket(&e, &basis_vector(b)).amax());
        }
    }
    constants
}

fn judge<T: Real, G: Bracket<T, N>, const N: usize>(right: &G, asked: &Asked<'_, AlgebraLaws<N>>) -> Answer {
    let algebra = Planted { algebra: right, fault: asked.fault };
    let vector = |name: &str| asked.case.vector::<T, N>(name);
    let constants = largest_constant(right);
    let floor = 64.0 * (N * N) as f64;
    let defect = |off: T, size: T, what: &'static str| Measured::defect(off, size, floor, || what.into());
    let by = |x: &Vector<T, N>, y: &Vector<T, N>| algebra.bracket(x, y);
    match asked.law.name {
        "algebra-bilinear" => {
            let a = asked.case.number::<T>("a")?;
            let (x, y, z) = (vector("x")?, vector("y")?, vector("z")?);
            let sum = x * a + y;
            let size = constants * z.amax() * (a.abs() * x.amax() + y.amax());
            let first = off(&by(&sum, &z), &(by(&x, &z) * a + by(&y, &z)));
            let second = off(&by(&z, &sum), &(by(&z, &x) * a + by(&z, &y)));
            Ok(defect(first, size, "[a x + y, z] ≠ a[x, z] + [y, z]").and(defect(
                second,
                size,
                "[z, a x + y] ≠ a[z, x] + [z, y]",
            )))
        }
        "algebra-antisymmetric" => {
            let (x, y) = (vector("x")?, vector("y")?);
            let swapped = defect(off(&by(&x, &y), &-by(&y, &x)), constants * x.amax() * y.amax(), "[x, y] ≠ −[y, x]");
            let itself = max_abs(&by(&x, &x));
            Ok(swapped.and(defect(itself, constants * x.amax() * x.amax(), "[x, x] ≠ 0")))
        }
        "algebra-jacobi" => {
            let (x, y, z) = (vector("x")?, vector("y")?, vector("z")?);
            let sum = by(&x, &by(&y, &z)) + by(&y, &by(&z, &x)) + by(&z, &by(&x, &y));
            let size = constants * constants * x.amax() * y.amax() * z.amax();
            Ok(defect(max_abs(&sum), size, "[x, [y, z]] + [y, [z, x]] + [z, [x, y]] ≠ 0"))
        }
        "algebra-ad" => {
            let (x, y) = (vector("x")?, vector("y")?);
            let (ad_x, ad_y) = (algebra.ad(&x), algebra.ad(&y));
            let size = constants * x.amax() * y.amax();
            let applied = defect(off(&(ad_x * y), &by(&x, &y)), size, "ad_x y ≠ [x, y]");
            let commutator = ad_x * ad_y - ad_y * ad_x;
            let of_bracket = algebra.ad(&by(&x, &y));
            Ok(applied.and(defect(off(&of_bracket, &commutator), size * constants, "ad_{[x, y]} ≠ [ad_x, ad_y]")))
        }
        "algebra-coad" => {
            let (x, y) = (vector("x")?, vector("y")?);
            let mu = asked.case.covector::<T, N>("mu")?;
            let (mine, expected) = (pair(&algebra.coad(&x, &mu), &y), pair(&mu, &right.bracket(&x, &y)));
            Ok(Measured::defect((mine - expected).abs(), constants * x.amax() * y.amax() * mu.amax(), floor, || {
                format!("⟨ad*_x μ, y⟩ = {:e}, ⟨μ, [x, y]⟩ = {:e}", mine.to_f64(), expected.to_f64())
            }))
        }
        "algebra-derivatives" => {
            let (x, y, z) = (vector("x")?, vector("y")?, vector("z")?);
            let moved = moving(&x, &y);
            let still = z.map(Dual::constant);
            let size = constants * y.amax() * z.amax();
            let (first, second) = (algebra.bracket(&moved, &still), algebra.bracket(&still, &moved));
            let first = off(&first.map(|v| v.eps), &right.bracket(&y, &z));
            let second = off(&second.map(|v| v.eps), &right.bracket(&z, &y));
            Ok(defect(first, size, "the derivative of [x, z] along y").and(defect(
                second,
                size,
                "the derivative of [z, x] along y",
            )))
        }
        "algebra-casimirs" => {
            let x = vector("x")?;
            let mu = asked.case.covector::<T, N>("mu")?;
            let velocity = Covector::<T, N>::from_fn(|_, b| pair(&mu, &right.bracket(&x, &basis_vector(b))));
            let moved = moving(&mu, &velocity);
            let mut measured = Measured::NotApplicable("no Casimir functions are declared".into());
            for k in 0..algebra.casimirs() {
                let slope =
                    |mu: &Covector<T, N>, a: usize| right.casimir(k, &along(&mu.transpose(), a).transpose()).eps.abs();
                // The terms of the velocity may cancel, and those of the slopes: not at other momenta of the same size, too.
                let slopes = (0..PLACES)
                    .map(|place| displaced(&mu, place))
                    .map(|mu| (0..N).fold(T::zero(), |sum, a| sum + slope(&mu, a)))
                    .fold(T::zero(), larger);
                let size = slopes * mu.amax() * x.amax() * constants;
                let slope = algebra.casimir(k, &moved).eps;
                measured = measured.and(Measured::defect(slope.abs(), size, floor, || {
                    format!("Casimir function {k} changes along its orbit at {:e}", slope.to_f64())
                }));
            }
            Ok(measured)
        }
        _ => asked.unknown("algebras"),
    }
}
