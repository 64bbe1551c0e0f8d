//! Coefficients of the case that may differ from member to member.

use crate::scalar::Number;
use crate::system::case::{Case, Drag, Inertia};
use crate::system::force::{COEFFICIENT, Value};

/// A number in a case, by its name: `inertia_2`, `force_1_alpha`; indices from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter(String);

impl Parameter {
    /// Those of a case, with their numbers: a diagonal inertia's entries, and the coefficients of the terms of the force that have a number
    /// each.
    fn all(case: &mut Case) -> Vec<(Self, &mut Number)> {
        let mut found = Vec::new();
        if let Inertia::Diagonal(entries) = &mut case.lagrangian.inertia {
            found.extend(entries.iter_mut().zip(1..).map(|(x, a)| (Self(format!("inertia_{a}")), x)));
        }
        for (force, k) in case.forces.iter_mut().zip(1..) {
            found.extend(force.parameters_mut().filter_map(|(parameter, value)| match value {
                Value::Number(x) => Some((Self(format!("force_{k}_{}", parameter.name)), x)),
                Value::Drag(Drag::Coefficient(x)) => Some((Self(format!("force_{k}_{COEFFICIENT}")), x)),
                _ => None,
            }));
        }
        found
    }

    /// Those of a case.
    pub fn of(case: &Case) -> Vec<Self> {
        Self::all(&mut case.clone()).into_iter().map(|(parameter, _)| parameter).collect()
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.0
    }

    /// Puts `value` in its place; nothing where the case has no such number.
    pub fn set(&self, case: &mut Case, value: &Number) {
        if let Some((_, place)) = Self::all(case).into_iter().find(|(parameter, _)| parameter == self) {
            *place = value.clone();
        }
    }
}
