//! The names of retractions in files, and what random systems know of them.

use super::beside::{Core, Typed};
// All retractions, of which the table has the names.
use super::*;
use crate::group::MatrixGroup;
use serde::{Deserialize, Serialize};

/// What is known of a retraction with a name.
pub(crate) struct Known {
    /// Whether it is a function of the matrix x̂, for groups of quadratic type; else for any algebra.
    pub of_matrices: bool,
    /// The angle by which τ(x) turns what x̂ turns with a frequency.
    pub angle: fn(f64) -> f64,
    /// The frequency for an angle.
    pub frequency: fn(f64) -> f64,
    /// k and q: of random attitudes, turns are at least 2⁻ᵏ of π below π, and coordinates multiples of 1/q.
    pub nearest: (i64, f64),
    /// How often it is drawn, beside the others.
    pub weight: usize,
    /// Its share of random cases, in percent: no less and no more than this.
    pub share: (f64, f64),
}

/// The enum [`Tau`] of the names, from the table `retractions!`, and what follows from a name.
macro_rules! tau {
    ($($(#[$doc:meta])* $name:ident($retraction:ident, $point:ident) {
        name: $text:literal, build: $build:expr, closed: $closed:expr, known: $known:expr,
    })*) => {
        /// Which retraction.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
        #[non_exhaustive]
        pub enum Tau {
            $($(#[$doc])* #[serde(rename = $text)] #[cfg_attr(feature = "cli", value(name = $text))] $name,)*
        }

        impl Tau {
            /// All of them.
            pub(crate) const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The name in files: `exp`, `cayley`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)*
                }
            }

            pub(crate) fn known(self) -> &'static Known {
                match self {
                    $(Self::$name => &$known,)*
                }
            }

            /// Its closed form on SO(3), where it has one.
            pub(crate) fn closed<T: Real>(self) -> Option<Core<T>> {
                match self {
                    $(Self::$name => $closed,)*
                }
            }
        }

        impl<T: Real, const N: usize, const D: usize> AnyRetraction<T, N, D> {
            /// That of a name on an algebra, with its group where there is one.
            ///
            /// # Errors
            /// Why there is none.
            pub(crate) fn named(
                tau: Tau,
                algebra: &LieAlgebra<T, N>,
                group: Option<&MatrixGroup<T, N, D>>,
            ) -> Result<Self, String> {
                match tau {
                    $(Tau::$name => {
                        let build: fn(&LieAlgebra<T, N>, Option<&MatrixGroup<T, N, D>>) -> Result<_, String> = $build;
                        build(algebra, group).map(Self::$name)
                    })*
                }
            }
        }
    };
}

retractions!(tau);
