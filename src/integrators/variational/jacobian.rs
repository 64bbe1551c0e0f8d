//! The Jacobian of the stage equations.
//!
//! Stage i depends on (Ξ_i, H_i) alone, and ∂r/∂H is linear in its derivatives: N along Ξ_i in dual numbers, and N along H_i, in which P_i and
//! G_i are linear but for ∂L/∂η and the force. To differentiate r along each of the sN components of H takes s times as many.

use super::parts::Mechanics;
use super::{Coefficients, Problem, Terms, domain};
use crate::algebra::{Covector, Matrix, Vector, apply, basis_vector, pull};
use crate::integrators::StepError;
use crate::integrators::stages::Stages;
use crate::retraction::TangentPoint;
use crate::scalar::{Dual, Real};
use nalgebra::DMatrix;

/// v + ε e_a.
pub(super) fn varied<T: Real, const N: usize>(v: &Vector<T, N>, a: usize) -> Vector<Dual<T>, N> {
    v.zip_map(&basis_vector(a), |re, eps| Dual { re, eps })
}

impl<T: Real, const N: usize> Terms<T, N> {
    pub fn zero() -> Self {
        Self { momentum: Covector::zeros(), gradient: Covector::zeros(), impulse: Covector::zeros() }
    }

    pub fn add(&mut self, other: &Self, factor: T) {
        self.momentum += other.momentum * factor;
        self.gradient += other.gradient * factor;
        self.impulse += other.impulse * factor;
    }
}

impl<T: Real, const N: usize> Terms<Dual<T>, N> {
    /// Their derivative.
    fn slope(&self) -> Terms<T, N> {
        let slope = |covector: &Covector<Dual<T>, N>| covector.map(|v| v.eps);
        Terms { momentum: slope(&self.momentum), gradient: slope(&self.gradient), impulse: slope(&self.impulse) }
    }
}

/// The terms of a stage, and how they change along e_a in Ξ_i and in H_i.
#[derive(Clone, Debug)]
pub(super) struct Linear<T: Real, const N: usize> {
    /// Ξ_i/h.
    pub direction: Vector<T, N>,
    pub terms: Terms<T, N>,
    pub by_displacement: [Terms<T, N>; N],
    pub by_rate: [Terms<T, N>; N],
}

impl<T: Real, const N: usize> Linear<T, N> {
    pub fn zero() -> Self {
        let zero = Terms::zero();
        Self { direction: Vector::zeros(), terms: zero, by_displacement: [zero; N], by_rate: [zero; N] }
    }

    /// Their change where Ξ_i changes by `share` e_a, and H_i by e_a or not at all.
    pub fn along(&self, a: usize, share: T, own: bool) -> Terms<T, N> {
        let mut terms = if own { self.by_rate[a] } else { Terms::zero() };
        if share != T::zero() {
            terms.add(&self.by_displacement[a], share);
        }
        terms
    }
}

/// A stage and where it is: the tangents of τ at Ξ_i, g τ(Ξ_i), t_i, H_i, M_i and P_i.
pub(super) struct Place<'a, T: Real, const N: usize, const D: usize> {
    point: &'a dyn TangentPoint<T, N>,
    attitude: Matrix<T, D>,
    time: T,
    rate: Vector<T, N>,
    momenta: [Covector<T, N>; 2],
}

/// What is done with stage i and its derivatives.
type Then<'a, T, const N: usize, const D: usize> =
    &'a mut dyn FnMut(usize, &Place<'_, T, N, D>, &Linear<T, N>) -> Result<(), StepError>;

/// What a stage changes along, besides Ξ_i.
pub(super) enum Argument<'a, T: Real, const N: usize, const D: usize> {
    /// e_a in H_i.
    Rate(usize),
    /// g τ(Ξ_i), as a dual number.
    Attitude(&'a Matrix<Dual<T>, D>),
    Time,
}

/// ξ and m, dτ_{−ξ}, and the derivative of m dτ_{−ξ} along e_a in ξ in row a.
pub(super) struct End<T: Real, const N: usize> {
    pub increment: Vector<T, N>,
    pub momentum: Covector<T, N>,
    pub d_neg: Matrix<T, N>,
    turning: Matrix<T, N>,
}

/// The workspace for J.
#[derive(Clone, Debug)]
pub(super) struct Jacobian<T: Real, const N: usize> {
    pub stages: Vec<Linear<T, N>>,
    /// The changes of the terms along one unknown.
    pub along: Vec<Terms<T, N>>,
}

impl<T: Real, const N: usize> Jacobian<T, N> {
    pub fn new(stages: usize) -> Self {
        Self { stages: vec![Linear::zero(); stages], along: vec![Terms::zero(); stages] }
    }
}

impl<T: Real, const N: usize, const D: usize> Mechanics<'_, T, N, D> {
    /// Stage i at H_i, of which Ξ_i/h is known, and its derivatives; hands on where it is.
    fn linearise(
        &self,
        problem: &Problem<T, N, D>,
        i: usize,
        rate: &Vector<T, N>,
        out: &mut Linear<T, N>,
        then: Then<'_, T, N, D>,
    ) -> Result<(), StepError> {
        let (h, tableau) = (problem.step, &self.coefficients.tableau);
        let failed = |e| domain(h, Some(i), e);
        let time = problem.time + tableau.c()[i] * h;
        let x = out.direction * h;
        let attitude = self.placed(problem, &x).map_err(failed)?;
        // Where Ξ_i depends on no stage it stays 0.
        let moved = tableau.a().row(i).iter().any(|a| *a != T::zero());
        self.with((Some(i), h), &x, |point| {
            let stage = self.stage((i, h), time, self.configuration(&attitude), point, rate)?;
            let m = self.parts.momentum(time, self.configuration(&attitude), &stage.velocity);
            let place = Place { point, attitude, time, rate: *rate, momenta: [m, stage.terms.momentum] };
            out.terms = stage.terms;
            for a in 0..N {
                out.by_rate[a] = self.respond(&place, Argument::Rate(a));
                out.by_displacement[a] = Terms::zero();
            }
            if moved {
                self.displace(problem, (i, time), (&x, rate), &mut out.by_displacement)?;
            }
            then(i, &place, out)
        })?
    }

    /// The changes of stage i along e_a in Ξ_i.
    fn displace(
        &self,
        problem: &Problem<T, N, D>,
        (i, time): (usize, T),
        (x, rate): (&Vector<T, N>, &Vector<T, N>),
        out: &mut [Terms<T, N>; N],
    ) -> Result<(), StepError> {
        let h = problem.step;
        let (time, rate) = (Dual::constant(time), rate.map(Dual::constant));
        for (a, terms) in out.iter_mut().enumerate() {
            let x = varied(x, a);
            let attitude = self.placed(problem, &x).map_err(|e| domain(h, Some(i), e))?;
            let stage = self.with((Some(i), h), &x, |point| {
                self.stage((i, h), time, self.configuration(&attitude), point, &rate)
            })??;
            *terms = stage.terms.slope();
        }
        Ok(())
    }

    /// The change of a stage along anything but Ξ_i: with tangents as they are, P = M dτ, G = P ddτ(H, ·) + f dτ and f Ad⁻¹ are linear.
    pub(super) fn respond(
        &self,
        Place { point, attitude, time, rate, momenta }: &Place<'_, T, N, D>,
        argument: Argument<'_, T, N, D>,
    ) -> Terms<T, N> {
        let along: Vector<T, N> = match argument {
            Argument::Rate(a) => basis_vector(a),
            _ => Vector::zeros(),
        };
        let velocity = apply(point.d(), rate).zip_map(&apply(point.d(), &along), |re, eps| Dual { re, eps });
        let constant;
        let (time, attitude) = match argument {
            Argument::Attitude(attitude) => (Dual::constant(*time), attitude),
            _ => {
                constant = attitude.map(Dual::constant);
                let eps = if matches!(argument, Argument::Time) { T::one() } else { T::zero() };
                (Dual { re: *time, eps }, &constant)
            }
        };
        let m = self.parts.momentum(time, self.configuration(attitude), &velocity).map(|v| v.eps);
        let momentum = pull(&m, point.d());
        let mut gradient = point.pull_dd(&momentum, &m, rate);
        if matches!(argument, Argument::Rate(_)) {
            let [m, p] = momenta;
            gradient += point.pull_dd(p, m, &along);
        }
        if !self.forced {
            return Terms { momentum, gradient, impulse: Covector::zeros() };
        }
        let force = self.parts.total_force(time, self.configuration(attitude), &velocity).0.map(|v| v.eps);
        let seen = pull(&force, point.d());
        Terms { momentum, gradient: gradient + seen, impulse: point.pull_ad_inv(&force, &seen) }
    }

    /// The end of a step with this ξ and m.
    fn end(&self, h: T, increment: Vector<T, N>, momentum: Covector<T, N>) -> Result<End<T, N>, StepError> {
        self.with((None, h), &-increment, |point| {
            let (d_neg, mut turning) = (*point.d(), Matrix::<T, N>::zeros());
            let pulled = pull(&momentum, &d_neg);
            for c in 0..N {
                // m dτ_{−ξ} e_c along e_a in ξ is −m dτ_{−ξ} ddτ_{−ξ}(e_c, e_a).
                turning.set_column(c, &-point.pull_dd(&pulled, &momentum, &basis_vector(c)).transpose());
            }
            End { increment, momentum, d_neg, turning }
        })
    }

    /// A column of ∂r, and of ∂(ξ, m) where that is asked for, from the changes of the terms of the stages and of ξ.
    pub(super) fn column(
        &self,
        (h, end): (T, &End<T, N>),
        along: &[Terms<T, N>],
        increment: &Vector<T, N>,
        (rows, ends, column): (&mut DMatrix<T>, Option<&mut DMatrix<T>>, usize),
    ) {
        let Coefficients { tableau, coupling, .. } = self.coefficients;
        let weighted = along.iter().zip(tableau.b());
        let impulse = weighted.fold(Covector::zeros(), |sum, (terms, &b)| sum + terms.impulse * (h * b));
        let common: Covector<T, N> = impulse * end.d_neg + increment.transpose() * end.turning;
        for i in 0..along.len() {
            let coupled = along.iter().enumerate();
            let coupled = coupled.fold(Covector::zeros(), |sum, (j, terms)| sum + terms.gradient * coupling.get(i, j));
            let residual: Covector<T, N> = along[i].momentum - common + coupled * h;
            for c in 0..N {
                rows[(i * N + c, column)] = residual[c];
            }
        }
        if let Some(ends) = ends {
            for c in 0..N {
                ends[(c, column)] = increment[c];
                ends[(N + c, column)] = impulse[c];
            }
        }
    }

    /// J = ∂r/∂H, sN×sN, at these H_i, and ∂(ξ, m)/∂H where that is asked for; hands on each stage, and returns the end.
    pub(super) fn jacobian(
        &self,
        problem: &Problem<T, N, D>,
        rates: &Stages<T, N>,
        Jacobian { stages, along }: &mut Jacobian<T, N>,
        (rows, mut ends): (&mut DMatrix<T>, Option<&mut DMatrix<T>>),
        then: Then<'_, T, N, D>,
    ) -> Result<End<T, N>, StepError> {
        let tableau = &self.coefficients.tableau;
        let (h, a, b) = (problem.step, tableau.a(), tableau.b());
        let mut momentum = problem.momentum;
        for (i, stage) in stages.iter_mut().enumerate() {
            let directions = (0..along.len()).map(|j| rates.vector(j) * a[(i, j)]);
            stage.direction = directions.fold(Vector::zeros(), |sum, v| sum + v);
            self.linearise(problem, i, &rates.vector(i), stage, then)?;
            momentum += stage.terms.impulse * (h * b[i]);
        }
        let end = self.end(h, rates.sum(b.as_slice()) * h, momentum)?;
        for k in 0..stages.len() {
            for e in 0..N {
                for (j, (terms, stage)) in along.iter_mut().zip(&*stages).enumerate() {
                    *terms = stage.along(e, h * a[(j, k)], j == k);
                }
                let increment = basis_vector(e) * (h * b[k]);
                self.column((h, &end), along, &increment, (rows, ends.as_deref_mut(), k * N + e));
            }
        }
        Ok(end)
    }
}
