//! A group, a retraction, a map, a Lagrangian, a force and a one-step method, as a user writes them; and each with one mistake.
//!
//! The group is that of Bianchi's type VII_h, h = ½: motions of the plane that turn and scale, g = [A, p; 0, 1] with
//! A = e^{hθ} R(θ). It is solvable and not unimodular. `wrong` puts the mistake in; a value and not a type, of which each would be
//! compiled.

use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, Vector};
use euler_poincare::group::LieGroup;
use euler_poincare::integrators::{OneStep, Report, Solver, State, StepError};
use euler_poincare::laws::user::Map;
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::{Retraction, RetractionError, TangentPoint};
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::system::System;
use nalgebra::{Matrix2, Vector2};

/// The group. Wrong: the inverse turns back and does not scale back.
#[derive(Clone)]
pub struct Bianchi<T: Real> {
    algebra: LieAlgebra<T, 3>,
    wrong: bool,
}

impl<T: Real> Bianchi<T> {
    /// [e_3, e_1] = h e_1 + e_2, [e_3, e_2] = h e_2 − e_1.
    pub fn new(wrong: bool) -> Self {
        let half = T::half();
        let table = [(0, 2, 0, -half), (0, 2, 1, -T::one()), (1, 2, 1, -half), (1, 2, 0, T::one())];
        let constant = |a, b, c| match table.iter().find(|(i, j, k, _)| (a, b, c) == (*i, *j, *k)) {
            Some((.., value)) => *value,
            None => table.iter().find(|(i, j, k, _)| (b, a, c) == (*i, *j, *k)).map_or(T::zero(), |(.., v)| -*v),
        };
        Self { algebra: LieAlgebra::new(constant).expect("a Lie algebra"), wrong }
    }
}

impl<T: Real> LieGroup<T, 3, 3> for Bianchi<T> {
    fn algebra(&self) -> &LieAlgebra<T, 3> {
        &self.algebra
    }

    fn hat<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Matrix<S, 3> {
        let (h, zero) = (S::half(), S::zero());
        Matrix::<S, 3>::new(h * x[2], -x[2], x[0], x[2], h * x[2], x[1], zero, zero, zero)
    }

    fn vee<S: Scalar<Base = T>>(&self, m: &Matrix<S, 3>) -> Vector<S, 3> {
        Vector::<S, 3>::new(m[(0, 2)], m[(1, 2)], m[(1, 0)])
    }

    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        let a = linear(g);
        let square = if self.wrong { S::one() } else { a[(0, 0)] * a[(0, 0)] + a[(1, 0)] * a[(1, 0)] };
        let inverse = a.transpose() / square;
        (square > S::zero()).then(|| affine(&inverse, &-(inverse * shift(g))))
    }
}

fn linear<S: Scalar>(g: &Matrix<S, 3>) -> Matrix2<S> {
    g.fixed_view::<2, 2>(0, 0).into_owned()
}

fn shift<S: Scalar>(g: &Matrix<S, 3>) -> Vector2<S> {
    Vector2::new(g[(0, 2)], g[(1, 2)])
}

fn affine<S: Scalar>(a: &Matrix2<S>, p: &Vector2<S>) -> Matrix<S, 3> {
    let (zero, one) = (S::zero(), S::one());
    Matrix::<S, 3>::new(a[(0, 0)], a[(0, 1)], p[0], a[(1, 0)], a[(1, 1)], p[1], zero, zero, one)
}

/// h + J.
fn generator<S: Scalar>() -> Matrix2<S> {
    Matrix2::new(S::half(), -S::one(), S::one(), S::half())
}

/// e^{hθ} R(θ).
fn turned<S: Scalar>(angle: S) -> Matrix2<S> {
    let (sin, cos) = angle.sin_cos();
    Matrix2::new(cos, -sin, sin, cos) * (angle * S::half()).exp()
}

/// τ(p, θ): half the translation, the turn, half the translation. Wrong: the sign of one term of ddτ.
#[derive(Clone)]
pub struct Split<T: Real> {
    group: Bianchi<T>,
    wrong: bool,
}

impl<T: Real> Split<T> {
    pub fn new(wrong: bool) -> Self {
        Self { group: Bianchi::new(false), wrong }
    }
}

impl<T: Real> Retraction<T, 3, 3> for Split<T> {
    type Point<S: Scalar<Base = T>> = SplitPoint<S>;

    fn name(&self) -> &'static str {
        "split"
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        self.group.algebra()
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        let (a, p) = (turned(x[2]), Vector2::new(x[0], x[1]) * S::half());
        Ok(affine(&a, &(p + a * p)))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Result<Vector<S, 3>, RetractionError> {
        let a = linear(g);
        let outside = RetractionError::NoPreimage { retraction: "split", why: "1 + A is singular" };
        let p = (a + Matrix2::identity()).try_inverse().ok_or(outside)? * shift(g) * S::int(2);
        Ok(Vector::<S, 3>::new(p[0], p[1], a[(1, 0)].atan2(a[(0, 0)])))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<SplitPoint<S>, RetractionError> {
        let p = Vector2::new(x[0], x[1]);
        let (a, back) = (turned(x[2]), turned(-x[2]));
        let tangent = |inverse: &Matrix2<S>, p: &Vector2<S>| {
            let half = S::half();
            affine(&((Matrix2::identity() + inverse) * half), &(generator() * p * half))
        };
        let (d, d_neg) = (tangent(&back, &p), tangent(&a, &-p));
        let size = x.amax().to_f64();
        let d_inv = d.try_inverse().ok_or(RetractionError::SingularTangent { retraction: "split", size })?;
        let shifted = (p + a * p) * S::half();
        let (ad, ad_inv) = (adjoint(&a, &shifted), adjoint(&back, &-(back * shifted)));
        Ok(SplitPoint { back, d, d_inv, d_neg, ad, ad_inv, wrong: self.wrong })
    }
}

/// Ad of [A, P; 0, 1].
fn adjoint<S: Scalar>(a: &Matrix2<S>, p: &Vector2<S>) -> Matrix<S, 3> {
    affine(a, &-(generator() * p))
}

#[derive(Clone)]
pub struct SplitPoint<S: Scalar> {
    back: Matrix2<S>,
    d: Matrix<S, 3>,
    d_inv: Matrix<S, 3>,
    d_neg: Matrix<S, 3>,
    ad: Matrix<S, 3>,
    ad_inv: Matrix<S, 3>,
    wrong: bool,
}

impl<S: Scalar> TangentPoint<S, 3> for SplitPoint<S> {
    fn d(&self) -> &Matrix<S, 3> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, 3> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, 3> {
        self.d_neg
    }

    fn ad(&self) -> Matrix<S, 3> {
        self.ad
    }

    fn ad_inv(&self) -> Matrix<S, 3> {
        self.ad_inv
    }

    fn dd(&self, y: &Vector<S, 3>) -> Matrix<S, 3> {
        let half = if self.wrong { -S::half() } else { S::half() };
        let turn = self.back * generator() * Vector2::new(y[0], y[1]) * -half;
        let mut derivative = affine(&(generator() * (y[2] * S::half())), &turn);
        derivative[(2, 2)] = S::zero();
        self.d_inv * derivative
    }
}

/// The same τ and no more.
pub struct SplitMap;

impl<T: Real> Map<T, 3, 3> for SplitMap {
    fn map<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Option<Matrix<S, 3>> {
        let (a, p) = (turned(x[2]), Vector2::new(x[0], x[1]) * S::half());
        Some(affine(&a, &(p + a * p)))
    }
}

/// l(η) = ½(η_1² + 2η_2² + 3η_3² + η_1 η_3) + ⅛ η_2⁴. Wrong: the gradient forgets the quartic term.
pub struct Stiff {
    pub wrong: bool,
}

impl<T: Real> Lagrangian<T, 3> for Stiff {
    fn value<S: Scalar<Base = T>>(&self, v: &Vector<S, 3>) -> S {
        let square = v[0] * v[0] + v[1] * v[1] * S::int(2) + v[2] * v[2] * S::int(3) + v[0] * v[2];
        square * S::half() + v[1] * v[1] * v[1] * v[1] * S::ratio(1, 8)
    }

    fn gradient<S: Scalar<Base = T>>(&self, v: &Vector<S, 3>) -> Covector<S, 3> {
        let quartic = if self.wrong { S::zero() } else { v[1] * v[1] * v[1] * S::half() };
        let half = S::half();
        Covector::<S, 3>::new(v[0] + v[2] * half, v[1] * S::int(2) + quartic, v[2] * S::int(3) + v[0] * half)
    }
}

/// Drag in a wind that comes and goes: f = −½ (η − w cos t). Wrong: the velocity loses its derivative.
pub struct Wind {
    pub wrong: bool,
}

impl<T: Real> Force<T, 3> for Wind {
    fn force<S: Scalar<Base = T>>(&self, t: S, v: &Vector<S, 3>) -> Covector<S, 3> {
        let wind = Vector::<S, 3>::new(S::ratio(1, 4), S::ratio(-1, 2), S::ratio(1, 8)) * t.cos();
        let v = if self.wrong { v.map(|x| S::lift(x.base())) } else { *v };
        ((wind - v) * S::half()).transpose()
    }
}

/// The explicit midpoint rule, of order 2. Wrong: the force at the start of the step, whatever the stage.
pub struct Midpoint<'s, T: Real> {
    pub system: &'s System<T, 3, 3>,
    pub wrong: bool,
}

impl<T> OneStep<T, 3, 3> for Midpoint<'_, T>
where
    T: Real,
{
    fn step(&mut self, state: &mut State<T, 3, 3>, h: T) -> Result<Report<T>, StepError> {
        let (system, step, half) = (self.system, h.to_f64(), h * T::half());
        let velocity = |mu: &Covector<T, 3>| {
            let eta = system.lagrangian.velocity(mu, &Vector::zeros());
            eta.map_err(|source| StepError::Legendre { step, source })
        };
        let rate = |t: T, eta: &Vector<T, 3>, mu: &Covector<T, 3>| {
            system.algebra.coad(eta, mu) + system.force.force(if self.wrong { state.time } else { t }, eta)
        };
        let eta = velocity(&state.momentum)?;
        let middle = state.momentum + rate(state.time, &eta, &state.momentum) * half;
        let eta = velocity(&middle)?;
        let end = state.momentum + rate(state.time + half, &eta, &middle) * h;
        let turn = system.retraction.tau(&(eta * h));
        let turn = turn.map_err(|source| StepError::Domain { step, stage: None, source })?;
        *state = State { time: state.time + h, momentum: end, attitude: state.attitude * turn };
        Ok(Report { solver: Solver::Explicit, iterations: 1, residual: T::zero() })
    }
}
