//! Work against precision, of this crate's integrators and of general-purpose solvers, in one interleaved run.
//!
//! | module | holds |
//! |---|---|
//! | [`fields`], [`problem`], [`mod@reference`] | the equations, the initial value problems and their solutions |
//! | [`contender`] | the trait, and the list of what takes part |
//! | [`ours`] | this crate |
//! | [`ode_solvers`], [`ivp`], [`differential_equations`], `russell`, `diffsol` | packaged solvers, one file a package |
//! | [`rk4`], [`dop853`], [`hindsight`] | explicit methods by hand, with the best fixed step |
//! | [`measure`] | errors and times |
//! | [`machine`] | what it ran on |
//! | [`report`], [`figure`] | the table, the file and the plot |
//! | [`plot`] | axes, curves and legends as SVG: the file of the command |
//! | [`rounding`] | how rounding errors grow, of this crate alone |

pub mod contender;
pub mod differential_equations;
#[cfg(feature = "diffsol")]
pub mod diffsol;
pub mod dop853;
pub mod fields;
pub mod figure;
pub mod hindsight;
pub mod ivp;
pub mod machine;
pub mod measure;
pub mod ode_solvers;
pub mod ours;
#[path = "../../../src/cli/plot.rs"]
pub mod plot;
pub mod problem;
pub mod reference;
pub mod report;
pub mod rk4;
pub mod rounding;
#[cfg(feature = "russell")]
pub mod russell;
