//! Laws of accuracy: values in `f64` against those in 32 digits.
//!
//! Identities judged at two precisions (`precision.rs`) see errors that do not shrink with round-off. An unstable
//! algorithm loses as many digits in one precision as in the other, and the amplification of rounding in 32 digits then excuses that
//! in `f64`. Here the values themselves are compared, and what they may differ by is measured: what a change of the input by one unit
//! of round-off makes of them, in 32 digits.

use super::planted::retraction::{DIGITS_LOST, LATE_SERIES, LATER_SERIES, LOG_NEAR_PI, Plant};
use super::precision::{AGREEMENT, Measured, alone};
use super::probe::{Probe, stream};
use super::question::law;
use super::retraction::within_half_turn;
use super::step::subject;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Vector};
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::OneStep;
use crate::laws::unbuilt;
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dd, Real, Scalar};
use crate::system::{Case, System, Visitor};
use nalgebra::DMatrix;
use std::fmt::Debug;

const ORACLE: &str = "the same functions in 32 digits";

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "retraction-accuracy",
                statement: "τ(ξ), τ⁻¹(τ(ξ)), dτ_ξ, dτ_ξ⁻¹, ddτ_ξ(η, ·) and Ad_{τ(ξ)} in f64 are those in 32 digits, rounded",
                source: "Higham 2002, §1.5 and §1.6: forward errors of a stable algorithm",
                oracle: ORACLE,
                bound: "2³ N D u of a value, times the condition of dτ for dτ⁻¹, ddτ and Ad, of |dτ⁻¹| |g| |g⁻¹| for τ⁻¹, and of what a \
                            change of ξ by u makes of it, times the condition of the basis",
                needs: "",
                faults: &[DIGITS_LOST, LATE_SERIES, LATER_SERIES, LOG_NEAR_PI],
                cases: |cases| cases,
                check: |case, fault| judge(case, fault, Which::Retraction),
            }),
            law!(Law {
                name: "step-accuracy",
                statement: "one step in f64 is that in 32 digits, rounded, also where h is tiny",
                source: "Higham 2002, §1.5 and §1.6: forward errors of a stable algorithm",
                oracle: ORACLE,
                bound: "2³ N D u of μ' and g', and of what a change of μ by u makes of them times the condition of the basis",
                needs: "",
                cost: Cost::Expensive,
                faults: &[DIGITS_LOST],
                cases: |cases| cases.main_dimensions(),
                check: |case, fault| judge(case, fault, Which::Step),
            }),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Retraction,
    Step,
}

/// A value, and how far small changes of the input move it.
struct Value<T> {
    what: &'static str,
    entries: Vec<T>,
    /// By how much rounding is multiplied: 1, or the condition of a matrix that is inverted.
    condition: T,
    moved: T,
}

impl<T: Real> Value<T> {
    fn new(what: &'static str, entries: &[T], condition: T) -> Self {
        Self { what, entries: entries.to_vec(), condition, moved: T::zero() }
    }
}

/// The values, and the multiple of u that is allowed.
struct Values<T> {
    list: Vec<Value<T>>,
    floor: f64,
    /// The input, for the witness.
    at: Vec<f64>,
    /// The factors of ξ at which the logarithm is taken.
    stretches: Vec<f64>,
}

#[derive(Clone, Copy)]
struct Evaluate<'a> {
    case: &'a dyn Debug,
    which: Which,
    fault: Option<&'a Fault>,
    /// Those of [`Values::stretches`] in the other precision. An eigenvalue may be so badly conditioned that the two would not find the same.
    stretches: Option<&'a [f64]>,
}

impl<T: Real> Visitor<T> for Evaluate<'_> {
    type Output = Result<Values<T>, Measured>;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Self::Output {
        match self.which {
            Which::Retraction => self.retraction(&system),
            Which::Step => self.step(&system),
        }
    }
}

/// At how many elements along ξ the logarithm is taken: few are near a half turn.
const LOGARITHMS: usize = 6;

/// In how many random directions the input is changed.
const DIRECTIONS: usize = 2;

impl Evaluate<'_> {
    fn retraction<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
    ) -> Result<Values<T>, Measured> {
        let mut probe = Probe::new(self.case, stream::ACCURACY);
        let size = probe.power_of_two::<f64>(-30, 2);
        let x = probe.dense::<T, N>(size);
        let y = probe.vector::<T, N>();
        let tau = &system.retraction;
        let near_half_turns = || {
            system
                .group
                .iter()
                .flat_map(|group| (0..LOGARITHMS).map(|k| within_half_turn(group, &x, &(self.case, k)).to_f64()))
        };
        let stretches: Vec<f64> = self.stretches.map_or_else(|| near_half_turns().collect(), <[f64]>::to_vec);
        let at = |x: &Vector<T, N>| -> Result<Vec<Value<T>>, RetractionError> {
            let point = tau.at(x)?;
            let solved = point.d().amax() * point.d_inv().amax() * T::int(system.dimension as i64);
            let mut values = vec![
                Value::new("dτ", point.d().as_slice(), T::one()),
                Value::new("dτ⁻¹", point.d_inv().as_slice(), solved),
                Value::new("ddτ", point.dd(&y).as_slice(), solved),
                Value::new("Ad", point.ad().as_slice(), solved),
            ];
            match tau.tau(x) {
                Ok(g) => values.push(Value::new("τ", g.as_slice(), T::one())),
                Err(RetractionError::NoGroup { .. }) => {}
                Err(error) => return Err(error),
            }
            for stretch in &stretches {
                values.push(logarithm(tau, &(x * T::exact(*stretch)))?);
            }
            Ok(values)
        };
        let outside = |error: RetractionError| match error {
            RetractionError::NotFinite { .. } => Measured::Broken(error.to_string()),
            _ => Measured::NotApplicable("the displacement is outside the domain".into()),
        };
        let nearby = std::array::from_fn(|_| x + probe.vector::<T, N>() * (x.amax() * ulp()));
        let mut list = values(at, &x, nearby).map_err(outside)?;
        for value in list.iter_mut().filter(|value| value.what == "ddτ") {
            // Terms of an odd map of the argument, of the size of x, which may cancel: rounding is relative to them.
            value.moved += x.amax() * y.amax() * ulp();
        }
        Ok(Values {
            list,
            floor: 8.0 * system.products() as f64,
            at: x.iter().map(|v| v.to_f64()).collect(),
            stretches,
        })
    }

    fn step<T: Real, const N: usize, const D: usize>(&self, system: &System<T, N, D>) -> Result<Values<T>, Measured> {
        let mut probe = Probe::new(self.case, stream::ACCURACY);
        let h = system.step * probe.power_of_two::<T>(-24, 0);
        let mut method = subject(system, self.fault);
        let at = |mu: &Covector<T, N>| -> Result<Vec<Value<T>>, Measured> {
            let mut state = system.state.clone();
            state.momentum = *mu;
            method.step(&mut state, h)?;
            Ok(vec![
                Value::new("μ'", state.momentum.as_slice(), T::one()),
                Value::new("g'", state.attitude.as_slice(), T::one()),
            ])
        };
        let mu = system.state.momentum;
        let nearby = std::array::from_fn(|_| mu + probe.covector::<T, N>() * (mu.amax() * ulp()));
        Ok(Values {
            list: values(at, &mu, nearby)?,
            floor: 8.0 * system.products() as f64,
            at: mu.iter().map(|v| v.to_f64()).chain([h.to_f64()]).collect(),
            stretches: Vec::new(),
        })
    }
}

/// τ⁻¹(τ(x)), nothing where it is not defined, with its condition: rounding of g = τ(x) by u moves it by |dτ⁻¹| |g⁻¹| |g| u.
fn logarithm<T: Real, const N: usize, const D: usize>(
    tau: &impl Retraction<T, N, D>,
    x: &Vector<T, N>,
) -> Result<Value<T>, RetractionError> {
    let (g, back) = (tau.tau(x)?, tau.tau(&-x)?);
    let Ok(found) = tau.tau_inv(&g) else { return Ok(Value::new("τ⁻¹", &[], T::one())) };
    let moved = tau.at(&found)?.d_inv().amax() * g.amax() * back.amax();
    Ok(Value::new("τ⁻¹", found.as_slice(), T::one() + moved / found.amax()))
}

/// The unit round-off of `f64`.
fn ulp<T: Real>() -> T {
    T::exact(f64::EPSILON / 2.0)
}

/// The values at an input, with how far those at inputs nearby are off them.
fn values<T: Real, X, E>(
    mut at: impl FnMut(&X) -> Result<Vec<Value<T>>, E>,
    input: &X,
    nearby: [X; DIRECTIONS],
) -> Result<Vec<Value<T>>, E> {
    let moved = nearby.iter().map(&mut at).collect::<Result<Vec<_>, E>>()?;
    let mut here = at(input)?;
    for (k, value) in here.iter_mut().enumerate() {
        for there in moved.iter().filter_map(|there| there.get(k)) {
            let pairs = there.entries.iter().zip(&value.entries);
            value.moved = pairs.fold(value.moved, |far, (a, b)| far.max((*a - *b).abs()));
        }
    }
    Ok(here)
}

fn judge<S: Source>(source: &S, fault: Option<&Fault>, which: Which) -> Verdict {
    let case: &dyn Debug = source;
    let evaluate = Evaluate { case, which, fault, stretches: None };
    let double = source.visit::<f64, _>(&Plant(fault), evaluate);
    let stretches = double.iter().flatten().next().map(|values| &values.stretches[..]);
    let quad = source.visit::<Dd, _>(&Plant(fault), Evaluate { stretches, ..evaluate });
    match (double, quad) {
        (Ok(Ok(double)), Ok(Ok(quad))) => alone(16, compared(&double, &quad, condition(source.case()))),
        (Ok(Err(measured)), _) | (_, Ok(Err(measured))) => alone(16, measured),
        (Err(e), _) | (_, Err(e)) => unbuilt(&e),
    }
}

/// |B| |B⁻¹| of the basis of a case; 1 without one.
fn condition(case: &Case) -> f64 {
    let Some(basis) = &case.algebra.basis else { return 1.0 };
    let n = basis.len();
    let entry = |a: usize, b: usize| basis.get(b).and_then(|row| row.get(a)).and_then(|v| v.eval::<f64>().ok());
    let matrix = DMatrix::from_fn(n, n, |a, b| entry(a, b).unwrap_or(f64::NAN));
    matrix.clone().try_inverse().map_or(f64::INFINITY, |inverse| matrix.norm() * inverse.norm())
}

/// The worst of the values, relative to what is allowed.
fn compared(double: &Values<f64>, quad: &Values<Dd>, condition: f64) -> Measured {
    let mut worst = Measured::NotApplicable("there are no values".into());
    for (mine, exact) in double.list.iter().zip(&quad.list) {
        let mut size = 0.0_f64;
        let mut defect = 0.0_f64;
        for (a, b) in mine.entries.iter().zip(&exact.entries) {
            let off = (Dd::exact(*a) - *b).to_f64().abs();
            if !off.is_finite() {
                return Measured::Broken(format!("{} is {a:e} in f64, {:e} in 32 digits", mine.what, b.to_f64()));
            }
            size = size.max(b.to_f64().abs());
            defect = defect.max(off);
        }
        let allowed = size * exact.condition.to_f64() + exact.moved.to_f64() / (f64::EPSILON / 2.0) * condition;
        let lost = (defect / (f64::EPSILON / 2.0) / allowed).log10();
        // The floor is all that is allowed: `alone` adds its margin.
        worst = worst.and(Measured::defect(defect, allowed, double.floor / AGREEMENT, || {
            format!(
                "{} has lost {lost:.1} of 16 digits more than the problem loses: an unstable algorithm, a series that is cut or \
                 switched to a closed form at the wrong place, or a tolerance; at {:?}",
                mine.what, double.at
            )
        }));
    }
    worst
}
