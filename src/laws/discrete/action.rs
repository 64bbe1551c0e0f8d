//! Laws of the extremal action of a tableau.

use super::super::planted::blend_scalar;
use super::super::planted::doubled::PlantedForced;
use super::super::precision::Measured;
use super::super::probe::{stream, unit_of};
use super::super::question::{Answer, Problem, Question, law};
use super::super::{CaseLaw, Source};
use super::{
    ANTISYMMETRY, CONJUGATE, DOUBLED, Kept, NO_U, Planted, SLOPES, U_RIGHT, U_SIGN, V_RIGHT, antisymmetry, compare,
    slopes,
};
use crate::algebra::{Covector, Matrix, Vector};
use crate::discrete::legendre::{Momenta, flow_from};
use crate::discrete::{DiscreteLagrangian, StageLagrangian, Triple};
use crate::harness::Cost;
use crate::integrators::{Doubled, DoubledState, OneStep, Variational};
use crate::mechanics::Lagrangian;
use crate::retraction::{AnyRetraction, Retraction, TangentPoint};
use crate::scalar::{Real, max_abs};
use crate::tableau::Tableau;

/// What every action needs.
const NEEDS: &str = "a group; a force";

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                needs: NEEDS,
                bound: apart(3, "2⁶ N u"),
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Slopes,
                ..SLOPES
            }),
            law!(Law {
                name: "doubled-step-generated",
                statement: "along a doubled step off the units F⁻l_d(V, U, W) = (λ, U, μ) and F⁺l_d(V, U, W) = (λ', U', μ')",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5, F± after Prop 5.1, and §5.2",
                oracle: "the doubled integrator, from the stage equations; l_d has only values, τ and dτ",
                bound: small(4, "floor 2⁹ s N u: two solves, of momenta that rounding of V moves by p u/|v|"),
                needs: "a group; a force",
                cost: Cost::Moderate,
                faults: &[V_RIGHT, U_RIGHT, NO_U, U_SIGN, DOUBLED, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Generated,
            }),
            law!(Law {
                needs: NEEDS,
                bound: small(
                    4,
                    "floor 2⁶ N u of the slopes, by which rounding of \
                            V, U and W is multiplied"
                ),
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Antisymmetry,
                ..ANTISYMMETRY
            }),
            law!(Law {
                name: "discrete-flow",
                statement: "the flow F_{l_d} takes the displacements of one doubled step off the units to those of the next",
                source: "Martín de Diego and Sato Martín de Almagro 2019, (5.2) and §5.2",
                oracle: "the doubled integrator; the flow knows momenta only through F±",
                bound: small(2, "floor 2¹⁰ s N u of the displacements: nested solves, and two steps"),
                needs: "a group; a force",
                cost: Cost::Expensive,
                faults: &[NO_U, U_SIGN, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Flow,
            }),
            law!(Law {
                name: "discrete-restricted-step",
                statement: "F_{l_d} takes (V, e, V) to a unit, and there it is the restricted step",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.3 and §5.2",
                oracle: "two steps of the restricted integrator, which knows neither U nor the second copy",
                bound: small(2, "floor 2¹⁰ s N u of the displacements: nested solves, and two steps"),
                needs: "a group; a force",
                cost: Cost::Expensive,
                faults: &[NO_U, U_SIGN, DOUBLED, CONJUGATE],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: Which::Restricted,
            }),
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
type Action<'a, T, const N: usize, const D: usize> =
    Planted<'a, StageLagrangian<T, PlantedForced<'a, T, N, D>, &'a AnyRetraction<T, N, D>, N, D>>;

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

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::POINT_OFF_UNITS);

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let mut near = NearMotion(problem);
        match self {
            Self::Slopes => near.slopes(),
            Self::Generated => near.generated(),
            Self::Antisymmetry => antisymmetry(&near.action(T::zero()), &near.point()?.triple),
            Self::Flow => near.discrete_flow(),
            Self::Restricted => near.restricted(),
        }
    }
}

/// Discrete steps near the motion of a system.
struct NearMotion<'a, T: Real, const N: usize, const D: usize>(Problem<'a, T, N, D>);

impl<'a, T: Real, const N: usize, const D: usize> NearMotion<'a, T, N, D> {
    /// l_d of the step that begins `later` than the motion, with the fault planted.
    fn action(&self, later: T) -> Action<'a, T, N, D> {
        let Problem { system, fault, .. } = self.0;
        let (here, there) = (&system.tableau, system.tableau.conjugate());
        let size = CONJUGATE.size_in(fault);
        let s = here.stages();
        let row = |i: usize| (0..s).map(|j| blend_scalar(here.a()[(i, j)], there.a()[(i, j)], size)).collect();
        let rows: Vec<Vec<T>> = (0..s).map(row).collect();
        let tableau = Tableau::new(&rows, here.b().as_slice()).unwrap_or_else(|_| here.clone());
        let time = system.state.time + later;
        let lagrangian = PlantedForced::of(system, None);
        let l_d = StageLagrangian::new(lagrangian, &system.retraction, tableau, system.step).at_time(time);
        Planted { l_d, fault }
    }

    /// [`Problem::floor`] of so much for each stage.
    fn floor_of_stages(&self, units: f64) -> f64 {
        self.0.floor(units * self.0.system.tableau.stages() as f64)
    }

    fn point(&mut self) -> Result<Point<T, N, D>, Measured> {
        let Problem { system, probe, .. } = &mut self.0;
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros());
        let eta = eta.map_err(|_| Measured::Inconclusive("the Legendre transform could not be inverted".into()))?;
        let speed = unit_of(&eta) * T::exact(0.125);
        let mut displacement = || (eta + probe.vector::<T, N>() * speed) * system.step;
        let (v, w) = (displacement(), displacement());
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let tau = |x: &Vector<T, N>| system.retraction.tau(x);
        Ok(Point { triple: Triple { v: tau(&v)?, u: tau(&x)?, w: tau(&w)? }, v, w })
    }

    fn slopes(&mut self) -> Answer {
        let group = self.0.group()?;
        let point = self.point()?;
        let mut probe = self.0.draws(stream::SLOPES);
        let mut along = || probe.vector::<T, N>();
        // V and W are as near to e as they are far apart.
        let along = [along() * point.v.amax(), along(), along() * point.w.amax()];
        let tau = &self.0.system.retraction;
        slopes(&self.action(T::zero()), group, |x| tau.tau(x), &point.triple, &along, T::one())
    }

    fn generated(&self) -> Answer {
        let DoubledStep { start, end, triple: x, stages } = &self.doubled_steps(1)?[0];
        let l_d = self.action(T::zero());
        // Of several extrema the one of the step is meant.
        let near = l_d.l_d.near(x, &stages.0, &stages.1)?;
        let slopes = l_d.slopes_from(x, &mut Kept::new(Some(near)))?;
        let (minus, plus) = (Momenta::minus(&slopes, x), Momenta::plus(&slopes, x)?);
        let step = |g: &Matrix<T, D>| self.0.system.retraction.tau_inv(g).map(|v| v.amax());
        let smallest = step(&x.v)?.min(step(&x.w)?).min(T::one());
        let momentum = start.lambda.amax().max(start.mu.amax()).max(end.lambda.amax()).max(end.mu.amax());
        let floor = self.floor_of_stages(512.0);
        let near = |what: &'static str, mine: &Covector<T, N>, theirs: &Covector<T, N>| {
            Measured::defect(max_abs(&(mine - theirs)), momentum / smallest, floor, || what.into())
        };
        let size = plus.u.amax().max(T::one());
        let relative = Measured::defect(max_abs(&(plus.u - end.relative)), size, floor, || "U of F⁺".into());
        Ok(near("λ of F⁻", &minus.lambda, &start.lambda)
            .and(near("μ of F⁻", &minus.mu, &start.mu))
            .and(near("λ of F⁺", &plus.lambda, &end.lambda))
            .and(near("μ of F⁺", &plus.mu, &end.mu))
            .and(relative))
    }

    /// Doubled steps from momenta off the units.
    fn doubled_steps(&self, count: usize) -> Result<Vec<DoubledStep<T, N, D>>, Measured> {
        let (system, mut probe) = (self.0.system, self.0.draws(stream::MOMENTA_OFF_UNITS));
        let state = &system.state;
        let scale = unit_of(&state.momentum) * T::exact(0.125);
        let (lambda, mu) =
            (state.momentum + probe.covector::<T, N>() * scale, state.momentum + probe.covector::<T, N>() * scale);
        let x = probe.vector::<T, N>() * T::exact(0.03125);
        let u = system.retraction.tau(&x)?;
        let lagrangian = PlantedForced::of(system, None);
        let mut method = Doubled::<T, _, _, N, D>::new(system.tableau.clone(), &system.retraction, lagrangian);
        let mut start = DoubledState { time: state.time, lambda, relative: u, mu, attitudes: None };
        let mut steps = Vec::with_capacity(count);
        for _ in 0..count {
            // Attitudes from e, so that those at the end are the displacements.
            start.attitudes = Some((Matrix::identity(), Matrix::identity()));
            let mut end = start.clone();
            method.step(&mut end, system.step)?;
            let (v, w) = end.attitudes.ok_or(Measured::Broken("the attitudes are gone".into()))?;
            let triple = Triple { v, u: start.relative, w };
            let next = end.clone();
            let (first, second) = method.stages();
            steps.push(DoubledStep { start, end, triple, stages: (first.to_vec(), second.to_vec()) });
            start = next;
        }
        Ok(steps)
    }

    fn discrete_flow(&self) -> Answer {
        let steps = self.doubled_steps(2)?;
        let DoubledStep { triple, stages, .. } = &steps[0];
        self.next(triple, &stages.0, &stages.1, &steps[1].triple)
    }

    /// Whether F_{l_d} takes the displacements of a step with these stages to `expected`.
    fn next(&self, x: &Triple<T, D>, h: &[Vector<T, N>], psi: &[Vector<T, N>], expected: &Triple<T, D>) -> Answer {
        let (previous, next) = (self.action(T::zero()), self.action(self.0.system.step));
        let near = previous.l_d.near(x, h, psi)?;
        let found = flow_from(&previous, &next, &self.0.system.retraction, x, &mut Kept::new(Some(near)))?;
        Ok(compare(&found, expected, T::one(), self.floor_of_stages(1024.0)))
    }

    fn restricted(&self) -> Answer {
        let system = self.0.system;
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let mut method = Variational::new(l, f, r, system.tableau.clone());
        let mut state = system.state.clone();
        // (V, e, V), and H.
        let mut step = || {
            // From e, so that the attitude at the end is the displacement.
            state.attitude = Matrix::identity();
            method.step(&mut state, system.step)?;
            let rates = method.stage_displacements().zip(method.stage_velocities());
            let rates = rates.map(|(xi, eta)| Ok(r.at(&xi)?.d_inv() * eta));
            Ok::<_, Measured>((Triple::unit(state.attitude), rates.collect::<Result<Vec<_>, Measured>>()?))
        };
        let ((here, rates), (there, _)) = (step()?, step()?);
        self.next(&here, &rates, &rates, &there)
    }
}
