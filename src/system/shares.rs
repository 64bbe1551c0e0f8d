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

/// Every label, with its share. An interval is what 60,000 cases had, half a point to each side. A force counts once for each kind of
/// term that it has.
pub const SHARES: &[Share] = &[
    Share::exact("algebra", "rn", 5.0),
    Share::exact("algebra", "so3", 8.0),
    Share::exact("algebra", "aff1", 2.0),
    Share::exact("algebra", "se2", 2.0),
    Share::exact("algebra", "heisenberg", 2.0),
    Share::exact("algebra", "sl2", 2.0),
    Share::exact("algebra", "se3", 3.0),
    Share::exact("algebra", "so4", 3.0),
    Share::exact("algebra", "product", 4.0),
    Share::exact("algebra", "constants", 4.0),
    // Families of matrices, 65 together: a draw that the knobs do not admit is in vain.
    Share::within("algebra", "commuting", 8.6, 9.6),
    Share::within("algebra", "two-step", 5.5, 6.5),
    Share::within("algebra", "semidirect", 12.8, 13.8),
    Share::within("algebra", "tangent", 5.4, 6.4),
    Share::within("algebra", "incidence", 7.9, 8.9),
    Share::within("algebra", "closure", 4.8, 5.8),
    Share::within("algebra", "derivation", 6.5, 7.5),
    Share::within("algebra", "central", 4.2, 5.2),
    Share::within("algebra", "known", 4.9, 5.9),
    // By invariants that no algebra of the catalogue and no product of them has.
    Share::within("catalogue", "unlisted", 63.7, 64.7),
    Share::within("catalogue", "listed", 35.3, 36.3),
    Share::exact("basis", "standard", 50.0),
    Share::exact("basis", "changed", 50.0),
    Share::exact("lagrangian", "quadratic", 80.0),
    Share::exact("lagrangian", "quartic", 20.0),
    // A half of those that have a group of which it is a map.
    Share::within("retraction", "cayley", 39.7, 40.7),
    Share::within("retraction", "exp", 59.3, 60.3),
    Share::within("angle", "none", 50.5, 51.5),
    Share::within("angle", "tiny", 6.7, 7.7),
    Share::within("angle", "moderate", 35.9, 36.9),
    Share::within("angle", "near-pi", 4.9, 5.9),
    Share::exact("force", "none", 25.0),
    // Some forces vanish on abelian algebras: they are never the only one there.
    Share::within("force", "double-bracket", 23.3, 24.3),
    Share::within("force", "metriplectic", 23.1, 24.1),
    Share::within("force", "linear-drag", 17.1, 18.1),
    Share::within("force", "quadratic-drag", 14.6, 15.6),
    Share::within("force", "constant", 11.4, 12.4),
    Share::within("force", "periodic", 11.6, 12.6),
    Share::within("class", "abelian", 4.6, 5.6),
    Share::within("class", "nilpotent", 16.6, 17.6),
    Share::within("class", "solvable", 50.8, 51.8),
    Share::within("class", "simple", 11.2, 12.2),
    Share::within("class", "semisimple", 4.5, 5.5),
    Share::within("class", "mixed", 9.3, 10.3),
    Share::within("unimodular", "yes", 58.1, 59.1),
    Share::within("unimodular", "no", 40.9, 41.9),
    Share::within("dimension", "1", 0.7, 1.7),
    Share::within("dimension", "2", 2.8, 3.8),
    Share::within("dimension", "3", 26.9, 27.9),
    Share::within("dimension", "4", 23.9, 24.9),
    Share::within("dimension", "5", 14.4, 15.4),
    Share::within("dimension", "6", 20.3, 21.3),
    Share::within("dimension", "7", 1.7, 2.7),
    Share::within("dimension", "8", 2.0, 3.0),
    Share::within("dimension", "9", 1.0, 2.0),
    Share::within("dimension", "10", 1.2, 2.2),
    Share::within("inertia", "unit", 9.7, 10.7),
    Share::within("inertia", "diagonal", 29.4, 30.4),
    Share::within("inertia", "full", 29.5, 30.5),
    Share::within("inertia", "thin", 19.6, 20.6),
    Share::within("inertia", "nearly-unit", 9.3, 10.3),
    // Weights out of 126 for the named ones, which are four of nine, and so on.
    Share::exact("tableau", "gauss", 100.0 * 992.0 / 9450.0),
    Share::exact("tableau", "lobatto", 100.0 * 1440.0 / 9450.0),
    Share::exact("tableau", "radau", 100.0 * 960.0 / 9450.0),
    Share::exact("tableau", "classic", 100.0 * 1018.0 / 9450.0),
    Share::within("tableau", "explicit", 11.1, 12.1),
    Share::within("tableau", "diagonally-implicit", 16.2, 17.2),
    Share::within("tableau", "fully-implicit", 24.5, 25.5),
];
