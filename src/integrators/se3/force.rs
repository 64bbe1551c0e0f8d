//! Forces on SE(3) in lanes: what [`super::VariationalSe3`] evaluates for eight stages at once.

use super::Vec6;
use crate::algebra::{Covector, Matrix};
use crate::integrators::lanes::Lanes;
use crate::integrators::so3::each;
use crate::integrators::so3::force::Pose;
use crate::integrators::so3::retraction::{add_cross, scale};
use crate::integrators::so3::{LaneAttitude, LaneForce};
use crate::mechanics::force::AnyForce;

/// A symmetric drag matrix D.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "`Copy`, because it is data of a kernel")]
pub enum Drag {
    /// Its diagonal; the rest is zero.
    Diagonal([f64; 6]),
    /// Its rows.
    Full([[f64; 6]; 6]),
}

impl Drag {
    fn new(matrix: &Matrix<f64, 6>) -> Self {
        let diagonal = (0..6).all(|r| (0..6).all(|c| r == c || matrix[(r, c)] == 0.0));
        if diagonal {
            Self::Diagonal(std::array::from_fn(|a| matrix[(a, a)]))
        } else {
            Self::Full(std::array::from_fn(|r| std::array::from_fn(|c| matrix[(r, c)])))
        }
    }

    /// D x.
    #[inline(always)]
    fn apply<V: Lanes>(&self, x: Vec6<V>) -> Vec6<V> {
        match self {
            Self::Diagonal(diagonal) => each!(6, a => x[a].constant(diagonal[a]) * x[a]),
            Self::Full(rows) => each!(6, r => {
                let mut sum = x[0].constant(rows[r][0]) * x[0];
                for c in 1..6 {
                    sum = x[0].constant(rows[r][c]).mul_add(x[c], sum);
                }
                sum
            }),
        }
    }
}

/// A term of a force of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "`Copy`, because it is data of a kernel")]
#[non_exhaustive]
pub enum Term {
    /// −D η.
    LinearDrag(Drag),
    /// −√(ηᵀ D η) D η.
    QuadraticDrag(Drag),
    /// A given load.
    Constant([f64; 6]),
    /// A load times cos(ω t + φ): load, ω, φ.
    Periodic([f64; 6], f64, f64),
    /// (−w r × Γ, −w Γ), Γ = Rᵀe₃: the weight w at the point r of the body, V = w ⟨e₃, R r + x⟩. A lift has the other sign.
    Gravity(f64, [f64; 3]),
    /// (m × RᵀB, 0): a moment m of the body in a uniform field B of space, V = −⟨R m, B⟩.
    UniformField([f64; 3], [f64; 3]),
}

#[inline(always)]
fn dot<V: Lanes>(x: Vec6<V>, y: Vec6<V>) -> V {
    let low = x[2].mul_add(y[2], x[1].mul_add(y[1], x[0] * y[0]));
    let high = x[5].mul_add(y[5], x[4].mul_add(y[4], x[3] * y[3]));
    low + high
}

impl LaneForce<6> for Term {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: Vec6<V>, eta: Vec6<V>, sum: Vec6<V>) -> Vec6<V> {
        self.add_at(t, Pose::identity(t), m, eta, sum)
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, _m: Vec6<V>, eta: Vec6<V>, sum: Vec6<V>) -> Vec6<V> {
        let turning = [sum[0], sum[1], sum[2]];
        match self {
            Self::LinearDrag(matrix) => {
                let drag = matrix.apply(eta);
                each!(6, a => sum[a] - drag[a])
            }
            Self::QuadraticDrag(matrix) => {
                let drag = matrix.apply(eta);
                let size = dot(drag, eta).max(t.constant(0.0)).sqrt();
                each!(6, a => size.neg_mul_add(drag[a], sum[a]))
            }
            Self::Constant(load) => each!(6, a => sum[a] + t.constant(load[a])),
            Self::Periodic(load, frequency, phase) => {
                let factor = t.constant(*frequency).mul_add(t, t.constant(*phase)).cos();
                each!(6, a => t.constant(load[a]).mul_add(factor, sum[a]))
            }
            Self::Gravity(weight, center) => {
                let pull = scale(t.constant(*weight), g.row(2));
                let turned = add_cross(turning, pull, each!(3, a => t.constant(center[a])));
                each!(6, a => if a < 3 { turned[a] } else { sum[a] - pull[a - 3] })
            }
            Self::UniformField(moment, field) => {
                let field = g.in_body(each!(3, a => t.constant(field[a])));
                let turned = add_cross(turning, each!(3, a => t.constant(moment[a])), field);
                each!(6, a => if a < 3 { turned[a] } else { sum[a] })
            }
        }
    }

    fn uses_attitude(&self) -> bool {
        matches!(self, Self::Gravity(..) | Self::UniformField(..))
    }
}

/// A force of the catalogue as a list of terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms(pub Vec<Term>);

impl LaneForce<6> for Terms {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: Vec6<V>, eta: Vec6<V>, sum: Vec6<V>) -> Vec6<V> {
        self.add_at(t, Pose::identity(t), m, eta, sum)
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: Vec6<V>, eta: Vec6<V>, mut sum: Vec6<V>) -> Vec6<V> {
        for term in &self.0 {
            sum = term.add_at(t, g, m, eta, sum);
        }
        sum
    }

    fn uses_attitude(&self) -> bool {
        self.0.iter().any(LaneForce::uses_attitude)
    }

    fn vanishes(&self) -> bool {
        self.0.is_empty()
    }
}

/// A force of the catalogue that has no form in lanes on SE(3).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {force} force has no form in lanes on SE(3): there are drag, constant and periodic loads")]
#[non_exhaustive]
pub struct LaneForceError {
    /// Which force.
    pub force: &'static str,
}

impl Terms {
    /// The terms of a force of the catalogue.
    ///
    /// # Errors
    /// A force that has no form in lanes here: a double bracket or a metriplectic force.
    pub fn new(force: &AnyForce<f64, 6>) -> Result<Self, LaneForceError> {
        let mut terms = Vec::new();
        collect(force, &mut terms)?;
        Ok(Self(terms))
    }
}

fn collect(force: &AnyForce<f64, 6>, terms: &mut Vec<Term>) -> Result<(), LaneForceError> {
    use crate::mechanics::Force;
    if force.is_zero() {
        return Ok(());
    }
    let load = |m: &Covector<f64, 6>| std::array::from_fn(|c| m[c]);
    terms.push(match force {
        AnyForce::Sum(sum) => return sum.iter().try_for_each(|term| collect(term, terms)),
        AnyForce::LinearDrag(f) => Term::LinearDrag(Drag::new(f.matrix())),
        AnyForce::QuadraticDrag(f) => Term::QuadraticDrag(Drag::new(f.matrix())),
        AnyForce::Constant(f) => Term::Constant(load(f.covector())),
        AnyForce::Periodic(f) => Term::Periodic(load(f.covector()), f.frequency(), f.phase()),
        other => return Err(LaneForceError { force: other.name() }),
    });
    Ok(())
}
