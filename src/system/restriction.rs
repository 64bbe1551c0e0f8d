//! Which systems a user's own method knows, where it does not know all: knobs of [`Cases`](super::Cases) beside those on
//! algebras, bases and quartic terms.

use super::case::{Case, Drag, Force, Inertia, Potential, Structure};
use super::force::Value;
use super::numbers::dyadic;
use crate::algebra::rational::{integer, small};
use crate::algebra::{Entry, Vector};
use crate::scalar::Number;
use dashu_ratio::RBig;
use nalgebra::{Matrix3, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// Which matrices a drag may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DragForm {
    /// Any.
    #[default]
    Any,
    /// Diagonal ones.
    Diagonal,
    /// Multiples of the identity.
    Scalar,
}

impl DragForm {
    /// Whether nothing is restricted.
    pub(crate) fn is_any(&self) -> bool {
        *self == Self::Any
    }

    /// Whether a drag is of this form.
    fn admits(self, drag: &Drag) -> bool {
        self.of(drag.clone()) == *drag
    }

    /// A drag of this form near another: its diagonal, or the first entry of that.
    pub(crate) fn of(self, drag: Drag) -> Drag {
        let Drag::Matrix(mut rows) = drag else { return drag };
        match self {
            Self::Any => {}
            Self::Diagonal => {
                for (r, row) in rows.iter_mut().enumerate() {
                    let off = row.iter_mut().enumerate().filter(|(c, _)| *c != r);
                    off.for_each(|(_, x)| *x = Number::default());
                }
            }
            Self::Scalar => {
                if let Some(x) = rows.first().and_then(|row| row.first()) {
                    return Drag::Coefficient(x.clone());
                }
            }
        }
        Drag::Matrix(rows)
    }
}

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
    /// Only inertias of rigid bodies, on so(3) and se(3) in their standard bases.
    pub physical: bool,
    /// Only drags with such a matrix.
    pub drag: DragForm,
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
            && self.has_drags(case)
            && self.has_potentials(case)
            && self.has_diagonal(case)
            && self.has_body(case)
            && !(self.forward && case.step.eval::<f64>().is_ok_and(|h| h < 0.0))
    }

    /// Whether the forces of a case are.
    pub fn has_forces(&self, case: &Case) -> bool {
        case.forces.iter().map(Force::kind).all(|kind| self.has_force(kind))
    }

    /// Whether the matrices of its drags are.
    pub fn has_drags(&self, case: &Case) -> bool {
        let mut values = case.forces.iter().flat_map(|force| force.parameters().map(|(_, value)| value));
        values.all(|value| match value {
            Value::Drag(drag) => self.drag.admits(&drag),
            _ => true,
        })
    }

    /// Whether potentials of this kind are.
    fn has_potential(&self, potential: &Potential) -> bool {
        self.potentials.as_ref().is_none_or(|kinds| kinds.iter().any(|kind| kind == potential.kind()))
    }

    /// Whether the potentials of a case are.
    pub fn has_potentials(&self, case: &Case) -> bool {
        case.potentials.iter().all(|potential| self.has_potential(potential))
    }

    /// Whether its inertia is diagonal, where it has to be.
    pub fn has_diagonal(&self, case: &Case) -> bool {
        !self.diagonal || matches!(case.lagrangian.inertia, Inertia::Diagonal(_))
    }

    /// Whether its inertia is that of a rigid body, where it has to be.
    pub fn has_body(&self, case: &Case) -> bool {
        let standard = match case.algebra.structure {
            Structure::Named(Entry::So3 | Entry::Se3) => case.algebra.basis.is_none(),
            _ => false,
        };
        !self.physical || (standard && !case.lagrangian.indefinite && is_of_body(&case.lagrangian.inertia))
    }

    /// A case with what can be left out of it left out: other kinds of forces and potentials, what is off the diagonal of the inertia
    /// or of a drag; and with an inertia of a body instead of another.
    pub fn adapted(&self, mut case: Case) -> Case {
        case.forces.retain(|force| self.has_force(force.kind()));
        case.potentials.retain(|potential| self.has_potential(potential));
        for (_, value) in case.forces.iter_mut().flat_map(Force::parameters_mut) {
            if let Value::Drag(drag) = value {
                *drag = self.drag.of(drag.clone());
            }
        }
        if let (true, Inertia::Full(rows)) = (self.diagonal, &case.lagrangian.inertia) {
            // The diagonal of a positive definite matrix is positive.
            let diagonal = rows.iter().enumerate().filter_map(|(a, row)| row.get(a).cloned()).collect();
            case.lagrangian.inertia = Inertia::Diagonal(diagonal);
        }
        if !self.has_body(&case)
            && let Some(inertia) = of_body(&case.lagrangian.inertia)
        {
            (case.lagrangian.inertia, case.lagrangian.indefinite) = (inertia, false);
        }
        case
    }
}

/// Principal values of ∫ x xᵀ dm below this share of the sum of the moments are those of a flat body: rounding decides about it.
const FLAT: f64 = 1e-9;

/// Whether an inertia of dimension 3 is J, or one of dimension 6 is [[J, m ĉ], [−m ĉ, m 1]], where no principal moment of J about the
/// center c of mass is larger than the sum of the others: ∫ x xᵀ dm = tr(J)/2·1 − J is positive definite (Wensing, Kim and Slotine 2018;
/// the matrix: Featherstone 2008, §2.13).
fn is_of_body(inertia: &Inertia) -> bool {
    let n = inertia.dimension();
    let value = |r: usize, c: usize| inertia.entry(r, c).eval::<f64>().unwrap_or(f64::NAN);
    let mut moments = Matrix3::from_fn(value);
    if n == 6 {
        let mass = value(3, 3);
        let center = Vector::<f64, 3>::new(value(2, 4), value(0, 5), value(1, 3)) / mass;
        let hat = center.cross_matrix();
        let near = |x: f64, y: f64| (x - y).abs() <= FLAT * mass;
        let block = |r: usize, c: usize| (value(r, c + 3), value(r + 3, c + 3));
        let is_body = (0..9).map(|k| (k / 3, k % 3)).all(|(r, c)| {
            let (coupling, translation) = block(r, c);
            near(coupling, mass * hat[(r, c)]) && near(translation, if r == c { mass } else { 0.0 })
        });
        if !(mass > 0.0 && is_body) {
            return false;
        }
        moments += hat * hat * mass;
    } else if n != 3 {
        return false;
    }
    // ∫ x xᵀ dm, which is positive definite.
    let second = Matrix3::identity() * (moments.trace() / 2.0) - moments;
    SymmetricEigen::new(second).eigenvalues.iter().all(|x| *x > FLAT * moments.trace())
}

/// The inertia of a body that a positive definite matrix M makes, diagonal if M is: J = tr(S)·1 − S about the center, with S the first
/// three rows and columns of M as ∫ x xᵀ dm, and on se(3) the mass M_44 and a center of entries of M.
pub(super) fn of_body(inertia: &Inertia) -> Option<Inertia> {
    let n = inertia.dimension();
    let number = |x: RBig| small(&x).map(|(p, q)| dyadic(p, q));
    let of = |r: usize, c: usize| inertia.entry(r, c).rational();
    let trace = of(0, 0)? + of(1, 1)? + of(2, 2)?;
    let moment = |r: usize, c: usize| Some(if r == c { trace.clone() - of(r, c)? } else { -of(r, c)? });
    if let Inertia::Diagonal(_) = inertia {
        let entry = |a: usize| number(if a < 3 { moment(a, a)? } else { of(3, 3)? });
        return (0..n).map(entry).collect::<Option<_>>().map(Inertia::Diagonal);
    }
    let (mass, center) = match n {
        6 => (of(3, 3)?, [of(2, 4)?, of(0, 5)?, of(1, 3)?]),
        _ => (RBig::ZERO, [RBig::ZERO; 3]),
    };
    let square: RBig = center.iter().map(|x| x * x).fold(RBig::ZERO, |sum, x| sum + x);
    let hat = |r: usize, c: usize| match (3 + c - r) % 3 {
        0 => RBig::ZERO,
        1 => -center[3 - r - c].clone(),
        _ => center[3 - r - c].clone(),
    };
    let entry = |r: usize, c: usize| {
        let unit = integer(i64::from(r % 3 == c % 3));
        Some(match (r < 3, c < 3) {
            (true, true) => moment(r, c)? + mass.clone() * (square.clone() * unit - &center[r] * &center[c]),
            (true, false) => mass.clone() * hat(r, c - 3),
            (false, true) => -mass.clone() * hat(r - 3, c),
            (false, false) => mass.clone() * unit,
        })
    };
    let row = |r: usize| (0..n).map(|c| number(entry(r, c)?)).collect::<Option<Vec<_>>>();
    (0..n).map(row).collect::<Option<_>>().map(Inertia::Full)
}
