//! Random tableaux of known order: every one that is drawn has exactly the orders it claims, by exact rational arithmetic.

use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use euler_poincare::tableau::known::{
    self, Class, KnownOrder, LARGEST_COLLOCATION_DENOMINATOR, LARGEST_DENOMINATOR, LEAST_COLLOCATION_WEIGHT,
    LEAST_WEIGHT, MAX_COLLOCATION, Means, Orders, Shape, VISIBLE, VISIBLE_RELATIVE,
};
use euler_poincare::tableau::trees::{Catalogue, Tree};
use euler_poincare::tableau::{Description, Entries, classical_order, variational_order};
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::TestRunner;

fn draw(strategy: &BoxedStrategy<KnownOrder>, count: usize) -> Vec<KnownOrder> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
}

/// All strategies of a single kind, with their names.
fn all() -> Vec<(String, BoxedStrategy<KnownOrder>)> {
    let classes = known::classes().into_iter().map(|class| (class.to_string(), known::of_class(class)));
    let order = |p| Some((format!("collocation of order {p}"), known::collocation_of_order(p)?));
    classes.chain((1..=MAX_COLLOCATION).filter_map(order)).collect()
}

// Exact order conditions.

/// A tableau over the rationals with its conjugate, straight from the definition.
struct Exact {
    colours: [Vec<Vec<RBig>>; 2],
    b: Vec<RBig>,
}

fn rational(text: &str) -> RBig {
    let (p, q) = text.split_once('/').unwrap_or((text, "1"));
    let (p, q): (IBig, UBig) = (p.parse().unwrap(), q.parse().unwrap());
    RBig::from_parts(p, q)
}

fn whole(n: u64) -> RBig {
    RBig::from(UBig::from(n))
}

impl Exact {
    fn new(entries: &Entries) -> Self {
        let row =
            |row: &Vec<_>| row.iter().map(|x: &euler_poincare::scalar::Number| rational(&x.to_string())).collect();
        let a: Vec<Vec<RBig>> = entries.a.iter().map(row).collect();
        let b: Vec<RBig> = row(&entries.b);
        let s = b.len();
        let hat = |i: usize, j: usize| b[j].clone() - b[j].clone() * a[j][i].clone() / b[i].clone();
        let conjugate = (0..s).map(|i| (0..s).map(|j| hat(i, j)).collect()).collect();
        Self { colours: [a, conjugate], b }
    }

    /// Φ_i of each tree of the catalogue, in order.
    fn stages(&self, catalogue: &Catalogue) -> Vec<Vec<RBig>> {
        let mut all: Vec<Vec<RBig>> = Vec::new();
        for tree in catalogue.trees() {
            let phi = self.of(tree, &all);
            all.push(phi);
        }
        all
    }

    fn of(&self, tree: &Tree, all: &[Vec<RBig>]) -> Vec<RBig> {
        let s = self.b.len();
        let mut phi = vec![RBig::ONE; s];
        for edge in tree.branches() {
            for (i, value) in phi.iter_mut().enumerate() {
                let row = &self.colours[edge.colour][i];
                *value *= row.iter().zip(&all[edge.tree]).fold(RBig::ZERO, |sum, (x, y)| sum + x * y);
            }
        }
        phi
    }

    fn defect(&self, tree: &Tree, phi: &[RBig]) -> RBig {
        let weight = self.b.iter().zip(phi).fold(RBig::ZERO, |sum, (x, y)| sum + x * y);
        weight - RBig::ONE / whole(tree.density())
    }

    /// The largest order all of whose conditions hold, and whether the next fails as visibly as promised.
    fn order(&self, colours: usize) -> (usize, bool) {
        for n in 1.. {
            let catalogue = Catalogue::up_to(colours, n);
            let all = self.stages(&catalogue);
            let first = catalogue.trees().len() - catalogue.of_order(n).len();
            let (mut holds, mut visible) = (true, false);
            for (tree, phi) in catalogue.trees().iter().zip(&all).skip(first) {
                let defect = self.defect(tree, phi);
                holds &= defect == RBig::ZERO;
                let size = defect.to_f64().value().abs();
                visible |= size >= if n <= 5 { VISIBLE } else { VISIBLE_RELATIVE / tree.density() as f64 } * 0.999;
            }
            if !holds {
                return (n - 1, visible);
            }
        }
        unreachable!()
    }
}

#[test]
fn the_orders_are_exactly_as_claimed() {
    for (name, strategy) in all() {
        for known in draw(&strategy, 100) {
            let KnownOrder { description, orders } = &known;
            let t = description.build::<f64>().unwrap();
            assert_eq!(classical_order(&t, orders.classical + 1).order, orders.classical, "{name}: {description}");
            assert_eq!(
                variational_order(&t, orders.variational + 1).order,
                orders.variational,
                "{name}: {description}"
            );
            let Description::Entries(entries) = description else { continue };
            let exact = Exact::new(entries);
            assert_eq!(exact.order(1), (orders.classical, true), "{name}: {description}");
            assert_eq!(exact.order(2), (orders.variational, true), "{name}: {description}");
        }
    }
}
