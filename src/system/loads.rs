//! The potentials of a body as terms of forces in lanes.

use super::case::{Case, Potential};
use crate::integrators::so3::Term;
use crate::scalar::Number;

fn three(values: &[Number]) -> Option<[f64; 3]> {
    let mut found = [0.0; 3];
    for (place, value) in found.iter_mut().zip(values) {
        *place = value.eval().ok()?;
    }
    (values.len() == 3).then_some(found)
}

impl Case {
    /// The potentials as terms in lanes on SO(3) or SE(3); `None` where one of them has no such form.
    pub(crate) fn loads<const N: usize>(&self) -> Option<Vec<Term<N>>> {
        let term = |potential: &Potential| {
            Some(match potential {
                Potential::Gravity { weight, center } => Term::Gravity(weight.eval().ok()?, three(center)?),
                Potential::Buoyancy { lift, center } => Term::Gravity(-lift.eval::<f64>().ok()?, three(center)?),
                Potential::UniformField { moment, field } => Term::UniformField(three(moment)?, three(field)?),
                _ => return None,
            })
        };
        self.potentials.iter().map(term).collect()
    }
}
