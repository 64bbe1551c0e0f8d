//! Properties of `euler_poincare::integrators::State`: what it comes from and goes to.

use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::So3;
use euler_poincare::integrators::State;
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction, RetractionError};
use euler_poincare::scalar::{Dd, Scalar};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};

fn turns() -> impl Iterator<Item = Vector3<f64>> {
    let angles = [0.0, 1e-9, 0.5, 2.0, 3.1, std::f64::consts::PI];
    angles.into_iter().map(|angle| Vector3::new(2.0, -1.0, 2.0) / 3.0 * angle)
}

#[test]
fn rotations_quaternions_and_isometries_go_there_and_back() {
    let momentum = Covector::<f64, 3>::new(1.0, -2.0, 0.5);
    for turn in turns() {
        let rotation = Rotation3::new(turn);
        let state = State::with_rotation(momentum, rotation);
        assert_eq!((state.time, state.momentum, state.rotation()), (0.0, momentum, rotation));
        let quaternion = UnitQuaternion::new(turn);
        let state = State::with_rotation(momentum, quaternion).at_time(3.0);
        assert_eq!(state.time, 3.0);
        assert!(state.quaternion().angle_to(&quaternion) < 1e-15, "{turn}");
        let isometry = Isometry3::new(Vector3::new(1.0, 2.0, -3.0), turn);
        let state = State::with_isometry(Covector::from([1.0; 6]), isometry);
        assert_eq!(state.attitude, isometry.to_homogeneous());
        let back = state.isometry();
        assert_eq!(back.translation, isometry.translation);
        assert!(back.rotation.angle_to(&isometry.rotation) < 1e-15, "{turn}");
    }
}

#[test]
fn a_state_is_one_line() {
    let state: State<f64, 2, 2> =
        State::new([0.5, -1.0].into(), Matrix::<f64, 2>::new(1.0, 2.0, 3.0, 4.0)).at_time(0.25);
    assert_eq!(state.to_string(), "t = 0.25, μ = (0.5, -1), g = [1 2; 3 4]");
    assert_eq!(format!("{state:.2}"), "t = 0.25, μ = (0.50, -1.00), g = [1.00 2.00; 3.00 4.00]");
    let fine: State<Dd, 1, 1> = State::at_identity(Covector::<Dd, 1>::new(Dd::ratio(1, 3)));
    assert!(fine.to_string().contains("0.33333333333333333333333333"), "{fine}");
}

#[test]
fn plus_and_minus_undo_each_other() {
    fn check<R: Retraction<f64, 3, 3>>(retraction: &R) {
        let g = retraction.tau(&Vector3::new(0.5, -1.0, 0.25)).unwrap();
        for x in turns().take(4) {
            let h = retraction.plus(&g, &x).unwrap();
            assert!((retraction.minus(&h, &g).unwrap() - x).norm() < 1e-14, "{x}");
        }
        let singular = Matrix::<f64, 3>::from_diagonal(&Vector3::new(1.0, 0.0, 1.0));
        assert!(matches!(retraction.minus(&g, &singular), Err(RetractionError::NoPreimage { .. })));
        assert!(retraction.plus(&g, &Vector3::new(f64::NAN, 0.0, 0.0)).is_err());
    }
    check(&CayleySo3::new());
    check(&ExponentialSo3::new());
    check(&euler_poincare::retraction::Exponential::of_group(So3::new()));
}
