//! What share of random cases is an example of what: the distribution of [`cases`](super::cases), declared.
//!
//! Shares are of the labels of [`labels`](super::labels), in percent, for cases without knobs. Where a share is drawn by weights it
//! is exact; where it follows from several draws (a class of the algebra, an angle near π of a group that has rotations) it is known
//! to lie in an interval. Samples are tested against both.

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

    const fn within(category: &'static str, label: &'static str, least: f64, most: f64) -> Self {
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

/// Every label, with its share; the intervals are those of a second program that draws the same, half a point to each side (of the
/// angles, which need the system, as they were found). A force counts once for each kind of term that it has.
pub const SHARES: &[Share] = &[
    Share::exact("algebra", "rn", 8.0),
    Share::exact("algebra", "so3", 15.0),
    Share::exact("algebra", "aff1", 8.0),
    Share::exact("algebra", "se2", 8.0),
    Share::exact("algebra", "heisenberg", 8.0),
    Share::exact("algebra", "sl2", 8.0),
    Share::exact("algebra", "se3", 9.0),
    Share::exact("algebra", "so4", 9.0),
    Share::exact("algebra", "product", 15.0),
    Share::exact("algebra", "constants", 12.0),
    Share::exact("basis", "standard", 50.0),
    Share::exact("basis", "changed", 50.0),
    Share::exact("lagrangian", "quadratic", 80.0),
    Share::exact("lagrangian", "quartic", 20.0),
    // A half of those that have a group.
    Share::exact("retraction", "cayley", 44.0),
    Share::exact("retraction", "exp", 56.0),
    Share::exact("angle", "none", 56.0),
    Share::within("angle", "tiny", 6.3, 7.3),
    Share::within("angle", "moderate", 30.6, 31.6),
    Share::within("angle", "near-pi", 5.4, 6.4),
    Share::exact("force", "none", 25.0),
    // Some forces vanish on abelian algebras: they are never the only one there.
    Share::within("force", "double-bracket", 22.7, 23.7),
    Share::within("force", "metriplectic", 22.7, 23.7),
    Share::within("force", "linear-drag", 17.2, 18.2),
    Share::within("force", "quadratic-drag", 15.1, 16.1),
    Share::within("force", "constant", 12.0, 13.0),
    Share::within("force", "periodic", 12.0, 13.0),
    Share::within("class", "abelian", 8.2, 9.2),
    Share::within("class", "nilpotent", 13.1, 14.1),
    Share::within("class", "solvable", 24.8, 25.8),
    Share::within("class", "simple", 23.6, 24.6),
    Share::within("class", "semisimple", 10.0, 11.0),
    Share::within("class", "mixed", 17.3, 18.3),
    Share::within("unimodular", "yes", 82.8, 83.8),
    Share::within("unimodular", "no", 16.2, 17.2),
    Share::within("dimension", "1", 1.8, 2.8),
    Share::within("dimension", "2", 9.9, 10.9),
    Share::within("dimension", "3", 45.6, 46.6),
    Share::within("dimension", "4", 6.9, 7.9),
    Share::within("dimension", "5", 6.5, 7.5),
    Share::within("dimension", "6", 22.8, 23.8),
    Share::within("dimension", "7", 0.8, 1.8),
    Share::within("dimension", "8", 1.8, 2.8),
    Share::within("dimension", "9", 2.6, 3.6),
    Share::within("dimension", "10", 0.05, 0.7),
    Share::within("inertia", "unit", 9.7, 10.7),
    Share::within("inertia", "diagonal", 30.1, 31.1),
    Share::within("inertia", "full", 29.6, 30.6),
    Share::within("inertia", "thin", 18.3, 19.3),
    Share::within("inertia", "nearly-unit", 9.7, 10.7),
    // Weights out of 126 for the named ones, which are four of nine, and so on.
    Share::exact("tableau", "gauss", 100.0 * 992.0 / 9450.0),
    Share::exact("tableau", "lobatto", 100.0 * 1440.0 / 9450.0),
    Share::exact("tableau", "radau", 100.0 * 960.0 / 9450.0),
    Share::exact("tableau", "classic", 100.0 * 1018.0 / 9450.0),
    Share::within("tableau", "explicit", 11.1, 12.1),
    Share::within("tableau", "diagonally-implicit", 16.2, 17.2),
    Share::within("tableau", "fully-implicit", 24.5, 25.5),
];
