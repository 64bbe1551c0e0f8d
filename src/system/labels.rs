//! What a case is an example of: the labels by which coverage is counted.

use super::case::{Algebra, Case, Inertia, Structure};
use super::dispatch::{System, Visitor};
use crate::algebra::catalogue::Entry;
use crate::retraction::Retraction;
use crate::scalar::Number;
use crate::tableau::{Description, Family};

/// Whether all brackets vanish, from the description alone.
pub(super) fn abelian(algebra: &Algebra) -> bool {
    fn entry_is(entry: &Entry) -> bool {
        match entry {
            Entry::Abelian(_) => true,
            Entry::Product(factors) => factors.iter().all(entry_is),
            _ => false,
        }
    }
    match &algebra.structure {
        Structure::Named(entry) => entry_is(entry),
        Structure::Constants { constants, .. } => constants.iter().all(|k| k.value == Number::default()),
    }
}

/// The name of the algebra in counts: ℝⁿ, products and algebras by constants are one kind each.
fn kind(algebra: &Algebra) -> String {
    match &algebra.structure {
        Structure::Named(Entry::Abelian(_)) => "rn".into(),
        Structure::Named(Entry::Product(_)) => "product".into(),
        Structure::Named(entry) => entry.to_string(),
        Structure::Constants { .. } => "constants".into(),
    }
}

struct Class;

impl Visitor<f64> for Class {
    type Output = (&'static str, bool);

    fn visit<const N: usize, const D: usize, R: Retraction<f64, N, D>>(
        self,
        system: System<f64, N, D, R>,
    ) -> Self::Output {
        let algebra = &system.algebra;
        let class = if algebra.is_abelian() {
            "abelian"
        } else if algebra.is_nilpotent() {
            "nilpotent"
        } else if algebra.is_solvable() {
            "solvable"
        } else if algebra.is_semisimple() {
            "semisimple"
        } else {
            "mixed"
        };
        (class, algebra.is_unimodular())
    }
}

/// Label names and values; `force` occurs once for each kind of term, or once as `none`.
pub fn labels(case: &Case) -> Vec<(&'static str, String)> {
    let mut labels = vec![("algebra", kind(&case.algebra)), ("dimension", case.dimension().to_string())];
    let mut probe = case.clone();
    // Whatever the retraction: exp is the quickest to set up.
    probe.method.retraction = super::case::Tau::Exponential;
    if let Ok((class, unimodular)) = probe.dispatch::<f64, _>(Class) {
        labels.push(("class", class.into()));
        labels.push(("unimodular", if unimodular { "yes" } else { "no" }.into()));
    }
    labels.push(("basis", if case.algebra.basis.is_some() { "changed" } else { "standard" }.into()));
    let inertia = match &case.lagrangian.inertia {
        Inertia::Diagonal(_) => "diagonal",
        Inertia::Full(_) => "full",
    };
    labels.push(("inertia", inertia.into()));
    labels.push(("lagrangian", if case.lagrangian.quartic.is_some() { "quartic" } else { "quadratic" }.into()));
    let mut kinds: Vec<&str> = case.forces.iter().map(|force| force.kind()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    if kinds.is_empty() {
        kinds.push("none");
    }
    labels.extend(kinds.into_iter().map(|kind| ("force", kind.to_string())));
    labels.push(("retraction", case.method.retraction.name().into()));
    labels.push(("tableau", tableau_kind(&case.method.tableau).into()));
    labels
}

/// `gauss`, `lobatto`, `radau` or `classic` for named tableaux, the shape of the others by their entries.
fn tableau_kind(tableau: &Description) -> &'static str {
    match tableau {
        Description::Family(Family::Gauss, _) => "gauss",
        Description::Family(Family::RadauIA | Family::RadauIIA, _) => "radau",
        Description::Family(_, _) => "lobatto",
        Description::Classic(_) => "classic",
        Description::Entries(_) => tableau.kind(),
    }
}
