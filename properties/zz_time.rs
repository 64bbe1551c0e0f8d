//! x
use euler_poincare::harness::{Cost, draw, verdict_on};
use euler_poincare::laws;
use std::time::Instant;
#[test]
fn run() {
    let n: usize = std::env::var("CASES").map_or(40, |n| n.parse().unwrap());
    let only = std::env::var("ONLY").ok();
    for law in laws::all() {
        if only.as_ref().is_some_and(|o| !law.name.contains(o.as_str())) {
            continue;
        }
        if law.cost != Cost::Cheap && only.is_none() {
            continue;
        }
        let st = (law.cases)();
        let (mut t, mut h, mut na, mut bad) = (0.0, 0, 0, vec![]);
        for i in 0..n {
            let c = draw(&st, 1, law.name, i).case.unwrap().0;
            let s = Instant::now();
            let v = verdict_on(law, &c, None);
            t += s.elapsed().as_secs_f64();
            match v {
                v if v.holds() => h += 1,
                euler_poincare::harness::Verdict::NotApplicable { .. } => na += 1,
                v => bad.push(format!("{i}: {v}")),
            }
        }
        println!("{:32} {:?} {:.2} ms held {h} na {na} {}", law.name, law.cost, t / n as f64 * 1e3, bad.join("; "));
    }
}
