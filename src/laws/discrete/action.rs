//! Laws of the extremal action of a tableau.

use super::super::integrators::refused as step_refused;
use super::super::planted::blend_scalar;
use super::super::precision::{Check, Measured, each_small, settle_small};
use super::super::probe::{Probe, stream, unit_of};
use super::super::subjects::PlantedForced;
use super::super::{CaseLaw, Source};
use super::{
    ANTISYMMETRY, CONJUGATE, DOUBLED, Kept, NO_U, Planted, SLOPES, U_RIGHT, U_SIGN, V_RIGHT, antisymmetry, compare,
    outside, refused, slopes,
};
use crate::algebra::{Covector, Matrix, Vector};
use crate::discrete::legendre::{Momenta, flow_from};
use crate::discrete::{DiscreteLagrangian, StageLagrangian, Triple};
use crate::harness::{About, Cost, Fault};
use crate::integrators::{Doubled, DoubledState, OneStep, Variational};
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::Forced;
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::retraction::{AnyRetraction, Retraction, TangentPoint};
use crate::scalar::{Real, max_abs};
use crate::system::{System, Visitor};
use crate::tableau::Tableau;

/// What every action needs.
const NEEDS: &str = "a group; a force";

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            CaseLaw {
                about: About {
                    needs: NEEDS,
                    bound: "the estimated error of the differences with 2⁶ N u; where it is above, in one case of ten, and where s N ≤ 3: 2⁸ \
                            times that, in each precision by itself",
                    ..SLOPES
                },
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| each_small(case, fault, Check { case, fault, which: Which::Slopes }, 3),
            },
            CaseLaw {
                about: About {
                    name: "doubled-step-generated",
                    statement: "along a doubled step off the units F⁻l_d(V, U, W) = (λ, U, μ) and F⁺l_d(V, U, W) = (λ', U', μ')",
                    source: "Martín de Diego and Sato Martín de Almagro 2019, §5, F± after Prop 5.1, and §5.2",
                    oracle: "the doubled integrator, from the stage equations; l_d has only values, τ and dτ",
                    bound: "two precisions (s N > 4: f64 alone below 8 u or a 2⁹th of the floor, but for one case in ten); floor 2⁹ s N u: two solves, of momenta that rounding of V moves by p u/|v|",
                    needs: "a group; a force",
                    cost: Cost::Moderate,
                    faults: &[V_RIGHT, U_RIGHT, NO_U, U_SIGN, DOUBLED, CONJUGATE],
                },
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| settle_small(case, fault, Check { case, fault, which: Which::Generated }, 4),
            },
            CaseLaw {
                about: About {
                    needs: NEEDS,
                    bound: "two precisions (s N > 4: f64 alone below 8 u or a 2⁹th of the floor, but for one case in ten); floor 2⁶ N u of the slopes, by which rounding of \
                            V, U and W is multiplied",
                    ..ANTISYMMETRY
                },
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| settle_small(case, fault, Check { case, fault, which: Which::Antisymmetry }, 4),
            },
            CaseLaw {
                about: About {
                    name: "discrete-flow",
                    statement: "the flow F_{l_d} takes the displacements of one doubled step off the units to those of the next",
                    source: "Martín de Diego and Sato Martín de Almagro 2019, (5.2) and §5.2",
                    oracle: "the doubled integrator; the flow knows momenta only through F±",
                    bound: "two precisions (s N > 2: f64 alone below 8 u or a 2⁹th of the floor, but for one case in ten); floor 2¹⁰ s N u of the displacements: nested solves, and two steps",
                    needs: "a group; a force",
                    cost: Cost::Expensive,
                    faults: &[NO_U, U_SIGN, CONJUGATE],
                },
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| settle_small(case, fault, Check { case, fault, which: Which::Flow }, 2),
            },
            CaseLaw {
                about: About {
                    name: "discrete-restricted-step",
                    statement: "F_{l_d} takes (V, e, V) to a unit, and there it is the restricted step",
                    source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.3 and §5.2",
                    oracle: "two steps of the restricted integrator, which knows neither U nor the second copy",
                    bound: "two precisions (s N > 2: f64 alone below 8 u or a 2⁹th of the floor, but for one case in ten); floor 2¹⁰ s N u of the displacements: nested solves, and two steps",
                    needs: "a group; a force",
                    cost: Cost::Expensive,
                    faults: &[NO_U, U_SIGN, DOUBLED, CONJUGATE],
                },
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| settle_small(case, fault, Check { case, fault, which: Which::Restricted }, 2),
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

/// l_d of a system.
type Action<'a, T, const N: usize, const D: usize> = Planted<
    'a,
    StageLagrangian<
        T,
        Forced<&'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>>,
        &'a AnyRetraction<T, N, D>,
        N,
        D,
    >,
>;

/// A point off the units near the motion of a system: V = τ(v), U = τ(x), W = τ(w).
struct Point<T: Real, const N: usize, const D: usize> {
    triple: Triple<T, D>,
    v: Vector<T, N>,
    w: Vector<T, N>,
}

/// A step of the doubled integrator.
struct DoubledStep<T: Real, const N: usize, const D: usize> {
    start: DoubledState<T, N, D>,
    end: DoubledState<T, N, D>,
    /// (V, U, W).
    triple: Triple<T, D>,
    /// (H, Ψ).
    stages: (Vec<Vector<T, N>>, Vec<Vector<T, N>>),
}

impl<T: Real> Visitor<T> for Check<'_, Which> {
    type Output = Measured;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Measured {
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

impl<'a> Check<'a, Which> {
    /// l_d of the step from time t, with the fault planted.
    fn action<T: Real, const N: usize, const D: usize>(
        &self,
        system: &'a System<T, N, D>,
        time: T,
    ) -> Action<'a, T, N, D> {
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

impl Check<'_, Which> {
    fn point<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
    ) -> Result<Point<T, N, D>, Measured> {
        let mut probe = Probe::new(self.case, stream::POINT_OFF_UNITS);
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros());
        let eta = eta.map_err(|_| Measured::Inconclusive("the Legendre transform could not be inverted".into()))?;
        let speed = unit_of(&eta) * T::exact(0.125);
        let mut displacement = || (eta + probe.vector::<T, N>() * speed) * system.step;
        let (v, w) = (displacement(), displacement());
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let tau = |x: &Vector<T, N>| system.retraction.tau(x).map_err(outside);
        Ok(Point { triple: Triple { v: tau(&v)?, u: tau(&x)?, w: tau(&w)? }, v, w })
    }

    fn slopes<T: Real, const N: usize, const D: usize>(&self, system: &System<T, N, D>) -> Result<Measured, Measured> {
        let Some(group) = &system.group else {
            return Err(Measured::NotApplicable("the algebra has no group".into()));
        };
        let point = self.point(system)?;
        let mut probe = Probe::new(self.case, stream::SLOPES);
        let mut along = || probe.vector::<T, N>();
        // V and W are as near to e as they are far apart.
        let along = [along() * point.v.amax(), along(), along() * point.w.amax()];
        let l_d = self.action(system, system.state.time);
        slopes(&l_d, group, |x| system.retraction.tau(x), &point.triple, &along, T::one())
    }

    fn generated<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
    ) -> Result<Measured, Measured> {
        let DoubledStep { start, end, triple: x, stages } = &self.doubled_steps(system, 1)?[0];
        let l_d = self.action(system, system.state.time);
        // Of several extrema the one of the step is meant.
        let near = l_d.l_d.near(x, &stages.0, &stages.1).map_err(refused)?;
        let slopes = l_d.slopes_from(x, &mut Kept::new(Some(near))).map_err(refused)?;
        let minus = Momenta::minus(&slopes, x);
        let plus = Momenta::plus(&slopes, x).map_err(refused)?;
        let step = |g: &Matrix<T, D>| system.retraction.tau_inv(g).map(|v| v.amax()).map_err(outside);
        let smallest = step(&x.v)?.min(step(&x.w)?).min(T::one());
        let momentum = start.lambda.amax().max(start.mu.amax()).max(end.lambda.amax()).max(end.mu.amax());
        let floor = 512.0 * (system.tableau.stages() * system.dimension) as f64;
        let near = |what: &'static str, mine: &Covector<T, N>, theirs: &Covector<T, N>| {
            Measured::defect(max_abs(&(mine - theirs)), momentum / smallest, floor, || what.into())
        };
        let size = plus.u.amax().max(T::one());
        Ok([
            near("λ of F⁻", &minus.lambda, &start.lambda),
            near("μ of F⁻", &minus.mu, &start.mu),
            near("λ of F⁺", &plus.lambda, &end.lambda),
            near("μ of F⁺", &plus.mu, &end.mu),
            Measured::defect(max_abs(&(plus.u - end.relative)), size, floor, || "U of F⁺".into()),
        ]
        .into_iter()
        .fold(Measured::NotApplicable("nothing".into()), Measured::and))
    }

    /// Doubled steps from momenta off the units.
    fn doubled_steps<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
        count: usize,
    ) -> Result<Vec<DoubledStep<T, N, D>>, Measured> {
        let mut probe = Probe::new(self.case, stream::MOMENTA_OFF_UNITS);
        let state = &system.state;
        let scale = unit_of(&state.momentum) * T::exact(0.125);
        let (lambda, mu) =
            (state.momentum + probe.covector::<T, N>() * scale, state.momentum + probe.covector::<T, N>() * scale);
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let u = system.retraction.tau(&x).map_err(outside)?;
        // The type that other laws step, too.
        let lagrangian = PlantedForced::of(system, None);
        let mut method = Doubled::<T, _, _, N, D>::new(system.tableau.clone(), &system.retraction, lagrangian);
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
            let (first, second) = method.stages();
            steps.push(DoubledStep { start, end, triple, stages: (first.to_vec(), second.to_vec()) });
            start = next;
        }
        Ok(steps)
    }

    fn antisymmetry<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
    ) -> Result<Measured, Measured> {
        antisymmetry(&self.action(system, system.state.time), &self.point(system)?.triple)
    }

    fn flow<T: Real, const N: usize, const D: usize>(&self, system: &System<T, N, D>) -> Result<Measured, Measured> {
        let steps = self.doubled_steps(system, 2)?;
        let (previous, next) =
            (self.action(system, system.state.time), self.action(system, system.state.time + system.step));
        let DoubledStep { triple: x, stages, .. } = &steps[0];
        let near = previous.l_d.near(x, &stages.0, &stages.1).map_err(refused)?;
        let found = flow_from(&previous, &next, &system.retraction, x, &mut Kept::new(Some(near))).map_err(refused)?;
        Ok(compare(&found, &steps[1].triple, T::one(), 1024.0 * (system.tableau.stages() * system.dimension) as f64))
    }

    fn restricted<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
    ) -> Result<Measured, Measured> {
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let mut method = Variational::new(l, f, r, system.tableau.clone());
        let mut state = system.state.clone();
        // (V, e, V), and H.
        let mut step = || {
            // From e, so that the attitude at the end is the displacement.
            state.attitude = Matrix::identity();
            method.step(&mut state, system.step).map_err(|error| step_refused(&error))?;
            let rates = method.stage_displacements().zip(method.stage_velocities());
            let rates = rates.map(|(xi, eta)| Ok(r.at(&xi).map_err(outside)?.d_inv() * eta));
            Ok::<_, Measured>((Triple::unit(state.attitude), rates.collect::<Result<Vec<_>, Measured>>()?))
        };
        let ((here, rates), (there, _)) = (step()?, step()?);
        let (previous, next) =
            (self.action(system, system.state.time), self.action(system, system.state.time + system.step));
        let near = previous.l_d.near(&here, &rates, &rates).map_err(refused)?;
        let found = flow_from(&previous, &next, r, &here, &mut Kept::new(Some(near))).map_err(refused)?;
        Ok(compare(&found, &there, T::one(), 1024.0 * (system.tableau.stages() * system.dimension) as f64))
    }
}
