//! What a tableau looks like: the zeros of a, symmetry of the method, symplecticity.

use super::quantity::{Coefficients, Quantity};
use std::fmt;

/// The zeros of a.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Shape {
    /// a is strictly lower triangular.
    Explicit,
    /// a is lower triangular with equal diagonal entries.
    SinglyDiagonallyImplicit,
    /// a is lower triangular.
    DiagonallyImplicit,
    /// Anything else.
    FullyImplicit,
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Shape::Explicit => "explicit",
            Shape::SinglyDiagonallyImplicit => "singly diagonally implicit",
            Shape::DiagonallyImplicit => "diagonally implicit",
            Shape::FullyImplicit => "fully implicit",
        })
    }
}

impl Shape {
    /// By the entries that vanish.
    pub fn of<Q: Quantity>(coefficients: &Coefficients<Q>) -> Self {
        let a = &coefficients.a;
        let zero = |first: usize| (0..a.len()).all(|i| (i + first..a.len()).all(|j| a[i][j].vanishes(1)));
        match (zero(0), zero(1)) {
            (true, _) => Shape::Explicit,
            (_, true) if (1..a.len()).all(|i| a[i][i].minus(&a[0][0]).vanishes(4)) => Shape::SinglyDiagonallyImplicit,
            (_, true) => Shape::DiagonallyImplicit,
            _ => Shape::FullyImplicit,
        }
    }
}

/// Whether the method is its own adjoint: stepping back with −h undoes the step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// a_ij + a_σ(i)σ(j) = b_j and b_σ(j) = b_j for this permutation of the stages (from 0; most often the reversal).
    Symmetric(Vec<usize>),
    /// No permutation does it.
    None,
    /// The search was given up after [`MOST_TRIALS`] partial permutations.
    Undecided,
}

/// How many partial permutations are tried.
pub const MOST_TRIALS: usize = 100_000;

impl Symmetry {
    /// By a search over the permutations that map b to b and c to 1 − c, the reversal first.
    ///
    /// A method with stages that do not matter, or several that are equal, can be symmetric without such a permutation: then
    /// the answer is about the tableau, not the method. Source: Hairer, Lubich and Wanner, *Geometric Numerical
    /// Integration*, theorem V.2.3.
    pub fn of<Q: Quantity>(coefficients: &Coefficients<Q>) -> Self {
        let mut search = Search { coefficients, sigma: Vec::new(), trials: 0 };
        match search.extend() {
            Some(true) => Symmetry::Symmetric(search.sigma),
            Some(false) => Symmetry::None,
            None => Symmetry::Undecided,
        }
    }

    /// Whether a permutation was found.
    pub fn holds(&self) -> bool {
        matches!(self, Symmetry::Symmetric(_))
    }
}

struct Search<'t, Q> {
    coefficients: &'t Coefficients<Q>,
    sigma: Vec<usize>,
    trials: usize,
}

impl<Q: Quantity> Search<'_, Q> {
    /// Whether the partial permutation can be completed; `None` when there were too many trials.
    fn extend(&mut self) -> Option<bool> {
        let (i, s) = (self.sigma.len(), self.coefficients.stages());
        if i == s {
            return Some(true);
        }
        for image in (0..s).map(|k| (2 * s - 1 - i - k) % s) {
            self.trials += 1;
            if self.trials > MOST_TRIALS {
                return None;
            }
            if !self.sigma.contains(&image) && self.fits(i, image) {
                self.sigma.push(image);
                if self.extend()? {
                    return Some(true);
                }
                self.sigma.pop();
            }
        }
        Some(false)
    }

    /// Whether σ(i) = `image` agrees with the rows and columns that are fixed so far.
    fn fits(&mut self, i: usize, image: usize) -> bool {
        let Coefficients { a, b, c, .. } = self.coefficients;
        let s = b.len();
        if !b[i].minus(&b[image]).vanishes(8) || !c[i].plus(&c[image]).minus(&Q::fraction(1, 1)).vanishes(8 * s) {
            return false;
        }
        let reflected = |i: usize, j: usize, k: usize, l: usize| a[i][j].plus(&a[k][l]).minus(&b[j]).vanishes(16);
        let with = |j: usize, to: usize| reflected(i, j, image, to) && reflected(j, i, to, image);
        self.sigma.iter().enumerate().all(|(j, &to)| with(j, to)) && reflected(i, i, image, image)
    }
}

/// Whether b_i a_ij + b_j a_ji = b_i b_j for all i and j: the method is symplectic (Sanz-Serna 1988), a = â, and on a Lie
/// group the pair is one method.
pub fn is_symplectic<Q: Quantity>(coefficients: &Coefficients<Q>) -> bool {
    let Coefficients { a, b, .. } = coefficients;
    let holds = |i: usize, j: usize| {
        let left = b[i].times(&a[i][j]).plus(&b[j].times(&a[j][i]));
        left.minus(&b[i].times(&b[j])).vanishes(16)
    };
    (0..b.len()).all(|i| (0..=i).all(|j| holds(i, j)))
}
