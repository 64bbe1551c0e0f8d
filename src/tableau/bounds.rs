//! What the simplifying assumptions say about the orders, without a single tree.
//!
//! **Classical order** (Butcher 1964). B(p), C(q) and D(r) with p ≤ q + r + 1 and p ≤ 2q + 2 give order p. Without B(p + 1) it is
//! not p + 1: the condition of the tree with p leaves at the root fails. No method of s stages has B(2s + 1).
//!
//! **Variational order.** With positive weights it is at least 2k + 1 if and only if B(2k + 1), C(k) and D(k) hold, and at least
//! 2k + 2 if and only if besides B(2k + 2) and Σ b_i c_i^k a_ij c_j^k = 1/(2 (k + 1)²). The "if" needs no sign of the weights.
//!
//! Sufficient: the conjugate has C and D exchanged, so for k ≥ 1 both matrices have C(k), with the same c by D(1). An oriented tree of
//! order 2k + 1, rooted at its centroid, has branches of order at most k, each of which is a power of c by C(k): what is left is
//! B(2k + 1). With 2k + 2 vertices the trees with two centroids reduce to the one condition more.
//!
//! Necessary: Σ_i b_i (Σ_j a_ij c_j^{k−1} − c_i^k/k)² is a combination of weights of order 2k + 1 that vanishes if these are 1/γ,
//! and the same for â. (k = 1 is the lemma on D(1) of Hager 2000.)

use super::Order;
use super::assumptions::{Assumptions, middle};
use super::quantity::{Coefficients, Quantity};

/// An order is at least `least` and at most `most`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Proven.
    pub least: usize,
    /// Nothing above is possible.
    pub most: usize,
}

impl Bounds {
    /// Those of the classical and of the variational order; `ceiling` is what the quadrature formula is known not to exceed (2s for
    /// any tableau of s stages), where round-off or few digits hide it.
    pub fn of<Q: Quantity>(coefficients: &Coefficients<Q>, assumptions: &Assumptions, ceiling: usize) -> [Self; 2] {
        let Assumptions { b, c, d } = assumptions;
        let (most, s) = (b.holds.min(ceiling), coefficients.stages());
        let k = c.holds.min(d.holds);
        let closed = || middle(coefficients, k).vanishes(8 * (2 * k + 2) * (s + 2));
        let pair = if most > 2 * k + 1 && closed() { 2 * k + 2 } else { most.min(2 * k + 1) };
        let positive = coefficients.b.iter().all(|b| b.to_f64() > 0.0);
        let variational = Self { least: pair, most: if positive { pair } else { most } };
        let one = most.min(c.holds + d.holds + 1).min(2 * c.holds + 2);
        [Self { least: one.max(pair), most }, variational]
    }

    /// What trees left open, closed.
    pub fn close(self, found: Order) -> Order {
        if found.broken.is_some() {
            return found;
        }
        let order = found.order.max(self.least);
        Order { order, most: Some(self.most.max(order)), ..found }
    }
}
