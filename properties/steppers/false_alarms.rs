//! The false alarms of the laws of methods: correct methods, each with the claims that are true of it, on random systems.
//!
//! `cargo run --example false_alarms -- FILE SEEDS CASES ORDER_SEEDS`: seeds 1 to SEEDS with CASES cases each for the laws of balance and
//! reversibility, seeds 1 to ORDER_SEEDS for the law of the order. Writes a line of CSV for each method and law to FILE, anew
//! after each seed, and prints what is broken. Exits with 1 if anything is.

mod methods;

use euler_poincare::harness::{Verdict, draw};
use euler_poincare::laws::method::{Claims, LAWS, check_case};
use euler_poincare::scalar::Dd;
use euler_poincare::system::cases;
use euler_poincare::tableau::{Description, Family, variational_order};
use methods::{Engine, Method};
use proptest::strategy::{Just, Strategy};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::process::ExitCode;
use std::sync::Mutex;

/// A method, and what is true of it.
struct Subject {
    name: &'static str,
    method: Method,
    claims: Claims,
}

/// The methods. The variational ones keep Casimirs without force, whatever their tableau. With a force they are not reversible, which the
/// classical Gauss methods are.
fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let plain = |order| Claims { order: Some(order), ..Claims::default() };
    let reversible = |order| Claims { reversible: true, ..plain(order) };
    let mut methods = Vec::new();
    for (name, engine, tableau, claims) in [
        ("rk4", Engine::Classical, "rk4", plain(4)),
        ("rkmk4", Engine::MuntheKaas, "rk4", plain(4)),
        ("classical-radau-iia-3", Engine::Classical, "radau-iia-3", plain(5)),
        ("classical-gauss-2", Engine::Classical, "gauss-2", reversible(4)),
        ("classical-gauss-4", Engine::Classical, "gauss-4", reversible(8)),
    ] {
        methods.push(Subject { name, method: Method(engine, tableau.parse::<Description>()?.build()?), claims });
    }
    let variational = "gauss-1 gauss-2 gauss-3 gauss-4 lobatto-iiia-3 lobatto-iiib-3 radau-iia-2 radau-iia-3";
    for name in variational.split(' ') {
        let tableau: Description = name.parse()?;
        let order = variational_order(&tableau.build::<Dd>()?, 9).order as u32;
        let claims = Claims { casimirs: true, ..plain(order) };
        methods.push(Subject { name, method: Method(Engine::Variational, tableau.build()?), claims });
    }
    Ok(methods)
}

/// Of each method and law: seeds, cases, held, broken, inconclusive, not applicable.
type Counts = BTreeMap<(usize, usize), [usize; 6]>;

fn table(methods: &[Subject], counts: &Counts) -> String {
    let mut text = String::from("method,law,seeds,cases,held,broken,inconclusive,not_applicable\n");
    for ((method, law), [seeds, rest @ ..]) in counts {
        let rest = rest.map(|count| count.to_string()).join(",");
        let _ = writeln!(text, "{},{},1-{seeds},{rest}", methods[*method].name, LAWS[*law].about.name);
    }
    text
}

/// Counts the verdicts on the cases of one seed.
fn judge(methods: &[Subject], law: usize, seed: u64, cases_each: usize) -> Counts {
    // Little of a draw depends on the tableau, which is the method's.
    let base = cases().with_group().main_dimensions().with_tableaux(Just(Description::Family(Family::Gauss, 1)));
    let (law_of, mut counts) = (&LAWS[law], Counts::new());
    let strategy = law_of.cases(base).boxed();
    for index in 0..cases_each {
        let Ok((case, _)) = draw(&strategy, seed, law_of.about.name, index).case else { continue };
        for (k, method) in methods.iter().enumerate() {
            let verdict = check_case(law_of, &method.method, &case, &method.claims).verdict;
            let kind = match &verdict {
                Verdict::Holds { .. } => 2,
                Verdict::Broken { .. } => 3,
                Verdict::Inconclusive { .. } => 4,
                Verdict::NotApplicable { .. } => 5,
            };
            if verdict.is_broken() {
                println!("BROKEN {} {} seed {seed} case {index}: {verdict}", method.name, law_of.about.name);
            }
            let count = counts.entry((k, law)).or_default();
            count[0] = 1;
            count[1] += 1;
            count[kind] += 1;
        }
    }
    counts
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, seeds, cases_each, order] = &arguments[..] else {
        return Err("usage: false_alarms FILE SEEDS CASES ORDER_SEEDS".into());
    };
    let (seeds, cases_each, order): (u64, usize, u64) = (seeds.parse()?, cases_each.parse()?, order.parse()?);
    let (methods, all) = (subjects()?, Mutex::new(Counts::new()));
    // The order; Casimirs, energy and reversibility.
    let jobs = (1..=seeds.max(order)).flat_map(|seed| [0, 1, 2, 3].map(|law| (law, seed)));
    let jobs: Vec<_> = jobs.filter(|(law, seed)| *seed <= if *law == 0 { order } else { seeds }).collect();
    jobs.par_iter().with_max_len(1).try_for_each(|&(law, seed)| {
        let found = judge(&methods, law, seed, cases_each);
        let mut counts = all.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for (key, new) in found {
            counts.entry(key).or_default().iter_mut().zip(new).for_each(|(sum, count)| *sum += count);
        }
        eprintln!("{} seed {seed}", LAWS[law].about.name);
        std::fs::write(file, table(&methods, &counts))
    })?;
    let counts = all.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    print!("{}", table(&methods, &counts));
    let broken = counts.values().any(|count| count[3] > 0);
    Ok(if broken { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
