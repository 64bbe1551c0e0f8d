//! Lie groupoids: translations, invariant vector fields, and the Lie algebroid by its definition.
//!
//! Elements have coordinates in an ambient ℝᵐ; tangent vectors are vectors there. The structure maps are evaluated on
//! dual numbers, so every tangent map is exact to round-off. Source: Martín de Diego and Sato Martín de Almagro 2019,
//! Definitions 4.2, 4.3 and 4.5.

use super::Groupoid;
use super::algebroid::{LieAlgebroid, Section};
use super::calculus::{along, constant, derivatives, infinitesimal, values};
use crate::scalar::{Dual, Scalar};
use nalgebra::DVector;

/// A Lie groupoid over the scalar S, with its Lie algebroid in closed form.
///
/// Tangent maps and invariant fields over S come from the groupoid over `Dual<S>`, brackets from that over
/// `Dual<Dual<S>>`. A fibre of AG is the kernel of Tα at a unit, with coordinates a in the frame of [`LieAlgebroid`].
///
/// ```
/// use euler_poincare::group::So3;
/// use euler_poincare::groupoid::{
///     ActionGroupoid, DenseGroup, Groupoid, LieAlgebroid, LieGroupoid, Lowered, section_bracket,
/// };
/// use euler_poincare::scalar::Dual;
/// use nalgebra::DVector;
///
/// let vector = |x: [f64; 3]| DVector::from_row_slice(&x);
///
/// // SO(3) acts on so(3)* by Ad*; the arrows are (μ, g, μ·g). The anchor of ξ is its generator, μ ↦ ad*_ξ μ.
/// let group = DenseGroup::of(&So3::<f64>::new());
/// let groupoid = ActionGroupoid::<f64>::new(group.clone());
/// let (mu, xi) = (vector([1.0, 2.0, 3.0]), vector([1.0, 0.0, 0.0]));
/// assert_eq!(groupoid.rank(), 3);
/// assert_eq!(groupoid.anchor(&mu, &xi).dot(&mu), 0.0);
///
/// // Coordinates: an element near a unit, and back.
/// let near = groupoid.near_unit(&mu, &vector([0.0, 0.0, 0.0]));
/// assert_eq!(groupoid.coordinates(&near), groupoid.coordinates(&groupoid.unit(&mu)));
///
/// // The bracket of sections: of two constant ones it is that of the algebra, up to the sign of the convention.
/// let on_duals = ActionGroupoid::<Dual<f64>>::new(group);
/// let constant = |k: usize| move |_: &DVector<Dual<f64>>| DVector::from_fn(3, |a, _| Dual::constant(if a == k { 1.0 } else { 0.0 }));
/// let bracket = section_bracket(&Lowered(&on_duals), &constant(0), &constant(1), &mu);
/// assert_eq!(bracket.map(f64::abs), vector([0.0, 0.0, 1.0]));
/// ```
pub trait LieGroupoid<S: Scalar>: Groupoid + LieAlgebroid<S> {
    /// The coordinates of g: those of α(g) first, those of β(g) last.
    fn coordinates(&self, g: &Self::Element) -> DVector<S>;

    /// The element with these coordinates.
    fn element(&self, z: &DVector<S>) -> Self::Element;

    /// The coordinates of x.
    fn base_coordinates(&self, x: &Self::Base) -> DVector<S>;

    /// The point of the base with these coordinates.
    fn base_point(&self, z: &DVector<S>) -> Self::Base;

    /// The number of vector fields that span the tangent spaces of the base.
    fn base_dimension(&self) -> usize;

    /// x displaced by v in these fields, to first order.
    fn near_point(&self, x: &Self::Base, v: &DVector<S>) -> Self::Base;

    /// An element with source x, displaced from ε(x) by a^i s_i(x) to first order; for a of order ε only.
    fn near_unit(&self, x: &Self::Base, a: &DVector<S>) -> Self::Element;

    /// The a with a^i s_i(x) = `tangent`, for a vector at ε(x) with Tα = 0; `None` where x is not a point of the base.
    fn fibre(&self, x: &Self::Base, tangent: &DVector<S>) -> Option<DVector<S>>;
}

/// The tangent maps of a Lie groupoid over S and its invariant fields, from the groupoid over `Dual<S>`.
pub trait Tangent<S: Scalar>: LieGroupoid<Dual<S>> {
    /// The derivative of the product at (g, h) along (δg, δh); `None` if they are not composable.
    fn push_product(
        &self,
        (g, along_g): (&DVector<S>, &DVector<S>),
        (h, along_h): (&DVector<S>, &DVector<S>),
    ) -> Option<DVector<S>> {
        let (g, h) = (self.element(&along(g, along_g)), self.element(&along(h, along_h)));
        Some(derivatives(&self.coordinates(&self.compose(&g, &h).ok()?)))
    }

    /// T_{g'} L_g of a vector with Tα = 0, for L_g(g') = g g' (Def 4.2); `None` if g and g' are not composable.
    fn push_left(&self, g: &DVector<S>, other: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        self.push_product((g, &DVector::zeros(g.len())), (other, tangent))
    }

    /// T_{g'} R_g of a vector with Tβ = 0, for R_g(g') = g' g (Def 4.2); `None` if g' and g are not composable.
    fn push_right(&self, g: &DVector<S>, other: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        self.push_product((other, tangent), (g, &DVector::zeros(g.len())))
    }

    /// T_g ι of a vector, or `None` where g has no inverse.
    fn push_inverse(&self, g: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        let inverse = self.inverse(&self.element(&along(g, tangent)))?;
        Some(derivatives(&self.coordinates(&inverse)))
    }

    /// T_g α of a vector.
    fn push_source(&self, g: &DVector<S>, tangent: &DVector<S>) -> DVector<S> {
        derivatives(&self.base_coordinates(&self.source(&self.element(&along(g, tangent)))))
    }

    /// T_g β of a vector.
    fn push_target(&self, g: &DVector<S>, tangent: &DVector<S>) -> DVector<S> {
        derivatives(&self.base_coordinates(&self.target(&self.element(&along(g, tangent)))))
    }

    /// T_x ε of a vector.
    fn push_unit(&self, x: &DVector<S>, tangent: &DVector<S>) -> DVector<S> {
        derivatives(&self.coordinates(&self.unit(&self.base_point(&along(x, tangent)))))
    }

    /// a^i s_i(x), a vector at ε(x).
    fn at_unit(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        let element = self.near_unit(&self.base_point(&constant(x)), &infinitesimal(a));
        derivatives(&self.coordinates(&element))
    }

    /// X←(g) = (T L_g) X(β(g)), the left-invariant field of a section given by its fibre coordinates.
    ///
    /// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.1).
    fn left_field(&self, section: impl FnOnce(&DVector<S>) -> DVector<S>, g: &DVector<S>) -> Option<DVector<S>> {
        let g = self.element(&constant(g));
        let x = self.target(&g);
        let a = section(&values(&self.base_coordinates(&x)));
        let product = self.compose(&g, &self.near_unit(&x, &infinitesimal(&a))).ok()?;
        Some(derivatives(&self.coordinates(&product)))
    }

    /// X→(g) = −(T R_g Tι) X(α(g)), the right-invariant field of a section given by its fibre coordinates.
    ///
    /// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.3).
    fn right_field(&self, section: impl FnOnce(&DVector<S>) -> DVector<S>, g: &DVector<S>) -> Option<DVector<S>> {
        let g = self.element(&constant(g));
        let x = self.source(&g);
        let a = section(&values(&self.base_coordinates(&x)));
        let inverse = self.inverse(&self.near_unit(&x, &infinitesimal(&a)))?;
        Some(-derivatives(&self.coordinates(&self.compose(&inverse, &g).ok()?)))
    }
}

impl<S: Scalar, Q: LieGroupoid<Dual<S>> + ?Sized> Tangent<S> for Q {}

/// A vector field on duals; `None` outside its domain.
pub type Field<'a, S> = dyn Fn(&DVector<Dual<S>>) -> Option<DVector<Dual<S>>> + 'a;

/// \[X, Y\](g) = DY·X − DX·Y for vector fields on ℝᵐ, by duals.
pub fn commutator<S: Scalar>(first: &Field<'_, S>, second: &Field<'_, S>, g: &DVector<S>) -> Option<DVector<S>> {
    let (x, y) = (values(&first(&constant(g))?), values(&second(&constant(g))?));
    Some(derivatives(&second(&along(g, &x))?) - derivatives(&first(&along(g, &y))?))
}

/// ⟦X, Y⟧(x) by its definition, the commutator of X← and Y← at ε(x), in fibre coordinates.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.2).
pub fn bracket_of_fields<S: Scalar, Q: LieGroupoid<Dual<Dual<S>>> + ?Sized>(
    groupoid: &Q,
    first: &Section<'_, S>,
    second: &Section<'_, S>,
    x: &DVector<S>,
) -> Option<DVector<S>> {
    let point = groupoid.base_point(&constant(&constant(x)));
    let unit = values(&values(&groupoid.coordinates(&groupoid.unit(&point))));
    let left = |section: &Section<'_, S>, g: &DVector<Dual<S>>| groupoid.left_field(section, g);
    let tangent = commutator(&|g| left(first, g), &|g| left(second, g), &unit)?;
    Some(values(&values(&groupoid.fibre(&point, &constant(&constant(&tangent)))?)))
}
