//! Forced discrete Noether's theorem for a method that tells its stages.
//!
//! ```text
//! Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ_j b_j Ad*_{g_j⁻¹} (f + ∂_gL)(t_j, g_j, η_j),   Σ_j b_j = 1
//! ```
//!
//! It holds at any step, whether the equations of the stages are solved or not, where the momentum is updated by the impulses at the stages.
//! The force is that of the theory at the stages of the method.

use super::symmetry::FLOOR;
use super::{Point, Quantity, Stage, View};
use crate::laws::precision::Measured;
use crate::laws::question::Answer;
use crate::scalar::{Real, max_abs};

/// The balance of the spatial momentum over a step.
pub(super) fn balance<T: Real>(view: &View<'_, '_, T>) -> Answer {
    let (start, h) = (view.theory.start(), view.theory.step());
    // From the identity the sides of g cannot be told apart.
    let no_attitude = || Measured::NotApplicable("the state has no attitude".into());
    let start = start.translated(&view.theory.element().ok_or_else(no_attitude)?);
    let end = view.step(&start, h)?;
    let stages = view.method.borrow().stages(&start, h);
    match stages {
        None => Err(Measured::NotApplicable("the method does not tell its stages".into())),
        Some(stages) if stages.is_empty() => Err(Measured::Broken("the method tells no stage".into())),
        Some(stages) => impulses(view, (&start, &end), h, &stages)
            .ok_or_else(|| Measured::Broken("the attitude at a stage has no inverse".into())),
    }
}

fn impulses<T: Real>(
    view: &View<'_, '_, T>,
    (start, end): (&Point<T>, &Point<T>),
    h: T,
    stages: &[Stage<T>],
) -> Option<Measured> {
    let theory = view.theory;
    let momentum = |point: &Point<T>| theory.value(Quantity::Momentum, point);
    let (before, after) = (momentum(start)?, momentum(end)?);
    let mut size = before.iter().chain(&after).fold(T::exact(f64::MIN_POSITIVE), |size, of| size.max(of.size));
    let mut change: Vec<T> = after.iter().zip(&before).map(|(after, before)| after.value - before.value).collect();
    for stage in stages {
        let push: Vec<T> = theory.force(stage).into_iter().map(|f| f * stage.weight * h).collect();
        let point = Point { time: stage.time, momentum: push, attitude: stage.attitude.clone() };
        for (change, impulse) in change.iter_mut().zip(momentum(&point)?) {
            *change -= impulse.value;
            size = size.max(impulse.size);
        }
    }
    let defect = max_abs(&change);
    let floor = view.floor(FLOOR.max(4.0 * (stages.len() * before.len() * before.len()) as f64));
    let balance = Measured::defect(defect, size, floor, || {
        let show: Vec<_> = change.iter().map(|x| format!("{:.3e}", x.to_f64())).collect();
        format!("the spatial momentum changes by ({}) more than the impulses at the stages", show.join(", "))
    });
    let sum = stages.iter().fold(T::zero(), |sum, stage| sum + stage.weight);
    let weights = Measured::defect((sum - T::one()).abs(), T::one(), FLOOR, || {
        format!("the weights of the stages add up to {:.17}", sum.to_f64())
    });
    Some(balance.and(weights))
}
