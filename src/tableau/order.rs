//! The order of a tableau, computed from its coefficients by the order conditions of coloured rooted trees.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/tableau/order.md"))]

use super::Tableau;
use super::quantity::{Ball, Coefficients, Quantity};
use super::trees::{Catalogue, Tree};
use crate::scalar::Real;
use std::fmt;

/// The highest order that [`classical_order`] checks (235 381 trees of order 16).
pub const MAX_CLASSICAL: usize = 16;

/// The highest order that [`variational_order`] checks (492 180 oriented trees of order 12).
pub const MAX_VARIATIONAL: usize = 12;

/// What the order conditions say.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Order {
    /// Every condition up to this order holds.
    pub order: usize,
    /// The order is at most this: [`Order::order`] where a condition of the next order fails; `None` if nothing bounds it.
    pub most: Option<usize>,
    /// The first condition of the next order that fails, where one was looked at and does.
    pub broken: Option<Broken>,
}

impl Order {
    /// Whether the order is exactly [`Order::order`]; otherwise it is *at least* that.
    pub fn is_exact(&self) -> bool {
        self.most == Some(self.order)
    }

    /// Whether the order is `claimed`; `None` where it is not known whether it is that high.
    pub fn is(&self, claimed: usize) -> Option<bool> {
        if self.is_exact() || claimed < self.order {
            return Some(claimed == self.order);
        }
        self.most.is_some_and(|most| claimed > most).then_some(false)
    }
}

/// An order condition that does not hold.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
        if self.is_exact() { write!(f, "{}", self.order) } else { write!(f, "at least {}", self.order) }
    }
}

/// The order of (a, b) as a Runge–Kutta method, checked up to `max` (at most [`MAX_CLASSICAL`]).
///
/// A condition counts as violated if its defect exceeds 8 n (s + 2) u Σ|b||Φ|, where |Φ| is formed with the magnitudes
/// |a_ij| + |b_j|, n is the order of the tree and u the unit round-off of `T`: a bound on what rounding the coefficients and
/// evaluating the sum can do. So the order of coefficients known to fewer digits than `T` has is that of the rounded ones.
///
/// Source: Butcher 1963; Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, theorem II.2.13.
pub fn classical_order<T: Real>(tableau: &Tableau<T>, max: usize) -> Order {
    Conditions::new(tableau, 1).order(max)
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
    Conditions::new(tableau, 2).order(max)
}

/// What one order condition says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub struct Verdict {
    /// |defect| ≤ tolerance.
    pub holds: bool,
    /// Σ b Φ.
    pub weight: f64,
    /// Σ b Φ − 1/γ.
    pub defect: f64,
    /// The bound on what round-off and the digits given can make; 0 in exact arithmetic.
    pub tolerance: f64,
}

impl Verdict {
    /// Of a condition that holds in exact arithmetic.
    pub(super) fn exact(tree: &Tree) -> Self {
        Self { holds: true, weight: 1.0 / tree.density() as f64, defect: 0.0, tolerance: 0.0 }
    }
}

/// The elementary weights of a tableau, with what the trees have in common computed once.
///
/// ```
/// use euler_poincare::tableau::assumptions::{Assumption, Assumptions, Failure, AssumptionKind};
/// use euler_poincare::tableau::failing::{Condition, Failing};
/// use euler_poincare::tableau::order::{Broken, Conditions};
/// use euler_poincare::tableau::quantity::{Ball, Coefficients, Quantity};
/// use euler_poincare::tableau::structure::{Shape, Symmetry, is_symplectic};
/// use euler_poincare::tableau::{Classic, Family};
///
/// let ralston = Classic::Ralston3.tableau::<f64>()?;
/// let mut conditions = Conditions::new(&ralston, 2); // trees with two colours: the pair (a, â)
/// let order = conditions.order(6);
/// let Some(Broken { weight, expected, .. }) = &order.broken else { panic!("of order 6") };
/// assert!((weight - expected).abs() > 0.01);
/// // Every condition of that order that fails, as a formula.
/// let failing: Failing = Failing::of(&mut conditions, &order).expect("at least one");
/// let condition: &Condition = &failing.conditions[0];
/// assert_eq!((order.order, failing.order, condition.formula.as_str()), (2, 3, "Σ b_i ĉ_i^2"));
///
/// // Simplifying assumptions and structure, from coefficients that know their rounding.
/// let coefficients: Coefficients<Ball<f64>> = Coefficients::of(&ralston);
/// let assumptions = Assumptions::of(&coefficients);
/// let d: &Assumption = &assumptions.d;
/// let failure: &Failure = d.fails.as_ref().expect("D(1) fails");
/// assert_eq!((d.kind, d.holds, failure.k), (AssumptionKind::D, 0, 1));
/// assert_eq!(Shape::of(&coefficients), Shape::Explicit);
/// let gauss = Coefficients::of(&Family::Gauss.tableau::<f64>(2)?);
/// assert!(matches!(Symmetry::of(&gauss), Symmetry::Symmetric(_)) && is_symplectic(&gauss));
/// assert!(gauss.b[0].minus(&gauss.b[1]).vanishes(1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Conditions<Q> {
    /// The matrix of each colour, by rows.
    matrices: Vec<Vec<Vec<Q>>>,
    weights: Vec<Q>,
    /// What Σ b Φ of a tree of order n is divided by, at n; empty: nothing.
    units: Vec<Q>,
    catalogue: Catalogue,
    /// Σ_j a^{(colour)}_ij Φ_j(tree), at (tree · colours + colour) · stages + i.
    branches: Vec<Q>,
}

impl<T: Real> Conditions<Ball<T>> {
    /// For trees with edges of `colours` colours: 1 for a alone, 2 (or more) for a and â.
    pub fn new(tableau: &Tableau<T>, colours: usize) -> Self {
        Self::of(&Coefficients::of(tableau), colours)
    }
}

impl<Q: Quantity> Conditions<Q> {
    /// For these coefficients.
    pub fn of(coefficients: &Coefficients<Q>, colours: usize) -> Self {
        let matrices = [&coefficients.a, &coefficients.hat].into_iter().take(colours.max(1)).cloned().collect();
        Self::with(matrices, coefficients.b.clone(), Vec::new())
    }

    /// For trees with an edge colour for each of the matrices; these and the weights may be multiples: Σ b Φ is then in `units`.
    pub(super) fn with(matrices: Vec<Vec<Vec<Q>>>, weights: Vec<Q>, units: Vec<Q>) -> Self {
        let catalogue = Catalogue::new(matrices.len());
        Self { matrices, weights, units, catalogue, branches: Vec::new() }
    }

    /// The trees known so far.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Makes the trees up to `order` available as branches.
    pub fn prepare(&mut self, order: usize) {
        self.catalogue.extend_to(order);
        let s = self.weights.len();
        for number in self.branches.len() / (self.matrices.len() * s)..self.catalogue.trees().len() {
            let tree = &self.catalogue.trees()[number];
            let phi: Vec<_> = (0..s).map(|i| self.stage(tree, i)).collect();
            for row in self.matrices.iter().flatten() {
                let zero = Q::fraction(0, 1);
                self.branches.push(row.iter().zip(&phi).fold(zero, |sum, (a, phi)| sum.plus(&a.times(phi))));
            }
        }
    }

    /// Φ_i.
    fn stage(&self, tree: &Tree, i: usize) -> Q {
        let (colours, s) = (self.matrices.len(), self.weights.len());
        let mut factors = tree.branches().iter().map(|e| &self.branches[(e.tree * colours + e.colour) * s + i]);
        let Some(first) = factors.next() else { return Q::fraction(1, 1) };
        factors.fold(first.clone(), |phi, factor| phi.times(factor))
    }

    /// Σ b Φ of a tree whose branches are [prepared](Conditions::prepare).
    pub fn weight(&self, tree: &Tree) -> Q {
        let sum = self.multiple(tree);
        match self.units.get(tree.order()) {
            Some(unit) => sum.over(unit),
            None => sum,
        }
    }

    /// Σ b Φ in units.
    fn multiple(&self, tree: &Tree) -> Q {
        let terms = self.weights.iter().enumerate().map(|(i, b)| b.times(&self.stage(tree, i)));
        terms.fold(Q::fraction(0, 1), |sum, term| sum.plus(&term))
    }

    /// Whether the condition of a tree whose branches are [prepared](Conditions::prepare) holds.
    pub fn verdict(&self, tree: &Tree) -> Verdict {
        if let Some(unit) = self.units.get(tree.order()) {
            // In integers; a fraction of long numbers is formed only where the condition fails.
            let multiple = self.multiple(tree).times(&Q::fraction(tree.density() as i64, 1));
            if multiple.minus(unit).vanishes(0) {
                return Verdict::exact(tree);
            }
        }
        self.weight(tree).verdict(tree, self.weights.len())
    }

    /// The highest order that [`Conditions::order`] checks.
    fn most(&self) -> usize {
        if self.matrices.len() == 1 { MAX_CLASSICAL } else { MAX_VARIATIONAL }
    }

    /// The order, checked up to `max`: that of [`classical_order`] with one colour, of [`variational_order`] with two.
    pub fn order(&mut self, max: usize) -> Order {
        let max = max.min(self.most());
        for n in 1..=max {
            if let Some(broken) = self.visit(n, |conditions, tree| conditions.broken(tree)).next() {
                return Order { order: n - 1, most: Some(n - 1), broken: Some(broken) };
            }
        }
        Order { order: max, most: None, broken: None }
    }

    /// What `look` finds at the trees whose conditions make up order n: all rooted trees for one colour, else one for each
    /// oriented free tree; nothing beyond [`MAX_CLASSICAL`] and [`MAX_VARIATIONAL`].
    pub fn visit<'c, R: 'c>(
        &'c mut self,
        n: usize,
        look: impl Fn(&Self, &Tree) -> Option<R> + 'c,
    ) -> Box<dyn Iterator<Item = R> + 'c> {
        let oriented = self.matrices.len() == 2;
        if !(1..=self.most()).contains(&n) {
            return Box::new(std::iter::empty());
        }
        self.prepare(if oriented { n / 2 } else { n - 1 });
        if !oriented {
            self.catalogue.extend_to(n);
        }
        let conditions = &*self;
        if oriented {
            Box::new(conditions.catalogue.oriented(n).filter_map(move |tree| look(conditions, &tree)))
        } else {
            Box::new(conditions.catalogue.of_order(n).iter().filter_map(move |tree| look(conditions, tree)))
        }
    }

    fn broken(&self, tree: &Tree) -> Option<Broken> {
        let verdict = self.verdict(tree);
        (!verdict.holds).then(|| Broken {
            tree: self.catalogue.show(tree),
            weight: verdict.weight,
            expected: 1.0 / tree.density() as f64,
            defect: verdict.defect.abs(),
            tolerance: verdict.tolerance,
        })
    }

    /// Σ b Φ and its distance from 1/γ as fractions, where they are exact.
    pub fn fractions(&self, tree: &Tree) -> Option<[String; 2]> {
        self.weight(tree).fractions(tree)
    }
}
