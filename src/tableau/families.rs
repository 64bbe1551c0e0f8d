//! The families of tableaux with any number of stages, and a few classical tableaux, at the full precision of the scalar.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/tableau/families.md"))]

use super::{Tableau, TableauError};
use crate::scalar::Real;
use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The largest number of stages that a family gives: more is refused (the cost is s³, and no run uses them).
pub const MAX_STAGES: usize = 64;

/// A family with one member for each number of stages s.
///
/// Nodes: zeros of P_s (Gauss), of P_s + P_{s−1} (Radau I), P_s − P_{s−1} (Radau II), P_s − P_{s−2} (Lobatto), shifted to
/// \[0, 1\]. Note that [`Tableau::c`] is the row sum of a, which for `RadauIA` with s = 1 and `LobattoIIIB` with s = 2 is
/// not the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Family {
    /// Collocation at the Gauss nodes: B(2s), C(s), D(s); its own conjugate.
    Gauss,
    /// Collocation at the Lobatto nodes: B(2s − 2), C(s), D(s − 2).
    LobattoIIIA,
    /// The conjugate of `LobattoIIIA`: B(2s − 2), C(s − 2), D(s).
    LobattoIIIB,
    /// a_i1 = b_1 and C(s − 1) at the Lobatto nodes: B(2s − 2), D(s − 1).
    LobattoIIIC,
    /// The mean of `LobattoIIIC` and its conjugate (Nørsett and Wanner 1981): B(2s − 2), C(s − 1), D(s − 1); symplectic.
    LobattoIIID,
    /// The mean of `LobattoIIIA` and `LobattoIIIB` (Chan 1990): B(2s − 2), C(s − 2), D(s − 2); symplectic.
    LobattoIIIE,
    /// The conjugate of collocation at the left Radau nodes: B(2s − 1), C(s − 1), D(s).
    RadauIA,
    /// Collocation at the right Radau nodes: B(2s − 1), C(s), D(s − 1).
    RadauIIA,
}

/// Which end points of \[−1, 1\] are nodes.
#[derive(Clone, Copy, PartialEq)]
enum Ends {
    None,
    Left,
    Right,
    Both,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 8] = [
        Family::Gauss,
        Family::LobattoIIIA,
        Family::LobattoIIIB,
        Family::LobattoIIIC,
        Family::LobattoIIID,
        Family::LobattoIIIE,
        Family::RadauIA,
        Family::RadauIIA,
    ];

    /// Those that random tableaux are drawn from: a fixed list, so that a seed keeps its meaning.
    pub const DRAWN: [Family; 6] = [
        Family::Gauss,
        Family::LobattoIIIA,
        Family::LobattoIIIB,
        Family::LobattoIIIC,
        Family::RadauIA,
        Family::RadauIIA,
    ];

    /// `gauss`, `lobatto-iiia` to `lobatto-iiie`, `radau-ia`, `radau-iia`.
    pub fn name(self) -> &'static str {
        match self {
            Family::Gauss => "gauss",
            Family::LobattoIIIA => "lobatto-iiia",
            Family::LobattoIIIB => "lobatto-iiib",
            Family::LobattoIIIC => "lobatto-iiic",
            Family::LobattoIIID => "lobatto-iiid",
            Family::LobattoIIIE => "lobatto-iiie",
            Family::RadauIA => "radau-ia",
            Family::RadauIIA => "radau-iia",
        }
    }

    /// The smallest number of stages: 2 for Lobatto, else 1.
    pub fn least_stages(self) -> usize {
        if self.ends() == Ends::Both { 2 } else { 1 }
    }

    /// Whether the family has a member with this many stages.
    ///
    /// # Errors
    /// [`TableauError::Unknown`], with the limits.
    pub fn check(self, stages: usize) -> Result<(), TableauError> {
        let least = self.least_stages();
        if (least..=MAX_STAGES).contains(&stages) {
            return Ok(());
        }
        let why = format!("the number of stages must be from {least} to {MAX_STAGES}");
        Err(TableauError::Unknown { name: format!("{}-{stages}", self.name()), why })
    }

    fn ends(self) -> Ends {
        match self {
            Family::Gauss => Ends::None,
            Family::RadauIA => Ends::Left,
            Family::RadauIIA => Ends::Right,
            _ => Ends::Both,
        }
    }

    /// The classical order of the member with s = `stages`: 2s for Gauss, 2s − 1 for Radau, 2s − 2 for Lobatto.
    pub fn declared(self, stages: usize) -> usize {
        (2 * stages).saturating_sub(match self.ends() {
            Ends::None => 0,
            Ends::Left | Ends::Right => 1,
            Ends::Both => 2,
        })
    }

    /// The member with s = `stages`.
    ///
    /// Accuracy: a_ij and b_j are off by at most 4 u (u the unit round-off of `T`; tested against more digits up to s = 32).
    ///
    /// # Errors
    /// [`TableauError::Unknown`] for fewer stages than [`Family::least_stages`] or more than [`MAX_STAGES`].
    pub fn tableau<T: Real>(self, stages: usize) -> Result<Tableau<T>, TableauError> {
        self.check(stages)?;
        let nodes = nodes::<T>(self.ends(), stages).ok_or_else(|| TableauError::Unknown {
            name: format!("{}-{stages}", self.name()),
            why: "the nodes did not converge".into(),
        })?;
        let (a, b) = self.coefficients(&nodes);
        Tableau::new(&a, &b)
    }

    /// a and b in exact arithmetic, where the nodes are rational: one stage, two (Radau, Lobatto) or three (Lobatto).
    #[cfg(feature = "harness")]
    pub(super) fn rational(self, stages: usize) -> Option<Coefficients<dashu_ratio::RBig>> {
        let nodes: &[(i64, i64)] = match (self.ends(), stages) {
            (Ends::None, 1) => &[(0, 1)],
            (Ends::Left, 1) => &[(-1, 1)],
            (Ends::Left, 2) => &[(-1, 1), (1, 3)],
            (Ends::Right, 1) => &[(1, 1)],
            (Ends::Right, 2) => &[(-1, 3), (1, 1)],
            (Ends::Both, 2) => &[(-1, 1), (1, 1)],
            (Ends::Both, 3) => &[(-1, 1), (0, 1), (1, 1)],
            _ => return None,
        };
        let nodes: Vec<_> = nodes.iter().map(|&(p, q)| Field::fraction(p, q)).collect();
        Some(self.coefficients(&nodes))
    }

    /// a and b from the nodes in \[−1, 1\].
    fn coefficients<F: Field>(self, nodes: &[F]) -> Coefficients<F> {
        let stages = nodes.len();
        let rows: Vec<Vec<F>> = nodes.iter().map(|x| legendre(stages, x)).collect();
        let b = weights(self.ends(), &rows);
        let (one, half) = (F::fraction(1, 1), F::fraction(1, 2));
        let q = |i: usize, j: usize| integral(self, &rows[i], &rows[j], &nodes[i]);
        let entry = |i: usize, j: usize| match self {
            Family::LobattoIIIB | Family::RadauIA => b[j].clone() * (one.clone() - q(j, i)),
            Family::LobattoIIID | Family::LobattoIIIE => {
                b[j].clone() * (half.clone() * (one.clone() + (q(i, j) - q(j, i))))
            }
            _ => b[j].clone() * q(i, j),
        };
        let a = (0..stages).map(|i| (0..stages).map(|j| entry(i, j)).collect()).collect();
        (a, b)
    }
}

/// a by rows, and b.
pub(super) type Coefficients<F> = (Vec<Vec<F>>, Vec<F>);

/// What coefficients are computed in: every scalar, and exact rationals.
pub(crate) trait Field:
    Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// p/q.
    fn fraction(p: i64, q: i64) -> Self;

    /// The zero near `start` of Σ_k p_k x^k; `None` where it is not in the field or Newton's method does not settle.
    fn zero_near(polynomial: &[i64], start: f64) -> Option<Self>;
}

impl<T: Real> Field for T {
    fn fraction(p: i64, q: i64) -> Self {
        T::ratio(p, q)
    }

    fn zero_near(polynomial: &[i64], start: f64) -> Option<Self> {
        newton(T::exact(start), |x| {
            polynomial
                .iter()
                .rev()
                .fold((T::zero(), T::zero()), |(value, slope), &p| (value * x + T::int(p), slope * x + value))
        })
    }
}

#[cfg(feature = "harness")]
impl Field for dashu_ratio::RBig {
    fn fraction(p: i64, q: i64) -> Self {
        Self::from_parts_signed(p.into(), q.into())
    }

    fn zero_near(_: &[i64], _: f64) -> Option<Self> {
        None
    }
}

/// q_ij from the Legendre values at x_i and x_j (for Lobatto the last term vanishes, as P_s = P_{s−2} at the nodes).
///
/// IIIC has ½ P_{s−1}(x_j) (P_{s−1}(x_i) − P_{s−2}(x_i)) as its last term: C(s − 1) leaves it free, and a_i1 = b_1 fixes it.
fn integral<F: Field>(family: Family, at_i: &[F], at_j: &[F], x_i: &F) -> F {
    let s = at_i.len() - 1;
    let last = if family.ends() == Ends::Both { s - 1 } else { s };
    let mut sum = F::fraction(0, 1);
    for k in (1..last).rev() {
        sum = sum + at_j[k].clone() * (at_i[k + 1].clone() - at_i[k - 1].clone());
    }
    if matches!(family, Family::LobattoIIIC | Family::LobattoIIID) {
        sum = sum + at_j[s - 1].clone() * (at_i[s - 1].clone() - at_i[s - 2].clone());
    }
    F::fraction(1, 2) * (F::fraction(1, 1) + x_i.clone() + sum)
}

/// b_j = 1/Σ_{k<s} ν_k P_k(x_j)² with ν_k = 2k + 1, but ν_{s−1} = s − 1 at the Lobatto nodes (discrete orthogonality).
fn weights<F: Field>(ends: Ends, rows: &[Vec<F>]) -> Vec<F> {
    let s = rows.len();
    let nu = |k: usize| if ends == Ends::Both && k == s - 1 { k as i64 } else { 2 * k as i64 + 1 };
    let square = |p: &F, k: usize| F::fraction(nu(k), 1) * p.clone() * p.clone();
    let sum = |p: &Vec<F>| (0..s).rev().fold(F::fraction(0, 1), |sum, k| sum + square(&p[k], k));
    rows.iter().map(|p| F::fraction(1, 1) / sum(p)).collect()
}

/// P_0(x) … P_n(x).
pub(crate) fn legendre<F: Field>(n: usize, x: &F) -> Vec<F> {
    let integer = |k: i64| F::fraction(k, 1);
    let mut p = vec![integer(1), x.clone()];
    for k in 1..n as i64 {
        let (last, before) = (p[k as usize].clone(), p[k as usize - 1].clone());
        p.push((integer(2 * k + 1) * x.clone() * last - integer(k) * before) / integer(k + 1));
    }
    p.truncate(n + 1);
    p
}

/// The nodes x_1 < … < x_s in \[−1, 1\]: the prescribed ends and the zeros of the Jacobi polynomial orthogonal to the rest.
fn nodes<T: Real>(ends: Ends, s: usize) -> Option<Vec<T>> {
    let (alpha, beta) = match ends {
        Ends::None => (0, 0),
        Ends::Left | Ends::Right => (1, 0),
        Ends::Both => (1, 1),
    };
    let n = s - (alpha + beta) as usize;
    let mut x = Vec::with_capacity(s);
    if ends == Ends::Both {
        x.push(-T::one());
    }
    for k in 0..n {
        let mirrored = alpha == beta && 2 * k + 1 >= n;
        x.push(match mirrored {
            true if 2 * k + 1 == n => T::zero(),
            true => -x[s - 1 - x.len()],
            false => jacobi_zero(n, alpha, beta, n - k)?,
        });
    }
    if ends != Ends::None {
        x.push(T::one());
    }
    if ends == Ends::Left {
        x.reverse();
        x.iter_mut().for_each(|v| *v = -*v);
    }
    x.windows(2).all(|pair| pair[0] < pair[1]).then_some(x)
}

/// The k-th largest zero of P_n^{(α,β)}, by Newton from x ≈ cos(π (k + α/2 − ¼)/(n + (α + β + 1)/2)) (Szegő 1939, 8.9).
fn jacobi_zero<T: Real>(n: usize, alpha: i64, beta: i64, k: usize) -> Option<T> {
    let angle = PI * (k as f64 + alpha as f64 / 2.0 - 0.25) / (n as f64 + (alpha + beta + 1) as f64 / 2.0);
    newton(T::exact(angle.cos()), |x| jacobi(n, alpha, beta, x))
}

/// The most iterations of Newton's method: starts are good to a digit or two, and five reach 32 digits.
const MAX_NEWTON: usize = 50;

/// The zero that Newton's method finds from `x` with (value, derivative), to round-off.
fn newton<T: Real>(mut x: T, at: impl Fn(T) -> (T, T)) -> Option<T> {
    let mut previous = T::one();
    for _ in 0..MAX_NEWTON {
        let (value, slope) = at(x);
        let step = value / slope;
        let size = step.abs();
        if !size.all_finite() {
            return None;
        }
        x -= step;
        // Steps shrink quadratically until round-off, where they stay: the last of them is noise of a few u.
        if size <= T::unit_roundoff() || (size * size <= T::unit_roundoff() && size >= T::half() * previous) {
            return Some(x);
        }
        previous = size;
    }
    None
}

/// P_n^{(α,β)}(x) and its derivative, by the three-term recurrence and its derivative.
fn jacobi<T: Real>(n: usize, alpha: i64, beta: i64, x: T) -> (T, T) {
    let sum = alpha + beta;
    let (mut p0, mut d0) = (T::one(), T::zero());
    let (mut p1, mut d1) = (T::half() * (T::int(alpha - beta) + T::int(sum + 2) * x), T::ratio(sum + 2, 2));
    if n == 0 {
        return (p0, d0);
    }
    for k in 1..n as i64 {
        let m = 2 * k + sum;
        let lead = T::int(2 * (k + 1) * (k + sum + 1) * m);
        let slope = T::int((m + 1) * (m + 2) * m);
        let factor = slope * x + T::int((m + 1) * (alpha * alpha - beta * beta));
        let back = T::int(2 * (k + alpha) * (k + beta) * (m + 2));
        let p2 = (factor * p1 - back * p0) / lead;
        let d2 = (factor * d1 + slope * p1 - back * d0) / lead;
        (p0, d0, p1, d1) = (p1, d1, p2, d2);
    }
    (p1, d1)
}

/// A classical tableau with a fixed number of stages.
///
/// The explicit midpoint rule is not among them: it has b_1 = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Classic {
    /// Euler's explicit method.
    Euler,
    /// Heun's second-order method: c = (0, 1), b = (½, ½).
    Heun2,
    /// Ralston's third-order method (Ralston 1962).
    Ralston3,
    /// The classical Runge–Kutta method of order 4 (Kutta 1901).
    Rk4,
    /// The 3/8 rule (Kutta 1901).
    Kutta38,
    /// Two diagonally implicit stages of order 3, γ = (3 + √3)/6 (Nørsett 1974, Crouzeix 1975).
    Sdirk2,
    /// Three diagonally implicit stages of order 4, γ = ½ + cos(π/18)/√3 (Nørsett 1974, Crouzeix 1975).
    Sdirk3,
    /// Two stiffly accurate diagonally implicit stages of order 2, γ = 1 − √2/2 (Alexander 1977).
    Alexander2,
    /// Three stiffly accurate diagonally implicit stages of order 3, γ ≈ 0.4359 (Alexander 1977).
    Alexander3,
}

impl Classic {
    /// All of them.
    pub const ALL: [Classic; 9] = [
        Classic::Euler,
        Classic::Heun2,
        Classic::Ralston3,
        Classic::Rk4,
        Classic::Kutta38,
        Classic::Sdirk2,
        Classic::Sdirk3,
        Classic::Alexander2,
        Classic::Alexander3,
    ];

    /// Those that random tableaux are drawn from: a fixed list, so that a seed keeps its meaning.
    pub const DRAWN: [Classic; 5] =
        [Classic::Heun2, Classic::Ralston3, Classic::Rk4, Classic::Kutta38, Classic::Sdirk2];

    /// `euler`, `heun2`, `ralston3`, `rk4`, `kutta38`, `sdirk2`, `sdirk3`, `alexander2`, `alexander3`.
    pub fn name(self) -> &'static str {
        match self {
            Classic::Euler => "euler",
            Classic::Heun2 => "heun2",
            Classic::Ralston3 => "ralston3",
            Classic::Rk4 => "rk4",
            Classic::Kutta38 => "kutta38",
            Classic::Sdirk2 => "sdirk2",
            Classic::Sdirk3 => "sdirk3",
            Classic::Alexander2 => "alexander2",
            Classic::Alexander3 => "alexander3",
        }
    }

    /// The number of stages.
    pub fn stages(self) -> usize {
        match self {
            Classic::Euler => 1,
            Classic::Heun2 | Classic::Sdirk2 | Classic::Alexander2 => 2,
            Classic::Ralston3 | Classic::Sdirk3 | Classic::Alexander3 => 3,
            Classic::Rk4 | Classic::Kutta38 => 4,
        }
    }

    /// The classical order that the source gives.
    pub fn declared(self) -> usize {
        match self {
            Classic::Euler => 1,
            Classic::Heun2 | Classic::Alexander2 => 2,
            Classic::Ralston3 | Classic::Sdirk2 | Classic::Alexander3 => 3,
            Classic::Rk4 | Classic::Kutta38 | Classic::Sdirk3 => 4,
        }
    }

    /// The tableau, each entry rounded once (those that depend on an irrational γ: a few roundings).
    ///
    /// # Errors
    /// None in practice: those of [`Tableau::new`].
    pub fn tableau<T: Real>(self) -> Result<Tableau<T>, TableauError> {
        let (a, b) = self.coefficients::<T>().ok_or_else(|| TableauError::Unknown {
            name: self.name().into(),
            why: "the diagonal entry did not converge".into(),
        })?;
        Tableau::new(&a, &b)
    }

    /// a and b in exact arithmetic, if they are rational.
    #[cfg(feature = "harness")]
    pub(super) fn rational(self) -> Option<Coefficients<dashu_ratio::RBig>> {
        self.coefficients()
    }

    fn coefficients<F: Field>(self) -> Option<Coefficients<F>> {
        let r = |p: i64, q: i64| F::fraction(p, q);
        let row = |fractions: &[(i64, i64)]| -> Vec<F> { fractions.iter().map(|&(p, q)| r(p, q)).collect() };
        let o = (0, 1);
        Some(match self {
            Classic::Euler => (vec![row(&[o])], row(&[(1, 1)])),
            Classic::Heun2 => (vec![row(&[o, o]), row(&[(1, 1), o])], row(&[(1, 2), (1, 2)])),
            Classic::Ralston3 => {
                (vec![row(&[o, o, o]), row(&[(1, 2), o, o]), row(&[o, (3, 4), o])], row(&[(2, 9), (1, 3), (4, 9)]))
            }
            Classic::Rk4 => (
                vec![row(&[o, o, o, o]), row(&[(1, 2), o, o, o]), row(&[o, (1, 2), o, o]), row(&[o, o, (1, 1), o])],
                row(&[(1, 6), (1, 3), (1, 3), (1, 6)]),
            ),
            Classic::Kutta38 => (
                vec![
                    row(&[o, o, o, o]),
                    row(&[(1, 3), o, o, o]),
                    row(&[(-1, 3), (1, 1), o, o]),
                    row(&[(1, 1), (-1, 1), (1, 1), o]),
                ],
                row(&[(1, 8), (3, 8), (3, 8), (1, 8)]),
            ),
            Classic::Sdirk2 => {
                let root = F::zero_near(&[-3, 0, 1], 1.732)?;
                let gamma = (r(3, 1) + root.clone()) / r(6, 1);
                (vec![vec![gamma.clone(), r(0, 1)], vec![-root / r(3, 1), gamma]], row(&[(1, 2), (1, 2)]))
            }
            Classic::Sdirk3 => return sdirk3(),
            Classic::Alexander2 => {
                let gamma = r(1, 1) - F::zero_near(&[-2, 0, 1], 1.414)? / r(2, 1);
                let b = vec![r(1, 1) - gamma.clone(), gamma.clone()];
                (vec![vec![gamma, r(0, 1)], b.clone()], b)
            }
            Classic::Alexander3 => return alexander3(),
        })
    }
}

/// γ is the largest zero of γ³ − 3/2 γ² + 1/2 γ − 1/24, δ = 1/(6 (2γ − 1)²): c = (γ, ½, 1 − γ), b = (δ, 1 − 2δ, δ).
fn sdirk3<F: Field>() -> Option<Coefficients<F>> {
    let r = |p: i64, q: i64| F::fraction(p, q);
    let gamma = F::zero_near(&[-1, 12, -36, 24], 1.0686)?;
    let double = r(2, 1) * gamma.clone();
    let delta = r(1, 6) / ((double.clone() - r(1, 1)) * (double.clone() - r(1, 1)));
    let a = vec![
        vec![gamma.clone(), r(0, 1), r(0, 1)],
        vec![r(1, 2) - gamma.clone(), gamma.clone(), r(0, 1)],
        vec![double.clone(), r(1, 1) - double.clone() - double, gamma],
    ];
    Some((a, vec![delta.clone(), r(1, 1) - delta.clone() - delta.clone(), delta]))
}

/// γ is the middle zero of γ³ − 3γ² + 3/2 γ − 1/6; c = (γ, (1 + γ)/2, 1), b_1 = −(6γ² − 16γ + 1)/4, b_2 = (6γ² − 20γ + 5)/4.
fn alexander3<F: Field>() -> Option<Coefficients<F>> {
    let r = |p: i64, q: i64| F::fraction(p, q);
    let gamma = F::zero_near(&[-1, 9, -18, 6], 0.4359)?;
    let square = r(6, 1) * gamma.clone() * gamma.clone();
    let first = (r(16, 1) * gamma.clone() - square.clone() - r(1, 1)) / r(4, 1);
    let second = (square - r(20, 1) * gamma.clone() + r(5, 1)) / r(4, 1);
    let b = vec![first, second, gamma.clone()];
    let half = (r(1, 1) - gamma.clone()) / r(2, 1);
    let a = vec![vec![gamma.clone(), r(0, 1), r(0, 1)], vec![half, gamma, r(0, 1)], b.clone()];
    Some((a, b))
}
