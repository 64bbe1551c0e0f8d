//! The same system in another basis of its algebra: another case with the same motion.
//!
//! With e'_a = e_b B^b_a: x = B x' for vectors, μ' = μ B for covectors, I' = Bᵀ I B; the group's matrices stay.

use super::case::{Case, Drag, Inertia, Monomial};
use super::force::{Role, Value};
use crate::scalar::Number;

/// B, and B⁻¹, in halves: every entry is k/2 with a small k.
struct Change {
    forth: Vec<Vec<i64>>,
    back: Vec<Vec<i64>>,
}

impl Change {
    /// B = P S: a cyclic permutation with changes of sign, and (with `sheared`) S = 1 + ½ E_12.
    fn new(n: usize, sheared: bool) -> Self {
        let sign = |a: usize| if a.is_multiple_of(2) { -2 } else { 2 };
        // P: e'_a = ± e_{a + 1}.
        let permuted = |b: usize, a: usize| if b == (a + 1) % n { sign(a) } else { 0 };
        let forth = |b: usize, a: usize| {
            let shear = if sheared && n > 1 && a == 1 { permuted(b, 0) / 2 } else { 0 };
            permuted(b, a) + shear
        };
        // S⁻¹ Pᵀ, S⁻¹ = 1 − ½ E_12.
        let back = |a: usize, b: usize| {
            let shear = if sheared && n > 1 && a == 0 { permuted(b, 1) / 2 } else { 0 };
            permuted(b, a) - shear
        };
        let table =
            |entry: &dyn Fn(usize, usize) -> i64| (0..n).map(|r| (0..n).map(|c| entry(r, c)).collect()).collect();
        Self { forth: table(&forth), back: table(&back) }
    }

    /// Σ_b x_b B^b_a, for each a.
    fn covector(&self, list: &[Number]) -> Vec<Number> {
        let n = list.len();
        (0..n).map(|a| sum((0..n).map(|b| (self.forth[b][a], &list[b])))).collect()
    }

    /// Σ_b (B⁻¹)^a_b x^b, for each a.
    fn vector(&self, list: &[Number]) -> Vec<Number> {
        let n = list.len();
        (0..n).map(|a| sum((0..n).map(|b| (self.back[a][b], &list[b])))).collect()
    }

    /// Bᵀ M B.
    fn form(&self, rows: &[Vec<Number>]) -> Vec<Vec<Number>> {
        let n = rows.len();
        let right: Vec<Vec<Number>> = rows.iter().map(|row| self.covector(row)).collect();
        let column = |b: usize| self.covector(&right.iter().map(|row| row[b].clone()).collect::<Vec<_>>());
        let columns: Vec<Vec<Number>> = (0..n).map(column).collect();
        (0..n).map(|a| (0..n).map(|b| columns[b][a].clone()).collect()).collect()
    }

    /// f_b B^b_a, or (B⁻¹)^a_b ζ^b, at η = B η'. With row i of a table t: t[i][j]/2 is the coefficient of j.
    fn polynomial(&self, terms: &[Monomial], role: Role) -> Vec<Monomial> {
        let n = self.forth.len();
        let image =
            |b: usize, a: usize| if role == Role::CovectorPolynomial { self.forth[b][a] } else { self.back[a][b] };
        let mut found = Vec::new();
        for term in terms {
            let start = (0..n).filter_map(|a| {
                let value = sum([(image(term.component - 1, a), &term.value)].into_iter());
                (image(term.component - 1, a) != 0).then(|| Monomial {
                    component: a + 1,
                    value,
                    factors: Vec::new(),
                    ..term.clone()
                })
            });
            found.extend(term.factors.iter().fold(start.collect(), |products: Vec<Monomial>, &i| {
                let row = &self.forth[i - 1];
                let times = |product: &Monomial, j: usize| {
                    let mut product = product.clone();
                    product.value = sum([(row[j], &product.value)].into_iter());
                    product.factors.push(j + 1);
                    product
                };
                let used = (0..n).filter(|j| row[*j] != 0);
                used.flat_map(|j| products.iter().map(move |product| times(product, j))).collect()
            }));
        }
        found
    }

    fn drag(&self, drag: &Drag, n: usize) -> Drag {
        match drag {
            Drag::Coefficient(k) => Drag::Matrix(self.form(&multiple(k, n))),
            Drag::Matrix(rows) => Drag::Matrix(self.form(rows)),
        }
    }
}

/// k 1.
fn multiple(k: &Number, n: usize) -> Vec<Vec<Number>> {
    (0..n).map(|a| (0..n).map(|b| if a == b { k.clone() } else { Number::default() }).collect()).collect()
}

/// The number, if it is a dyadic one that `f64` holds exactly.
fn dyadic(x: &Number) -> Option<f64> {
    let value = x.eval::<f64>().ok()?;
    (Number::from(value).rational().is_some_and(|exact| x.rational() == Some(exact))).then_some(value)
}

/// Σ (k/2) x, exactly: dyadic numbers are added up, others as an expression.
fn sum<'a>(terms: impl Iterator<Item = (i64, &'a Number)>) -> Number {
    let terms: Vec<(i64, &Number)> = terms.filter(|(k, x)| *k != 0 && **x != Number::default()).collect();
    let values: Option<Vec<f64>> = terms.iter().map(|(k, x)| Some(0.5 * *k as f64 * dyadic(x)?)).collect();
    let moderate = |x: f64| x == 0.0 || (2f64.powi(-20)..2f64.powi(20)).contains(&x.abs());
    // Of so few bits sums are exact.
    if let Some(values) = values.filter(|values| values.iter().all(|x| moderate(*x))) {
        return Number::from(values.iter().sum::<f64>());
    }
    if let [(k @ (2 | -2), x)] = terms.as_slice() {
        return Number::parse(&if *k > 0 { x.to_string() } else { format!("-({x})") }).unwrap_or_default();
    }
    let text: Vec<String> = terms.iter().map(|(k, x)| format!("({k})/2*({x})")).collect();
    Number::parse(&text.join(" + ")).unwrap_or_default()
}

impl Case {
    /// The same system in another basis e'_a = e_b B^b_a, and B by rows (formulas, which name coordinates, stay as they are written); the same state, so μ' = μ B and g' = g.
    ///
    /// B is a cyclic permutation with changes of sign, and a shear by a half where no force needs more than a change of basis
    /// gives it: the double bracket identifies g* with g in the basis that it is given in, and keeps its form under
    /// orthogonal changes only.
    pub fn presented(&self) -> (Self, Vec<Vec<f64>>) {
        let n = self.dimension();
        let orthogonal = self.forces.iter().any(|force| force.description().orthogonal);
        let change = Change::new(n, !orthogonal);
        let mut case = self.clone();
        let old = self.algebra.basis.clone().unwrap_or_else(|| multiple(&Number::from(1), n));
        let combined = |a: usize, entry: usize| sum((0..n).map(|b| (change.forth[b][a], &old[b][entry])));
        case.algebra.basis = Some((0..n).map(|a| (0..n).map(|entry| combined(a, entry)).collect()).collect());
        for (role, part) in case.parts_mut() {
            match part {
                Value::List(list) if role == Role::Vector => *list = change.vector(list),
                Value::List(list) => *list = change.covector(list),
                Value::Form(form) => {
                    let rows: Vec<_> = (0..n).map(|a| (0..n).map(|b| form.entry(a, b)).collect()).collect();
                    *form = Inertia::Full(change.form(&rows));
                }
                Value::Drag(drag) => *drag = change.drag(drag, n),
                Value::Polynomial(terms) => *terms = change.polynomial(terms, role),
                Value::Number(_) | Value::Formula(_) => {}
            }
        }
        let rows = change.forth.iter().map(|row| row.iter().map(|k| 0.5 * *k as f64).collect()).collect();
        (case, rows)
    }
}
