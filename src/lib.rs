//! Forced variational integrators on Lie groups, and the property-based harness that verifies them.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/system.md"))]
//!
//! Examples are rigid bodies, underwater vehicles and spins, with drag, torques and damping. This crate integrates such
//! systems by the variationally partitioned Runge–Kutta–Munthe-Kaas methods that come from doubling the variables (D. Martín
//! de Diego, R. T. Sato Martín de Almagro, *Variational order for forced Lagrangian systems II: Euler–Poincaré equations
//! with forcing*, 2019). It checks what the theory promises on random algebras, inertias, forces, tableaux and states.
//!
//! The [guide](guide/index.html) has a chapter for each task: getting started, integrating a system, orders of a tableau,
//! testing your own code, probing a program in any language, campaigns, the theory.
//!
//! # Example
//!
//! A rigid body with linear drag, one second in steps of a tenth with the Gauss method of order 4:
//!
//! ```
//! use euler_poincare::algebra::{Covector, Matrix};
//! use euler_poincare::integrators::{OneStep, State, Variational};
//! use euler_poincare::mechanics::{force::LinearDrag, lagrangian::Quadratic};
//! use euler_poincare::retraction::CayleySo3;
//! use euler_poincare::tableau::Family;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let inertia = Quadratic::diagonal([0.5, 2.0, 1.0])?;
//! let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(0.1))?;
//! let gauss = Family::Gauss.tableau::<f64>(2)?;
//! let mut method = Variational::new(inertia, drag, CayleySo3::new(), gauss);
//!
//! let momentum = Covector::<f64, 3>::new(0.4, 0.1, 0.7);
//! let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
//! for _ in 0..10 {
//!     method.step(&mut state, 0.1)?;
//! }
//! assert!((state.time - 1.0).abs() < 1e-15);
//! assert!(state.momentum.norm() < momentum.norm());
//! assert!((state.attitude.transpose() * state.attitude - Matrix::<f64, 3>::identity()).amax() < 1e-14);
//! # Ok(())
//! # }
//! ```
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/notation.md"))]
//!
//! # Modules
//!
//! Importing goes one way, downwards in this table.
//!
//! | module | holds |
//! |---|---|
//! | `file` | text files: read with the place of what is wrong, replaced when the new one is whole |
//! | [`scalar`] | `f64`, ~32 digits, duals; exact number expressions |
//! | [`algebra`], [`tableau`], [`newton`] | structure constants and catalogue; coefficients, families, trees, orders; one solver |
//! | [`group`] | matrix groups, SO(3) |
//! | [`retraction`], [`groupoid`] | exp and Cayley with their tangents; Lie groupoids and algebroids, G×G×G, g*×G×g* and its bracket |
//! | [`mechanics`] | Lagrangians, forces, equations, doubled Lagrangians and Hamiltonians, the paper's models |
//! | [`discrete`] | discrete Lagrangians on G×G×G, G⁴ and G: Legendre transforms, equations, flows |
//! | [`integrators`] | the variational step, its form in vector registers, the doubled scheme, comparators, trajectories |
//! | `experiments` | the paper's numerical experiments |
//! | `harness` | laws, verdicts, campaigns, order estimates; knows no Lie theory |
//! | `system`, `study` | the case as a plain value; convergence studies, of any one-step method |
//! | `laws` | what is promised, with planted faults; laws of any one-step method |
//! | `external` | steppers that are other programs, over standard input and output |
//!
//! # Features
//!
//! | feature | contains |
//! |---|---|
//! | none | what needs little more than nalgebra: `scalar` to `integrators` in the table above |
//! | `lanes` | also the steps, solvers and ensembles in vector registers: `integrators::{lanes, so3, se3}` |
//! | `rayon` | ensembles on all cores; without it one group of bodies after the other, to the same bits |
//! | `serde` | states, exact numbers and numbers of 32 digits, saved and read |
//! | `harness` | also `lanes`, `rayon`, `serde`, `file`, `experiments`, `harness`, `system`, `study`, `laws`, `external` |
//! | `cli` (default) | also the command |

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod algebra;
pub mod discrete;
#[cfg(feature = "harness")]
pub mod experiments;
pub mod expression;
#[cfg(feature = "harness")]
pub mod external;
#[cfg(feature = "harness")]
pub mod file;
pub mod group;
pub mod groupoid;
#[cfg(all(any(doc, doctest), feature = "harness"))]
pub mod guide;
#[cfg(feature = "harness")]
pub mod harness;
pub mod integrators;
#[cfg(feature = "harness")]
pub mod laws;
pub mod mechanics;
pub mod newton;
pub mod retraction;
pub mod scalar;
#[cfg(feature = "harness")]
pub mod study;
#[cfg(feature = "harness")]
pub mod system;
pub mod tableau;
