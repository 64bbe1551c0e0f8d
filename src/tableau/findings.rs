//! The orders of a tableau with what they rest on.

use super::assumptions::{Assumptions, Failure};
use super::bounds::Bounds;
use super::failing::Failing;
use super::order::Conditions;
use super::quantity::{Coefficients, Quantity};
use super::{Description, Order};

/// How far orders are looked for.
#[derive(Clone, Copy)]
pub(super) struct Reach {
    /// In trees.
    pub max: usize,
    /// No order is higher, whatever round-off hides: that of the quadrature formula of a family, else 2s.
    pub ceiling: usize,
}

impl Reach {
    pub fn of(description: &Description, max: usize) -> Self {
        let ceiling = match description {
            Description::Family(family, stages) => family.declared(*stages),
            _ => 2 * description.stages(),
        };
        Self { max, ceiling }
    }
}

/// The orders of a tableau with what they rest on.
#[derive(Clone, Debug, PartialEq)]
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

impl Findings {
    pub(super) fn of<Q: Quantity>(
        mut one: Conditions<Q>,
        mut two: Conditions<Q>,
        coefficients: &Coefficients<Q>,
        reach: Reach,
    ) -> Self {
        let assumptions = Assumptions::of(coefficients);
        let [bounds_of_one, bounds_of_two] = Bounds::of(coefficients, &assumptions, reach.ceiling);
        let classical = bounds_of_one.close(one.order(reach.max));
        let mut variational = bounds_of_two.close(two.order(reach.max));
        // Trees of one colour are among those of two.
        variational.most = variational.most.map(|most| most.min(classical.most.unwrap_or(most)));
        let failing_classical = Failing::of(&mut one, &classical);
        let mut failing_variational = Failing::of(&mut two, &variational);
        if variational.broken.is_none() && variational.order == classical.order {
            // What fails for one colour was not checked for the pair, but fails.
            variational.broken.clone_from(&classical.broken);
            failing_variational.clone_from(&failing_classical);
        }
        Self { failing_classical, failing_variational, classical, variational, assumptions }
    }

    /// The simplifying assumptions that explain the order of the pair, where one does: B(p + 1) where it is the classical order p, and for a smaller
    /// one those of [`Findings::missing`].
    pub fn hints(&self) -> Vec<String> {
        let Assumptions { b, c, d } = &self.assumptions;
        let failures: Vec<&Failure> = if self.variational.order < self.classical.order {
            self.missing()
        } else if !self.classical.is_exact() {
            Vec::new()
        } else {
            match b.fails.as_ref().filter(|_| b.holds == self.classical.order) {
                Some(failure) => vec![failure],
                None => [&c.fails, &d.fails].into_iter().flatten().collect(),
            }
        };
        failures.into_iter().map(ToString::to_string).collect()
    }

    /// What of C(k) and D(k) fails, with k half the variational order: with positive weights, why the order is not at least 2k + 1
    /// (see [`bounds`](super::bounds)).
    pub fn missing(&self) -> Vec<&Failure> {
        let k = self.variational.order / 2;
        let Assumptions { c, d, .. } = &self.assumptions;
        [d, c].into_iter().filter(|assumption| assumption.holds < k).filter_map(|x| x.fails.as_ref()).collect()
    }
}
