//! Strategies for random tableaux whose classical and variational order are known, with exact fractions as entries.
//!
//! The *classical* order is that of (a, b) as a Runge–Kutta method, the *variational* order that of the pair (a, â), on
//! which the forced integrators depend ([`super::variational_order`]). A [`Class`] says which two orders, which zeros of a,
//! and by which means; [`classes`] lists those that exist here:
//!
//! | orders | means | explicit | diagonally implicit | full |
//! |---|---|---|---|---|
//! | (1, 1) | row sums | 1 | 1 | 2 |
//! | (2, 2) | row sums | 2 | 1 | 2 |
//! | (2, 2) | symplectic | | 1 | 2 |
//! | (3, 2) | no D(1) | 3 | 3 | 3 |
//! | (3, 3) | D(1) | 3 | 2 | 2 |
//! | (3, 3) | opposite weights | 4 | 4 | 4 |
//! | (3, 3) | symplectic | | 4 | 2 |
//! | (4, 2) | no D(1) | 5 | 4 | 4 |
//! | (4, 3) | opposite weights | 6 | 5 | 5 |
//! | (4, 4) | D(1) | 4 | 3 | 3 |
//! | (4, 4) | symplectic | | | 3 |
//!
//! with the least number of stages of the tableaux drawn. No two stages are the same, and a full tableau is not triangular
//! in another order of its stages. Explicit tableaux of order 4 with 4 stages all have D(1) (Butcher 1963); with 5 they need
//! not, and fall to order 2 as variational ones. D(1) is Σ_i b_i a_ij = b_j(1 − c_j). For positive weights the variational
//! order is at least 3 if and only if the classical one is and D(1) holds; weights of both signs can hide a defect of D(1).
//! Collocation at random nodes goes higher: see [`collocation_of_order`].
//!
//! Every tableau satisfies all conditions of its orders exactly, and of the next order, classical and variational,
//! some condition fails by at least [`VISIBLE`], so that the order shows in a convergence study. |a_ij|, |b_j| ≤ 2,
//! |â_ij| ≤ 4 and |b_j| ≥ [`LEAST_WEIGHT`]: the stage equations of moderate steps can be solved. Denominators are at most
//! [`LARGEST_DENOMINATOR`]. (Weights and denominators of collocation have bounds of their own.)
//!
//! A strategy shrinks within its class: first to the simplest tableau of the class, then to ever less simple ones.

pub(super) mod construct;
mod dice;
pub(super) mod fraction;

use super::order::Conditions;
use super::trees::Tree;
use super::{Description, Family, Tableau};
use construct::Raw;
use dice::Dice;
use fraction::Fraction;
use proptest::prelude::Rng;
use proptest::strategy::{BoxedStrategy, Just, NewTree, Strategy, Union, ValueTree};
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The least defect |Σ b Φ − 1/γ| that the worst condition of the next order has, up to order 5.
pub const VISIBLE: f64 = 1.0 / 200.0;

/// The same for conditions of order 6 and more, relative to 1/γ: γ|Σ b Φ − 1/γ|. (Gauss-3 has 1/400 for the bushy tree.)
pub const VISIBLE_RELATIVE: f64 = 1.0 / 1000.0;

/// The largest denominator of an entry.
pub const LARGEST_DENOMINATOR: i64 = 10_000;

/// The same for collocation, whose entries all have digits.
pub const LARGEST_COLLOCATION_DENOMINATOR: i64 = 1_000_000;

/// The least |b_j| of the [`classes`].
pub const LEAST_WEIGHT: f64 = 1.0 / 12.0;

/// The least |b_j| of collocation, whose weights become smaller as stages become more.
pub const LEAST_COLLOCATION_WEIGHT: f64 = 1.0 / 20.0;

/// The zeros of a.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Shape {
    /// a_ij = 0 for j ≥ i.
    Explicit,
    /// a_ij = 0 for j > i, and not explicit.
    DiagonallyImplicit,
    /// Neither.
    Full,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Shape; 3] = [Shape::Explicit, Shape::DiagonallyImplicit, Shape::Full];

    /// As [`Description::kind`] calls it.
    pub fn name(self) -> &'static str {
        match self {
            Shape::Explicit => "explicit",
            Shape::DiagonallyImplicit => "diagonally-implicit",
            Shape::Full => "fully-implicit",
        }
    }

    /// Whether a_ij may differ from 0.
    fn holds(self, i: usize, j: usize) -> bool {
        match self {
            Shape::Explicit => j < i,
            Shape::DiagonallyImplicit => j <= i,
            Shape::Full => true,
        }
    }

    /// The least shape that has these zeros; `None` if the shape is full and some order of the stages makes a triangular.
    fn of(a: &[Vec<Fraction>]) -> Option<Self> {
        let fits = |shape: &Shape| {
            a.iter().enumerate().all(|(i, row)| row.iter().enumerate().all(|(j, x)| shape.holds(i, j) || x.is_zero()))
        };
        match Shape::ALL.into_iter().find(fits) {
            Some(Shape::Full) | None => {
                // Stages that need none of the others but those put aside before are put aside.
                let mut rest: Vec<usize> = (0..a.len()).collect();
                while let Some(place) = rest.iter().position(|&i| rest.iter().all(|&j| i == j || a[i][j].is_zero())) {
                    rest.remove(place);
                }
                (!rest.is_empty()).then_some(Shape::Full)
            }
            triangular => triangular,
        }
    }
}

/// The order of (a, b) and that of the pair (a, â).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Orders {
    /// As a Runge–Kutta method.
    pub classical: usize,
    /// Of the pair; at most the classical order.
    pub variational: usize,
}

impl fmt::Display for Orders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.classical, self.variational)
    }
}

/// How a tableau comes to its orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Means {
    /// Nodes and weights alone: orders 1 and 2.
    Free,
    /// D(1): Σ_i b_i a_ij = b_j(1 − c_j).
    D1,
    /// A defect of D(1) that the pair (a, â) feels: variational order 2.
    NotD1,
    /// A defect of D(1) at two stages with the same node and opposite weights, which the conditions of order 3 do not feel.
    Pair,
    /// b_i a_ij + b_j a_ji = b_i b_j, so â = a.
    Symplectic,
}

/// Tableaux of the same orders, shape and means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Class {
    /// The orders.
    pub orders: Orders,
    /// The zeros of a.
    pub shape: Shape,
    /// How the orders come about.
    pub means: Means,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let means = match self.means {
            Means::Free => "row sums",
            Means::D1 => "D(1)",
            Means::NotD1 => "no D(1)",
            Means::Pair => "opposite weights",
            Means::Symplectic => "symplectic",
        };
        write!(f, "{} {} by {means}", self.orders, self.shape.name())
    }
}

/// A tableau and its orders.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownOrder {
    /// The tableau.
    pub description: Description,
    /// Its orders, exactly.
    pub orders: Orders,
}

/// Every class, as in the table of this module.
pub fn classes() -> Vec<Class> {
    let means = [
        (1, 1, Means::Free),
        (2, 2, Means::Free),
        (2, 2, Means::Symplectic),
        (3, 2, Means::NotD1),
        (3, 3, Means::D1),
        (3, 3, Means::Pair),
        (3, 3, Means::Symplectic),
        (4, 2, Means::NotD1),
        (4, 3, Means::Pair),
        (4, 4, Means::D1),
        (4, 4, Means::Symplectic),
    ];
    let mut classes = Vec::new();
    for (classical, variational, means) in means {
        for shape in Shape::ALL {
            // An explicit tableau is not symplectic (0 = b_i²); a lower triangular one that is has Σ b_i³ = 0 at order 3, and
            // at order 4 irrational weights, as far as known.
            let none = means == Means::Symplectic
                && (shape == Shape::Explicit || (shape == Shape::DiagonallyImplicit && classical > 3));
            if !none {
                classes.push(Class { orders: Orders { classical, variational }, shape, means });
            }
        }
    }
    classes
}

/// What a strategy draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Recipe {
    Class(Class),
    /// At s nodes with B(s + r).
    Collocation {
        s: usize,
        r: usize,
    },
}

/// Tableaux of one class, with positive weights in at least half of the draws where the class has such; they take two more
/// stages than the least at most.
///
/// Shrinks to the simplest tableau of the class: the fewest stages, then the fewest negative weights, then the smallest
/// numerators and denominators (of a few thousand tableaux from the simplest nodes and weights). That is
/// for (1, 1) the explicit and the implicit Euler tableau; for (2, 2) `heun2` and the midpoint rule; for (3, 3) by D(1)
/// Kutta's tableau with the weights (1, 4, 1)/6 and, at the nodes of Radau IIA, a_11 = 1/3, a_21 = 1, b = (3, 1)/4; for
/// (3, 2) explicit a_21 = 2/3, a_31 = −1/3, a_32 = 1, b = (1, 2, 1)/4; for (4, 4) `rk4` and the lower triangular tableau with
/// a_21 = a_22 = 1/4, a_32 = 1, b = (1, 4, 1)/6. The tests list all.
///
/// A draw takes 10 to 400 µs, and 1 to 3 ms in the full and explicit classes (4, 2) and (4, 3).
pub fn of_class(class: Class) -> BoxedStrategy<KnownOrder> {
    Known(Recipe::Class(class)).boxed()
}

/// Collocation of classical order p: at p nodes, with variational order min(p, 2); at p − 1 nodes the last of which gives
/// B(p), with variational order min(p, 4); and the Gauss, Radau IIA and Lobatto IIIA tableaux of order p, with variational
/// order p. `None` unless 1 ≤ p ≤ [`MAX_COLLOCATION`].
///
/// The three have weights 2, 2 and 1. With s nodes, C(s) and B(s + r) one has D(r), and the conjugate C(r) and D(s); so the
/// variational order is min(s + r, 2 r + 2), which every draw is checked for. (Two nodes that r = 2 needs solve a quadratic
/// equation, and no rational solution with small denominators was found.) Shrinks to one of fewer nodes, then to simpler
/// nodes.
pub fn collocation_of_order(p: usize) -> Option<BoxedStrategy<KnownOrder>> {
    if !(1..=MAX_COLLOCATION).contains(&p) {
        return None;
    }
    let mut choices = Vec::new();
    for (family, stages) in
        [(Family::Gauss, p / 2), (Family::RadauIIA, p.div_ceil(2)), (Family::LobattoIIIA, p / 2 + 1)]
    {
        let order = match family {
            Family::Gauss => 2 * stages,
            Family::RadauIIA => 2 * stages - 1,
            _ => 2 * stages - 2,
        };
        if order == p && stages > 0 {
            let orders = Orders { classical: p, variational: p };
            choices.push((1, Just(KnownOrder { description: Description::Family(family, stages), orders }).boxed()));
        }
    }
    if p > 1 {
        choices.push((2, Known(Recipe::Collocation { s: p - 1, r: 1 }).boxed()));
    }
    choices.push((2, Known(Recipe::Collocation { s: p, r: 0 }).boxed()));
    Some(Union::new_weighted(choices).boxed())
}

/// The highest order of [`collocation_of_order`].
pub const MAX_COLLOCATION: usize = 6;

/// Any tableau of this module: each of the [`classes`] with weight 1, and collocation of the orders 3 to
/// [`MAX_COLLOCATION`] with weight 1 each. Shrinks to the explicit Euler tableau.
pub fn any_of_known_order() -> BoxedStrategy<KnownOrder> {
    let collocation = (3..=MAX_COLLOCATION).filter_map(collocation_of_order);
    Union::new(classes().into_iter().map(of_class).chain(collocation)).boxed()
}

/// The descriptions alone.
pub fn descriptions(strategy: impl Strategy<Value = KnownOrder> + 'static) -> BoxedStrategy<Description> {
    strategy.prop_map(|known| known.description).boxed()
}

impl Recipe {
    fn orders(self) -> Orders {
        match self {
            Recipe::Class(class) => class.orders,
            Recipe::Collocation { s, r } => Orders { classical: s + r, variational: (s + r).min(2 * r + 2) },
        }
    }

    /// Whether there are tableaux with positive weights.
    fn may_be_positive(self) -> bool {
        match self {
            Recipe::Class(Class { means: Means::Pair, .. }) => false,
            // Σ b_i³ = 0.
            Recipe::Class(Class { means: Means::Symplectic, shape: Shape::DiagonallyImplicit, orders }) => {
                orders.classical < 3
            }
            _ => true,
        }
    }

    /// What these choices lead to.
    fn make(self, mut dice: Dice) -> Option<Drawn> {
        let raw = match self {
            Recipe::Class(class) => construct::draw(class, &mut dice)?,
            Recipe::Collocation { s, r } => construct::collocation(s, r, &mut dice)?,
        };
        let (largest, least) = match self {
            Recipe::Class(_) => (LARGEST_DENOMINATOR, LEAST_WEIGHT),
            Recipe::Collocation { .. } => (LARGEST_COLLOCATION_DENOMINATOR, LEAST_COLLOCATION_WEIGHT),
        };
        let entries = raw.a.iter().flatten().all(|x| fits(x, largest));
        let weights = raw.b.iter().all(|x| fits(x, largest) && x.size() >= least) && dice.accepts(&raw.b);
        let distinct = raw.a.iter().enumerate().all(|(i, row)| raw.a[..i].iter().all(|other| row != other));
        let other_shape = matches!(self, Recipe::Class(class) if Shape::of(&raw.a) != Some(class.shape));
        if !entries || !weights || !distinct || other_shape {
            return None;
        }
        let known = KnownOrder { description: accept(&raw, self.orders())?, orders: self.orders() };
        Some(Drawn { height: height(&raw, &known.description), known })
    }

    /// The simplest tableaux, from narrow choices with fixed seeds; made once.
    fn ladder(self) -> Arc<Vec<Drawn>> {
        static LADDERS: OnceLock<Mutex<HashMap<Recipe, Arc<Vec<Drawn>>>>> = OnceLock::new();
        let ladders = LADDERS.get_or_init(Mutex::default);
        let mut ladders = ladders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(ladder) = ladders.get(&self) {
            return ladder.clone();
        }
        let mut rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[0; 32]);
        let narrow = |_| self.make(Dice::narrow(&mut rng, self.may_be_positive()));
        let draws = if matches!(self, Recipe::Class(_)) { NARROW_DRAWS } else { NARROW_DRAWS / 5 };
        let mut candidates: Vec<Drawn> = (0..draws).filter_map(narrow).collect();
        candidates.sort_by(|x, y| x.height.cmp(&y.height));
        candidates.dedup_by(|x, y| x.known == y.known);
        candidates.truncate(CANDIDATES);
        let ladder = Arc::new(candidates);
        ladders.insert(self, ladder.clone());
        ladder
    }
}

/// How often narrow choices are tried for the simplest tableaux of a class. (Twelve times as many find smaller digits in four
/// of the 29 classes, and nowhere fewer stages.)
const NARROW_DRAWS: usize = 5000;

/// How many of them are kept.
const CANDIDATES: usize = 16;

/// Whether an entry is at most 2 and can be read.
fn fits(x: &Fraction, largest: i64) -> bool {
    x.is_some() && x.denominator() <= largest && x.size() <= 2.0
}

/// The tableau, if its conjugate is not too large and it has exactly these orders.
fn accept(raw: &Raw, orders: Orders) -> Option<Description> {
    let values: Vec<Vec<f64>> = raw.a.iter().map(|row| row.iter().map(|x| x.value()).collect()).collect();
    let tableau = Tableau::new(&values, &raw.b.iter().map(|x| x.value()).collect::<Vec<_>>()).ok()?;
    let conjugate = tableau.conjugate();
    let good = conjugate.a().iter().all(|x| x.abs() <= 4.0 + 1e-9)
        && exactly(&tableau, 1, orders.classical)
        && exactly(&tableau, 2, orders.variational);
    good.then(|| raw.description())
}

/// Whether all conditions up to `order` hold, and one of the next fails visibly; trees of one or two colours.
fn exactly(tableau: &Tableau<f64>, colours: usize, order: usize) -> bool {
    let mut conditions = Conditions::new(tableau, colours);
    let mut holds = |n: usize| {
        let fails = |conditions: &Conditions<_>, tree: &Tree| (!conditions.verdict(tree).holds).then_some(());
        conditions.visit(n, fails).next().is_none()
    };
    if !(1..=order).all(&mut holds) {
        return false;
    }
    let visible = |conditions: &Conditions<_>, tree: &Tree| {
        let least = if tree.order() <= 5 { VISIBLE } else { VISIBLE_RELATIVE / tree.density() as f64 };
        (conditions.verdict(tree).defect.abs() >= least).then_some(())
    };
    conditions.visit(order + 1, visible).next().is_some()
}

/// What makes a tableau less simple: stages, then negative weights, then Σ (|p| + q) over the entries p/q that are not 0, one
/// more for each sign; the text decides between equals.
type Height = (usize, usize, u64, String);

fn height(raw: &Raw, description: &Description) -> Height {
    let entry = |x: &Fraction| match x.numerator() {
        0 => 0,
        p => p.unsigned_abs() + x.denominator().unsigned_abs() + u64::from(p < 0),
    };
    let negative = raw.b.iter().filter(|b| b.numerator() < 0).count();
    let digits = raw.a.iter().flatten().chain(&raw.b).map(entry).sum();
    (raw.b.len(), negative, digits, description.to_string())
}

/// A tableau, and how simple it is.
#[derive(Clone, Debug)]
struct Drawn {
    known: KnownOrder,
    height: Height,
}

/// How many constructions may fail before a strategy gives up.
const ATTEMPTS: usize = 100_000;

/// The strategy of a recipe.
#[derive(Clone, Copy, Debug)]
struct Known(Recipe);

impl Strategy for Known {
    type Tree = KnownTree;
    type Value = KnownOrder;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let positive = self.0.may_be_positive() && runner.rng().next_u64().is_multiple_of(2);
        for _ in 0..ATTEMPTS {
            if let Some(best) = self.0.make(Dice::random(runner.rng(), positive)) {
                return Ok(KnownTree { recipe: self.0, current: best.clone(), best, tried: None });
            }
        }
        Err("no tableau of the prescribed orders was found".into())
    }
}

/// A drawn tableau and its way to simpler ones of its class.
#[derive(Debug)]
struct KnownTree {
    recipe: Recipe,
    best: Drawn,
    current: Drawn,
    /// The number of the candidate that is tried.
    tried: Option<usize>,
}

impl KnownTree {
    /// The candidate with that number, or back to the best.
    fn candidate(&mut self, number: usize) -> bool {
        let ladder = self.recipe.ladder();
        // The first one is what the class shrinks to, even should the narrow draws have missed a simpler one.
        let next = |candidate: &&Drawn| {
            candidate.height < self.best.height || (number == 0 && candidate.height != self.best.height)
        };
        let found = ladder.get(number).filter(next);
        self.current = found.unwrap_or(&self.best).clone();
        self.tried = Some(number);
        found.is_some()
    }
}

impl ValueTree for KnownTree {
    type Value = KnownOrder;

    fn current(&self) -> KnownOrder {
        self.current.known.clone()
    }

    fn simplify(&mut self) -> bool {
        self.best = self.current.clone();
        // Simpler candidates than one that is kept were tried.
        self.tried.is_none() && self.candidate(0)
    }

    fn complicate(&mut self) -> bool {
        match self.tried {
            Some(number) => self.candidate(number + 1),
            None => false,
        }
    }
}
