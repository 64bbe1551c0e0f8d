//! The derivatives of a step and of a run, forward and reverse.

use super::CaseLaw;
use super::configuration::{What, configured};
use super::planted::retraction::Plant;
use super::precision::{CEILING, Measured, SAMPLES, alone, compare, moved};
use super::probe::{Probe, stream};
use super::question::law;
use super::step::{End, displaced, outside};
use crate::algebra::{Covector, Vector};
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::derivative::{Derivative, Gradient, InputGradient, Linearised, Parameters, Variation};
use crate::integrators::{OneStep, State, StepError, Variational};
use crate::laws::unbuilt;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::force::{AnyForce, Driven, Factor};
use crate::mechanics::given::{GivenForce, UntypedForce};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{AnyRetraction, Retraction, TangentPoint};
use crate::scalar::{Dd, Real, Scalar, larger, max_abs};
use crate::system::{Case, System};
use nalgebra::ComplexField;

/// δμ' as it is seen from the start.
const UNTURNED: Fault =
    Fault::new("variation-unturned", "δμ' = δm Ad_{τ(ξ)}, without ad*_ω μ'", "algebras that are not abelian");
/// ζ is not brought to the end.
const NOT_CARRIED: Fault =
    Fault::new("variation-not-carried", "ζ' = ζ + ω, without Ad_{τ(ξ)}⁻¹ on ζ", "algebras that are not abelian");
/// Explicit time is forgotten.
const NO_TIME: Fault = Fault::new("variation-without-time", "∂/∂t = 0", "systems that depend on the time");
/// The stages do not move with h.
const NO_STEP: Fault = Fault::new("variation-without-step", "∂/∂h = 0", "every system that moves");
/// Half of the digits.
const DIFFERENCED: Fault =
    Fault::new("differenced", "the derivative by a one-sided difference of the step, over √u", "every system");
/// The reverse mode alone is wrong.
const ADJOINT: Fault = Fault::new(
    "adjoint-not-carried",
    "the covector at the end goes to the start without Ad_{τ(ξ)}⁻¹",
    "algebras that are not abelian",
);

const FAULTS: &[Fault] = &[UNTURNED, NOT_CARRIED, NO_TIME, NO_STEP, DIFFERENCED, ADJOINT];

const SOURCE: &str =
    "the implicit function theorem on the stage equations; Hairer, Lubich and Wanner 2006, §VI.4 and §VI.9";
const ORACLE: &str = "central differences of the step in 32 digits, extrapolated, for the tangent; the tangent for the adjoint, which is by the \
                      transpose of the matrices of the steps";
const BOUND: &str = "in 32 digits (one step) what the differences are known to; in f64 2⁴ (2⁴ n s N c + κ) u in n steps, c the condition number \
                     of ∂r/∂H, κ what changes of the inputs by one unit make of the derivative; of the adjoint two precisions (one step)";

/// Steps of a run: two segments between checkpoints.
const RUN: usize = 4;

/// The laws of this file.
pub const fn laws() -> &'static [CaseLaw] {
    &[
        law!(Law {
            name: "derivative-step",
            statement: "the derivative of (g', μ') along a variation of (g, μ, t, h) and of factors of f and L is that of the map of a step, \
                            and the adjoint is its transpose",
            source: SOURCE,
            oracle: ORACLE,
            bound: BOUND,
            needs: "a group; a smooth force",
            cost: Cost::Moderate,
            faults: FAULTS,
            cases: |cases| cases.with_group().main_dimensions().smooth(),
            check: |case, fault| judge(case, fault, 1).unwrap_or_else(|verdict| verdict),
        }),
        law!(Law {
            name: "derivative-run",
            statement: "the derivative of the end of a run of four steps by its start, t, h and factors of f and L is that of the map, forward and \
                            in reverse with checkpoints",
            source: "the chain rule; Griewank and Walther 2008, ch. 12",
            oracle: ORACLE,
            bound: BOUND,
            needs: "a group; a smooth force",
            cost: Cost::Heavy,
            faults: FAULTS,
            cases: |cases| cases.with_group().main_dimensions().smooth(),
            check: |case, fault| judge(case, fault, RUN).unwrap_or_else(|verdict| verdict),
        }),
    ]
}

fn judge(case: &Case, fault: Option<&Fault>, steps: usize) -> Result<Verdict, Verdict> {
    let salt = stream::DERIVATIVE;
    let case = match Probe::new(case, salt).next() & 1 {
        0 => case.clone(),
        _ => configured(case, What::All),
    };
    let probe = || Probe::new(&case, salt);
    let double = numbers::<f64>(&case, probe(), fault, steps)?;
    let quad = numbers::<Dd>(&case, probe(), fault, steps)?;
    // |a − b| in units of round-off of f64.
    let unit = f64::unit_roundoff() * double.size;
    let off = |a: &[Dd]| {
        let off = a.iter().zip(&quad.variation).fold(0.0_f64, |off, (a, b)| larger(off, (*a - *b).abs().to_f64()));
        if off == 0.0 { off } else { off / unit }
    };
    let defect = off(&double.variation.iter().map(|v| Dd::exact(*v)).collect::<Vec<_>>());
    let floor = double.floor + if quad.known > 0.0 { quad.known / unit } else { 0.0 };
    let mut bound = CEILING * floor;
    if defect > bound {
        let changed = (0..SAMPLES)
            .filter_map(|sample| Some(off(&numbers(&moved(&case, sample), probe(), None, steps).ok()?.variation)));
        bound = CEILING * (floor + changed.fold(0.0, larger));
    }
    let rounded = Verdict::judge(defect, bound, || {
        format!("f64: {defect:.3e} units of round-off from the derivative in 32 digits; it is {:?}", double.variation)
    });
    let others = match quad.tangent {
        Some([transposed, differenced]) => compare(double.transposed, transposed).and(alone(32, differenced)),
        None => alone(16, double.transposed),
    };
    Ok(others.and(rounded))
}

/// The derivative of a run along a direction that is drawn.
fn numbers<T: Real>(case: &Case, mut probe: Probe, fault: Option<&Fault>, steps: usize) -> Result<Numbers<T>, Verdict> {
    let system = &case.main::<T>(&Plant(fault)).map_err(|e| unbuilt(&e))?;
    let along = Direction::drawn(&mut probe, system.dimension, system.step);
    let functional = Gradient { attitude: probe.covector(), momentum: probe.vector() };
    Run { system, along, fault, steps }.numbers(&functional).map_err(|said| alone(32, said))
}

/// The factors of f and of L, at 1.
struct Factors<'a, T: Real, const N: usize, const D: usize>(&'a System<T, N, D>);

impl<T: Real, const N: usize, const D: usize> Parameters<T, N> for Factors<'_, T, N, D> {
    fn count(&self) -> usize {
        2
    }

    fn force(&self, k: usize, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Covector<T, N> {
        match k {
            0 => self.0.force.force_at(t, g, eta),
            _ => self.0.lagrangian.configuration_gradient(t, g, eta),
        }
    }

    fn momentum(&self, k: usize, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Covector<T, N> {
        match k {
            0 => Covector::zeros(),
            _ => self.0.lagrangian.gradient_at(t, g, eta),
        }
    }
}

/// A change of everything that a run starts from.
#[derive(Clone, Copy)]
struct Direction<T: Real, const N: usize> {
    state: Variation<T, N>,
    time: T,
    step: T,
    factors: [T; 2],
}

impl<T: Real, const N: usize> Direction<T, N> {
    /// Spectators stay as they are. The change of h is relative to h.
    fn drawn(probe: &mut Probe, n: usize, h: T) -> Self {
        let mut state = Variation { attitude: probe.vector::<T, N>(), momentum: probe.covector::<T, N>() };
        state.attitude.iter_mut().skip(n).for_each(|v| *v = T::zero());
        state.momentum.iter_mut().skip(n).for_each(|v| *v = T::zero());
        Self { state, time: probe.unit(), step: probe.unit::<T>() * h, factors: [probe.unit(), probe.unit()] }
    }

    /// Its components, one after the other.
    fn components(&self) -> Vec<T> {
        let Self { state, time, step, factors } = self;
        state.attitude.iter().chain(state.momentum.iter()).chain([time, step]).chain(factors).copied().collect()
    }

    /// The derivative along it, and the size of the terms of that.
    fn through(&self, of: &Derivative<T, N>) -> Result<(Variation<T, N>, T), StepError> {
        let terms = self.components().into_iter().zip(of.matrix().column_iter());
        let size = terms.fold(T::zero(), |sum, (value, column)| sum + column.amax() * value.abs());
        Ok((of.tangent(&self.state, self.time, self.step, &self.factors)?, size))
    }

    /// ⟨gradient, direction⟩, and the size of its terms.
    fn against(&self, InputGradient { state, time, step, parameters }: &InputGradient<T, N>) -> (T, T) {
        let gradient = state.attitude.iter().chain(state.momentum.iter()).chain([time, step]).chain(parameters);
        let terms = gradient.zip(self.components()).map(|(&a, b)| a * b);
        terms.fold((T::zero(), T::zero()), |(sum, size), term| (sum + term, size + term.abs()))
    }
}

/// What a derivative is, and what it should be.
struct Numbers<T> {
    /// (ζ', δμ') along the direction.
    variation: Vec<T>,
    /// The size of the terms of which it is the sum.
    size: f64,
    /// What the count of operations allows, in units of round-off.
    floor: f64,
    /// The adjoint against the tangent.
    transposed: Measured,
    /// What the variation is off by besides rounding.
    known: f64,
    /// In 32 digits the adjoint against the tangent, and the tangent against differences; `None` where the variation is by differences.
    tangent: Option<[Measured; 2]>,
}

/// The displacement of the differences: they are extrapolated from it and its double, and their error is its fourth power.
const DISPLACEMENT: f64 = 1.0 / 1_048_576.0;

fn values<T: Real, const N: usize>(variation: &Variation<T, N>) -> Vec<T> {
    variation.attitude.iter().chain(variation.momentum.iter()).copied().collect()
}

fn distance<T: Real, const N: usize>(a: &Variation<T, N>, b: &Variation<T, N>) -> T {
    larger(max_abs(&(a.attitude - b.attitude)), max_abs(&(a.momentum - b.momentum)))
}

/// A run and what is asked of it.
struct Run<'a, T: Real, const N: usize, const D: usize> {
    system: &'a System<T, N, D>,
    along: Direction<T, N>,
    fault: Option<&'a Fault>,
    steps: usize,
}

/// The method with its derivatives, on a system.
type Method<'a, T, const N: usize, const D: usize> =
    Linearised<T, N, D, &'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>, Factors<'a, T, N, D>>;

/// The forward mode.
struct Forward<T: Real, const N: usize, const D: usize> {
    /// All states, the last one is the end.
    states: Vec<State<T, N, D>>,
    variation: Variation<T, N>,
    size: T,
    condition: T,
}

impl<'a, T: Real, const N: usize, const D: usize> Run<'a, T, N, D> {
    fn share(&self, fault: &Fault) -> T {
        T::exact(fault.size_in(self.fault))
    }

    fn numbers(&self, functional: &Gradient<T, N>) -> Result<Numbers<T>, Measured> {
        let precise = T::unit_roundoff().to_f64() < f64::unit_roundoff();
        if precise && self.steps > 1 {
            // Derivatives of many steps in 32 digits take seconds.
            let end = End::of(self.system, &self.moved(T::zero())?)?;
            let (variation, known) = self.by_differences(&end)?;
            let (transposed, variation) = (Measured::exact(), values(&variation));
            let known = known.to_f64();
            return Ok(Numbers { variation, size: 0.0, floor: 0.0, transposed, known, tangent: None });
        }
        let mut method = Linearised::new(self.system.scheme(), Factors(self.system));
        let forward = self.forward(&mut method)?;
        let end = End::of(self.system, &forward.states[self.steps])?;
        let mut variation = forward.variation;
        let share = self.share(&DIFFERENCED);
        if share > T::zero() {
            let away = T::unit_roundoff().sqrt();
            let wrong = end.difference(&self.moved(away)?, &forward.states[self.steps], away);
            variation.attitude += (wrong.attitude - variation.attitude) * share;
            variation.momentum += (wrong.momentum - variation.momentum) * share;
        }
        let floor = self.floor() * forward.condition.to_f64().max(1.0);
        let adjoint = self.reverse(&mut method, &forward.states, functional)?;
        let (there, (here, extent)) = (functional.along(&variation), self.along.against(&adjoint));
        let largest = functional.attitude.amax().max(functional.momentum.amax());
        let terms = (largest * forward.size * T::int(2 * N as i64)).max(extent);
        let transposed = Measured::defect((there - here).abs(), terms, floor, || {
            format!("the tangent gives {:e}, the adjoint {:e}", there.to_f64(), here.to_f64())
        });
        let tangent = match precise {
            false => None,
            true => {
                let (best, known) = self.by_differences(&end)?;
                let known = known + T::unit_roundoff() * T::exact(floor) * forward.size;
                let defect = distance(&variation, &best);
                let differenced = Measured::within(defect, known, || {
                    format!("the derivative is {:e} from differences, known to {:e}", defect.to_f64(), known.to_f64())
                });
                Some([transposed.clone(), differenced])
            }
        };
        let size = forward.size.to_f64();
        Ok(Numbers { variation: values(&variation), size, floor, transposed, known: 0.0, tangent })
    }

    /// What the count of operations allows, in units of round-off.
    fn floor(&self) -> f64 {
        16.0 * (self.steps * self.system.tableau.stages() * self.system.dimension) as f64
    }

    /// The derivative by central differences, extrapolated, and what it is known to.
    fn by_differences(&self, end: &End<'_, T, N, D>) -> Result<(Variation<T, N>, T), StepError> {
        let delta = T::exact(DISPLACEMENT);
        let central = |k: i64| {
            let away = delta * T::int(k);
            Ok::<_, StepError>(end.difference(&self.moved(away)?, &self.moved(-away)?, away + away))
        };
        let [first, second, third] = [central(1)?, central(2)?, central(4)?];
        let extrapolated = |fine: &Variation<T, N>, coarse: &Variation<T, N>| Variation {
            attitude: (fine.attitude * T::int(4) - coarse.attitude) / T::int(3),
            momentum: (fine.momentum * T::int(4) - coarse.momentum) / T::int(3),
        };
        let (best, next) = (extrapolated(&first, &second), extrapolated(&second, &third));
        let extent = end.size * (T::one() + end.back.amax() * T::int(D as i64));
        let rounding = T::unit_roundoff() * T::exact(self.floor()) * extent / delta;
        Ok((best, distance(&best, &next) + rounding))
    }

    /// The end of the run from a start that is moved along the direction. With L and f multiplied by m and p, the motion of μ is m times that of μ/m
    /// with L and f p/m.
    fn moved(&self, by: T) -> Result<State<T, N, D>, StepError> {
        let System { lagrangian, force, retraction, tableau, step, .. } = self.system;
        let Direction { state: along, time, step: stretch, factors } = &self.along;
        let [push, mass] = factors.map(|factor| T::one() + factor * by);
        // Without its type, so that the method is compiled once.
        let force = UntypedForce::new::<N>(Driven::new(force.clone(), Factor(push / mass)));
        let force = AnyForce::Given(GivenForce::new(force, N, D));
        let mut method = Variational::new(lagrangian, &force, retraction, tableau.clone());
        let mut state = displaced(self.system, along, by)?;
        state.time += *time * by;
        state.momentum /= mass;
        for _ in 0..self.steps {
            method.step(&mut state, *step + *stretch * by)?;
        }
        state.momentum *= mass;
        Ok(state)
    }

    /// The forward mode, step by step where a fault is planted or there is one step, else by [`Linearised::sensitivity`]; then the condition
    /// is that of the first step.
    fn forward(&self, method: &mut Method<'a, T, N, D>) -> Result<Forward<T, N, D>, StepError> {
        let (h, along) = (self.system.step, &self.along);
        let mut states = vec![self.system.state.clone()];
        if self.steps > 1 && self.fault.is_none() {
            method.step(&mut states[0].clone(), h)?;
            let condition = method.condition();
            let mut end = states[0].clone();
            let keep = |_: usize, state: &State<T, N, D>, _: &Derivative<T, N>| states.push(state.clone());
            let whole = method.sensitivity(&mut end, h, self.steps, keep).map_err(|e| e.source)?;
            let (variation, size) = along.through(&whole)?;
            return Ok(Forward { states, variation, size, condition });
        }
        let (mut variation, mut condition) = (along.state, T::one());
        let mut size = T::zero();
        for k in 0..self.steps {
            let (before, mut state) = (variation, states[k].clone());
            let (_, step) = method.step(&mut state, h)?;
            let time = (along.time + along.step * T::int(k as i64)) * (T::one() - self.share(&NO_TIME));
            let stretch = along.step * (T::one() - self.share(&NO_STEP));
            variation = step.tangent(&before, time, stretch, &along.factors)?;
            size = size.max(along.through(step)?.1);
            condition = condition.max(method.condition());
            let engine = method.method();
            let back =
                engine.retraction().at(engine.increment()).map_err(|source| outside(self.system, source))?.ad_inv();
            let carried = back * before.attitude;
            let turned = self.system.algebra.coad(&(variation.attitude - carried), &state.momentum);
            variation.momentum -= turned * self.share(&UNTURNED);
            variation.attitude += (before.attitude - carried) * self.share(&NOT_CARRIED);
            states.push(state);
        }
        Ok(Forward { states, variation, size, condition })
    }

    /// The reverse mode, likewise.
    fn reverse(
        &self,
        method: &mut Method<'a, T, N, D>,
        states: &[State<T, N, D>],
        functional: &Gradient<T, N>,
    ) -> Result<InputGradient<T, N>, StepError> {
        let (h, share) = (self.system.step, self.share(&ADJOINT));
        if self.steps > 1 && share == T::zero() {
            let last = |k, _: &State<T, N, D>| if k == self.steps { *functional } else { Gradient::zero() };
            return method.gradient(&states[0], h, self.steps, last).map_err(|e| e.source);
        }
        let mut all = InputGradient::of(*functional, 2);
        for k in (0..self.steps).rev() {
            let mut state = states[k].clone();
            let end = all.state;
            let of_step = method.step(&mut state, h)?.1.adjoint(&end)?;
            let engine = method.method();
            let back =
                engine.retraction().at(engine.increment()).map_err(|source| outside(self.system, source))?.ad_inv();
            all.state = of_step.state;
            all.state.attitude += (end.attitude - end.attitude * back) * share;
            all.time += of_step.time;
            all.step += of_step.step + of_step.time * T::int(k as i64);
            all.parameters.iter_mut().zip(&of_step.parameters).for_each(|(sum, value)| *sum += *value);
        }
        Ok(all)
    }
}
