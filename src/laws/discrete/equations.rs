//! Laws of the discrete equations and flows, for random polynomials of the entries of V, U and W; for the units the
//! polynomial is ½(L − L ∘ ι̌_d).

use super::super::CaseLaw;
use super::super::differences::slope;
use super::super::polynomial::odd_part;
use super::super::precision::Measured;
use super::super::probe::{Probe, stream};
use super::super::question::{Answer, Problem, Question, law, singular};
use super::{DOUBLED, KEEPS_U, NO_U, Planted, U_SIGN, UNITS, V_RIGHT, compare, inverse, largest, units};
use crate::algebra::{Matrix, Vector, pair};
use crate::discrete::legendre::{euler_lagrange, flow};
use crate::discrete::{Momenta, Quadruple, Smooth, SmoothLagrangian, Triple, quadruple};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{Cost, Fault};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Real, Scalar, max_abs};

/// The laws of this file.
pub static LAWS: &[CaseLaw] = &[
    law!(Law {
        name: "discrete-euler-lagrange",
        statement: "the first variation of two steps is ⟨F⁻(k) − F⁺(k−1), (P, Σ)⟩, with U_k = V_{k−1}⁻¹U_{k−1}W_{k−1}",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 5.1, (5.1) and (5.2)",
        oracle: "the action of four group elements, their middle ones moved on dual numbers; not at a solution",
        bound: both("floor 2⁵ N D u of the slopes and group elements"),
        needs: "a group",
        faults: &[NO_U, U_SIGN],
        cases: |cases| cases.main_dimensions().with_group(),
        asks: Which::Variation,
    }),
    law!(Law {
        needs: "a group",
        bound: small(12, "floor 2⁸ N D u of the group elements"),
        cases: |cases| cases.main_dimensions().with_group(),
        asks: Which::Units,
        ..UNITS
    }),
    law!(Law {
        name: "discrete-reduction",
        statement: "π ∘ F_{L_d} = F_{l_d} ∘ π for L_d = l_d ∘ π on G⁴, and π ∘ ι_d = ι̌_d ∘ π",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.4 (its proof) and §5",
        oracle: "the flow on G⁴, from the derivatives of L_d by the four group elements",
        bound: small(12, "floor 2⁸ N D u of the group elements"),
        needs: "a group",
        cost: Cost::Expensive,
        faults: &[NO_U, U_SIGN, KEEPS_U],
        cases: |cases| cases.main_dimensions().with_group(),
        asks: Which::Reduction,
    }),
    law!(Law {
        name: "legendre-regularity",
        statement: "⟨∂(λ₀, −μ₀)/∂(g₁, g̃₁) x, y⟩ = ⟨∂(−λ₁, μ₁)/∂(g₀, g̃₀) y, x⟩ for (λ₀, U₀, μ₀) = F⁻ and (λ₁, U₁, μ₁) = F⁺: their \
                        Jacobians are transposes, so F⁻ is regular exactly where F⁺ is",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.3 and §5; Marsden and West 2001, §1.3.4",
        oracle: "differences of F⁻ with the ends of a step moved, against those of F⁺ with its start moved",
        bound: apart(12, "2⁶ N D u"),
        needs: "a group",
        faults: &[NO_U, U_SIGN, DOUBLED, V_RIGHT],
        cases: |cases| cases.main_dimensions().with_group(),
        asks: Which::Regularity,
    }),
];

#[derive(Clone, Copy)]
enum Which {
    Variation,
    Units,
    Reduction,
    Regularity,
}

/// l_d(V, U, W) = (‖W − 1‖² − ‖V − 1‖²) w + Σ_m f_m(V) g_m(U) k_m(W), with affine functions of the entries: regular for
/// large w, as the matrices ê_a are linearly independent. Or the odd part of it.
#[derive(Clone, Copy)]
pub(super) struct ArrowPolynomial<'a, T: Real, const D: usize> {
    weight: T,
    terms: [[Matrix<T, D>; 3]; 2],
    odd: bool,
    fault: Option<&'a Fault>,
}

/// 1/(2h) for h = 2⁻⁶.
const KINETIC: f64 = 32.0;

impl<'a, T: Real, const D: usize> ArrowPolynomial<'a, T, D> {
    /// One with random terms, and w.
    pub fn random(probe: &mut Probe, weight: f64) -> Self {
        let mut matrix = || Matrix::<T, D>::from_fn(|_, _| probe.unit::<T>() * T::exact(0.125));
        let terms = [[matrix(), matrix(), matrix()], [matrix(), matrix(), matrix()]];
        Self { weight: T::exact(weight), terms, odd: false, fault: None }
    }

    /// ½(L − L ∘ ι̌_d), or what the fault makes of it.
    pub fn odd(self, fault: Option<&'a Fault>) -> Self {
        Self { odd: true, fault, ..self }
    }

    fn whole<S: Scalar<Base = T>>(&self, x: &Triple<S, D>) -> S {
        let square = |g: &Matrix<S, D>| (g - Matrix::<S, D>::identity()).iter().fold(S::zero(), |sum, v| sum + *v * *v);
        let kinetic = (square(&x.w) - square(&x.v)) * S::lift(self.weight);
        let affine = |c: &Matrix<T, D>, g: &Matrix<S, D>| {
            c.iter().zip(g.iter()).fold(S::one(), |sum, (c, v)| sum + S::lift(*c) * *v)
        };
        let product = |[f, g, k]: &[Matrix<T, D>; 3]| affine(f, &x.v) * affine(g, &x.u) * affine(k, &x.w);
        kinetic + product(&self.terms[0]) + product(&self.terms[1])
    }
}

impl<T: Real, const D: usize> SmoothLagrangian<T, D> for ArrowPolynomial<'_, T, D> {
    fn value<S: Scalar<Base = T>>(&self, x: &Triple<S, D>) -> Result<S, RetractionError> {
        let here = self.whole(x);
        if !self.odd {
            return Ok(here);
        }
        let singular = RetractionError::NoPreimage { retraction: "the inverse", why: "U is singular" };
        Ok(odd_part(here, self.whole(&x.inverse().ok_or(singular)?), self.fault))
    }
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::ELEMENTS);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (group, tau) = (problem.group()?, &problem.system.retraction);
        // Six random elements near e.
        let mut elements = [Matrix::<T, D>::identity(); 6];
        for element in &mut elements {
            *element = tau.tau(&(problem.probe.vector::<T, N>() * T::exact(0.0625)))?;
        }
        let polynomial = ArrowPolynomial::random(&mut problem.draws(stream::DISCRETE_POLYNOMIAL), KINETIC);
        let mut near = NearUnit { problem, group, polynomial, elements };
        match self {
            Self::Variation => near.variation(),
            Self::Units => {
                near.polynomial = polynomial.odd(near.problem.fault);
                units(&near.l_d(), tau, elements[0])
            }
            Self::Reduction => near.reduction(),
            Self::Regularity => near.regularity(),
        }
    }
}

/// A random discrete Lagrangian, and elements near e.
struct NearUnit<'a, T: Real, const N: usize, const D: usize> {
    problem: Problem<'a, T, N, D>,
    group: &'a MatrixGroup<T, N, D>,
    polynomial: ArrowPolynomial<'a, T, D>,
    elements: [Matrix<T, D>; 6],
}

impl<'a, T: Real, const N: usize, const D: usize> NearUnit<'a, T, N, D> {
    /// l_d, with the fault planted.
    fn l_d(&self) -> Planted<'a, Smooth<'a, ArrowPolynomial<'a, T, D>, MatrixGroup<T, N, D>>> {
        Planted { l_d: Smooth::new(self.polynomial, self.group), fault: self.problem.fault }
    }

    fn variation(&self) -> Answer {
        let (group, [g0, g1, g2, p0, p1, p2]) = (self.group, &self.elements);
        let mut probe = self.problem.draws(stream::VARIATION);
        let (first, second) = (probe.vector::<T, N>(), probe.vector::<T, N>());
        let still = |g: &Matrix<T, D>| g.map(Dual::constant);
        let moved = |g: &Matrix<T, D>, along: &Vector<T, N>| moving(g, &(g * group.hat(along)));
        let (h1, q1) = (moved(g1, &first), moved(p1, &second));
        let step = |first, second| quadruple::lifted(&self.polynomial, &Quadruple { first, second });
        let action = step([still(g0), h1], [still(p0), q1])? + step([h1, still(g2)], [q1, still(p2)])?;
        let reduced = |first, second| Quadruple { first, second }.project().ok_or_else(singular);
        let (x, y) = (reduced([*g0, *g1], [*p0, *p1])?, reduced([*g1, *g2], [*p1, *p2])?);
        let l_d = self.l_d();
        let (row, partner) = euler_lagrange((&l_d, &x), (&l_d, &y))?;
        let found = pair(&row, &first) + pair(&partner, &second);
        let expected = action.eps;
        let size = row.amax().max(partner.amax()).max(T::one());
        // The two steps meet: U at the end of the first is that of the second.
        let next = x.next_u().ok_or(Measured::Broken("V is a singular matrix".into()))?;
        let scale = [g0, g1, g2, p0, p1, p2].into_iter().fold(T::one(), |scale, g| scale.max(g.amax()));
        let floor = 32.0 * (N * D) as f64;
        let varied = Measured::defect((found - expected).abs(), size * scale, floor, || {
            format!("⟨residual, (P, Σ)⟩ = {:.17e}, δ action = {:.17e}", found.to_f64(), expected.to_f64())
        });
        Ok(varied.and(Measured::defect(max_abs(&(next - y.u)), scale * scale, floor, || "U_k ≠ V⁻¹UW".into())))
    }

    fn reduction(&self) -> Answer {
        let (tau, [v, u, w, start, ..]) = (&self.problem.system.retraction, &self.elements);
        let partner = start * u;
        let above = Quadruple { first: [*start, start * v], second: [partner, partner * w] };
        let project = |x: &Quadruple<T, D>| x.project().ok_or_else(singular);
        let below = project(&above)?;
        let (l_d, polynomial) = (self.l_d(), &self.polynomial);
        let expected = project(&quadruple::flow(polynomial, polynomial, self.group, tau, &above)?)?;
        let found = flow(&l_d, &l_d, tau, &below)?;
        let floor = 256.0 * (N * D) as f64;
        let flows = compare(&found, &expected, T::one(), floor);
        let exchanged = compare(&inverse(&below, self.problem.fault)?, &project(&above.exchange())?, T::one(), floor);
        Ok(flows.and(exchanged))
    }

    fn regularity(&self) -> Answer {
        let (l_d, [v, u, w, ..]) = (self.l_d(), self.elements);
        let mut probe = self.problem.draws(stream::VARIATION);
        let [ends, starts] = [[probe.vector::<T, N>(), probe.vector()], [probe.vector::<T, N>(), probe.vector()]];
        let tau = |x: &Vector<T, N>, s: T| self.problem.system.retraction.tau(&(x * s));
        let momenta = |x: &Triple<T, D>| {
            let rows = l_d.rows(x)?;
            let end = Momenta::plus(&rows, x)?;
            Ok::<_, Measured>((Momenta::minus(&rows, x), end))
        };
        let minus = |s: T| {
            let (start, _) = momenta(&Triple { v: v * tau(&ends[0], s)?, u, w: w * tau(&ends[1], s)? })?;
            Ok(pair(&start.lambda, &starts[0]) - pair(&start.mu, &starts[1]))
        };
        let plus = |s: T| {
            let (first, second) = (tau(&starts[0], -s)?, tau(&starts[1], -s)?);
            let (_, end) = momenta(&Triple { v: first * v, u: first * u * tau(&starts[1], s)?, w: second * w })?;
            Ok(pair(&end.mu, &ends[1]) - pair(&end.lambda, &ends[0]))
        };
        let rows = l_d.rows(&Triple { v, u, w })?;
        // The slopes of w |g − 1|² are rounded like 2 w g.
        let typical = (largest(&rows) + T::exact(2.0 * KINETIC)) * T::int((N * D) as i64);
        let mut stopped = None;
        let mut differences = |f: &dyn Fn(T) -> Result<T, Measured>| {
            slope(|s| f(s).map_err(|why| stopped = Some(why)).ok(), T::exact(0.25), typical)
        };
        let found = (differences(&minus), differences(&plus));
        let (Some(minus), Some(plus)) = found else {
            return Err(stopped.unwrap_or(Measured::NotApplicable("a point is outside the domain".into())));
        };
        let rounding = T::exact(64.0) * T::unit_roundoff() * typical;
        Ok(Measured::within((minus.value - plus.value).abs(), minus.error + plus.error + rounding, || {
            format!("of F⁻ {:e}, of F⁺ {:e}", minus.value.to_f64(), plus.value.to_f64())
        }))
    }
}
