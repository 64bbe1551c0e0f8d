//! Laws of the extremal action of a tableau.

use super::super::integrators::refused as step_refused;
use super::super::planted::blend_scalar;
use super::super::precision::{Measured, settle_main_small};
use super::super::probe::{Probe, stream};
use super::super::subjects::PlantedForced;
use super::super::{CaseLaw, Source};
use super::{
    ANTISYMMETRIC, ANTISYMMETRIC_FAULTS, ANTISYMMETRIC_ORACLE, ANTISYMMETRIC_SOURCE, CONJUGATE, DOUBLED, NO_U, Planted,
    U_RIGHT, U_SIGN, V_RIGHT, VALUE, antisymmetry, compare, inverse, outside, refused,
};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::discrete::legendre::{Momenta, flow};
use crate::discrete::{DiscreteLagrangian, StageLagrangian, Triple};
use crate::group::LieGroup;
use crate::harness::{Cost, Fault};
use crate::integrators::{Doubled, DoubledState, OneStep, Variational};
use crate::mechanics::Force;
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::Forced;
use crate::retraction::Retraction;
use crate::scalar::Real;
use crate::system::{System, Visitor};
use crate::tableau::Tableau;
use proptest::strategy::Strategy;
use std::fmt::Debug;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            CaseLaw {
                name: "discrete-slopes",
                statement: "the slopes of the extremal action: ∂l_d/∂v = θ, ∂l_d/∂w = φ, ∂l_d/∂U at fixed stages; L* = Ad* R*",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5, before (5.2), and §5.2",
                oracle: "differences of the extremal values, each with its own stages, and Ad by conjugation of matrices",
                bound: "two precisions; rounding of V moves values by p u, p a slope: floor 2⁶ s N p u/ε, ε = 2⁻¹² (f64), 2⁻²⁴ (dd)",
                cost: Cost::Cheap,
                faults: &[VALUE, V_RIGHT, U_RIGHT, DOUBLED],
                cases: |cases| cases.main_dimensions().with_group().forced().boxed(),
                check: |case, fault| settle_main_small(case, fault, Check { case, fault, which: Which::Slopes }, 3),
            },
            CaseLaw {
                name: "doubled-step-generated",
                statement: "along a doubled step off the units F⁻l_d(V, U, W) = (λ, U, μ) and F⁺l_d(V, U, W) = (λ', U', μ')",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5, F± after Prop 5.1, and §5.2",
                oracle: "the doubled integrator, from the stage equations; l_d has only values, τ and dτ",
                bound: "two precisions; floor 2⁹ s N u: two solves, of momenta that rounding of V moves by p u/|v|",
                cost: Cost::Cheap,
                faults: &[V_RIGHT, U_RIGHT, NO_U, U_SIGN, DOUBLED, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced().boxed(),
                check: |case, fault| settle_main_small(case, fault, Check { case, fault, which: Which::Generated }, 4),
            },
            CaseLaw {
                name: "discrete-antisymmetry",
                statement: ANTISYMMETRIC,
                source: ANTISYMMETRIC_SOURCE,
                oracle: ANTISYMMETRIC_ORACLE,
                bound: "two precisions; floor 2⁶ s N u of the momenta, which rounding of V and W is multiplied by",
                cost: Cost::Cheap,
                faults: ANTISYMMETRIC_FAULTS,
                cases: |cases| cases.main_dimensions().with_group().forced().boxed(),
                check: |case, fault| {
                    settle_main_small(case, fault, Check { case, fault, which: Which::Antisymmetry }, 4)
                },
            },
            CaseLaw {
                name: "discrete-flow",
                statement: "the flow F_{l_d} takes the displacements of one doubled step off the units to those of the next",
                source: "Martín de Diego and Sato Martín de Almagro 2019, (5.2) and §5.2",
                oracle: "the doubled integrator; the flow knows momenta only through F±",
                bound: "two precisions; floor 2¹⁰ s N u of the displacements: nested solves, and two steps",
                cost: Cost::Expensive,
                faults: &[NO_U, U_SIGN, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced().boxed(),
                check: |case, fault| settle_main_small(case, fault, Check { case, fault, which: Which::Flow }, 2),
            },
            CaseLaw {
                name: "discrete-restricted-step",
                statement: "F_{l_d} takes (V, e, V) to a unit, and there it is the restricted step",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.3 and §5.2",
                oracle: "two steps of the restricted integrator, which knows neither U nor the second copy",
                bound: "two precisions; floor 2¹⁰ s N u of the displacements: nested solves, and two steps",
                cost: Cost::Expensive,
                faults: &[NO_U, U_SIGN, DOUBLED, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced().boxed(),
                check: |case, fault| settle_main_small(case, fault, Check { case, fault, which: Which::Restricted }, 2),
            },
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Slopes,
    Generated,
    Antisymmetry,
    Flow,
    Restricted,
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a dyn Debug,
    fault: Option<&'a Fault>,
    which: Which,
}

/// l_d of a system.
type Action<'a, T, R, L, F, const N: usize, const D: usize> =
    Planted<'a, StageLagrangian<T, Forced<&'a L, &'a F, &'a R>, &'a R, N, D>>;

/// A point off the units near the motion of a system: V = τ(v), U = τ(x), W = τ(w).
struct Point<T: Real, const N: usize, const D: usize> {
    triple: Triple<T, D>,
    v: Vector<T, N>,
    w: Vector<T, N>,
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        self,
        system: System<T, N, D, R, L, F>,
    ) -> Measured {
        let judged = match self.which {
            Which::Slopes => self.slopes(&system),
            Which::Generated => self.generated(&system),
            Which::Antisymmetry => self.antisymmetry(&system),
            Which::Flow => self.flow(&system),
            Which::Restricted => self.restricted(&system),
        };
        judged.unwrap_or_else(|refused| refused)
    }
}

impl<'a> Check<'a> {
    /// l_d of the step from time t, with the fault planted.
    fn action<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        &self,
        system: &'a System<T, N, D, R, L, F>,
        time: T,
    ) -> Action<'a, T, R, L, F, N, D> {
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let (here, there) = (&system.tableau, system.tableau.conjugate());
        let size = Fault::size_of(self.fault, CONJUGATE.name);
        let s = here.stages();
        let row = |i: usize| (0..s).map(|j| blend_scalar(here.a()[(i, j)], there.a()[(i, j)], size)).collect();
        let rows: Vec<Vec<T>> = (0..s).map(row).collect();
        let tableau = Tableau::new(&rows, here.b().as_slice()).unwrap_or_else(|_| here.clone());
        let l_d = StageLagrangian::new(Forced::new(l, f, r), r, tableau, system.step).at_time(time);
        Planted { l_d, fault: self.fault }
    }
}

impl Check<'_> {
    fn point<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Point<T, N, D>, Measured> {
        let mut probe = Probe::new(self.case, stream::POINT_OFF_UNITS);
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros());
        let eta = eta.map_err(|_| Measured::Inconclusive("the Legendre transform could not be inverted".into()))?;
        let speed = eta.amax() * T::exact(0.125);
        let mut displacement = || (eta + probe.vector::<T, N>() * speed) * system.step;
        let (v, w) = (displacement(), displacement());
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let tau = |x: &Vector<T, N>| system.retraction.tau(x).map_err(outside);
        Ok(Point { triple: Triple { v: tau(&v)?, u: tau(&x)?, w: tau(&w)? }, v, w })
    }

    fn slopes<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, Measured> {
        let point = self.point(system)?;
        let l_d = self.action(system, system.state.time);
        let x = point.triple;
        let mine = l_d.slopes(&x).map_err(refused)?;
        let mut probe = Probe::new(self.case, stream::SLOPES);
        let relative = T::exact(2f64.powi(if T::unit_roundoff() < T::exact(1e-20) { -24 } else { -12 }));
        let largest = [mine.v_left, mine.v_right, mine.u_left, mine.u_right, mine.w_left, mine.w_right]
            .iter()
            .fold(T::zero(), |m, slope| m.max(slope.amax()));
        let floor = 64.0 * (system.tableau.stages() * N) as f64;
        let mut along = || probe.vector::<T, N>();
        let (first, relation, second) = (along() * point.v.amax(), along(), along() * point.w.amax());
        let value = |multiple: i64| {
            let tau =
                |along: &Vector<T, N>| system.retraction.tau(&(along * (relative * T::int(multiple)))).map_err(outside);
            let moved = Triple { v: x.v * tau(&first)?, u: x.u * tau(&relation)?, w: x.w * tau(&second)? };
            l_d.value(&moved).map_err(refused)
        };
        let difference = (value(1)? - value(-1)?) * T::int(8) - (value(2)? - value(-2)?);
        let expected = difference / (relative * T::int(12));
        let found = pair(&mine.v_left, &first) + pair(&mine.u_left, &relation) + pair(&mine.w_left, &second);
        let differences = Measured::defect((found - expected).abs(), largest / relative, floor, || {
            format!("slope {:.17e}, differences {:.17e}", found.to_f64(), expected.to_f64())
        });
        Ok(differences
            .and(sides(system, &mine.v_left, &mine.v_right, &x.v, largest, "V")?)
            .and(sides(system, &mine.u_left, &mine.u_right, &x.u, largest, "U")?)
            .and(sides(system, &mine.w_left, &mine.w_right, &x.w, largest, "W")?))
    }

    fn generated<
        T: Real,
        const N: usize,
        const D: usize,
        R: Retraction<T, N, D>,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    >(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, Measured> {
        let (start, end, x) = &self.doubled_steps(system, 1)?[0];
        let l_d = self.action(system, system.state.time);
        let slopes = l_d.slopes(x).map_err(refused)?;
        let minus = Momenta::minus(&slopes, x);
        let plus = Momenta::plus(&slopes, x).map_err(refused)?;
        let step = |g: &Matrix<T, D>| system.retraction.tau_inv(g).map(|v| v.amax()).map_err(outside);
        let smallest = step(&x.v)?.min(step(&x.w)?).min(T::one());
        let momentum = start.lambda.amax().max(start.mu.amax()).max(end.lambda.amax()).max(end.mu.amax());
        let floor = 512.0 * (system.tableau.stages() * N) as f64;
        let near = |what: &'static str, mine: &Covector<T, N>, theirs: &Covector<T, N>| {
            Measured::defect((mine - theirs).amax(), momentum / smallest, floor, || what.into())
        };
        let size = plus.u.amax().max(T::one());
        Ok([
            near("λ of F⁻", &minus.lambda, &start.lambda),
            near("μ of F⁻", &minus.mu, &start.mu),
            near("λ of F⁺", &plus.lambda, &end.lambda),
            near("μ of F⁺", &plus.mu, &end.mu),
            Measured::defect((plus.u - end.relative).amax(), size, floor, || "U of F⁺".into()),
        ]
        .into_iter()
        .fold(Measured::NotApplicable("nothing".into()), Measured::and))
    }

    /// Doubled steps from momenta off the units: start, end and (V, U, W) of each.
    #[allow(clippy::type_complexity, reason = "an alias would hide what a step is: start, end and (V, U, W)")]
    fn doubled_steps<
        T: Real,
        const N: usize,
        const D: usize,
        R: Retraction<T, N, D>,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    >(
        &self,
        system: &System<T, N, D, R, L, F>,
        count: usize,
    ) -> Result<Vec<(DoubledState<T, N, D>, DoubledState<T, N, D>, Triple<T, D>)>, Measured> {
        let mut probe = Probe::new(self.case, stream::MOMENTA_OFF_UNITS);
        let state = &system.state;
        let scale = state.momentum.amax() * T::exact(0.125);
        let (lambda, mu) =
            (state.momentum + probe.covector::<T, N>() * scale, state.momentum + probe.covector::<T, N>() * scale);
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let u = system.retraction.tau(&x).map_err(outside)?;
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        // The type that other laws step, too.
        let forced = Forced::new(l, f, r);
        let lagrangian = PlantedForced { doubled: &forced, fault: None };
        let mut method = Doubled::<T, _, _, N, D>::new(system.tableau.clone(), r, lagrangian);
        let mut start = DoubledState { time: state.time, lambda, relative: u, mu, attitudes: None };
        let mut steps = Vec::with_capacity(count);
        for _ in 0..count {
            // Attitudes from e, so that those at the end are the displacements.
            start.attitudes = Some((Matrix::identity(), Matrix::identity()));
            let mut end = start.clone();
            method.step(&mut end, system.step).map_err(|error| step_refused(&error))?;
            let (v, w) = end.attitudes.ok_or(Measured::Broken("the attitudes are gone".into()))?;
            let triple = Triple { v, u: start.relative, w };
            let next = end.clone();
            steps.push((start, end, triple));
            start = next;
        }
        Ok(steps)
    }

    fn antisymmetry<
        T: Real,
        const N: usize,
        const D: usize,
        R: Retraction<T, N, D>,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    >(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, Measured> {
        let point = self.point(system)?;
        let l_d = self.action(system, system.state.time);
        let back = inverse(&point.triple, self.fault)?;
        let here = l_d.value(&point.triple).map_err(refused)?;
        let there = l_d.value(&back).map_err(refused)?;
        let size = (0..2).fold(T::zero(), |size, k| {
            let eta = [point.v, point.w][k] / system.step;
            let force = crate::mechanics::Force::force(&system.force, system.state.time, &eta);
            size + system.lagrangian.gradient(&eta).amax() + force.amax() * system.step.abs()
        });
        let scale = point.triple.u.amax().max(T::one()) * back.u.amax().max(T::one());
        let floor = 64.0 * (system.tableau.stages() * N) as f64;
        Ok(antisymmetry([here, there], size * scale, floor))
    }

    fn flow<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, Measured> {
        let steps = self.doubled_steps(system, 2)?;
        let (previous, next) =
            (self.action(system, system.state.time), self.action(system, system.state.time + system.step));
        let found = flow(&previous, &next, &system.retraction, &steps[0].2).map_err(refused)?;
        Ok(compare(&found, &steps[1].2, T::one(), 1024.0 * (system.tableau.stages() * N) as f64))
    }

    fn restricted<
        T: Real,
        const N: usize,
        const D: usize,
        R: Retraction<T, N, D>,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    >(
        &self,
        system: &System<T, N, D, R, L, F>,
    ) -> Result<Measured, Measured> {
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let mut method = Variational::new(l, f, r, system.tableau.clone());
        let mut state = system.state.clone();
        let mut step = || {
            // From e, so that the attitude at the end is the displacement.
            state.attitude = Matrix::identity();
            method.step(&mut state, system.step).map_err(|error| step_refused(&error))?;
            Ok::<_, Measured>(Triple::unit(state.attitude))
        };
        let (here, there) = (step()?, step()?);
        let (previous, next) =
            (self.action(system, system.state.time), self.action(system, system.state.time + system.step));
        let found = flow(&previous, &next, r, &here).map_err(refused)?;
        Ok(compare(&found, &there, T::one(), 1024.0 * (system.tableau.stages() * N) as f64))
    }
}

/// L*_g F' = Ad*_g R*_g F'.
fn sides<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
    system: &System<T, N, D, R, L, F>,
    left: &Covector<T, N>,
    right: &Covector<T, N>,
    element: &Matrix<T, D>,
    size: T,
    what: &'static str,
) -> Result<Measured, Measured> {
    let Some(group) = &system.group else {
        return Err(Measured::NotApplicable("the algebra has no group".into()));
    };
    let ad = group.adjoint(element).ok_or(Measured::Broken("a group element is a singular matrix".into()))?;
    let floor = 64.0 * (system.tableau.stages() * N) as f64;
    Ok(Measured::defect((left - right * ad).amax(), size * ad.amax().max(T::one()), floor, || {
        format!("L* and Ad* R* differ at {what}")
    }))
}
