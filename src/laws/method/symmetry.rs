//! Identities of a step: Φ_{−h}∘Φ_h, translations, changes of basis.

use super::{Point, View, difference};
use crate::laws::precision::Measured;
use crate::laws::question::Answer;
use crate::laws::step::show_list;
use crate::scalar::Real;

/// Of a defect between two steps, in units of u: [`AGREEMENT`](crate::laws::precision::AGREEMENT) times this is 2¹⁴, the
/// residual that the library's own solver may leave where a case is ill-conditioned.
pub(super) const FLOOR: f64 = 64.0;

/// The graver of the defects in μ and in g between two states that must be equal; `stretch` is how much larger than the states
/// the terms of the attitude are.
fn same<T: Real>(
    view: &View<'_, '_, T>,
    mine: &Point<T>,
    other: &Point<T>,
    (momentum, attitude): (T, T),
    what: &str,
) -> Measured {
    let judged = |x: &[T], y: &[T], stretch: T, part: &str| {
        let (defect, size) = difference(x, y);
        let size = (size * stretch).max(T::exact(f64::MIN_POSITIVE));
        Measured::defect(defect, size, view.floor(FLOOR), || {
            format!("{what}: {part} = {}, expected {}", show_list(x), show_list(y))
        })
    };
    let momentum = judged(&mine.momentum, &other.momentum, momentum, "μ");
    momentum.and(judged(&mine.attitude, &other.attitude, attitude, "g"))
}

/// Φ_{−h}∘Φ_h = 1.
pub(super) fn reversibility<T: Real>(view: &View<'_, '_, T>) -> Answer {
    let (start, h) = (view.theory.start(), view.theory.step());
    let back = view.step(&view.step(&start, h)?, -h)?;
    Ok(same(view, &back, &start, (T::one(), T::one()), "after a step forth and back"))
}

/// Left translations, time translations, repetition.
pub(super) fn equivariance<T: Real>(view: &View<'_, '_, T>) -> Answer {
    let (start, h) = (view.theory.start(), view.theory.step());
    let end = view.step(&start, h)?;
    let mut found = same(view, &view.step(&start, h)?, &end, (T::one(), T::one()), "asked again");
    if let Some(k) = view.theory.symmetry() {
        let (moved, expected) = (start.translated(&k), end.translated(&k));
        let size = k.iter().fold(T::one(), |m, x| m.max(x.abs())) * T::int(start.attitude.len().isqrt() as i64);
        let after = view.step(&moved, h)?;
        found = found.and(same(view, &after, &expected, (size, size), "after a left translation of g"));
    }
    if view.theory.is_autonomous() {
        let later = Point { time: start.time + T::ratio(5, 8), ..start.clone() };
        let after = view.step(&later, h)?;
        found = found.and(same(view, &after, &end, (T::one(), T::one()), "from a later time"));
    }
    Ok(found)
}

/// The same step in another basis.
pub(super) fn presentation<T: Real>(view: &View<'_, '_, T>) -> Answer {
    let (start, h) = (view.theory.start(), view.theory.step());
    let end = view.step(&start, h)?;
    let (other, basis) = (view.setup.presented)();
    let other = other?;
    let Some(other) = other.as_ref().and_then(view.alike) else {
        return Err(Measured::NotApplicable("the system is given in one basis only".into()));
    };
    let mut after = other.step(&other.theory.start(), h)?;
    let n = end.momentum.len();
    let entry = |b: usize, a: usize| basis.get(b).and_then(|row| row.get(a)).copied().unwrap_or(f64::NAN);
    let momentum = |a: usize| (0..n).fold(T::zero(), |sum, b| sum + end.momentum[b] * T::exact(entry(b, a)));
    let expected = Point { momentum: (0..n).map(momentum).collect(), ..end.clone() };
    if after.attitude.len() != expected.attitude.len() {
        after.attitude.clone_from(&expected.attitude);
    }
    let size = T::int(n as i64);
    Ok(same(view, &after, &expected, (size, size), "in another basis"))
}
