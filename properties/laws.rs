//! Properties of `euler_poincare::laws`: every law holds on random systems, and catches every fault planted for it.

use euler_poincare::harness::{Campaign, Law, catch_fault};
use euler_poincare::laws;
use euler_poincare::system::Case;

#[test]
fn every_law_holds() {
    let laws: Vec<&dyn Law<Case>> = laws::all().into_iter().map(|law| law as &dyn Law<Case>).collect();
    let report = Campaign::new(1, 60).run(&laws);
    for law in &report.laws {
        println!(
            "{} cases {} held {} broken {:?} inconclusive {:?} na {:?} worst {:?} ratio {:?} seconds {:.2}",
            law.law, law.cases, law.held, law.broken, law.inconclusive, law.not_applicable, law.worst, law.worst.as_ref().map(|w| w.ratio()), law.seconds
        );
        for failure in &law.failures {
            println!("{failure:?}");
        }
    }
    assert!(report.holds());
}

#[test]
fn every_fault_is_caught() {
    for law in laws::all() {
        for fault in law.faults {
            let t = std::time::Instant::now();
            let caught = catch_fault(law, fault, 1, 100);
            println!("{} {} {:?} {:.2}", law.name, fault.name, caught, t.elapsed().as_secs_f64());
        }
    }
}
