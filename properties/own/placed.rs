//! Laws on a Lagrangian and a force of one's own that depend on the configuration: they are judged where they are, not at g = e.

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::{LieGroup, So3};
use euler_poincare::integrators::Variational;
use euler_poincare::laws::method::Claims;
use euler_poincare::laws::user::{Outcome, Suite, SuiteSettings};
use euler_poincare::mechanics::configuration::{ForceOnGroup, OnGroup, Potential, WithPotential};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::suite;
use euler_poincare::tableau::Family;

/// V = 1.3 ⟨e₃, g r⟩; with the mistake, its derivative is that at the transposed matrix.
struct Weight {
    wrong: bool,
}

fn height<S: Scalar>(g: &Matrix<S, 3>) -> S {
    (g[(2, 0)] * S::ratio(3, 10) - g[(2, 1)] * S::ratio(1, 5) + g[(2, 2)] * S::half()) * S::ratio(13, 10)
}

impl<T: Real> Potential<T, 3> for Weight {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        height(g)
    }

    fn gradient<S: Scalar<Base = T>, const N: usize>(
        &self,
        group: &impl LieGroup<T, N, 3>,
        _: S,
        g: &Matrix<S, 3>,
    ) -> Covector<S, N> {
        let g = if self.wrong { g.transpose() } else { *g };
        Covector::from_fn(|_, a| {
            let along = Vector::<S, N>::from_fn(|b, _| if a == b { S::one() } else { S::zero() });
            height(&(g * group.hat(&along)))
        })
    }
}

/// Drag, and a torque towards g = 1.
struct Spring;

impl<T: Real> ForceOnGroup<T, 3, 3> for Spring {
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let error = Vector::<S, 3>::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]);
        -(error * (S::one() + t.cos()) * S::ratio(1, 4) + eta * S::ratio(1, 5)).transpose()
    }
}

fn top<T: Real>(wrong: bool) -> WithPotential<Quadratic<T, 3>, Weight, So3<T>, 3> {
    let moments = [T::half(), T::int(2), T::one()];
    WithPotential::new(Quadratic::diagonal(moments).unwrap(), Weight { wrong }, So3::new())
}

suite! {
    mod tops<T, 3, 3> {
        group: So3::<T>::new(),
        lagrangian: top::<T>(false),
        force: OnGroup(Spring),
        method: |system| Variational::new(&system.lagrangian, &system.force, &system.retraction, Family::Gauss.tableau(2).unwrap()),
        claims: Claims { order: Some(4), energy: true, stages: true, ..Claims::default() },
    }
}

suite! {
    mod wrong_tops<T, 3, 3> {
        group: So3::<T>::new(),
        lagrangian: top::<T>(true),
    }
}

fn run(suite: &Suite, law: &str) -> Outcome {
    suite.run(law, &SuiteSettings { cases: 6, ..SuiteSettings::new() })
}

#[test]
fn laws_that_know_the_configuration_judge_it() {
    let suite = tops::suite();
    let laws = "configuration-gradient plain-step discrete-noether retraction-adjoint step-accuracy \
        order-momentum-attitude energy-balance solve-dense method-order method-energy method-noether \
        method-equivariance method-momentum method-smoothness";
    for law in laws.split(' ') {
        let outcome = run(&suite, law);
        assert!(matches!(outcome, Outcome::Held { .. }), "{law}: {outcome:?}");
    }
}

#[test]
fn laws_of_reduced_systems_do_not() {
    for law in ["lie-poisson-equations", "free-poisson-map", "discrete-slopes", "doubled-splitting"] {
        let outcome = run(&tops::suite(), law);
        let Outcome::Off { why } = &outcome else { panic!("{law}: {outcome:?}") };
        assert!(why.contains("f(t, η) and l(η)"), "{law}: {why}");
    }
}

#[test]
fn a_wrong_derivative_of_a_potential_is_found() {
    for law in ["configuration-gradient", "energy-balance"] {
        let outcome = run(&wrong_tops::suite(), law);
        assert!(matches!(outcome, Outcome::Broken(_)), "{law}: {outcome:?}");
    }
}
