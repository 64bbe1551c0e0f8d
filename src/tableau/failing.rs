//! The order conditions that fail, written so that a person can act on them.

use super::order::{Conditions, Order};
use super::quantity::{Quantity, digits};
use super::trees::{Catalogue, Tree};
use std::fmt;

/// The largest number of failing conditions listed: those off by most; [`Failing::count`] counts all.
pub const MOST_LISTED: usize = 1000;

/// The conditions of one order that fail.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Failing {
    /// The order: one more than the order of the tableau.
    pub order: usize,
    /// How many fail.
    pub count: usize,
    /// How many there are.
    pub total: usize,
    /// Those that fail, by decreasing |defect|; at most [`MOST_LISTED`].
    pub conditions: Vec<Condition>,
}

/// A condition that fails.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "harness", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Condition {
    /// The tree as brackets, see [`Catalogue::show`].
    pub tree: String,
    /// Σ b Φ as in [`formula`].
    pub formula: String,
    /// γ, and the value that the sum should have is 1/γ.
    pub density: u64,
    /// σ, the number of automorphisms of the tree with its colours.
    pub symmetry: u64,
    /// Σ b Φ.
    pub weight: f64,
    /// Σ b Φ − 1/γ.
    pub defect: f64,
    /// Σ b Φ and Σ b Φ − 1/γ as fractions, where the tableau is rational.
    pub exact: Option<[String; 2]>,
}

impl Failing {
    /// The conditions of the first order that fails; `None` if no condition that was checked does.
    pub fn of<Q: Quantity>(conditions: &mut Conditions<Q>, order: &Order) -> Option<Failing> {
        order.broken.as_ref()?;
        let n = order.order + 1;
        // Two passes: which are off by most, from numbers alone, and then the texts of those.
        let verdicts: Vec<(bool, f64)> = conditions.visit(n, look).collect();
        let mut failing: Vec<usize> = (0..verdicts.len()).filter(|&k| !verdicts[k].0).collect();
        let (count, total) = (failing.len(), verdicts.len());
        failing.sort_by(|&x, &y| size(verdicts[y].1).total_cmp(&size(verdicts[x].1)));
        failing.truncate(MOST_LISTED);
        let trees: Vec<Tree> = conditions.visit(n, |_, tree| Some(tree.clone())).collect();
        let listed = failing.into_iter().map(|k| condition(conditions, &trees[k])).collect();
        Some(Failing { order: n, count, total, conditions: listed })
    }
}

/// |x|, with what is not a number before everything else.
fn size(x: f64) -> f64 {
    if x.is_nan() { f64::INFINITY } else { x.abs() }
}

/// Whether the condition of a tree holds, and the defect.
fn look<Q: Quantity>(conditions: &Conditions<Q>, tree: &Tree) -> Option<(bool, f64)> {
    let verdict = conditions.verdict(tree);
    Some((verdict.holds, verdict.defect))
}

fn condition<Q: Quantity>(conditions: &Conditions<Q>, tree: &Tree) -> Condition {
    let verdict = conditions.verdict(tree);
    Condition {
        tree: conditions.catalogue().show(tree),
        formula: formula(conditions.catalogue(), tree),
        density: tree.density(),
        symmetry: tree.symmetry(),
        weight: verdict.weight,
        defect: verdict.defect,
        exact: conditions.fractions(tree),
    }
}

/// Σ b Φ of a tree as on paper: `Σ b_i c_i a_ij ĉ_j`.
///
/// An index for every vertex with branches, i for the root; an edge to such a vertex is a_ij, or â_ij of colour 1; a leaf is
/// c_i = Σ_j a_ij, or ĉ_i = Σ_j â_ij. Of more than two colours the further ones are named by their number.
pub fn formula(catalogue: &Catalogue, tree: &Tree) -> String {
    let mut text = String::from("Σ b_i");
    let mut indices = 0;
    write_factors(catalogue, tree, &mut indices, &mut text);
    text
}

/// i, j, k, …, z, then i1, j1, …
fn letter(number: usize) -> String {
    let round = number / 18;
    let letter = char::from(b'i' + (number % 18) as u8);
    if round == 0 { letter.into() } else { format!("{letter}{round}") }
}

fn write_factors(catalogue: &Catalogue, tree: &Tree, indices: &mut usize, text: &mut String) {
    let here = letter(*indices);
    *indices += 1;
    let is_leaf = |tree: usize| catalogue.trees()[tree].branches().is_empty();
    for colour in 0..catalogue.colours() {
        let leaves = tree.branches().iter().filter(|edge| edge.colour == colour && is_leaf(edge.tree)).count();
        let power = if leaves > 1 { format!("^{leaves}") } else { String::new() };
        if leaves > 0 {
            *text += &format!(" {}_{here}{power}", name(colour, ["c", "ĉ"]));
        }
    }
    for edge in tree.branches().iter().filter(|edge| !is_leaf(edge.tree)) {
        *text += &format!(" {}_{here}{}", name(edge.colour, ["a", "â"]), letter(*indices));
        write_factors(catalogue, &catalogue.trees()[edge.tree], indices, text);
    }
}

fn name(colour: usize, names: [&str; 2]) -> String {
    names.get(colour).map_or_else(|| format!("{}{colour}", names[0]), |name| name.to_string())
}

impl fmt::Display for Condition {
    /// `Σ b_i c_i a_ij ĉ_j = 1/8, is 0.1203 (off by -4.7e-3)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Enough digits to see the difference, as far as an `f64` has them.
        let count = 2.0 + (self.weight / self.defect).abs().max(1e4).log10().ceil();
        let (mut weight, mut defect) = (digits(self.weight, count as i32), format!("{:.2e}", self.defect));
        if let Some([exact_weight, exact_defect]) = self.exact.as_ref().filter(|exact| exact[1].len() <= 24) {
            weight.clone_from(exact_weight);
            defect = format!("{exact_defect} = {defect}");
        }
        let expected = if self.density == 1 { "1".into() } else { format!("1/{}", self.density) };
        write!(f, "{} = {expected}, is {weight} (off by {defect})", self.formula)
    }
}
