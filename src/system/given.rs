//! Systems whose group, retraction, Lagrangian or force has a type that is not known here, in the classes of `dispatch`.
//!
//! What a user has written is handed over as numbers and pointers ([`Supplied`]), beside spectators. So the laws are compiled once, in
//! this crate, and not again for the types of each user.

use super::case::{Case, Force as ForceTerm, Tau};
use super::dispatch::{self, System, Wrap};
use super::error::{CaseError, CaseProblem, Place};
use crate::algebra::{Casimir, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::group::{LieGroup, MatrixGroup};
use crate::mechanics::force::AnyForce;
use crate::mechanics::given::{GivenForce, GivenLagrangian, UntypedForce, UntypedLagrangian};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::retraction::AnyRetraction;
use crate::retraction::beside::{BesideRetraction, Core, UntypedRetraction};
use crate::scalar::Real;

/// The parts of a system that a user has written, over T.
#[derive(Default)]
pub(crate) struct Supplied<T: Real> {
    /// n.
    pub dimension: usize,
    /// The size of the matrices.
    pub size: usize,
    /// ê_a, by columns.
    pub basis: Vec<Vec<T>>,
    /// C.
    pub casimirs: Vec<Tensor<T>>,
    /// τ; exp of the group if there is none.
    pub retraction: Option<UntypedRetraction<T>>,
    /// l; the one of the case if there is none.
    pub lagrangian: Option<UntypedLagrangian<T>>,
    /// f, for cases that say so.
    pub force: Option<UntypedForce<T>>,
}

/// The degree of a Casimir and the components of its z, Q or Q_a, by columns.
pub(crate) type Tensor<T> = (usize, Vec<T>);

/// A Casimir without its dimension.
pub(crate) fn tensor<T: Real, const N: usize>(casimir: &Casimir<T, N>) -> Tensor<T> {
    match casimir {
        Casimir::Linear(z) => (1, z.as_slice().to_vec()),
        Casimir::Quadratic(q) => (2, q.as_slice().to_vec()),
        Casimir::Cubic(q) => (3, q.iter().flat_map(|q| q.iter().copied()).collect()),
    }
}

/// The Casimir of the first n of N coordinates.
fn leading<T: Real, const N: usize>((degree, components): &Tensor<T>, n: usize) -> Casimir<T, N> {
    let component = |k: usize, inside: bool| if inside { components[k] } else { T::zero() };
    let square = |c: usize| Matrix::from_fn(|a, b| component((c * n + b) * n + a, a.max(b).max(c) < n));
    match degree {
        1 => Casimir::Linear(Vector::from_fn(|a, _| component(a, a < n))),
        2 => Casimir::Quadratic(square(0)),
        _ => Casimir::Cubic(Box::new(std::array::from_fn(square))),
    }
}

impl Case {
    /// The system of a user's parts beside spectators, with the retraction wrapped.
    ///
    /// # Errors
    /// A [`CaseError`] that says which part cannot be built; a dimension that is too large.
    pub(crate) fn with_given<T: Real, const N: usize, const D: usize>(
        &self,
        supplied: &Supplied<T>,
        wrap: &impl Wrap,
        knows_configuration: bool,
    ) -> Result<System<T, N, D>, CaseError> {
        let (n, size) = (supplied.dimension, supplied.size);
        let beside = Beside::new(n, size, N).filter(|beside| beside.rows() <= D).ok_or_else(|| {
            let found = format!("of dimension {n}, in {size}×{size} matrices");
            let allowed = format!("dimension 1 to {N}, in matrices of at most {D}×{D} with those of spectators");
            Place::root().key("algebra").range(found, allowed)
        })?;
        let matrix = |a: usize| -> Matrix<T, D> {
            Matrix::from_fn(|r, c| if r.max(c) < size { supplied.basis[a][c * size + r] } else { T::zero() })
        };
        let refused = |e| Place::root().key("algebra").error(CaseProblem::Algebra(e));
        let group = MatrixGroup::<T, N, D>::new(beside.basis(matrix)).map_err(refused)?;
        let algebra = group.algebra().clone();
        let retraction = match supplied.retraction.clone().map(Core::Given) {
            Some(given) => {
                BesideRetraction::new(given, algebra.clone(), beside).map(AnyRetraction::Beside).ok_or_else(|| {
                    let why = "its matrices and those of spectators do not fit";
                    Place::root().key("method").inapplicable("the retraction", why)
                })?
            }
            None => dispatch::plain(&algebra, &Some(group.clone()), Tau::Exponential)
                .map_err(|problem| Place::root().key("method").key("retraction").error(problem))?,
        };
        let casimirs = supplied.casimirs.iter().map(|casimir| leading(casimir, n)).collect();
        let lagrangian = |drawn| match &supplied.lagrangian {
            Some(given) => AnyLagrangian::Given(GivenLagrangian::new(given.clone(), n, size)),
            None => drawn,
        };
        let force = |drawn| match &supplied.force {
            Some(given) if self.forces.contains(&ForceTerm::Given) => {
                AnyForce::Given(GivenForce::new(given.clone(), n, size))
            }
            _ => drawn,
        };
        self.complete(
            (algebra, Some(group), casimirs, size),
            wrap.wrap(retraction),
            &|(l, f)| (lagrangian(l), force(f)),
            knows_configuration,
        )
    }
}
