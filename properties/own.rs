//! `euler_poincare::laws!` on types of a user's own: they hold, and each mistake is found by a law that names it.

mod numerics;
mod placed;
mod readme;
mod types;

use self::types::{Bianchi, Midpoint, Split, SplitMap, Stiff, Wind};
use super::parts::discrete::stages;
use super::parts::groupoid::{Intervals, Plane};
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::laws;
use euler_poincare::laws::method::Claims;
use euler_poincare::laws::user::{FromMap, Map, Outcome, Suite, SuiteSettings};
use euler_poincare::mechanics::given::{GivenForce, GivenLagrangian, UntypedForce, UntypedLagrangian};
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::beside::BesideRetraction;
use euler_poincare::retraction::{Retraction, RetractionError, TangentPoint};
use euler_poincare::scalar::{Dual, Real, Scalar};
use euler_poincare::suite;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::process::Command;

laws! {
    mod bianchi<T, 3, 3> {
        group: Bianchi::<T>::new(false),
        retraction: Split::<T>::new(false),
        lagrangian: Stiff { wrong: false },
        force: Wind { wrong: false },
        method: |system| Midpoint { system, wrong: false },
        claims: Claims { order: Some(2), ..Claims::default() },
    }
}

laws! {
    mod from_map<T, 3, 3> {
        group: Bianchi::<T>::new(false),
        map: SplitMap,
    }
}

laws! {
    mod intervals<T> { groupoid: Intervals::<T>("nothing", PhantomData) }
}

laws! {
    mod plane<T> { lie_groupoid: Plane::<T> { lost: false, added: T::zero() } }
}

laws! {
    mod rule<T, 3, 3> { discrete: stages::<T>(1), claims: [antisymmetric] }
}

// The same with a mistake in each.
suite! {
    mod wrong<T, 3, 3> {
        group: Bianchi::<T>::new(true),
        retraction: Split::<T>::new(true),
        lagrangian: Stiff { wrong: true },
        force: Wind { wrong: true },
        method: |system| Midpoint { system, wrong: true },
        claims: Claims { order: Some(2), ..Claims::default() },
    }
}

/// A folder of its own for the saved cases of one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("own-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// The law is broken; the report says what a person needs, the case is saved, and replayed first.
fn found(suite: &Suite, law: &str) {
    let folder = folder(law);
    let settings = SuiteSettings { regressions: Some(folder.clone()), ..SuiteSettings::new() };
    let broken = |settings: &SuiteSettings| match suite.run(law, settings) {
        Outcome::Broken(broken) => *broken,
        other => panic!("{law} does not see the mistake: {other:?}"),
    };
    let first = broken(&settings);
    let report = first.to_string();
    let replay = format!("{law}-");
    for part in
        [law, first.about.statement, first.about.source, "16 digits", "32 digits", "EULER_POINCARE_REPLAY=", &replay]
    {
        assert!(report.contains(part), "{part} is not in the report:\n{report}");
    }
    assert!((1..12).contains(&first.case.lines().count()), "{}", first.case);
    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    let again = broken(&SuiteSettings { cases: 0, ..settings.clone() });
    assert!(again.origin.starts_with("as saved in"), "{}", again.origin);
    assert_eq!((again.verdict, again.case), (first.verdict.clone(), first.case.clone()));
    let alone = SuiteSettings { replay: Some(files[0].clone()), regressions: None, ..settings };
    assert_eq!(broken(&alone).verdict, first.verdict);
    for other in suite.names().into_iter().filter(|name| *name != law) {
        assert!(matches!(suite.run(other, &alone), Outcome::Skipped), "{other}");
    }
}

#[test]
fn each_mistake_is_found() {
    for law in ["group-inverse", "retraction-second-tangent", "lagrangian-gradient", "force-derivatives"] {
        found(&wrong::suite(), law);
    }
}

#[test]
fn a_force_at_the_wrong_time_is_found() {
    // An order has levels, in 32 digits alone.
    let outcome = wrong::suite().run("method-order", &SuiteSettings::new());
    let Outcome::Broken(broken) = outcome else { panic!("{outcome:?}") };
    let report = broken.to_string();
    assert!(report.contains("method-order") && report.contains("32 digits"), "{report}");
}

/// Its tangents and its inverse are judged by the laws of the suite `from_map`.
#[test]
fn a_map_without_a_preimage_says_so() {
    let derived = FromMap::new(SplitMap, Bianchi::<f64>::new(false));
    let error = Retraction::<f64, 3, 3>::tau_inv(&derived, &Matrix::<f64, 3>::zeros()).unwrap_err();
    assert!(matches!(error, RetractionError::NoPreimage { .. } | RetractionError::SingularTangent { .. }), "{error}");
}

/// Maps on SO(3), of one type: each type is compiled with all its derivatives.
#[derive(Clone, Copy)]
enum OwnMap {
    /// τ(x) = exp(x_1 e_1) exp(x_2 e_2) exp(x_3 e_3). τ(−x) is not τ(x)⁻¹, which has the factors in the other order: it is no
    /// retraction of the kind that is needed.
    SecondKind,
    /// exp(x_3 e_3/2) … exp(x_1 e_1) … exp(x_3 e_3/2), which is.
    Symmetric,
    /// exp as 1 + (sin θ/θ) x̂ + A x̂².
    Rotation(numerics::Second),
}

impl<T: Real> Map<T, 3, 3> for OwnMap {
    fn map<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Option<Matrix<S, 3>> {
        match *self {
            Self::SecondKind => Some(turn(0, x[0]) * turn(1, x[1]) * turn(2, x[2])),
            Self::Symmetric => {
                let (outer, inner) = (turn(2, x[2] * S::half()), turn(1, x[1] * S::half()));
                Some(outer * inner * turn(0, x[0]) * inner * outer)
            }
            Self::Rotation(second) => Some(second.rotation(x)),
        }
    }
}

fn turn<S: Scalar>(axis: usize, angle: S) -> Matrix<S, 3> {
    let (a, b, (sin, cos)) = ((axis + 1) % 3, (axis + 2) % 3, angle.sin_cos());
    let mut turn = Matrix::<S, 3>::identity();
    (turn[(a, a)], turn[(a, b)], turn[(b, a)], turn[(b, b)]) = (cos, -sin, sin, cos);
    turn
}

suite! {
    mod second_kind<T, 3, 3> { group: So3::<T>::new(), map: OwnMap::SecondKind }
}

suite! {
    mod symmetric_kind<T, 3, 3> { group: So3::<T>::new(), map: OwnMap::Symmetric }
}

#[test]
fn coordinates_of_the_second_kind_are_refused() {
    let settings = SuiteSettings { cases: 40, ..SuiteSettings::new() };
    for law in ["retraction-inverse", "retraction-adjoint"] {
        let Outcome::Broken(broken) = second_kind::suite().run(law, &settings) else { panic!("{law} does not see it") };
        assert!(broken.to_string().contains("τ(−ξ)") || law == "retraction-adjoint", "{broken}");
        let outcome = symmetric_kind::suite().run(law, &settings);
        assert!(!matches!(outcome, Outcome::Broken(_)), "{outcome:?}");
    }
    // What is right about it is right: its tangents are those of the map.
    for law in ["retraction-tangent", "retraction-inverse-tangent", "retraction-second-tangent"] {
        let outcome = second_kind::suite().run(law, &settings);
        assert!(!matches!(outcome, Outcome::Broken(_)), "{law}: {outcome:?}");
    }
}

#[test]
fn every_law_of_a_suite_is_a_test() {
    let list = Command::new(std::env::current_exe().unwrap()).arg("--list").output().unwrap();
    let list = String::from_utf8(list.stdout).unwrap();
    let suites = [
        ("bianchi", bianchi::suite()),
        ("from_map", from_map::suite()),
        ("intervals", intervals::suite()),
        ("plane", plane::suite()),
        ("rule", rule::suite()),
    ];
    for (module, suite) in suites {
        for law in suite.names() {
            let test = format!("own::{module}::{}: test", law.replace('-', "_"));
            let claimed = ["force-dissipates", "force-workless", "force-keeps-casimirs"].contains(&law);
            assert!(claimed || list.lines().any(|line| line == test), "{test}");
        }
    }
}

#[test]
fn what_is_no_case_of_a_law_is_refused() {
    let folder = folder("refused");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("group-inverse-00000000.json");
    std::fs::write(&file, "{\"law\": \"group-inverse\"}").unwrap();
    let settings = SuiteSettings { regressions: Some(folder), ..SuiteSettings::new() };
    let Outcome::Broken(broken) = bianchi::suite().run("group-inverse", &settings) else { panic!() };
    assert!(broken.to_string().contains("is no case of this law: missing field"), "{broken}");
    let Outcome::Undecided { why } = bianchi::suite().run("group-law", &settings) else { panic!() };
    assert_eq!(why, "there is no law called `group-law` on these types");
}

#[test]
fn the_readme_shows_what_is_tested() {
    let readme = include_str!("../README.md");
    let (_, block) = include_str!("own/readme.rs").split_once("\n\n").unwrap();
    assert!(readme.contains(block), "the block of the README is that of own/readme.rs");
    assert!(readme.len() <= 8192, "{} bytes", readme.len());
    let laws = euler_poincare::laws::all().len();
    assert!(
        readme.contains(&format!("checks {laws} laws")) && readme.contains(&format!("laws-{laws}-")),
        "{laws} laws"
    );
}

/// x + ε δ, twice.
fn twice(x: &Vector<f64, 3>, delta: &Vector<f64, 3>) -> Vector<Dual<Dual<f64>>, 3> {
    x.zip_map(delta, |x, d| Dual { re: Dual { re: x, eps: d }, eps: Dual { re: d * d, eps: x - d } })
}

/// All four numbers of each entry.
fn numbers<'a>(values: impl IntoIterator<Item = &'a Dual<Dual<f64>>>) -> Vec<f64> {
    values.into_iter().flat_map(|v| [v.re.re, v.re.eps, v.eps.re, v.eps.eps]).collect()
}

/// Behind a pointer, beside spectators, every number is the same: values, derivatives, and derivatives of these.
#[test]
fn what_stands_behind_a_pointer_is_what_it_was() {
    let (x, delta) = (Vector::<f64, 3>::new(0.3, -0.2, 0.4), Vector::<f64, 3>::new(0.5, 1.5, -0.25));
    let jet = twice(&x, &delta);

    let plain = Split::<f64>::new(false);
    let given = BesideRetraction::<f64, 3, 3>::whole(Split::<f64>::new(false));
    let slope = x.zip_map(&delta, |re, eps| Dual { re, eps });
    let (g, same) = (plain.tau(&slope).unwrap(), given.tau(&slope).unwrap());
    assert!(g.iter().zip(&same).all(|(a, b)| (a.re, a.eps) == (b.re, b.eps)));
    let element = g.map(|v| Dual { re: v, eps: Dual { re: v.eps, eps: v.re } });
    assert_eq!(numbers(&plain.tau_inv(&element).unwrap()), numbers(&given.tau_inv(&element).unwrap()));
    let (here, there) = (plain.at(&x).unwrap(), given.at(&x).unwrap());
    let of_plain = [*here.d(), *here.d_inv(), here.d_neg(), here.ad(), here.ad_inv(), here.dd(&delta)];
    let of_given = [*there.d(), *there.d_inv(), there.d_neg(), there.ad(), there.ad_inv(), there.dd(&delta)];
    assert_eq!(of_plain, of_given);
    let (p, m) = (delta.transpose(), x.transpose());
    assert_eq!(here.pull_dd(&p, &m, &delta), there.pull_dd(&p, &m, &delta));

    // Two spectators, which are at rest: they add nothing.
    let rest = |v: &Vector<Dual<Dual<f64>>, 3>| {
        Vector::<Dual<Dual<f64>>, 5>::from_fn(|a, _| if a < 3 { v[a] } else { Dual::default() })
    };
    let time = Dual { re: Dual::variable(0.5), eps: Dual::constant(2.0) };
    let force = GivenForce::<f64, 5>::new(UntypedForce::new::<3>(Wind { wrong: false }), 3, 0);
    let padded = |v: Vec<f64>| v.into_iter().chain([0.0; 8]).collect::<Vec<_>>();
    assert_eq!(numbers(&force.force(time, &rest(&jet))), padded(numbers(&Wind { wrong: false }.force(time, &jet))));
    let plain = Stiff { wrong: false };
    let given = GivenLagrangian::<f64, 5>::new(UntypedLagrangian::new::<3>(Stiff { wrong: false }), 3, 0);
    assert_eq!(numbers([&given.value(&rest(&jet))]), numbers([&Lagrangian::<f64, 3>::value(&plain, &jet)]));
    let gradient: Covector<Dual<Dual<f64>>, 3> = Lagrangian::<f64, 3>::gradient(&plain, &jet);
    assert_eq!(numbers(&given.gradient(&rest(&jet))), padded(numbers(&gradient)));
    let moving = Vector::<f64, 5>::new(0.3, -0.2, 0.4, 2.0, -1.0);
    assert_eq!(given.value(&moving), Lagrangian::<f64, 3>::value(&plain, &x) + 2.5, "spectators have unit inertia");
    assert_eq!(given.velocity(&given.gradient(&moving), &Vector::zeros()).map(|v| (v[3], v[4])), Ok((2.0, -1.0)));
}
