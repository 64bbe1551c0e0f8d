//! Coefficients of the case that may differ from member to member.

use crate::scalar::Number;
use crate::system::case::{Case, Drag, Inertia};
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
    /// Those of a case, with their numbers: a diagonal inertia's entries, and the coefficients of the terms of the force that have a number
    /// each.
    fn all(case: &mut Case) -> Vec<(Self, &mut Number)> {
        let mut found = Vec::new();
        if let Inertia::Diagonal(entries) = &mut case.lagrangian.inertia {
            found.extend(entries.iter_mut().enumerate().map(|(a, x)| (Self::Inertia(a), x)));
        }
        for (k, force) in case.forces.iter_mut().enumerate() {
            found.extend(force.parameters_mut().filter_map(|(parameter, value)| match value {
                Value::Number(x) => Some((Self::Force(k, parameter.name), x)),
                Value::Drag(Drag::Coefficient(x)) => Some((Self::Force(k, COEFFICIENT), x)),
                _ => None,
            }));
        }
        found
    }

    /// Those of a case.
    pub fn of(case: &Case) -> Vec<Self> {
        Self::all(&mut case.clone()).into_iter().map(|(parameter, _)| parameter).collect()
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
        if let Some((_, place)) = Self::all(case).into_iter().find(|(parameter, _)| parameter == self) {
            *place = value.clone();
        }
    }
}
