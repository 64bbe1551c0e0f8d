//! Properties of `euler_poincare::integrators::derivative`: tangents against differences in 32 digits, adjoints against tangents, the
//! symplectic form, runs, and two problems that need derivatives: a fit, and a turn with the least torque.
//!
//! Fourteen mistakes were planted, each of which some test found:
//!
//! | mistake | fails |
//! |---|---|
//! | dτ_{−ξ} in place of dτ_ξ; Ad_{τ(ξ)} in place of its inverse; no ad*_ω μ'; a variation of g on the right | `tangents_…`, `a_step_without_force_is_symplectic` |
//! | no ∂r/∂t; no dτ_{−ξ} in ∂r/∂p; no ddτ in ∂r/∂p | `tangents_…` |
//! | J⁻¹ in place of J⁻ᵀ; its rows exchanged in the order of J⁻¹; no ad*_v μ' in the adjoint alone | `adjoints_…` |
//! | ∂/∂h of a run without the times of its steps (forward, reverse); a checkpoint, the stages of another step | `gradients_of_runs_…` |

use crate::mechanics::Sequence;
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector, elimination};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::derivative::{
    Derivative, Gradient, InputGradient, Linearised, Parameters, StepDerivative, Variation,
};
use euler_poincare::integrators::trajectory::integrate;
use euler_poincare::integrators::{OneStep, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{Configuration, ForceOnGroup, OnGroup, Potential, WithPotential};
use euler_poincare::mechanics::force::{LinearDrag, Zero};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::{Force, Lagrangian, LegendreError};
use euler_poincare::retraction::{AnyRetraction, Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Classic, Family, Tableau};
use nalgebra::{DMatrix, DVector};

/// f_a = −(p₀ + p₁ |η|²) η_a + p₂ cos t (g_xy + g_0x η_b).
#[derive(Clone, Copy)]
struct Loads<T>([T; 3]);

impl<T: Real, const N: usize, const D: usize> ForceOnGroup<T, N, D> for Loads<T> {
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> Covector<S, N> {
        let [p0, p1, p2] = self.0.map(S::lift);
        let square = (0..N).fold(S::zero(), |sum, a| sum + eta[a] * eta[a]);
        Covector::from_fn(|_, a| {
            let at = g[(a % D, (a + 1) % D)] + g[(0, a % D)] * eta[(a + 1) % N];
            p2 * t.cos() * at - (p0 + p1 * square) * eta[a]
        })
    }
}

/// V = p₃ Σ w_rc g_rc.
#[derive(Clone, Copy)]
struct Weight<T>(T);

impl<T: Real, const D: usize> Potential<T, D> for Weight<T> {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, D>) -> S {
        let mut sum = S::zero();
        for r in 0..D {
            for c in 0..D {
                sum += g[(r, c)] * S::ratio((r as i64 + 2 * c as i64 + 1) % 5 - 2, 4);
            }
        }
        sum * S::lift(self.0)
    }
}

/// The parameters p₀ … p₃, and p₄, which is added to the first moment of inertia.
struct All<T: Real, const N: usize, const D: usize>(MatrixGroup<T, N, D>);

impl<T: Real, const N: usize, const D: usize> Parameters<T, N> for All<T, N, D> {
    fn count(&self) -> usize {
        5
    }

    fn force(&self, k: usize, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Covector<T, N> {
        let unit = std::array::from_fn(|l| if l == k { T::one() } else { T::zero() });
        match k {
            0..3 => Loads(unit).force(t, &g.matrix::<D>(), eta),
            3 => -Weight(T::one()).gradient(&self.0, t, &g.matrix::<D>()),
            _ => Covector::zeros(),
        }
    }

    fn momentum(&self, k: usize, _: T, _: Configuration<'_, T>, eta: &Vector<T, N>) -> Covector<T, N> {
        Covector::from_fn(|_, a| if k == 4 && a == 0 { eta[0] } else { T::zero() })
    }
}

fn inertia<T: Real, const N: usize>(extra: T) -> Quadratic<T, N> {
    Quadratic::new(Matrix::from_fn(|a, b| match a.abs_diff(b) {
        0 => T::one() + T::ratio(a as i64, 4) + if a == 0 { extra } else { T::zero() },
        away => T::ratio(1, 8 + 8 * away as i64),
    }))
    .unwrap()
}

fn group<T: Real, const N: usize, const D: usize>(entry: &Entry) -> MatrixGroup<T, N, D> {
    MatrixGroup::from_entry(entry).unwrap()
}

fn retraction<T: Real, const N: usize, const D: usize>(entry: &Entry, cayley: bool) -> AnyRetraction<T, N, D> {
    match cayley {
        true => AnyRetraction::Cayley(Cayley::new(group(entry)).unwrap()),
        false => AnyRetraction::Exponential(Exponential::of_group(group(entry))),
    }
}

type General<T, const N: usize, const D: usize> = Variational<
    T,
    N,
    D,
    WithPotential<Quadratic<T, N>, Weight<T>, MatrixGroup<T, N, D>, D>,
    OnGroup<Loads<T>, D>,
    AnyRetraction<T, N, D>,
>;

fn general<T: Real, const N: usize, const D: usize>(
    entry: &Entry,
    cayley: bool,
    tableau: Tableau<T>,
    p: &[T],
) -> General<T, N, D> {
    let lagrangian = WithPotential::new(inertia(p[4]), Weight(p[3]), group(entry));
    Variational::new(lagrangian, OnGroup(Loads([p[0], p[1], p[2]])), retraction(entry, cayley), tableau)
}

fn parameters<T: Real>() -> [T; 5] {
    [T::ratio(1, 8), T::ratio(1, 16), T::ratio(1, 4), T::half(), T::ratio(1, 8)]
}

fn start<T: Real, const N: usize, const D: usize>(retraction: &impl Retraction<T, N, D>) -> State<T, N, D> {
    let x = Vector::<T, N>::from_fn(|a, _| T::ratio(3 - 2 * a as i64, 8));
    let momentum = Covector::<T, N>::from_fn(|_, a| T::ratio(5 - 3 * (a as i64 % 3), 8));
    State { time: T::ratio(1, 4), momentum, attitude: retraction.tau(&x).unwrap() }
}

fn tableaux<T: Real>() -> Vec<(&'static str, Tableau<T>)> {
    let family = |family: Family, s| family.tableau(s).unwrap();
    vec![
        ("Gauss-1", family(Family::Gauss, 1)),
        ("Gauss-2", family(Family::Gauss, 2)),
        ("Gauss-3", family(Family::Gauss, 3)),
        ("IIIA-3", family(Family::LobattoIIIA, 3)),
        ("IIIB-3", family(Family::LobattoIIIB, 3)),
        ("Radau IIA-2", family(Family::RadauIIA, 2)),
        ("RK4", Classic::Rk4.tableau().unwrap()),
    ]
}

/// The columns of a derivative, as numbers of 16 digits.
fn columns<T: Real, const N: usize>(derivative: &Derivative<T, N>) -> DMatrix<f64> {
    let Derivative { by_attitude, by_momentum, by_time, by_step, by_parameters } = derivative;
    let all: Vec<&Variation<T, N>> =
        by_attitude.iter().chain(by_momentum).chain([by_time, by_step]).chain(by_parameters).collect();
    DMatrix::from_fn(2 * N, all.len(), |r, c| {
        if r < N { all[c].attitude[r].to_f64() } else { all[c].momentum[r - N].to_f64() }
    })
}

/// The same by central differences in 32 digits, of a run with the method that `make` makes of the parameters.
#[allow(clippy::type_complexity, reason = "the types of a method are its parts")]
fn differences<const N: usize, const D: usize, L, F, R>(
    make: &dyn Fn(&[Dd]) -> Variational<Dd, N, D, L, F, R>,
    p: &[Dd],
    (start, h, steps): (&State<Dd, N, D>, Dd, usize),
) -> DMatrix<f64>
where
    L: Lagrangian<Dd, N>,
    F: Force<Dd, N>,
    R: Retraction<Dd, N, D>,
{
    let end = |p: &[Dd], start: &State<Dd, N, D>, h: Dd| {
        let mut state = start.clone();
        integrate(&mut make(p), &mut state, h, steps, |_, _, _| {}).unwrap();
        state
    };
    let back = elimination::inverse(&end(p, start, h).attitude).unwrap();
    let (method, by) = (make(p), Dd::exact(2f64.powi(-30)));
    let mut found = DMatrix::zeros(2 * N, 2 * N + 2 + p.len());
    for c in 0..found.ncols() {
        let [ahead, behind] = [by, -by].map(|by| {
            let (mut p, mut state, mut h) = (p.to_vec(), start.clone(), h);
            match c {
                c if c < N => {
                    let x = Vector::<Dd, N>::from_fn(|a, _| if a == c { by } else { Dd::exact(0.0) });
                    state.attitude *= method.retraction().tau(&x).unwrap();
                }
                c if c < 2 * N => state.momentum[c - N] += by,
                c if c == 2 * N => state.time += by,
                c if c == 2 * N + 1 => h += by,
                c => p[c - 2 * N - 2] += by,
            }
            let state = end(&p, &state, h);
            (method.retraction().tau_inv(&(back * state.attitude)).unwrap(), state.momentum)
        });
        for a in 0..N {
            let scale = Dd::half() / by;
            found[(a, c)] = ((ahead.0[a] - behind.0[a]) * scale).to_f64();
            found[(N + a, c)] = ((ahead.1[a] - behind.1[a]) * scale).to_f64();
        }
    }
    found
}

/// The same numbers of a gradient.
fn numbers<const N: usize>(gradient: InputGradient<f64, N>) -> DVector<f64> {
    let InputGradient { state, time, step, parameters } = gradient;
    let state = state.attitude.iter().chain(state.momentum.iter()).copied();
    DVector::from_vec(state.chain([time, step]).chain(parameters).collect())
}

fn near(found: &DMatrix<f64>, wanted: &DMatrix<f64>, within: f64, what: &str) {
    let defect = (found - wanted).amax() / wanted.amax();
    assert!(defect <= within, "{what}: {defect:e} of {:e}\n{found:.3}{wanted:.3}", wanted.amax());
}

/// Tangents in 16 and in 32 digits against differences, with forces and without; of one tableau of several, from the first used.
fn tangents<const N: usize, const D: usize>(entry: &Entry, cayley: bool, used: [usize; 2]) {
    let digits = |p: &[f64]| p.iter().map(|&p| Dd::exact(p)).collect::<Vec<_>>();
    let [first, every] = used;
    for ((name, tableau), (_, long)) in tableaux::<f64>().into_iter().zip(tableaux::<Dd>()).skip(first).step_by(every) {
        let what = format!("{entry:?}, Cayley {cayley}, {name}");
        let tau = retraction::<f64, N, D>(entry, cayley);
        let from = start::<Dd, N, D>(&retraction(entry, cayley));
        // At p = 0 there is no force, but a derivative by p.
        for p in [parameters::<f64>(), [0.0; 5]] {
            let make = |p: &[Dd]| general::<Dd, N, D>(entry, cayley, long.clone(), p);
            let wanted = differences(&make, &digits(&p), (&from, Dd::exact(0.125), 1));
            let method = general(entry, cayley, tableau.clone(), &p);
            let mut method = Linearised::new(method, All::<f64, N, D>(group(entry)));
            let (_, step) = method.step(&mut start(&tau), 0.125).unwrap();
            near(&columns(&step.matrices().unwrap()), &wanted, 1e-13, &what);
            if p[0] > 0.0 {
                let mut method = Linearised::new(make(&digits(&p)), All::<Dd, N, D>(group(entry)));
                let (_, step) = method.step(&mut from.clone(), Dd::exact(0.125)).unwrap();
                near(&columns(&step.matrices().unwrap()), &wanted, 1e-15, &what);
            }
        }
        let free = |_: &[Dd]| Variational::new(inertia(Dd::exact(0.0)), Zero, retraction(entry, cayley), long.clone());
        let wanted = differences::<N, D, _, _, _>(&free, &[], (&from, Dd::exact(-0.25), 1));
        let free = Variational::new(inertia(0.0), Zero, tau.clone(), tableau);
        let mut method = Linearised::new(free, ());
        let (_, step) = method.step(&mut start(&tau), -0.25).unwrap();
        near(&columns(&step.matrices().unwrap()), &wanted, 1e-13, &what);
    }
}

#[test]
fn tangents_are_differences_in_32_digits_on_so3() {
    tangents::<3, 3>(&Entry::So3, false, [0, 1]);
    tangents::<3, 3>(&Entry::So3, true, [0, 1]);
}

#[test]
fn tangents_are_differences_in_32_digits_on_se2() {
    tangents::<3, 3>(&Entry::Se2, false, [0, 1]);
    tangents::<3, 3>(&Entry::Se2, true, [0, 1]);
}

#[test]
fn tangents_are_differences_in_32_digits_on_sl2() {
    tangents::<3, 2>(&Entry::Sl2, false, [0, 1]);
    tangents::<3, 2>(&Entry::Sl2, true, [0, 1]);
}

#[test]
fn tangents_are_differences_in_32_digits_on_se3() {
    tangents::<6, 4>(&Entry::Se3, false, [0, 2]);
    tangents::<6, 4>(&Entry::Se3, true, [1, 2]);
}

/// A force f(η) on an algebra without a group: ζ is defined all the same.
#[test]
fn tangents_need_no_group() {
    let algebra = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3).unwrap();
    let drag = LinearDrag::new(Matrix::<f64, 3>::new(0.3, 0.1, 0.0, -0.2, 0.4, 0.1, 0.0, 0.3, 0.2)).unwrap();
    let gauss: Tableau<f64> = Family::Gauss.tableau(2).unwrap();
    let without =
        Variational::new(inertia(0.0), drag.clone(), Exponential::<f64, 3, 3>::of_algebra(algebra), gauss.clone());
    let with = Variational::new(inertia(0.0), drag, ExponentialSo3::new(), gauss);
    let from = start::<f64, 3, 3>(&ExponentialSo3::new());
    let [mut one, mut other] = [from.clone(), from];
    let one = Linearised::new(without, ()).step(&mut one, 0.25).unwrap().1.matrices().unwrap();
    let other = Linearised::new(with, ()).step(&mut other, 0.25).unwrap().1.matrices().unwrap();
    near(&columns(&one), &columns(&other), 1e-14, "so(3)");
}

/// The adjoints of the 2N coordinates of the end, as rows, are the tangents of all inputs, as columns.
fn transposed<const N: usize>(step: &mut StepDerivative<f64, N>, what: &str) {
    let forward = columns(&step.matrices().unwrap());
    let rows: Vec<DVector<f64>> = (0..2 * N)
        .map(|r| {
            let unit = |k: usize| f64::from(k == r);
            let end =
                Gradient { attitude: Covector::from_fn(|_, a| unit(a)), momentum: Vector::from_fn(|a, _| unit(N + a)) };
            numbers(step.adjoint(&end).unwrap())
        })
        .collect();
    near(&DMatrix::from_columns(&rows).transpose(), &forward, 1e-14, what);
}

fn adjoints<const N: usize, const D: usize>(entry: &Entry) {
    for (name, tableau) in tableaux::<f64>() {
        let tau = retraction::<f64, N, D>(entry, true);
        let method = general(entry, true, tableau, &parameters());
        let mut method = Linearised::new(method, All::<f64, N, D>(group(entry)));
        transposed(method.step(&mut start(&tau), 0.5).unwrap().1, &format!("{entry:?} {name}"));
    }
}

#[test]
fn adjoints_are_transposes_of_tangents() {
    adjoints::<3, 3>(&Entry::So3);
    adjoints::<3, 3>(&Entry::Se2);
    adjoints::<3, 2>(&Entry::Sl2);
    adjoints::<6, 4>(&Entry::Se3);

    // With this inertia elimination exchanges rows.
    let indefinite = Matrix::<f64, 3>::new(0.1, 1.0, 0.2, 1.0, 0.3, 1.5, 0.2, 1.5, 0.1);
    let gauss = Family::Gauss.tableau(2).unwrap();
    let method = Variational::new(Quadratic::new(indefinite).unwrap(), Zero, ExponentialSo3::new(), gauss);
    let mut state = start(&ExponentialSo3::<f64>::new());
    transposed(Linearised::new(method, ()).step(&mut state, 0.25).unwrap().1, "indefinite");
}

/// Ω((ζ, δμ), (ζ', δμ')) = δμ ζ' − δμ' ζ − ⟨μ, [ζ, ζ']⟩ is kept by a step without force, with a potential.
fn symplectic<const N: usize, const D: usize>(entry: &Entry) {
    let algebra = LieAlgebra::<f64, N>::from_catalogue(entry).unwrap();
    let form = |momentum: &Covector<f64, N>| {
        DMatrix::from_fn(2 * N, 2 * N, |r, c| match (r < N, c < N) {
            (true, true) => (0..N).map(|a| -momentum[a] * algebra.constant(r, c, a)).sum(),
            (true, false) => -f64::from(r + N == c),
            (false, true) => f64::from(r == c + N),
            (false, false) => 0.0,
        })
    };
    for (name, tableau) in tableaux::<f64>() {
        for cayley in [false, true] {
            let mut state = start(&retraction::<f64, N, D>(entry, cayley));
            let before = form(&state.momentum);
            let method = general::<f64, N, D>(entry, cayley, tableau.clone(), &[0.0, 0.0, 0.0, 0.5, 0.0]);
            let mut method = Linearised::new(method, ());
            let matrix = method.step(&mut state, 0.5).unwrap().1.matrices().unwrap().state_matrix();
            let kept = matrix.transpose() * form(&state.momentum) * &matrix;
            near(&kept, &before, 1e-13, &format!("{entry:?} {name}"));
        }
    }
}

#[test]
fn a_step_without_force_is_symplectic() {
    symplectic::<3, 3>(&Entry::So3);
    symplectic::<3, 3>(&Entry::Se2);
    symplectic::<3, 2>(&Entry::Sl2);
    symplectic::<6, 4>(&Entry::Se3);
}

/// Σ_n of half the square of the momentum, and of an entry of the attitude at the end.
fn terms(n: usize, steps: usize, state: &State<f64, 3, 3>) -> Gradient<f64, 3> {
    // d/ds g exp(s ê_a)_02 = (g ê_a)_02, with ê_a e₃ the a-th unit vector × e₃.
    let turned = Covector::<f64, 3>::new(-state.attitude[(0, 1)], state.attitude[(0, 0)], 0.0);
    Gradient { attitude: if n == steps { turned } else { Covector::zeros() }, momentum: state.momentum.transpose() }
}

#[test]
fn gradients_of_runs_are_those_of_sensitivities_and_of_differences() {
    let (entry, h) = (Entry::So3, 0.125);
    for steps in [0, 1, 2, 3, 4, 8, 10, 17] {
        let gauss = Family::Gauss.tableau(2).unwrap();
        let method = general::<f64, 3, 3>(&entry, false, gauss, &parameters());
        let mut method = Linearised::new(method, All::<f64, 3, 3>(group(&entry)));
        let from = start(method.method().retraction());
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
            forward += columns(derivative).transpose() * row;
        };
        let mut state = from.clone();
        let whole = method.sensitivity(&mut state, h, steps, &mut add).unwrap();
        let found = DMatrix::from_columns(&[numbers(gradient)]);
        near(&found, &DMatrix::from_columns(&[forward]), 1e-13, &format!("{steps} steps"));

        if steps != 3 {
            continue;
        }
        let gauss = Family::Gauss.tableau(2).unwrap();
        let make = |p: &[Dd]| general::<Dd, 3, 3>(&entry, false, Tableau::clone(&gauss), p);
        let from = start::<Dd, 3, 3>(&retraction(&entry, false));
        let wanted = differences(&make, &parameters::<Dd>(), (&from, Dd::exact(h), steps));
        near(&columns(&whole), &wanted, 1e-13, &format!("{steps} steps"));
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
    let gauss = || Family::Gauss.tableau::<f64>(2).unwrap();
    let rest = State { time: 0.0, momentum: Covector::<f64, 1>::zeros(), attitude: Matrix::identity() };
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
        let momentum = Covector::<f64, 3>::new(0.75, 0.5, -1.0);
        let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
        method.step(&mut state, h).map(|(_, step)| step.condition())
    };
    let (far, near) = (condition(17.6).unwrap(), condition(17.627).unwrap());
    assert!(condition(1.0).unwrap() < 20.0 && far > 100.0 && near > 5.0 * far, "{far} {near}");
    assert!(matches!(condition(17.7), Err(StepError::Fold { .. })));
}

/// Principal moments I₁, I₂ (I₃ = 1) and coefficients of a linear drag.
struct Body;

impl Parameters<f64, 3> for Body {
    fn count(&self) -> usize {
        5
    }

    fn force(&self, k: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if k == a + 2 { -eta[a] } else { 0.0 })
    }

    fn momentum(&self, k: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if k == a && a < 2 { eta[a] } else { 0.0 })
    }
}

/// Inertia and drag of a body from samples of its momentum, by Gauss and Newton's method. One moment has to be known: from μ alone,
/// I⁻¹ is seen up to a multiple of the identity.
#[test]
fn inertia_and_drag_are_found_from_samples_of_the_momentum() {
    let (steps, h) = (120, 0.1);
    let from = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.6, 1.1, 0.8), attitude: Matrix::identity() };
    let run = |p: &DVector<f64>| {
        let mut momenta = DVector::zeros(3 * steps);
        let mut slopes = DMatrix::zeros(3 * steps, 5);
        let body = Quadratic::diagonal([p[0], p[1], 1.0]).unwrap();
        let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(p[2], p[3], p[4]))).unwrap();
        let method = Variational::new(body, drag, CayleySo3::new(), Family::Gauss.tableau(2).unwrap());
        let keep = |n: usize, state: &State<f64, 3, 3>, derivative: &Derivative<f64, 3>| {
            for a in 0..3 {
                momenta[3 * n - 3 + a] = state.momentum[a];
                for k in 0..5 {
                    slopes[(3 * n - 3 + a, k)] = derivative.by_parameters[k].momentum[a];
                }
            }
        };
        Linearised::new(method, Body).sensitivity(&mut from.clone(), h, steps, keep).unwrap();
        (momenta, slopes)
    };
    let truth = DVector::from_column_slice(&[0.5, 1.75, 0.05, 0.1, 0.02]);
    let exact = run(&truth).0;
    for (size, within) in [(0.0, 1e-12), (0.01, 0.01)] {
        let mut noise = Sequence(24);
        let samples = exact.map(|m| m + size * noise.next());
        let mut p = DVector::from_column_slice(&[0.6, 1.5, 0.0, 0.0, 0.0]);
        for _ in 0..12 {
            let (momenta, slopes) = run(&p);
            p += slopes.svd(true, true).solve(&(&samples - momenta), 1e-12).unwrap();
        }
        let error = (&p - &truth).amax();
        assert!(error <= within, "noise {size}: {p} {error:e}");
    }
}

/// Torques f_a(t) = Σ_k p_ak P_k(2t/T − 1) with Legendre's polynomials up to degree 3, for which ½ ∫ |f|² dt = ½ Σ p_ak² T/(2k + 1).
#[derive(Clone)]
struct Torque {
    values: [[f64; 4]; 3],
    duration: f64,
}

impl Torque {
    fn shapes<S: Scalar<Base = f64>>(&self, t: S) -> [S; 4] {
        let x = t * S::exact(2.0 / self.duration) - S::one();
        let square = x * x;
        [S::one(), x, (square * S::int(3) - S::one()) * S::half(), x * (square * S::int(5) - S::int(3)) * S::half()]
    }

    fn weight(&self, k: usize) -> f64 {
        self.duration / (2 * (k % 4) + 1) as f64
    }
}

impl Force<f64, 3> for Torque {
    fn force<S: Scalar<Base = f64>>(&self, t: S, _: &Vector<S, 3>) -> Covector<S, 3> {
        let shapes = self.shapes(t);
        Covector::from_fn(|_, a| (0..4).fold(S::zero(), |sum, k| sum + S::exact(self.values[a][k]) * shapes[k]))
    }
}

impl Parameters<f64, 3> for Torque {
    fn count(&self) -> usize {
        12
    }

    fn force(&self, k: usize, t: f64, _: Configuration<'_, f64>, _: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if a == k / 4 { self.shapes(t)[k % 4] } else { 0.0 })
    }
}

/// The least ½ ∫ |f|² dt that turns a body from rest at 1 to rest at exp(x): the end x − log g = 0, μ = 0 as constraints c(p) = 0, each with
/// its gradient by the adjoint; p ← the least p with c + c'(p) · δp = 0, until it is stationary. Returns p, c, c' and the cost.
fn turn(moments: [f64; 3], x: Vector<f64, 3>, duration: f64) -> (DVector<f64>, DVector<f64>, DMatrix<f64>, f64) {
    let (steps, rest) = (20, State { time: 0.0, momentum: Covector::<f64, 3>::zeros(), attitude: Matrix::identity() });
    let tau = ExponentialSo3::<f64>::new();
    let target: Matrix<f64, 3> = tau.tau(&x).unwrap();
    let torque = Torque { values: [[0.0; 4]; 3], duration };
    let body = Quadratic::diagonal(moments).unwrap();
    let method = Variational::new(body, torque.clone(), tau.clone(), Family::Gauss.tableau(2).unwrap());
    let mut method = Linearised::new(method, torque.clone());
    let weights = DMatrix::from_diagonal(&DVector::from_fn(12, |k, _| torque.weight(k)));
    let inverse = weights.map(|w| if w > 0.0 { 1.0 / w } else { 0.0 });
    let (mut p, mut ends, mut slopes) = (DVector::zeros(12), DVector::zeros(6), DMatrix::zeros(6, 12));
    for _ in 0..40 {
        for (k, &value) in p.iter().enumerate() {
            method.method_mut().force_mut().values[k / 4][k % 4] = value;
        }
        for c in 0..6 {
            let of_end = |n: usize, state: &State<f64, 3, 3>| {
                if n < steps {
                    return Gradient::zero();
                }
                let off = tau.tau_inv(&(target.transpose() * state.attitude)).unwrap();
                ends[c] = if c < 3 { off[c] } else { state.momentum[c - 3] };
                // log(g exp(ζ)) = log g + dτ⁻¹ ζ.
                let rows =
                    euler_poincare::retraction::TangentPoint::d_inv(&tau.at(&off).unwrap()).row(c % 3).into_owned();
                let unit = Vector::<f64, 3>::from_fn(|a, _| if a + 3 == c { 1.0 } else { 0.0 });
                Gradient { attitude: if c < 3 { rows } else { Covector::zeros() }, momentum: unit }
            };
            let gradient = method.gradient(&rest, duration / steps as f64, steps, of_end).unwrap();
            slopes.set_row(c, &DVector::from_vec(gradient.parameters).transpose());
        }
        let across = &inverse * slopes.transpose();
        let multipliers = (&slopes * &across).lu().solve(&(&slopes * &p - &ends)).unwrap();
        p = across * multipliers;
    }
    let cost = 0.5 * p.dot(&(&weights * &p));
    (p, ends, slopes, cost)
}

#[test]
fn a_turn_from_rest_to_rest_has_the_least_torque() {
    // About a principal axis: f = 6 I θ (1 − 2t/T)/T², so that the cost is 6 I² θ²/T³.
    let (_, ends, _, cost) = turn([0.5, 2.0, 1.0], Vector::<f64, 3>::new(0.0, 2.0, 0.0), 2.0);
    assert!(ends.amax() < 1e-12 && (cost / 12.0 - 1.0).abs() < 1e-9, "{ends} {cost}");

    // About another: the end is reached, and along the constraints the cost is stationary: W p is a combination of the rows of c'.
    let (p, ends, slopes, cost) = turn([0.5, 2.0, 1.0], Vector::<f64, 3>::new(0.5, 1.0, -0.75), 2.0);
    let torque = Torque { values: [[0.0; 4]; 3], duration: 2.0 };
    let gradient = DVector::from_fn(12, |k, _| torque.weight(k) * p[k]);
    let multipliers = slopes.transpose().svd(true, true).solve(&gradient, 1e-12).unwrap();
    let rest = (slopes.transpose() * multipliers - &gradient).amax();
    assert!(ends.amax() < 1e-10 && rest < 1e-9 * gradient.amax() && cost > 0.0, "{ends} {rest:e}");
    assert!(p.rows(8, 4).amax() > 0.1);
}
