//! The families of cases: every label that a case can carry.

/// The categories of [`labels`](super::labels) and the labels of each, in the order in which a person reads them.
///
/// A campaign that has no case of one of them has not seen that family. The strategies draw all of them, up to the knobs.
pub const FAMILIES: [(&str, &[&str]); 11] = [
    ("algebra", &["rn", "aff1", "se2", "heisenberg", "so3", "sl2", "se3", "so4", "product", "constants"]),
    ("dimension", &["1", "2", "3", "4", "5", "6", "7", "8"]),
    ("class", &["abelian", "nilpotent", "solvable", "simple", "semisimple", "mixed"]),
    ("unimodular", &["yes", "no"]),
    ("basis", &["standard", "changed"]),
    ("inertia", &["unit", "nearly-unit", "thin", "diagonal", "full"]),
    ("lagrangian", &["quadratic", "quartic"]),
    ("force", &["none", "constant", "periodic", "linear-drag", "quadratic-drag", "double-bracket", "metriplectic"]),
    ("angle", &["none", "tiny", "moderate", "near-pi"]),
    ("retraction", &["exp", "cayley"]),
    ("tableau", &["gauss", "lobatto", "radau", "classic", "explicit", "diagonally-implicit", "fully-implicit"]),
];
