//! Fixed-point iterations on (M_i, Ξ_i), M_i the momenta at the stages in the frame of the body, by the equations of motion themselves:
//!
//! M_i = μ + h Σ_j â_ij (ad*_{η_j} M_j + f_j) + δM_i, Ξ_i = h Σ_j a_ij dτ⁻¹_{Ξ_j} η_j + δΞ_i.
//!
//! They need no tangents of τ as matrices, and contract better than those on (P_i, Ξ_i). What the variational scheme has besides, δ, is of
//! the size of its error, and frozen: each evaluation of the scheme gives it anew.

use super::iteration::relative_change;
use super::parts::Parts;
use super::{Problem, Scheme, Work, largest};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Matrix, pull};
use crate::integrators::stages::Stages;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, larger};

/// The quantities of the stages that these iterations need besides those of the scheme.
#[derive(Clone, Debug)]
pub(super) struct Collocation<T: Real, const N: usize> {
    brackets: Brackets<T>,
    /// M_i.
    pub momenta: Stages<T, N>,
    /// f_i.
    pub forces: Stages<T, N>,
    /// dτ⁻¹ at Ξ_i of the last evaluation of the scheme.
    pub tangents: Vec<Matrix<T, N>>,
    /// dτ_ξ⁻¹ and Ad_{τ(ξ)}⁻¹ at the end of the last evaluation of the scheme.
    pub tangent_inv: Matrix<T, N>,
    pub coadjoint_inv: Matrix<T, N>,
    /// Ṁ_i.
    slopes: Stages<T, N>,
    /// dτ⁻¹ η_i, more or less.
    rates: Stages<T, N>,
    next_momenta: Stages<T, N>,
    next_displacements: Stages<T, N>,
    /// δM_i.
    momentum_shifts: Stages<T, N>,
    /// δΞ_i.
    displacement_shifts: Stages<T, N>,
}

impl<T: Real, const N: usize> Collocation<T, N> {
    pub fn new(brackets: Brackets<T>, stages: usize) -> Self {
        let zeros = Stages::zeros(stages);
        Self {
            brackets,
            momenta: zeros.clone(),
            forces: zeros.clone(),
            tangent_inv: Matrix::zeros(),
            coadjoint_inv: Matrix::zeros(),
            tangents: vec![Matrix::zeros(); stages],
            slopes: zeros.clone(),
            rates: zeros.clone(),
            next_momenta: zeros.clone(),
            next_displacements: zeros.clone(),
            momentum_shifts: zeros.clone(),
            displacement_shifts: zeros,
        }
    }

    /// δ = 0.
    pub fn unshift(&mut self) {
        self.momentum_shifts.clear();
        self.displacement_shifts.clear();
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Scheme<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Σ_j of the slopes and rates at the stages, without δ: the next M_i − δM_i and Ξ_i − δΞ_i.
    fn gather(&self, problem: &Problem<T, N, D>, own: &mut Collocation<T, N>) {
        let Collocation { slopes, rates, next_momenta, next_displacements, .. } = own;
        next_momenta.advance(&self.coefficients.conjugate, slopes, problem.step, Some(&problem.momentum));
        next_displacements.advance(&self.coefficients.weights, rates, problem.step, None);
    }

    /// The slopes and rates at the stages: ad*_{η_i} M_i + f_i and dτ⁻¹ η_i, more or less.
    fn turn(&self, work: &Work<T, N>, own: &mut Collocation<T, N>) {
        let Collocation { brackets, momenta, forces, slopes, rates, .. } = own;
        let (x, eta) = (&work.displacements, &work.velocities);
        slopes.map_lanes([eta, momenta], |[eta, m]| brackets.coads(eta, m), |[eta, m]| brackets.coads(eta, m));
        if self.forced {
            slopes.add(forces);
        }
        rates.map_lanes(
            [x, eta],
            |[x, eta]| self.retraction.rough_rates(brackets, x, eta),
            |[x, eta]| self.retraction.rough_rates(brackets, x, eta),
        );
    }

    /// One iteration; returns the largest relative change, and what that of M_i is relative to. `None`: a stage has no velocity, or left the
    /// domain.
    pub(super) fn collocate(
        &self,
        problem: &Problem<T, N, D>,
        work: &mut Work<T, N>,
        own: &mut Collocation<T, N>,
    ) -> Option<(T, T)> {
        let mut load = problem.rounding;
        for i in 0..self.coefficients.tableau.stages() {
            let (m, x) = (own.momenta.covector(i), work.displacements.vector(i));
            let time = problem.time + self.coefficients.tableau.c()[i] * problem.step;
            let at;
            let g = if self.moves {
                at = Parts::<T, N, D>::attitude(self, &problem.attitude, &x).ok()?;
                Configuration::of(&at)
            } else {
                Configuration::identity()
            };
            let eta = self.velocity(time, g, &m, &work.velocities.vector(i)).ok()?;
            if self.forced {
                let (f, size) = Parts::<T, N, D>::total_force(self, time, g, &eta);
                load = larger(load, size);
                own.forces.set_covector(i, &f);
            }
            work.velocities.set_vector(i, &eta);
        }
        self.turn(work, own);
        self.gather(problem, own);
        own.next_momenta.add(&own.momentum_shifts);
        own.next_displacements.add(&own.displacement_shifts);
        let (momenta, displacements) =
            ([&own.next_momenta, &own.momenta], [&own.next_displacements, &work.displacements]);
        let sizes = [largest(&problem.momentum), load * problem.step.abs()];
        let changed = relative_change(momenta, displacements, work.factors.as_ref(), sizes);
        std::mem::swap(&mut own.next_momenta, &mut own.momenta);
        std::mem::swap(&mut own.next_displacements, &mut work.displacements);
        Some(changed)
    }

    /// δ from an evaluation of the scheme, and M_i, Ξ_i as the scheme has them next.
    pub(super) fn shift(&self, problem: &Problem<T, N, D>, work: &mut Work<T, N>, own: &mut Collocation<T, N>) {
        self.turn(work, own);
        self.gather(problem, own);
        own.displacement_shifts.difference(&work.next_displacements, &own.next_displacements);
        // P_i' − P_i. What is common to the stages acts like another momentum at the start, of which the scheme takes ε − ε dτ_{−ξ} back.
        work.next_momenta.subtract(&work.momenta);
        let common = work.next_momenta.sum(self.coefficients.tableau.b().as_slice()).transpose();
        let started = pull(&pull(&common, &own.tangent_inv), &own.coadjoint_inv);
        for i in 0..self.coefficients.tableau.stages() {
            let change = started + pull(&(work.next_momenta.covector(i) - common), &own.tangents[i]);
            own.momenta.set_covector(i, &(own.momenta.covector(i) + change));
            own.momentum_shifts.set_covector(i, &(own.momentum_shifts.covector(i) + change));
        }
        std::mem::swap(&mut work.next_displacements, &mut work.displacements);
    }
}
