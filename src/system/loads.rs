//! The potentials of a body as terms of forces in lanes.

use super::case::{Case, Potential};
use crate::integrators::{se3, so3};
use crate::scalar::Number;

/// What a potential of a body is in lanes.
enum Load {
    /// A weight at a point of the body.
    Weight(f64, [f64; 3]),
    /// A moment of the body in a field of space.
    Field([f64; 3], [f64; 3]),
}

fn three(values: &[Number]) -> Option<[f64; 3]> {
    let mut found = [0.0; 3];
    for (place, value) in found.iter_mut().zip(values) {
        *place = value.eval().ok()?;
    }
    (values.len() == 3).then_some(found)
}

impl Load {
    fn of(potential: &Potential) -> Option<Self> {
        Some(match potential {
            Potential::Gravity { weight, center } => Self::Weight(weight.eval().ok()?, three(center)?),
            Potential::Buoyancy { lift, center } => Self::Weight(-lift.eval::<f64>().ok()?, three(center)?),
            Potential::UniformField { moment, field } => Self::Field(three(moment)?, three(field)?),
            _ => return None,
        })
    }
}

impl Case {
    /// The potentials as terms in lanes on SO(3); `None` where one of them has no such form.
    pub(crate) fn loads_on_so3(&self) -> Option<Vec<so3::Term>> {
        let term = |potential: &Potential| {
            Some(match Load::of(potential)? {
                Load::Weight(weight, center) => so3::Term::Gravity(center.map(|r| weight * r)),
                Load::Field(moment, field) => so3::Term::UniformField(moment, field),
            })
        };
        self.potentials.iter().map(term).collect()
    }

    /// The same on SE(3).
    pub(crate) fn loads_on_se3(&self) -> Option<Vec<se3::Term>> {
        let term = |potential: &Potential| {
            Some(match Load::of(potential)? {
                Load::Weight(weight, center) => se3::Term::Gravity(weight, center),
                Load::Field(moment, field) => se3::Term::UniformField(moment, field),
            })
        };
        self.potentials.iter().map(term).collect()
    }
}
