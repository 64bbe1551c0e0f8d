//! Forces at a point of a body.

use super::Configuration;
use crate::algebra::{Covector, Vector, basis_vector};
use crate::group::LieGroup;
use crate::mechanics::{Force, at_the_identity};
use crate::scalar::{Real, Scalar};

/// In which frame a force at a point is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    Body,
    Space,
}

/// A force F(t, g, v) ∈ ℝᴾ* that acts at a point r of a body, as a force on its group: ⟨f, ξ⟩ = F · v_ξ(r) for every ξ ∈ g, so that its
/// power ⟨f, η⟩ is F · v.
///
/// | group | velocity of the point, in the body | f, with F in the body |
/// |---|---|---|
/// | SO(3), D = 3; the body turns about the origin | η × r | the torque r × F |
/// | SE(3), D = 4, η = (ω, u) | ω × r + u | the wrench (r × F, F) |
/// | SE(2), D = 3, P = 2, η = (ω, u) | ω (−r₂, r₁) + u | (r₁ F₂ − r₂ F₁, F) |
///
/// In general v_ξ(r) = ξ̂ r, with r as (r, 1) where the matrices of the group have one row more than r. In any basis of the algebra.
///
/// F is any [`Force`] on ℝᴾ: instead of η it is given the velocity v of the point. So a [`Constant`](crate::mechanics::force::Constant)
/// is a weight or a thrust, a [`LinearDrag`](crate::mechanics::force::LinearDrag) a damper;
/// [`Driven`](crate::mechanics::force::Driven) makes it follow a control, a pair is a sum, and a
/// [`ForceOnGroup`](super::ForceOnGroup)`<T, P, D>` in an [`OnGroup`](super::OnGroup) depends on where the body is.
///
/// * [`in_body`](AtPoint::in_body): F and v have the components of the frame of the body.
/// * [`in_space`](AtPoint::in_space): those of the frame of space. v_s = R v and F = F_s R, with the first P rows and columns R of g.
///
/// Units: r in m and F in N give torques in N m.
#[derive(Clone, Debug, PartialEq)]
pub struct AtPoint<F, T: Real, const P: usize, const N: usize> {
    force: F,
    frame: Frame,
    /// ê_a r for each a: the velocity of the point is the sum of η^a ê_a r.
    velocities: [Vector<T, P>; N],
}

impl<F, T: Real, const P: usize, const N: usize> AtPoint<F, T, P, N> {
    /// F in the frame of the body, at the point r of the body.
    pub fn in_body<const D: usize>(force: F, point: Vector<T, P>, group: &impl LieGroup<T, N, D>) -> Self {
        Self { force, frame: Frame::Body, velocities: velocities(&point, group) }
    }

    /// F in the frame of space, at the point r of the body (in the frame of the body).
    pub fn in_space<const D: usize>(force: F, point: Vector<T, P>, group: &impl LieGroup<T, N, D>) -> Self {
        Self { force, frame: Frame::Space, velocities: velocities(&point, group) }
    }

    /// The velocity of the point in the frame of the body, where the body has the velocity η.
    pub fn point_velocity<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Vector<S, P> {
        let mut sum = Vector::<S, P>::zeros();
        for (velocity, eta) in self.velocities.iter().zip(eta.iter()) {
            sum += velocity.map(S::lift) * *eta;
        }
        sum
    }
}

/// ê_a r for each a. Matrices have the affine part, if there is one, in the column after the last of r.
fn velocities<T: Real, const P: usize, const N: usize, const D: usize>(
    point: &Vector<T, P>,
    group: &impl LieGroup<T, N, D>,
) -> [Vector<T, P>; N] {
    let place = Vector::<T, D>::from_fn(|k, _| {
        if k < P {
            point[k]
        } else if k == P {
            T::one()
        } else {
            T::zero()
        }
    });
    std::array::from_fn(|a| {
        let moved = group.hat(&basis_vector(a)) * place;
        Vector::from_fn(|k, _| if k < D { moved[k] } else { T::zero() })
    })
}

impl<F: Force<T, P>, T: Real, const P: usize, const N: usize> Force<T, N> for AtPoint<F, T, P, N> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        let velocity = self.point_velocity(eta);
        let force = match self.frame {
            Frame::Body => self.force.force_at(t, g, &velocity),
            Frame::Space => {
                let turned = g.matrix::<P>();
                self.force.force_at(t, g, &(turned * velocity)) * turned
            }
        };
        Covector::from_fn(|_, a| {
            let along = &self.velocities[a];
            (0..P).fold(S::zero(), |sum, k| sum + force[k] * S::lift(along[k]))
        })
    }

    fn uses_configuration(&self) -> bool {
        self.frame == Frame::Space || self.force.uses_configuration()
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        let velocity = self.point_velocity(eta);
        match self.frame {
            Frame::Body => self.force.undefined(t, g, &velocity),
            Frame::Space => self.force.undefined(t, g, &(g.matrix::<P>() * velocity)),
        }
    }

    fn is_zero(&self) -> bool {
        self.force.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.force.is_smooth()
    }
}
