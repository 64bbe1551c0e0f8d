//! Properties of `euler_poincare::harness::lower`: no Taylor series is refused, lower orders are found.

use euler_poincare::harness::lower::{Share, Signed, share};

/// Numbers in [−1, 1], the same on every machine.
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Σ a_k h^{k + power} of two components with noise, at h = 1, 3/4, 1/2, 3/8, … times `first`, until it is noise.
fn line(stream: &mut Stream, series: &[[f64; 2]], power: u32, first: f64, noise: f64) -> Vec<Signed> {
    let sizes = (0..32).map(|k| first * 0.5_f64.powi(k / 2) * if k % 2 == 0 { 1.0 } else { 0.75 });
    let level = |h: f64| {
        let sum = |c: usize| series.iter().rev().fold(0.0, |sum, a| sum * h + a[c]) * h.powi(power as i32);
        let error = (0..2).map(|c| sum(c) + noise * stream.next()).collect();
        Signed { h, error, noise }
    };
    sizes.map(level).collect()
}

/// Of lines of series with these coefficients and this power, none is refuted; how many are confirmed, and how many open.
fn none_is_refuted(seed: u64, cases: u32, series: impl Fn(&mut Stream, u32) -> (Vec<[f64; 2]>, u32)) -> (usize, usize) {
    let (mut stream, mut small, mut open) = (Stream(seed), 0, 0);
    for case in 0..cases {
        let (series, power) = series(&mut stream, case);
        let levels = line(&mut stream, &series, power, 0.5, 1e-14);
        match share(&levels, power) {
            Some(Share::Large(part)) => panic!("case {case}: {part}: {levels:?}"),
            Some(Share::Small(_)) => small += 1,
            _ => open += 1,
        }
    }
    (small, open)
}

#[test]
fn no_series_of_the_claimed_order_is_refuted() {
    let (small, open) = none_is_refuted(1, 6000, |stream, case| {
        // Coefficients grow with the order; the first are small or of either sign: slopes settle late, or not above the noise.
        let growth = 1.0 + 0.75 * stream.next();
        let faint = 10_f64.powf(-1.5 + 1.5 * stream.next());
        let scale = |k: i32| growth.powi(k) * if k == 0 { faint } else { 1.0 };
        ((0..12).map(|k| [scale(k) * stream.next(), scale(k) * stream.next()]).collect(), 2 + case % 6)
    });
    assert!(small > open, "{small} confirmed, {open} open");
}

/// The first two terms cancel at a step between the levels: the slopes rise towards it and fall behind it.
#[test]
fn no_series_that_passes_through_zero_is_refuted() {
    none_is_refuted(5, 6000, |stream, case| {
        let zero = 10_f64.powf(-1.5 + 1.5 * stream.next());
        let growth = 1.0 + 0.75 * stream.next();
        // (h − zero) Σ b_k h^k in both components.
        let factor: Vec<f64> = (0..11).map(|k| growth.powi(k) * if k == 0 { 1.0 } else { stream.next() }).collect();
        let term = |k: usize| factor.get(k).copied().unwrap_or(0.0);
        let series = (0..12).map(|k| if k == 0 { 0.0 } else { term(k - 1) } - zero * term(k));
        (series.map(|a| [a, -0.5 * a]).collect(), 2 + case % 6)
    });
}

/// Errors of a much higher order than claimed, whose first terms cancel at a step between the levels.
#[test]
fn no_error_that_falls_faster_than_claimed_is_refuted() {
    none_is_refuted(6, 3000, |stream, case| {
        let zero = 10_f64.powf(-2.0 + 1.5 * stream.next());
        let mut series = vec![[0.0, 0.0]; 1 + (case as usize / 4) % 5];
        series.extend([[-zero, 0.5 * zero], [1.0, -0.5], [stream.next(), stream.next()]]);
        (series, 2 + case % 4)
    });
}

#[test]
fn lower_orders_are_refuted() {
    let mut stream = Stream(2);
    let mut refuted = 0;
    for case in 0..1000 {
        let power = 2 + case % 4;
        let series: Vec<[f64; 2]> = (0..8).map(|_| [stream.next(), stream.next()]).collect();
        match share(&line(&mut stream, &series, power, 0.5, 1e-15), power + 1) {
            Some(Share::Large(_)) => refuted += 1,
            Some(Share::Small(part)) => panic!("case {case}: {part}"),
            _ => {}
        }
    }
    assert!(refuted > 950, "{refuted}");
}

#[test]
fn a_line_that_is_too_short_or_no_line_says_nothing() {
    let mut stream = Stream(3);
    let levels = line(&mut stream, &[[1.0, 1.0]], 3, 0.5, 1e-15);
    assert_eq!(share(&levels[..5], 3), None);
    assert_eq!(share(&[], 3), None);
    let twice: Vec<Signed> = levels.iter().chain(&levels[..1]).cloned().collect();
    assert_eq!(share(&twice, 3), None);
    let mut nan = levels;
    nan[4].error[1] = f64::NAN;
    assert_eq!(share(&nan, 3), None);
}

#[test]
fn what_emerges_below_the_noise_is_not_confirmed() {
    let mut stream = Stream(4);
    let mut levels = line(&mut stream, &[[1.0, 0.5]], 4, 0.5, 1e-15);
    assert!(matches!(share(&levels, 4), Some(Share::Small(_))));
    levels.iter_mut().for_each(|level| level.error[0] += 1e-12);
    assert!(!matches!(share(&levels, 4), Some(Share::Small(_))));
}
