//! What the check of a cheap law costs, on one fixed case.

use criterion::{Criterion, criterion_group, criterion_main};
use euler_poincare::harness::Cost;
use euler_poincare::laws;
use euler_poincare::system::SystemFile;
use euler_poincare::system::file::example;
use std::hint::black_box;

/// The first cheap law of every module that applies to the example.
fn law(criterion: &mut Criterion) {
    let case = SystemFile::parse(example()).expect("the example is a system file").case;
    let mut group = criterion.benchmark_group("law");
    let modules = [laws::retraction::LAWS, laws::groupoid::LAWS, laws::mechanics::LAWS, laws::integrators::LAWS];
    for module in modules {
        let holds = |law: &&laws::CaseLaw| law.cost == Cost::Cheap && (law.check)(&case, None).holds();
        if let Some(law) = module.iter().find(holds) {
            group.bench_function(law.name, |bencher| bencher.iter(|| (law.check)(black_box(&case), None)));
        }
    }
    group.finish();
}

criterion_group!(benches, law);
criterion_main!(benches);
