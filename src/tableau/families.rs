//! The families of tableaux with any number of stages, and a few classical tableaux, at the full precision of the scalar.
//!
//! All six families come from one expansion in Legendre polynomials (the W-transformation of Hairer and Wanner,
//! *Solving Ordinary Differential Equations II*, section IV.5). With nodes x_i = 2c_i − 1 of a quadrature formula of
//! order at least 2s − 2 the Lagrange polynomials are ℓ_j(x) = b_j Σ_k ν_k P_k(x_j) P_k(x), and
//! ∫_{−1}^x P_k = (P_{k+1}(x) − P_{k−1}(x))/(2k + 1), so that a_ij = ∫₀^{c_i} ℓ_j = b_j q_ij with
//!
//! q_ij = ½ [1 + x_i + Σ_{k=1}^{s−1} P_k(x_j) (P_{k+1}(x_i) − P_{k−1}(x_i))].
//!
//! Every term is bounded by 2, so a_ij is accurate to a few units of round-off of b_j, without linear systems.

use super::{Tableau, TableauError};
use crate::scalar::Real;
use std::f64::consts::PI;

/// The largest number of stages that a family gives: more is refused (the cost is s³, and nobody steps with them).
pub const MAX_STAGES: usize = 64;

/// A family with one member for each number of stages s.
///
/// Nodes: zeros of P_s (Gauss), of P_s + P_{s−1} (Radau I), P_s − P_{s−1} (Radau II), P_s − P_{s−2} (Lobatto), shifted to
/// \[0, 1\]. Note that [`Tableau::c`] is the row sum of a, which for `RadauIA` with s = 1 and `LobattoIIIB` with s = 2 is
/// not the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// Collocation at the Gauss nodes: B(2s), C(s), D(s); its own conjugate.
    Gauss,
    /// Collocation at the Lobatto nodes: B(2s − 2), C(s), D(s − 2).
    LobattoIIIA,
    /// The conjugate of `LobattoIIIA`: B(2s − 2), C(s − 2), D(s).
    LobattoIIIB,
    /// a_i1 = b_1 and C(s − 1) at the Lobatto nodes: B(2s − 2), D(s − 1).
    LobattoIIIC,
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
    pub const ALL: [Family; 6] = [
        Family::Gauss,
        Family::LobattoIIIA,
        Family::LobattoIIIB,
        Family::LobattoIIIC,
        Family::RadauIA,
        Family::RadauIIA,
    ];

    /// `gauss`, `lobatto-iiia`, `lobatto-iiib`, `lobatto-iiic`, `radau-ia`, `radau-iia`.
    pub fn name(self) -> &'static str {
        match self {
            Family::Gauss => "gauss",
            Family::LobattoIIIA => "lobatto-iiia",
            Family::LobattoIIIB => "lobatto-iiib",
            Family::LobattoIIIC => "lobatto-iiic",
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
            Family::LobattoIIIA | Family::LobattoIIIB | Family::LobattoIIIC => Ends::Both,
            Family::RadauIA => Ends::Left,
            Family::RadauIIA => Ends::Right,
        }
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
        let rows: Vec<Vec<T>> = nodes.iter().map(|&x| legendre(stages, x)).collect();
        let b = weights(self.ends(), &rows);
        let q = |i: usize, j: usize| integral(self, &rows[i], &rows[j], nodes[i]);
        let entry = |i: usize, j: usize| match self {
            Family::LobattoIIIB | Family::RadauIA => b[j] * (T::one() - q(j, i)),
            _ => b[j] * q(i, j),
        };
        let a: Vec<Vec<T>> = (0..stages).map(|i| (0..stages).map(|j| entry(i, j)).collect()).collect();
        Tableau::new(&a, &b)
    }
}

/// q_ij from the Legendre values at x_i and x_j (for Lobatto the last term vanishes, as P_s = P_{s−2} at the nodes).
///
/// IIIC has ½ P_{s−1}(x_j) (P_{s−1}(x_i) − P_{s−2}(x_i)) as its last term: C(s − 1) leaves it free, and a_i1 = b_1 fixes it.
fn integral<T: Real>(family: Family, at_i: &[T], at_j: &[T], x_i: T) -> T {
    let s = at_i.len() - 1;
    let last = if family.ends() == Ends::Both { s - 1 } else { s };
    let mut sum = T::zero();
    for k in (1..last).rev() {
        sum += at_j[k] * (at_i[k + 1] - at_i[k - 1]);
    }
    if family == Family::LobattoIIIC {
        sum += at_j[s - 1] * (at_i[s - 1] - at_i[s - 2]);
    }
    T::half() * (T::one() + x_i + sum)
}

/// b_j = 1/Σ_{k<s} ν_k P_k(x_j)² with ν_k = 2k + 1, but ν_{s−1} = s − 1 at the Lobatto nodes (discrete orthogonality).
fn weights<T: Real>(ends: Ends, rows: &[Vec<T>]) -> Vec<T> {
    let s = rows.len();
    let nu = |k: usize| if ends == Ends::Both && k == s - 1 { T::int(k as i64) } else { T::int(2 * k as i64 + 1) };
    rows.iter().map(|p| T::one() / (0..s).rev().fold(T::zero(), |sum, k| sum + nu(k) * p[k] * p[k])).collect()
}

/// P_0(x) … P_n(x).
fn legendre<T: Real>(n: usize, x: T) -> Vec<T> {
    let mut p = vec![T::one(), x];
    for k in 1..n as i64 {
        let (last, before) = (p[k as usize], p[k as usize - 1]);
        p.push((T::int(2 * k + 1) * x * last - T::int(k) * before) / T::int(k + 1));
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
    let mut x = T::exact(angle.cos());
    let mut previous = T::one();
    for _ in 0..50 {
        let (value, slope) = jacobi(n, alpha, beta, x);
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
pub enum Classic {
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
}

impl Classic {
    /// All of them.
    pub const ALL: [Classic; 5] = [Classic::Heun2, Classic::Ralston3, Classic::Rk4, Classic::Kutta38, Classic::Sdirk2];

    /// `heun2`, `ralston3`, `rk4`, `kutta38`, `sdirk2`.
    pub fn name(self) -> &'static str {
        match self {
            Classic::Heun2 => "heun2",
            Classic::Ralston3 => "ralston3",
            Classic::Rk4 => "rk4",
            Classic::Kutta38 => "kutta38",
            Classic::Sdirk2 => "sdirk2",
        }
    }

    /// The tableau, each entry rounded once (γ of `Sdirk2`: a few roundings).
    ///
    /// # Errors
    /// None in practice: those of [`Tableau::new`].
    pub fn tableau<T: Real>(self) -> Result<Tableau<T>, TableauError> {
        let r = |p: i64, q: i64| T::ratio(p, q);
        let o = T::zero();
        let (a, b) = match self {
            Classic::Heun2 => (vec![vec![o, o], vec![r(1, 1), o]], vec![r(1, 2), r(1, 2)]),
            Classic::Ralston3 => {
                (vec![vec![o, o, o], vec![r(1, 2), o, o], vec![o, r(3, 4), o]], vec![r(2, 9), r(1, 3), r(4, 9)])
            }
            Classic::Rk4 => (
                vec![vec![o, o, o, o], vec![r(1, 2), o, o, o], vec![o, r(1, 2), o, o], vec![o, o, r(1, 1), o]],
                vec![r(1, 6), r(1, 3), r(1, 3), r(1, 6)],
            ),
            Classic::Kutta38 => (
                vec![
                    vec![o, o, o, o],
                    vec![r(1, 3), o, o, o],
                    vec![r(-1, 3), r(1, 1), o, o],
                    vec![r(1, 1), r(-1, 1), r(1, 1), o],
                ],
                vec![r(1, 8), r(3, 8), r(3, 8), r(1, 8)],
            ),
            Classic::Sdirk2 => {
                let root = T::int(3).sqrt();
                let gamma = (T::int(3) + root) / T::int(6);
                (vec![vec![gamma, o], vec![-root / T::int(3), gamma]], vec![r(1, 2), r(1, 2)])
            }
        };
        Tableau::new(&a, &b)
    }
}
