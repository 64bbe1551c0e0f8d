//! Steppers that are other programs: any language, one JSON object a line on standard input and output.
//!
//! The protocol is in `properties/steppers/PROTOCOL.md`. A [`Program`] is a running command with a time limit; it is killed
//! when it hangs, floods or answers with something else than a state, and restarted at most [`Limits::restarts`] times. [`External`] makes
//! methods of it for described systems ([`crate::laws::method`] judges them), [`ExternalStepper`] is a typed
//! [`OneStep`](crate::integrators::OneStep).
//!
//! ```no_run
//! use euler_poincare::external::{External, ExternalStepper, Limits};
//! use euler_poincare::integrators::{OneStep, State};
//! use euler_poincare::algebra::{Covector, Matrix};
//! use euler_poincare::study::problem;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let external = External::new(&["python3".into(), "stepper.py".into()], Limits::default());
//! let body = problem::generic()?.case; // on so(3)
//! let mut method = ExternalStepper::<3, 3>::new(&external, &body)?;
//! let mut state = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.4, 0.1, 0.7), attitude: Matrix::<f64, 3>::identity() };
//! method.step(&mut state, 0.125)?;
//! # Ok(())
//! # }
//! ```

mod campaign;
mod counterexample;
mod program;
mod protocol;
mod record;
mod report;
mod stepper;
mod supports;

pub use crate::system::restriction::DragForm;
pub use campaign::{Drawn, Probe, Shrinking, examine};
pub use counterexample::{Broken, Compared, SlopeLevel, Slopes, Values};
pub use program::{Exchange, Limits, Program, Silence};
pub use protocol::{CONFIGURATION_VERSION, Described, LAGRANGIAN_VERSION, Reply, VERSION, parse};
pub use record::Record;
pub use report::{ClaimReport, Conclusion, LawReport, MeasuredCase, ProbeReport, QuantityOrders};
pub use stepper::{External, ExternalStepper};
pub use supports::Supports;
