//! Forced variational integrators on Lie groups, and the property-based harness that verifies them.
//!
//! A forced Euler–Poincaré system is a Lie group G, a reduced Lagrangian l: g → ℝ and a force f: g → g*,
//! d/dt l'(η) = ad*_η l'(η) + f(t, η), ġ = g η. This crate integrates it by the variationally partitioned Runge–Kutta–
//! Munthe-Kaas methods that come from doubling the variables (D. Martín de Diego, R. T. Sato Martín de Almagro,
//! *Variational order for forced Lagrangian systems II: Euler–Poincaré equations with forcing*, 2019), and it checks what
//! the theory promises on random algebras, inertias, forces, tableaux and states.
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
//! # Notation
//!
//! | symbol | meaning | in code |
//! |---|---|---|
//! | G, g, g* | Lie group, its algebra of dimension N, the dual | [`group::LieGroup`], [`algebra::LieAlgebra`] |
//! | C^c_ab | structure constants: \[e_a, e_b\] = C^c_ab e_c | `constant(a, b, c)` |
//! | η, ξ, Ξ, H, Ψ | vectors of g, columns | [`algebra::Vector`] |
//! | μ, λ, p, f | covectors of g*, rows: ⟨μ, ξ⟩ = μ ξ, and A*μ is μ A | [`algebra::Covector`], [`algebra::pair`] |
//! | ad_ξ, ad*_ξ μ | (ad_ξ)^c_b = C^c_ab ξ^a, μ ad_ξ | `ad`, `coad` |
//! | Ad_g, Ad*_g μ | Ad_g ξ = g ξ g⁻¹, μ Ad_g (no inverse) | `adjoint`, `coadjoint` |
//! | η = g⁻¹ġ | left trivialisation, throughout | |
//! | τ | retraction: τ(0) = e, T₀τ = 1, τ(−ξ) = τ(ξ)⁻¹ | [`retraction::Retraction`] |
//! | dτ_ξ | T_ξ τ(η) = τ(ξ) dτ_ξ η ("right Jacobian" in robotics) | `d`, `d_inv` |
//! | ddτ_ξ(η, δ) | ∂_ξ(dτ_ξ η) δ = dτ_ξ ddτ_ξ(η, δ) | `dd`, `pull_dd` |
//! | a_ij, b_j, c_i | tableau with s stages, every b_i ≠ 0 | [`tableau::Tableau`] |
//! | â_ij | b_j − b_j a_ji / b_i, the symplectic conjugate | `conjugate` |
//! | l, l', f | reduced Lagrangian, its gradient, force | [`mechanics::Lagrangian`], [`mechanics::Force`] |
//! | l_f, k_f | doubled Lagrangian on g×G×g and its coupling | [`mechanics::doubled`] |
//! | h_f, h̃_f | Hamiltonians on g*×G×g* of a forced system | [`mechanics::forced_hamiltonian`], [`mechanics::hamiltonian`] |
//! | u | unit round-off of the scalar | `unit_roundoff` |
//!
//! Bases: so(3) the three rotations, \[e_1, e_2\] = e_3; se(3) and so(4) rotations first; the rest in
//! [`algebra::catalogue`]. Where a source has another convention, the formula says so.
//!
//! # Modules
//!
//! Importing goes one way, downwards in this table.
//!
//! | module | holds |
//! |---|---|
//! | [`scalar`] | `f64`, ~32 and ~64 digits, duals; exact number expressions |
//! | [`algebra`], [`tableau`], [`newton`] | structure constants and catalogue; coefficients, families, trees, orders; one solver |
//! | [`group`] | matrix groups, SO(3) |
//! | [`retraction`], [`groupoid`] | exp and Cayley with their tangents; Lie groupoids and algebroids, G×G×G, g*×G×g* and its bracket |
//! | [`mechanics`] | Lagrangians, forces, equations, doubled Lagrangians and Hamiltonians, the paper's models |
//! | [`discrete`] | discrete Lagrangians on G×G×G, G⁴ and G: Legendre transforms, equations, flows |
//! | [`integrators`] | the variational step, its fast forms on SO(3), the doubled scheme, comparators, trajectories |
//! | `experiments` | the paper's numerical experiments |
//! | `harness` | laws, verdicts, campaigns, order estimates; knows no Lie theory |
//! | `system`, `study` | the case as a plain value; convergence studies, of any one-step method |
//! | `laws` | what is promised, with planted faults; laws of any one-step method |
//! | `foreign` | steppers that are other programs, over standard input and output |
//!
//! # Features
//!
//! `default = ["cli"]`; `cli` contains `harness`; with neither, the core needs little more than nalgebra.

pub mod algebra;
pub mod discrete;
#[cfg(feature = "harness")]
pub mod experiments;
#[cfg(feature = "harness")]
pub mod foreign;
pub mod group;
pub mod groupoid;
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
