//! Many bodies at once: a thousand spins, each with a damping of its own, turn into the axis of the largest inertia.
//!
//! Eight bodies share the registers; with the feature `rayon` the groups of eight are spread over all cores.
//!
//! `cargo run --release --example ensemble`

use euler_poincare::algebra::Covector;
use euler_poincare::integrators::State;
use euler_poincare::integrators::lanes::{Term, Terms};
use euler_poincare::integrators::so3::{EnsembleSo3, Member};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::CayleySo3;
use euler_poincare::tableau::Family;
use std::error::Error;

const BODIES: u32 = 1000;
const STEP: f64 = 0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
    let start = State::at_identity(Covector::<f64, 3>::new(0.8, 0.0, 0.6));
    // f = α M × (M × Ω), which keeps |M|, with α from 0 to 1.
    let member = |k: u32| Member {
        lagrangian: body.clone(),
        force: Terms(vec![Term::Damping(f64::from(k) / f64::from(BODIES - 1))]),
        state: start.clone(),
    };
    let members: Vec<_> = (0..BODIES).map(member).collect();
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), Family::Gauss.tableau(2)?)?;

    for _ in 0..5 {
        ensemble.advance(STEP, 200)?;
        let aligned = ensemble.states().filter(|state| state.momentum[1].abs() > 0.99).count();
        let time = ensemble.state(0).map_or(0.0, |state| state.time);
        println!("t = {time:.1}: {aligned} of {BODIES} spins are aligned");
    }
    // Without damping |M| is kept to round-off, with it to the order of the method.
    let change = |state: State<f64, 3, 3>| (state.momentum.norm() - start.momentum.norm()).abs();
    let changes: Vec<f64> = ensemble.states().map(change).collect();
    let most = changes.iter().copied().fold(0.0, f64::max);
    println!("|M| has changed by {:.1e} without damping, by {most:.1e} at most", changes[0]);
    assert!(changes[0] < 1e-14 && most < 1e-6);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
