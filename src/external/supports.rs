//! What a program says that it supports: once, beside an answer or in its place.

use super::program::shown;
use crate::algebra::Entry;
use crate::laws::method::StateForm;
use crate::system::case::{Potential, Structure};
use crate::system::force::ForceKind;
use crate::system::restriction::{DragForm, Restriction};
use crate::system::{Case, Cases};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The systems that a program supports, and what its state is. A key that is absent restricts nothing; without `potentials` there are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Supports {
    /// Only these algebras, by name: `so3`, `se3`, `so3+r1`, …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub algebras: Option<Vec<String>>,
    /// Only algebras of these dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimensions: Option<Vec<usize>>,
    /// Only standard bases.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub standard_basis: bool,
    /// Only diagonal inertias.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub diagonal_inertia: bool,
    /// Only inertias of rigid bodies: moments of which none is larger than the sum of the others, on se(3) with a mass and a center. For
    /// so(3) and se(3) in their standard bases.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub physical_inertia: bool,
    /// Whether Lagrangians may have a quartic term.
    #[serde(skip_serializing_if = "bool::clone")]
    pub quartic: bool,
    /// Only forces of these kinds; an empty list: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forces: Option<Vec<String>>,
    /// Only drags with such a matrix.
    #[serde(skip_serializing_if = "DragForm::is_any")]
    pub drag: DragForm,
    /// Potentials of these kinds alone; absent: none. A state that is not an attitude has none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub potentials: Vec<String>,
    /// Only positive steps.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub positive_steps: bool,
    /// What its state is.
    #[serde(skip_serializing_if = "StateForm::is_attitude")]
    pub state: StateForm,
}

impl Default for Supports {
    fn default() -> Self {
        Self {
            algebras: None,
            dimensions: None,
            standard_basis: false,
            diagonal_inertia: false,
            physical_inertia: false,
            quartic: true,
            forces: None,
            drag: DragForm::Any,
            potentials: Vec::new(),
            positive_steps: false,
            state: StateForm::default(),
        }
    }
}

/// The key of an answer that holds it.
const KEY: &str = "supports";

/// What a line says about it, and whether it says nothing else; `None` where it does not say it.
///
/// # Errors
/// What is wrong with it.
pub(super) fn said(line: &[u8]) -> Result<Option<(Supports, bool)>, String> {
    // Most answers are long lists of numbers without it.
    if !line.windows(KEY.len()).any(|word| word == KEY.as_bytes()) {
        return Ok(None);
    }
    // What is no object is said when the answer is read.
    let Ok(Value::Object(object)) = serde_json::from_slice(line) else { return Ok(None) };
    let Some(value) = object.get(KEY) else { return Ok(None) };
    let supports = Supports::of(value).map_err(|why| format!("{why}: {}", shown(line, 200)))?;
    let alone = !["mu", "unsupported", "error"].iter().any(|key| object.contains_key(*key));
    Ok(Some((supports, alone)))
}

impl Supports {
    /// What a JSON object says.
    ///
    /// # Errors
    /// Text that is none, unknown keys, algebras and forces that there are not.
    pub fn parse(text: &str) -> Result<Self, String> {
        Self::of(&serde_json::from_str(text).map_err(|error| error.to_string())?)
    }

    fn of(value: &Value) -> Result<Self, String> {
        let wrong = |why: String| format!("\"{KEY}\" in the stepper's answer: {why}");
        let supports: Self = Self::deserialize(value).map_err(|error| wrong(error.to_string()))?;
        for name in supports.algebras.iter().flatten() {
            name.parse::<Entry>().map_err(|error| wrong(error.to_string()))?;
        }
        let kinds: Vec<&str> = ForceKind::names().collect();
        if let Some(name) = supports.forces.iter().flatten().find(|name| !kinds.contains(&name.as_str())) {
            return Err(wrong(format!("a force \"{name}\"; allowed: {}", kinds.join(", "))));
        }
        if let Some(name) = supports.potentials.iter().find(|name| !Potential::KINDS.contains(&name.as_str())) {
            return Err(wrong(format!("a potential \"{name}\"; allowed: {}", Potential::KINDS.join(", "))));
        }
        if !supports.potentials.is_empty() && supports.state != StateForm::Attitude {
            return Err(wrong("potentials, of which the state has no attitude".into()));
        }
        let bodies = |entries: Vec<Entry>| entries.iter().all(|entry| matches!(entry, Entry::So3 | Entry::Se3));
        if supports.physical_inertia && !(supports.standard_basis && supports.entries().is_some_and(bodies)) {
            return Err(wrong(
                "physical_inertia; it is for \"algebras\" so3 and se3 with \"standard_basis\": true".into(),
            ));
        }
        if let StateForm::Point(x) = &supports.state
            && (x.iter().all(|x| *x == 0.0) || x.iter().any(|x| !x.is_finite()))
        {
            return Err(wrong("a point that is 0, or not finite".into()));
        }
        Ok(supports)
    }

    /// The algebras.
    fn entries(&self) -> Option<Vec<Entry>> {
        self.algebras.as_ref().map(|names| names.iter().filter_map(|name| name.parse().ok()).collect())
    }

    fn restriction(&self) -> Restriction {
        let matrices = match &self.state {
            StateForm::Point(x) => Some(x.len()),
            _ => None,
        };
        let Self { dimensions, forces, .. } = self.clone();
        let potentials = Some(self.potentials.clone());
        let (diagonal, physical, forward) = (self.diagonal_inertia, self.physical_inertia, self.positive_steps);
        Restriction { dimensions, matrices, forces, potentials, diagonal, physical, drag: self.drag, forward }
    }

    /// Those of these cases that it supports.
    pub fn cases(&self, base: Cases) -> Cases {
        // Who asks for no force asks for no potential either.
        let potentials = if base.is_force_free() { &[][..] } else { &self.potentials };
        let mut cases = match self.entries() {
            Some(entries) => base.among(&entries),
            None => base,
        };
        if self.standard_basis {
            cases = cases.changed_basis(false);
        }
        if !self.quartic {
            cases = cases.quadratic();
        }
        if self.forces.as_ref().is_some_and(Vec::is_empty) {
            cases = cases.force_free();
        }
        cases.potentials(potentials).restricted(self.restriction())
    }

    /// Whether it supports a system; the sign of the step is not looked at.
    pub fn admits(&self, case: &Case) -> bool {
        self.excludes(case).is_none()
    }

    /// The first key that excludes a system.
    pub(super) fn excludes(&self, case: &Case) -> Option<&'static str> {
        let named = |entries: Vec<Entry>| match &case.algebra.structure {
            Structure::Named(entry) => entries.contains(entry),
            _ => false,
        };
        let restriction = self.restriction();
        let keys = [
            ("algebras", self.entries().is_none_or(named)),
            ("dimensions", restriction.has_dimension(case.dimension())),
            ("standard_basis", !self.standard_basis || case.algebra.basis.is_none()),
            ("diagonal_inertia", restriction.has_diagonal(case)),
            ("physical_inertia", restriction.has_body(case)),
            ("quartic", self.quartic || case.lagrangian.quartic.is_none()),
            ("forces", restriction.has_forces(case)),
            ("drag", restriction.has_drags(case)),
            ("potentials", restriction.has_potentials(case)),
            ("state", restriction.has_matrices(case.matrix_size())),
        ];
        keys.into_iter().find_map(|(key, holds)| (!holds).then_some(key))
    }

    /// The case with what can be left out of it left out.
    pub(super) fn adapted(&self, case: Case) -> Option<Case> {
        let mut case = self.restriction().adapted(case);
        if !self.quartic {
            case.lagrangian.quartic = None;
        }
        self.admits(&case).then_some(case)
    }
}
