//! Ensembles of members that are moved by any method.

use super::Body;
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::integrators::trajectory::integrate;
use euler_poincare::integrators::{Ensemble, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{Potential, WithPotential};
use euler_poincare::mechanics::{Force, force};
use euler_poincare::retraction::ExponentialSo3;
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::tableau::Family;

/// A weight at the distance `self.0` from the fixed point.
#[derive(Clone)]
struct Weight(f64);

impl Potential<f64, 3> for Weight {
    fn value<S: Scalar<Base = f64>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        g[(2, 2)] * S::lift(self.0)
    }
}

/// No force until a time, and none that is a number after it.
#[derive(Clone)]
struct Until(f64);

impl<T: Real> Force<T, 3> for Until {
    fn force<S: Scalar<Base = T>>(&self, time: S, _: &Vector<S, 3>) -> Covector<S, 3> {
        let value = if time.to_f64() < self.0 { S::zero() } else { S::exact(f64::NAN) };
        Covector::<S, 3>::repeat(value)
    }
}

fn start() -> State<f64, 3, 3> {
    State::at_identity(Covector::<f64, 3>::new(0.5, 0.3, 0.9))
}

#[test]
fn a_member_moves_as_it_does_alone() {
    let method = |k: i32| {
        let top = WithPotential::new(Body, Weight(f64::from(k) / 4.0), So3::new());
        Variational::new(top, force::Zero, ExponentialSo3::new(), Family::Gauss.tableau(2).unwrap())
    };
    let mut ensemble = Ensemble::new((0..20).map(|k| (method(k), start())));
    ensemble.advance(0.125, 16).unwrap();
    ensemble.advance(0.125, 16).unwrap();
    for (k, found) in ensemble.states().enumerate() {
        let (mut method, mut state) = (method(k as i32), start());
        for _ in 0..2 {
            integrate(&mut method, &mut state, 0.125, 16, |_, _, _| {}).unwrap();
        }
        assert_eq!(*found, state, "member {k}");
    }
    assert_eq!((ensemble.len(), ensemble.is_empty(), ensemble.state(20)), (20, false, None));
    // On from another state.
    ensemble.members_mut().for_each(|(_, state)| *state = start());
    ensemble.advance(0.125, 0).unwrap();
    assert!(ensemble.states().all(|state| *state == start()));
}

#[test]
fn a_member_that_cannot_go_on_is_named() {
    let method = |k: i32| {
        let until = Until(if k == 2 { 0.3 } else { 9.0 });
        Variational::new(Body, until, ExponentialSo3::new(), Family::Gauss.tableau(1).unwrap())
    };
    let mut ensemble = Ensemble::new((0..4).map(|k| (method(k), start())));
    let error = ensemble.advance(0.125, 8).unwrap_err();
    assert_eq!((error.member, error.step, error.time), (2, 2, 0.25));
    assert!(matches!(error.source, StepError::Undefined { .. }), "{error}");
    // Its state is the last that it reached; the others may have gone to the end.
    assert_eq!(ensemble.state(2).map(|state| state.time), Some(0.25));
    assert!(ensemble.states().all(|state| state.time <= 1.0));
}
