//! The laws on random cases until the first that fails: what `mutants/run.py` runs on a mutant first.
//!
//! Arguments: the seed and the number of cases per law. Index-major, so that each law sees a case before any sees two.
//! Prints the law that fails and why, and exits with 1; exits with 0 when none does. The criteria are those of
//! `properties/laws.rs`: nothing broken, at most one case in twenty inconclusive, more than half of the cases held.

use euler_poincare::harness::Law;
use euler_poincare::harness::{Cost, Verdict, draw, verdict_on};
use euler_poincare::laws;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>().expect("two numbers"));
    let (seed, cases) = (arguments.next().expect("the seed") as u64, arguments.next().expect("the number of cases"));
    let laws: Vec<_> = laws::all().into_iter().filter(|law| law.about.cost != Cost::Heavy).collect();
    let strategies: Vec<_> = laws.iter().map(|law| law.cases()).collect();
    let mut inconclusive = vec![0; laws.len()];
    let mut held = vec![0; laws.len()];
    for index in 0..cases {
        for (k, law) in laws.iter().enumerate() {
            if index >= law.about.cost.cases(cases) {
                continue;
            }
            let verdict = match draw(&strategies[k], seed, law.about.name, index).case {
                Ok((case, _)) => verdict_on(*law, &case, None),
                Err(why) => Verdict::Inconclusive { why },
            };
            match verdict {
                Verdict::Holds { .. } => held[k] += 1,
                Verdict::Inconclusive { .. } => inconclusive[k] += 1,
                Verdict::NotApplicable { .. } => {}
                Verdict::Broken { .. } => {
                    println!("{} case {index}: {verdict}", law.about.name);
                    return ExitCode::FAILURE;
                }
            }
        }
    }
    for (k, law) in laws.iter().enumerate() {
        let run = law.about.cost.cases(cases).min(cases);
        if run >= 20 && (inconclusive[k] * 20 > run || held[k] * 2 <= run) {
            println!("{}: of {run} cases {} held, {} inconclusive", law.about.name, held[k], inconclusive[k]);
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
