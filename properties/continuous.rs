//! Properties of the continuous theory, on g×G×g and g*×G×g*, that the laws do not ask of random systems.

use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, Vector};
use euler_poincare::mechanics::doubled::{
    DoubledLagrangian, Forced, MomentumPoint, VelocityError, VelocityPoint, velocity_hessian_by_duals,
};
use euler_poincare::mechanics::euler_lagrange::{accelerations, rates};
use euler_poincare::mechanics::force::{DoubleBracket, LinearDrag};
use euler_poincare::mechanics::forced_hamiltonian::ForcedHamiltonian;
use euler_poincare::mechanics::hamiltonian::{
    LegendreHamiltonian, hamilton_rates, hamiltonian_legendre_jacobian, hamiltonian_momenta, modified_legendre,
};
use euler_poincare::mechanics::lagrangian::{Quadratic, Quartic};
use euler_poincare::mechanics::{Lagrangian, LegendreError};
use euler_poincare::retraction::{CayleySo3, Retraction, RetractionError};
use euler_poincare::scalar::Scalar;

const TIGHT: f64 = 1e-13;

fn so3() -> LieAlgebra<f64, 3> {
    Retraction::<f64, 3, 3>::algebra(&CayleySo3::<f64>::new()).clone()
}

fn body() -> Quadratic<f64, 3> {
    Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap()
}

fn drag() -> LinearDrag<f64, 3> {
    LinearDrag::new(Matrix::<f64, 3>::new(0.3, 0.1, 0.0, -0.2, 0.4, 0.1, 0.0, 0.3, 0.2)).unwrap()
}

fn point() -> VelocityPoint<f64, 3, 3> {
    let u = CayleySo3::new().tau(&Vector::<f64, 3>::new(0.3, -0.2, 0.4)).unwrap();
    VelocityPoint {
        time: 0.0,
        eta: Vector::<f64, 3>::new(0.7, -0.3, 0.5),
        u,
        psi: Vector::<f64, 3>::new(0.2, 0.6, -0.4),
    }
}

/// Doubled Lagrangians of a kind that no system has.
enum Odd {
    /// Only the first velocity enters.
    Half(Quadratic<f64, 3>),
    /// ⟨η, Cψ⟩: regular, although neither diagonal block of the second derivatives is.
    Crossed,
}

impl DoubledLagrangian<f64, 3, 3> for Odd {
    fn value<S: Scalar<Base = f64>>(&self, at: &VelocityPoint<S, 3, 3>) -> Result<S, RetractionError> {
        let VelocityPoint { eta, psi, .. } = at;
        Ok(match self {
            Self::Half(body) => body.value(eta),
            Self::Crossed => eta[0] * psi[1] + eta[1] * psi[2] * S::int(2) + eta[2] * psi[0] * S::exact(1e-30),
        })
    }

    fn hat<S: Scalar<Base = f64>>(&self, xi: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        Ok(xi.cross_matrix())
    }
}

#[test]
fn accelerations_need_regularity_and_nothing_else() {
    let at = point();
    let singular = rates(&Odd::Half(body()), &so3(), &at);
    assert!(matches!(singular, Err(VelocityError::Legendre(LegendreError::Singular { .. }))));
    let (first, second) = (Covector::<f64, 3>::new(1.0, 2.0, 3e-30), Covector::<f64, 3>::new(4e-30, 5.0, 6.0));
    let (x, y) = accelerations(&Odd::Crossed, &at, &first, &second).unwrap();
    assert!((x - Vector::<f64, 3>::new(5.0, 3.0, 4.0)).amax() < TIGHT);
    assert!((y - Vector::<f64, 3>::new(3.0, 1.0, 1.0)).amax() < TIGHT);
}

#[test]
fn what_is_outside_the_domain_is_an_error() {
    let half_turn = Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(1.0, -1.0, -1.0));
    let doubled = Forced::new(body(), drag(), CayleySo3::new());
    let found = rates(&doubled, &so3(), &VelocityPoint { u: half_turn, ..point() });
    assert!(matches!(found, Err(VelocityError::Domain(_))));
    let h = ForcedHamiltonian::new(body(), drag(), CayleySo3::new());
    let (lambda, mu) = (Covector::<f64, 3>::new(0.1, 0.2, 0.3), Covector::<f64, 3>::new(0.3, 0.2, 0.1));
    assert!(hamilton_rates(&h, &so3(), &MomentumPoint { time: 0.0, lambda, u: half_turn, mu }).is_err());
    assert!(doubled.velocities(&MomentumPoint { time: 0.0, lambda, u: half_turn, mu }).is_err());
    let nan = Vector::<f64, 3>::new(f64::NAN, 0.0, 0.0);
    let nowhere = VelocityPoint { eta: nan, u: Matrix::identity(), ..point() };
    assert!(rates(&doubled, &so3(), &nowhere).is_err());
    assert!(hamiltonian_momenta(&h, &nowhere, (&lambda, &mu)).is_err());
}

/// The Jacobian of Fh̃× is the inverse of that of FL×: derivatives pass through the inverse transform.
#[test]
fn the_legendre_hamiltonian_carries_derivatives() {
    let at = point();
    let inertia = Matrix::<f64, 3>::new(1.0, 0.2, 0.0, 0.2, 2.0, 0.1, 0.0, 0.1, 1.5);
    let lagrangian: euler_poincare::mechanics::lagrangian::AnyLagrangian<f64, 3> =
        Quartic::new(inertia, 0.25).unwrap().into();
    let damping = DoubleBracket::new(so3(), lagrangian.clone(), 0.25).unwrap();
    let h = LegendreHamiltonian::new(Forced::new(lagrangian, damping, CayleySo3::new()));
    let momenta = modified_legendre(&h.doubled, &at).unwrap();
    let jacobian = hamiltonian_legendre_jacobian(&h, &momenta).unwrap();
    let ((a, c), (b, d)) = velocity_hessian_by_duals(&h.doubled, &at).unwrap();
    let mut of_velocities = Matrix::<f64, 6>::zeros();
    for (row, column, block) in [(0, 0, -a), (0, 3, -b), (3, 0, c), (3, 3, d)] {
        of_velocities.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    }
    assert!((jacobian * of_velocities - Matrix::<f64, 6>::identity()).amax() < 1e-12);
}
