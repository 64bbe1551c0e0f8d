//! What the check of a cheap law costs, on one fixed case.

use criterion::{Criterion, criterion_group, criterion_main};
use euler_poincare::laws;
use euler_poincare::system::SystemFile;
use euler_poincare::system::file::example;
use std::hint::black_box;

/// A cheap law of every kind, on the example.
const LAWS: [&str; 10] = [
    "retraction-tangent",
    "groupoid-gauge",
    "algebroid-bracket",
    "poisson-bracket",
    "lie-poisson-bracket",
    "first-variation",
    "legendre-intertwines",
    "discrete-slopes",
    "doubled-step-generated",
    "plain-step",
];

fn law(criterion: &mut Criterion) {
    let case = SystemFile::parse(example()).expect("the example is a system file").case;
    let mut group = criterion.benchmark_group("law");
    for law in LAWS.map(|name| laws::named(name).expect("the name of a law")) {
        assert!((law.check)(&case, None).holds(), "{}", law.about.name);
        group.bench_function(law.about.name, |bencher| bencher.iter(|| (law.check)(black_box(&case), None)));
    }
    group.finish();
}

criterion_group!(benches, law);
criterion_main!(benches);
