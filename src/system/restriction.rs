//! Which systems a method of somebody's own knows, where it does not know all: knobs of [`Cases`](super::Cases) beside those on
//! algebras, bases and quartic terms.

use super::case::{Case, Force, Inertia, Potential};

/// What is left out; nothing by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Restriction {
    /// Only algebras of these dimensions.
    pub dimensions: Option<Vec<usize>>,
    /// Only groups of matrices of this size.
    pub matrices: Option<usize>,
    /// Only forces of these kinds, by their names in files.
    pub forces: Option<Vec<String>>,
    /// Only potentials of these kinds, by their names in files.
    pub potentials: Option<Vec<String>>,
    /// Only diagonal inertias.
    pub diagonal: bool,
    /// Only positive steps.
    pub forward: bool,
}

impl Restriction {
    /// Whether forces of this kind are among the systems.
    pub fn has_force(&self, kind: &str) -> bool {
        self.forces.as_ref().is_none_or(|kinds| kinds.iter().any(|name| name == kind))
    }

    /// Whether algebras of this dimension are.
    pub fn has_dimension(&self, n: usize) -> bool {
        self.dimensions.as_ref().is_none_or(|dimensions| dimensions.contains(&n))
    }

    /// Whether matrices of this size are.
    pub fn has_matrices(&self, size: usize) -> bool {
        self.matrices.is_none_or(|wanted| wanted == size)
    }

    /// Whether a case is.
    pub fn admits(&self, case: &Case) -> bool {
        self.has_dimension(case.dimension())
            && self.has_matrices(case.matrix_size())
            && self.has_forces(case)
            && self.has_potentials(case)
            && self.has_inertia(case)
            && !(self.forward && case.step.eval::<f64>().is_ok_and(|h| h < 0.0))
    }

    /// Whether the forces of a case are.
    pub fn has_forces(&self, case: &Case) -> bool {
        case.forces.iter().map(Force::kind).all(|kind| self.has_force(kind))
    }

    /// Whether potentials of this kind are.
    fn has_potential(&self, potential: &Potential) -> bool {
        self.potentials.as_ref().is_none_or(|kinds| kinds.iter().any(|kind| kind == potential.kind()))
    }

    /// Whether the potentials of a case are.
    pub fn has_potentials(&self, case: &Case) -> bool {
        case.potentials.iter().all(|potential| self.has_potential(potential))
    }

    /// Whether its inertia is.
    pub fn has_inertia(&self, case: &Case) -> bool {
        !self.diagonal || matches!(case.lagrangian.inertia, Inertia::Diagonal(_))
    }

    /// A case with what can be left out of it left out: other kinds of forces and potentials, and what is off the diagonal of the inertia.
    pub fn adapted(&self, mut case: Case) -> Case {
        case.forces.retain(|force| self.has_force(force.kind()));
        case.potentials.retain(|potential| self.has_potential(potential));
        if let (true, Inertia::Full(rows)) = (self.diagonal, &case.lagrangian.inertia) {
            // The diagonal of a positive definite matrix is positive.
            let diagonal = rows.iter().enumerate().filter_map(|(a, row)| row.get(a).cloned()).collect();
            case.lagrangian.inertia = Inertia::Diagonal(diagonal);
        }
        case
    }
}
