//! Properties of `euler_poincare::study` and of the laws of order: bad methods are refuted every time, good ones never, and a
//! table of all named tableaux.

use euler_poincare::algebra::Covector;
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::harness::{Fault, Law, draw};
use euler_poincare::integrators::{OneStep, Report, Solver, State, StepError};
use euler_poincare::laws;
use euler_poincare::laws::planted::step::{
    FIRST_STAGE, FORCE_INDEX, INVERSE_SECOND, NO_SECOND, ORDER_TWO, UNCONJUGATED,
};
use euler_poincare::laws::planted::{retraction, tableau};
use euler_poincare::laws::trial::{Digits, Judged, Trial};
use euler_poincare::mechanics::equations::EulerPoincare;
use euler_poincare::scalar::{Dd, Number};
use euler_poincare::study::guard::{Warning, warnings};
use euler_poincare::study::{Comparison, Findings, Reading, Row, StepLevel, Study, Target, problem};
use euler_poincare::system::{Case, System, Visitor, cases};
use euler_poincare::tableau::{Description, Family, analyse};
use proptest::sample::select;
use proptest::strategy::Strategy;
use rayon::prelude::*;
use std::fmt::Write;

/// Random problems of each bad method.
const PROBLEMS: usize = 8;

/// Algebras that are not nilpotent. The step in which faults are planted solves dense equations by Newton's method: dimension 6
/// takes it seconds, and has its turn in the campaigns of the command.
const ALGEBRAS: [Entry; 5] = [Entry::So3, Entry::Sl2, Entry::Se2, Entry::Se3, Entry::So4];
const SMALL: usize = 3;

/// The warnings about a case over eight of its steps.
struct Look;

impl Visitor<f64> for Look {
    type Output = Vec<Warning>;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Vec<Warning> {
        let body = EulerPoincare::new(system.algebra.clone(), &system.lagrangian, &system.force);
        warnings(&body, &system.state, 8.0 * system.step)
    }
}

/// Forced motions without warnings, on these algebras, with one of these tableaux.
fn problems(seed: u64, algebras: &[Entry], tableaux: &[&str], count: usize) -> Vec<Case> {
    let tableaux: Vec<Description> = tableaux.iter().map(|name| name.parse().unwrap()).collect();
    let strategy = cases().algebras(algebras).forced_nonabelian().smooth().with_tableaux(select(tableaux)).boxed();
    let drawn = (0..).map(|index| draw(&strategy, seed, "zoo", index).case.unwrap().0);
    drawn.filter(|case| case.dispatch(Look).unwrap().is_empty()).take(count).collect()
}

/// Every one of the problems refutes the method with the fault, and none the method without it.
#[test]
fn every_bad_method_is_refuted() {
    let table: [(&str, &Fault, &[&str]); 9] = [
        ("order-munthe-kaas", &tableau::WRONG_STAGE, &["rk4", "kutta38", "ralston3"]),
        ("order-munthe-kaas", &retraction::INVERSE_MISSING, &["rk4", "kutta38", "ralston3"]),
        ("order-predicted", &INVERSE_SECOND, &["gauss-2", "gauss-3", "rk4", "lobatto-iiib-3"]),
        ("order-predicted", &NO_SECOND, &["gauss-2", "gauss-3", "rk4", "lobatto-iiia-3"]),
        ("order-predicted", &FORCE_INDEX, &["gauss-3", "radau-iia-3", "lobatto-iiib-4"]),
        ("order-predicted", &tableau::COEFFICIENT, &["rk4", "gauss-2", "gauss-3", "radau-ia-2", "lobatto-iiic-3"]),
        ("order-predicted", &UNCONJUGATED, &["ralston3"]),
        ("order-predicted", &ORDER_TWO, &["gauss-2", "gauss-3", "rk4", "sdirk2"]),
        ("order-predicted", &FIRST_STAGE, &["gauss-2", "gauss-3", "rk4", "lobatto-iiia-3"]),
    ];
    table.into_par_iter().for_each(|(law, fault, tableaux)| {
        let law = laws::named(law).unwrap();
        let planted = laws::planted::step::ALL.iter().any(|known| known.name == fault.name);
        let algebras = if planted { &ALGEBRAS[..SMALL] } else { &ALGEBRAS };
        for (index, case) in problems(11, algebras, tableaux, PROBLEMS).iter().enumerate() {
            let bad = law.check(case, Some(fault));
            assert!(bad.is_broken(), "{}, problem {index}: {bad}\n{case}", fault.name);
            if index < 3 {
                let good = law.check(case, None);
                assert!(good.holds(), "{}, problem {index}: {good}\n{case}", law.about.name);
            }
        }
    });
}

/// The entries of a Gauss method to a number of decimals.
fn rounded(stages: usize, places: usize) -> Description {
    let tableau = Family::Gauss.tableau::<f64>(stages).unwrap();
    let number = |x: f64| format!("{x:.places$}").parse::<Number>().unwrap();
    let a = (0..stages).map(|i| (0..stages).map(|j| number(tableau.a()[(i, j)])).collect()).collect();
    Description::entries(a, tableau.b().iter().map(|&b| number(b)).collect())
}

#[test]
fn gauss_3_to_eight_digits() {
    let description = rounded(3, 8);
    let analysis = analyse(&description, 8).unwrap();
    assert!(analysis.exactly.variational.order <= 2, "{:?}", analysis.exactly.variational);
    assert_eq!(analysis.to_digits.as_ref().unwrap().variational.order, 6);
    let exact = analysis.exactly.variational.order as u32;
    for mut case in problems(12, &ALGEBRAS[..SMALL], &["gauss-3"], PROBLEMS) {
        case.method.tableau = description.clone();
        let horizon = 4.0 * case.step.eval::<f64>().unwrap();
        let trial = Trial::of(&case, Digits::ThirtyTwo, horizon, 6).unwrap();
        assert!(matches!(trial.compare(6), Comparison::Below { .. }), "{:?}\n{case}", trial.compare(6));
        assert!(matches!(trial.compare(exact), Comparison::As { .. }), "{:?}\n{case}", trial.compare(exact));
    }
}

#[test]
fn labels_that_are_off_are_refuted() {
    for (name, order) in [("heun2", 2_u32), ("sdirk2", 3), ("rk4", 4), ("radau-iia-3", 5)] {
        for case in problems(13, &ALGEBRAS, &[name], 5) {
            let horizon = 4.0 * case.step.eval::<f64>().unwrap();
            let trial = Trial::of(&case, Digits::ThirtyTwo, horizon, order).unwrap();
            let [right, above, below] = [order, order + 1, order - 1].map(|order| trial.compare(order));
            assert!(matches!(right, Comparison::As { .. }), "{name}: {right:?}\n{case}");
            assert!(matches!(above, Comparison::Below { .. }), "{name}: {above:?}\n{case}");
            assert!(
                matches!(below, Comparison::Above { .. } | Comparison::Unknown { .. }),
                "{name}: {below:?}\n{case}"
            );
        }
    }
}

/// The forces of the generic problem, in its file.
fn forces() -> &'static str {
    let text = problem::generic_text();
    &text[text.find("[[force]]").unwrap()..text.find("[method]").unwrap()]
}

#[test]
fn the_guard_warns_of_problems_that_hide() {
    let warned = |changes: &[(&str, &str)], expected: &[Warning]| {
        let text = changes.iter().fold(problem::generic_text().to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        assert_eq!(Case::from_toml(&text).unwrap().dispatch(Look).unwrap(), expected, "{changes:?}");
    };
    let forces = forces();
    let drag = "[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/4\"\n";
    let inertia = "inertia = [[\"1/2\", \"1/8\", 0], [\"1/8\", 2, \"-1/4\"], [0, \"-1/4\", 1]]";
    let velocity = "velocity = [\"3/4\", \"1/4\", \"5/8\"]";
    warned(&[], &[]);
    warned(&[(forces, "")], &[Warning::NoForce]);
    warned(&[(forces, "[[force]]\nkind = \"constant\"\nvalue = [1, 2, 3]\n")], &[Warning::ForceIgnoresVelocity]);
    warned(&[("\"so3\"", "\"r3\"")], &[Warning::Commuting, Warning::LinearField]);
    warned(&[(forces, drag), (inertia, "inertia = [1, 1, 1]")], &[Warning::LinearField, Warning::Isotropic]);
    let steady = [(forces, ""), (inertia, "inertia = [1, 2, 3]"), (velocity, "velocity = [0, 1, 0]")];
    warned(&steady, &[Warning::NoForce, Warning::ConstantVelocity]);
}

#[test]
fn where_a_system_hides_the_order_its_variations_show_it() {
    // Free motion in the basis of the axes: SDIRK-2 has order 4 there with Cayley, and 3 in general.
    let mut case = Case::from_toml(&problem::generic_text().replace(forces(), "")).unwrap();
    case.method.tableau = "sdirk2".parse().unwrap();
    let judged = Judged::of(&case, Digits::ThirtyTwo, 1.0, 3, false).unwrap();
    assert!(judged.verdict.holds(), "{:?}", judged.verdict);
    assert!(matches!(judged.trial.compare(3), Comparison::Above { .. }));
    assert!(judged.trial.warnings.contains(&Warning::NoForce));
    assert!(judged.trial.warnings.contains(&Warning::SuperConvergence));
    assert!(judged.explanation.is_some_and(|why| why.contains("variation 1 of the system shows it")));
    // Order 4, which the system shows, is not that of the method.
    let judged = Judged::of(&case, Digits::ThirtyTwo, 1.0, 4, false).unwrap();
    assert!(judged.verdict.holds(), "the case alone shows order 4: {:?}", judged.verdict);
}

#[test]
fn lobatto_iiib_5_has_order_8() {
    let mut case = problem::generic().unwrap().case;
    case.method.tableau = Description::Family(Family::LobattoIIIB, 5);
    let trial = Trial::of(&case, Digits::ThirtyTwo, 1.0, 8).unwrap();
    let Comparison::As { slope, .. } = trial.compare(8) else { panic!("{:?}", trial.compare(8)) };
    assert!((slope - 8.0).abs() < 0.05, "{slope}");
}

/// A user's stepper that spoils one number.
struct Spoiling(usize);

impl OneStep<Dd, 3, 3> for Spoiling {
    fn step(&mut self, state: &mut State<Dd, 3, 3>, h: Dd) -> Result<Report<Dd>, StepError> {
        self.0 += 1;
        state.time += h;
        if self.0 > 2 {
            state.momentum[0] = Dd::exact(f64::NAN);
        }
        Ok(Report { solver: Solver::Explicit, iterations: 1, residual: Dd::exact(0.0) })
    }
}

#[test]
fn a_stepper_that_answers_nan_is_refused_and_not_measured() {
    let start = State::at_identity(Covector::<Dd, 3>::zeros());
    let levels = StepLevel::over(Dd::exact(1.0), [1, 2, 4, 8]);
    let target = Target { state: start.clone(), reference_error: (Dd::exact(0.0), Dd::exact(0.0)) };
    let study = Study::new(start).with_attitude();
    let findings = study.descend(|| Spoiling(0), &levels, &vec![target; 4]);
    let refused = findings.rows().iter().map(|row| row.readings.is_err()).collect::<Vec<_>>();
    assert_eq!(refused, [false, false, true, true]);
    assert!(matches!(findings.compare(1), Comparison::Unknown { .. }), "{:?}", findings.compare(1));
}

/// The names that the command knows, with stages up to those of the table.
const NAMED: &str = "euler rk4 kutta38 ralston3 heun2 sdirk2 sdirk3 alexander2 alexander3 gauss-1 gauss-2 gauss-3 gauss-4 gauss-5 gauss-6 \
                     radau-ia-1 radau-ia-2 radau-ia-3 radau-iia-1 radau-iia-2 radau-iia-3 lobatto-iiia-2 lobatto-iiia-3 lobatto-iiia-4 \
                     lobatto-iiib-2 lobatto-iiib-3 lobatto-iiib-4 lobatto-iiic-2 lobatto-iiic-3 lobatto-iiic-4 \
                     lobatto-iiid-2 lobatto-iiid-3 lobatto-iiid-4 lobatto-iiie-2 lobatto-iiie-3 lobatto-iiie-4";

#[test]
fn the_table_of_named_tableaux() {
    let mut table =
        String::from("tableau          literature classical variational measured verdict      assumptions\n");
    for name in NAMED.split(' ') {
        let description: Description = name.parse().unwrap();
        let literature = description.declared().unwrap();
        let analysis = analyse(&description, 12).unwrap();
        let (orders, assumed) = (&analysis.exactly, &analysis.exactly.assumptions);
        let order = orders.variational.order as u32;
        let mut file = problem::generic().unwrap();
        file.case.method.tableau = description;
        let at_least = orders.variational.broken.is_none();
        let judged = Judged::of(&file.case, Digits::ThirtyTwo, 1.0, order, at_least).unwrap();
        assert!(judged.verdict.holds(), "{name}: {}", judged.verdict);
        let (_, _, estimate) = judged.trial.slope(order).unwrap();
        let slope = estimate.slope().unwrap();
        let symplectic = if analysis.symplectic { " symplectic" } else { "" };
        writeln!(
            table,
            "{name:16} {literature:>10} {:>9} {:>11} {slope:>8.1} confirmed    B({}) C({}) D({}), {}{symplectic}, {}",
            orders.classical.order,
            orders.variational.order,
            assumed.b.holds,
            assumed.c.holds,
            assumed.d.holds,
            analysis.shape,
            analysis.stability,
        )
        .unwrap();
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("orders", table));
}

/// An error that is not a number is not left out: no order is read off the others, and nothing counts as exact.
#[test]
fn errors_that_are_not_numbers_are_inconclusive() {
    for missing in [0..0, 3..4, 0..8] {
        let mut findings = Findings::new(vec!["energy".into()], 1);
        for k in 0..8 {
            let h = 0.5f64.powi(k);
            let error = if missing.contains(&k) { f64::NAN } else { h * h };
            findings.push(Row { steps: 1 << k, h, readings: Ok(vec![Reading::new(error, 1e-16, 0.0)]) });
        }
        let (_, verdict) = findings.judge(0, 2);
        assert_eq!(verdict.holds(), missing.is_empty(), "{missing:?}: {verdict}");
        assert!(!findings.is_exact(0) && !verdict.is_broken(), "{missing:?}: {verdict}");
        assert_eq!(matches!(findings.compare(2), Comparison::Unknown { .. }), !missing.is_empty(), "{missing:?}");
    }
}
