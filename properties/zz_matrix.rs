use euler_poincare::harness::{Fault, catch_fault};
use euler_poincare::laws;
use rayon::prelude::*;
#[test]
fn matrix() {
    let mut faults: Vec<Fault> = Vec::new();
    for l in laws::all() {
        for f in l.faults {
            if !faults.iter().any(|g| g.name == f.name) {
                faults.push(*f)
            }
        }
    }
    for f in laws::planted::retraction::ALL {
        if !faults.iter().any(|g| g.name == f.name) {
            faults.push(f)
        }
    }
    let only = std::env::var("ONLY").ok();
    let faults: Vec<_> =
        faults.into_iter().filter(|f| only.as_ref().is_none_or(|o| f.name.contains(o.as_str()))).collect();
    let laws = laws::all();
    let pairs: Vec<_> = laws
        .iter()
        .filter(|l| l.cost == euler_poincare::harness::Cost::Cheap)
        .flat_map(|l| faults.iter().map(move |f| (l, f)))
        .collect();
    let mut rows: Vec<_> = pairs
        .par_iter()
        .map(|(l, f)| (f.name, l.name, catch_fault(**l, f, 1, 20), l.faults.iter().any(|g| g.name == f.name)))
        .collect();
    rows.sort();
    for (f, l, c, listed) in rows {
        if c.is_some() || listed {
            println!("{f:32} {l:32} {c:?} {}", if listed { "listed" } else { "" });
        }
    }
}
