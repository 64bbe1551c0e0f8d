//! The partial derivatives of r(H; g, μ, t, h, p) and of the end of the step, at the stages of the last step.
//!
//! A stage depends on (Ξ_i, H_i, g, t_i) alone: it is differentiated by itself, in dual numbers, and the rest is linear.

use super::jacobian::{Argument, End, Jacobian, Linear, Place, varied};
use super::parts::Mechanics;
use super::{Problem, Terms, Variational, domain};
use crate::algebra::{Covector, Matrix, Vector, basis_vector};
use crate::integrators::parameters::Parameters;
use crate::integrators::stages::Stages;
use crate::integrators::{State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Dual, Real, finite};
use nalgebra::DMatrix;

/// How the terms of a stage change along e_a in the attitude, and in the time.
#[derive(Clone, Debug)]
struct Changes<T: Real, const N: usize> {
    by_attitude: [Terms<T, N>; N],
    by_time: Terms<T, N>,
}

/// The columns of the inputs are ζ (N), μ (N), t, h and the parameters.
#[derive(Clone, Debug)]
pub(in crate::integrators) struct Partials<T: Real, const N: usize> {
    /// J = ∂r/∂H, sN×sN.
    pub stages: DMatrix<T>,
    /// ∂r/∂(inputs), sN×(2N + 2 + K).
    pub inputs: DMatrix<T>,
    /// ∂(ζ', δμ')/∂H, 2N×sN.
    pub end_by_stages: DMatrix<T>,
    /// ∂(ζ', δμ')/∂(inputs) with H as it is, 2N×(2N + 2 + K).
    pub end_by_inputs: DMatrix<T>,
    /// Ad_{τ(ξ)}.
    pub adjoint: Matrix<T, N>,
    linear: Jacobian<T, N>,
    changes: Vec<Changes<T, N>>,
    /// Those along parameter k, from k s on.
    along_parameters: Vec<Terms<T, N>>,
}

impl<T: Real, const N: usize> Partials<T, N> {
    pub fn new(stages: usize, parameters: usize) -> Self {
        let (unknowns, inputs) = (stages * N, 2 * N + 2 + parameters);
        let zero = Terms::zero();
        let changes = Changes { by_attitude: [zero; N], by_time: zero };
        Self {
            stages: DMatrix::zeros(unknowns, unknowns),
            inputs: DMatrix::zeros(unknowns, inputs),
            end_by_stages: DMatrix::zeros(2 * N, unknowns),
            end_by_inputs: DMatrix::zeros(2 * N, inputs),
            adjoint: Matrix::zeros(),
            linear: Jacobian::new(stages),
            changes: vec![changes; stages],
            along_parameters: vec![zero; stages * parameters],
        }
    }

    /// How many parameters there is room for.
    pub fn parameters(&self) -> usize {
        self.inputs.ncols() - 2 * N - 2
    }

    /// Whether nothing is NaN or infinite.
    pub fn all_finite(&self) -> bool {
        let matrices = [&self.stages, &self.inputs, &self.end_by_stages, &self.end_by_inputs];
        matrices.iter().all(|matrix| finite(matrix.as_slice()))
    }
}

impl<T: Real, const N: usize, const D: usize> Mechanics<'_, T, N, D> {
    /// How stage i changes with the attitude and the time.
    fn changes(
        &self,
        problem: &Problem<T, N, D>,
        i: usize,
        (place, linear): (&Place<'_, T, N, D>, &Linear<T, N>),
        Changes { by_attitude, by_time }: &mut Changes<T, N>,
    ) -> Result<(), StepError> {
        let failed = |e| domain(problem.step, Some(i), e);
        *by_attitude = [Terms::zero(); N];
        if self.moves {
            let turned = self.parts.tau(&(linear.direction * problem.step).map(Dual::constant)).map_err(failed)?;
            for (a, terms) in by_attitude.iter_mut().enumerate() {
                // g exp(ε e_a), since T₀τ = 1.
                let along = self.parts.attitude(&problem.attitude, &varied(&Vector::zeros(), a)).map_err(failed)?;
                *terms = self.respond(place, Argument::Attitude(&(along * turned)));
            }
        }
        *by_time = self.respond(place, Argument::Time);
        Ok(())
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// The H_i of the last step.
    pub(in crate::integrators) fn rates(&self) -> &Stages<T, N> {
        &self.work.rates
    }

    /// The next step starts as the first does: from these steps on a run can be repeated to the last bit.
    pub(in crate::integrators) fn forget(&mut self) {
        (self.last, self.predicted, self.first_residual) = (None, None, None);
    }

    /// The partial derivatives at the H_i of the last step, or at others (`rates`), of a step of size h from `start`.
    pub(in crate::integrators) fn partials(
        &self,
        start: &State<T, N, D>,
        h: T,
        rates: Option<&Stages<T, N>>,
        parameters: &dyn Parameters<T, N>,
        out: &mut Partials<T, N>,
    ) -> Result<(), StepError> {
        let rates = rates.unwrap_or(&self.work.rates);
        self.scheme.mechanics().partials(&Problem::new(start, h), rates, parameters, out)
    }
}

impl<T: Real, const N: usize, const D: usize> Mechanics<'_, T, N, D> {
    fn partials(
        &self,
        problem: &Problem<T, N, D>,
        rates: &Stages<T, N>,
        parameters: &dyn Parameters<T, N>,
        out: &mut Partials<T, N>,
    ) -> Result<(), StepError> {
        let h = problem.step;
        let Partials { linear, changes, stages, end_by_stages, .. } = &mut *out;
        let end = self.jacobian(problem, rates, linear, (stages, Some(end_by_stages)), &mut |i, place, linear| {
            self.changes(problem, i, (place, linear), &mut changes[i])
        })?;
        if !out.along_parameters.is_empty() {
            self.along_parameters(problem, parameters, rates, &out.linear.stages, &mut out.along_parameters)?;
        }
        let mean = rates.sum(self.coefficients.tableau.b().as_slice());
        self.input_columns((h, &end), &mean, out);

        let (tangent, adjoint, adjoint_inv) =
            self.with((None, h), &end.increment, |point| (*point.d(), point.ad(), point.ad_inv()))?;
        let (momentum, algebra, mut turned) = (end.momentum * adjoint, self.parts.algebra(), Matrix::<T, N>::zeros());
        for b in 0..N {
            // ⟨μ', [e_a, e_b]⟩ = −(ad*_{e_b} μ')_a.
            turned.set_column(b, &-algebra.coad(&basis_vector(b), &momentum).transpose());
        }
        // From (δξ, δm) to (ζ', δμ').
        for mut column in out.end_by_stages.column_iter_mut().chain(out.end_by_inputs.column_iter_mut()) {
            let increment = Vector::<T, N>::from_fn(|a, _| column[a]);
            let impulse = Covector::<T, N>::from_fn(|_, a| column[N + a]);
            let omega = tangent * increment;
            let momentum = impulse * adjoint + omega.transpose() * turned;
            for a in 0..N {
                (column[a], column[N + a]) = (omega[a], momentum[a]);
            }
        }
        for (a, b) in (0..N).flat_map(|a| (0..N).map(move |b| (a, b))) {
            out.end_by_inputs[(a, b)] += adjoint_inv[(a, b)];
        }
        out.adjoint = adjoint;
        Ok(())
    }

    /// The columns of ζ, μ, t, h and the parameters; `mean` is ξ/h.
    fn input_columns(&self, (h, end): (T, &End<T, N>), mean: &Vector<T, N>, out: &mut Partials<T, N>) {
        let Partials { linear: Jacobian { stages, along }, changes, inputs, end_by_inputs, along_parameters, .. } = out;
        let zero = Vector::zeros();
        for e in 0..N {
            for (terms, stage) in along.iter_mut().zip(&*changes) {
                *terms = stage.by_attitude[e];
            }
            self.column((h, end), along, &zero, (inputs, Some(end_by_inputs), e));
            for row in 0..inputs.nrows() {
                inputs[(row, N + e)] = -end.d_neg[(e, row % N)];
            }
            for row in 0..2 * N {
                end_by_inputs[(row, N + e)] = if row == N + e { T::one() } else { T::zero() };
            }
        }
        for (terms, stage) in along.iter_mut().zip(&*changes) {
            *terms = stage.by_time;
        }
        self.column((h, end), along, &zero, (inputs, Some(end_by_inputs), 2 * N));
        for (j, (terms, stage)) in along.iter_mut().zip(&*stages).enumerate() {
            *terms = Terms::zero();
            terms.add(&changes[j].by_time, self.coefficients.tableau.c()[j]);
            for e in 0..N {
                terms.add(&stage.by_displacement[e], stage.direction[e]);
            }
        }
        self.column((h, end), along, mean, (inputs, Some(end_by_inputs), 2 * N + 1));
        self.explicit_in_step(end, stages, (inputs, end_by_inputs, 2 * N + 1));
        for (k, along) in along_parameters.chunks_exact(changes.len()).enumerate() {
            self.column((h, end), along, &zero, (inputs, Some(end_by_inputs), 2 * N + 2 + k));
        }
    }

    /// What h multiplies in r and in m.
    fn explicit_in_step(
        &self,
        end: &End<T, N>,
        stages: &[Linear<T, N>],
        (rows, ends, column): (&mut DMatrix<T>, &mut DMatrix<T>, usize),
    ) {
        let b = self.coefficients.tableau.b();
        let impulse = stages.iter().zip(b).fold(Covector::zeros(), |sum, (stage, &b)| sum + stage.terms.impulse * b);
        let common: Covector<T, N> = impulse * end.d_neg;
        for i in 0..stages.len() {
            for c in 0..N {
                let coupled = stages.iter().enumerate().fold(T::zero(), |sum, (j, stage)| {
                    sum + stage.terms.gradient[c] * self.coefficients.coupling.get(i, j)
                });
                rows[(i * N + c, column)] += coupled - common[c];
            }
        }
        for c in 0..N {
            ends[(N + c, column)] += impulse[c];
        }
    }

    /// The terms of the stages along the parameters: they are linear in ∂L/∂η and the force.
    fn along_parameters(
        &self,
        problem: &Problem<T, N, D>,
        parameters: &dyn Parameters<T, N>,
        rates: &Stages<T, N>,
        stages: &[Linear<T, N>],
        along: &mut [Terms<T, N>],
    ) -> Result<(), StepError> {
        for (j, stage) in stages.iter().enumerate() {
            let (x, rate) = (stage.direction * problem.step, rates.vector(j));
            let at;
            let g = match self.parts.attitude(&problem.attitude, &x) {
                Ok(attitude) => {
                    at = attitude;
                    Configuration::of(&at)
                }
                Err(RetractionError::NoGroup { .. }) => Configuration::identity(),
                Err(source) => return Err(domain(problem.step, Some(j), source)),
            };
            let time = problem.time + self.coefficients.tableau.c()[j] * problem.step;
            self.with((Some(j), problem.step), &x, |point| {
                let eta: Vector<T, N> = point.d() * rate;
                for (k, terms) in along.iter_mut().skip(j).step_by(stages.len()).enumerate() {
                    let (force, m) = (parameters.force(k, time, g, &eta), parameters.momentum(k, time, g, &eta));
                    let momentum = m * point.d();
                    let gradient = point.pull_dd(&momentum, &m, &rate) + force * point.d();
                    *terms = Terms { momentum, gradient, impulse: force * point.ad_inv() };
                }
            })?;
        }
        Ok(())
    }
}
