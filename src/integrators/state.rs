//! The state (t, μ, g), and how it comes from and goes to the types of others.

use super::StepError;
use crate::algebra::{Covector, Matrix};
use crate::scalar::Real;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};
use std::fmt::{self, Display, Formatter};

/// The state of a forced Euler–Poincaré system at a time.
///
/// With the feature `serde` it is saved and read in every scalar that is: `{"time": t, "momentum": [μ_1, …], "attitude": [[g_11, …], …]}`, the
/// attitude by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct State<T: Real, const N: usize, const D: usize> {
    /// t.
    pub time: T,
    /// μ ∈ g*, left-trivialised.
    pub momentum: Covector<T, N>,
    /// g ∈ G, as its matrix; carried along unchanged where there is no group.
    pub attitude: Matrix<T, D>,
}

impl<T: Real, const N: usize, const D: usize> State<T, N, D> {
    /// (0, μ, g).
    pub fn new(momentum: Covector<T, N>, attitude: Matrix<T, D>) -> Self {
        Self { time: T::zero(), momentum, attitude }
    }

    /// (0, μ, e).
    pub fn at_identity(momentum: Covector<T, N>) -> Self {
        Self::new(momentum, Matrix::identity())
    }

    /// The same at another time.
    pub fn at_time(self, time: T) -> Self {
        Self { time, ..self }
    }

    /// Refuses NaN and infinity, in the state and in the step size `h`.
    ///
    /// # Errors
    /// [`StepError::NotFinite`] says what was not finite.
    #[inline]
    pub fn check_finite(&self, h: T) -> Result<(), StepError> {
        all_finite([
            ("h", h.all_finite()),
            ("the time", self.time.all_finite()),
            ("the momentum", self.momentum.iter().all(|v| v.all_finite())),
            ("the attitude", self.attitude.iter().all(|v| v.all_finite())),
        ])
    }
}

/// Refuses the first of these that is not finite.
#[inline(always)]
pub(super) fn all_finite(finite: [(&'static str, bool); 4]) -> Result<(), StepError> {
    match finite.into_iter().find(|(_, ok)| !ok) {
        Some((what, _)) => Err(StepError::NotFinite { what }),
        None => Ok(()),
    }
}

impl<T: Real> State<T, 3, 3> {
    /// (0, μ, R) on SO(3), with R from a rotation or a unit quaternion.
    pub fn with_rotation(momentum: Covector<T, 3>, rotation: impl Into<Rotation3<T>>) -> Self {
        Self::new(momentum, rotation.into().into_inner())
    }

    /// The attitude as a rotation; not orthonormalised.
    pub fn rotation(&self) -> Rotation3<T> {
        Rotation3::from_matrix_unchecked(self.attitude)
    }

    /// The attitude as a unit quaternion, one of two.
    pub fn quaternion(&self) -> UnitQuaternion<T> {
        UnitQuaternion::from_rotation_matrix(&self.rotation())
    }
}

impl<T: Real> State<T, 6, 4> {
    /// (0, μ, g) on SE(3), coordinates (ω, v), with g from an isometry.
    pub fn with_isometry(momentum: Covector<T, 6>, isometry: Isometry3<T>) -> Self {
        Self::new(momentum, isometry.to_homogeneous())
    }

    /// The attitude as an isometry; its rotation as a unit quaternion.
    pub fn isometry(&self) -> Isometry3<T> {
        let rotation = Rotation3::from_matrix_unchecked(self.attitude.fixed_view::<3, 3>(0, 0).into_owned());
        let translation = Translation3::from(self.attitude.fixed_view::<3, 1>(0, 3).into_owned());
        Isometry3::from_parts(translation, UnitQuaternion::from_rotation_matrix(&rotation))
    }
}

/// Numbers with something between them, each in the format of `f`.
fn listed<'a, T: Display + 'a>(
    f: &mut Formatter<'_>,
    numbers: impl Iterator<Item = &'a T>,
    between: &str,
) -> fmt::Result {
    for (k, number) in numbers.enumerate() {
        if k > 0 {
            f.write_str(between)?;
        }
        number.fmt(f)?;
    }
    Ok(())
}

/// t, μ, and g by rows; a precision is that of each number.
impl<T: Real, const N: usize, const D: usize> Display for State<T, N, D> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("t = ")?;
        Display::fmt(&self.time, f)?;
        f.write_str(", μ = (")?;
        listed(f, self.momentum.iter(), ", ")?;
        f.write_str("), g = [")?;
        for row in 0..D {
            if row > 0 {
                f.write_str("; ")?;
            }
            listed(f, self.attitude.row(row).iter(), " ")?;
        }
        f.write_str("]")
    }
}

/// `{"time": t, "momentum": [μ_1, …], "attitude": [[g_11, …], …]}`, the attitude by rows.
#[cfg(feature = "serde")]
mod serialised {
    use super::State;
    use crate::algebra::{Covector, Matrix};
    use crate::scalar::Real;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Plain<T> {
        time: T,
        momentum: Vec<T>,
        attitude: Vec<Vec<T>>,
    }

    impl<T: Real + Serialize, const N: usize, const D: usize> Serialize for State<T, N, D> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let attitude = self.attitude.row_iter().map(|row| row.iter().copied().collect()).collect();
            Plain { time: self.time, momentum: self.momentum.iter().copied().collect(), attitude }.serialize(serializer)
        }
    }

    impl<'de, T: Real + Deserialize<'de>, const N: usize, const D: usize> Deserialize<'de> for State<T, N, D> {
        fn deserialize<E: Deserializer<'de>>(deserializer: E) -> Result<Self, E::Error> {
            let Plain { time, momentum, attitude } = Plain::deserialize(deserializer)?;
            if momentum.len() != N {
                return Err(E::Error::invalid_length(momentum.len(), &format!("{N} components of μ").as_str()));
            }
            if attitude.len() != D || attitude.iter().any(|row| row.len() != D) {
                return Err(E::Error::custom(format!("the attitude is not a {D}×{D} matrix")));
            }
            Ok(Self {
                time,
                momentum: Covector::<T, N>::from_fn(|_, a| momentum[a]),
                attitude: Matrix::<T, D>::from_fn(|i, j| attitude[i][j]),
            })
        }
    }
}
