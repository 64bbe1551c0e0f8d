//! A run with a tolerance: a body tumbles in a fluid until it has lost half of its momentum. States at chosen times, and events.
//!
//! `cargo run --release --example solve`

use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::integrators::State;
use euler_poincare::integrators::solve::{End, Event, Solve};
use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
use euler_poincare::retraction::CayleySo3;
use euler_poincare::scalar::{Real, Scalar};
use std::error::Error;

/// A force of one's own: drag with the square of the speed, f = −|η| η/10.
#[derive(Clone, Copy)]
struct Fluid;

impl<T: Real> Force<T, 3> for Fluid {
    fn force<S: Scalar<Base = T>>(&self, _time: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let speed = eta.dot(eta).sqrt();
        -eta.transpose() * (speed * S::ratio(1, 10))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
    let start = State::at_identity(Covector::<f64, 3>::new(0.4, 1.0, 0.7));

    // Event 0: the third axis of the body passes the horizontal plane. Event 1 ends the run.
    let level = Event::new(|state: &State<f64, 3, 3>| state.attitude[(2, 2)]);
    let half = start.momentum.norm() / 2.0;
    let slow = Event::new(|state: &State<f64, 3, 3>| state.momentum.norm() - half).falling().terminal();

    let mut solve = Solve::new(body, Fluid, CayleySo3::new()).tolerance(1e-10).save_at([1.0, 2.0, 4.0, 8.0]);
    solve = solve.event(level).event(slow);
    let solution = solve.run(&start, 1000.0)?;

    for state in &solution.saved {
        println!("{state:.6}");
    }
    for found in &solution.events {
        println!("event {} at t = {:.9}, {}", found.event, found.state.time, if found.rising { "up" } else { "down" });
    }
    println!("{:?}: {} steps, error about {:.1e}", solution.end, solution.statistics.steps, solution.statistics.error);
    assert_eq!(solution.end, End::Event(1));
    assert!((solution.state.momentum.norm() - half).abs() < 1e-9);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
