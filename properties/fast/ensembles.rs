//! Many bodies at once.

use super::{after, damping, distance, rigid, tableau, unforced};
use euler_poincare::algebra::Covector;
use euler_poincare::integrators::lanes::{Drag, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::so3::{EnsembleSo3, HalfAngle, Member};
use euler_poincare::integrators::{OneStep, Solver, State, StepError};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{CayleySo3, ExponentialSo3};

/// Free bodies, no two of them alike.
fn free(k: usize) -> Member<Terms> {
    let x = |n: usize| ((k * 7 + n * 13 + k * k * n) % 101) as f64 / 101.0;
    let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(1.0, x(1), x(2), x(3)));
    Member {
        lagrangian: Quadratic::diagonal([0.5 + x(1), 0.75 + x(2), 1.0]).unwrap(),
        force: unforced(),
        state: State {
            time: x(6),
            momentum: Covector::<f64, 3>::new(x(7) - 0.5, 0.25 + x(8), x(9) - 0.5),
            attitude: turn.to_rotation_matrix().into_inner(),
        },
    }
}

#[test]
fn an_ensemble_knows_its_bodies() {
    for size in [0, 1, 8, 21] {
        let members: Vec<_> = (0..size).map(free).collect();
        let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
        assert_eq!((ensemble.len(), ensemble.is_empty(), ensemble.states().count()), (size, size == 0, size));
        for (k, member) in members.iter().enumerate() {
            assert_eq!(ensemble.state(k), Some(member.state.clone()));
        }
        ensemble.advance(0.25, 0).unwrap();
        assert!(ensemble.states().eq(members.iter().map(|member| member.state.clone())));
        assert_eq!(ensemble.state(size), None);
    }
    let nine = EnsembleSo3::new(&[free(0)], CayleySo3::new(), tableau("gauss-9"));
    assert_eq!(nine.unwrap_err().stages, 9);
}

#[test]
fn an_ensemble_takes_steps_that_fixed_point_iterations_do_not_solve_and_names_the_body_that_fails() {
    let (lagrangian, start) = rigid();
    let member = |scale: f64| Member {
        lagrangian: lagrangian.clone(),
        force: damping(scale),
        state: State { momentum: start.momentum * scale, ..start.clone() },
    };
    // The branch of Lobatto IIIA-2 folds at h = 0.797 for the body 9, at larger steps for the others.
    let members: Vec<_> = (0..12).map(|k| member(if k == 9 { 1.0 } else { 0.25 })).collect();
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("lobatto-iiia-2")).unwrap();
    let error = ensemble.advance(0.9, 3).unwrap_err();
    assert_eq!((error.member, error.step), (9, 0), "{error}");
    assert!(matches!(error.source, StepError::Fold { .. }), "{error}");
    // Newton's method steps in, in a group that is not full: large steps of Gauss-1.
    let mut solvers = Vec::new();
    for (fastest, h) in [(1.0, 1.5), (0.5, 3.0)] {
        let members: Vec<_> = (0..12).map(|k| member(if k == 9 { fastest } else { 0.25 })).collect();
        let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-1")).unwrap();
        ensemble.advance(h, 2).unwrap();
        for (member, found) in members.iter().zip(ensemble.states()) {
            let (body, force) = (member.lagrangian.clone(), member.force.clone());
            let mut method = VariationalInLanes::new(body, force, CayleySo3::new(), tableau("gauss-1")).unwrap();
            let mut state = member.state.clone();
            solvers.extend([(); 2].map(|()| method.step(&mut state, h).unwrap().solver));
            assert!(distance(&state, &found) < 1e-13);
        }
    }
    let alone = solvers.iter().filter(|solver| **solver == Solver::FixedPoint).count();
    assert!(alone > 0 && alone < solvers.len(), "{solvers:?}");
}

/// In a steady rotation every step rounds alike: gᵀg would drift by 5e-19 a step if g were summed up.
#[test]
fn a_steady_rotation_stays_a_rotation() {
    let momenta = |k: usize| Covector::<f64, 3>::new(0.0, 0.0, 0.5 + 0.1 * k as f64);
    let member = |k: usize| Member { state: State { momentum: momenta(k), ..free(k).state }, ..free(k) };
    let members: Vec<_> = (0..8).map(member).collect();
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
    ensemble.advance(0.1, 100_000).unwrap();
    for (member, state) in members.iter().zip(ensemble.states()) {
        assert_eq!(state.momentum, member.state.momentum);
        let departure = (state.attitude.transpose() * state.attitude - nalgebra::Matrix3::identity()).amax();
        assert!(departure < 4e-15, "{departure:e}");
    }
}

/// The rounding errors of free bodies over many steps: |μ|² and g μ are kept by the method, so all change is rounding. With
/// compensated sums it grows like √n.
#[test]
fn rounding_grows_like_the_square_root_of_the_steps() {
    let members: Vec<_> = (0..32).map(free).collect();
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
    let spatial = |state: &State<f64, 3, 3>| state.attitude * state.momentum.transpose();
    // After 1000, 4000, 16000 and 64000 steps.
    let rms = [1000, 3000, 12000, 48000].map(|more| {
        ensemble.advance(0.1, more).unwrap();
        let squares = members.iter().zip(ensemble.states()).map(|(member, state)| {
            ((spatial(&state) - spatial(&member.state)) / member.state.momentum.norm()).norm_squared()
        });
        (squares.sum::<f64>() / 32.0).sqrt()
    });
    let exponent = (rms[3] / rms[0]).ln() / 64f64.ln();
    assert!(exponent < 0.75, "{exponent} {rms:?}");
    assert!(rms[3] < 1e-13, "{rms:?}");
}

/// The largest distance of an ensemble from bodies that are moved on alone.
fn apart<R: HalfAngle + Sync>(members: &[Member<Terms>], retraction: R, name: &str, h: f64, steps: usize) -> f64 {
    let mut ensemble = EnsembleSo3::new(members, retraction.clone(), tableau(name)).unwrap();
    ensemble.advance(h, steps).unwrap();
    let alone = members.iter().map(|member| {
        let (body, force) = (member.lagrangian.clone(), member.force.clone());
        after(VariationalInLanes::new(body, force, retraction.clone(), tableau(name)).unwrap(), &member.state, h, steps)
    });
    alone.zip(ensemble.states()).map(|(x, y)| distance(&x, &y)).fold(0.0, f64::max)
}

/// Over many steps, with forces that change from one to the next: what an ensemble extrapolates, and what it takes for granted
/// of its fixed-point iterations, are no part of where it ends.
#[test]
fn an_ensemble_goes_with_the_bodies_over_many_steps() {
    let members: Vec<_> = (0..12)
        .map(|k| {
            let Member { lagrangian, state, .. } = free(k);
            let u = k as f64 / 12.0;
            let drag = Drag::Full([[0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1 + u]]);
            let force = Terms(vec![Term::Periodic([5.0 * u, 0.5, -3.0], 1.0 + 5.0 * u, u), Term::QuadraticDrag(drag)]);
            Member { lagrangian, force, state }
        })
        .collect();
    for name in ["gauss-1", "gauss-2", "gauss-3", "lobatto-iiic-4"] {
        for (h, steps) in [(0.01, 1000), (0.125, 100)] {
            let cayley = apart(&members, CayleySo3::new(), name, h, steps);
            let exponential = apart(&members, ExponentialSo3::new(), name, h, steps);
            assert!(cayley < 2e-13 && exponential < 2e-13, "{name}, h = {h}: {cayley:e}, {exponential:e}");
        }
    }
}

/// Quaternions may have any length: each of these steps multiplies |q|² by 1.3 or more, which would be infinite after 2700.
/// (The distance is that of the bodies alone: there g is a sum, and in a steady rotation every step rounds alike.)
#[test]
fn an_ensemble_turns_far_in_many_steps() {
    let members: Vec<_> = (0..9)
        .map(|k| Member {
            force: unforced(),
            lagrangian: Quadratic::diagonal([1.0, 1.0, 1.0]).unwrap(),
            state: State { momentum: Covector::<f64, 3>::new(0.0, 0.1 * k as f64, 1.0), ..free(k).state },
        })
        .collect();
    let found = apart(&members, CayleySo3::new(), "gauss-2", 1.0, 4000);
    assert!(found < 2e-11, "{found:e}");
}
