//! Laws of one force: any [`Force`] that a user writes, with the properties that the user claims for it.
//!
//! ```
//! use euler_poincare::algebra::Matrix;
//! use euler_poincare::laws::user::{force::UserForce, part};
//! use euler_poincare::mechanics::force::LinearDrag;
//!
//! let drag = LinearDrag::new(Matrix::<f64, 3>::identity())?;
//! let report = part::run(UserForce::in_double(drag).dissipates(), 1, 4);
//! assert!(report.laws.iter().all(|law| law.broken.is_empty()));
//! # Ok::<(), euler_poincare::mechanics::force::ForceError>(())
//! ```

use super::super::differences::{compared, slope};
use super::super::planted::blend;
use super::super::precision::Measured;
use super::lagrangian::list;
use super::part::{Answer, Answers, Asked, Kind, Part, off, part_laws};
use crate::algebra::{Casimir, Covector, Vector, basis_vector, pair};
use crate::harness::{About, Cost, Fault};
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::dual::{along, moving};
use crate::scalar::{Dd, Dual, Real, Scalar};
use std::any::Any;
use std::cell::Cell;
use std::sync::Arc;

const EVERY: &str = "every force";
const NOT_ZERO: &str = "forces other than 0";
const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, §2 and (2.12)";
const EXACT: &str = "none: the same bits";
const DIFFERENCES: &str = "2⁸ times the estimated error of the differences with 2⁶ N u, also of terms that cancel; in each precision by itself";
const BOUND: &str =
    "two precisions; floor 2⁶ N u relative to Σ(|f_a| + Σ|∂_b f_a| |η^b|) |η^a|, or with |dC^a|: f may cancel";

const FORCE_NAN: Fault = Fault::new("force-nan", "f is NaN where η_1 > 0", EVERY);
const FORCE_STATE: Fault = Fault::new("force-state", "the number of evaluations so far added to f", EVERY);
const FORCE_CONSTANT: Fault =
    Fault::new("force-constant", "f evaluated on values alone: its derivative is 0", "forces that are not constant");
const SAYS_ZERO: Fault = Fault::new("says-zero", "`is_zero` where f ≠ 0", NOT_ZERO);
pub(in crate::laws) const FORCE_SIGN: Fault = Fault::new("force-sign", "f replaced by −f", "forces that dissipate");
const FORCE_LOAD: Fault = Fault::new("force-load", "1 added to each component of f", EVERY);

const fn about(
    statement: &'static str,
    oracle: &'static str,
    bound: &'static str,
    needs: &'static str,
    faults: &'static [Fault],
) -> About {
    About { name: "", statement, source: SOURCE, oracle, bound, needs, faults, cost: Cost::Cheap }
}

part_laws! {
    /// The laws of this file.
    LAWS FIELDS __own_force;
    every {
        force_finite "t# eta" about("f(t, η) is finite", "the numbers themselves", "none: finite or not", "", &[FORCE_NAN]);
        force_deterministic "t# eta dt# along" about(
            "f(t, η) is the same whenever it is evaluated",
            "another evaluation, after one elsewhere",
            EXACT,
            "",
            &[FORCE_STATE, FORCE_NAN],
        );
        force_derivatives "t# eta dt# along" about(
            "f on dual numbers has the value of f and the derivative of its values, along t and η; on duals of duals too",
            "differences of f, extrapolated to fourth order",
            DIFFERENCES,
            "",
            &[FORCE_CONSTANT, FORCE_STATE],
        );
        force_zero "t# eta" about("if `is_zero()` then f(t, η) = 0", "f itself", "none: exactly 0", "", &[SAYS_ZERO]);
    }
    claimed {
        force_dissipates "t# eta" about(
            "⟨f(t, η), η⟩ ≤ 0",
            "the pairing",
            BOUND,
            "the claim `dissipates`",
            &[FORCE_SIGN, FORCE_LOAD],
        );
        force_workless "t# eta" about(
            "⟨f(t, η), η⟩ = 0: energy is kept",
            "the pairing",
            BOUND,
            "the claim `workless`",
            &[FORCE_LOAD],
        );
    }
    told {
        force_keeps_casimirs "t# eta" about(
            "⟨f(t, η), dC(l'(η))⟩ = 0 for each Casimir function C that is claimed to be kept",
            "dC and l' of the claim",
            BOUND,
            "the claim `keeps`: a Lagrangian and Casimir functions",
            &[FORCE_LOAD],
        );
    }
}

/// dC(l'(η)) of each Casimir function, and the sizes of its terms.
type Gradients<T, const N: usize> = Arc<dyn Fn(&Vector<T, N>) -> Vec<[Vector<T, N>; 2]> + Send + Sync>;

/// The size of the terms that f is the sum of, at velocities of a size.
type Terms<T, const N: usize> = Arc<dyn Fn(&Vector<T, N>) -> T + Send + Sync>;

/// What is known of a force in one scalar.
struct Known<T: Real, const N: usize> {
    kept: Option<Gradients<T, N>>,
    terms: Option<Terms<T, N>>,
}

impl<T: Real, const N: usize> Default for Known<T, N> {
    fn default() -> Self {
        Self { kept: None, terms: None }
    }
}

/// A user's force, with claims. The largest number of a case is that of velocities.
#[doc(hidden)]
pub type UserForce<const N: usize> = Part<ForceLaws<N>>;

/// The laws on forces.
#[derive(Default)]
#[doc(hidden)]
pub struct ForceLaws<const N: usize> {
    dissipates: bool,
    workless: bool,
    double: Known<f64, N>,
    quad: Known<Dd, N>,
}

impl<const N: usize> ForceLaws<N> {
    /// What is known in T.
    fn known<T: Real>(&self) -> Option<&Known<T, N>> {
        let sides: [&dyn Any; 2] = [&self.double, &self.quad];
        sides.into_iter().find_map(|side| side.downcast_ref())
    }
}

fn gradients<T: Real, L, const N: usize>(lagrangian: L, casimirs: Vec<Casimir<T, N>>) -> Option<Gradients<T, N>>
where
    L: Lagrangian<T, N> + Send + Sync + 'static,
{
    Some(Arc::new(move |eta| {
        let momentum = lagrangian.gradient(eta);
        casimirs.iter().map(|casimir| [casimir.gradient(&momentum), casimir.gradient_terms(&momentum)]).collect()
    }))
}

impl<const N: usize> UserForce<N> {
    /// Claims ⟨f, η⟩ ≤ 0.
    pub fn dissipates(mut self) -> Self {
        self.kind.dissipates = true;
        self
    }

    /// Claims ⟨f, η⟩ = 0.
    pub fn workless(mut self) -> Self {
        self.kind.workless = true;
        self
    }

    /// Claims that f keeps these Casimir functions, at the momentum l'(η): Lagrangian and functions in each scalar.
    pub fn keeps_both<L, M>(mut self, double: (L, Vec<Casimir<f64, N>>), quad: (M, Vec<Casimir<Dd, N>>)) -> Self
    where
        L: Lagrangian<f64, N> + Send + Sync + 'static,
        M: Lagrangian<Dd, N> + Send + Sync + 'static,
    {
        self.kind.double.kept = gradients(double.0, double.1);
        self.kind.quad.kept = gradients(quad.0, quad.1);
        self
    }

    /// Says how large the terms are that f is the sum of, for velocities with components of at most those of its argument: where they
    /// cancel, f is rounding of terms of this size.
    pub(in crate::laws) fn summing(
        mut self,
        double: impl Fn(&Vector<f64, N>) -> f64 + Send + Sync + 'static,
        quad: impl Fn(&Vector<Dd, N>) -> Dd + Send + Sync + 'static,
    ) -> Self {
        self.kind.double.terms = Some(Arc::new(double));
        self.kind.quad.terms = Some(Arc::new(quad));
        self
    }
}

impl<const N: usize> Kind for ForceLaws<N> {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const DIMENSION: usize = N;
    const LARGEST: f64 = 4.0;
    const APART: &'static [&'static str] = &["force-derivatives"];

    fn missing(&self, law: &str) -> Option<&'static str> {
        match law {
            "force-dissipates" if !self.dissipates => Some("the force is not said to dissipate"),
            "force-workless" if !self.workless => Some("the force is not said to do no work"),
            "force-keeps-casimirs" if self.double.kept.is_none() => {
                Some("the force is not said to keep Casimir functions")
            }
            _ => None,
        }
    }
}

impl<T: Real, F, const N: usize> Answers<T, ForceLaws<N>> for F
where
    F: Force<T, N> + Send + Sync + 'static,
{
    fn answer(&self, asked: &Asked<'_, ForceLaws<N>>) -> Answer {
        judge(self, asked.kind.known(), asked)
    }
}

/// A force with a fault planted in it.
struct Planted<'a, F> {
    force: &'a F,
    fault: Option<&'a Fault>,
    evaluations: Cell<i64>,
}

impl<T: Real, F: Force<T, N>, const N: usize> Force<T, N> for Planted<'_, F> {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let right = self.force.force(t, eta);
        if FORCE_NAN.size_in(self.fault) > 0.0 && eta[0] > S::zero() {
            return right * S::exact(f64::NAN);
        }
        let evaluations = self.evaluations.get();
        self.evaluations.set(evaluations + 1);
        let right = blend(right, right.add_scalar(S::int(evaluations)), FORCE_STATE.size_in(self.fault));
        let right = blend(right, right.map(|v| S::lift(v.base())), FORCE_CONSTANT.size_in(self.fault));
        let right = blend(right, -right, FORCE_SIGN.size_in(self.fault));
        blend(right, right.add_scalar(S::one()), FORCE_LOAD.size_in(self.fault))
    }

    fn is_zero(&self) -> bool {
        self.force.is_zero() || SAYS_ZERO.size_in(self.fault) > 0.0
    }
}

fn judge<T: Real, F: Force<T, N>, const N: usize>(
    force: &F,
    known: Option<&Known<T, N>>,
    asked: &Asked<'_, ForceLaws<N>>,
) -> Answer {
    let (t, eta) = (asked.case.number::<T>("t")?, asked.case.vector::<T, N>("eta")?);
    let (law, terms) = (asked.law.name, known.and_then(|known| known.terms.as_ref()));
    let planted = Planted { force, fault: asked.fault, evaluations: Cell::new(0) };
    let f = planted.force(t, &eta);
    let floor = 64.0 * N as f64;
    if !f.iter().all(|v| v.all_finite()) {
        return Ok(Measured::Broken(format!("f(t, η) = {}", list(f.iter()))));
    }
    match law {
        "force-finite" => Ok(Measured::exact()),
        "force-deterministic" => {
            let elsewhere = (asked.case.number::<T>("dt")?, asked.case.vector::<T, N>("along")?);
            let _ = planted.force(t + elsewhere.0, &(eta + elsewhere.1));
            let again = planted.force(t, &eta);
            if again == f {
                Ok(Measured::exact())
            } else {
                Ok(Measured::Broken(format!("f(t, η) = {} and then {}", list(f.iter()), list(again.iter()))))
            }
        }
        "force-derivatives" => {
            let along = (asked.case.number::<T>("dt")?, asked.case.vector::<T, N>("along")?);
            // Of the derivative, too: that of a product of k velocities is a sum of k terms.
            let terms = terms.map_or(T::zero(), |terms| terms(&(eta.abs() + along.1.abs())));
            let over = |scale: T| derivatives(&planted, (t, &eta), &f, (along.0, &along.1), scale, terms);
            // Steps for a smooth force, and small against η for one that is not smooth at 0: there the difference over longer steps may look
            // as if it had converged.
            let smooth = over(T::exact(asked.largest / 4.0).max(eta.amax()))?;
            let doubtful = match &smooth {
                Measured::Inconclusive(_) => true,
                Measured::Defect { amplification, floor, .. } => amplification > floor,
                _ => false,
            };
            if !doubtful || eta.amax() == T::zero() {
                return Ok(smooth);
            }
            match (smooth, over(eta.amax())?) {
                (Measured::Inconclusive(_), near) => Ok(near),
                (smooth, Measured::Inconclusive(_)) => Ok(smooth),
                (_, near) => Ok(near),
            }
        }
        "force-zero" => match planted.is_zero() && f.amax() > T::zero() {
            true => Ok(Measured::Broken(format!("`is_zero()`, and f(t, η) = {}", list(f.iter())))),
            false => Ok(Measured::exact()),
        },
        "force-dissipates" | "force-workless" => {
            let power = pair(&f, &eta);
            let gain = if law == "force-workless" { power.abs() } else { power.max(T::zero()) };
            let size = pair(&sizes(&planted, t, &eta, &f, terms), &eta.abs());
            Ok(Measured::defect(gain, size, floor, || format!("⟨f, η⟩ = {:e}", power.to_f64())))
        }
        "force-keeps-casimirs" => {
            let Some(gradients) = known.and_then(|known| known.kept.as_ref()) else {
                return Ok(Measured::NotApplicable("the force is not said to keep Casimir functions".into()));
            };
            let mut measured = Measured::NotApplicable("no Casimir functions are claimed".into());
            for (k, [gradient, terms_of_gradient]) in gradients(&eta).iter().enumerate() {
                let sizes = sizes(&planted, t, &eta, &f, terms);
                let (rate, size) = (pair(&f, gradient), pair(&sizes, terms_of_gradient));
                measured = measured.and(Measured::defect(rate.abs(), size, floor, || {
                    format!("Casimir function {k} changes at {:e}", rate.to_f64())
                }));
            }
            Ok(measured)
        }
        _ => asked.unknown("forces"),
    }
}

/// |f_a| + Σ_b |∂f_a/∂η^b| |η^b|, how far relative changes of η move a component of f, and the terms of f where they are known: what
/// rounding is relative to, also where f is small because its terms cancel.
fn sizes<T: Real, F: Force<T, N>, const N: usize>(
    f: &Planted<'_, F>,
    t: T,
    eta: &Vector<T, N>,
    value: &Covector<T, N>,
    terms: Option<&Terms<T, N>>,
) -> Covector<T, N> {
    let mut sizes = value.abs().add_scalar(terms.map_or(T::zero(), |terms| terms(&eta.abs())));
    for b in 0..N {
        let along = along(eta, b);
        let slopes = f.force.force(Dual::constant(t), &along).map(|v| v.eps.abs() * eta[b].abs());
        // A force that is not smooth here has no slope.
        sizes += slopes.map(|slope| if slope.all_finite() { slope } else { T::zero() });
    }
    sizes
}

fn derivatives<T: Real, F: Force<T, N>, const N: usize>(
    f: &Planted<'_, F>,
    (t, eta): (T, &Vector<T, N>),
    value: &Covector<T, N>,
    (dt, along): (T, &Vector<T, N>),
    typical: T,
    terms: T,
) -> Answer {
    let dual = |re: T, eps: T| Dual { re, eps };
    let floor = 64.0 * N as f64;
    let moved = moving(eta, along);
    let found = f.force(dual(t, dt), &moved);
    let slopes = found.map(|v| v.eps);
    // Duals of duals: the value and both derivatives again.
    let time = Dual { re: dual(t, dt), eps: Dual::constant(dt) };
    let second = f.force(time, &moving(&moved, &along.map(Dual::constant)));
    let near = |what: &'static str, a: Covector<T, N>, b: &Covector<T, N>, size: T| {
        let allowed = T::exact(256.0 * floor) * T::unit_roundoff() * size;
        let off = off(&a, b);
        if off == T::zero() || off <= allowed { Ok(()) } else { Err(Measured::Broken(what.into())) }
    };
    let (size, steep) = (value.amax(), slopes.amax() + value.amax());
    let whole = steep + terms;
    near("f differs on dual numbers", found.map(|v| v.re), value, whole)?;
    near("f differs on duals of duals", second.map(|v| v.re.re), value, whole)?;
    near("the derivative differs on duals of duals", second.map(|v| v.re.eps), &slopes, whole)?;
    near("the derivative differs on duals of duals", second.map(|v| v.eps.re), &slopes, whole)?;
    let length = along.amax();
    if length == T::zero() && dt == T::zero() {
        return Ok(Measured::exact());
    }
    // A step that is small against the typical velocity and against a time of 1.
    let by_eta = if length == T::zero() { T::one() } else { typical / length };
    let scale = if dt == T::zero() { by_eta } else { by_eta.min(T::one() / dt.abs()) };
    let mut measured = Measured::exact();
    for a in 0..N {
        let along = |s: T| {
            let moved = f.force.force(t + dt * s, &(eta + along * s));
            moved.iter().all(|v| v.all_finite()).then(|| pair(&moved, &basis_vector(a)))
        };
        let slope = slope(along, scale, whole).ok_or(Measured::NotApplicable("f is not finite nearby".into()))?;
        measured = measured.and(compared(slopes[a], &slope, steep.max(size), terms, floor, "f along a direction"));
    }
    Ok(measured)
}
