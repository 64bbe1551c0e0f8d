//! What a method has as its state.

use serde::{Deserialize, Serialize};

/// What a method has as its state: always the momentum μ, and something of the attitude g beside it.
///
/// A point x₀ that is fixed in space is x = g⁻¹ x₀ in the body: ẋ = −η̂ x, so that (μ, x) moves by itself, and x stays on the orbit
/// of the group through x₀. With e₃ on SO(3) it is a point of S², with (0, …, 0, 1) on SE(2) and SE(3) the origin of space as the
/// body sees it. (g x₀ does not move by itself with μ: its velocity g η̂ x₀ needs g.)
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StateForm {
    /// (μ, g).
    #[default]
    Attitude,
    /// μ alone, a point of its coadjoint orbit.
    Momentum,
    /// (μ, x) with x = g⁻¹ x₀; the numbers of x₀, as many as the group's matrices have rows.
    Point(Vec<f64>),
}

impl StateForm {
    /// Whether it is (μ, g).
    pub(crate) fn is_attitude(&self) -> bool {
        *self == Self::Attitude
    }
}
