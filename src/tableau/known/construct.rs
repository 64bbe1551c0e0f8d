//! Tableaux of orders up to 4 from linear equations over the rationals.
//!
//! Nodes c and weights b with B(p): Σ_i b_i c_i^{k−1} = 1/k, k ≤ p, come first. Then d_j = Σ_i b_i a_ij is *chosen*, with
//! Σ_j d_j c_j^{k−1} = 1/(k(k+1)) for k < p. Once d is known, all that is left up to order 4 is linear in a:
//! the row sums c, the column sums d, Σ b_i c_i a_ij c_j = 1/8 and Σ d_i a_ij c_j = 1/24 (Butcher 1963, with
//! Σ b_i a_ij a_jk c_k = Σ d_j a_jk c_k). D(1) is d_j = b_j(1 − c_j); the defect is e = d − b(1 − c), and the pair (a, â)
//! is of order 3 if and only if Σ_j e_j²/b_j = 0 as well.

use super::dice::Dice;
use super::fraction::{Equations, Fraction, power, sum};
use super::{Class, Description, LARGEST_DENOMINATOR, LEAST_COLLOCATION_WEIGHT, LEAST_WEIGHT, Means, Shape};

/// a and b.
#[derive(Clone, Debug)]
pub struct Raw {
    pub a: Vec<Vec<Fraction>>,
    pub b: Vec<Fraction>,
}

impl Raw {
    /// As a plain value.
    pub fn description(&self) -> Description {
        let numbers = |row: &Vec<Fraction>| row.iter().map(|x| x.number()).collect::<Vec<_>>();
        Description::entries(self.a.iter().map(numbers).collect(), numbers(&self.b))
    }
}

/// Nodes, the simplest first, fifths last.
const NODES: [(i64, i64); 13] =
    [(0, 1), (1, 1), (1, 2), (1, 3), (2, 3), (1, 4), (3, 4), (1, 6), (5, 6), (1, 5), (2, 5), (3, 5), (4, 5)];

/// The nodes of order 4 where the equations for a are many: without fifths, or most solutions have large denominators.
fn nodes(class: Class) -> &'static [(i64, i64)] {
    let many = class.orders.classical >= 4 && matches!(class.means, Means::NotD1 | Means::Pair);
    if many { &NODES[..9] } else { &NODES }
}

/// Weights.
const WEIGHTS: [(i64, i64); 14] = [
    (1, 2),
    (1, 3),
    (1, 4),
    (-1, 4),
    (1, 6),
    (1, 1),
    (-1, 2),
    (3, 4),
    (2, 3),
    (-1, 3),
    (1, 5),
    (2, 5),
    (3, 2),
    (-1, 1),
];

/// Weights of four stages or more.
const SMALL_WEIGHTS: [(i64, i64); 14] = [
    (1, 6),
    (1, 3),
    (1, 8),
    (1, 4),
    (1, 5),
    (1, 12),
    (1, 10),
    (3, 8),
    (1, 2),
    (-1, 4),
    (-1, 6),
    (-1, 2),
    (-1, 3),
    (-1, 1),
];

/// n_i with Σ n_i³ = 0: the weights b_i = n_i/Σn of lower triangular symplectic tableaux of order 3.
const CUBES: [&[i64]; 10] = [
    &[3, 4, 5, -6],
    &[1, 6, 8, -9],
    &[9, 10, -1, -12],
    &[7, 14, 17, -20],
    &[3, 10, 18, -19],
    &[4, 17, 22, -25],
    &[11, 15, 27, -29],
    &[18, 19, 21, -28],
    &[1, 1, 5, 6, -7],
    &[4, 4, 6, -1, -7],
];

/// Entries of a that the equations leave free: 0 in three of twelve.
const ENTRIES: [(i64, i64); 12] =
    [(0, 1), (0, 1), (0, 1), (1, 2), (1, 4), (-1, 4), (1, 3), (1, 6), (-1, 2), (1, 1), (-1, 3), (2, 3)];

/// Defects of D(1) that the equations leave free.
const DEFECTS: [(i64, i64); 10] =
    [(1, 4), (-1, 4), (1, 6), (-1, 6), (1, 8), (-1, 8), (1, 3), (-1, 3), (1, 12), (-1, 12)];

/// A tableau of a class but for what [`super::accept`] looks at; `None` if the choices do not lead to one.
pub fn draw(class: Class, dice: &mut Dice) -> Option<Raw> {
    // Positive weights that are not small are rare with many stages.
    let least = least_stages(class);
    let s = least + dice.few(if least < 4 { 2 } else { 1 });
    match class.means {
        Means::Free => free(class, s, dice),
        Means::Symplectic => symplectic(class, s, dice),
        Means::D1 | Means::NotD1 => {
            let (c, b) = quadrature(class, s, dice)?;
            let e = if class.means == Means::D1 { vec![Fraction::ZERO; s] } else { defect(class, &c, &b, dice)? };
            with_defect(class, c, b, &e, dice)
        }
        Means::Pair => pair(class, s, dice),
    }
}

fn fits(x: &Fraction) -> bool {
    super::fits(x, LARGEST_DENOMINATOR)
}

/// The least number of stages that is tried (with fewer there is no rational member).
pub fn least_stages(class: Class) -> usize {
    let explicit = class.shape == Shape::Explicit;
    let full = usize::from(class.shape == Shape::Full);
    let p = class.orders.classical;
    match (class.means, p) {
        (Means::Free, 2) if explicit => 2,
        (Means::Free, _) => 1 + full,
        (Means::D1, _) if explicit => p,
        (Means::D1, _) => p - 1,
        (Means::NotD1, 4) if explicit => 5,
        (Means::NotD1, _) => p,
        (Means::Pair, _) => p + 1 + usize::from(explicit && p == 4),
        (Means::Symplectic, 2) => 1 + full,
        (Means::Symplectic, _) => p - 1,
    }
}

/// Order 1 or 2: row sums alone.
fn free(class: Class, s: usize, dice: &mut Dice) -> Option<Raw> {
    let (c, b) = quadrature(class, s, dice)?;
    let mut unknowns = Unknowns::of(class.shape, s);
    unknowns.rows(&c);
    Some(Raw { a: unknowns.solve(dice)?, b })
}

/// Nodes and weights with B(p).
fn quadrature(class: Class, s: usize, dice: &mut Dice) -> Option<(Vec<Fraction>, Vec<Fraction>)> {
    let mut c = dice.picks(s, nodes(class));
    let mut solved = s - 1;
    if class.shape == Shape::Explicit {
        c[0] = Fraction::ZERO;
        // Where the defect is to vanish, it does so for the last stage too, and there d = 0.
        if class.means == Means::D1 {
            c[s - 1] = Fraction::ONE;
            solved = s.saturating_sub(2);
        }
    }
    // The second stage of an explicit tableau would be the first one again.
    if class.shape == Shape::Explicit && s > 1 && c[1].is_zero() {
        return None;
    }
    let b = weights(&mut c, class.orders.classical, solved, dice)?;
    Some((c, b))
}

/// Weights with B(p); with p − 1 nodes, the one at `solved` is moved so that there are some.
fn weights(c: &mut [Fraction], p: usize, solved: usize, dice: &mut Dice) -> Option<Vec<Fraction>> {
    let s = c.len();
    if s + 1 == p {
        c[solved] = closing_node(c, solved);
    }
    let mut equations = Equations::default();
    for k in 1..=p {
        equations.add(c.iter().map(|&x| power(x, k - 1)).collect(), Fraction::new(1, k as i64));
    }
    let list = if s < 4 { &WEIGHTS } else { &SMALL_WEIGHTS };
    let b = equations.solve(&dice.picks(s, list), &dice.permutation(s))?;
    // What cannot be accepted is not worth a solution for a.
    (dice.accepts(&b) && b.iter().all(|x| fits(x) && x.size() >= LEAST_WEIGHT)).then_some(b)
}

/// The node x that makes ∫₀¹ (t − x) Π_{k ≠ solved} (t − c_k) dt vanish.
pub fn closing_node(c: &[Fraction], solved: usize) -> Fraction {
    let mut polynomial = vec![Fraction::ONE];
    for (k, &node) in c.iter().enumerate() {
        if k != solved {
            polynomial.insert(0, Fraction::ZERO);
            for i in 1..polynomial.len() {
                polynomial[i - 1] = polynomial[i - 1] - polynomial[i] * node;
            }
        }
    }
    let moment = |n: usize| sum(polynomial.iter().enumerate().map(|(i, &x)| x / Fraction::new((i + n) as i64, 1)));
    moment(2) / moment(1)
}

/// e with Σ_j e_j c_j^{k−1} = 0 for k < p; where d_s = 0, e_s = −b_s(1 − c_s).
fn defect(class: Class, c: &[Fraction], b: &[Fraction], dice: &mut Dice) -> Option<Vec<Fraction>> {
    let s = c.len();
    let mut equations = Equations::default();
    for k in 1..class.orders.classical {
        equations.add(c.iter().map(|&x| power(x, k - 1)).collect(), Fraction::ZERO);
    }
    if class.shape == Shape::Explicit {
        let last = (0..s).map(|j| if j + 1 == s { Fraction::ONE } else { Fraction::ZERO }).collect();
        equations.add(last, -b[s - 1] * (Fraction::ONE - c[s - 1]));
    }
    equations.solve(&dice.picks(s, &DEFECTS), &dice.permutation(s))
}

/// a from c, b and the defect e.
fn with_defect(class: Class, c: Vec<Fraction>, b: Vec<Fraction>, e: &[Fraction], dice: &mut Dice) -> Option<Raw> {
    let s = c.len();
    let d: Vec<Fraction> = (0..s).map(|j| b[j] * (Fraction::ONE - c[j]) + e[j]).collect();
    // 1 − d_j/b_j is the node of the conjugate.
    if !c.iter().all(fits) || !(0..s).all(|j| fits(&(Fraction::ONE - d[j] / b[j]))) {
        return None;
    }
    let mut unknowns = Unknowns::of(class.shape, s);
    unknowns.rows(&c);
    for j in 0..s {
        unknowns.equation(|i, k| if k == j { b[i] } else { Fraction::ZERO }, d[j]);
    }
    if class.orders.classical >= 4 {
        unknowns.equation(|i, j| b[i] * c[i] * c[j], Fraction::new(1, 8));
        unknowns.equation(|i, j| d[i] * c[j], Fraction::new(1, 24));
    }
    Some(Raw { a: unknowns.solve(dice)?, b })
}

/// Two stages at one node with weights ±β and defects ±ε: Σ e²/b = 0 although D(1) fails, and the other stages are a
/// quadrature by themselves.
fn pair(class: Class, s: usize, dice: &mut Dice) -> Option<Raw> {
    let explicit = class.shape == Shape::Explicit;
    // The last stage of an explicit tableau stays out of the pair, at the node 1.
    let last = if explicit { s - 1 } else { s };
    let first = dice.below(last - 1);
    let second = first + 1 + dice.below(last - 1 - first);
    let mut others = dice.picks(s - 2, nodes(class));
    let (mut node, weight, size) = (dice.pick(nodes(class)), dice.pick(&WEIGHTS), dice.pick(&DEFECTS));
    let mut solved = others.len() - 1;
    if explicit {
        *(if first == 0 { &mut node } else { &mut others[0] }) = Fraction::ZERO;
        others[s - 3] = Fraction::ONE;
        solved = s - 4;
    }
    let mut b = weights(&mut others, class.orders.classical, solved, dice)?;
    let mut e = vec![Fraction::ZERO; s - 2];
    for (place, sign) in [(first, Fraction::ONE), (second, -Fraction::ONE)] {
        others.insert(place, node);
        b.insert(place, sign * weight);
        e.insert(place, sign * size);
    }
    with_defect(class, others, b, &e, dice)
}

/// a_ij = b_j/2 + w_ij/b_i with w antisymmetric: b_i a_ij + b_j a_ji = b_i b_j. Its row sums are the nodes; B(p), p ≤ 4, is
/// then all that order p asks for, since for a symplectic tableau the conditions of trees that differ by the root are equivalent
/// (Sanz-Serna and Abia 1991) and Σ c_i w_ij c_j = 0. Lower triangular: w_ij = −b_i b_j/2 above the diagonal, steps b_i of the
/// midpoint rule one after the other, of order 3 if and only if Σ b_i³ = 0.
fn symplectic(class: Class, s: usize, dice: &mut Dice) -> Option<Raw> {
    let half = Fraction::new(1, 2);
    let mut w = vec![vec![Fraction::ZERO; s]; s];
    let b;
    if class.shape == Shape::Full {
        let c;
        (c, b) = quadrature(class, s, dice)?;
        let pairs: Vec<(usize, usize)> = (0..s).flat_map(|i| (i + 1..s).map(move |j| (i, j))).collect();
        let mut equations = Equations::default();
        for i in 0..s {
            let sign = |&(j, k): &(usize, usize)| Fraction::new(i64::from(i == j) - i64::from(i == k), 1);
            equations.add(pairs.iter().map(sign).collect(), b[i] * (c[i] - half));
        }
        let solution = equations.solve(&dice.picks(pairs.len(), &ENTRIES), &dice.permutation(pairs.len()))?;
        for (&(i, j), &x) in pairs.iter().zip(&solution) {
            (w[i][j], w[j][i]) = (x, -x);
        }
    } else {
        b = if class.orders.classical == 3 { cubes(dice) } else { closed(s, dice) };
        let s = b.len();
        w = vec![vec![Fraction::ZERO; s]; s];
        for i in 0..s {
            for j in i + 1..s {
                w[i][j] = -half * b[i] * b[j];
                w[j][i] = half * b[i] * b[j];
            }
        }
    }
    let s = b.len();
    let a = (0..s).map(|i| (0..s).map(|j| half * b[j] + w[i][j] / b[i]).collect()).collect();
    Some(Raw { a, b })
}

/// Weights that sum to 1.
fn closed(s: usize, dice: &mut Dice) -> Vec<Fraction> {
    let mut b = dice.picks(s - 1, &WEIGHTS);
    b.push(Fraction::ONE - sum(b.iter().copied()));
    b
}

/// Weights that sum to 1, their cubes to 0, in any order.
fn cubes(dice: &mut Dice) -> Vec<Fraction> {
    let n = CUBES[dice.below(CUBES.len())];
    let total = n.iter().sum();
    dice.permutation(n.len()).into_iter().map(|i| Fraction::new(n[i], total)).collect()
}

/// The entries of a that a shape leaves open, and equations for them.
struct Unknowns {
    s: usize,
    places: Vec<(usize, usize)>,
    equations: Equations,
}

impl Unknowns {
    fn of(shape: Shape, s: usize) -> Self {
        let places = (0..s).flat_map(|i| (0..s).map(move |j| (i, j))).filter(|&(i, j)| shape.holds(i, j)).collect();
        Self { s, places, equations: Equations::default() }
    }

    /// Σ_ij factor(i, j) a_ij = right.
    fn equation(&mut self, factor: impl Fn(usize, usize) -> Fraction, right: Fraction) {
        self.equations.add(self.places.iter().map(|&(i, j)| factor(i, j)).collect(), right);
    }

    /// Σ_j a_ij = c_i.
    fn rows(&mut self, c: &[Fraction]) {
        for i in 0..self.s {
            self.equation(|k, _| if k == i { Fraction::ONE } else { Fraction::ZERO }, c[i]);
        }
    }

    /// a, drawn where the equations leave it free.
    fn solve(self, dice: &mut Dice) -> Option<Vec<Vec<Fraction>>> {
        let n = self.places.len();
        let x = self.equations.solve(&dice.picks(n, &ENTRIES), &dice.permutation(n))?;
        let mut a = vec![vec![Fraction::ZERO; self.s]; self.s];
        for (&(i, j), x) in self.places.iter().zip(x) {
            a[i][j] = x;
        }
        Some(a)
    }
}

/// Collocation at s nodes with B(s + r), r ≤ 1: for r = 1 the last node is solved for.
pub fn collocation(s: usize, r: usize, dice: &mut Dice) -> Option<Raw> {
    let mut c = if s < 4 { dice.picks(s, &NODES) } else { spread(s, dice) };
    if r == 1 {
        c[s - 1] = closing_node(&c, s - 1);
    }
    let readable = |x: &Fraction| x.is_some() && x.denominator() <= 100 && x.size() <= 2.0;
    c.iter().all(readable).then(|| at_nodes(&c))?
}

/// k/q with one denominator, k from one of s equal parts of 0, …, q after the other: few sets of many nodes have weights that
/// are not small.
fn spread(s: usize, dice: &mut Dice) -> Vec<Fraction> {
    let q = [12, 10, 8, 9, 14, 15, 16][dice.below(7)];
    let mut least = 0;
    (0..s)
        .map(|i| {
            let low = (i * q).div_ceil(s).max(least);
            let k = low + dice.below(((i + 1) * q / s + 1).saturating_sub(low));
            least = k + 1;
            Fraction::new(k as i64, q as i64)
        })
        .collect()
}

/// Collocation at the nodes c: Σ_j a_ij c_j^{k−1} = c_i^k/k and Σ_j b_j c_j^{k−1} = 1/k, k ≤ s.
pub fn at_nodes(c: &[Fraction]) -> Option<Raw> {
    let s = c.len();
    // Equal nodes leave the equations without a solution, except for special right-hand sides.
    if (0..s).any(|i| c[..i].contains(&c[i])) {
        return None;
    }
    let integrals = |to: Fraction| {
        let mut equations = Equations::default();
        for k in 1..=s {
            let row = c.iter().map(|&x| power(x, k - 1)).collect();
            equations.add(row, power(to, k) / Fraction::new(k as i64, 1));
        }
        equations.solve(&vec![Fraction::ZERO; s], &(0..s).collect::<Vec<_>>())
    };
    let b = integrals(Fraction::ONE)?;
    if b.iter().any(|x| x.size() < LEAST_COLLOCATION_WEIGHT || x.size() > 2.0) {
        return None;
    }
    let a = c.iter().map(|&to| integrals(to)).collect::<Option<Vec<_>>>()?;
    Some(Raw { a, b })
}
