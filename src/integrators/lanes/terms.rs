//! The forces of the catalogue in lanes, as lists of terms.

use super::Row;
use super::force::{Coefficient, Damping, EnsembleForce, LaneAttitude, LaneForce, Relaxation};
use super::vectors::{add_cross, first, join, last, scale};
use crate::algebra::{Covector, LieAlgebra, Matrix};
use crate::integrators::lanes::Lanes;
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::{AnyLagrangian, Quadratic};

/// A symmetric drag matrix D.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "`Copy`, because it is data of a kernel")]
pub enum Drag<const N: usize = 3, C = f64> {
    /// Its diagonal; the rest is zero.
    Diagonal([C; N]),
    /// Its rows.
    Full([[C; N]; N]),
}

impl<const N: usize> Drag<N> {
    fn new(matrix: &Matrix<f64, N>) -> Self {
        let diagonal = (0..N).all(|r| (0..N).all(|c| r == c || matrix[(r, c)] == 0.0));
        if diagonal {
            Self::Diagonal(std::array::from_fn(|a| matrix[(a, a)]))
        } else {
            Self::Full(std::array::from_fn(|r| std::array::from_fn(|c| matrix[(r, c)])))
        }
    }

    fn rows(&self) -> [[f64; N]; N] {
        match self {
            Self::Diagonal(diagonal) => {
                std::array::from_fn(|r| std::array::from_fn(|c| if r == c { diagonal[r] } else { 0.0 }))
            }
            Self::Full(rows) => *rows,
        }
    }
}

impl<const N: usize, C: Coefficient> Drag<N, C> {
    /// D x.
    #[inline(always)]
    fn apply<V: Lanes>(&self, x: [V; N]) -> [V; N] {
        match self {
            Self::Diagonal(diagonal) => each!(N, a => diagonal[a].lanes(x[0]) * x[a]),
            Self::Full(rows) => each!(N, r => {
                let mut sum = rows[r][0].lanes(x[0]) * x[0];
                for c in 1..N {
                    sum = rows[r][c].lanes(x[0]).mul_add(x[c], sum);
                }
                sum
            }),
        }
    }
}

/// A term of a force of the catalogue, with coefficients `C`. Weights and fields are those of SO(3) and SE(3): on other groups they have no
/// value, and a step with them is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "`Copy`, because it is data of a kernel")]
#[non_exhaustive]
pub enum Term<const N: usize = 3, C = f64> {
    /// [`Damping`].
    Damping(C),
    /// [`Relaxation`].
    Relaxation(C),
    /// −D η.
    LinearDrag(Drag<N, C>),
    /// −√(ηᵀ D η) D η.
    QuadraticDrag(Drag<N, C>),
    /// A given load.
    Constant([C; N]),
    /// A load times cos(ω t + φ): load, ω, φ.
    Periodic([C; N], C, C),
    /// (−w r × Γ, −w Γ), Γ = Rᵀe₃: the weight w at the point r of the body, V = w ⟨e₃, R r + x⟩. A lift has the other sign. On SO(3)
    /// the body turns about a fixed point: −w r × Γ.
    Gravity(C, [C; 3]),
    /// (m × RᵀB, 0): a moment m of the body in a uniform field B of space, V = −⟨R m, B⟩.
    UniformField([C; 3], [C; 3]),
}

impl<const N: usize, const D: usize, C: Coefficient> LaneForce<N, D> for Term<N, C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        match self {
            Self::Damping(alpha) => Damping(*alpha).add_to(t, g, m, eta, sum),
            Self::Relaxation(beta) => Relaxation(*beta).add_to(t, g, m, eta, sum),
            Self::LinearDrag(matrix) => {
                let drag = matrix.apply(eta);
                each!(N, a => sum[a] - drag[a])
            }
            Self::QuadraticDrag(matrix) => {
                let drag = matrix.apply(eta);
                let mut square = drag[0] * eta[0];
                for a in 1..N {
                    square = drag[a].mul_add(eta[a], square);
                }
                let size = square.max(t.constant(0.0)).sqrt();
                each!(N, a => size.neg_mul_add(drag[a], sum[a]))
            }
            Self::Constant(load) => each!(N, a => sum[a] + load[a].lanes(t)),
            Self::Periodic(load, frequency, phase) => {
                let factor = frequency.lanes(t).mul_add(t, phase.lanes(t)).cos();
                each!(N, a => load[a].lanes(t).mul_add(factor, sum[a]))
            }
            Self::Gravity(..) | Self::UniformField(..) if const { !matches!((N, D), (3, 3) | (6, 4)) } => {
                [t.constant(f64::NAN); N]
            }
            Self::Gravity(weight, center) => {
                let pull = scale(weight.lanes(t), first(g.row(2)));
                let turned = add_cross(first(sum), pull, each!(3, a => center[a].lanes(t)));
                let moved = last(sum);
                join(turned, each!(3, a => moved[a] - pull[a]))
            }
            Self::UniformField(moment, field) => {
                let field = g.in_body(each!(3, a => field[a].lanes(t)));
                join(add_cross(first(sum), each!(3, a => moment[a].lanes(t)), field), last(sum))
            }
        }
    }

    fn uses_attitude(&self) -> bool {
        matches!(self, Self::Gravity(..) | Self::UniformField(..))
    }

    fn vanishes_when_steady(&self) -> bool {
        matches!(self, Self::Damping(_) | Self::Relaxation(_))
    }
}

/// A force of the catalogue as a list of terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms<const N: usize = 3, C = f64>(pub Vec<Term<N, C>>);

impl<const N: usize, const D: usize, C: Coefficient> LaneForce<N, D> for Terms<N, C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(
        &self,
        t: V,
        g: G,
        m: [V; N],
        eta: [V; N],
        mut sum: [V; N],
    ) -> [V; N] {
        for term in &self.0 {
            sum = term.add_to(t, g, m, eta, sum);
        }
        sum
    }

    fn uses_attitude(&self) -> bool {
        self.0.iter().any(LaneForce::<N, D>::uses_attitude)
    }

    fn vanishes(&self) -> bool {
        self.0.is_empty()
    }

    fn vanishes_when_steady(&self) -> bool {
        self.0.iter().all(LaneForce::<N, D>::vanishes_when_steady)
    }
}

/// Why a force has no form in lanes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LaneForceError {
    /// The force was built on structure constants other than those of the group.
    #[error("the {force} force belongs to an algebra other than that of the group")]
    OtherAlgebra {
        /// Which force.
        force: &'static str,
    },
    /// A force that the kernels do not have.
    #[error("the {force} force has no form in lanes")]
    NoForm {
        /// Which force.
        force: &'static str,
    },
    /// The force was built with a Lagrangian other than that of the body.
    #[error("the {force} force was built with another Lagrangian than the body's")]
    OtherLagrangian {
        /// Which force.
        force: &'static str,
    },
}

impl<const N: usize> Terms<N> {
    /// The terms of a force of the catalogue that acts on a body of inertia `lagrangian` on a group of this algebra.
    ///
    /// # Errors
    /// A force that has no form in lanes, or depends on the momentum and was built on another algebra or another Lagrangian.
    pub fn new(
        force: &AnyForce<f64, N>,
        lagrangian: &Quadratic<f64, N>,
        algebra: &LieAlgebra<f64, N>,
    ) -> Result<Self, LaneForceError> {
        let mut terms = Vec::new();
        collect(force, (lagrangian, algebra), &mut terms)?;
        Ok(Self(terms))
    }
}

fn collect<const N: usize>(
    force: &AnyForce<f64, N>,
    (lagrangian, algebra): (&Quadratic<f64, N>, &LieAlgebra<f64, N>),
    terms: &mut Vec<Term<N>>,
) -> Result<(), LaneForceError> {
    use crate::mechanics::Force;
    let name = force.name();
    let same = |own: &LieAlgebra<f64, N>, other: &AnyLagrangian<f64, N>| {
        if own != algebra {
            return Err(LaneForceError::OtherAlgebra { force: name });
        }
        match other.kinetic() {
            AnyLagrangian::Quadratic(other) if other == lagrangian => Ok(()),
            _ => Err(LaneForceError::OtherLagrangian { force: name }),
        }
    };
    if force.is_zero() {
        return Ok(());
    }
    let load = |m: &Covector<f64, N>| std::array::from_fn(|c| m[c]);
    terms.push(match force {
        AnyForce::Sum(sum) => return sum.iter().try_for_each(|term| collect(term, (lagrangian, algebra), terms)),
        AnyForce::DoubleBracket(f) => {
            same(&f.algebra, &f.lagrangian)?;
            Term::Damping(f.alpha)
        }
        AnyForce::Metriplectic(f) => {
            same(&f.algebra, &f.lagrangian)?;
            Term::Relaxation(f.beta)
        }
        AnyForce::LinearDrag(f) => Term::LinearDrag(Drag::new(&f.matrix)),
        AnyForce::QuadraticDrag(f) => Term::QuadraticDrag(Drag::new(&f.matrix)),
        AnyForce::Constant(f) => Term::Constant(load(&f.covector)),
        AnyForce::Periodic(f) => Term::Periodic(load(&f.covector), f.frequency, f.phase),
        // A force that vanishes has been seen to.
        _ => return Err(LaneForceError::NoForm { force: name }),
    });
    Ok(())
}

impl Term {
    /// The term with other coefficients, asked for in a fixed order, and a drag as a full matrix.
    fn map<E>(&self, mut of: impl FnMut(f64) -> E) -> Term<3, E> {
        match self {
            Self::Damping(alpha) => Term::Damping(of(*alpha)),
            Self::Relaxation(beta) => Term::Relaxation(of(*beta)),
            Self::LinearDrag(matrix) => Term::LinearDrag(Drag::Full(matrix.rows().map(|row| row.map(&mut of)))),
            Self::QuadraticDrag(matrix) => Term::QuadraticDrag(Drag::Full(matrix.rows().map(|row| row.map(&mut of)))),
            Self::Constant(load) => Term::Constant(load.map(of)),
            Self::Periodic(load, frequency, phase) => Term::Periodic(load.map(&mut of), of(*frequency), of(*phase)),
            Self::Gravity(weight, center) => Term::Gravity(of(*weight), center.map(of)),
            Self::UniformField(moment, field) => Term::UniformField(moment.map(&mut of), field.map(of)),
        }
    }
}

impl EnsembleForce for Terms {
    type Packed = Terms<3, Row>;

    /// A term for each kind that one of the bodies has, as often as it has it; with zeros for bodies that lack it.
    fn pack(forces: [&Self; 8]) -> Terms<3, Row> {
        let mut packed = Vec::new();
        let mut taken = [const { Vec::<usize>::new() }; 8];
        while let Some(example) = (0..8).find_map(|lane| {
            forces[lane].0.iter().enumerate().find(|(k, _)| !taken[lane].contains(k)).map(|(_, term)| *term)
        }) {
            let same = |term: &Term| std::mem::discriminant(term) == std::mem::discriminant(&example);
            let lanes: [Vec<f64>; 8] = std::array::from_fn(|lane| {
                let found = forces[lane].0.iter().enumerate().find(|(k, term)| !taken[lane].contains(k) && same(term));
                let mut coefficients = Vec::new();
                if let Some((k, term)) = found {
                    taken[lane].push(k);
                    term.map(|coefficient| coefficients.push(coefficient));
                }
                coefficients
            });
            let mut k = 0..;
            packed.push(example.map(|_| {
                let k = k.next().unwrap_or(0);
                Row(std::array::from_fn(|lane| lanes[lane].get(k).copied().unwrap_or(0.0)))
            }));
        }
        Terms(packed)
    }
}
