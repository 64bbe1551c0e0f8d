//! Properties of the slope laws of methods: what they are asked on, and that correct methods are not refused.

#[path = "../steppers/methods.rs"]
mod methods;

use self::methods::{Engine, Method};
use euler_poincare::harness::{Verdict, draw};
use euler_poincare::integrators::StepError;
use euler_poincare::laws::method::{
    Claims, LAWS, MethodLaw, MethodSource, Point, StateForm, Stepper, check_case, named,
};
use euler_poincare::study::problem;
use euler_poincare::system::case::{Drag, Force as Term};
use euler_poincare::system::{self, Case, Cases, cases};
use euler_poincare::tableau::{Description, Family, Tableau};
use nalgebra::DMatrix;
use proptest::strategy::{Just, Strategy};

/// The method, which answers NaN from steps above a size on.
struct Diverging(Method, f64);

impl MethodSource for Diverging {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        Ok(Box::new(DivergingStep(self.0.double(case)?, self.1)))
    }
}

struct DivergingStep<'m>(Box<dyn Stepper<f64> + 'm>, f64);

impl Stepper<f64> for DivergingStep<'_> {
    fn step(&mut self, point: &Point<f64>, h: f64) -> Result<Point<f64>, StepError> {
        let mut next = self.0.step(point, h)?;
        if h.abs() > self.1 {
            next.momentum[0] = f64::NAN;
        }
        Ok(next)
    }
}

/// Cases of the law.
fn drawn(law: &MethodLaw, base: Cases, seed: u64, count: usize) -> Vec<Case> {
    let strategy = law.cases(base).boxed();
    (0..count).map(|index| draw(&strategy, seed, law.about.name, index).case.unwrap().0).collect()
}

/// Cases on some of the algebras.
fn on(algebras: &[&str]) -> Cases {
    cases().algebras(&algebras.iter().map(|name| name.parse().unwrap()).collect::<Vec<_>>())
}

fn tableau(name: &str) -> Tableau<f64> {
    name.parse::<Description>().unwrap().build().unwrap()
}

fn rk4() -> Method {
    Method(Engine::Classical, tableau("rk4"))
}

fn variational(name: &str) -> Method {
    Method(Engine::Variational, tableau(name))
}

fn claims(order: u32) -> Claims {
    Claims { order: Some(order), ..Claims::default() }
}

/// Cases on which slopes refused a correct method.
///
/// `gauss-3` was refused on the last: near its start the leading term of the balance is small, and other starts whose momentum had the
/// same signs were no better. In 32 digits its order there is 6.
#[test]
fn correct_methods_are_not_refused_where_they_were() {
    assert_eq!(include_str!("refused.txt").lines().count(), 5);
    for (k, line) in include_str!("refused.txt").lines().enumerate() {
        let mut parts = line.splitn(3, '\t');
        let mut next = || parts.next().unwrap();
        let (law, name, case) = (named(next()).unwrap(), next(), next());
        let case: Case = serde_json::from_str(case).unwrap();
        let (method, order, decided) = match name {
            "rk4" => (rk4(), 4, k > 0),
            "gauss-2" => (variational(name), 4, true),
            "gauss-3" => (variational(name), 6, false),
            other => panic!("{other}"),
        };
        let verdict = check_case(law, &method, &case, &claims(order)).verdict;
        assert!(!verdict.is_broken(), "{k}: {verdict}");
        assert!(!decided || verdict.holds(), "{k}: {verdict}");
    }
}

/// The laws that ask for a slope.
fn slopes() -> impl Iterator<Item = &'static MethodLaw> {
    LAWS[..4].iter()
}

#[test]
fn a_step_that_diverges_is_left_out_if_it_is_larger_than_that_of_the_system() {
    let case = problem::generic().unwrap().case;
    let step = case.step.eval::<f64>().unwrap();
    for law in slopes() {
        for (diverges, broken) in [(step, false), (step / 3.0, true)] {
            let verdict = check_case(law, &Diverging(rk4(), diverges), &case, &claims(4)).verdict;
            assert_eq!(verdict.is_broken(), broken, "{} beyond {diverges}: {verdict}", law.about.name);
        }
    }
}

#[test]
fn wrong_orders_are_refuted_and_right_ones_confirmed() {
    let case = problem::generic().unwrap().case;
    let mut off = vec![vec![0.0; 4]; 4];
    (off[1][0], off[2][1], off[3][2]) = (0.5, 0.5 + 1e-3, 1.0);
    let off = Tableau::new(&off, &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0]).unwrap();
    let named = [("rk4", 5), ("heun2", 3), ("heun2", 4), ("ralston3", 4), ("radau-iia-2", 4)];
    let wrong = named.map(|(name, order)| (tableau(name), order)).into_iter().chain([(off, 4)]);
    let wrong: Vec<(Tableau<f64>, u32)> = wrong.collect();
    for law in &LAWS[..3] {
        for (k, (tableau, order)) in wrong.iter().enumerate() {
            let verdict = check_case(law, &Method(Engine::Classical, tableau.clone()), &case, &claims(*order)).verdict;
            assert!(verdict.is_broken(), "{} {k}: {verdict}", law.about.name);
        }
        let verdict = check_case(law, &rk4(), &case, &claims(4)).verdict;
        assert!(verdict.holds(), "{}: {verdict}", law.about.name);
    }
    // On both sides.
    let verdict = check_case(&LAWS[0], &rk4(), &case, &claims(3)).verdict;
    assert!(verdict.is_broken(), "{verdict}");
}

#[test]
fn the_slope_laws_draw_what_shows_an_error() {
    const COUNT: usize = 200;
    let gauss = Just(Description::Family(Family::Gauss, 1));
    for law in slopes() {
        let drawn = drawn(law, cases().with_tableaux(gauss.clone()), 5, COUNT);
        let share = |what: &dyn Fn(&Case) -> bool| drawn.iter().filter(|case| what(case)).count() as f64 / COUNT as f64;
        let with = |what: fn(&Term) -> bool| share(&|case: &Case| case.forces.iter().any(what));
        let unsymmetric = |rows: &[Vec<_>]| {
            let n = rows.len();
            (0..n).any(|a| (0..a).any(|b| rows[a][b] != rows[b][a]))
        };
        let quadratic = with(|force| matches!(force, Term::QuadraticDrag(_)));
        let matrix = share(&|case: &Case| {
            case.forces.iter().any(|f| matches!(f, Term::LinearDrag(Drag::Matrix(rows)) if unsymmetric(rows)))
        });
        let free = share(&|case: &Case| case.forces.is_empty());
        assert!(quadratic > 0.15, "{}: quadratic drag in {quadratic}", law.about.name);
        assert!(matrix > 0.2, "{}: matrices without symmetry in {matrix}", law.about.name);
        assert!(free < 0.25, "{}: no force in {free}", law.about.name);
    }
}

/// The method on a system with its forces changed: what a program makes that reads them wrongly.
struct Misread(fn(&mut Case), Method);

impl MethodSource for Misread {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        let mut misread = case.clone();
        self.0(&mut misread);
        self.1.double(&misread)
    }
}

#[test]
fn drag_that_is_read_wrongly_is_refuted() {
    let transposed = |case: &mut Case| {
        for force in &mut case.forces {
            if let Term::LinearDrag(Drag::Matrix(rows)) = force {
                let old = rows.clone();
                (0..old.len()).for_each(|a| (0..old.len()).for_each(|b| rows[a][b] = old[b][a].clone()));
            }
        }
    };
    let linear = |case: &mut Case| {
        for force in &mut case.forces {
            if let Term::QuadraticDrag(drag) = force {
                *force = Term::LinearDrag(drag.clone());
            }
        }
    };
    for (k, misread) in [transposed as fn(&mut Case), linear].into_iter().enumerate() {
        let subject = Misread(misread, rk4());
        let caught = |law: &MethodLaw| {
            let cases = drawn(law, on(&["so3", "se2"]), 9, 12);
            cases.iter().any(|case| check_case(law, &subject, case, &Claims::default()).verdict.is_broken())
        };
        assert!(caught(&LAWS[0]), "misreading {k}");
        // The part of a drag that is not symmetric does no work.
        assert!(k == 0 || caught(&LAWS[2]), "misreading {k}");
    }
}

#[test]
fn a_claim_that_nothing_confirms_is_not_confirmed() {
    // Order 8 has no three levels between a tenth and the rounding errors of 16 digits.
    let case = problem::generic().unwrap().case;
    let verdict = check_case(&LAWS[0], &variational("gauss-4"), &case, &claims(8)).verdict;
    assert!(matches!(verdict, Verdict::Inconclusive { .. } | Verdict::Holds { .. }), "{verdict}");
}

/// A method whose state is the momentum alone, or a point besides: the increment of the attitude moves it, on the right side or not.
struct WithoutAttitude {
    form: StateForm,
    method: Method,
    wrong_side: bool,
}

struct Moving<'m>(Box<dyn Stepper<f64> + 'm>, &'m WithoutAttitude);

impl Stepper<f64> for Moving<'_> {
    fn step(&mut self, point: &Point<f64>, h: f64) -> Result<Point<f64>, StepError> {
        let StateForm::Point(x) = &self.1.form else { return self.0.step(point, h) };
        let m = x.len();
        assert_eq!(point.attitude.len(), m);
        let identity = DMatrix::<f64>::identity(m, m).iter().copied().collect();
        let next = self.0.step(&Point { attitude: identity, ..point.clone() }, h)?;
        let increment = DMatrix::from_row_slice(m, m, &next.attitude);
        let inverse = if self.1.wrong_side { increment } else { increment.try_inverse().unwrap() };
        let moved = inverse * DMatrix::from_row_slice(m, 1, &point.attitude);
        Ok(Point { attitude: moved.iter().copied().collect(), ..next })
    }
}

impl MethodSource for WithoutAttitude {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        Ok(Box::new(Moving(self.method.double(case)?, self)))
    }

    fn form(&self) -> StateForm {
        self.form.clone()
    }
}

#[test]
fn points_of_homogeneous_spaces_and_of_orbits_have_the_order_of_the_method() {
    let (sphere, origin) = (StateForm::Point(vec![0.0, 0.0, 1.0]), StateForm::Point(vec![0.0, 0.0, 0.0, 1.0]));
    let plane = StateForm::Point(vec![3.0, -1.0]);
    for (algebra, form) in [
        ("so3", sphere.clone()),
        ("se2", sphere),
        ("se3", origin),
        ("sl2", plane),
        ("so3", StateForm::Momentum),
        ("se2", StateForm::Momentum),
    ] {
        let cases = drawn(&LAWS[0], on(&[algebra]).kinetic(), 3, 12);
        let count = |wrong_side: bool| {
            let subject = WithoutAttitude { form: form.clone(), method: variational("gauss-2"), wrong_side };
            let verdict = |case| check_case(&LAWS[0], &subject, case, &claims(4)).verdict;
            let verdicts: Vec<Verdict> = cases.iter().map(verdict).collect();
            [verdicts.iter().filter(|v| v.holds()).count(), verdicts.iter().filter(|v| v.is_broken()).count()]
        };
        let [held, broken] = count(false);
        // Of the method with its attitude 6 of 12 are decided on SE(2).
        assert!(held >= 5 && broken == 0, "{algebra} {form:?}: {held} held, {broken} broken");
        if form != StateForm::Momentum {
            let [held, broken] = count(true);
            assert!(broken >= 9 && held == 0, "{algebra} {form:?}, the wrong side: {held} held, {broken} broken");
        }
    }
}

/// With the claim of its tolerance it holds. Without, it claims round-off: what the iteration leaves is then no conservation, and may be
/// refuted.
#[test]
fn an_iteration_that_stops_early_is_no_error_of_an_order() {
    let kept = Claims { casimirs: true, momentum: true, poisson: true, ..Claims::default() };
    for name in ["gauss-1", "gauss-2", "lobatto-iiia-3", "radau-iia-2"] {
        for tolerance in [1e-12, 1e-10] {
            let subject = Method(Engine::Loose(tolerance), tableau(name));
            for law in LAWS.iter().filter(|law| law.claim(&kept).is_some()) {
                for case in drawn(law, on(&["so3", "se2", "sl2"]).kinetic().force_free(), 2, 16) {
                    let verdict = check_case(law, &subject, &case, &Claims { tolerance, ..kept.clone() }).verdict;
                    assert!(verdict.holds(), "{name}, {tolerance}, {}: {verdict}", law.about.name);
                }
            }
        }
    }
}

/// What is claimed of a case: the scheme of a tableau, with the retraction of the case.
fn scheme(case: &Case, tableau: &Description, tolerance: f64) -> Claims {
    let method = system::case::Method { tableau: tableau.clone(), ..case.method.clone() };
    Claims { variational: Some(method), tolerance, ..Claims::default() }
}

#[test]
fn the_scheme_holds_with_any_tolerance_and_without_an_attitude() {
    let law = named("method-variational").unwrap();
    for (k, tableau) in
        ["gauss-1", "gauss-2", "gauss-3", "gauss-4", "lobatto-iiia-2", "lobatto-iiia-3", "lobatto-iiib-2"]
            .into_iter()
            .chain(["lobatto-iiib-3", "radau-ia-2", "radau-iia-2", "radau-iia-3", "lobatto-iiic-2", "rk4"])
            .enumerate()
    {
        let tableau: Description = tableau.parse().unwrap();
        for tolerance in [0.0, [1e-13, 1e-11, 1e-9, 1e-7][k % 4]] {
            let subject = Method(Engine::Loose(tolerance), tableau.build().unwrap());
            for algebra in ["so3", "se2", "sl2"] {
                let (mut held, cases) = (0, drawn(law, on(&[algebra]), 2, 8));
                for case in &cases {
                    let verdict = check_case(law, &subject, case, &scheme(case, &tableau, tolerance)).verdict;
                    assert!(!verdict.is_broken(), "{tableau}, {tolerance}, {algebra}: {verdict}\n{case:?}");
                    held += usize::from(verdict.holds());
                }
                assert!(held + 1 >= cases.len(), "{tableau}, {tolerance}, {algebra}: {held} held");
            }
        }
    }
    let sphere = StateForm::Point(vec![0.0, 0.0, 1.0]);
    let tableau: Description = "gauss-2".parse().unwrap();
    for (algebra, form) in [("so3", sphere.clone()), ("se2", sphere), ("sl2", StateForm::Momentum)] {
        let of = |wrong_side| WithoutAttitude { form: form.clone(), method: variational("gauss-2"), wrong_side };
        for case in drawn(law, on(&[algebra]), 2, 8) {
            let claims = scheme(&case, &tableau, 0.0);
            let verdict = check_case(law, &of(false), &case, &claims).verdict;
            assert!(verdict.holds(), "{algebra} {form:?}: {verdict}");
            let wrong = check_case(law, &of(true), &case, &claims).verdict;
            assert_eq!(wrong.is_broken(), form != StateForm::Momentum, "{algebra} {form:?}: {wrong}");
        }
    }
}

/// An iteration that stops early without saying so is no step of the scheme.
#[test]
fn a_tolerance_that_is_not_claimed_is_seen() {
    let law = named("method-variational").unwrap();
    let tableau: Description = "gauss-2".parse().unwrap();
    let subject = Method(Engine::Loose(1e-6), tableau.build().unwrap());
    let cases = drawn(law, on(&["so3"]), 2, 8);
    let verdict = |case| check_case(law, &subject, case, &scheme(case, &tableau, 0.0)).verdict;
    let broken = cases.iter().filter(|case| verdict(case).is_broken()).count();
    assert!(broken >= 4, "{broken} of {}", cases.len());
}
