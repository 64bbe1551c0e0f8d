//! What a Lie algebra is, by numbers that do not depend on the basis.

use super::catalogue::Entry;
use super::families::named;
use super::rational::RationalAlgebra;
use std::fmt;
use std::sync::LazyLock;

/// The class of a Lie algebra: the narrowest that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AlgebraClass {
    /// All brackets vanish.
    Abelian,
    /// The lower central series ends in 0.
    Nilpotent,
    /// The derived series ends in 0.
    Solvable,
    /// Without ideals: semisimple, of dimension below 6.
    Simple,
    /// With a regular Killing form.
    Semisimple,
    /// None of these.
    Mixed,
}

impl fmt::Display for AlgebraClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

/// Numbers that are the same for isomorphic algebras; exact.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct AlgebraInvariants {
    /// n.
    pub dimension: usize,
    /// The dimensions of g, \[g, g\], \[\[g, g\], \[g, g\]\], …, to where they stay.
    pub derived_series: Vec<usize>,
    /// The dimensions of g, \[g, g\], \[g, \[g, g\]\], …, to where they stay.
    pub lower_central_series: Vec<usize>,
    /// How many squares of the Killing form are positive, negative and zero.
    pub killing: [usize; 3],
    /// The dimension of the centre.
    pub centre: usize,
    /// Whether tr ad_ξ = 0 for all ξ.
    pub unimodular: bool,
}

impl AlgebraInvariants {
    pub(crate) fn of(algebra: &RationalAlgebra) -> Self {
        Self {
            dimension: algebra.dimension(),
            derived_series: algebra.series(false),
            lower_central_series: algebra.series(true),
            killing: algebra.killing_signature(),
            centre: algebra.centre().len(),
            unimodular: algebra.is_unimodular(),
        }
    }

    /// The class.
    pub fn class(&self) -> AlgebraClass {
        match self {
            _ if self.centre == self.dimension => AlgebraClass::Abelian,
            _ if self.lower_central_series.last() == Some(&0) => AlgebraClass::Nilpotent,
            _ if self.derived_series.last() == Some(&0) => AlgebraClass::Solvable,
            // The least is of dimension 3, and there is none of 4 or 5: below 6 it is not a sum of two.
            _ if self.killing[2] == 0 && self.dimension < 6 => AlgebraClass::Simple,
            _ if self.killing[2] == 0 => AlgebraClass::Semisimple,
            _ => AlgebraClass::Mixed,
        }
    }

    /// Those of the direct product.
    fn beside(&self, other: &Self) -> Self {
        let sum = |x: &[usize], y: &[usize]| {
            let at = |list: &[usize], k: usize| list.get(k).or(list.last()).copied().unwrap_or(0);
            (0..x.len().max(y.len())).map(|k| at(x, k) + at(y, k)).collect()
        };
        Self {
            dimension: self.dimension + other.dimension,
            derived_series: sum(&self.derived_series, &other.derived_series),
            lower_central_series: sum(&self.lower_central_series, &other.lower_central_series),
            killing: std::array::from_fn(|k| self.killing[k] + other.killing[k]),
            centre: self.centre + other.centre,
            unimodular: self.unimodular && other.unimodular,
        }
    }

    /// Whether no algebra of the catalogue, and no direct product of them, has the same invariants: then it is isomorphic to none.
    pub fn is_unlisted(&self) -> bool {
        !LISTED.contains(self)
    }
}

impl fmt::Display for AlgebraInvariants {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [plus, minus, zero] = self.killing;
        let unimodular = if self.unimodular { "unimodular" } else { "not unimodular" };
        write!(f, "{}, {unimodular}, of dimension {}, centre {}, ", self.class(), self.dimension, self.centre)?;
        write!(f, "derived series {:?}, lower central series {:?}, ", self.derived_series, self.lower_central_series)?;
        write!(f, "Killing form {plus} positive, {minus} negative, {zero} zero")
    }
}

/// Products are looked at up to this dimension.
const LARGEST: usize = 10;

/// Those of the catalogue and of all direct products of it of dimension up to 10.
static LISTED: LazyLock<Vec<AlgebraInvariants>> = LazyLock::new(|| {
    let of = |entry: &Entry| RationalAlgebra::of_matrices(&named(entry)).ok();
    let factors: Vec<_> = Entry::drawn()
        .iter()
        .filter_map(|(entry, _)| of(entry))
        .map(|algebra| AlgebraInvariants::of(&algebra))
        .collect();
    // Multisets: each product with the factors from its last one on.
    let mut all: Vec<(usize, AlgebraInvariants)> = factors.iter().cloned().enumerate().collect();
    let mut next = 0;
    while next < all.len() {
        let (last, product) = all[next].clone();
        for (k, factor) in factors.iter().enumerate().skip(last) {
            if product.dimension + factor.dimension <= LARGEST {
                all.push((k, product.beside(factor)));
            }
        }
        next += 1;
    }
    let mut listed: Vec<_> = all.into_iter().map(|(_, product)| product).collect();
    listed.dedup();
    listed
});
