//! The tableau of the highest order among those whose entries round to the digits given.
//!
//! A decimal that counts as rounded stands for the interval of its [allowances](Entries::allowances): first all entries are taken
//! to have had the same number of places, then each its own. The order *to the digits given* is
//! the highest variational order of a tableau with entries in these intervals; [`complete`] finds one, in 32 digits.
//!
//! Method: Gauss and Newton's iteration with steps of least norm (in units of the allowances) on the equations that make up an order:
//! B(p), C(k), D(k) and the condition between them (see [`bounds`](super::bounds)), with Legendre polynomials in place of the powers
//! of c, which are nearly dependent; or, where a weight is negative and they have no solution, the bicoloured trees up to order p.
//! Where the solution leaves an interval, projections onto the intervals and onto the tangent space of the solutions alternate until
//! they meet.

use super::findings::Findings;
use super::order::Conditions;
use super::quantity::{Ball, Coefficients, Quantity};
use super::{Entries, TableauError, legendre};
use crate::scalar::{Dd, Number, Scalar};
use nalgebra::{DMatrix, DVector};

/// The most iterations of Newton's method on order conditions: with a Jacobian that is kept at the end, each gives some digits of
/// the 32.
const MAX_NEWTON: usize = 40;

/// From this iteration on a residual has to fall to a fifth; before it the iteration may still be far from a solution.
const SETTLING: usize = 6;
const STALLED: f64 = 0.2;

/// Coefficients of this size are no tableau.
const LOST: f64 = 1e9;

/// Tableaux with more rounded entries are not completed.
pub const MOST_UNKNOWNS: usize = 160;

/// Trees are equations up to this order.
const MOST_TREES: usize = 6;

/// Rooted trees of one colour are equations up to this order.
const MOST_ROOTED: usize = 8;

/// Every equation holds to this in 32 digits, and to the round-off of its terms ([`System::operations`]): the iteration goes on until
/// residuals fall no more.
const SOLVED: f64 = 1e-26;

/// What a solution may be outside of an interval, in units of its half width.
const SLACK: f64 = 1e-6;

/// No interval is narrower than this, twice: in less 32 digits have only round-off.
const NARROWEST: f64 = 1e-30;

/// How often a solution is moved into the intervals.
const ROUNDS: usize = 2000;

/// Singular values below this part of the largest count as 0: equations that follow from the others.
const DEPENDENT: f64 = 1e-9;

/// A tableau that rounds to the digits given.
///
/// ```
/// use euler_poincare::tableau::analysis::analyse;
/// use euler_poincare::tableau::completion::Completion;
/// use euler_poincare::tableau::file::TableauFile;
///
/// // Gauss with two stages, typed to six places: of order 4 to the digits given.
/// let file = TableauFile::parse(
///     "a = [[0.25, -0.038675], [0.538675, 0.25]]
///      b = [0.5, 0.5]",
/// )?;
/// let analysis = analyse(&file.description(), 6)?;
/// let completed: &Completion = analysis.completion.as_ref().expect("a tableau of a higher order");
/// assert!(completed.order == 4 && completed.moved < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// Its entries, the rounded ones with 34 decimal places.
    pub entries: Entries,
    /// Its variational order.
    pub order: usize,
    /// The largest distance of an entry from the digits given.
    pub moved: f64,
}

/// The tableau of the highest variational order (and, for that, of the highest classical one up to 8) in the intervals of the entries.
///
/// `typed` and `allowed` are the orders of exactly these digits, and those that no condition alone excludes. `None` if none of a
/// higher order than that of the digits was found, although one is not excluded, or if there are too many rounded entries.
///
/// # Errors
/// An entry without a value in 32 digits.
pub fn complete(entries: &Entries, typed: &Findings, allowed: &Findings) -> Result<Option<Completion>, TableauError> {
    let problems = [Problem::new(entries, true)?, Problem::new(entries, false)?];
    if problems.iter().any(|problem| problem.unknowns.len() > MOST_UNKNOWNS) {
        return Ok(None);
    }
    let (least, most) = (typed.variational.order, allowed.variational.most.unwrap_or(allowed.variational.order));
    for order in (least + 1..=most).rev() {
        for problem in &problems {
            let system = |rooted: usize| problem.find(&System::Assumptions { order, rooted });
            let trees = || (order <= MOST_TREES).then(|| problem.find(&System::Trees { order })).flatten();
            let Some(found) = system(0).or_else(|| if problem.positive() { None } else { trees() }) else { continue };
            return Ok(Some(problem.completion(order, &problem.rooted(order, allowed).unwrap_or(found))));
        }
    }
    // Exactly these digits, unless a higher order was not excluded; but a higher classical order may be there.
    let [problem, _] = &problems;
    if most > least && !problem.positive() {
        return Ok(None);
    }
    let rooted = problems.iter().find_map(|problem| {
        let y = problem.rooted(least, allowed).filter(|_| allowed.classical.order > typed.classical.order)?;
        Some(problem.completion(least, &y))
    });
    let digits = || problem.completion(least, &vec![Dd::exact(0.0); problem.unknowns.len()]);
    Ok(Some(rooted.unwrap_or_else(digits)))
}

/// The equations that make up an order.
enum System {
    /// B(p), C(k), D(k) and the condition between them: variational order p; and, if larger, the rooted trees up to `rooted`.
    Assumptions { order: usize, rooted: usize },
    /// The bicoloured trees up to this order.
    Trees { order: usize },
}

impl System {
    /// Left minus right of each, with the sizes of their terms.
    fn defects(&self, coefficients: &Coefficients<Ball<Dd>>) -> Vec<Ball<Dd>> {
        match *self {
            System::Trees { order } => trees(coefficients, 2, order),
            System::Assumptions { order, rooted } => {
                let mut found = assumptions(coefficients, order);
                if rooted > order {
                    found.extend(trees(coefficients, 1, rooted));
                }
                found
            }
        }
    }

    /// The rounded operations on each term of a defect: products of up to as many factors as the order is high, and sums over the stages.
    /// Those of a verdict on a tree.
    fn operations(&self, stages: usize) -> usize {
        let order = match *self {
            System::Trees { order } => order,
            System::Assumptions { order, rooted } => order.max(rooted),
        };
        8 * order * (stages + 2)
    }
}

/// B(p), C(k), D(k) and, for p = 2k + 2, the condition between them, in Legendre polynomials P_m on [0, 1], with Q_m = ∫₀ P_m:
/// Σ b_i P_m(c_i) = δ_m0 for m < p, Σ a_ij P_m(c_j) = Q_m(c_i) and Σ b_i P_m(c_i) a_ij = b_j (Q_m(1) − Q_m(c_j)) for m < k, and
/// Σ b_i P_k(c_i) a_ij P_k(c_j) = ∫ P_k Q_k.
fn assumptions(coefficients: &Coefficients<Ball<Dd>>, order: usize) -> Vec<Ball<Dd>> {
    let Coefficients { a, b, c, .. } = coefficients;
    let (s, k) = (b.len(), (order - 1) / 2);
    let sum = |term: &dyn Fn(usize) -> Ball<Dd>| (0..s).fold(Ball::fraction(0, 1), |sum, i| sum.plus(&term(i)));
    let p: Vec<Vec<Dd>> = c.iter().map(|c| legendre(order.max(k + 2), &(c.value + c.value - Dd::exact(1.0)))).collect();
    // On [0, 1] |P_m| ≤ 1: the recurrence rounds by that, and c_i by its terms.
    let p = |i: usize, m: usize| Ball::new(p[i][m], p[i][m].to_f64().abs().max(1.0) * c[i].size.max(1.0));
    let integral = |m: usize, i: usize| match m {
        0 => c[i],
        _ => {
            let Ball { value, size, .. } = p(i, m + 1).minus(&p(i, m - 1));
            Ball::new(value / Dd::int(4 * m as i64 + 2), size)
        }
    };
    let one = |m: usize| Ball::fraction(i64::from(m == 0), 1);
    let mut found: Vec<_> = (0..order).map(|m| sum(&|i| b[i].times(&p(i, m))).minus(&one(m))).collect();
    for m in 0..k {
        // C(1) is the definition of c.
        if m > 0 {
            found.extend((0..s).map(|i| sum(&|j| a[i][j].times(&p(j, m))).minus(&integral(m, i))));
        }
        let right = |j: usize| b[j].times(&one(m).minus(&integral(m, j)));
        found.extend((0..s).map(|j| sum(&|i| b[i].times(&p(i, m)).times(&a[i][j])).minus(&right(j))));
    }
    if order == 2 * k + 2 {
        let inner = |i: usize| sum(&|j| a[i][j].times(&p(j, k)));
        let half = Ball::fraction(i64::from(k == 0), 2);
        found.push(sum(&|i| b[i].times(&p(i, k)).times(&inner(i))).minus(&half));
    }
    found
}

/// Σ b Φ − 1/γ of the trees up to an order.
fn trees(coefficients: &Coefficients<Ball<Dd>>, colours: usize, order: usize) -> Vec<Ball<Dd>> {
    let mut conditions = Conditions::of(coefficients, colours);
    let mut found = Vec::new();
    for n in 1..=order {
        found.extend(conditions.visit(n, |conditions, tree| {
            Some(conditions.weight(tree).minus(&Ball::fraction(1, tree.density() as i64)))
        }));
    }
    found
}

/// A rounded entry.
struct Unknown {
    /// The row of a; `None` for b.
    row: Option<usize>,
    column: usize,
    /// The value of the digits.
    centre: Dd,
    /// Half the width of the interval.
    radius: f64,
}

struct Problem<'e> {
    entries: &'e Entries,
    a: Vec<Vec<Dd>>,
    b: Vec<Dd>,
    unknowns: Vec<Unknown>,
}

impl<'e> Problem<'e> {
    fn new(entries: &'e Entries, uniform: bool) -> Result<Self, TableauError> {
        let bad = |why: crate::scalar::NumberError| TableauError::BadEntry { entry: "a".into(), why: why.to_string() };
        let row = |row: &[Number]| row.iter().map(Number::eval::<Dd>).collect::<Result<Vec<_>, _>>().map_err(bad);
        let a = entries.a.iter().map(|numbers| row(numbers)).collect::<Result<Vec<_>, _>>()?;
        let b = row(&entries.b)?;
        let rows = entries.a.iter().enumerate().map(|(i, row)| (Some(i), row)).chain([(None, &entries.b)]);
        let mut radii = entries.allowances(uniform).into_iter();
        let mut unknowns = Vec::new();
        for (row, numbers) in rows {
            for (column, radius) in radii.by_ref().take(numbers.len()).enumerate() {
                if radius > 0.0 {
                    let centre = row.map_or(&b, |i| &a[i])[column];
                    unknowns.push(Unknown { row, column, centre, radius: radius.max(NARROWEST) });
                }
            }
        }
        Ok(Self { entries, a, b, unknowns })
    }

    fn positive(&self) -> bool {
        self.b.iter().all(|b| b.to_f64() > 0.0)
    }

    /// The rounded entries at a point y, in units of their allowances.
    fn values(&self, y: &[Dd]) -> Vec<Dd> {
        self.unknowns.iter().zip(y).map(|(unknown, &y)| unknown.centre + Dd::exact(unknown.radius) * y).collect()
    }

    /// The coefficients with these rounded entries.
    fn coefficients(&self, values: &[Dd]) -> Coefficients<Ball<Dd>> {
        let ball = |x: &Dd| Ball::new(*x, x.to_f64().abs());
        let mut a: Vec<Vec<Ball<Dd>>> = self.a.iter().map(|row| row.iter().map(ball).collect()).collect();
        let mut b: Vec<Ball<Dd>> = self.b.iter().map(ball).collect();
        for (unknown, value) in self.unknowns.iter().zip(values) {
            match unknown.row {
                Some(row) => a[row][unknown.column] = ball(value),
                None => b[unknown.column] = ball(value),
            }
        }
        Coefficients::conjugated(a, b)
    }

    /// A solution of the highest classical order above a variational one.
    fn rooted(&self, order: usize, allowed: &Findings) -> Option<Vec<Dd>> {
        let highest = allowed.classical.order.min(MOST_ROOTED);
        (order + 1..=highest).rev().find_map(|rooted| self.find(&System::Assumptions { order, rooted }))
    }

    /// A solution within all intervals.
    fn find(&self, system: &System) -> Option<Vec<Dd>> {
        let y = self.newton(system, vec![Dd::exact(0.0); self.unknowns.len()])?;
        if largest(&y) <= 1.0 + SLACK {
            return Some(y);
        }
        let jacobian = self.jacobian(system, &self.values(&y));
        let start = DVector::from_iterator(y.len(), y.iter().map(|y| y.to_f64()));
        let inside = meet(jacobian, start)?;
        let y = self.newton(system, inside.iter().map(|&y| Dd::exact(y)).collect())?;
        (largest(&y) <= 1.0 + SLACK).then_some(y)
    }

    /// The solution that the iteration reaches from y: of its points the one with the least residual.
    fn newton(&self, system: &System, mut y: Vec<Dd>) -> Option<Vec<Dd>> {
        let operations = system.operations(self.b.len());
        let (mut solver, mut before) = (None, f64::INFINITY);
        let (mut least, mut best) = (f64::INFINITY, None);
        for step in 0..MAX_NEWTON {
            let values = self.values(&y);
            let found = system.defects(&self.coefficients(&values));
            let residual = DVector::from_iterator(found.len(), found.iter().map(|x| x.value.to_f64()));
            let size = residual.amax();
            if size < least {
                least = size;
                let rounded = size <= SOLVED && found.iter().all(|defect| defect.vanishes(operations));
                best = rounded.then(|| y.clone());
            }
            let stalled = size > STALLED * before;
            if size == 0.0 || (stalled && best.is_some()) {
                return best;
            }
            // An inconsistent system ends where the residual is least, and not zero.
            if !size.is_finite() || (step >= SETTLING && stalled && size > SOLVED) || largest(&y) > LOST {
                return None;
            }
            before = size;
            if solver.is_none() || size > 1e-20 {
                solver = Some(self.jacobian(system, &values).svd(true, true));
            }
            let decomposition = solver.as_ref()?;
            let threshold = DEPENDENT * decomposition.singular_values.amax();
            let change = decomposition.solve(&residual, threshold).ok()?;
            y.iter_mut().zip(change.iter()).for_each(|(y, &change)| *y -= Dd::exact(change));
        }
        best
    }

    /// ∂(defects)/∂y by differences.
    fn jacobian(&self, system: &System, values: &[Dd]) -> DMatrix<f64> {
        const STEP: f64 = 1e-13;
        let at = system.defects(&self.coefficients(values));
        let mut jacobian = DMatrix::zeros(at.len(), values.len());
        for (column, unknown) in self.unknowns.iter().enumerate() {
            let mut moved = values.to_vec();
            moved[column] += Dd::exact(STEP);
            let there = system.defects(&self.coefficients(&moved));
            for (row, (there, here)) in there.iter().zip(&at).enumerate() {
                jacobian[(row, column)] = (there.value - here.value).to_f64() / STEP * unknown.radius;
            }
        }
        jacobian
    }

    /// The tableau at y.
    fn completion(&self, order: usize, y: &[Dd]) -> Completion {
        let mut entries = Entries { c: None, ..self.entries.clone() };
        let mut moved = 0.0f64;
        for (unknown, value) in self.unknowns.iter().zip(self.values(y)) {
            let distance = (value - unknown.centre).to_f64().abs();
            // What rounding moves, stays.
            if distance <= unknown.centre.to_f64().abs() * Dd::unit_roundoff().to_f64() {
                continue;
            }
            moved = moved.max(distance);
            let place = match unknown.row {
                Some(row) => &mut entries.a[row][unknown.column],
                None => &mut entries.b[unknown.column],
            };
            if let Ok(number) = format!("{value:.34}").parse() {
                *place = number;
            }
        }
        Completion { entries, order, moved }
    }
}

/// A point of y + ker J in the cube |y_i| ≤ 1, by projections onto the two in turn.
fn meet(jacobian: DMatrix<f64>, y: DVector<f64>) -> Option<DVector<f64>> {
    let decomposition = jacobian.svd(false, true);
    let least = DEPENDENT * decomposition.singular_values.amax();
    let rows = decomposition.v_t.as_ref()?;
    let kept: Vec<usize> = (0..rows.nrows()).filter(|&k| decomposition.singular_values[k] > least).collect();
    let normal = rows.select_rows(&kept);
    let mut point = y.clone();
    for _ in 0..ROUNDS {
        let clipped = point.map(|y| y.clamp(-1.0, 1.0));
        let next = &clipped - normal.tr_mul(&(&normal * (&clipped - &y)));
        let (outside, step) = (next.amax() - 1.0, (&next - &point).amax());
        point = next;
        if outside <= 0.5 * SLACK {
            return Some(point);
        }
        if step < 1e-3 * SLACK {
            return None;
        }
    }
    None
}

/// The largest |y|.
fn largest(y: &[Dd]) -> f64 {
    y.iter().map(|y| y.to_f64().abs()).fold(0.0, f64::max)
}
