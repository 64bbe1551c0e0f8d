//! The tableau of the highest order among those whose entries round to the digits given.
//!
//! A decimal that counts as rounded stands for the interval of its [allowance](Entries::allowance). The order *to the digits given* is
//! the highest variational order of a tableau with entries in these intervals; [`complete`] finds one, in 64 digits.
//!
//! Method: Gauss and Newton's iteration with steps of least norm (in units of the allowances) on the equations that make up an order:
//! B(p), C(k), D(k) and the condition between them (see [`bounds`](super::bounds)), or, where a weight is negative and they have no
//! solution, the bicoloured trees up to order p. Where the solution leaves an interval, it is moved to the nearest point within all of
//! them and the iteration begins again.

use super::analysis::Findings;
use super::assumptions::{Kind, defects, middle};
use super::order::Conditions;
use super::quantity::{Ball, Coefficients};
use super::{Entries, TableauError};
use crate::scalar::{Dd, Number, Qd, Real, Scalar};
use nalgebra::{DMatrix, DVector};

/// Tableaux with more rounded entries are not completed.
pub const MOST_UNKNOWNS: usize = 160;

/// Trees are equations up to this order.
const MOST_TREES: usize = 6;

/// Rooted trees of one colour are equations up to this order.
const MOST_ROOTED: usize = 8;

/// Every equation holds to this in 64 digits.
const SOLVED: f64 = 1e-58;

/// What a solution may be outside of an interval, in units of its half width: a decimal that was rounded half up.
const SLACK: f64 = 1e-9;

/// How often a solution is moved into the intervals.
const ROUNDS: usize = 60;

/// A tableau that rounds to the digits given.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Completion {
    /// Its entries, the rounded ones with 66 decimal places.
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
/// An entry without a value in 64 digits.
pub fn complete(entries: &Entries, typed: &Findings, allowed: &Findings) -> Result<Option<Completion>, TableauError> {
    let problem = Problem::new(entries)?;
    if problem.unknowns.len() > MOST_UNKNOWNS {
        return Ok(None);
    }
    let (least, most) = (typed.variational.order, allowed.variational.most.unwrap_or(allowed.variational.order));
    for order in (least + 1..=most).rev() {
        let system = |rooted: usize| problem.find(&System::Assumptions { order, rooted });
        let trees = || (order <= MOST_TREES).then(|| problem.find(&System::Trees { order })).flatten();
        let Some(found) = system(0).or_else(|| if problem.positive() { None } else { trees() }) else { continue };
        let rooted = (order + 1..=allowed.classical.order.min(MOST_ROOTED)).rev().find_map(system);
        return Ok(Some(problem.completion(order, &rooted.unwrap_or(found))));
    }
    // Exactly these digits, unless a higher order was not excluded.
    let digits = vec![Qd::exact(0.0); problem.unknowns.len()];
    Ok((most <= least || problem.positive()).then(|| problem.completion(least, &digits)))
}

/// The equations that make up an order.
enum System {
    /// B(p), C(k), D(k) and the condition between them: variational order p; and, if larger, the rooted trees up to `rooted`.
    Assumptions { order: usize, rooted: usize },
    /// The bicoloured trees up to this order.
    Trees { order: usize },
}

impl System {
    /// Left minus right of each.
    fn defects<T: Real>(&self, coefficients: &Coefficients<Ball<T>>) -> Vec<T> {
        let value = |balls: Vec<Ball<T>>| balls.into_iter().map(|ball| ball.value);
        match *self {
            System::Trees { order } => trees(coefficients, 2, order),
            System::Assumptions { order, rooted } => {
                let k = (order - 1) / 2;
                let mut found: Vec<T> = value(defects(coefficients, Kind::B, 1, order)).collect();
                // C(1) is the definition of c.
                found.extend(value(defects(coefficients, Kind::C, 2, k)));
                found.extend(value(defects(coefficients, Kind::D, 1, k)));
                if order == 2 * k + 2 {
                    found.push(middle(coefficients, k).value);
                }
                if rooted > order {
                    found.extend(trees(coefficients, 1, rooted));
                }
                found
            }
        }
    }
}

/// Σ b Φ − 1/γ of the trees up to an order.
fn trees<T: Real>(coefficients: &Coefficients<Ball<T>>, colours: usize, order: usize) -> Vec<T> {
    let mut conditions = Conditions::in_balls(coefficients, colours);
    let mut found = Vec::new();
    for n in 1..=order {
        found.extend(
            conditions
                .visit(n, |conditions, tree| Some(conditions.weight(tree).value - T::ratio(1, tree.density() as i64))),
        );
    }
    found
}

/// A rounded entry.
struct Unknown {
    /// The row of a; `None` for b.
    row: Option<usize>,
    column: usize,
    /// The value of the digits.
    centre: Qd,
    /// Half the width of the interval.
    radius: f64,
}

struct Problem<'e> {
    entries: &'e Entries,
    a: Vec<Vec<Qd>>,
    b: Vec<Qd>,
    unknowns: Vec<Unknown>,
}

impl<'e> Problem<'e> {
    fn new(entries: &'e Entries) -> Result<Self, TableauError> {
        let bad = |why: crate::scalar::NumberError| TableauError::BadEntry { entry: "a".into(), why: why.to_string() };
        let row = |row: &[Number]| row.iter().map(Number::eval::<Qd>).collect::<Result<Vec<_>, _>>().map_err(bad);
        let a = entries.a.iter().map(|numbers| row(numbers)).collect::<Result<Vec<_>, _>>()?;
        let b = row(&entries.b)?;
        let rows = entries.a.iter().enumerate().map(|(i, row)| (Some(i), row)).chain([(None, &entries.b)]);
        let mut unknowns = Vec::new();
        for (row, numbers) in rows {
            for (column, number) in numbers.iter().enumerate() {
                let radius = Entries::allowance::<Dd>(number).to_f64();
                if radius > 0.0 {
                    let centre = row.map_or(&b, |i| &a[i])[column];
                    unknowns.push(Unknown { row, column, centre, radius });
                }
            }
        }
        Ok(Self { entries, a, b, unknowns })
    }

    fn positive(&self) -> bool {
        self.b.iter().all(|b| b.to_f64() > 0.0)
    }

    /// The rounded entries at a point y, in units of their allowances.
    fn values(&self, y: &[Qd]) -> Vec<Qd> {
        self.unknowns.iter().zip(y).map(|(unknown, &y)| unknown.centre + Qd::exact(unknown.radius) * y).collect()
    }

    /// The coefficients with these rounded entries.
    fn coefficients<T: Real>(&self, values: &[Qd]) -> Coefficients<Ball<T>> {
        let ball = |x: &Qd| Ball::new(convert(*x), 1.0);
        let mut a: Vec<Vec<Ball<T>>> = self.a.iter().map(|row| row.iter().map(ball).collect()).collect();
        let mut b: Vec<Ball<T>> = self.b.iter().map(ball).collect();
        for (unknown, value) in self.unknowns.iter().zip(values) {
            match unknown.row {
                Some(row) => a[row][unknown.column] = ball(value),
                None => b[unknown.column] = ball(value),
            }
        }
        let s = b.len();
        let conjugate = |i: usize, j: usize| Ball::new(b[j].value - b[j].value * a[j][i].value / b[i].value, 1.0);
        let hat = (0..s).map(|i| (0..s).map(|j| conjugate(i, j)).collect()).collect();
        Coefficients::new(a, hat, b)
    }

    /// A solution within all intervals.
    fn find(&self, system: &System) -> Option<Vec<Qd>> {
        let mut y = self.newton(system, vec![Qd::exact(0.0); self.unknowns.len()])?;
        for _ in 0..ROUNDS {
            if largest(&y) <= 1.0 + SLACK {
                return Some(y);
            }
            let clipped = y.iter().map(|&y| nalgebra::clamp(y, Qd::exact(-1.0), Qd::exact(1.0))).collect();
            let next = self.newton(system, clipped)?;
            let step = y.iter().zip(&next).map(|(&x, &y)| (x - y).to_f64().abs()).fold(0.0, f64::max);
            // The only solution nearby is outside.
            if step < 1e-6 {
                return None;
            }
            y = next;
        }
        None
    }

    /// The solution that the iteration reaches from y.
    fn newton(&self, system: &System, mut y: Vec<Qd>) -> Option<Vec<Qd>> {
        let (mut solver, mut before) = (None, f64::INFINITY);
        for step in 0..40 {
            let values = self.values(&y);
            let found = system.defects(&self.coefficients::<Qd>(&values));
            let residual = DVector::from_iterator(found.len(), found.iter().map(|x| x.to_f64()));
            let size = residual.amax();
            if size <= SOLVED {
                return Some(y);
            }
            // An inconsistent system ends where the residual is least, and not zero.
            if !size.is_finite() || (step >= 6 && size > 0.2 * before) || largest(&y) > 1e9 {
                return None;
            }
            before = size;
            if solver.is_none() || size > 1e-20 {
                solver = Some(self.jacobian(system, &values).svd(true, true));
            }
            let decomposition = solver.as_ref()?;
            let threshold = 1e-12 * decomposition.singular_values.amax();
            let change = decomposition.solve(&residual, threshold).ok()?;
            y.iter_mut().zip(change.iter()).for_each(|(y, &change)| *y -= Qd::exact(change));
        }
        None
    }

    /// ∂(defects)/∂y by differences, in 32 digits.
    fn jacobian(&self, system: &System, values: &[Qd]) -> DMatrix<f64> {
        const STEP: f64 = 1e-13;
        let at = system.defects(&self.coefficients::<Dd>(values));
        let mut jacobian = DMatrix::zeros(at.len(), values.len());
        for (column, unknown) in self.unknowns.iter().enumerate() {
            let mut moved = values.to_vec();
            moved[column] += Qd::exact(STEP);
            let there = system.defects(&self.coefficients::<Dd>(&moved));
            for (row, (there, here)) in there.iter().zip(&at).enumerate() {
                jacobian[(row, column)] = (*there - *here).to_f64() / STEP * unknown.radius;
            }
        }
        jacobian
    }

    /// The tableau at y.
    fn completion(&self, order: usize, y: &[Qd]) -> Completion {
        let mut entries = Entries { c: None, ..self.entries.clone() };
        let mut moved = 0.0f64;
        for (unknown, value) in self.unknowns.iter().zip(self.values(y)) {
            let distance = (value - unknown.centre).to_f64().abs();
            if distance == 0.0 {
                continue;
            }
            moved = moved.max(distance);
            let place = match unknown.row {
                Some(row) => &mut entries.a[row][unknown.column],
                None => &mut entries.b[unknown.column],
            };
            if let Ok(number) = format!("{value:.66}").parse() {
                *place = number;
            }
        }
        Completion { entries, order, moved }
    }
}

/// The largest |y|.
fn largest(y: &[Qd]) -> f64 {
    y.iter().map(|y| y.to_f64().abs()).fold(0.0, f64::max)
}

/// x in another scalar, to all digits that both have.
fn convert<T: Real>(x: Qd) -> T {
    let (mut rest, mut sum) = (x, T::zero());
    for _ in 0..4 {
        let part = rest.to_f64();
        sum += T::exact(part);
        rest -= Qd::exact(part);
    }
    sum
}
