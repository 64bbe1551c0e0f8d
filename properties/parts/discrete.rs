//! Discrete Lagrangians of a user's own. On those of random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, names, switched_off};
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::discrete::{DiscreteError, DiscreteLagrangian, Slopes, StageLagrangian, Triple};
use euler_poincare::group::So3;
use euler_poincare::laws::user::discrete::{OnGroup, UserDiscrete};
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::force::LinearDrag;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{CayleySo3, Retraction, TangentPoint};
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::tableau::Family;

type Stages<T> = StageLagrangian<T, Forced<Quadratic<T, 3>, LinearDrag<T, 3>, CayleySo3<T>>, CayleySo3<T>, 3, 3>;

/// l_d of a damped body by the Gauss method of `stages` stages, h = 1/8.
pub fn stages<T: Real>(stages: usize) -> OnGroup<Stages<T>, So3<T>, CayleySo3<T>> {
    let inertia = Quadratic::diagonal([T::half(), T::int(2), T::one()]).unwrap();
    let drag = LinearDrag::new(Matrix::<T, 3>::identity() * T::half()).unwrap();
    let l_f = Forced::new(inertia, drag, CayleySo3::new());
    let tableau = Family::Gauss.tableau::<T>(stages).unwrap();
    let lagrangian = StageLagrangian::new(l_f, CayleySo3::new(), tableau, T::exact(0.125));
    OnGroup { lagrangian, group: So3::new(), retraction: CayleySo3::new() }
}

/// l_d = (⟨w, I w⟩ − ⟨v, I v⟩)/(2h) − ⟨v + w, u⟩/2 with V = cay(v), U = cay(u), W = cay(w), h = 1/8, by hand, with mistakes.
#[derive(Clone, Copy, Debug)]
struct ByHand(&'static str);

impl ByHand {
    fn logarithms<T: Real>(self, x: &Triple<T, 3>) -> Result<[Vector<T, 3>; 3], DiscreteError> {
        let tau = CayleySo3::<T>::new();
        let log =
            |g: &Matrix<T, 3>| tau.tau_inv(g).map_err(|source| DiscreteError::Domain { what: "(V, U, W)", source });
        Ok([log(&x.v)?, log(&x.u)?, log(&x.w)?])
    }

    /// Of V and W in the work.
    fn shares<T: Real>(self) -> [T; 2] {
        if self.0 == "one copy" { [T::one(), T::zero()] } else { [T::half(); 2] }
    }

    fn inertia<T: Real>() -> Matrix<T, 3> {
        Matrix::from_diagonal(&Vector::<T, 3>::new(T::half(), T::int(2), T::one()))
    }
}

impl<T: Real> DiscreteLagrangian<T, 3, 3> for ByHand {
    type Memory = Option<Slopes<T, 3>>;

    fn value(&self, x: &Triple<T, 3>) -> Result<T, DiscreteError> {
        let [v, u, w] = self.logarithms(x)?;
        let kinetic = |x: &Vector<T, 3>| x.dot(&(Self::inertia() * x)) * T::int(4);
        // Antisymmetric to first order on the units alone.
        let off = if self.0 == "off the units" { u[0] * u[0] } else { T::zero() };
        let [a, b] = self.shares::<T>();
        Ok(kinetic(&w) - kinetic(&v) - (v * a + w * b).dot(&u) + off)
    }

    fn slopes_from(&self, x: &Triple<T, 3>, memory: &mut Self::Memory) -> Result<Slopes<T, 3>, DiscreteError> {
        if let (Some(slopes), "stale") = (*memory, self.0) {
            return Ok(slopes);
        }
        let [v, u, w] = self.logarithms(x)?;
        let eight = T::int(8);
        let factor = if self.0 == "factor" { T::int(4) } else { eight };
        let [a, b] = self.shares::<T>();
        let coupled = if self.0 == "no coupling" { T::zero() } else { b };
        let by_v = -(Self::inertia() * v * eight + u * a).transpose();
        let by_w = (Self::inertia() * w * factor - u * coupled).transpose();
        let mut by_u = -(v * a + w * b).transpose();
        if self.0 == "off the units" {
            by_u[0] += u[0] + u[0];
        }
        let tau = CayleySo3::<T>::new();
        let refused = |source| DiscreteError::Domain { what: "(V, U, W)", source };
        let sides = |p: Covector<T, 3>, x: &Vector<T, 3>| {
            let (here, back) = (tau.at(x).map_err(refused)?, tau.at(&-x).map_err(refused)?);
            Ok::<_, DiscreteError>((p * here.d_inv(), p * back.d_inv()))
        };
        let ((v_left, v_right), (u_left, u_right), (w_left, w_right)) =
            (sides(by_v, &v)?, sides(by_u, &u)?, sides(by_w, &w)?);
        let (u_left, u_right) = if self.0 == "sides" { (u_right, u_left) } else { (u_left, u_right) };
        let slopes = Slopes { v_left, v_right, u_left, u_right, w_left, w_right };
        *memory = Some(slopes);
        Ok(slopes)
    }
}

fn by_hand<T: Real>(mistake: &'static str) -> OnGroup<ByHand, So3<T>, CayleySo3<T>> {
    OnGroup { lagrangian: ByHand(mistake), group: So3::new(), retraction: CayleySo3::new() }
}

#[test]
fn mistakes_by_hand_are_named() {
    let own = |mistake| move || UserDiscrete::at_both(by_hand::<f64>(mistake), by_hand::<Dd>(mistake)).antisymmetric();
    assert!(switched_off(&clean("by hand", own("nothing")(), 60)).is_empty());
    clean("one stage in f64", UserDiscrete::in_double(stages::<f64>(1)).antisymmetric(), 40);
    let found = |mistake| names(&broken(own(mistake), 40));
    assert!(found("factor").contains(&"discrete-slopes"), "{:?}", found("factor"));
    assert_eq!(found("sides"), ["discrete-slopes"]);
    assert!(found("no coupling").contains(&"discrete-slopes"));
    assert!(found("stale").contains(&"discrete-memory"), "{:?}", found("stale"));
    assert!(found("one copy").contains(&"discrete-antisymmetry"), "{:?}", found("one copy"));
    assert!(!found("one copy").contains(&"discrete-slopes"), "its slopes are right");
    // Thm 5.3 looks at the derivatives on the units alone.
    assert_eq!(found("off the units"), ["discrete-antisymmetry"]);
    let kept = UserDiscrete::at_both(by_hand::<f64>("off the units"), by_hand::<Dd>("off the units")).keeps_units();
    assert_eq!(switched_off(&clean("keeps units", kept, 40)), ["discrete-antisymmetry"]);
}

/// D₃l_d = 0: no step can be found.
#[derive(Clone, Copy)]
struct Irregular;

impl<T: Real> DiscreteLagrangian<T, 3, 3> for Irregular {
    type Memory = ();

    fn value(&self, x: &Triple<T, 3>) -> Result<T, DiscreteError> {
        Ok(x.v[(0, 0)])
    }

    fn slopes_from(&self, x: &Triple<T, 3>, (): &mut ()) -> Result<Slopes<T, 3>, DiscreteError> {
        let (hat, zero) = (euler_poincare::group::so3::hat::<T>, Covector::zeros());
        let e = |a: usize| Vector::<T, 3>::from_fn(|b, _| if a == b { T::one() } else { T::zero() });
        let v_left = Covector::from_fn(|_, a| (x.v * hat(&e(a)))[(0, 0)]);
        let v_right = Covector::from_fn(|_, a| (hat(&e(a)) * x.v)[(0, 0)]);
        Ok(Slopes { v_left, v_right, u_left: zero, u_right: zero, w_left: zero, w_right: zero })
    }
}

#[test]
fn an_irregular_one_is_named() {
    let part = || OnGroup { lagrangian: Irregular, group: So3::<f64>::new(), retraction: CayleySo3::<f64>::new() };
    let found = names(&broken(|| UserDiscrete::in_double(part()), 40));
    assert_eq!(found, ["discrete-regular"]);
}
