//! Steppers that are other programs: any language, one JSON object a line on standard input and output.
//!
//! The protocol is in `properties/steppers/PROTOCOL.md`. A [`Program`] is a running command with a time limit; it is killed
//! when it hangs, floods or answers with something else than a state, and restarted at most [`Limits::restarts`] times. [`External`] makes
//! methods of it for described systems: [`crate::laws::method`] judges them.
//!
//! ```no_run
//! use euler_poincare::external::{External, Limits};
//! use euler_poincare::laws::method::{Point, Stepper};
//! use euler_poincare::study::problem;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let external = External::new(&["python3".into(), "stepper.py".into()], Limits::default());
//! let body = problem::generic()?.case; // on so(3)
//! let mut method = external.on(&body)?;
//! let attitude = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
//! let next = method.step(&Point { time: 0.0, momentum: vec![0.4, 0.1, 0.7], attitude }, 0.125)?;
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
pub use counterexample::{Compared, Examined, SlopeLevel, Slopes, Values};
pub use program::{Exchange, Limits, Program, Silence};
pub use protocol::{CONFIGURATION_VERSION, Described, LAGRANGIAN_VERSION, Reply, VERSION, parse};
pub use record::Record;
pub use report::{ClaimReport, Conclusion, LawReport, ProbeReport, QuantityOrders};
pub use stepper::External;
pub use supports::Supports;
