//! Properties of `euler_poincare::mechanics`: Lagrangians far from rest, forces and files against their formulas, models, refusals. The laws on
//! Lagrangians and forces, and those of `laws::mechanics` and `laws::lie_poisson`, say what holds on random systems.

use crate::systems::{last, parsed};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector, pair};
use euler_poincare::mechanics::force::*;
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Gyrostat, Quadratic, Quartic};
use euler_poincare::mechanics::models::{landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::mechanics::{Force, Lagrangian, LegendreError};
use euler_poincare::scalar::{Dd, Dual, Real, Scalar};
use euler_poincare::system::{System, SystemFile, Visitor};

pub const U: f64 = f64::EPSILON / 2.0;

/// Numbers in [−1, 1), the same on every run.
pub struct Sequence(pub u64);

impl Sequence {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn vector<const N: usize>(&mut self) -> Vector<f64, N> {
        Vector::from_fn(|_, _| self.next())
    }
    pub fn covector<const N: usize>(&mut self) -> Covector<f64, N> {
        Covector::from_fn(|_, _| self.next())
    }
    pub fn matrix<const N: usize>(&mut self) -> Matrix<f64, N> {
        Matrix::from_fn(|_, _| self.next())
    }
    /// BᵀB + 1/4.
    fn inertia<const N: usize>(&mut self) -> Matrix<f64, N> {
        let b = self.matrix::<N>();
        b.transpose() * b + Matrix::identity() * 0.25
    }
}

pub fn size<'a>(entries: impl IntoIterator<Item = &'a f64>) -> f64 {
    entries.into_iter().fold(0.0, |m, v| if v.abs() > m || v.is_nan() { v.abs() } else { m })
}

#[track_caller]
pub fn close(defect: f64, bound: f64) {
    assert!(defect <= bound, "defect {defect:e} above {bound:e}");
}

/// A Lagrangian of which only the value is used: the rest is what any Lagrangian gets.
struct ByValue<L>(L);

impl<L: Lagrangian<f64, N>, const N: usize> Lagrangian<f64, N> for ByValue<L> {
    fn value<S: Scalar<Base = f64>>(&self, eta: &Vector<S, N>) -> S {
        self.0.value(eta)
    }
}

#[test]
fn the_quartic_is_inverted_from_any_guess_at_any_size() {
    let mut random = Sequence(4);
    for k in 0..60 {
        let inertia = random.inertia::<4>();
        let kappa = 10f64.powf(2.0 * random.next());
        let closed = Quartic::new(inertia, kappa).unwrap();
        let eta = random.vector::<4>() * 10f64.powf(6.0 * random.next());
        let q = eta.dot(&(inertia * eta));
        let body = ByValue(closed.clone());
        let gradient = (inertia * eta * (1.0 + kappa * q)).transpose();
        let scale = 64.0 * U * size(&inertia) * (1.0 + kappa * q);
        close(size(&(body.gradient(&eta) - gradient)), 4.0 * scale * size(&eta));
        let slope = inertia * (1.0 + kappa * q) + inertia * eta * (inertia * eta).transpose() * (2.0 * kappa);
        close(size(&(body.hessian(&eta) - slope)), 64.0 * scale);
        close(size(&(closed.gradient(&eta) - gradient)), 4.0 * scale * size(&eta));
        close(size(&(closed.hessian(&eta) - slope)), 64.0 * scale);
        let condition = size(&slope) * size(&slope.try_inverse().unwrap()) * 16.0;
        let guess = match k % 3 {
            0 => Vector::zeros(),
            1 => eta * 1e3,
            _ => random.vector::<4>() * 10f64.powf(4.0 * random.next()),
        };
        let found = body.velocity(&gradient, &guess).unwrap();
        close(size(&(found - eta)), 64.0 * U * condition * size(&eta));
        let found = closed.velocity(&gradient, &guess).unwrap();
        close(size(&(found - eta)), 64.0 * U * condition * size(&eta));
    }
    let closed = Quartic::new(Matrix::<f64, 2>::identity(), 1.0).unwrap();
    assert_eq!(closed.velocity(&Covector::zeros(), &Vector::zeros()).unwrap(), Vector::<f64, 2>::zeros());
    let body = ByValue(closed);
    assert_eq!(body.velocity(&Covector::zeros(), &Vector::zeros()).unwrap(), Vector::<f64, 2>::zeros());
    close(size(&body.velocity(&Covector::zeros(), &Vector::from([3.0, -2.0])).unwrap()), 1e-100);
}

/// l = ½ ηᵀIη + ⟨b, η⟩ + ¼ κ (ηᵀKη)²: l', l'', E, and the inverse of l' from any guess, beside the same by values alone.
#[test]
fn a_gyrostat_and_a_quartic_in_a_metric_of_its_own_are_their_formulas() {
    let mut random = Sequence(14);
    for k in 0..60 {
        let (inertia, factor) = (random.inertia::<4>(), random.matrix::<4>());
        // Of rank 4, and of rank 2.
        let metric =
            if k % 2 == 0 { random.inertia() } else { factor.columns(0, 2) * factor.columns(0, 2).transpose() };
        let (kappa, rotor) = (10f64.powf(2.0 * random.next()), random.vector::<4>().transpose());
        let body = Gyrostat::new(Quartic::in_metric(inertia, kappa, &metric).unwrap(), rotor).unwrap();
        let eta = random.vector::<4>() * 10f64.powf(3.0 * random.next());
        let (momentum, q) = (metric * eta, eta.dot(&(metric * eta)));
        let gradient = (inertia * eta + momentum * (kappa * q)).transpose() + rotor;
        let slope = inertia + metric * (kappa * q) + momentum * momentum.transpose() * (2.0 * kappa);
        let scale = size(&inertia) + size(&metric) * kappa * (q + size(&momentum) * size(&eta));
        let rounding = 256.0 * U * (scale * size(&eta) + size(&rotor));
        close(size(&(body.gradient(&eta) - gradient)), rounding);
        close(size(&(body.hessian(&eta) - slope)), 256.0 * U * scale);
        let energy = 0.5 * eta.dot(&(inertia * eta)) + 0.75 * kappa * q * q;
        close((body.energy(&eta) - energy).abs(), 64.0 * U * energy);
        let by_value = ByValue(body.clone());
        close(size(&(by_value.gradient(&eta) - gradient)), rounding);
        close((by_value.energy(&eta) - energy).abs(), 256.0 * U * (energy + size(&rotor) * size(&eta)));
        let condition = size(&slope.try_inverse().unwrap()) * 16.0;
        for guess in [Vector::zeros(), eta * 1e3, random.vector::<4>() * 10f64.powf(4.0 * random.next())] {
            close(size(&(body.velocity(&gradient, &guess).unwrap() - eta)), condition * rounding);
        }
        // Chosen at run time.
        let any: AnyLagrangian<f64, 4> =
            Gyrostat::new(AnyLagrangian::from(body.body().clone()), *body.rotor()).unwrap().into();
        assert_eq!((any.gradient(&eta), any.energy(&eta)), (body.gradient(&eta), body.energy(&eta)));
    }
    let same = Quartic::in_metric(Matrix::<f64, 2>::identity(), 0.5, &Matrix::identity()).unwrap();
    let (plain, eta) = (Quartic::new(Matrix::<f64, 2>::identity(), 0.5).unwrap(), Vector::from([0.5, -2.0]));
    assert_eq!((same.value(&eta), same.energy(&eta)), (plain.value(&eta), plain.energy(&eta)));
    assert_eq!(same.metric(), plain.metric());
}

/// η + κη³ = μ: η' = 1/p, η'' = −6κη/p³, η''' = (108κ²η²/p − 6κ)/p⁴ with p = 1 + 3κη².
#[test]
fn the_inverse_legendre_transform_carries_derivatives_of_any_order() {
    type Third = Dual<Dual<Dual<f64>>>;
    let kappa = 0.75;
    let body = Quartic::new(Matrix::<f64, 1>::identity(), kappa).unwrap();
    let closed = |mu: Third| body.velocity(&Covector::from([mu]), &Vector::zeros()).unwrap()[0];
    let by_newton = |mu: Third| ByValue(body.clone()).velocity(&Covector::from([mu]), &Vector::zeros()).unwrap()[0];
    let velocities: [&dyn Fn(Third) -> Third; 2] = [&closed, &by_newton];
    for (eta, velocity) in [-1.5, -0.3, 1e-3, 0.4, 2.0].into_iter().flat_map(|eta| velocities.map(|v| (eta, v))) {
        let mu: f64 = eta + kappa * eta * eta * eta;
        let found: Third = velocity(Dual::variable(Dual::variable(Dual::variable(mu))));
        let p = 1.0 + 3.0 * kappa * eta * eta;
        let third = (108.0 * kappa * kappa * eta * eta / p - 6.0 * kappa) / p.powi(4);
        close((found.re.re.re - eta).abs(), 16.0 * U * eta.abs());
        close((found.eps.re.re - 1.0 / p).abs(), 64.0 * U);
        close((found.eps.eps.re + 6.0 * kappa * eta / p.powi(3)).abs(), 256.0 * U);
        close((found.re.eps.eps + 6.0 * kappa * eta / p.powi(3)).abs(), 256.0 * U);
        close((found.eps.eps.eps - third).abs(), 4096.0 * U);
    }
}

struct Flat;
impl Lagrangian<f64, 2> for Flat {
    fn value<S: Scalar<Base = f64>>(&self, eta: &Vector<S, 2>) -> S {
        (S::one() + eta.dot(eta)).sqrt()
    }
}

struct Degenerate;
impl Lagrangian<f64, 2> for Degenerate {
    fn value<S: Scalar<Base = f64>>(&self, eta: &Vector<S, 2>) -> S {
        eta[0] * eta[0]
    }
}

#[test]
fn bad_lagrangians_and_momenta_are_errors() {
    let bad = |m: [f64; 4]| Quadratic::new(Matrix::<f64, 2>::from_row_slice(&m));
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let singular = [[1.0, 2.0, 2.0, 4.0], [1.0, 0.0, 0.0, 0.0]];
    for m in [[1.0, 0.5, 0.4, 1.0], [nan, 0.0, 0.0, 1.0], [1.0, inf, inf, 1.0]].into_iter().chain(singular) {
        assert!(matches!(bad(m), Err(LegendreError::BadInertia { .. })), "{m:?}");
    }
    assert!(bad([1e-40, 0.0, 0.0, 1.0]).unwrap().is_positive_definite());
    let indefinite = bad([1.0, 0.0, 0.0, -1.0]).unwrap();
    assert!(!indefinite.is_positive_definite());
    assert!(Quartic::new(*indefinite.inertia(), 1.0).is_err());
    assert!(Quartic::new(Matrix::<f64, 2>::identity(), -1.0).is_err());
    assert!(Quartic::new(Matrix::<f64, 2>::identity(), f64::NAN).is_err());
    let metric =
        |entries: [f64; 4]| Quartic::in_metric(Matrix::identity(), 1.0, &Matrix::<f64, 2>::from_row_slice(&entries));
    assert!(metric([1.0, 1.0, 1.0, 1.0]).is_ok() && metric([0.0; 4]).is_ok());
    for entries in [[1.0, 0.0, 0.0, -1.0], [1.0, 0.5, 0.0, 1.0], [1.0, f64::NAN, f64::NAN, 1.0]] {
        assert!(matches!(metric(entries), Err(LegendreError::BadTerm { .. })));
    }
    let rotor = Gyrostat::new(bad([1.0, 0.0, 0.0, 1.0]).unwrap(), Covector::from([0.0, f64::INFINITY]));
    assert!(rotor.is_err_and(|e| e.to_string().contains("gyrostat term is refused: entry 2 is not finite")));
    let (mu, guess) = (Covector::from([2.0, 0.0]), Vector::from([0.1, 0.2]));
    assert!(Flat.velocity(&mu, &guess).is_err(), "|l'| < 1 < |μ|");
    assert!(matches!(Degenerate.velocity(&mu, &guess), Err(LegendreError::Singular { .. })));
    let quartic = Quartic::new(Matrix::<f64, 2>::identity(), 1.0).unwrap();
    assert!(quartic.velocity(&Covector::from([f64::NAN, 0.0]), &guess).is_err());
    assert!(quartic.velocity(&Covector::from([1e200, 0.0]), &guess).is_err(), "μ I⁻¹ μᵀ is infinite");
    assert!(ByValue(quartic.clone()).velocity(&Covector::from([f64::NAN, 0.0]), &guess).is_err());
    assert!(ByValue(quartic).velocity(&mu, &Vector::from([f64::INFINITY, 0.0])).is_err());
}

/// The asymmetry that is taken for rounding, 64 N u max|I|, goes with the size of the matrix.
#[test]
fn an_inertia_may_be_asymmetric_by_rounding_at_any_size() {
    for scale in [1e-8, 1.0, 1e8] {
        for (units, allowed) in [(100.0, true), (150.0, false)] {
            let inertia = Matrix::<f64, 2>::new(1.0, 0.5 + units * U, 0.5, 1.0) * scale;
            assert_eq!(Quadratic::new(inertia).is_ok(), allowed, "{scale:e}, {units} u");
        }
    }
}

fn algebra<const N: usize>(entry: &Entry) -> LieAlgebra<f64, N> {
    LieAlgebra::from_catalogue(entry).unwrap()
}

#[test]
fn drags_and_loads_are_their_formulas() {
    let mut random = Sequence(11);
    let (r, k) = (random.matrix::<3>(), random.inertia::<3>());
    let c = random.covector::<3>();
    let linear = LinearDrag::new(r).unwrap();
    let quadratic = QuadraticDrag::new(k).unwrap();
    let load = Constant::new(c).unwrap();
    let wave = Periodic::new(c, 1.5, 0.25).unwrap();
    let sum = AnyForce::Sum(vec![linear.clone().into(), quadratic.clone().into(), load.clone().into()]);
    for _ in 0..20 {
        let (eta, t) = (random.vector::<3>(), random.next());
        close((pair(&linear.force(t, &eta), &eta) + eta.dot(&(r * eta))).abs(), 64.0 * U);
        let power: f64 = -eta.dot(&(k * eta)).powf(1.5);
        close((pair(&quadratic.force(t, &eta), &eta) - power).abs(), 256.0 * U * power.abs().max(1.0));
        assert_eq!(load.force(t, &eta), c);
        close(size(&(wave.force(t, &eta) - c * (1.5 * t + 0.25).cos())), 4.0 * U);
        let slope = wave.force(Dual::variable(t), &eta.map(Dual::constant)).map(|v| v.eps);
        close(size(&(slope + c * (1.5 * (1.5 * t + 0.25).sin()))), 16.0 * U);
        let parts = linear.force(t, &eta) + quadratic.force(t, &eta) + load.force(t, &eta);
        close(size(&(sum.force(t, &eta) - parts)), 16.0 * U * size(&parts));
    }
    assert!(AnyForce::<f64, 3>::from(Zero).is_zero() && AnyForce::<f64, 3>::Sum(vec![]).is_zero());
    assert!(!sum.is_zero() && !Force::<f64, 3>::is_zero(&wave));
    assert!(LinearDrag::new(Matrix::<f64, 3>::zeros()).unwrap().is_zero());
}

#[test]
fn cubic_drag_is_its_formula_in_files_too() {
    let eta = Vector::<f64, 3>::new(0.5, -1.0, 2.0);
    let drag = CubicDrag::new(0.25).unwrap();
    assert_eq!(drag.force(0.0, &eta), -(eta.transpose() * (0.25 * 5.25)));
    assert!(CubicDrag::new(f64::INFINITY).is_err() && Force::<f64, 3>::is_zero(&CubicDrag::new(0.0).unwrap()));

    // η̇ = −q η³ in one dimension, from η = 1: η = 1/√(1 + 2 q t), in 32 digits.
    let file = parsed(include_str!("systems/cases/cubic-drag.toml"));
    let last = last::<Dd>(&file);
    let error = (last[1] - Dd::half()).to_f64();
    assert!(error.abs() < 1e-20, "{error:e}");
    let text = file.case.to_string();
    assert!(text.contains("cubic-drag q = 3/2"), "{text}");
}

/// A body on so(3) with these keys in `[lagrangian]`, of unit inertia if they have none, at rest or not, without force.
fn body(keys: &str, state: &str) -> SystemFile {
    let keys = if keys.contains("inertia") { keys.to_owned() } else { format!("inertia = [1, 1, 1]\n{keys}") };
    let file = format!(
        "format = 1\n[algebra]\nname = \"so3\"\n[lagrangian]\n{keys}\n[method]\ntableau = \"gauss-4\"\nretraction = \"exp\"\n\
         [state]\n{state}\n[run]\nstep = \"1/16\"\nsteps = 16\n"
    );
    parsed(&file)
}

#[test]
fn gyrostats_metrics_and_indefinite_inertias_are_in_files() {
    // M = b at rest, and nothing moves it; then with a rotor along the axis of a symmetric body, where the steady precession is known:
    // Ω = (a, 0, n), ad*_Ω M = M × Ω = 0 for M = (A a, 0, C n + b) where A n = C n + b.
    let end = |keys: &str, state: &str| last::<Dd>(&body(keys, state)).iter().map(|x| x.to_f64()).collect::<Vec<f64>>();
    let rest = end("inertia = [1, 2, 3]\ngyrostat = [1, \"1/2\", -1]", "velocity = [0, 0, 0]");
    assert_eq!(rest[1..8], [1.0, 0.5, -1.0, 0.0, 0.0, 0.0, 0.0]);
    let steady = end("inertia = [3, 3, 1]\ngyrostat = [0, 0, 1]", "velocity = [1, 0, \"1/2\"]");
    for (found, wanted) in steady[1..8].iter().zip([3.0, 0.0, 1.5, 1.0, 0.0, 0.5, 1.625]) {
        assert!((found - wanted).abs() < 1e-28, "{steady:?}");
    }
    // q = Ω_3⁴/4 with K = diag(0, 0, 1): l' = (Ω_1, Ω_2, Ω_3 + Ω_3³).
    let quartic = end("quartic = 1\nmetric = [0, 0, 1]", "velocity = [0, 0, 2]");
    assert_eq!(quartic[1..8], [0.0, 0.0, 10.0, 0.0, 0.0, 2.0, 14.0]);
    // An indefinite body: the energy and |M|² are kept.
    let hyperbolic = end("inertia = [1, -2, 3]\nindefinite = true", "momentum = [1, 1, 1]");
    let energy = 0.5 - 0.25 + 1.0 / 6.0;
    assert!((hyperbolic[7] - energy).abs() < 1e-9 && (hyperbolic[1] - 1.0).abs() > 1e-3, "{hyperbolic:?}");
    let printed = body("gyrostat = [0, 0, 1]\nquartic = \"1/3\"\nmetric = [0, 0, 1]", "momentum = [1, 1, 1]");
    let text = printed.case.to_string();
    let line = "lagrangian inertia diag[1, 1, 1], gyrostat [0, 0, 1], quartic 1/3 in the metric diag[0, 0, 1]\n";
    assert!(text.contains(line), "{text}");
    assert_eq!(parsed(&printed.to_toml().unwrap()), printed);
}

#[test]
fn polynomials_are_their_terms_in_files_too() {
    let force = |keys: &str| body(&format!("inertia = [1, 2, 3]\n[[force]]\n{keys}"), "momentum = [1, 1, 1]");
    struct At(f64, Vector<f64, 3>);
    impl Visitor<f64> for At {
        type Output = Vector<f64, 3>;
        fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Vector<f64, 3> {
            let eta = Vector::<f64, N>::from_fn(|a, _| self.1.get(a).copied().unwrap_or(0.0));
            let force = system.force.force(self.0, &eta);
            Vector::from_fn(|a, _| force[a])
        }
    }
    let (t, eta) = (0.75, Vector::<f64, 3>::new(0.5, -1.0, 2.0));
    let is = |keys: &str, expected: Vector<f64, 3>, bound: f64| {
        let file = force(keys);
        assert_eq!(parsed(&file.to_toml().unwrap()), file);
        close(size(&(file.case.dispatch::<f64, _>(At(t, eta)).unwrap() - expected)), bound);
    };
    let terms = "[[1, \"1/2\", 0, 1, [2, 2, 3]], [3, -3, 2, 0, []], [3, 1, 0, 0, [1]]]";
    let p = Vector::<f64, 3>::new(0.5 * t.sin() * 2.0, 0.0, -3.0 * t.cos() * t.cos() + 0.5);
    is(&format!("kind = \"polynomial\"\nterms = {terms}"), p, 16.0 * U);
    // M × ζ on so(3).
    let m = Vector::<f64, 3>::new(0.5, -2.0, 6.0);
    is(&format!("kind = \"orbit\"\nzeta = {terms}"), m.cross(&p), 256.0 * U);
    let text = force(&format!("kind = \"orbit\"\nzeta = {terms}")).case.to_string();
    assert!(
        text.contains("force      orbit zeta = [[1, 1/2, 0, 1, [2, 2, 3]], [3, -3, 2, 0, []], [3, 1, 0, 0, [1]]]"),
        "{text}"
    );
    let term = |coefficient, component, cos| Monomial { component, coefficient, cos, sin: 0, factors: vec![0] };
    for (bad, why) in
        [(term(f64::NAN, 0, 0), "finite"), (term(1.0, 3, 0), "no component 4 of 3"), (term(1.0, 0, 17), "degree 17")]
    {
        assert!(Polynomial::<f64, 3>::new(vec![bad]).is_err_and(|e| e.to_string().contains(why)));
    }
    assert!(Force::<f64, 3>::is_zero(&Polynomial::<f64, 3>::new(vec![term(0.0, 0, 1)]).unwrap()));
}

#[test]
fn quadratic_drag_is_differentiable_at_rest() {
    let singular = Matrix::<f64, 2>::from_row_slice(&[1.0, 1.0, 1.0, 1.0]);
    for k in [Matrix::identity(), singular, Matrix::zeros()] {
        let drag = QuadraticDrag::new(k).unwrap();
        let moving = Vector::from([Dual::variable(Dual::variable(0.0)), Dual::constant(Dual::variable(0.0))]);
        let force = drag.force(Dual::constant(Dual::constant(0.0)), &moving);
        assert!(force.iter().all(|v| v.re.re == 0.0 && v.re.eps == 0.0 && v.eps.re == 0.0 && v.eps.eps == 0.0));
    }
}

#[test]
fn bad_forces_are_errors() {
    let nan = Matrix::<f64, 2>::from_row_slice(&[1.0, 0.0, f64::NAN, 1.0]);
    let body = Quadratic::diagonal([1.0, 2.0, 3.0]).unwrap();
    assert!(DoubleBracket::new(algebra::<3>(&Entry::So3), body.clone(), f64::NAN).is_err());
    assert!(Metriplectic::new(algebra::<3>(&Entry::So3), body, f64::INFINITY).is_err());
    assert!(matches!(LinearDrag::new(nan), Err(ForceError::NotFinite { .. })));
    assert!(QuadraticDrag::new(nan).is_err());
    let indefinite = Matrix::<f64, 2>::from_row_slice(&[1.0, 0.0, 0.0, -1e-3]);
    assert!(matches!(QuadraticDrag::new(indefinite), Err(ForceError::BadMatrix { .. })));
    assert!(QuadraticDrag::new(Matrix::<f64, 2>::from_row_slice(&[1.0, 0.1, 0.0, 1.0])).is_err());
    assert!(Constant::new(Covector::from([f64::NAN])).is_err());
    assert!(Periodic::new(Covector::from([1.0]), f64::INFINITY, 0.0).is_err());
}

/// In 32 digits; elsewhere integrators of several kinds end there in 16.
#[test]
fn the_models_start_and_end_where_they_say() {
    let decimal = |text| Dd::parse_decimal(text).unwrap();
    let (energy, square) = (
        decimal("0.325558583767277337311226297454719051018832743"),
        decimal("0.639208655351581980652366160171253173860125946"),
    );
    for (model, energy, square, bound) in [
        (landau_lifshitz_gilbert::<Dd>(), energy, Dd::ratio(5, 8), 1e-31),
        (relaxed_rigid_body(), Dd::ratio(3, 8), square, 1e-30),
    ] {
        let start = model.system.lagrangian.gradient(&model.velocity());
        close((start - model.momentum).amax().to_f64(), 1e-30);
        let end = model.reference_momentum().unwrap();
        close((model.system.hamiltonian(&end, &Vector::zeros()).unwrap() - energy).to_f64().abs(), bound);
        close((end.norm_squared() - square).to_f64().abs(), 1e-31);
    }
}
