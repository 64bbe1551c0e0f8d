//! Coefficients of the case that may differ from member to member.

use crate::scalar::Number;
use crate::system::case::{Case, Drag, Force, Inertia};

/// A number in a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parameter {
    /// An entry of a diagonal inertia, from 0.
    Inertia(usize),
    /// A coefficient of a term of the force: which term, from 0, and which coefficient.
    Force(usize, &'static str),
}

impl Parameter {
    /// Those of a case: a diagonal inertia's entries, and the coefficients of the terms of the force that have a number each.
    pub fn of(case: &Case) -> Vec<Self> {
        let mut parameters = Vec::new();
        if let Inertia::Diagonal(entries) = &case.lagrangian.inertia {
            parameters.extend((0..entries.len()).map(Self::Inertia));
        }
        for (k, force) in case.forces.iter().enumerate() {
            let keys: &[&str] = match force {
                Force::DoubleBracket { .. } => &["alpha"],
                Force::Metriplectic { .. } => &["beta"],
                Force::LinearDrag(Drag::Coefficient(_)) | Force::QuadraticDrag(Drag::Coefficient(_)) => {
                    &["coefficient"]
                }
                Force::Periodic { .. } => &["frequency", "phase"],
                Force::LinearDrag(Drag::Matrix(_))
                | Force::QuadraticDrag(Drag::Matrix(_))
                | Force::Constant { .. }
                | Force::Given => &[],
            };
            parameters.extend(keys.iter().map(|key| Self::Force(k, key)));
        }
        parameters
    }

    /// Its name: `inertia_2`, `force_1_alpha`; indices from 1.
    pub fn name(&self) -> String {
        match self {
            Self::Inertia(a) => format!("inertia_{}", a + 1),
            Self::Force(k, key) => format!("force_{}_{key}", k + 1),
        }
    }

    /// Puts `value` in its place; nothing where the case has no such number.
    pub fn set(&self, case: &mut Case, value: &Number) {
        let place = match *self {
            Self::Inertia(a) => match &mut case.lagrangian.inertia {
                Inertia::Diagonal(entries) => entries.get_mut(a),
                Inertia::Full(_) => None,
            },
            Self::Force(k, key) => match (case.forces.get_mut(k), key) {
                (Some(Force::DoubleBracket { alpha }), "alpha") => Some(alpha),
                (Some(Force::Metriplectic { beta }), "beta") => Some(beta),
                (
                    Some(Force::LinearDrag(Drag::Coefficient(k)) | Force::QuadraticDrag(Drag::Coefficient(k))),
                    "coefficient",
                ) => Some(k),
                (Some(Force::Periodic { frequency, .. }), "frequency") => Some(frequency),
                (Some(Force::Periodic { phase, .. }), "phase") => Some(phase),
                _ => None,
            },
        };
        if let Some(place) = place {
            *place = value.clone();
        }
    }
}
