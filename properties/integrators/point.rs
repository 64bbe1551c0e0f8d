//! Forces at a point of a body: moments by hand, and virtual work.

use euler_poincare::algebra::{Covector, Entry, Matrix, Vector, pair};
use euler_poincare::group::{LieGroup, MatrixGroup, So3};
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::configuration::{AtPoint, Configuration, ForceOnGroup, InSpace, OnGroup, Potential};
use euler_poincare::mechanics::force::{Constant, Control, Driven, Hold, LinearDrag, QuadraticDrag, Signal, Zero};
use euler_poincare::retraction::{Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Real, Scalar};

/// A bound for rounding: sums of a dozen terms of size 100.
const ROUNDING: f64 = 1e-13;

fn space() -> MatrixGroup<f64, 6, 4> {
    MatrixGroup::from_entry(&Entry::Se3).unwrap()
}

/// Somewhere on SE(3).
fn place() -> Matrix<f64, 4> {
    let x = Vector::<f64, 6>::from_row_slice(&[0.7, -1.1, 0.4, 2.0, -0.5, 1.5]);
    Exponential::of_group(space()).tau(&x).unwrap()
}

/// ω and u.
fn split(eta: &Vector<f64, 6>) -> (Vector<f64, 3>, Vector<f64, 3>) {
    (eta.fixed_rows::<3>(0).into_owned(), eta.fixed_rows::<3>(3).into_owned())
}

fn constant<const P: usize>(force: &Vector<f64, P>) -> Constant<f64, P> {
    Constant::new(force.transpose()).unwrap()
}

#[test]
fn the_moment_is_that_by_hand() {
    // 5 N upward, 2 m along the first axis and 1 m along the second: (1·5, −2·5, 0) N m.
    let (r, up) = (Vector::<f64, 3>::new(2.0, 1.0, 0.0), Vector::<f64, 3>::new(0.0, 0.0, 5.0));
    let torque: Covector<f64, 3> = AtPoint::in_body(constant(&up), r, &So3::new()).force(0.0, &Vector::zeros());
    assert_eq!(torque.as_slice(), [5.0, -10.0, 0.0]);
    let wrench: Covector<f64, 6> = AtPoint::in_body(constant(&up), r, &space()).force(0.0, &Vector::zeros());
    assert_eq!(wrench.as_slice(), [5.0, -10.0, 0.0, 0.0, 0.0, 5.0]);
    // At the origin of the body there is no moment, wherever the body is.
    let here = AtPoint::in_space(constant(&up), Vector::<f64, 3>::zeros(), &space());
    let found: Covector<f64, 6> = here.force_at(0.0, Configuration::of(&place()), &Vector::zeros());
    assert_eq!(found.as_slice()[..3], [0.0; 3]);
    // A quarter turn about the third axis: in the body the force along the second axis of space is along the first.
    let quarter = Matrix::<f64, 3>::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let side = AtPoint::in_space(constant(&Vector::<f64, 3>::y()), Vector::<f64, 3>::z(), &So3::new());
    let found: Covector<f64, 3> = side.force_at(0.0, Configuration::of(&quarter), &Vector::zeros());
    assert_eq!(found.as_slice(), [0.0, 1.0, 0.0]);
    // In the plane the moment is r₁ F₂ − r₂ F₁.
    let plane = MatrixGroup::<f64, 3, 3>::from_entry(&Entry::Se2).unwrap();
    let (r, f) = (Vector::<f64, 2>::new(2.0, 3.0), Vector::<f64, 2>::new(5.0, 7.0));
    let found: Covector<f64, 3> = AtPoint::in_body(constant(&f), r, &plane).force(0.0, &Vector::zeros());
    assert_eq!(found.as_slice(), [2.0 * 7.0 - 3.0 * 5.0, 5.0, 7.0]);
}

#[test]
fn the_power_is_that_of_the_point() {
    let (r, f) = (Vector::<f64, 3>::new(0.5, -1.5, 2.0), Vector::<f64, 3>::new(1.0, 3.0, -2.0));
    let eta = Vector::<f64, 6>::from_row_slice(&[1.0, -0.5, 0.75, 0.3, -2.0, 1.25]);
    let (g, (omega, u)) = (place(), split(&eta));
    let turned = g.fixed_view::<3, 3>(0, 0).into_owned();
    let (body, around) = (omega.cross(&r) + u, omega.cross(&r));
    let near = |a: f64, b: f64| assert!((a - b).abs() < ROUNDING, "{a} {b}");

    // ⟨f, η⟩ = F · v, with F and v in the body or in space.
    let in_body = AtPoint::in_body(constant(&f), r, &space());
    near(pair(&in_body.force_at(0.0, Configuration::of(&g), &eta), &eta), f.dot(&body));
    assert!((in_body.point_velocity(&eta) - body).amax() < ROUNDING);
    let in_space = AtPoint::in_space(constant(&f), r, &space());
    let wrench: Covector<f64, 6> = in_space.force_at(0.0, Configuration::of(&g), &eta);
    near(pair(&wrench, &eta), f.dot(&(turned * body)));
    let local = turned.transpose() * f;
    let (moment, push) = split(&wrench.transpose());
    assert!((moment - r.cross(&local)).amax() < ROUNDING && (push - local).amax() < ROUNDING);

    // A body about a fixed point, and a force that depends on the velocity of the point.
    let rotation = ExponentialSo3::<f64>::new().tau(&Vector::<f64, 3>::new(0.4, -0.3, 0.2)).unwrap();
    let matrix = Matrix::<f64, 3>::new(1.0, 0.5, 0.0, 0.25, 2.0, 0.0, 0.0, -0.5, 3.0);
    let damper = AtPoint::in_space(LinearDrag::new(matrix).unwrap(), r, &So3::new());
    let speed = rotation * around;
    let torque: Covector<f64, 3> = damper.force_at(0.0, Configuration::of(&rotation), &omega);
    near(pair(&torque, &omega), -speed.dot(&(matrix * speed)));
    let drag = AtPoint::in_body(QuadraticDrag::new(Matrix::<f64, 3>::identity()).unwrap(), r, &So3::new());
    near(pair(&Force::<f64, 3>::force(&drag, 0.0, &omega), &omega), -around.norm().powi(3));

    // In another basis of the algebra the components are others, and the power is the same.
    let basis = Matrix::<f64, 6>::from_fn(|a, b| if a == b { 1.0 } else { 0.125 * (a as f64 - 2.0 * b as f64) });
    let other = space().in_basis(&basis).unwrap();
    let moved = AtPoint::in_body(constant(&f), r, &other);
    let coordinates = other.vee(&space().hat(&eta));
    near(pair(&moved.force(0.0, &coordinates), &coordinates), f.dot(&body));
}

/// A spring of stiffness 3 from the point (1, 2, −1)/2 of a body to the point (1, 0, 2) of space.
#[derive(Clone, Copy)]
struct Spring;

impl Spring {
    /// The vector from its end in space to its end at the body.
    fn length<S: Scalar>(g: &Matrix<S, 4>) -> Vector<S, 3> {
        let ends = [S::one(), S::zero(), S::int(2)];
        Vector::from_fn(|k, _| (g[(k, 0)] + g[(k, 1)] * S::int(2) - g[(k, 2)]) * S::half() + g[(k, 3)] - ends[k])
    }
}

impl<T: Real> Potential<T, 4> for Spring {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 4>) -> S {
        let length = Self::length(g);
        (length[0] * length[0] + length[1] * length[1] + length[2] * length[2]) * S::ratio(3, 2)
    }
}

impl<T: Real> ForceOnGroup<T, 3, 4> for Spring {
    fn force<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 4>, _: &Vector<S, 3>) -> Covector<S, 3> {
        (Self::length(g) * S::int(-3)).transpose()
    }
}

#[test]
fn a_spring_at_a_point_is_its_potential_and_forces_compose() {
    let (g, r) = (place(), Vector::<f64, 3>::new(0.5, 1.0, -0.5));
    let spring = AtPoint::in_space(OnGroup::<_, 4>(Spring), r, &space());
    let eta = Vector::<f64, 6>::zeros();
    let force = spring.force_at(0.0, Configuration::of(&g), &eta);
    let gradient: Covector<f64, 6> = Potential::gradient(&Spring, &space(), 0.0, &g);
    assert!((force + gradient).amax() < ROUNDING, "{force} {gradient}");
    assert!(Force::<f64, 6>::uses_configuration(&spring) && !Force::<f64, 6>::is_zero(&spring));

    // Half of the thrust of a control, in the middle of its spline.
    let push = Vector::<f64, 3>::new(1.0, 0.0, 2.0);
    let control = Control::new(vec![0.0, 2.0], vec![0.0, 1.0], Hold::Spline).unwrap();
    let driven = AtPoint::in_body(Driven::new(constant(&push), control), r, &space());
    let full: Covector<f64, 6> = AtPoint::in_body(constant(&push), r, &space()).force(0.0, &eta);
    let sum = (&driven, &spring).force_at(1.0, Configuration::of(&g), &eta);
    assert!((sum - force - full * 0.5).amax() < ROUNDING);
    assert!(!Force::<f64, 6>::uses_configuration(&driven) && !Force::<f64, 6>::is_smooth(&driven));
    assert!(Force::<f64, 6>::is_zero(&AtPoint::in_space(Zero, r, &space())));
}

/// The reciprocal of the time: it has no value at 0.
struct Reciprocal;

impl<T: Real> Signal<T> for Reciprocal {
    fn value<S: Scalar<Base = T>>(&self, t: S) -> S {
        S::one() / t
    }
}

/// A torque about the vertical.
struct Upward;

impl<T: Real> ForceOnGroup<T, 6, 4> for Upward {
    fn force<S: Scalar<Base = T>>(&self, _: S, _: &Matrix<S, 4>, _: &Vector<S, 6>) -> Covector<S, 6> {
        Covector::from_fn(|_, a| if a == 2 { S::one() } else { S::zero() })
    }
}

#[test]
fn what_has_no_value_says_why() {
    let (eta, here) = (Vector::<f64, 6>::zeros(), place());
    let push = Vector::<f64, 6>::from_element(1.0);
    let driven = Driven::new(Constant::new(push.transpose()).unwrap(), Reciprocal);
    let why = |t: f64, g: &Matrix<f64, 4>| (&driven, &Zero).undefined(t, Configuration::of(g), &eta);
    assert_eq!(why(1.0, &here), None);
    assert_eq!(why(0.0, &here).as_deref(), Some("the signal has no finite value"));
    let upward = InSpace::new(Upward, space());
    let why = |g: &Matrix<f64, 4>| upward.undefined(0.0, Configuration::of(g), &eta);
    assert_eq!(why(&here), None);
    assert_eq!(why(&Matrix::zeros()).as_deref(), Some("the attitude is a singular matrix"));
}
