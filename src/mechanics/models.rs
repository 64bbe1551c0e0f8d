//! The two systems of Martín de Diego and Sato Martín de Almagro 2019, §5.3, exact in every scalar.
//!
//! Both live on so(3) (vectors of ℝ³, [x, y] = x × y) with inertia diag(½, 2, 1), Ω(0) = (1, 0, 1)/√2 and T = 1.

use super::equations::EulerPoincare;
use super::force::{AnyForce, DoubleBracket, Metriplectic};
use super::lagrangian::{AnyLagrangian, Quadratic};
use crate::algebra::{Covector, LieAlgebra, Vector};
use crate::group::{LieGroup, So3};
use crate::scalar::Real;

/// A system with an initial state, a horizon, and its solution there.
#[derive(Clone, Debug)]
pub struct Model<T: Real> {
    /// `"llg"` or `"relaxed"`: the name in tables and files.
    pub name: &'static str,
    /// The algebra so(3), the Lagrangian ½ ΩᵀIΩ and the force.
    pub system: EulerPoincare<T, 3, AnyLagrangian<T, 3>, AnyForce<T, 3>>,
    /// M(0) = I Ω(0).
    pub momentum: Covector<T, 3>,
    /// T, the end of the interval [0, T].
    pub horizon: T,
    /// M(T), to 40 digits (extrapolated midpoint rule in 60-digit arithmetic, two resolutions agreeing to 10⁻⁵⁴).
    pub reference: [&'static str; 3],
}

impl<T: Real> Model<T> {
    /// M(T) in T's precision.
    pub fn reference_momentum(&self) -> Option<Covector<T, 3>> {
        let [x, y, z] = self.reference.map(T::parse_decimal);
        Some(Covector::from([x?, y?, z?]))
    }

    /// Ω(0).
    pub fn velocity(&self) -> Vector<T, 3> {
        let c = T::one() / T::int(2).sqrt();
        Vector::from([c, T::zero(), c])
    }
}

fn model<T: Real>(
    name: &'static str,
    reference: [&'static str; 3],
    force: impl FnOnce(LieAlgebra<T, 3>, AnyLagrangian<T, 3>) -> AnyForce<T, 3>,
) -> Model<T> {
    let inertia = Quadratic::diagonal([T::half(), T::int(2), T::one()]).expect("the moments are not zero");
    let lagrangian = AnyLagrangian::from(inertia);
    let algebra = So3::new().algebra().clone();
    let force = force(algebra.clone(), lagrangian.clone());
    let c = T::one() / T::int(2).sqrt();
    let momentum = Covector::from([T::half() * c, T::zero(), c]);
    let system = EulerPoincare::new(algebra, lagrangian, force);
    Model { name, system, momentum, horizon: T::one(), reference }
}

/// Landau–Lifshitz–Gilbert: f = M × (M × Ω). |M|² is kept, the energy falls.
pub fn landau_lifshitz_gilbert<T: Real>() -> Model<T> {
    let reference = [
        "0.2414593544179368885463111843598407097451",
        "0.2537142183692990580699436642122433443185",
        "0.7087499386676014196337227897913316761450",
    ];
    model("llg", reference, |algebra, lagrangian| {
        DoubleBracket::new(algebra, lagrangian, T::one()).expect("α is finite").into()
    })
}

/// The relaxed rigid body: f = (1/10) (Ω × M) × Ω. The energy is kept, |M|² grows at 2 |Ω × M|²/10.
pub fn relaxed_rigid_body<T: Real>() -> Model<T> {
    let reference = [
        "0.3792307480209543639345208227206081917150",
        "0.2570004497899354372657588518798812706374",
        "0.6552430571282844754182144270780495170196",
    ];
    model("relaxed", reference, |algebra, lagrangian| {
        Metriplectic::new(algebra, lagrangian, T::ratio(1, 10)).expect("β is finite").into()
    })
}
