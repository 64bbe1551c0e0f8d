//! scratch
use euler_poincare::experiments::*;
#[test]
fn scratch() {
    for p in Problem::ALL {
        let t = std::time::Instant::now();
        let r = Reference::compute(p).unwrap();
        println!(
            "ref {:?} {:.3e} {:.3e} {:.3e}",
            t.elapsed(),
            r.momentum[0] - r.model.reference_momentum().unwrap()[0],
            r.momentum[1] - r.model.reference_momentum().unwrap()[1],
            r.momentum[2] - r.model.reference_momentum().unwrap()[2]
        );
        for m in Method::TABULATED {
            let t = std::time::Instant::now();
            let rows = errors::table(&r, &[m], 8, || {});
            match rows {
                Ok(rows) => {
                    println!("{} {m} {:?}", p.name(), t.elapsed());
                    for s in ["f64", "dd"] {
                        println!(
                            "  {s} {}",
                            rows.iter()
                                .filter(|r| r.scalar == s)
                                .map(|r| format!("{}:{:.2e}({})", r.level, r.errors.momentum, r.errors.iterations))
                                .collect::<Vec<_>>()
                                .join(" ")
                        );
                    }
                }
                Err(e) => println!("{e}"),
            }
        }
    }
    for c in expected::TABLE {
        let r = Reference::compute(c.problem).unwrap();
        for k in 0..7 {
            let e = errors::errors::<euler_poincare::scalar::Dd>(&r, c.method, k).unwrap();
            let (a, b) = (e.map(|e| expected::shown(e.momentum)), c.error(k).map(expected::shown));
            if a != b {
                println!("DIFF {:?} {} {k} {a:?} {b:?} {e:?}", c.problem, c.method);
            }
        }
    }
}
