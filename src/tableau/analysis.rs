//! Everything that can be said about a tableau from its coefficients, exactly where they are rational.

use super::assumptions::{Assumptions, Failure};
use super::exact::RationalTableau;
use super::failing::Failing;
use super::order::{Arithmetic, Conditions};
use super::quantity::{Ball, Coefficients, Quantity, decimal};
use super::stability::Stability;
use super::structure::{Shape, Symmetry, is_symplectic};
use super::{Description, Order, Tableau, TableauError};
use crate::scalar::Real;
use dashu_ratio::RBig;

/// What [`analyse`] finds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Analysis {
    /// The tableau as text.
    pub description: String,
    /// The number of stages.
    pub stages: usize,
    /// Whether everything was decided in exact rational arithmetic; otherwise to the round-off of [`Analysis::scalar`].
    pub exact: bool,
    /// The name of the scalar that irrational coefficients were computed in.
    pub scalar: &'static str,
    /// The order as a plain Runge–Kutta method that the name, or the file, claims.
    pub declared: Option<usize>,
    /// For the coefficients as they stand.
    pub exactly: Findings,
    /// If some entries are rounded decimals: what may hold for a tableau whose entries round to these digits.
    ///
    /// A condition is counted as fulfilled if its defect is no larger than what moving every rounded entry by its
    /// [uncertainty](crate::scalar::Number::uncertainty) can make, by ball arithmetic: a tableau of order p that is typed
    /// with rounding has order at least p here.
    pub to_digits: Option<Findings>,
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

/// The orders of a tableau with what they rest on.
///
/// ```
/// use euler_poincare::tableau::analysis::{Analysis, Findings, analyse};
/// use euler_poincare::tableau::stability::Stability;
/// use euler_poincare::tableau::{Description, Entries, RationalTableau};
///
/// let description: Description = "alexander2".parse()?;
/// let analysis: Analysis = analyse::<f64>(&description, 6)?;
/// let findings: &Findings = analysis.findings();
/// assert_eq!((analysis.declared, findings.classical.order), (Some(2), 2));
/// assert_eq!(analysis.stability, Stability::AStable);
///
/// // Rational coefficients are analysed exactly.
/// let half = || "1/2".parse();
/// let midpoint = Description::Entries(Entries { a: vec![vec![half()?]], b: vec!["1".parse()?], c: None });
/// let exact: RationalTableau = midpoint.rational()?.expect("rational entries");
/// assert_eq!(exact.variational_order(6).map(|order| order.order), Some(2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Findings {
    /// The order as a Runge–Kutta method.
    pub classical: Order,
    /// The order of the pair (a, â): of the forced variational integrator on a general Lie group.
    pub variational: Order,
    /// The rooted trees of the next classical order that fail.
    pub failing_classical: Option<Failing>,
    /// The oriented free trees of the next variational order that fail, each rooted at its centroid.
    pub failing_variational: Option<Failing>,
    /// B(p), C(q), D(r).
    pub assumptions: Assumptions,
}

/// Analyses a tableau: in exact arithmetic if it is rational, else in `T`; orders are checked up to `max` (and at most
/// [`MAX_CLASSICAL`](super::order::MAX_CLASSICAL), [`MAX_VARIATIONAL`](super::order::MAX_VARIATIONAL)).
///
/// ```
/// use euler_poincare::scalar::Dd;
/// use euler_poincare::tableau::analyse;
/// let ralston = analyse::<Dd>(&"ralston3".parse()?, 6)?;
/// assert_eq!((ralston.exactly.classical.order, ralston.exactly.variational.order), (3, 2));
/// let failing = ralston.exactly.failing_variational.unwrap();
/// assert_eq!(failing.conditions[0].to_string(), "Σ b_i ĉ_i^2 = 1/3, is 11/24 (off by 1/8 = 1.25e-1)");
/// # Ok::<(), euler_poincare::tableau::TableauError>(())
/// ```
///
/// # Errors
/// Those of [`Description::build`] and [`Description::rational`].
pub fn analyse<T: Real>(description: &Description, max: usize) -> Result<Analysis, TableauError> {
    let tableau = description.build::<T>()?;
    let rational = description.rational()?;
    let exact = rational.as_ref().and_then(|rational| in_rationals(rational, max));
    let mut analysis = exact.unwrap_or_else(|| in_scalar(&tableau, max));
    analysis.description = description.to_string();
    analysis.declared = description.declared();
    analysis.scalar = T::NAME;
    analysis.normalised =
        rational.and_then(|rational| rational.normalised().map(|sum| (sum - RBig::ONE).to_f64_fast()));
    if let Description::Entries(entries) = description {
        analysis.first_rounded = entries.first_rounded();
        analysis.to_digits = analysis.first_rounded.as_ref().map(|_| {
            let coefficients = Coefficients::to_digits(&tableau, entries);
            analysis.stability = analysis.stability.clone().within_digits(&coefficients);
            in_balls(&coefficients, max)
        });
    }
    Ok(analysis)
}

fn in_rationals(tableau: &RationalTableau, max: usize) -> Option<Analysis> {
    let coefficients = tableau.coefficients();
    let (one, two) = (tableau.conditions(1)?, tableau.conditions(2)?);
    let findings = Findings::of(one, two, &coefficients, max);
    Some(Analysis::of(&coefficients, findings, Stability::of_rational(tableau), true))
}

fn in_scalar<T: Real>(tableau: &Tableau<T>, max: usize) -> Analysis {
    let coefficients = Coefficients::of(tableau);
    Analysis::of(&coefficients, in_balls(&coefficients, max), Stability::of(tableau), false)
}

fn in_balls<T: Real>(coefficients: &Coefficients<Ball<T>>, max: usize) -> Findings {
    let conditions = |colours: usize| Conditions::in_balls(coefficients, colours);
    Findings::of(conditions(1), conditions(2), coefficients, max)
}

impl Findings {
    fn of<A: Arithmetic, Q: Quantity>(
        mut one: Conditions<A>,
        mut two: Conditions<A>,
        coefficients: &Coefficients<Q>,
        max: usize,
    ) -> Self {
        let (classical, mut variational) = (one.order(max), two.order(max));
        let failing_classical = Failing::of(&mut one, &classical);
        let mut failing_variational = Failing::of(&mut two, &variational);
        if variational.broken.is_none() && variational.order == classical.order {
            // Trees of one colour are among those of two: what fails for them was not checked for the pair, but fails.
            variational.broken.clone_from(&classical.broken);
            failing_variational.clone_from(&failing_classical);
        }
        Self {
            failing_classical,
            failing_variational,
            classical,
            variational,
            assumptions: Assumptions::of(coefficients),
        }
    }

    /// The simplifying assumptions that explain the orders, where one does: B(p + 1) for a classical order p, and for a
    /// smaller variational order those of [`Findings::missing`].
    pub fn hints(&self) -> Vec<String> {
        let Assumptions { b, c, d } = &self.assumptions;
        let mut hints: Vec<String> = Vec::new();
        let mut add = |failure: &Failure| {
            let hint = failure.to_string();
            if !hints.contains(&hint) {
                hints.push(hint);
            }
        };
        if self.classical.broken.is_some() {
            match b.fails.as_ref().filter(|_| b.holds == self.classical.order) {
                Some(failure) => add(failure),
                None => [&c.fails, &d.fails].into_iter().flatten().for_each(&mut add),
            }
        }
        if self.variational.order < self.classical.order {
            self.missing().into_iter().for_each(&mut add);
        }
        hints
    }

    /// What of C(k) and D(k) fails, with k half the variational order.
    ///
    /// With positive weights the variational order is at least 2k + 1 if and only if B(2k + 1), C(k) and D(k) hold, and at
    /// least 2k + 2 if and only if besides B(2k + 2) and Σ b_i c_i^k a_ij c_j^k = 1/(2 (k + 1)²).
    ///
    /// Sufficient: the conjugate has C and D exchanged, so for k ≥ 1 both matrices have C(k), with the same c by D(1). An
    /// oriented tree of order 2k + 1, rooted at its centroid, has branches of order at most k, each of which is a power
    /// of c by C(k): what is left is B(2k + 1). With 2k + 2 vertices the trees with two centroids reduce to the one
    /// condition more. Necessary: Σ_i b_i (Σ_j a_ij c_j^{k−1} − c_i^k/k)² is a combination of weights of order
    /// 2k + 1 that vanishes if these are 1/γ, and the same for â. (k = 1 is the lemma on D(1) of Hager 2000.)
    pub fn missing(&self) -> Vec<&Failure> {
        let k = self.variational.order / 2;
        let Assumptions { c, d, .. } = &self.assumptions;
        [d, c].into_iter().filter(|assumption| assumption.holds < k).filter_map(|x| x.fails.as_ref()).collect()
    }
}

impl Analysis {
    fn of<Q: Quantity>(coefficients: &Coefficients<Q>, exactly: Findings, stability: Stability, exact: bool) -> Self {
        Self {
            description: String::new(),
            stages: coefficients.stages(),
            exact,
            scalar: "",
            declared: None,
            exactly,
            to_digits: None,
            shape: Shape::of(coefficients),
            symmetry: Symmetry::of(coefficients),
            symplectic: is_symplectic(coefficients),
            stability,
            positive_weights: coefficients.b.iter().all(|b| b.to_f64() > 0.0),
            normalised: None,
            first_rounded: None,
        }
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
        let given = [&digits.classical, &digits.variational];
        let exact = [&self.exactly.classical, &self.exactly.variational];
        let which = format!("{entry} is a rounded decimal (half a unit of its last digit is allowed for)");
        if given.map(|order| order.order) == exact.map(|order| order.order) {
            return Some(format!("{which}; the orders are the same without the allowance."));
        }
        let [classical, variational] = given;
        let pair = format!("classical {classical}, variational {variational}");
        let mut note = format!("{which}: the orders {pair} hold only to the digits given. ");
        let (name, failing) = match (&self.exactly.failing_classical, &self.exactly.failing_variational) {
            (Some(failing), _) if given[0].order != exact[0].order => ("classical", Some(failing)),
            (_, failing) => ("variational", failing.as_ref()),
        };
        if let Some(failing) = failing {
            note += &format!("The exact {name} order of these digits is {}", failing.order - 1);
            note += &failing.conditions.first().map_or_else(String::new, |worst| format!(": {worst}"));
            note += ".";
        }
        Some(note)
    }

    fn note_on_declared(&self) -> Option<String> {
        let (declared, found) = (self.declared?, self.findings());
        let classical = &found.classical;
        if declared == classical.order || (declared > classical.order && classical.broken.is_none()) {
            return None;
        }
        let mut note = format!("The declared order is {declared}, but the classical order is {classical}");
        if declared > classical.order {
            let worst = found.failing_classical.as_ref().and_then(|failing| failing.conditions.first());
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
        let scalar = self.scalar;
        (!self.exact)
            .then(|| format!("Some coefficients are irrational: conditions are decided to the round-off of {scalar}."))
    }
}
