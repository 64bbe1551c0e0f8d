//! Properties of `euler_poincare::integrators::derivative`: what the laws `derivative-step` and `derivative-run` do not ask. They compare
//! tangents with differences in 32 digits and adjoints with tangents, of one step and of four; the examples `fit` and `turn` need both.

use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::integrators::derivative::{Derivative, Gradient, InputGradient, Linearised, Parameters, Variation};
use euler_poincare::integrators::{OneStep, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{Configuration, ForceOnGroup, OnGroup, Potential, WithPotential};
use euler_poincare::mechanics::force::{LinearDrag, Zero};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::{Force, Lagrangian, LegendreError};
use euler_poincare::retraction::{Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::tableau::{Family, Tableau};
use nalgebra::{DMatrix, DVector};

/// f_a = −(p₀ + p₁ |η|²) η_a + p₂ cos t (g_xy + g_0x η_b).
#[derive(Clone, Copy)]
struct Loads([f64; 3]);

impl ForceOnGroup<f64, 3, 3> for Loads {
    fn force<S: Scalar<Base = f64>>(&self, t: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let [p0, p1, p2] = self.0.map(S::lift);
        Covector::from_fn(|_, a| {
            let at = g[(a, (a + 1) % 3)] + g[(0, a)] * eta[(a + 1) % 3];
            p2 * t.cos() * at - (p0 + p1 * eta.dot(eta)) * eta[a]
        })
    }
}

/// V = p₃ Σ w_rc g_rc.
#[derive(Clone, Copy)]
struct Weight(f64);

impl Potential<f64, 3> for Weight {
    fn value<S: Scalar<Base = f64>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        let mut sum = S::zero();
        for r in 0..3 {
            for c in 0..3 {
                sum += g[(r, c)] * S::ratio((r as i64 + 2 * c as i64 + 1) % 5 - 2, 4);
            }
        }
        sum * S::lift(self.0)
    }
}

/// The parameters p₀ … p₃, and p₄, which is added to the first moment of inertia.
struct All;

impl Parameters<f64, 3> for All {
    fn count(&self) -> usize {
        5
    }

    fn force(&self, k: usize, t: f64, g: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        let unit = std::array::from_fn(|l| f64::from(l == k));
        match k {
            0..3 => Loads(unit).force(t, &g.matrix::<3>(), eta),
            3 => -Weight(1.0).gradient(&So3::new(), t, &g.matrix::<3>()),
            _ => Covector::zeros(),
        }
    }

    fn momentum(&self, k: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if k == 4 && a == 0 { eta[0] } else { 0.0 })
    }
}

fn inertia(extra: f64) -> Quadratic<f64, 3> {
    Quadratic::new(Matrix::<f64, 3>::new(1.0 + extra, 0.0625, 0.041, 0.0625, 1.25, 0.0625, 0.041, 0.0625, 1.5)).unwrap()
}

type Body = WithPotential<Quadratic<f64, 3>, Weight, So3<f64>, 3>;

/// A body with all of them, in Gauss's method of two stages.
fn general() -> Linearised<f64, 3, 3, Body, OnGroup<Loads, 3>, ExponentialSo3<f64>, All> {
    let body = WithPotential::new(inertia(0.125), Weight(0.5), So3::new());
    Linearised::new(Variational::new(body, OnGroup(Loads([0.125, 0.0625, 0.25])), ExponentialSo3::new(), gauss()), All)
}

fn gauss() -> Tableau<f64> {
    Family::Gauss.tableau(2).unwrap()
}

fn start() -> State<f64, 3, 3> {
    let [x, momentum] = [[0.375, 0.125, -0.125], [0.625, 0.25, -0.125]].map(Vector::<f64, 3>::from);
    State { time: 0.25, momentum: momentum.transpose(), attitude: ExponentialSo3::new().tau(&x).unwrap() }
}

/// The numbers of a gradient.
fn numbers(gradient: InputGradient<f64, 3>) -> DVector<f64> {
    let InputGradient { state, time, step, parameters } = gradient;
    let state = state.attitude.iter().chain(state.momentum.iter()).copied();
    DVector::from_vec(state.chain([time, step]).chain(parameters).collect())
}

fn near(found: &DMatrix<f64>, wanted: &DMatrix<f64>, within: f64, what: &str) {
    let defect = (found - wanted).amax() / wanted.amax();
    assert!(defect <= within, "{what}: {defect:e} of {:e}\n{found:.3}{wanted:.3}", wanted.amax());
}

/// A force f(η) on an algebra without a group: ζ is defined all the same.
#[test]
fn tangents_need_no_group() {
    let algebra = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3).unwrap();
    let drag = LinearDrag::new(Matrix::<f64, 3>::new(0.3, 0.1, 0.0, -0.2, 0.4, 0.1, 0.0, 0.3, 0.2)).unwrap();
    let without = Exponential::<f64, 3, 3>::of_algebra(algebra);
    let mut without = Linearised::new(Variational::new(inertia(0.0), drag.clone(), without, gauss()), ());
    let mut with = Linearised::new(Variational::new(inertia(0.0), drag, ExponentialSo3::new(), gauss()), ());
    let (_, one) = without.step(&mut start(), 0.25).unwrap();
    let (_, other) = with.step(&mut start(), 0.25).unwrap();
    near(one.matrix(), other.matrix(), 1e-14, "so(3)");
}

/// Σ_n of half the square of the momentum, and of an entry of the attitude at the end.
fn terms(n: usize, steps: usize, state: &State<f64, 3, 3>) -> Gradient<f64, 3> {
    // d/ds g exp(s ê_a)_02 = (g ê_a)_02, with ê_a e₃ the a-th unit vector × e₃.
    let turned = Covector::<f64, 3>::new(-state.attitude[(0, 1)], state.attitude[(0, 0)], 0.0);
    Gradient { attitude: if n == steps { turned } else { Covector::zeros() }, momentum: state.momentum.transpose() }
}

#[test]
fn gradients_of_runs_are_those_of_sensitivities() {
    let (h, from) = (0.125, start());
    for steps in [0, 1, 2, 3, 4, 8, 10, 17] {
        let mut method = general();
        let mut asked = Vec::new();
        let gradient = method
            .gradient(&from, h, steps, |n, state| {
                asked.push(n);
                assert!((state.time - 0.25 - n as f64 * h).abs() < 1e-15);
                terms(n, steps, state)
            })
            .unwrap();
        assert!(asked.iter().copied().eq((0..=steps).rev()), "{asked:?}");
        let first = terms(0, steps, &from);
        let mut forward = DVector::<f64>::zeros(13);
        forward.rows_mut(0, 3).copy_from_slice(first.attitude.as_slice());
        forward.rows_mut(3, 3).copy_from_slice(first.momentum.as_slice());
        let mut add = |n: usize, state: &State<f64, 3, 3>, derivative: &Derivative<f64, 3>| {
            let term = terms(n, steps, state);
            let row = DVector::from_iterator(6, term.attitude.iter().chain(term.momentum.iter()).copied());
            forward += derivative.matrix().transpose() * row;
        };
        method.sensitivity(&mut from.clone(), h, steps, &mut add).unwrap();
        let found = DMatrix::from_columns(&[numbers(gradient)]);
        near(&found, &DMatrix::from_columns(&[forward]), 1e-13, &format!("{steps} steps"));
    }
}

/// l = η⁴/4: at rest l'' = 0, and Newton's method does not invert l' there.
struct Singular;

impl<T: Real> Lagrangian<T, 1> for Singular {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 1>) -> S {
        eta[0] * eta[0] * eta[0] * eta[0] * S::ratio(1, 4)
    }
}

/// The same with an inverse of l' that has a value at rest: there the step is solved, and J = 0.
struct Flat;

impl<T: Real> Lagrangian<T, 1> for Flat {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 1>) -> S {
        Singular.value(eta)
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, 1>,
        _: &Vector<S, 1>,
    ) -> Result<Vector<S, 1>, LegendreError> {
        Ok(Vector::<S, 1>::new(S::lift(mu[0].base().cbrt())))
    }
}

/// f = −√|η|, which has no derivative at rest.
struct Root;

impl<T: Real> Force<T, 1> for Root {
    fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 1>) -> Covector<S, 1> {
        Covector::<S, 1>::new(-(eta[0] * eta[0]).sqrt().sqrt())
    }
}

/// ∂f/∂p = NaN.
struct Broken;

impl Parameters<f64, 1> for Broken {
    fn count(&self) -> usize {
        1
    }

    fn force(&self, _: usize, _: f64, _: Configuration<'_, f64>, _: &Vector<f64, 1>) -> Covector<f64, 1> {
        Covector::<f64, 1>::new(f64::NAN)
    }
}

#[test]
fn what_has_no_derivative_is_refused_and_the_state_kept() {
    let line = || Exponential::<f64, 1, 2>::of_algebra(LieAlgebra::from_catalogue(&Entry::Abelian(1)).unwrap());
    let rest = State::at_identity(Covector::<f64, 1>::zeros());
    let mut state = rest.clone();

    let mut method = Variational::new(Singular, Zero, line(), gauss());
    let refused = method.step(&mut state, 0.1).map(|_| ()).unwrap_err();
    assert!(
        matches!(&refused, StepError::Legendre { source: LegendreError::Singular { rank: Some(0), .. }, .. }),
        "{refused}"
    );
    assert_eq!(state, rest);

    let mut method = Linearised::new(Variational::new(Flat, Zero, line(), gauss()), ());
    let refused = method.step(&mut state, 0.1).map(|_| ()).unwrap_err();
    assert!(
        matches!(refused, StepError::SingularJacobian { condition, .. } if condition == f64::INFINITY),
        "{refused}"
    );
    let refused = method.sensitivity(&mut state, 0.1, 3, |_, _, _| {}).unwrap_err();
    assert!(refused.index == 0 && matches!(refused.source, StepError::SingularJacobian { .. }));
    let refused = method.gradient(&rest, 0.1, 3, |_, _| Gradient::zero()).unwrap_err();
    assert!(refused.index == 2 && matches!(refused.source, StepError::SingularJacobian { .. }), "{refused}");

    let unit = || Quadratic::<f64, 1>::diagonal([1.0]).unwrap();
    let mut method = Linearised::new(Variational::new(unit(), Root, line(), gauss()), ());
    let refused = method.step(&mut state, 0.1).map(|_| ()).unwrap_err();
    assert!(matches!(refused, StepError::Undefined { .. }), "{refused}");

    let mut method = Linearised::new(Variational::new(unit(), Zero, line(), gauss()), Broken);
    let refused = method.step(&mut state, 0.1).map(|_| ()).unwrap_err();
    assert!(matches!(refused, StepError::NotFinite { .. }), "{refused}");
    assert_eq!(state, rest);

    let mut method = Linearised::new(Variational::new(unit(), Zero, line(), gauss()), ());
    let (_, step) = method.step(&mut state, 0.1).unwrap();
    let refused = step.tangent(&Variation::zero(), 0.0, 0.0, &[1.0]).unwrap_err();
    assert_eq!(refused, StepError::Parameters { found: 1, needed: 0 });
    assert!(step.tangent(&Variation::zero(), f64::NAN, 0.0, &[]).is_err());
    let nowhere = Gradient { momentum: Vector::<f64, 1>::new(f64::INFINITY), ..Gradient::zero() };
    assert!(step.adjoint(&nowhere).is_err());
    let refused = method.gradient(&rest, 0.1, 3, |_, _| nowhere).unwrap_err();
    assert!(matches!(refused.source, StepError::NotFinite { .. }), "{refused}");
}

/// A branch that folds at h = 17.6272: the condition number grows like the inverse root of the distance from there.
#[test]
fn the_condition_number_grows_towards_a_fold() {
    let inertia = Matrix::<f64, 3>::new(1.0, 0.25, 0.0, 0.25, 2.0, 0.125, 0.0, 0.125, 3.0);
    let condition = |h: f64| {
        let gauss = Family::Gauss.tableau(3).unwrap();
        let body = Quadratic::new(inertia).unwrap();
        let mut method = Linearised::new(Variational::new(body, Zero, ExponentialSo3::new(), gauss), ());
        let mut state = State::at_identity(Covector::<f64, 3>::new(0.75, 0.5, -1.0));
        method.step(&mut state, h).map(drop)?;
        Ok::<_, StepError>(method.condition())
    };
    let (far, near) = (condition(17.6).unwrap(), condition(17.627).unwrap());
    assert!(condition(1.0).unwrap() < 20.0 && far > 100.0 && near > 5.0 * far, "{far} {near}");
    assert!(matches!(condition(17.7), Err(StepError::Fold { .. })));
}
