//! Properties of what the laws stand on: from scalars to integrators. Without the harness, those that need none, except the
//! derivatives of steps: half of the compiler's work, for code that knows no features.

/// Tests that run a check in 16 digits and in 32.
macro_rules! in_both {
    ($($name:ident: $check:ident;)*) => {
        $(#[test] fn $name() {
            $check::<f64>();
            $check::<euler_poincare::scalar::Dd>();
        })*
    };
}

mod continuous;
mod discrete;
mod scalar;
mod solve;

#[cfg(feature = "lanes")]
mod allocation;

#[cfg(feature = "harness")]
mod algebra;
#[cfg(feature = "harness")]
#[path = "integrators/derivative.rs"]
mod derivative;
#[cfg(feature = "harness")]
mod expression;
#[cfg(feature = "harness")]
mod group;
#[cfg(feature = "harness")]
mod groupoid;
#[cfg(feature = "harness")]
mod integrators;
#[cfg(feature = "harness")]
mod mechanics;
#[cfg(feature = "harness")]
mod retraction;
#[cfg(feature = "harness")]
mod systems;
#[cfg(feature = "harness")]
mod tableau;
#[cfg(feature = "harness")]
mod trajectories;
