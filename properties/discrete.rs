//! Properties of `euler_poincare::discrete`.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::discrete::{DiscreteLagrangian, StageLagrangian, Triple, legendre_minus, legendre_plus};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::{Doubled, DoubledState};
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::retraction::{CayleySo3, Exponential, Retraction};
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::tableau::{Description, Tableau};

fn tableau<T: Real>(name: &str) -> Tableau<T> {
    let description: Description = name.parse().expect("the name of a tableau");
    description.build().expect("a tableau")
}

fn rigid_body<T: Real>(name: &str) -> (f64, f64) {
    let model = landau_lifshitz_gilbert::<T>();
    let tau = CayleySo3::new();
    let forced = || Forced::new(model.system.lagrangian.clone(), model.system.force.clone(), tau.clone());
    let h = T::ratio(1, 8);
    let l_d = StageLagrangian::<T, _, _, 3, 3>::new(forced(), tau.clone(), tableau(name), h);
    let x = Vector::<T, 3>::new(T::ratio(1, 16), T::ratio(-1, 32), T::ratio(1, 20));
    let u: Matrix<T, 3> = tau.tau(&x).expect("in the domain");
    let lambda = model.momentum + Covector::<T, 3>::new(T::ratio(1, 8), T::ratio(-1, 16), T::zero());
    judge(forced(), &l_d, tau, name, h, [lambda, model.momentum], u)
}

fn body_in_a_fluid<T: Real>(name: &str) -> (f64, f64) {
    let se3 = MatrixGroup::<T, 6, 4>::from_entry(&Entry::Se3).expect("se(3) has dimension 6");
    let inertia = [(1, 2), (2, 1), (1, 1), (3, 1), (3, 2), (5, 4)].map(|(p, q)| T::ratio(p, q));
    let lagrangian = Quadratic::diagonal(inertia).expect("a regular inertia");
    let drag = |p, q| Matrix::from_diagonal_element(T::ratio(p, q));
    let force: AnyForce<T, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(1, 8)).expect("finite").into(),
        QuadraticDrag::new(drag(1, 4)).expect("positive").into(),
    ]);
    let mu = Covector::from([(1, 2), (-1, 4), (1, 1), (1, 1), (1, 2), (-1, 2)].map(|(p, q)| T::ratio(p, q)));
    let lambda = mu * T::ratio(3, 4);
    let tau = Exponential::of_group(se3);
    let forced = || Forced::new(lagrangian.clone(), force.clone(), tau.clone());
    let h = T::ratio(1, 8);
    let l_d = StageLagrangian::<T, _, _, 6, 4>::new(forced(), tau.clone(), tableau(name), h);
    let u = tau.tau(&(mu.transpose() * T::ratio(1, 16))).expect("in the domain");
    judge(forced(), &l_d, tau.clone(), name, h, [lambda, mu], u)
}

/// The largest defect of F∓ along a step of the doubled scheme, in units of round-off, and seconds an evaluation.
fn judge<T: Real, L, M, R, const N: usize, const D: usize>(
    forced: L,
    l_d: &M,
    tau: R,
    name: &str,
    h: T,
    [lambda, mu]: [Covector<T, N>; 2],
    u: Matrix<T, D>,
) -> (f64, f64)
where
    L: euler_poincare::mechanics::doubled::DoubledLagrangian<T, N, D>,
    M: DiscreteLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    let mut doubled = Doubled::new(tableau(name), &tau, forced);
    let start = DoubledState { time: T::zero(), lambda, relative: u, mu, attitudes: Some((Matrix::identity(), u)) };
    let mut end = start.clone();
    doubled.step(&mut end, h).expect("a step");
    let (g, partner) = end.attitudes.expect("carried along");
    let x = Triple { v: g, u, w: u.try_inverse().expect("regular") * partner };
    let clock = std::time::Instant::now();
    let (minus, plus) = (legendre_minus(l_d, &x).expect("F-"), legendre_plus(l_d, &x).expect("F+"));
    let seconds = clock.elapsed().as_secs_f64() / 2.0;
    let defects = [
        (minus.lambda - lambda).amax(),
        (minus.mu - mu).amax(),
        (plus.lambda - end.lambda).amax(),
        (plus.mu - end.mu).amax(),
        (plus.u - end.relative).amax(),
    ];
    let worst = defects.iter().fold(T::zero(), |m, d| m.max(*d));
    ((worst / T::unit_roundoff()).to_f64(), seconds)
}

#[test]
fn a_doubled_step_off_the_units_is_generated_by_the_extremal_action() {
    for name in ["gauss-1", "gauss-2", "gauss-3", "lobatto-iiia-2", "lobatto-iiib-3", "radau-iia-2", "rk4"] {
        let judged = [
            rigid_body::<f64>(name),
            rigid_body::<Dd>(name),
            body_in_a_fluid::<f64>(name),
            body_in_a_fluid::<Dd>(name),
        ];
        println!("{name}: {judged:?}");
        for (defect, _) in judged {
            assert!(defect < 1e4, "{name}: {defect:e} units of round-off");
        }
    }
}
