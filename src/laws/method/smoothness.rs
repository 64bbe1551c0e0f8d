//! Whether a step is a smooth function of its length.
//!
//! The end Φ_h(t, μ, g) of a step of a method is analytic in h where its equations have one solution near h = 0. What is not: an
//! iteration that stops at a tolerance leaves an error that jumps where the count of its iterations does, and so do a step length in
//! fewer digits, tables, and formulas that are switched at the wrong place. So the end is sampled at m Chebyshev nodes
//!
//! ```text
//! h_j = H (9/16 + 7/16 cos(π (j + ½)/m)),   j = 0 … m − 1,   c_k = 2/m Σ_j Φ(h_j) cos(k π (j + ½)/m)
//! ```
//!
//! between H/8 and H, H pace ≤ 1/4. Where Φ is analytic for |h| < 4H (h pace < 1), the coefficients fall like ρ^{−k} with ρ = 15.6:
//! with m = 24 the last third, k ≥ 16, is below u of the state in 16 digits (ρ^{−16} = 8e-20), with m = 48 and k ≥ 32 in 32 digits
//! likewise (6e-39). A jump of size J leaves up to 2J/(π k) there.
//!
//! A method may have less room than the motion: with τ = exp(x + x³) its equations branch at |h| = 1.1 where the motion has none. So where
//! the last third is above rounding, lengths up to H/2 and H/4 are asked too, and the smoothest third counts: each halving doubles ρ, and
//! leaves a jump where it is.

use super::levels::{self, REACH};
use super::{LOOSE, Point, View};
use crate::integrators::StepError;
use crate::laws::precision::Measured;
use crate::laws::question::Answer;
use crate::scalar::Real;

/// Of a coefficient, in units of u of the state: the residual that a solver may leave, as of an identity of two steps.
const FLOOR: f64 = 64.0;

/// How often H is halved where a method refuses steps of it.
const HALVINGS: i32 = 12;

/// h ↦ Φ_h is smooth.
pub(super) fn smooth<T: Real>(view: &View<'_, '_, T>) -> Answer {
    let Some(largest) = levels::largest(view) else {
        return Err(Measured::NotApplicable("the motion has no pace at its start".into()));
    };
    let usual = view.theory.step().abs();
    let mut most = largest * T::exact(0.25 / REACH);
    let mut halvings = 0;
    loop {
        match sampled(view, most) {
            Ok(samples) => return Ok(smoothest(view, most, &samples)),
            Err(error) if levels::is_final(&error) => return Err(error.into()),
            // A step that is too large for the method says nothing.
            Err(error) if halvings == HALVINGS || most < usual * T::exact(0.125) => return Err(error.into()),
            Err(_) => (most, halvings) = (most * T::half(), halvings + 1),
        }
    }
}

/// What is judged of lengths up to H; where that is above the floor, up to H/2 and H/4 as well: the least defect.
fn smoothest<T: Real>(view: &View<'_, '_, T>, most: T, samples: &[Point<T>]) -> Measured {
    let mut found = judged(view, most, samples);
    for part in [T::half(), T::exact(0.25)] {
        let least = match &found {
            Measured::Defect { amplification, floor, .. } if amplification > floor => *amplification,
            _ => break,
        };
        let Ok(samples) = sampled(view, most * part) else { break };
        let again = judged(view, most * part, &samples);
        if again.amplification().is_some_and(|amplification| amplification < least) {
            found = again;
        }
    }
    found
}

/// m.
fn nodes<T: Real>() -> usize {
    if T::unit_roundoff().to_f64() < 1e-20 { 48 } else { 24 }
}

/// cos(k π (j + ½)/m).
fn cosine<T: Real>(k: usize, j: usize, m: usize) -> T {
    // Periodic: the argument stays below 2π.
    (T::pi() * T::ratio(((k * (2 * j + 1)) % (4 * m)) as i64, 2 * m as i64)).cos()
}

/// The ends of the steps.
fn sampled<T: Real>(view: &View<'_, '_, T>, most: T) -> Result<Vec<Point<T>>, StepError> {
    let (start, m) = (view.start(), nodes::<T>());
    let size = |j| most * (T::ratio(9, 16) + T::ratio(7, 16) * cosine::<T>(1, j, m));
    (0..m).map(|j| view.step(&start, size(j))).collect()
}

fn judged<T: Real>(view: &View<'_, '_, T>, most: T, samples: &[Point<T>]) -> Measured {
    let m = samples.len();
    // The same for all components: cosines of 32 digits are dear.
    let waves: Vec<Vec<T>> = (2 * m / 3..m).map(|k| (0..m).map(|j| cosine(k, j, m)).collect()).collect();
    let part = |name: &str, of: fn(&Point<T>) -> &[T]| {
        let size = samples.iter().flat_map(of).fold(T::exact(f64::MIN_POSITIVE), |size, x| size.max(x.abs()));
        let coefficient = |a: usize, wave: &[T]| {
            let terms = samples.iter().zip(wave).map(|(sample, cosine)| of(sample)[a] * *cosine);
            terms.fold(T::zero(), |sum, term| sum + term) * T::ratio(2, m as i64)
        };
        let of_component = |a: usize| waves.iter().map(move |wave| coefficient(a, wave).abs());
        let roughness = (0..of(&samples[0]).len()).flat_map(of_component).fold(T::zero(), |most, c| most.max(c));
        Measured::defect(roughness, size, view.floor(FLOOR), || {
            format!(
                "{LOOSE}, or a rounded step length: {name} after a step is no smooth function of its length between {:.3e} and {:.3e}; \
                 its Chebyshev coefficients from the {}th on are up to {:.1e} of it, as where the equations of a step are solved to \
                 {:.0e} only",
                (most * T::exact(0.125)).to_f64(),
                most.to_f64(),
                2 * m / 3,
                (roughness / size).to_f64(),
                (roughness / size).to_f64() * m as f64,
            )
        })
    };
    part("μ", |point| &point.momentum).and(part("what stands beside μ", |point| &point.attitude))
}
