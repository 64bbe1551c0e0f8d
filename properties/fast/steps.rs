//! One step.

use super::{U, after, damping, distance, own, reach, relaxation, rigid, submerged, tableau, unforced};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::group::{Aff1, Heisenberg, LieGroup, MatrixGroup, Se2, Se3, Sl2, So3, So4};
use euler_poincare::integrators::lanes::{
    ByLane, Damping, Drag, Eight, FastRetraction, Free, Gravity, Isa, Kernel, LaneForce, LaneForceError, LaneGroup,
    Lanes, Pose, Registers, Relaxation, Term, Terms, VariationalInLanes,
};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::so3::{HalfAngle, QuaternionSo3, QuaternionState};
use euler_poincare::integrators::{OneStep, Solver, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{AtPoint, OfPotential, Potential};
use euler_poincare::mechanics::force::{
    AnyForce, Constant, CubicDrag, DoubleBracket, LinearDrag, Metriplectic, QuadraticDrag,
};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{Cayley, CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Real, Scalar};
use nalgebra::{Quaternion, UnitQuaternion};

const TABLEAUX: &str = "gauss-1 gauss-2 gauss-3 gauss-4 gauss-5 gauss-6 gauss-7 gauss-8 lobatto-iiia-2 lobatto-iiia-3 \
    lobatto-iiia-5 lobatto-iiib-2 lobatto-iiib-4 lobatto-iiib-5 lobatto-iiic-2 lobatto-iiic-4 radau-ia-2 \
    radau-ia-3 radau-iia-2 radau-iia-4 rk4 lobatto-iiia-4";

/// Ten steps, none of which needs Newton's method.
fn by_fixed_point_iterations<const N: usize, const D: usize>(
    method: &mut impl OneStep<f64, N, D>,
    start: &State<f64, N, D>,
    h: f64,
    name: &str,
) {
    let mut state = start.clone();
    for _ in 0..10 {
        assert_eq!(method.step(&mut state, h).unwrap().solver, Solver::FixedPoint, "{name}");
    }
}

#[test]
fn the_bodies_of_the_benchmarks_take_their_steps_by_fixed_point_iterations() {
    let (body, start) = rigid();
    let (vessel, afloat) = submerged();
    let drag = |d: f64| Matrix::<f64, 6>::from_diagonal_element(d);
    let force: AnyForce<f64, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(0.125)).unwrap().into(),
        QuadraticDrag::new(drag(0.25)).unwrap().into(),
    ]);
    let terms = Terms::new(&force, &vessel, CayleySe3::new().algebra()).unwrap();
    assert_eq!(terms.0[0], Term::LinearDrag(Drag::Diagonal([0.125; 6])));
    for name in TABLEAUX.split(' ') {
        for registers in Registers::all() {
            let damped = VariationalInLanes::new(body.clone(), damping(1.0), CayleySo3::new(), tableau(name));
            by_fixed_point_iterations(&mut damped.unwrap().in_registers(registers), &start, 0.125, name);
            let damped = VariationalInLanes::new(body.clone(), damping(1.0), ExponentialSo3::new(), tableau(name));
            by_fixed_point_iterations(&mut damped.unwrap().in_registers(registers), &start, 0.125, name);
            let dragged = VariationalInLanes::new(vessel.clone(), terms.clone(), CayleySe3::new(), tableau(name));
            by_fixed_point_iterations(&mut dragged.unwrap().in_registers(registers), &afloat, 0.1, name);
        }
    }
}

/// What a force adds to (1, 2, 3) in eight lanes, at times, momenta and velocities that differ.
struct Added<F>(F);

impl<F: LaneForce> Kernel for Added<F> {
    type Output = [[f64; 8]; 3];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [[f64; 8]; 3] {
        let lanes = |a: usize| Eight::load(isa, &std::array::from_fn(|k| (2 * a + 1) as f64 - 0.75 * k as f64));
        let [t, m, eta, sum] = [0, 1, 4, 0].map(|first| [first, first + 1, first + 2].map(lanes));
        let identity = [0, 1, 2].map(|r| [0, 1, 2].map(|c| Eight::splat(isa, if r == c { 1.0 } else { 0.0 })));
        let group = CayleySo3::new().in_lanes();
        let here = Pose { rows: identity, group: &group };
        let found = self.0.add_to(t[0], here, m, eta, sum);
        let mut values = [[0.0; 8]; 3];
        for (value, lanes) in values.iter_mut().zip(found) {
            lanes.store(value);
        }
        values
    }
}

/// A force with a type of its own is the term of that name, in all that the kernels ask of a force.
#[test]
fn forces_by_name_are_their_terms() {
    fn vanishes<F: LaneForce>(force: &F) -> (bool, bool) {
        (force.vanishes(), force.vanishes_when_steady())
    }
    assert_eq!(vanishes(&Damping(0.5)), vanishes(&damping(0.5)));
    assert_eq!(vanishes(&Relaxation(0.5)), vanishes(&relaxation(0.5)));
    assert_eq!((vanishes(&Free), vanishes(&unforced())), ((true, true), (true, true)));
    for registers in Registers::all() {
        let [damped, relaxed, free] = [damping(0.5), relaxation(0.5), unforced()].map(|f| registers.run(Added(f)));
        assert_eq!(registers.run(Added(Damping(0.5))), damped);
        assert_eq!(registers.run(Added(Relaxation(0.5))), relaxed);
        assert_eq!(registers.run(Added(Free)), free);
        assert!(damped != free && relaxed != free && damped != relaxed);
    }
}

/// A force as the general engine takes it is the same in each lane by itself, on both groups, with Newton's method behind it, and in the
/// solvers with a tolerance.
#[test]
fn forces_of_the_general_engine_are_taken_lane_by_lane() {
    let (body, start) = rigid();
    let algebra = LieGroup::algebra(&So3::<f64>::new()).clone();
    let force = DoubleBracket::new(algebra, body.clone(), 1.0).unwrap();
    let by_lane = || ByLane(force.clone());
    let agree = |name: &str, h: f64, steps: usize, bound: f64| {
        let mut listed = VariationalInLanes::new(body.clone(), damping(1.0), CayleySo3::new(), tableau(name)).unwrap();
        let mut method = VariationalInLanes::new(body.clone(), by_lane(), CayleySo3::new(), tableau(name)).unwrap();
        let (mut one, mut other) = (start.clone(), start.clone());
        for _ in 0..steps {
            let reports = (listed.step(&mut one, h).unwrap(), method.step(&mut other, h).unwrap());
            assert_eq!(reports.0.solver, reports.1.solver);
            assert!(distance(&one, &other) <= bound, "{name} {h}: {:e}", distance(&one, &other));
        }
    };
    for name in ["gauss-1", "gauss-2", "gauss-5", "gauss-8", "lobatto-iiia-3"] {
        [0.125, -0.25].iter().for_each(|h| agree(name, *h, 4, 32.0 * U));
    }
    // Beyond what the iterations in lanes reach.
    agree("gauss-1", 1.5, 1, 256.0 * U);

    for tolerance in [1e-5, 1e-8, 1e-12] {
        let (mut one, mut other) = (start.clone(), start.clone());
        reach(body.clone(), damping(1.0), CayleySo3::new(), &mut one, 3.0, tolerance).unwrap();
        reach(body.clone(), by_lane(), CayleySo3::new(), &mut other, 3.0, tolerance).unwrap();
        assert!(distance(&one, &other) <= tolerance, "{tolerance:e}: {:e}", distance(&one, &other));
    }
    let (vessel, afloat) = submerged();
    let listed = Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; 6]))]);
    let one = VariationalInLanes::new(vessel.clone(), listed.clone(), CayleySe3::new(), tableau("gauss-3")).unwrap();
    let other = VariationalInLanes::new(vessel.clone(), own(0.125, 0.0), CayleySe3::new(), tableau("gauss-3")).unwrap();
    let (one, other) = (after(one, &afloat, 0.125, 1), after(other, &afloat, 0.125, 1));
    assert!(distance(&one, &other) <= 32.0 * U, "{:e}", distance(&one, &other));
    let algebra = LieAlgebra::<f64, 6>::from_catalogue(&Entry::Se3).unwrap();
    let brackets: AnyForce<f64, 6> = AnyForce::Sum(vec![
        DoubleBracket::new(algebra.clone(), vessel.clone(), 0.25).unwrap().into(),
        Metriplectic::new(algebra.clone(), vessel.clone(), 0.125).unwrap().into(),
    ]);
    let terms = Terms::new(&brackets, &vessel, &algebra).unwrap();
    let one = VariationalInLanes::new(vessel.clone(), terms, CayleySe3::new(), tableau("gauss-3")).unwrap();
    let other = Variational::new(vessel.clone(), brackets, CayleySe3::new(), tableau("gauss-3"));
    let (one, other) = (after(one, &afloat, 0.125, 1), after(other, &afloat, 0.125, 1));
    assert!(distance(&one, &other) <= 64.0 * U, "{:e}", distance(&one, &other));
    let (mut one, mut other) = (afloat.clone(), afloat);
    reach(vessel.clone(), listed, CayleySe3::new(), &mut one, 1.0, 1e-10).unwrap();
    reach(vessel, own(0.125, 0.0), CayleySe3::new(), &mut other, 1.0, 1e-10).unwrap();
    assert!(distance(&one, &other) <= 1e-10, "{:e}", distance(&one, &other));
}

#[test]
fn a_fold_is_refused_by_the_fast_step_too() {
    let (lagrangian, start) = rigid();
    for (name, fold) in [("lobatto-iiia-2", 0.797), ("radau-ia-1", 0.49), ("lobatto-iiic-2", 0.76)] {
        let mut method =
            VariationalInLanes::new(lagrangian.clone(), damping(1.0), CayleySo3::new(), tableau(name)).unwrap();
        let mut state = start.clone();
        let error = method.step(&mut state, fold + 0.1).unwrap_err();
        let StepError::Fold { fold: found, .. } = error else { panic!("{name}: {error}") };
        assert!((found - fold).abs() < 0.01, "{name}: {found}");
        assert_eq!(state, start);
    }
}

/// What is not finite, and a step of no size.
fn refuses<const N: usize, const D: usize>(method: &mut impl OneStep<f64, N, D>, start: &State<f64, N, D>) {
    let [mut momentum, mut attitude] = [start.clone(), start.clone()];
    momentum.momentum[0] = f64::NAN;
    attitude.attitude[(1, D - 1)] = f64::NAN;
    for (start, h) in [(start, f64::NAN), (start, f64::INFINITY), (&momentum, 0.1), (&attitude, 0.1)] {
        let mut state = start.clone();
        assert!(matches!(method.step(&mut state, h), Err(StepError::NotFinite { .. })));
        assert!(h.is_finite() || &state == start, "the state stays");
    }
    let mut state = start.clone();
    method.step(&mut state, 0.0).unwrap();
    assert!(distance(&state, start) <= 4.0 * U);
}

#[test]
fn bad_input_is_refused() {
    let (body, start) = rigid();
    let mut method = VariationalInLanes::new(body.clone(), damping(1.0), CayleySo3::new(), tableau("gauss-3")).unwrap();
    refuses(&mut method, &start);
    let mut state = State { momentum: Covector::zeros(), ..start };
    method.step(&mut state, 0.1).unwrap();
    assert_eq!(state.momentum, Covector::<f64, 3>::zeros());
    let (vessel, afloat) = submerged();
    refuses(
        &mut VariationalInLanes::new(vessel.clone(), own(0.125, 0.0), CayleySe3::new(), tableau("gauss-3")).unwrap(),
        &afloat,
    );
    let nine = VariationalInLanes::new(body, damping(1.0), CayleySo3::new(), tableau("gauss-9"));
    assert_eq!(nine.unwrap_err().stages, 9);
    let nine = VariationalInLanes::new(vessel, Terms::<6, f64>(Vec::new()), CayleySe3::new(), tableau("gauss-9"));
    assert_eq!(nine.unwrap_err().stages, 9);
}

/// A weight of a body about a fixed point, as a potential of one's own.
#[derive(Clone)]
struct Weight([i64; 3]);

impl<T: Real> Potential<T, 3> for Weight {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        (0..3).fold(S::zero(), |sum, c| sum + g[(2, c)] * S::ratio(self.0[c], 4))
    }
}

/// A force that depends on the attitude, and a potential, lane by lane: as the general engine has them, and as their form in lanes.
#[test]
fn forces_of_the_attitude_are_taken_lane_by_lane() {
    let (body, start) = rigid();
    let pull = Constant::new(Covector::<f64, 3>::new(0.0, 0.0, -1.0)).unwrap();
    let pull = AtPoint::in_space(pull, Vector::<f64, 3>::new(0.5, 0.0, 0.0), &So3::new());
    let fast =
        VariationalInLanes::new(body.clone(), ByLane(pull.clone()), CayleySo3::new(), tableau("gauss-3")).unwrap();
    let general = Variational::new(body.clone(), pull, CayleySo3::new(), tableau("gauss-3"));
    assert!(distance(&after(fast, &start, 0.125, 4), &after(general, &start, 0.125, 4)) <= 64.0 * U);
    let potential = OfPotential::new(Weight([1, 0, 2]), So3::new());
    let [mut own, mut listed] = [start.clone(), start.clone()];
    reach(body.clone(), ByLane(potential), CayleySo3::new(), &mut own, 2.0, 1e-10).unwrap();
    reach(body, Gravity([0.25, 0.0, 0.5]), CayleySo3::new(), &mut listed, 2.0, 1e-10).unwrap();
    assert!(distance(&own, &listed) <= 1e-13);
}

#[test]
fn forces_without_a_form_in_lanes_are_refused() {
    let (body, _) = rigid();
    let other = Quadratic::diagonal([1.0, 2.0, 3.0]).unwrap();
    let algebra = LieGroup::algebra(&So3::<f64>::new()).clone();
    let force: AnyForce<f64, 3> = DoubleBracket::new(algebra.clone(), other, 1.0).unwrap().into();
    assert!(matches!(Terms::new(&force, &body, &algebra), Err(LaneForceError::OtherLagrangian { .. })));
    let basis = Matrix::<f64, 3>::new(1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0);
    let force = Metriplectic::new(algebra.in_basis(&basis).unwrap(), body.clone(), 1.0).unwrap().into();
    assert!(matches!(Terms::new(&force, &body, &algebra), Err(LaneForceError::OtherAlgebra { .. })));
    let (vessel, _) = submerged();
    let force = AnyForce::from(CubicDrag::new(0.25).unwrap());
    assert_eq!(
        Terms::new(&force, &vessel, CayleySe3::new().algebra()).unwrap_err(),
        LaneForceError::NoForm { force: "cubic drag" }
    );
}

/// The quaternion form takes the steps of the matrix form: the same momenta, and the same rotation to round-off, by
/// fixed-point iterations and by Newton's method, when it starts again from a state of one's own, and backwards.
#[test]
fn quaternions_turn_as_matrices_do() {
    fn agree<R: HalfAngle>(retraction: R, name: &str, h: f64, wanted: Solver) {
        let (lagrangian, start) = rigid();
        let damped =
            || VariationalInLanes::new(lagrangian.clone(), damping(0.01), retraction.clone(), tableau(name)).unwrap();
        let (mut by_matrix, mut by_quaternion) = (damped(), QuaternionSo3::of(damped()));
        let axis = nalgebra::Vector3::new(0.3, -2.0, 0.7);
        let attitude = UnitQuaternion::from_scaled_axis(axis);
        let mut state = QuaternionState { time: start.time, momentum: start.momentum, attitude };
        let mut matrix = State { attitude: attitude.to_rotation_matrix().into_inner(), ..start };
        for k in 1..=400_u32 {
            // From the hundredth step on backwards; from the two hundredth on from a copy with the other sign.
            let h = if k > 100 { -h } else { h };
            if k == 200 {
                state.attitude = UnitQuaternion::new_unchecked(-state.attitude.into_inner());
            }
            let report = by_quaternion.step(&mut state, h).unwrap();
            assert_eq!(by_matrix.step(&mut matrix, h).unwrap(), report);
            assert_eq!(report.solver, wanted, "{name}");
            assert_eq!((state.time, state.momentum), (matrix.time, matrix.momentum), "{name}, step {k}");
            let off = (state.attitude.to_rotation_matrix().into_inner() - matrix.attitude).amax();
            assert!(off < 8.0 * U * f64::from(k).sqrt() + 8.0 * U, "{name}, step {k}: {off:e}");
            // 2 u for the rounding of the components, 4 u for that of |q|² where it is brought back to 1, 4 u for that here.
            let off = (state.attitude.as_ref().norm_squared() - 1.0).abs();
            assert!(off <= 10.0 * U, "{name}, step {k}: {off:e}");
        }
    }
    for name in ["gauss-1", "gauss-2", "gauss-5", "lobatto-iiia-3"] {
        agree(CayleySo3::new(), name, 0.125, Solver::FixedPoint);
        agree(ExponentialSo3::new(), name, 0.125, Solver::FixedPoint);
    }
}

/// A quaternion that is none is refused, and a step that fails leaves the state.
#[test]
fn a_quaternion_is_of_unit_length() {
    let (lagrangian, start) = rigid();
    let method =
        VariationalInLanes::new(lagrangian, damping(1.0), CayleySo3::new(), tableau("lobatto-iiia-2")).unwrap();
    let mut method = QuaternionSo3::of(method);
    let mut with = |w: f64, x: f64| {
        let attitude = UnitQuaternion::new_unchecked(Quaternion::new(w, x, 0.0, 0.0));
        method.step(&mut QuaternionState { time: 0.0, momentum: start.momentum, attitude }, 0.1).map(|_| ())
    };
    assert_eq!(with(0.0, 0.0), Err(StepError::OffGroup { departure: 1.0 }));
    assert_eq!(with(1.0, 0.5), Err(StepError::OffGroup { departure: 0.25 }));
    assert_eq!(with(f64::NAN, 0.0), Err(StepError::NotFinite { what: "the attitude" }));
    assert_eq!(with(0.6, 0.8), Ok(()));
    let fresh = QuaternionState { time: 0.0, momentum: start.momentum, attitude: UnitQuaternion::identity() };
    let mut state = fresh.clone();
    assert!(matches!(method.step(&mut state, 0.9), Err(StepError::Fold { .. })));
    assert_eq!(state, fresh);
    // Newton's method, just before the fold; and a step forth and back by fixed-point iterations.
    let report = method.step(&mut state, 0.79).unwrap();
    assert_ne!(report.solver, Solver::FixedPoint);
    let matrix = VariationalInLanes::new(rigid().0, damping(1.0), CayleySo3::new(), tableau("lobatto-iiia-2")).unwrap();
    let matrix = after(matrix, &start, 0.79, 1);
    assert!((state.attitude.to_rotation_matrix().into_inner() - matrix.attitude).amax() < 16.0 * U);
}

/// A retraction's displacement against many short steps along its tangent map, for rates η₀ + η₁ t + η₂ t².
struct Displacements<'a, R, const N: usize, const D: usize>(&'a R, [[f64; N]; 3]);

impl<R: LaneGroup<N, D>, const N: usize, const D: usize> Kernel for Displacements<'_, R, N, D> {
    /// The largest difference in each lane, lane k for the time 0.8/(k + 1).
    type Output = [f64; 8];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [f64; 8] {
        const STEPS: usize = 200;
        let time = Eight::load(isa, &std::array::from_fn(|k| 0.8 / (k + 1) as f64));
        let rate = |t: Eight<I>| -> [Eight<I>; N] {
            std::array::from_fn(|a| {
                let [constant, slope, bend] = [0, 1, 2].map(|power| t.constant(self.1[power][a]));
                bend.mul_add(t, slope).mul_add(t, constant)
            })
        };
        let zero = time.constant(0.0);
        let found = self.0.displacement(time, rate(zero), rate(time * time.constant(0.5)), rate(time));
        let step = time * time.constant(1.0 / STEPS as f64);
        let per_unit = time.constant(1.0 / R::UNIT);
        let along = |x: [Eight<I>; N], t| self.0.rate(&self.0.at(x, false), x, rate(t)).map(|rate| per_unit * rate);
        let add = |x: [Eight<I>; N], h: Eight<I>, y: [Eight<I>; N]| std::array::from_fn(|a| h.mul_add(y[a], x[a]));
        let mut x = [zero; N];
        for k in 0..STEPS {
            let now = step * time.constant(k as f64);
            let (half, middle) = (step * time.constant(0.5), now + step * time.constant(0.5));
            let first = along(x, now);
            let second = along(add(x, half, first), middle);
            let third = along(add(x, half, second), middle);
            let fourth = along(add(x, step, third), now + step);
            let sixth = step * time.constant(1.0 / 6.0);
            let two = time.constant(2.0);
            x = add(x, sixth, std::array::from_fn(|a| first[a] + two * (second[a] + third[a]) + fourth[a]));
        }
        let mut worst = zero;
        for a in 0..N {
            worst = worst.max((found[a] - x[a]).abs());
        }
        let mut lanes = [0.0; 8];
        worst.store(&mut lanes);
        lanes
    }
}

fn of_order_four<R: FastRetraction<N, D>, const N: usize, const D: usize>(retraction: R, rates: [[f64; N]; 3]) {
    let group = retraction.in_lanes();
    for registers in Registers::all() {
        let errors = registers.run(Displacements::<R::Lanes, N, D>(&group, rates));
        assert!(errors[0] < 1e-2 && errors[0] > 1e-6, "{errors:?}");
        for halved in [3, 7] {
            // Of t⁵: 32 times less for half the time.
            let ratio = errors[halved / 2] / errors[halved];
            assert!((24.0..48.0).contains(&ratio), "{ratio}: {errors:?}");
        }
    }
}

#[test]
fn displacements_are_of_order_four() {
    let so3 = [[0.7, -0.2, 0.9], [0.5, 1.1, -0.4], [-0.3, 0.6, 0.8]];
    of_order_four(CayleySo3::new(), so3);
    of_order_four(ExponentialSo3::new(), so3);
    of_order_four(Cayley::new(MatrixGroup::<f64, 3, 2>::from_entry(&Entry::Sl2).unwrap()).unwrap(), so3);
    let se3 = [[0.7, -0.2, 0.9, 1.0, 0.3, -0.6], [0.5, 1.1, -0.4, -0.7, 0.2, 0.9], [-0.3, 0.6, 0.8, 0.4, -0.5, 0.1]];
    of_order_four(CayleySe3::new(), se3);
    of_order_four(Cayley::new(MatrixGroup::<f64, 6, 4>::from_entry(&Entry::So4).unwrap()).unwrap(), se3);
}

/// The matrices that the compiler knows are those of the catalogue.
fn is_of_the_catalogue<G: LieGroup<f64, N, D>, const N: usize, const D: usize>(_: &G, entry: &Entry) {
    let given = MatrixGroup::<f64, N, D>::from_entry(entry).unwrap();
    let basis = G::BASIS.unwrap();
    for a in 0..N {
        assert_eq!(given.basis()[a], Matrix::<f64, D>::from_fn(|r, c| f64::from(basis[a][r][c])));
    }
}

/// Of such a group a step is that of the general engine.
fn is_that_of_the_general_engine<G, const N: usize, const D: usize>(group: G)
where
    G: LieGroup<f64, N, D> + Clone + 'static,
{
    let body = Quadratic::diagonal(std::array::from_fn(|a| 0.75 + 0.5 * a as f64)).unwrap();
    let retraction = Cayley::new(group).unwrap();
    let momentum = Covector::<f64, N>::from_fn(|_, a| [0.5, -0.75, 0.25, 0.625, -0.375, 0.875][a]);
    let attitude = retraction.tau(&Vector::<f64, N>::from_element(0.25)).unwrap();
    let start = State { time: 0.0, momentum, attitude };
    let drag = LinearDrag::new(Matrix::from_diagonal_element(0.125)).unwrap();
    let terms = Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; N]))]);
    for name in ["gauss-1", "gauss-3", "gauss-8", "lobatto-iiia-3"] {
        let general = Variational::new(body.clone(), drag.clone(), retraction.clone(), tableau(name));
        let expected = after(general, &start, 0.25, 4);
        for registers in Registers::all() {
            let method = VariationalInLanes::new(body.clone(), terms.clone(), retraction.clone(), tableau(name));
            let off = distance(&after(method.unwrap().in_registers(registers), &start, 0.25, 4), &expected);
            assert!(off <= 64.0 * U, "{name}, {registers:?}: {off:e}");
        }
    }
}

#[test]
fn groups_whose_matrices_are_known_take_the_same_steps() {
    is_of_the_catalogue(&So3::new(), &Entry::So3);
    is_of_the_catalogue(&Se2::new(), &Entry::Se2);
    is_of_the_catalogue(&Sl2::new(), &Entry::Sl2);
    is_of_the_catalogue(&Aff1::new(), &Entry::Aff1);
    is_of_the_catalogue(&Heisenberg::new(), &Entry::Heisenberg);
    is_of_the_catalogue(&Se3::new(), &Entry::Se3);
    is_of_the_catalogue(&So4::new(), &Entry::So4);
    is_that_of_the_general_engine(Se2::new());
    is_that_of_the_general_engine(Sl2::new());
    is_that_of_the_general_engine(Heisenberg::new());
    is_that_of_the_general_engine(Se3::new());
    is_that_of_the_general_engine(So4::new());
    // Known when it runs.
    is_that_of_the_general_engine(MatrixGroup::<f64, 3, 2>::from_entry(&Entry::Sl2).unwrap());
    is_that_of_the_general_engine(MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).unwrap());
}
