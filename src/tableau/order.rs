//! The order of a tableau, computed from its coefficients by the order conditions Σ_i b_i Φ_i(t) = 1/γ(t).
//!
//! Φ_i(t) = Π over the branches (colour, u) of t of Σ_j a^{(colour)}_ij Φ_j(u). Plain Runge–Kutta conditions use one
//! colour, a. The variational integrators on a Lie group need two, a and its conjugate â (Martín de Diego and Sato Martín
//! de Almagro 2019): every bicoloured rooted tree counts.

use super::Tableau;
use super::trees::{Catalogue, Tree};
use crate::scalar::Real;
use nalgebra::DMatrix;
use std::fmt;

/// The highest order that [`classical_order`] checks (235 381 trees of order 16).
pub const MAX_CLASSICAL: usize = 16;

/// The highest order that [`variational_order`] checks (492 180 oriented trees of order 12).
pub const MAX_VARIATIONAL: usize = 12;

/// What the order conditions say.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Every condition up to this order holds.
    pub order: usize,
    /// The first condition of the next order that fails; `None` if no condition that was checked fails: the order is *at
    /// least* [`Order::order`].
    pub broken: Option<Broken>,
}

/// An order condition that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The tree, as in [`Catalogue::show`]: edges of â carry a tick.
    pub tree: String,
    /// Σ b Φ.
    pub weight: f64,
    /// 1/γ.
    pub expected: f64,
    /// |Σ b Φ − 1/γ|, formed in the scalar of the tableau.
    pub defect: f64,
    /// The bound on round-off that the defect exceeds.
    pub tolerance: f64,
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.broken {
            Some(_) => write!(f, "{}", self.order),
            None => write!(f, "at least {}", self.order),
        }
    }
}

/// The order of (a, b) as a Runge–Kutta method, checked up to `max` (at most [`MAX_CLASSICAL`]).
///
/// A condition counts as violated if its defect exceeds 8 n (s + 2) u Σ|b||Φ|, where |Φ| is formed with the magnitudes
/// |a_ij| + |b_j|, n is the order of the tree and u the unit round-off: a bound on what rounding the coefficients and
/// evaluating the sum can do. So the order of coefficients known to fewer digits than `T` has is that of the rounded ones.
///
/// Source: Butcher 1963; Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, theorem II.2.13.
pub fn classical_order<T: Real>(tableau: &Tableau<T>, max: usize) -> Order {
    let mut conditions = Conditions::new(tableau, 1);
    check(max.min(MAX_CLASSICAL), |n| {
        conditions.prepare(n - 1);
        conditions.catalogue.extend_to(n);
        conditions.first_broken(conditions.catalogue.of_order(n).iter())
    })
}

/// The order of the pair (a, â) of a tableau and its conjugate, checked up to `max` (at most [`MAX_VARIATIONAL`]): the
/// largest p such that every bicoloured rooted tree of order ≤ p satisfies Σ b Φ = 1/γ.
///
/// It is the order of the forced variational integrator with this tableau on a general Lie group; for forces or groups
/// that are special it can be exceeded. The tolerance is that of [`classical_order`].
///
/// Only one tree is evaluated for each *oriented free tree*. From b_i â_ij + b_j a_ji = b_i b_j, if u and v have their
/// roots joined, Σb Φ(u with branch v along â) + Σb Φ(v with branch u along a) = Σb Φ(u) Σb Φ(v), and the values
/// 1/γ satisfy the same identity. So, given the conditions of lower order, moving the root along an edge while its
/// colour changes leaves the truth of a condition as it was: what counts is the tree without its root, its edges oriented.
pub fn variational_order<T: Real>(tableau: &Tableau<T>, max: usize) -> Order {
    let mut conditions = Conditions::new(tableau, 2);
    check(max.min(MAX_VARIATIONAL), |n| {
        conditions.prepare(n / 2);
        conditions.first_broken(conditions.catalogue.oriented(n))
    })
}

fn check(max: usize, mut broken_at: impl FnMut(usize) -> Option<Broken>) -> Order {
    for n in 1..=max {
        if let Some(broken) = broken_at(n) {
            return Order { order: n - 1, broken: Some(broken) };
        }
    }
    Order { order: max, broken: None }
}

/// A stage vector of a tree and the bound on its terms.
struct Stages<T> {
    value: Vec<T>,
    size: Vec<T>,
}

/// The elementary weights of a tableau, with what the trees have in common computed once.
pub struct Conditions<'t, T: Real> {
    tableau: &'t Tableau<T>,
    /// The matrix of each colour, and the magnitudes that its entries are computed from.
    matrices: Vec<(DMatrix<T>, DMatrix<T>)>,
    catalogue: Catalogue,
    /// Σ_j a^{(colour)}_ij Φ_j(tree), at tree · colours + colour.
    branches: Vec<Stages<T>>,
}

/// Σ b Φ and the same sum over magnitudes.
#[derive(Clone, Copy, Debug)]
pub struct Weight<T> {
    /// Σ_i b_i Φ_i.
    pub value: T,
    /// Σ_i |b_i| |Φ_i|, |Φ| formed with magnitudes: round-off is this times a modest multiple of u.
    pub size: T,
}

impl<'t, T: Real> Conditions<'t, T> {
    /// For trees with edges of `colours` colours: 1 for a alone, 2 for a and â.
    pub fn new(tableau: &'t Tableau<T>, colours: usize) -> Self {
        let (s, b) = (tableau.stages(), tableau.b());
        let magnitude = |a: &DMatrix<T>| DMatrix::from_fn(s, s, |i, j| a[(i, j)].abs() + b[j].abs());
        let first = (tableau.a().clone(), magnitude(tableau.a()));
        let conjugate = tableau.conjugate().a().clone();
        // â_ij = b_j − b_j a_ji/b_i: an error u b_i of a_ji becomes one of u b_j, so b_j again measures it.
        let size = magnitude(&conjugate);
        let matrices = if colours == 1 { vec![first] } else { vec![first, (conjugate, size)] };
        let catalogue = Catalogue::new(matrices.len());
        Self { tableau, matrices, catalogue, branches: Vec::new() }
    }

    /// The trees known so far.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Makes the trees up to `order` available as branches.
    pub fn prepare(&mut self, order: usize) {
        self.catalogue.extend_to(order);
        for number in self.branches.len() / self.matrices.len()..self.catalogue.trees().len() {
            let phi = self.stages(&self.catalogue.trees()[number]);
            for (a, size) in &self.matrices {
                self.branches.push(Stages { value: product(a, &phi.value), size: product(size, &phi.size) });
            }
        }
    }

    fn stages(&self, tree: &Tree) -> Stages<T> {
        let s = self.tableau.stages();
        let mut phi = Stages { value: vec![T::one(); s], size: vec![T::one(); s] };
        for edge in tree.branches() {
            let branch = &self.branches[edge.tree * self.matrices.len() + edge.colour];
            for i in 0..s {
                phi.value[i] *= branch.value[i];
                phi.size[i] *= branch.size[i];
            }
        }
        phi
    }

    /// Σ b Φ of a tree whose branches are [prepared](Conditions::prepare).
    pub fn weight(&self, tree: &Tree) -> Weight<T> {
        let phi = self.stages(tree);
        let mut sum = Weight { value: T::zero(), size: T::zero() };
        for (i, &b) in self.tableau.b().iter().enumerate() {
            sum.value += b * phi.value[i];
            sum.size += b.abs() * phi.size[i];
        }
        sum
    }

    /// The defect |Σ b Φ − 1/γ| and the bound on its round-off.
    pub fn defect(&self, tree: &Tree) -> (T, T) {
        let weight = self.weight(tree);
        let steps = 8 * tree.order() * (self.tableau.stages() + 2);
        let tolerance = T::int(steps as i64) * T::unit_roundoff() * weight.size;
        ((weight.value - T::ratio(1, tree.density() as i64)).abs(), tolerance)
    }

    fn first_broken<R: std::borrow::Borrow<Tree>>(&self, mut trees: impl Iterator<Item = R>) -> Option<Broken> {
        trees.find_map(|tree| {
            let tree = tree.borrow();
            let (defect, tolerance) = self.defect(tree);
            // A defect that is not a number (overflow) is no fulfilled condition.
            let holds = defect <= tolerance;
            (!holds).then(|| Broken {
                tree: self.catalogue.show(tree),
                weight: self.weight(tree).value.to_f64(),
                expected: 1.0 / tree.density() as f64,
                defect: defect.to_f64(),
                tolerance: tolerance.to_f64(),
            })
        })
    }
}

fn product<T: Real>(a: &DMatrix<T>, v: &[T]) -> Vec<T> {
    (0..a.nrows()).map(|i| (0..v.len()).fold(T::zero(), |sum, j| sum + a[(i, j)] * v[j])).collect()
}
