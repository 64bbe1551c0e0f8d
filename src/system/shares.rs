//! What share of random cases is an example of what: the distribution of [`cases`](super::cases), declared.
//!
//! Shares are of the labels of [`labels`](super::labels), in percent, for cases without knobs. Where a share is drawn by weights it
//! is exact; where it follows from several draws (a class of the algebra, an angle near π of a group that has rotations) it is known
//! to lie in an interval. Samples are tested against both.

pub use super::potential::POTENTIAL_SHARES;

use super::case::Tau;
use super::force::FORCE_SHARES;
use crate::algebra::AlgebraFamily;
use crate::algebra::catalogue::{Entry, Kind};
use std::sync::LazyLock;

/// The share of the cases that have a label.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// What kind of label.
    pub category: &'static str,
    /// The label.
    pub label: &'static str,
    /// No less than this, in percent.
    pub least: f64,
    /// No more than this, in percent; the same as `least` where the share is exact.
    pub most: f64,
}

impl Share {
    const fn exact(category: &'static str, label: &'static str, share: f64) -> Self {
        Self { category, label, least: share, most: share }
    }

    pub(super) const fn within(category: &'static str, label: &'static str, least: f64, most: f64) -> Self {
        Self { category, label, least, most }
    }

    /// How surprising it is that `count` of `cases` cases have the label, as a bound on the probability of a count that is as
    /// far off on its side, for the share in the interval that explains it best: exp(−n D), with D the divergence of Bernoulli
    /// distributions, D(q‖p) = q ln(q/p) + (1 − q) ln((1 − q)/(1 − p)); 1 where the share that was seen is in the interval.
    ///
    /// Source: Chernoff 1952, Hoeffding 1963 (Thm 1): P(S ≥ qn) ≤ exp(−n D(q‖p)) for q ≥ p, and likewise below. It holds for
    /// every n.
    pub fn surprise(&self, count: usize, cases: usize) -> f64 {
        let (seen, n) = (count as f64 / cases.max(1) as f64, cases as f64);
        let expected = seen.clamp(self.least / 100.0, self.most / 100.0);
        let part = |q: f64, p: f64| if q == 0.0 { 0.0 } else { q * (q / p).ln() };
        (-n * (part(seen, expected) + part(1.0 - seen, 1.0 - expected)).max(0.0)).exp()
    }
}

/// Every label, with its share. An interval is what 60,000 cases had, half a point to each side or less. A force counts once for each kind of
/// term that it has; some vanish on abelian algebras, and are never the only one there.
pub static SHARES: LazyLock<Vec<Share>> = LazyLock::new(|| {
    let named = |(entry, weight): (Entry, usize)| match entry.kind() {
        Kind::Named(named) => Some(Share::exact("algebra", named.name, weight as f64)),
        _ => None,
    };
    let family =
        |(family, (least, most)): (AlgebraFamily, (f64, f64))| Share::within("algebra", family.name(), least, most);
    let retraction = |tau: &Tau| {
        let (least, most) = tau.known().share;
        Share::within("retraction", tau.name(), least, most)
    };
    let mut shares = vec![Share::exact("algebra", "rn", 3.0)];
    shares.extend(Entry::drawn().into_iter().filter_map(named));
    shares.extend(["product", "constants"].map(|label| Share::exact("algebra", label, 3.0)));
    shares.extend(AlgebraFamily::ALL.into_iter().zip(AlgebraFamily::SHARES).map(family));
    let (algebras, others) =
        OTHERS.split_at(OTHERS.iter().position(|share| share.category == "retraction").unwrap_or(0));
    shares.extend_from_slice(algebras);
    shares.extend(Tau::ALL.iter().rev().map(retraction));
    shares.extend_from_slice(others);
    shares.extend_from_slice(FORCE_SHARES);
    shares
});

/// The shares of labels that are not names of algebras and of retractions, and not of forces.
const OTHERS: &[Share] = &[
    Share::within("algebra", "known", 4.8, 5.8),
    // By invariants that no algebra of the catalogue and no product of them has.
    Share::within("catalogue", "unlisted", 67.8, 68.8),
    Share::within("catalogue", "listed", 31.2, 32.2),
    Share::exact("basis", "standard", 50.0),
    Share::exact("basis", "changed", 50.0),
    Share::within("lagrangian", "quadratic", 59.9, 60.9),
    Share::within("lagrangian", "quartic", 11.3, 12.3),
    Share::within("lagrangian", "metric", 8.5, 9.5),
    Share::within("lagrangian", "gyrostat", 11.3, 12.3),
    Share::within("lagrangian", "gyrostat-quartic", 6.5, 7.5),
    Share::within("retraction", "composed", 19.2, 20.2),
    Share::within("angle", "none", 50.2, 51.2),
    Share::within("angle", "tiny", 5.5, 6.5),
    Share::within("angle", "moderate", 38.5, 39.5),
    Share::within("angle", "near-pi", 3.6, 4.2),
    // A free system has no force that could grow, or turn its motion.
    Share::within("start", "moving", 93.5, 94.5),
    Share::within("start", "rest", 3.5, 4.5),
    Share::within("start", "turning", 1.5, 2.5),
    Share::within("step", "usual", 84.3, 85.3),
    Share::within("step", "large", 6.7, 7.7),
    Share::within("step", "negative", 7.6, 8.6),
    Share::exact("force", "none", 25.0),
    Share::within("class", "abelian", 2.5, 3.5),
    Share::within("class", "nilpotent", 17.3, 18.3),
    Share::within("class", "solvable", 53.6, 54.6),
    Share::within("class", "simple", 10.2, 11.2),
    Share::within("class", "semisimple", 4.7, 5.7),
    Share::within("class", "mixed", 9.3, 10.3),
    Share::within("unimodular", "yes", 55.9, 56.9),
    Share::within("unimodular", "no", 43.1, 44.1),
    Share::within("dimension", "1", 0.2, 1.2),
    Share::within("dimension", "2", 2.7, 3.7),
    Share::within("dimension", "3", 25.8, 26.8),
    Share::within("dimension", "4", 24.7, 25.7),
    Share::within("dimension", "5", 15.2, 16.2),
    Share::within("dimension", "6", 21.0, 22.0),
    Share::within("dimension", "7", 1.8, 2.8),
    Share::within("dimension", "8", 1.9, 2.9),
    Share::within("dimension", "9", 1.1, 2.1),
    Share::within("dimension", "10", 1.2, 2.2),
    Share::within("inertia", "unit", 9.6, 10.6),
    Share::within("inertia", "diagonal", 27.8, 28.8),
    Share::within("inertia", "full", 27.6, 28.6),
    Share::within("inertia", "thin", 18.9, 19.9),
    Share::within("inertia", "nearly-unit", 9.8, 10.8),
    Share::within("inertia", "indefinite", 3.2, 4.2),
    // Weights out of 126 for the named ones, which are four of nine, and so on.
    Share::exact("tableau", "gauss", 100.0 * 992.0 / 9450.0),
    Share::exact("tableau", "lobatto", 100.0 * 1440.0 / 9450.0),
    Share::exact("tableau", "radau", 100.0 * 960.0 / 9450.0),
    Share::exact("tableau", "classic", 100.0 * 1018.0 / 9450.0),
    Share::within("tableau", "explicit", 11.1, 12.1),
    Share::within("tableau", "diagonally-implicit", 16.2, 17.2),
    Share::within("tableau", "fully-implicit", 24.5, 25.5),
];
