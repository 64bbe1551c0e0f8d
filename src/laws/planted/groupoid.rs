//! The structure maps of a Lie groupoid, in its coordinates, with faults planted in them.

use super::blend_scalar;
use crate::groupoid::{Groupoid, LieAlgebroid, LieGroupoid, NotComposable};
use crate::harness::Fault;
use crate::scalar::Scalar;
use nalgebra::DVector;

/// A Lie groupoid whose elements are vectors of coordinates.
pub type Flat<'a, S> = dyn LieGroupoid<S, Element = DVector<S>, Base = DVector<S>> + 'a;

pub const INVERSE_KEEPS_U: Fault = Fault::new(
    "inverse-keeps-u",
    "ι(λ, U, μ) = (μ, U, λ), without the inverse of U (as printed in (4.4))",
    "every groupoid with a group part, U ≠ U⁻¹",
);
pub const ENDS_KEPT: Fault =
    Fault::new("ends-kept", "ι(λ, U, μ) = (λ, U⁻¹, μ)", "every groupoid over more than a point");
// (λ, VU, κ) is none: it is the groupoid of the opposite group.
pub const SECOND_INVERTED: Fault =
    Fault::new("second-inverted", "(λ, U, μ)(μ, V, κ) = (λ, UV⁻¹, κ)", "every groupoid with a group part");
pub const PRODUCT_KEEPS_END: Fault =
    Fault::new("product-keeps-end", "(λ, U, μ)(μ, V, κ) = (λ, UV, μ)", "every groupoid over more than a point");
pub const UNCHECKED: Fault = Fault::new(
    "composed-unchecked",
    "pairs whose ends differ by at most 8 are taken for composable",
    "every groupoid over more than a point",
);
pub const UNMATCHED: Fault =
    Fault::new("atiyah-unmatched", "[p, q][p', q'] = [p, q'], without the k that takes p' to q", "Atiyah groupoids");
pub const ACTION_INVERTED: Fault =
    Fault::new("action-inverted", "x·g⁻¹ instead of x·g", "action groupoids, where g acts by more than a sign");
pub const SOURCE_BLIND: Fault = Fault::new(
    "source-blind",
    "the last coordinate of α(g) replaced by the same number for all g",
    "every groupoid over g*",
);
pub const PRODUCT_WITHOUT_GROUP: Fault =
    Fault::new("product-without-group", "(λ, U, μ)(μ, V, κ) = (λ, e, κ)", "groupoids with a group part");
pub const ANCHOR_SIGN: Fault = Fault::new("algebroid-anchor-sign", "ρ replaced by −ρ", "anchors other than 0");
pub const STRUCTURE_SIGN: Fault =
    Fault::new("algebroid-structure-sign", "⟦s_i, s_j⟧ replaced by ⟦s_j, s_i⟧", "non-abelian algebras");

/// right + ε (wrong − right) of two vectors.
pub fn blend_vector<S: Scalar>(right: &DVector<S>, wrong: &DVector<S>, size: f64) -> DVector<S> {
    right.zip_map(wrong, |right, wrong| blend_scalar(right, wrong, size))
}

/// A product, or `near_unit`, with a fault of its own.
pub(in crate::laws) type Wrong<'a, S> = Box<dyn Fn(&DVector<S>, &DVector<S>) -> DVector<S> + 'a>;

/// A Lie groupoid in its coordinates, with a fault planted in its structure: elements and points of the base are vectors.
pub struct Planted<'a, Q, S: Scalar> {
    groupoid: Q,
    fault: Option<&'a Fault>,
    /// The product that [`UNMATCHED`] has.
    pub(in crate::laws) unmatched: Option<Wrong<'a, S>>,
    /// `near_unit`, where it has a fault of its own.
    pub(in crate::laws) near_unit: Option<Wrong<'a, S>>,
}

impl<'a, S: Scalar, Q: LieGroupoid<S>> Planted<'a, Q, S> {
    /// The groupoid with a fault or without.
    pub fn new(groupoid: Q, fault: Option<&'a Fault>) -> Self {
        Self { groupoid, fault, unmatched: None, near_unit: None }
    }

    /// α without a fault.
    fn right_source(&self, g: &DVector<S>) -> DVector<S> {
        let q = &self.groupoid;
        q.base_coordinates(&q.source(&q.element(g)))
    }

    /// ι without a fault.
    fn right_inverse(&self, g: &DVector<S>) -> Option<DVector<S>> {
        let q = &self.groupoid;
        Some(q.coordinates(&q.inverse(&q.element(g))?))
    }

    /// ν without a fault.
    fn right_product(&self, first: &DVector<S>, second: &DVector<S>) -> DVector<S> {
        let q = &self.groupoid;
        q.coordinates(&q.product(&q.element(first), &q.element(second)))
    }

    /// The coordinates of the ends from `ends`, those between them from `middle`.
    fn assembled(&self, ends: &DVector<S>, middle: &DVector<S>) -> DVector<S> {
        let end = self.right_source(ends).len();
        DVector::from_fn(ends.len(), |i, _| if i < end || i >= ends.len() - end { ends[i] } else { middle[i] })
    }
}

impl<S: Scalar, Q: LieGroupoid<S>> Groupoid for Planted<'_, Q, S> {
    type Element = DVector<S>;
    type Base = DVector<S>;

    fn source(&self, g: &DVector<S>) -> DVector<S> {
        let mut right = self.right_source(g);
        let blind = SOURCE_BLIND.size_in(self.fault);
        if let (true, Some(last)) = (blind > 0.0, right.iter_mut().last()) {
            *last = blend_scalar(*last, S::one(), blind);
        }
        right
    }

    fn target(&self, g: &DVector<S>) -> DVector<S> {
        let q = &self.groupoid;
        q.base_coordinates(&q.target(&q.element(g)))
    }

    fn unit(&self, x: &DVector<S>) -> DVector<S> {
        let q = &self.groupoid;
        q.coordinates(&q.unit(&q.base_point(x)))
    }

    fn inverse(&self, g: &DVector<S>) -> Option<DVector<S>> {
        let right = self.right_inverse(g)?;
        let (u, ends) = (INVERSE_KEEPS_U.size_in(self.fault), ENDS_KEPT.size_in(self.fault));
        if u > 0.0 {
            return Some(blend_vector(&right, &self.assembled(&right, g), u));
        }
        Some(if ends > 0.0 { blend_vector(&right, &self.assembled(g, &right), ends) } else { right })
    }

    fn product(&self, first: &DVector<S>, second: &DVector<S>) -> DVector<S> {
        let right = self.right_product(first, second);
        let (inverted, end) = (SECOND_INVERTED.size_in(self.fault), PRODUCT_KEEPS_END.size_in(self.fault));
        if let (true, Some(inverse)) = (inverted > 0.0, self.right_inverse(second)) {
            let wrong = self.right_product(first, &self.assembled(second, &inverse));
            return blend_vector(&right, &wrong, inverted);
        }
        if let (true, Some(unmatched)) = (UNMATCHED.size_in(self.fault) > 0.0, &self.unmatched) {
            return blend_vector(&right, &unmatched(first, second), UNMATCHED.size_in(self.fault));
        }
        let without = PRODUCT_WITHOUT_GROUP.size_in(self.fault);
        if without > 0.0 {
            let unit = self.unit(&self.target(second));
            return blend_vector(&right, &self.assembled(&right, &unit), without);
        }
        if end > 0.0 {
            let kept = self.target(first).len();
            let wrong = DVector::from_fn(right.len(), |i, _| if i < right.len() - kept { right[i] } else { first[i] });
            return blend_vector(&right, &wrong, end);
        }
        right
    }

    fn compose(&self, first: &DVector<S>, second: &DVector<S>) -> Result<DVector<S>, NotComposable<DVector<S>>> {
        let (target, source_of_second) = (self.target(first), self.source(second));
        let tolerance = S::exact(8.0 * UNCHECKED.size_in(self.fault));
        let near = tolerance > S::zero() && (&target - &source_of_second).amax() <= tolerance;
        if target == source_of_second || near {
            return Ok(self.product(first, second));
        }
        let source_of_second = self.right_source(second);
        if target == source_of_second {
            return Ok(self.right_product(first, second));
        }
        Err(NotComposable { target, source_of_second })
    }
}

impl<S: Scalar, Q: LieGroupoid<S>> LieAlgebroid<S> for Planted<'_, Q, S> {
    fn rank(&self) -> usize {
        self.groupoid.rank()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        let right = self.groupoid.anchor(x, a);
        blend_vector(&right, &-&right, ANCHOR_SIGN.size_in(self.fault))
    }

    fn structure(&self, x: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        let right = self.groupoid.structure(x, a, b);
        blend_vector(&right, &-&right, STRUCTURE_SIGN.size_in(self.fault))
    }
}

impl<S: Scalar, Q: LieGroupoid<S>> LieGroupoid<S> for Planted<'_, Q, S> {
    fn coordinates(&self, g: &DVector<S>) -> DVector<S> {
        g.clone()
    }

    fn element(&self, z: &DVector<S>) -> DVector<S> {
        z.clone()
    }

    fn base_coordinates(&self, x: &DVector<S>) -> DVector<S> {
        x.clone()
    }

    fn base_point(&self, z: &DVector<S>) -> DVector<S> {
        z.clone()
    }

    fn base_dimension(&self) -> usize {
        self.groupoid.base_dimension()
    }

    fn near_point(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        let q = &self.groupoid;
        q.base_coordinates(&q.near_point(&q.base_point(x), v))
    }

    fn near_unit(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        if let Some(wrong) = &self.near_unit {
            return wrong(x, a);
        }
        let q = &self.groupoid;
        q.coordinates(&q.near_unit(&q.base_point(x), a))
    }

    fn fibre(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        self.groupoid.fibre(&self.groupoid.base_point(x), tangent)
    }
}
