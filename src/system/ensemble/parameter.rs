//! Coefficients of the case that may differ from member to member.

use crate::scalar::Number;
use crate::system::case::{Case, Drag, Force, Inertia};
use crate::system::force::{COEFFICIENT, Value};

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
            parameters.extend(force.parameters().filter_map(|(parameter, value)| match value {
                Value::Number(_) => Some(Self::Force(k, parameter.name)),
                Value::Drag(Drag::Coefficient(_)) => Some(Self::Force(k, COEFFICIENT)),
                Value::Drag(Drag::Matrix(_)) | Value::Covector(_) | Value::Polynomial(_) | Value::Formula(_) => None,
            }));
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
            Self::Force(k, key) => {
                let parameters = case.forces.get_mut(k).into_iter().flat_map(Force::parameters_mut);
                parameters.into_iter().find_map(|(parameter, value)| match value {
                    Value::Number(x) if parameter.name == key => Some(x),
                    Value::Drag(Drag::Coefficient(x)) if key == COEFFICIENT => Some(x),
                    _ => None,
                })
            }
        };
        if let Some(place) = place {
            *place = value.clone();
        }
    }
}
