//! Properties of `euler_poincare::system`.

#[path = "systems/refuses.rs"]
pub mod refuses;

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::integrators::State;
use euler_poincare::scalar::{Dd, Number, Real, Scalar};
use euler_poincare::system::case::{Algebra, Constant, Inertia, Motion, Potential, Start, Structure, Tau};
use euler_poincare::system::file::{Horizon, example};
use euler_poincare::system::shares::{POTENTIAL_SHARES, SHARES, Share};
use euler_poincare::system::{Case, Cases, Replay, System, SystemFile, Visitor, case, cases, labels};
use euler_poincare::tableau::{Description, Family};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use quickcheck::{Arbitrary as _, Gen, QuickCheck};
use rand::SeedableRng;
use rand::distr::{Distribution, StandardUniform};
use std::collections::{BTreeMap, BTreeSet};

fn runner(seed: u8) -> TestRunner {
    TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]))
}

fn sample(knobs: &Cases, seed: u8, count: usize) -> Vec<Case> {
    let mut runner = runner(seed);
    (0..count).map(|_| knobs.new_tree(&mut runner).expect("the knobs admit cases").current()).collect()
}

/// The momentum at the start.
struct Momentum;

impl<T: Real> Visitor<T> for Momentum {
    type Output = Vec<f64>;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Vec<f64> {
        system.state.momentum.iter().map(|v| v.to_f64()).collect()
    }
}

/// A shorter file than the example, without comments.
const PLAIN: &str = include_str!("systems/wrong/plain.toml");

/// The file with one text replaced, a text in the line that must be named, or behind ^ the text at its caret, and what the message must
/// contain.
const BAD: &str = include_str!("systems/wrong/plain.txt");

#[test]
fn bad_files_are_refused_with_the_line_and_what_is_allowed() {
    refuses::refuses_each(PLAIN, BAD, 108, |line, rest, marker| match marker.strip_prefix('^') {
        Some(text) => rest.starts_with(text),
        None => line.contains(marker) && !marker.is_empty(),
    });
}

#[test]
fn no_truncated_or_garbled_file_panics() {
    let text = example();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)).step_by(7) {
        let _ = SystemFile::parse(&text[..end]).map_err(|e| e.to_string());
    }
    // Every token replaced by things of another type.
    for (start, _) in PLAIN.match_indices(['=', '[', '"', ',', '\n']) {
        for garbage in ["[[[", "\"\"", "-9223372036854775808", "1e400", "{}", "é", "\u{0}", "]"] {
            let text = format!("{}{garbage}{}", &PLAIN[..start], &PLAIN[start + 1..]);
            let _ = SystemFile::parse(&text).map_err(|e| e.to_string());
        }
    }
    assert!(SystemFile::parse(&"[".repeat(100_000)).is_err());
    assert!(SystemFile::parse(&format!("a = {}", "[".repeat(100_000))).is_err());
    assert!(SystemFile::parse(&" ".repeat(2 << 20)).is_err_and(|e| e.message.contains("at most 1048576")));
    let long = PLAIN.replace("so3", &vec!["so3"; 1000].join("+"));
    assert!(SystemFile::parse(&long).is_err_and(|e| e.message.contains("3000")));
}

#[test]
fn the_example_is_the_damped_body_of_the_paper() {
    let file = SystemFile::parse(example()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(file.case.algebra.structure, Structure::Named(Entry::So3));
    assert_eq!(file.case.method.tableau, Description::Family(Family::LobattoIIIA, 3));
    assert_eq!(file.horizon, Horizon::Duration(Number::from(1)));
    assert_eq!(file.plan::<f64>(), Ok((8, None)));
    let momentum = file.case.dispatch::<Dd, _>(Momentum).unwrap_or_else(|e| panic!("{e}"));
    let root = std::f64::consts::FRAC_1_SQRT_2;
    assert_eq!(momentum[..3], [root / 2.0, 0.0, root]);
    // Every commented-out key of the example is one that the schema knows: each parses, or contradicts another key.
    let mut table = None;
    for line in example().lines() {
        // A table that is commented out goes to the next empty line.
        if line.is_empty() || line.starts_with("# [") {
            table = Some(line).filter(|line| !line.is_empty());
        }
        if !(line.starts_with("# ") && line.contains(" = ")) {
            continue;
        }
        let mut text = example().replacen(line, &line[2..], 1);
        if let Some(table) = table {
            text = text.replacen(table, &table[2..], 1);
        }
        let message = SystemFile::parse(&text).map_or_else(|e| e.message, |_| String::new());
        assert!(!message.contains("unknown"), "{line}: {message}");
    }
}

#[test]
fn plans_end_where_the_horizon_says() {
    let plan = |step: &str, horizon: &str| {
        let text = PLAIN.replace("step = \"1/8\"", &format!("step = \"{step}\""));
        let text = text.replace("horizon = 1", &format!("horizon = \"{horizon}\""));
        SystemFile::parse(&text).map(|file| file.plan::<f64>().unwrap_or_else(|e| panic!("{e}")))
    };
    assert_eq!(plan("0.1", "0.3"), Ok((3, None)));
    assert_eq!(plan("1/3", "1"), Ok((3, None)));
    assert_eq!(plan("1/8", "5/16"), Ok((2, Some(0.0625))));
    let long = PLAIN.replace("step = \"1/8\"", "step = 1e308").replace("horizon = 1", "horizon = 10");
    assert!(SystemFile::parse(&long).is_err_and(|error| error.message.contains("at least one step of 1e308")));
    assert!(plan("1", "1/4").is_err_and(|error| error.message.contains("at least one step of 1")));
    assert_eq!(plan("-1/8", "-1"), Ok((8, None)));
}

/// The key of saved failures stands in any file.
#[test]
fn a_dimension_of_any_size_is_an_error() {
    for dimension in ["-1", "1025", "100000000000", "90000000000000000"] {
        let text = format!(
            "format = 1\n[algebra]\ngiven = \"abelian\"\ndimension = {dimension}\n[method]\ntableau = \"gauss-1\"\n\
             retraction = \"exp\"\n[state]\nmomentum = []\n[run]\nstep = 1\nhorizon = 1\n"
        );
        let refused = SystemFile::parse(&text).unwrap_err();
        assert!(refused.line == 4 && refused.message.contains("0 to 1024"), "{refused}");
    }
}

#[test]
fn cases_and_files_round_trip() {
    let mut matrices = 0;
    for (index, case) in sample(&cases(), 3, 200).into_iter().enumerate() {
        let toml = case.to_toml().unwrap_or_else(|e| panic!("{e}"));
        let again = Case::from_toml(&toml).unwrap_or_else(|e| panic!("{e}\n{toml}"));
        // Laws draw numbers from the text: it is the same for a drawn case, of whose algebra much has been asked, and for one from a file.
        assert_eq!((&again, format!("{again:?}")), (&case, format!("{case:?}")), "{toml}");
        matrices += usize::from(matches!(case.algebra.structure, Structure::Matrices { .. }));
        let json = case.to_json().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(serde_json::from_str::<Case>(&json).unwrap_or_else(|e| panic!("{e}\n{json}")), case);
        // A saved case becomes a run when a horizon is added.
        let file =
            SystemFile::parse(&toml.replace("[run]", "[run]\nsteps = 3")).unwrap_or_else(|e| panic!("{e}\n{toml}"));
        let again = SystemFile::parse(&file.to_toml().unwrap_or_else(|e| panic!("{e}")));
        assert_eq!(again.unwrap_or_else(|e| panic!("{e}")), file);
        let fault = (index % 2 == 0).then(|| "wrong-index".to_string());
        let replay = Replay { module: None, law: "casimirs".into(), seed: u64::MAX, index: index as u64, fault, case };
        let json = replay.to_json().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(Replay::from_json(&json).as_ref(), Ok(&replay));
        assert!(Replay::from_json(&json.replacen("\"law\"", "\"lav\"", 1)).is_err());
    }
    assert!(matrices >= 60, "{matrices} of 200 algebras are of matrices");
}

#[test]
fn a_case_prints_in_a_few_lines() {
    for case in sample(&cases(), 4, 50) {
        let text = case.to_string();
        assert_eq!(text.lines().count(), 6, "{text}");
        assert!(text.contains(case.method.retraction.name()) && text.contains(&case.step.to_string()));
    }
}

/// How many cases have each label.
fn counts(list: &[Case]) -> BTreeMap<(&'static str, String), usize> {
    let mut counts = BTreeMap::new();
    for label in list.iter().flat_map(labels) {
        *counts.entry(label).or_insert(0) += 1;
    }
    counts
}

/// The largest probability with which a sound generator fails the test of one label.
const ERROR: f64 = 1e-8;

/// Holds a sample against the declared shares. A generator that has them fails with a probability of at most [`ERROR`] for each
/// label, 10⁻⁶ in all; the seeds are fixed, so that it fails never or always.
fn has_the_declared_shares(list: &[Case], who: &str) {
    let counts = counts(list);
    let seen = |share: &Share| counts.get(&(share.category, share.label.to_string())).copied().unwrap_or(0);
    let mut failing = Vec::new();
    for share in SHARES.iter() {
        if share.surprise(seen(share), list.len()) <= ERROR {
            failing.push(format!("{share:?}: {:.2} %", 100.0 * seen(share) as f64 / list.len() as f64));
        }
    }
    // Which iteration solves the step is found, not drawn: it has no share, but each has to occur.
    for solver in ["fixed-point", "newton", "continuation"] {
        if !counts.contains_key(&("solver", solver.to_string())) {
            failing.push(format!("no step is solved by {solver}"));
        }
    }
    for (category, label) in counts.keys().filter(|(category, _)| *category != "solver") {
        if !SHARES.iter().any(|share| (share.category, share.label) == (*category, label.as_str())) {
            let count = counts[&(*category, label.clone())];
            failing
                .push(format!("{category} {label} is not declared: {:.2} %", 100.0 * count as f64 / list.len() as f64));
        }
    }
    assert!(failing.is_empty(), "{who}, {} cases:\n{}", list.len(), failing.join("\n"));
}

#[test]
fn every_kind_of_case_has_its_declared_share_in_proptest() {
    has_the_declared_shares(&sample(&cases(), 5, 6000), "proptest");
}

#[test]
fn potentials_have_their_declared_shares_and_shrink_away() {
    let knobs = cases().potentials(&Potential::KINDS);
    let list = sample(&knobs, 5, 2000);
    let counts = counts(&list);
    for share in POTENTIAL_SHARES {
        let seen = counts.get(&(share.category, share.label.to_string())).copied().unwrap_or(0);
        assert!(share.surprise(seen, list.len()) > ERROR, "{share:?}: {seen} of {}", list.len());
    }
    assert!(counts.keys().all(|(category, label)| {
        *category != "potential" || POTENTIAL_SHARES.iter().any(|share| share.label == label.as_str())
    }));
    let usual = |case: &&Case| labels(case).contains(&("step", "usual".into()));
    for case in list.iter().filter(|case| !case.potentials.is_empty()).filter(usual).take(40) {
        case.check().unwrap();
        assert!(!cases().admits(case), "without the knob there are none");
        assert_eq!(&serde_json::from_str::<Case>(&case.to_json().unwrap()).unwrap(), case);
        assert!(knobs.simpler(case).any(|simpler| simpler.potentials.len() < case.potentials.len()), "{case}");
    }
    // Without a force and on a free system there is none either.
    assert!(
        sample(&cases().potentials(&Potential::KINDS).force_free(), 5, 50)
            .iter()
            .all(|case| case.potentials.is_empty())
    );
}

#[test]
fn every_kind_of_case_has_its_declared_share_in_rand() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let list: Vec<Case> = cases().sample_iter(&mut rng).take(2000).collect();
    has_the_declared_shares(&list, "rand, Cases");
    let list: Vec<Case> = StandardUniform.sample_iter(&mut rng).take(2000).collect();
    has_the_declared_shares(&list, "rand, StandardUniform");
}

#[test]
fn every_kind_of_case_has_its_declared_share_in_quickcheck() {
    let mut g = Gen::from_size_and_seed(100, 5);
    let list: Vec<Case> = (0..2000).map(|_| Case::arbitrary(&mut g)).collect();
    has_the_declared_shares(&list, "quickcheck");
    // Special integers are frequent in quickcheck; they do not make cases repeat.
    let distinct: BTreeSet<String> = list.iter().map(|case| format!("{case:?}")).collect();
    assert!(distinct.len() >= 1950, "{} of 2000 are distinct", distinct.len());
}

#[test]
fn what_matters_is_common_enough() {
    // In 100 cases, none of a kind with at least 4 % is missed once in sixty times, in 1000 cases never. Less is left for abelian algebras, on
    // which there is little to see, and for half turns, which need a group with rotations: none in 1000 cases is once in 10¹¹ times.
    let matters = "class: abelian nilpotent solvable simple semisimple mixed; unimodular: yes no; \
                   lagrangian: quadratic quartic metric gyrostat gyrostat-quartic; inertia: unit diagonal full thin nearly-unit; \
                   angle: none tiny moderate near-pi; \
                   tableau: gauss lobatto radau classic explicit diagonally-implicit fully-implicit; \
                   force: none double-bracket metriplectic linear-drag quadratic-drag cubic-drag constant periodic polynomial orbit";
    for (category, labels) in matters.split("; ").map(|row| row.split_once(": ").unwrap()) {
        for label in labels.split(' ') {
            let share = SHARES.iter().find(|share| (share.category, share.label) == (category, label));
            let enough = match label {
                "abelian" => 2.5,
                "near-pi" => 3.6,
                _ => 4.0,
            };
            assert!(share.is_some_and(|share| share.least >= enough), "{category} {label}: {share:?}");
        }
    }
    let mut pairs: Vec<_> = SHARES.iter().map(|share| (share.category, share.label)).collect();
    pairs.sort_unstable();
    pairs.dedup();
    assert_eq!(pairs.len(), SHARES.len(), "a share is declared twice");
    // Shares of a category in which a case has one label sum to 100.
    let categories: BTreeSet<_> = SHARES.iter().map(|share| share.category).filter(|name| *name != "force").collect();
    for category in categories {
        let of =
            |end: fn(&Share) -> f64| SHARES.iter().filter(|share| share.category == category).map(end).sum::<f64>();
        let (least, most) = (of(|share| share.least), of(|share| share.most));
        assert!(least <= 100.0 && 100.0 <= most, "{category}: {least} to {most}");
    }
}

#[test]
fn wrong_shares_are_noticed() {
    let share = |share: f64| Share { category: "", label: "", least: share, most: share };
    // 4 % instead of 8 %, 44 % instead of 50 %; and 8 % for 8.1 %.
    assert!(share(8.0).surprise(240, 6000) < ERROR && share(50.0).surprise(2640, 6000) < ERROR);
    assert!(share(8.0).surprise(486, 6000) > 0.5 && share(8.0).surprise(480, 6000) == 1.0);
    assert!(share(8.0).surprise(0, 6000) < ERROR && share(8.0).surprise(6000, 6000) < ERROR);
    assert_eq!(share(0.0).surprise(1, 6000), 0.0);
    // The bound is one: the binomial tail P(S ≥ 20) of n = 100, p = 0.1 is 0.0020.
    let bound = share(10.0).surprise(20, 100);
    assert!((0.0020..0.05).contains(&bound), "{bound}");
    // An interval explains what is in it, and all that is near its ends.
    let wide = Share { least: 5.0, most: 10.0, ..share(0.0) };
    assert_eq!((wide.surprise(7, 100), wide.surprise(20, 100)), (1.0, bound));
}

#[test]
fn a_force_that_vanishes_on_the_case_is_none() {
    let case = |algebra: &str, inertia: &str, kind: &str| {
        let text = format!(
            "format = 1\n[algebra]\nname = \"{algebra}\"\n[lagrangian]\ninertia = {inertia}\n[[force]]\n{kind}\n[method]\n\
             tableau = \"gauss-1\"\nretraction = \"exp\"\n[state]\nmomentum = [1, 1, 1]\n[run]\nstep = \"1/8\"\nsteps = 1\n"
        );
        Case::from_toml(&text).unwrap()
    };
    let (double, metriplectic) = ("kind = \"double-bracket\"\nalpha = 1", "kind = \"metriplectic\"\nbeta = 1");
    let forced = |case: Case| cases().forced().admits(&case);
    // −β ad*_η ad*_η M = 0 on a nilpotent algebra of two steps; Ω×M = 0 on an isotropic body.
    assert!(!forced(case("heisenberg", "[1, 2, 1]", metriplectic)));
    assert!(!forced(case("so3", "[1, 1, 1]", metriplectic)));
    assert!(!forced(case("so3", "[1, 1, 1]", double)));
    assert!(forced(case("heisenberg", "[1, 2, 1]", double)));
    assert!(forced(case("so3", "[1, 2, 1]", metriplectic)));
}

#[test]
fn knobs_hold_for_generated_and_for_shrunk_cases() {
    let order = || cases().forced_nonabelian().smooth().with_group().retraction(Tau::Cayley).dimension_at_most(6);
    let gauss =
        proptest::sample::select(vec![Description::Family(Family::Gauss, 2), Description::Family(Family::Gauss, 3)]);
    let all = [
        order(),
        cases().force_free().quadratic().changed_basis(true),
        cases().algebras(&[Entry::Se3, Entry::Sl2]).changed_basis(false).with_tableaux(gauss).steps(3, 4),
        cases().forced().retraction(Tau::Exponential),
        cases().fast(),
        cases().kinetic(),
    ];
    for (i, knobs) in all.into_iter().enumerate() {
        let mut runner = runner(6 + i as u8);
        for _ in 0..30 {
            let mut tree = knobs.new_tree(&mut runner).unwrap_or_else(|e| panic!("{i}: {e}"));
            let mut moves = 0;
            loop {
                let case = tree.current();
                assert!(knobs.admits(&case), "{i}\n{case}");
                assert_eq!(case.check(), Ok(()), "{i}\n{case}");
                if i == 2 {
                    assert!(matches!(case.method.tableau, Description::Family(Family::Gauss, 2 | 3)));
                    assert!([8.0, 16.0].contains(&(1.0 / case.step.eval::<f64>().unwrap_or(0.0))));
                }
                moves += 1;
                // Walk down, refusing every third candidate.
                if moves > 60 || !(if moves % 3 == 0 { tree.complicate() } else { tree.simplify() }) {
                    break;
                }
            }
        }
    }
}

fn nonabelian(case: &Case) -> bool {
    labels(case).iter().any(|(name, value)| *name == "class" && value != "abelian")
}

/// The simplest case that is broken, as proptest finds it.
fn shrunk(tree: impl ValueTree<Value = Case>, broken: impl Fn(&Case) -> bool) -> Case {
    let config = Config { max_shrink_iters: 20_000, ..Config::default() };
    let sound = |case: Case| if broken(&case) { Err(TestCaseError::fail("broken")) } else { Ok(()) };
    match TestRunner::new(config).run_one(tree, sound) {
        Err(TestError::Fail(_, case)) => case,
        other => panic!("{other:?}"),
    }
}

#[test]
fn shrinking_reaches_the_simplest_case() {
    let mut runner = runner(11);
    for _ in 0..40 {
        let case = shrunk(cases().new_tree(&mut runner).unwrap_or_else(|e| panic!("{e}")), |_| true);
        let text = case.to_toml().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(case.algebra.structure, Structure::Named(Entry::Abelian(1)), "{text}");
        assert_eq!(case.algebra.basis, None);
        assert_eq!(case.lagrangian, case::Lagrangian::new(Inertia::Diagonal(vec![Number::from(1)])));
        assert!(case.forces.is_empty() && case.start.attitude.is_none());
        assert_eq!(case.method.tableau, Description::Family(Family::Gauss, 1));
        assert_eq!(case.method.retraction, Tau::Exponential);
        assert_eq!(case.start.motion, Motion::Momentum(vec![Number::from(0)]));
        assert_eq!(case.step, Number::ratio(1, 64));
    }
}

#[test]
fn shrinking_keeps_what_breaks_and_drops_the_rest() {
    let mut runner = runner(12);
    // A fault that needs a non-abelian algebra, a force and two stages.
    let stages = |case: &Case| case.method.tableau.stages() >= 2;
    let broken = |case: &Case| stages(case) && nonabelian(case) && !case.forces.is_empty();
    let mut seen = 0;
    while seen < 15 {
        let tree = cases().new_tree(&mut runner).unwrap_or_else(|e| panic!("{e}"));
        if !broken(&tree.current()) {
            continue;
        }
        seen += 1;
        let case = shrunk(tree, broken);
        assert_eq!(case.algebra.structure, Structure::Named(Entry::Aff1), "{case}");
        assert_eq!((case.forces.len(), case.algebra.basis.is_none()), (1, true), "{case}");
        assert_eq!(case.lagrangian.inertia, Inertia::Diagonal(vec![Number::from(1); 2]), "{case}");
    }
}

#[test]
fn generated_numbers_are_dyadic() {
    for case in sample(&cases(), 13, 300) {
        let (Motion::Velocity(list) | Motion::Momentum(list)) = &case.start.motion;
        let lagrangian = &case.lagrangian;
        let mut forms: Vec<&Number> = lagrangian.gyrostat.iter().flatten().collect();
        for form in [&lagrangian.inertia].into_iter().chain(&lagrangian.metric) {
            match form {
                Inertia::Diagonal(list) => forms.extend(list),
                Inertia::Full(rows) => forms.extend(rows.iter().flatten()),
            }
        }
        for x in list.iter().chain(forms).chain([&case.step]).chain(case.algebra.basis.iter().flatten().flatten()) {
            let value = x.eval::<f64>().unwrap_or(f64::NAN);
            assert_eq!((value * 65_536.0 * 65_536.0).fract(), 0.0, "{x}\n{case}");
            assert_eq!(x.eval::<Dd>().map(|v| (v.hi(), v.lo())), Ok((value, 0.0)), "{x}\n{case}");
        }
    }
}

#[test]
fn a_chosen_part_stays_and_the_rest_is_random() {
    // A part of each kind, on so(3).
    let mine = Case::from_toml(include_str!("systems/cases/parts.toml")).unwrap_or_else(|e| panic!("{e}"));
    let of = |constants: &[(usize, usize, usize, i64, i64)]| {
        let constant = |&(a, b, c, p, q): &_| Constant { a, b, c, value: Number::ratio(p, q) };
        let constants = constants.iter().map(constant).collect();
        Algebra { structure: Structure::Constants { dimension: 3, constants }, basis: None }
    };
    let bianchi = of(&[(1, 2, 2, 1, 2), (1, 2, 3, 1, 1), (1, 3, 2, -1, 1), (1, 3, 3, 1, 2)]);
    type Part = fn(&Case, &Case) -> bool;
    let fixed: [(Cases, Part); 8] = [
        (cases().algebra(mine.algebra.clone()), |a, b| a.algebra == b.algebra),
        (cases().lagrangian(mine.lagrangian.clone()), |a, b| a.lagrangian == b.lagrangian),
        (cases().forces(mine.forces.clone()), |a, b| a.forces == b.forces),
        (cases().forces(Vec::new()).nonabelian(), |a, _| a.forces.is_empty()),
        (cases().tableau(mine.method.tableau.clone()), |a, b| a.method.tableau == b.method.tableau),
        (cases().start(mine.start.clone()), |a, b| a.start == b.start),
        (cases().step(mine.step.clone()), |a, b| a.step == b.step),
        (cases().algebra(bianchi).forced(), |a, _| a.algebra.basis.is_none() && a.dimension() == 3),
    ];
    for (i, (knobs, same)) in fixed.iter().enumerate() {
        let mut runner = runner(20 + i as u8);
        let mut seen = BTreeSet::new();
        for _ in 0..25 {
            let mut tree = knobs.new_tree(&mut runner).unwrap_or_else(|e| panic!("{i}: {e}"));
            let case = tree.current();
            assert!(same(&case, &mine) && knobs.admits(&case), "{i}\n{case}");
            assert_eq!(case.check(), Ok(()), "{i}\n{case}");
            seen.insert(case.to_string());
            // It stays on the way down too.
            for _ in 0..6 {
                if !tree.simplify() {
                    break;
                }
                assert!(same(&tree.current(), &mine), "{i}\n{}", tree.current());
            }
            for simpler in knobs.simpler(&case).take(10) {
                assert!(same(&simpler, &mine), "{i}\n{simpler}");
            }
        }
        assert!(seen.len() > 20, "{i}: the rest is not random");
    }
    // All parts at once are one case, however fast it is; and parts that do not fit are none.
    let all = cases().algebra(mine.algebra.clone()).lagrangian(mine.lagrangian.clone()).forces(mine.forces.clone());
    let all = all.start(mine.start.clone()).step(mine.step.clone()).tableau(mine.method.tableau.clone());
    assert_eq!(sample(&all.retraction(Tau::Cayley), 30, 1)[0], mine);
    for none in [
        // With a centre: no group.
        cases().algebra(of(&[(1, 2, 3, 1, 1)])).with_group(),
        cases().algebra(mine.algebra.clone()).dimension_at_most(2),
        cases().lagrangian(mine.lagrangian.clone()).algebras(&[Entry::Se3]),
        cases().forces(mine.forces.clone()).force_free(),
        cases().lagrangian(mine.lagrangian.clone()).start(Start::moving(Motion::Momentum(vec![Number::from(1); 2]))),
    ] {
        assert!(none.new_tree(&mut runner(31)).is_err());
        assert!(none.try_sample(&mut rand_chacha::ChaCha8Rng::seed_from_u64(1)).is_err());
    }
}

#[test]
fn quickcheck_runs_and_shrinks_cases() {
    let mut quick = QuickCheck::new().rng(Gen::from_size_and_seed(100, 5)).tests(50);
    let read: fn(Case) -> bool = |case| Case::from_toml(&case.to_toml().unwrap()).is_ok_and(|again| again == case);
    assert!(matches!(quick.quicktest(read), Ok(50)));
    let mut witness = |property: fn(Case) -> bool| format!("{:?}", quick.quicktest(property).unwrap_err());
    for _ in 0..5 {
        let (any, curved) = (witness(|_| false), witness(|case| !nonabelian(&case)));
        assert!(any.contains("structure: Named(Abelian(1))") && any.contains("tableau: Family(Gauss, 1)"), "{any}");
        assert!(curved.contains("structure: Named(Aff1)"), "{curved}");
    }
}

proptest::proptest! {
    #![proptest_config(Config::with_cases(20))]

    /// The strategies behind proptest's `any`.
    #[test]
    fn any_case(
        case in proptest::arbitrary::any::<Case>(),
        forced in proptest::arbitrary::any_with::<Case>(cases().forced()),
    ) {
        proptest::prop_assert_eq!(case.check(), Ok(()));
        proptest::prop_assert!(!forced.forces.is_empty());
    }
}

#[test]
fn a_state_is_saved_and_read() {
    let state: State<f64, 2, 2> = State::new([0.1, -2.0].into(), [[1.0, 3.0], [2.0, 4.0]].into()).at_time(0.25);
    let text = serde_json::to_string(&state).unwrap();
    assert_eq!(text, r#"{"time":0.25,"momentum":[0.1,-2.0],"attitude":[[1.0,2.0],[3.0,4.0]]}"#);
    assert_eq!(serde_json::from_str::<State<f64, 2, 2>>(&text).unwrap(), state);
    let long = serde_json::from_str::<State<f64, 3, 2>>(&text).unwrap_err().to_string();
    let wide = serde_json::from_str::<State<f64, 2, 3>>(&text).unwrap_err().to_string();
    assert!(long.contains("3 components of μ") && wide.contains("not a 3×3 matrix"), "{long}, {wide}");
    // In more digits, all of them.
    let fine: State<Dd, 1, 1> = State::at_identity([Dd::ratio(1, 3)].into()).at_time(Dd::ratio(1, 2));
    let text = serde_json::to_string(&fine).unwrap();
    assert!(text.starts_with(r#"{"time":"0.5","momentum":["3.3333333333333333333333333333333"#), "{text}");
    assert_eq!(serde_json::from_str::<State<Dd, 1, 1>>(&text).unwrap(), fine);
}
