//! The partial derivatives of r(H; g, μ, t, h, p), ξ and m at the stages of the last step, and of the end of the step.

use super::{Problem, Variational, Work, domain};
use crate::algebra::{Covector, Matrix, Vector, basis_vector};
use crate::integrators::derivative::Parameters;
use crate::integrators::stages::Stages;
use crate::integrators::{State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dual, Real};
use nalgebra::DMatrix;

/// The columns of the inputs are ζ (N), μ (N), t, h and the parameters.
#[derive(Clone, Debug)]
pub(in crate::integrators) struct Partials<T: Real, const N: usize> {
    /// J = ∂r/∂H, sN×sN.
    pub stages: DMatrix<T>,
    /// ∂r/∂(inputs), sN×(2N + 2 + K).
    pub inputs: DMatrix<T>,
    /// ∂(ξ, m)/∂H, 2N×sN.
    pub end_by_stages: DMatrix<T>,
    /// ∂(ξ, m)/∂(inputs), 2N×(2N + 2 + K).
    pub end_by_inputs: DMatrix<T>,
    /// dτ_ξ.
    pub tangent: Matrix<T, N>,
    /// Ad_{τ(ξ)}.
    pub adjoint: Matrix<T, N>,
    /// Ad_{τ(ξ)}⁻¹.
    pub adjoint_inv: Matrix<T, N>,
    /// The matrices of v ↦ (ω ↦ ⟨μ', [ω, v]⟩): row a, column b is ⟨μ', [e_a, e_b]⟩.
    pub turned: Matrix<T, N>,
}

impl<T: Real, const N: usize> Partials<T, N> {
    pub fn new(stages: usize, parameters: usize) -> Self {
        let (unknowns, inputs) = (stages * N, 2 * N + 2 + parameters);
        Self {
            stages: DMatrix::zeros(unknowns, unknowns),
            inputs: DMatrix::zeros(unknowns, inputs),
            end_by_stages: DMatrix::zeros(2 * N, unknowns),
            end_by_inputs: DMatrix::zeros(2 * N, inputs),
            tangent: Matrix::zeros(),
            adjoint: Matrix::zeros(),
            adjoint_inv: Matrix::zeros(),
            turned: Matrix::zeros(),
        }
    }

    /// How many parameters there is room for.
    pub fn parameters(&self) -> usize {
        self.inputs.ncols() - 2 * N - 2
    }

    /// Whether nothing is NaN or infinite.
    pub fn all_finite(&self) -> bool {
        [&self.stages, &self.inputs, &self.end_by_stages, &self.end_by_inputs]
            .iter()
            .all(|matrix| crate::scalar::finite(matrix.as_slice()))
            && [&self.tangent, &self.adjoint, &self.adjoint_inv, &self.turned]
                .iter()
                .all(|matrix| crate::scalar::finite(matrix.as_slice()))
    }
}

/// The derivative parts of r, ξ and m, into a column of each.
fn keep<T: Real, const N: usize>(dual: &Work<Dual<T>, N>, rows: &mut DMatrix<T>, ends: &mut DMatrix<T>, column: usize) {
    for row in 0..rows.nrows() {
        rows[(row, column)] = dual.next_momenta.get(row / N, row % N).eps;
    }
    for a in 0..N {
        ends[(a, column)] = dual.increment[a].eps;
        ends[(N + a, column)] = dual.after_impulse[a].eps;
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Room for the H_i of a step.
    pub(in crate::integrators) fn room_for_rates(&self) -> Stages<T, N> {
        Stages::zeros(self.scheme.tableau.stages())
    }

    /// The H_i of the last step.
    pub(in crate::integrators) fn save_rates(&self, rates: &mut Stages<T, N>) {
        rates.clone_from(&self.work.rates);
    }

    /// The next step starts as the first does: from these steps on a run can be repeated to the last bit.
    pub(in crate::integrators) fn forget(&mut self) {
        (self.last, self.predicted, self.jump) = (None, None, None);
    }

    /// The partial derivatives at the H_i of the last step, or at others (`rates`), of a step of size h from `start`.
    pub(in crate::integrators) fn partials<P: Parameters<T, N>>(
        &mut self,
        start: &State<T, N, D>,
        h: T,
        rates: Option<&Stages<T, N>>,
        parameters: &P,
        out: &mut Partials<T, N>,
    ) -> Result<(), StepError> {
        let Self { scheme, work, dual, .. } = self;
        let rates = rates.unwrap_or(&work.rates);
        let unknowns = scheme.tableau.stages() * N;
        let problem = Problem::new(start, h);
        let mut moved: Problem<Dual<T>, N, D> = problem.lifted();
        let load = |dual: &mut Work<Dual<T>, N>| {
            for k in 0..unknowns {
                dual.rates.set(k / N, k % N, Dual::constant(rates.get(k / N, k % N)));
            }
        };
        load(dual);
        for column in 0..unknowns {
            let (i, a) = (column / N, column % N);
            dual.rates.set(i, a, Dual::variable(rates.get(i, a)));
            scheme.residual::<Dual<T>, N, D>(&moved, dual)?;
            keep(dual, &mut out.stages, &mut out.end_by_stages, column);
            dual.rates.set(i, a, Dual::constant(rates.get(i, a)));
        }
        out.inputs.fill(T::zero());
        out.end_by_inputs.fill(T::zero());
        if scheme.moves {
            for a in 0..N {
                // g exp(ε e_a), since T₀τ = 1.
                let along = basis_vector::<T, N>(a).map(|eps| Dual { re: T::zero(), eps });
                moved.attitude =
                    scheme.attitude::<Dual<T>, N, D>(&problem.lifted(), &along).map_err(|e| domain(h, None, e))?;
                scheme.residual::<Dual<T>, N, D>(&moved, dual)?;
                keep(dual, &mut out.inputs, &mut out.end_by_inputs, a);
            }
            moved.attitude = problem.lifted().attitude;
        }
        if scheme.moves || scheme.forced {
            moved.time = Dual::variable(start.time);
            scheme.residual::<Dual<T>, N, D>(&moved, dual)?;
            keep(dual, &mut out.inputs, &mut out.end_by_inputs, 2 * N);
            moved.time = Dual::constant(start.time);
        }
        moved.step = Dual::variable(h);
        scheme.residual::<Dual<T>, N, D>(&moved, dual)?;
        keep(dual, &mut out.inputs, &mut out.end_by_inputs, 2 * N + 1);

        // The rest is explicit: r and m are linear in μ, in ∂L/∂η and in the forces.
        let increment = dual.increment.map(|v| v.re);
        let point = self.scheme.retraction.at(&increment).map_err(|e| domain(h, None, e))?;
        let d_neg = point.d_neg();
        for a in 0..N {
            for row in 0..unknowns {
                out.inputs[(row, N + a)] = -d_neg[(a, row % N)];
            }
            out.end_by_inputs[(N + a, N + a)] = T::one();
        }
        out.tangent = *point.d();
        (out.adjoint, out.adjoint_inv) = (point.ad(), point.ad_inv());
        let momentum = dual.after_impulse.map(|v| v.re) * out.adjoint;
        let algebra = self.scheme.retraction.algebra();
        for b in 0..N {
            // ⟨μ', [e_a, e_b]⟩ = −(ad*_{e_b} μ')_a.
            let column = -algebra.coad(&basis_vector(b), &momentum).transpose();
            out.turned.set_column(b, &column);
        }
        self.parameter_columns(&problem, parameters, &d_neg, out)
    }

    /// The columns of the parameters, where the workspace of duals holds the displacements.
    fn parameter_columns<P: Parameters<T, N>>(
        &self,
        problem: &Problem<T, N, D>,
        parameters: &P,
        d_neg: &Matrix<T, N>,
        out: &mut Partials<T, N>,
    ) -> Result<(), StepError> {
        let (count, scheme, h) = (out.parameters(), &self.scheme, problem.step);
        if count == 0 {
            return Ok(());
        }
        let (s, a, b) = (scheme.tableau.stages(), scheme.tableau.a(), scheme.tableau.b());
        for j in 0..s {
            let x = self.dual.displacements.vector(j).map(|v| v.re);
            let rate = self.dual.rates.vector(j).map(|v| v.re);
            let point = scheme.retraction.at(&x).map_err(|e| domain(h, Some(j), e))?;
            let at;
            let g = match scheme.attitude::<T, N, D>(problem, &x) {
                Ok(attitude) => {
                    at = attitude;
                    Configuration::of(&at)
                }
                Err(RetractionError::NoGroup { .. }) => Configuration::identity(),
                Err(source) => return Err(domain(h, Some(j), source)),
            };
            let time = problem.time + scheme.tableau.c()[j] * h;
            let eta: Vector<T, N> = point.d() * rate;
            for k in 0..count {
                let force = parameters.force(k, time, g, &eta);
                let momentum = parameters.momentum(k, time, g, &eta);
                let p: Covector<T, N> = momentum * point.d();
                let gradient = point.pull_dd(&p, &momentum, &rate) + force * point.d();
                let impulse: Covector<T, N> = force * point.ad_inv() * (h * b[j]);
                let end = impulse * d_neg;
                let column = 2 * N + 2 + k;
                for c in 0..N {
                    out.inputs[(j * N + c, column)] += p[c];
                    out.end_by_inputs[(N + c, column)] += impulse[c];
                    for i in 0..s {
                        out.inputs[(i * N + c, column)] += h * b[j] * a[(j, i)] / b[i] * gradient[c] - end[c];
                    }
                }
            }
        }
        Ok(())
    }
}
