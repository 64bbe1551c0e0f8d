//! Branches of roots: where they end, where they turn fast and go on, and where another crosses.

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::integrators::{OneStep, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{Potential, WithPotential};
use euler_poincare::mechanics::force::Zero;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::newton::{Equations, Failure, Newton, NewtonSettings, Outcome};
use euler_poincare::retraction::ExponentialSo3;
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::tableau::Family;
use nalgebra::DMatrix;

/// F(x, s) = 0 in as many unknowns, at s, by F and ∂F/∂x.
pub struct Branch<F>(usize, f64, F);

pub fn branch<F: FnMut(&[f64], f64) -> (Vec<f64>, DMatrix<f64>)>(dimension: usize, equations: F) -> Branch<F> {
    Branch(dimension, 0.0, equations)
}

/// The same in one unknown.
pub fn one(mut equations: impl FnMut(f64, f64) -> [f64; 2]) -> impl Equations<f64, Error = ()> {
    branch(1, move |x, s| {
        let [residual, slope] = equations(x[0], s);
        (vec![residual], DMatrix::from_element(1, 1, slope))
    })
}

impl<F: FnMut(&[f64], f64) -> (Vec<f64>, DMatrix<f64>)> Equations<f64> for Branch<F> {
    type Error = ();

    fn dimension(&self) -> usize {
        self.0
    }

    fn set_fraction(&mut self, fraction: f64) {
        self.1 = fraction;
    }

    fn residual(&mut self, x: &[f64], out: &mut [f64]) -> Result<f64, ()> {
        out.copy_from_slice(&(self.2)(x, self.1).0);
        Ok(1.0)
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) -> Result<(), ()> {
        out.copy_from(&(self.2)(x, self.1).1);
        Ok(())
    }
}

/// The root at s = 1 of the branch from x at s = 0.
fn followed(equations: fn(f64, f64) -> [f64; 2], x: f64) -> (Result<Outcome<f64>, Failure<f64, ()>>, f64) {
    let settings = NewtonSettings { tolerance: 1e-14, floor: 1e-13, max_iterations: 20 };
    let mut x = [x];
    (Newton::new(1).follow(&mut one(equations), &mut x, &settings), x[0])
}

#[test]
fn a_fold_is_where_the_branch_turns_back() {
    for (equations, x, fold) in [
        ((|x, s| [x * x - 1.0 + 2.0 * s, 2.0 * x]) as fn(f64, f64) -> [f64; 2], 1.0, 0.5),
        (|x, s| [x * x - 1.0 + 1e9 * s, 2.0 * x], 1.0, 1e-9),
        (|x, s| [x * x - 1.0 + s * (1.0 + 1e-6), 2.0 * x], 1.0, 1.0 / (1.0 + 1e-6)),
        // It turns twice, and goes on to s = 1: the root there is another.
        (|x, s| [x * x * x - x - 1.0 + 2.0 * s, 3.0 * x * x - 1.0], 1.324717957244746, 0.5 + 1.0 / 27f64.sqrt()),
    ] {
        let (found, x) = followed(equations, x);
        let Err(Failure::Fold { fraction, determinant }) = found else { panic!("{found:?} at {x} for {fold}") };
        assert!((fraction / fold - 1.0).abs() < 1e-6 && determinant < 1e-2, "{fraction} for {fold}, {determinant}");
    }
}

/// Case 1490 of seed 30111126 of the law `branch`: both folds of an S were within one step along the branch, which looked at its ends alone.
///
/// 9/4 s = y³ − depth y + 1 − depth, y = (x₁ − 1)/width − 1: from x₁ = 1 at s = 0, steep at y = 0, where the branch turns back and forth again if
/// depth > 0, in an S of |y| < (depth/3)^½. The other unknowns follow x₁ and s.
#[test]
fn an_s_that_is_narrow_is_a_fold() {
    let settings = NewtonSettings { tolerance: 1e-14, floor: 1e-12, max_iterations: 20 };
    for (dimension, width) in [1, 3].into_iter().flat_map(|n| [0.1, 0.3137, 0.93, 1.5, 3.0].map(|width| (n, width))) {
        for (depth, turns) in (1..=26).flat_map(|k| [(0.5f64.powi(k), true), (-0.5f64.powi(k), false)]) {
            let at = |y: f64| (y * y * y - depth * y + 1.0 - depth) / 2.25;
            let mut steep = branch(dimension, |x, s| {
                let y = (x[0] - 1.0) / width - 1.0;
                let mut residual: Vec<f64> = x.iter().map(|x_k| x_k - x[0].sin() / 2.0 - s.cos()).collect();
                residual[0] = at(y) - s;
                let mut jacobian = DMatrix::identity(dimension, dimension);
                jacobian.column_mut(0).fill(-x[0].cos() / 2.0);
                jacobian[(0, 0)] = (3.0 * y.powi(2) - depth) / (2.25 * width);
                (residual, jacobian)
            });
            let mut x = [1.0, 1.0f64.sin() / 2.0 + 1.0, 1.0f64.sin() / 2.0 + 1.0];
            let found = Newton::new(dimension).follow(&mut steep, &mut x[..dimension], &settings);
            match found {
                Ok(_) if !turns => {}
                Err(Failure::Fold { fraction, .. }) if turns => {
                    let fold = at(-(depth / 3.0).sqrt());
                    assert!((fraction / fold - 1.0).abs() < 1e-3, "{fraction} for {fold}");
                }
                _ => panic!("depth {depth:e}, width {width}, {dimension} unknowns: {found:?} at {x:?}"),
            }
        }
    }
}

#[test]
fn what_is_no_fold_is_followed() {
    for (equations, x, end) in [
        // Just before a fold.
        ((|x, s| [x * x - 1.0 + s * (1.0 - 1e-6), 2.0 * x]) as fn(f64, f64) -> [f64; 2], 1.0, 1e-3),
        // From rest.
        (|x, s| [x - s * s, 1.0], 0.0, 1.0),
        // A turn within 10⁻⁴ of the way.
        (|x, s| [x - (1e4 * (s - 0.3)).tanh(), 1.0], -1.0, 1.0),
        // Another branch crosses, two begin, and J is singular without a change of its sign.
        (|x, s| [-x * (x - (s - 0.5)), -2.0 * x + (s - 0.5)], 0.0, 0.0),
        (|x, s| [x * (x * x - (s - 0.3)), 3.0 * x * x - (s - 0.3)], 0.0, 0.0),
        (|x, s| [(s - 0.3) * (s - 0.3) * (x - 1.0), (s - 0.3) * (s - 0.3)], 1.0, 1.0),
    ] {
        let (found, x) = followed(equations, x);
        assert!(found.is_ok() && (x - end).abs() < 1e-9, "{found:?} at {x} for {end}");
    }
}

/// One step from rest in space along the axis e₃ of a top whose axis leans, and of a satellite.
enum Place {
    Top,
    Orbit,
}

impl<T: Real> Potential<T, 3> for Place {
    fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, 3>) -> S {
        match self {
            Self::Top => g[(2, 2)],
            Self::Orbit => {
                let angle = t * S::half();
                let down = g.transpose() * Vector::<S, 3>::new(angle.cos(), angle.sin(), S::zero());
                let inertia = [S::one(), S::ratio(3, 2), S::int(2)];
                let gradient = (0..3).fold(S::zero(), |sum, k| sum + inertia[k] * down[k] * down[k]) * S::ratio(3, 8);
                gradient - (g[(2, 1)] * S::ratio(1, 20) + g[(2, 2)] * S::ratio(1, 10))
            }
        }
    }
}

fn step(place: Place, h: f64) -> Result<State<f64, 3, 3>, StepError> {
    let turn = |axis, angle| nalgebra::Rotation3::from_axis_angle(&axis, angle);
    let (inertia, momentum, attitude, stages) = match place {
        Place::Top => ([1.0, 1.0, 0.5], [0.0, 0.0, 2.5], turn(Vector::y_axis(), 0.8f64.acos()), 3),
        Place::Orbit => {
            let attitude = turn(Vector::z_axis(), 0.2) * turn(Vector::x_axis(), 0.1);
            ([1.0, 1.5, 2.0], [0.05, 0.03, 1.0], attitude, 2)
        }
    };
    let top = WithPotential::new(Quadratic::diagonal(inertia).unwrap(), place, So3::new());
    let mut method = Variational::new(top, Zero, ExponentialSo3::new(), Family::Gauss.tableau(stages).unwrap());
    let momentum = Covector::<f64, 3>::from(momentum);
    let mut state = State { time: 0.0, momentum, attitude: attitude.into_inner() };
    method.step(&mut state, h).map(|_| state)
}

/// At h = 1.2048 the branch of the heavy top turns within 10⁻² of h, and goes on.
#[test]
fn a_step_does_not_depend_on_how_far_it_goes() {
    for h in [1.2, 1.21, 1.25, 1.5, 2.0, 5.0, 10.0, 30.0, 45.0, 50.0] {
        let state = step(Place::Top, h).unwrap_or_else(|error| panic!("h = {h}: {error}"));
        // The spin of a symmetric top is kept.
        assert!((state.momentum[2] - 2.5).abs() < 1e-12, "h = {h}: {}", state.momentum);
    }
    for h in [5.0, 11.4, 11.5, 11.6, 12.0, 13.0, 14.0, 14.4] {
        step(Place::Orbit, h).unwrap_or_else(|error| panic!("h = {h}: {error}"));
    }
    for h in [14.5, 15.0, 20.0, 50.0, 100.0, 1000.0, 1e4] {
        let found = step(Place::Orbit, h);
        let Err(StepError::Fold { fold, .. }) = found else { panic!("h = {h}: {found:?}") };
        assert!((fold - 14.423468).abs() < 1e-5, "h = {h}: {fold}");
    }
}

#[test]
fn small_steps_are_told_in_digits() {
    let told = |fold| StepError::Fold { step: 1e-6, fold, determinant: 0.0 }.to_string();
    assert!(told(1.234567891e-9).contains("near h = 1.234568e-9"), "{}", told(1.234567891e-9));
    assert!(told(0.79665520001).contains("near h = 0.7966552,"), "{}", told(0.79665520001));
    let long = StepError::TooLong { step: 50.0, reached: 0.0 }.to_string();
    assert!(long.contains("followed to h = 0; take a smaller step"), "{long}");
    let rounding = StepError::Rounding { step: 864.0, reached: 273.5, residual: 2e-12, floor: 1.8e-12 }.to_string();
    assert!(rounding.contains("followed to h = 273.5, before the step h = 864; from there on"), "{rounding}");
}
