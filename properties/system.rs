//! Properties of `euler_poincare::system`.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::mechanics::Force as _;
use euler_poincare::retraction::Retraction;
use euler_poincare::scalar::{Dd, Number, Real};
use euler_poincare::system::case::{Inertia, Motion, Structure, Tau};
use euler_poincare::system::file::{Horizon, example};
use euler_poincare::system::{Case, Cases, Replay, System, SystemFile, Visitor, cases, labels};
use euler_poincare::tableau::{Description, Family};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::BTreeMap;

fn runner(seed: u8) -> TestRunner {
    TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]))
}

fn sample(knobs: &Cases, seed: u8, count: usize) -> Vec<Case> {
    let mut runner = runner(seed);
    (0..count).map(|_| knobs.new_tree(&mut runner).expect("the knobs admit cases").current()).collect()
}

/// What two scalars must agree on: momentum, attitude, step, force at a velocity, all structure constants.
struct Numbers;

impl<T: Real> Visitor<T> for Numbers {
    type Output = Vec<f64>;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>>(self, system: System<T, N, D, R>) -> Vec<f64> {
        let mut values: Vec<T> = system.state.momentum.iter().copied().collect();
        values.extend(system.state.attitude.iter());
        values.extend([system.step, system.state.time]);
        let eta = euler_poincare::algebra::Vector::<T, N>::from_fn(|a, _| T::ratio(1 + a as i64, 8));
        values.extend(system.force.force(system.state.time, &eta).iter());
        for a in 0..N {
            for b in 0..N {
                values.extend((0..N).map(|c| system.algebra.constant(a, b, c)));
            }
        }
        values.extend(system.tableau.a().iter());
        values.extend(system.casimirs.iter().map(|casimir| casimir.value(&system.state.momentum)));
        values.into_iter().map(|v| v.to_f64()).collect()
    }
}

#[test]
fn every_case_builds_in_both_scalars_and_means_the_same() {
    for case in sample(&cases(), 1, 600) {
        let short = case.dispatch::<f64, _>(Numbers).unwrap_or_else(|e| panic!("{e}\n{case}"));
        let long = case.dispatch::<Dd, _>(Numbers).unwrap_or_else(|e| panic!("{e}\n{case}"));
        let size = long.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
        for (x, y) in short.iter().zip(&long) {
            // A few hundred roundings, amplified by the condition of a basis change (some tens) at most.
            assert!((x - y).abs() <= 1e4 * f64::EPSILON * size, "{x} {y}\n{case}");
        }
    }
}

#[test]
fn explore() {
    let t = std::time::Instant::now();
    let list = sample(&cases(), 2, 4000);
    println!("{:?}", t.elapsed());
    let mut counts: BTreeMap<(&str, String), usize> = BTreeMap::new();
    for case in &list {
        for label in labels(case) {
            *counts.entry(label).or_default() += 1;
        }
        *counts.entry(("step", case.step.to_string())).or_default() += 1;
    }
    for ((k, v), n) in counts {
        println!("{k:12} {v:20} {:.1}", 100.0 * n as f64 / 4000.0);
    }
    for case in &list[..6] {
        println!("{case}\n{}", case.to_toml().unwrap());
    }
    let mut runner = runner(3);
    for _ in 0..5 {
        let mut tree = cases().new_tree(&mut runner).unwrap();
        let mut n = 0;
        while tree.simplify() {
            n += 1;
        }
        println!("{n}\n{}", tree.current());
    }
    match SystemFile::parse(example()) {
        Ok(f) => println!("{}\n{:?}", f.case, f.plan::<f64>()),
        Err(e) => println!("{e}"),
    }
}
