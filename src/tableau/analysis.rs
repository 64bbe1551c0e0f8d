//! Everything that can be said about a tableau from its coefficients, exactly where they are rational.

use super::completion::{Completion, complete};
pub use super::findings::Findings;
use super::findings::Reach;
use super::order::Conditions;
use super::quantity::{Ball, Coefficients, Quantity, decimal};
use super::stability::Stability;
use super::structure::{Shape, Symmetry, is_symplectic};
use super::{Description, Entries, Tableau, TableauError};
use crate::scalar::{Dd, Real};
use dashu_ratio::RBig;

/// What [`analyse`] finds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Analysis {
    /// The tableau as text.
    pub description: String,
    /// The number of stages.
    pub stages: usize,
    /// Whether everything was decided in exact rational arithmetic; otherwise to the round-off of 32 digits.
    pub exact: bool,
    /// The order that is claimed for the variational integrator with this tableau; names claim none.
    pub declared: Option<usize>,
    /// For the coefficients as they stand.
    pub exactly: Findings,
    /// If some entries are rounded decimals: for the tableau of [`Analysis::completion`]. Without one, orders are at least those of the
    /// digits as they stand, and at most [`Analysis::allowed`].
    pub to_digits: Option<Findings>,
    /// If some entries are rounded decimals: the tableau of the highest order that rounds to these digits, if it was found.
    pub completion: Option<Completion>,
    /// If some entries are rounded decimals: no tableau that rounds to these digits has a higher variational order.
    ///
    /// Every condition up to this order has a defect no larger than what moving every rounded entry by its
    /// [allowance](super::Entries::allowances) can make, by ball arithmetic.
    pub allowed: Option<usize>,
    /// The zeros of a.
    pub shape: Shape,
    /// Whether the method is its own adjoint.
    pub symmetry: Symmetry,
    /// Whether b_i a_ij + b_j a_ji = b_i b_j: a = â.
    pub symplectic: bool,
    /// A-stability.
    pub stability: Stability,
    /// Whether all weights are positive, as Hager's lemma on D(1) asks.
    pub positive_weights: bool,
    /// Σb − 1 of the weights as given, if they were divided by their sum.
    pub normalised: Option<f64>,
    /// The name of the first entry that is a rounded decimal.
    pub first_rounded: Option<String>,
}

/// Analyses a tableau: in exact arithmetic if it is rational, else in 32 digits. Trees are checked up to order `max` (and at most
/// [`MAX_CLASSICAL`](super::order::MAX_CLASSICAL), [`MAX_VARIATIONAL`](super::order::MAX_VARIATIONAL)); where none fails, the simplifying
/// assumptions decide ([`bounds`](super::bounds)).
///
/// ```
/// use euler_poincare::tableau::analyse;
/// let ralston = analyse(&"ralston3".parse()?, 6)?;
/// assert_eq!((ralston.exactly.classical.order, ralston.exactly.variational.order), (3, 2));
/// let failing = ralston.exactly.failing_variational.unwrap();
/// assert_eq!(failing.conditions[0].to_string(), "Σ b_i ĉ_i^2 = 1/3, is 11/24 (off by 1/8 = 1.25e-1)");
/// # Ok::<(), euler_poincare::tableau::TableauError>(())
/// ```
///
/// # Errors
/// Those of [`Description::build`] and [`Description::rational`].
pub fn analyse(description: &Description, max: usize) -> Result<Analysis, TableauError> {
    let tableau = description.build::<Dd>()?;
    let rational = description.rational()?;
    let reach = Reach::of(description, max);
    let exact = rational.as_ref().and_then(|rational| in_rationals(rational, reach));
    let mut analysis = exact.unwrap_or_else(|| in_scalar(&tableau, reach));
    analysis.description = description.to_string();
    if let Description::Entries(entries) = description {
        analysis.normalised = rational.and_then(|_| entries.excess());
        analysis.first_rounded = entries.first_rounded();
        if analysis.first_rounded.is_some() {
            analysis.allow_for_rounding(&tableau, entries, reach)?;
        }
    }
    Ok(analysis)
}

fn in_rationals(coefficients: &Coefficients<RBig>, reach: Reach) -> Option<Analysis> {
    let (one, two) = (coefficients.conditions(1)?, coefficients.conditions(2)?);
    let findings = Findings::of(one, two, coefficients, reach);
    Some(Analysis::of(coefficients, findings, Stability::of_rational(coefficients), true))
}

fn in_scalar(tableau: &Tableau<Dd>, reach: Reach) -> Analysis {
    let coefficients = Coefficients::of(tableau);
    Analysis::of(&coefficients, in_balls(&coefficients, reach), Stability::of(tableau), false)
}

fn in_balls(coefficients: &Coefficients<Ball<Dd>>, reach: Reach) -> Findings {
    let conditions = |colours: usize| Conditions::of(coefficients, colours);
    Findings::of(conditions(1), conditions(2), coefficients, reach)
}

impl Analysis {
    fn of<Q: Quantity>(coefficients: &Coefficients<Q>, exactly: Findings, stability: Stability, exact: bool) -> Self {
        Self {
            description: String::new(),
            stages: coefficients.stages(),
            exact,
            declared: None,
            exactly,
            to_digits: None,
            completion: None,
            allowed: None,
            shape: Shape::of(coefficients),
            symmetry: Symmetry::of(coefficients),
            symplectic: is_symplectic(coefficients),
            stability,
            positive_weights: coefficients.b.iter().all(|b| b.to_f64() > 0.0),
            normalised: None,
            first_rounded: None,
        }
    }

    /// What may hold for a tableau whose entries round to these digits, and the one with the highest order.
    fn allow_for_rounding(
        &mut self,
        tableau: &Tableau<Dd>,
        entries: &Entries,
        reach: Reach,
    ) -> Result<(), TableauError> {
        let coefficients = Coefficients::to_digits(tableau, entries);
        self.stability = self.stability.clone().within_digits(&coefficients);
        let mut allowed = in_balls(&coefficients, reach);
        self.allowed = allowed.variational.most;
        self.completion = complete(entries, &self.exactly, &allowed)?;
        if let Some(completion) = &mut self.completion {
            let coefficients = Coefficients::of(&completion.entries.build::<Dd>()?);
            self.symmetry = Symmetry::of(&coefficients);
            self.symplectic = is_symplectic(&coefficients);
            let found = in_balls(&coefficients, reach);
            // Higher than what was asked for where the digits are symmetric: such methods have even orders.
            completion.order = found.variational.order;
            self.to_digits = Some(found);
            return Ok(());
        }
        for (order, typed) in
            [(&mut allowed.classical, &self.exactly.classical), (&mut allowed.variational, &self.exactly.variational)]
        {
            order.order = typed.order;
        }
        self.to_digits = Some(allowed);
        Ok(())
    }

    /// The orders of exactly these digits are the orders to the digits given, and nothing higher was found.
    pub fn rounding_matters(&self) -> bool {
        let orders = |found: &Findings| [found.classical.order, found.variational.order];
        self.to_digits.as_ref().is_some_and(|found| orders(found) != orders(&self.exactly))
            || (self.to_digits.is_some() && self.completion.is_none())
    }

    /// Whether the variational order is `claimed`, to the digits given; `None` where that is not known.
    pub fn has_order(&self, claimed: usize) -> Option<bool> {
        let order = &self.findings().variational;
        // A higher order may be in digits that the search did not find.
        let open = self.allowed.is_some_and(|allowed| claimed <= allowed) && claimed > order.order;
        if open { None } else { order.is(claimed) }
    }

    /// What is to be relied on: to the digits given if entries are rounded, else exactly.
    pub fn findings(&self) -> &Findings {
        self.to_digits.as_ref().unwrap_or(&self.exactly)
    }

    /// Why the orders are what they are, in plain sentences; empty if there is nothing to explain.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        notes.extend(self.normalised.map(|excess| {
            let (sign, size) = (if excess < 0.0 { '−' } else { '+' }, decimal(excess.abs()));
            format!("The weights b sum to 1 {sign} {size}; they were divided by their sum.")
        }));
        notes.extend(self.note_on_digits());
        notes.extend(self.note_on_declared());
        notes.extend(self.note_on_the_pair());
        notes.extend(self.note_on_precision());
        notes
    }

    fn note_on_digits(&self) -> Option<String> {
        let (digits, entry) = (self.to_digits.as_ref()?, self.first_rounded.as_ref()?);
        let which = format!("{entry} is a rounded decimal: it stands for an interval of half a unit of its last place");
        if !self.rounding_matters() {
            return Some(format!("{which}. The orders of exactly these digits are the same."));
        }
        let mut note = match &self.completion {
            Some(Completion { order, moved, .. }) => format!(
                "{which}. A tableau of variational order {order} rounds to these digits; it differs from them by at most {moved:.1e}, and \
                 the orders are those of this tableau."
            ),
            None => format!(
                "{which}. No tableau of an order above {} that rounds to these digits was found; {} is not excluded.",
                digits.variational.order,
                self.allowed.map_or("a higher order".into(), |allowed| format!("order {allowed}"))
            ),
        };
        let Findings { classical, failing_classical, failing_variational, .. } = &self.exactly;
        let (name, failing) = match failing_classical {
            Some(failing) if classical.order < digits.classical.order => ("classical", Some(failing)),
            _ => ("variational", failing_variational.as_ref()),
        };
        if let Some(failing) = failing {
            note += &format!(" The {name} order of exactly these digits is {}", failing.order - 1);
            note += &failing.conditions.first().map_or_else(String::new, |worst| format!(": {worst}"));
            note += ".";
        }
        Some(note)
    }

    fn note_on_declared(&self) -> Option<String> {
        let (declared, found) = (self.declared?, self.findings());
        let (classical, variational) = (&found.classical, &found.variational);
        if self.has_order(declared) != Some(false) {
            return None;
        }
        let mut note =
            format!("The declared order is {declared}, but the order of the variational integrator is {variational}");
        if declared == classical.order {
            return Some(note + &format!("; {declared} is the order as a Runge–Kutta method."));
        }
        if declared > variational.order {
            let worst = found.failing_variational.as_ref().and_then(|failing| failing.conditions.first());
            note += &worst.map_or_else(String::new, |worst| format!(": {worst}"));
        }
        Some(note + ".")
    }

    fn note_on_the_pair(&self) -> Option<String> {
        let found = self.findings();
        let (classical, variational) = (&found.classical, &found.variational);
        if variational.order >= classical.order {
            return None;
        }
        if !variational.is_exact() {
            let checked =
                format!("The conditions of two colours were checked up to order {}, and all hold", variational.order);
            let open = self.to_digits.is_none() || self.completion.is_some();
            return open.then(|| {
                format!("{checked}. The variational order may be higher: the classical order is {classical}.")
            });
        }
        let mut note = format!(
            "The variational order is {variational} although the classical order is {classical}, because the forced \
             integrator uses a and its conjugate â together"
        );
        let missing = found.missing();
        if let Some(failure) = missing.first() {
            note += &format!(": {failure}");
            if self.positive_weights {
                let (kind, k) = (failure.kind, variational.order / 2);
                note +=
                    &format!("; with positive weights {kind:?}({k}) is necessary for variational order {}", 2 * k + 1);
            }
        } else if let Some(worst) = found.failing_variational.as_ref().and_then(|failing| failing.conditions.first()) {
            note += &format!(": {worst}");
        }
        Some(note + ".")
    }

    fn note_on_precision(&self) -> Option<String> {
        let scalar = Dd::NAME;
        (!self.exact)
            .then(|| format!("Some coefficients are irrational: conditions are decided to the round-off of {scalar}."))
    }
}
