//! The discrete Lagrangian of a tableau: the action sum over the stages, extremised.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/discrete/stages.md"))]

use super::chord::{self, Equations, Factors, Residual};
use super::{DiscreteError, DiscreteLagrangian, Slopes, Triple, assembly};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::mechanics::doubled::{DoubledLagrangian, VelocityPoint};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::dual::along;
use crate::scalar::{Dual, Real};
use crate::tableau::Tableau;
use nalgebra::{DMatrix, DVector};

/// l_d of a tableau, for a doubled Lagrangian **l**, a retraction τ, a step h and a time t.
#[derive(Clone, Debug, PartialEq)]
pub struct StageLagrangian<T: Real, L, R, const N: usize, const D: usize> {
    lagrangian: L,
    retraction: R,
    tableau: Tableau<T>,
    step: T,
    time: T,
}

/// The extremal stages of an action sum and the multipliers of its two constraints.
#[derive(Clone, Debug)]
pub struct Extremal<T: Real, const N: usize> {
    /// H_i.
    pub first: Vec<Vector<T, N>>,
    /// Ψ_i.
    pub second: Vec<Vector<T, N>>,
    /// θ = ∂l_d/∂v with V = τ(v).
    pub theta: Covector<T, N>,
    /// φ = ∂l_d/∂w with W = τ(w).
    pub phi: Covector<T, N>,
    /// Iterations spent.
    pub iterations: usize,
    /// The residual of the stationarity conditions, relative to the momenta.
    pub residual: T,
    factors: Option<Factors<T>>,
}

impl<T: Real, const N: usize> Extremal<T, N> {
    /// (H, Ψ, θ, φ).
    fn unknowns(&self) -> DVector<T> {
        unknowns(self.first.iter().chain(&self.second).flatten(), &self.theta, &self.phi)
    }
}

/// Steps of the continuation in the positions Ξ and X of the stages.
const CONTINUATION: i64 = 4;

/// The largest distance of an extremum from its guess relative to that of the start without a guess.
const FARTHEST: i64 = 4;

/// (Ξ, H, X, Ψ) of one stage.
type Stage<T, const N: usize> = [Vector<T, N>; 4];

/// The derivatives of **l** at a stage.
struct StageSlopes<T: Real, const N: usize> {
    /// By (Ξ, H, X, Ψ).
    local: [Covector<T, N>; 4],
    /// By U in τ(−Ξ) U τ(X): L*_U and R*_U.
    left: Covector<T, N>,
    right: Covector<T, N>,
}

impl<T, L, R, const N: usize, const D: usize> StageLagrangian<T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    /// l_d for a step `h` from time 0.
    pub fn new(lagrangian: L, retraction: R, tableau: Tableau<T>, h: T) -> Self {
        Self { lagrangian, retraction, tableau, step: h, time: T::zero() }
    }

    /// The same for a step from time t.
    pub fn at_time(self, t: T) -> Self {
        Self { time: t, ..self }
    }

    /// The extremal stages for V = τ(v), U, W = τ(w), by Newton's method from H_i = v/h, Ψ_i = w/h or from a `guess`.
    ///
    /// The start is the extremum for Ξ = X = 0; where Newton's method fails, Ξ and X are turned on in four steps. A guess decides how fast the
    /// extremum is found, not which: where the one that is found is far from the guess, the start is that without a guess.
    ///
    /// # Errors
    /// No convergence; singular conditions; a stage outside a domain; numbers that are not finite, h = 0 among them.
    pub fn extremise(
        &self,
        v: &Vector<T, N>,
        u: &Matrix<T, D>,
        w: &Vector<T, N>,
        guess: Option<&Extremal<T, N>>,
    ) -> Result<Extremal<T, N>, DiscreteError> {
        let s = self.tableau.stages();
        let (eta, psi) = (v / self.step, w / self.step);
        if !eta.iter().chain(&psi).all(|x| x.all_finite()) {
            return Err(DiscreteError::NotFinite { what: "a mean velocity v/h or w/h" });
        }
        if !u.iter().all(|x| x.all_finite()) {
            return Err(DiscreteError::NotFinite { what: "U" });
        }
        let start = self.start(&eta, u, &psi)?;
        let (mut x, factors) = match guess.filter(|guess| guess.first.len() == s && guess.second.len() == s) {
            Some(guess) => (guess.unknowns(), guess.factors.clone()),
            None => (start.clone(), None),
        };
        let weight = self.weight(&eta, &psi, &start);
        let mut conditions = Conditions { l_d: self, u, eta, psi, weight, h: self.step, certified: false };
        let from = guess.map(|_| x.clone());
        let mut near = chord::solve(&mut conditions, &mut x, factors);
        if let Some(from) = from
            && !(near.is_ok() && (&x - &from).amax() <= (&from - &start).amax() * T::int(FARTHEST))
        {
            // The extremum must not depend on the guess; far away it may be another one, or none: at huge rates a residual is small beside
            // its terms.
            x.copy_from(&start);
            near = chord::solve(&mut conditions, &mut x, None);
        }
        if near.is_err() {
            x = start;
            for k in 1..=CONTINUATION {
                conditions.h = self.step * T::ratio(k, CONTINUATION);
                near = chord::solve(&mut conditions, &mut x, None);
                if near.is_err() {
                    break;
                }
            }
        }
        let near = near?;
        conditions.certified = true;
        let solved = chord::solve(&mut conditions, &mut x, near.factors)?;
        let [first, second] = rates::<T, N>(&x, s);
        Ok(Extremal {
            first,
            second,
            theta: block::<T, N>(&x, 2 * s).transpose(),
            phi: block::<T, N>(&x, 2 * s + 1).transpose(),
            iterations: near.iterations + solved.iterations,
            residual: solved.residual,
            factors: solved.factors,
        })
    }

    /// The extremum at (V, U, W) near given stages (H, Ψ), to go on from as a memory: where there are several extrema, these say which one is
    /// meant. It solves the conditions of [`extremise`](Self::extremise), whatever the stages are.
    ///
    /// # Errors
    /// Those of [`extremise`](Self::extremise).
    pub fn near(
        &self,
        x: &Triple<T, D>,
        first: &[Vector<T, N>],
        second: &[Vector<T, N>],
    ) -> Result<Extremal<T, N>, DiscreteError> {
        let (v, w) = self.coordinates(x)?;
        let (eta, psi) = (v / self.step, w / self.step);
        let mut guess = Extremal {
            first: first.to_vec(),
            second: second.to_vec(),
            theta: Covector::zeros(),
            phi: Covector::zeros(),
            iterations: 0,
            residual: T::zero(),
            factors: None,
        };
        let s = self.tableau.stages();
        if first.len() == s && second.len() == s {
            // The conditions of the first stage, without multipliers, are the multipliers.
            let unknowns = guess.unknowns();
            let mut conditions =
                Conditions { l_d: self, u: &x.u, eta, psi, weight: T::one(), h: self.step, certified: false };
            let (residual, _) = conditions.residual(&unknowns)?;
            guess.theta = block::<T, N>(&residual, 0).transpose();
            guess.phi = block::<T, N>(&residual, s).transpose();
        }
        self.extremise(&v, &x.u, &w, Some(&guess))
    }

    /// Σ_i h b_i **l** at the stages of an extremal.
    ///
    /// # Errors
    /// A stage outside a domain.
    pub fn action(&self, u: &Matrix<T, D>, extremal: &Extremal<T, N>) -> Result<T, DiscreteError> {
        let out = DiscreteError::domain("a stage");
        let mut sum = T::zero();
        for i in 0..self.tableau.stages() {
            let [xi, rate, chi, partner] = self.stage(i, self.step, &extremal.first, &extremal.second);
            let eta = self.retraction.at(&xi).map_err(&out)?.d() * rate;
            let psi = self.retraction.at(&chi).map_err(&out)?.d() * partner;
            let u = self.relative(&xi, u, &chi).map_err(&out)?;
            let value =
                self.lagrangian.value(&VelocityPoint { time: self.stage_time(i), eta, u, psi }).map_err(&out)?;
            sum += value * (self.step * self.tableau.b()[i]);
        }
        Ok(sum)
    }

    /// v = τ⁻¹(V), w = τ⁻¹(W).
    fn coordinates(&self, x: &Triple<T, D>) -> Result<(Vector<T, N>, Vector<T, N>), DiscreteError> {
        let v = self.retraction.tau_inv(&x.v).map_err(DiscreteError::domain("V"))?;
        let w = self.retraction.tau_inv(&x.w).map_err(DiscreteError::domain("W"))?;
        Ok((v, w))
    }

    /// t + c_i h.
    fn stage_time(&self, i: usize) -> T {
        self.time + self.tableau.c()[i] * self.step
    }

    /// (Ξ_i, H_i, X_i, Ψ_i), the positions for a step h.
    fn stage(&self, i: usize, h: T, first: &[Vector<T, N>], second: &[Vector<T, N>]) -> Stage<T, N> {
        let sum = |rates: &[Vector<T, N>]| {
            let terms = rates.iter().enumerate().map(|(j, rate)| rate * self.tableau.a()[(i, j)]);
            terms.fold(Vector::<T, N>::zeros(), |sum, term| sum + term) * h
        };
        [sum(first), first[i], sum(second), second[i]]
    }

    /// τ(−Ξ) U τ(X).
    fn relative(
        &self,
        xi: &Vector<T, N>,
        u: &Matrix<T, D>,
        chi: &Vector<T, N>,
    ) -> Result<Matrix<T, D>, RetractionError> {
        Ok(self.retraction.tau(&-xi)? * u * self.retraction.tau(chi)?)
    }

    /// The derivatives of **l** at stage i: ∂_x(dτ_x y) by dτ on dual numbers if `certified`, else as dτ_x ddτ_x(y, ·), which is several
    /// times cheaper.
    fn stage_slopes(
        &self,
        i: usize,
        u: &Matrix<T, D>,
        [xi, rate, chi, partner]: &Stage<T, N>,
        certified: bool,
    ) -> Result<StageSlopes<T, N>, DiscreteError> {
        let out = DiscreteError::domain("a stage");
        let (here, there) = (self.retraction.at(xi).map_err(&out)?, self.retraction.at(chi).map_err(&out)?);
        let (eta, psi) = (here.d() * rate, there.d() * partner);
        let relative = self.relative(xi, u, chi).map_err(&out)?;
        let by = self
            .lagrangian
            .partials(&VelocityPoint { time: self.stage_time(i), eta, u: relative, psi })
            .map_err(&out)?;
        // p ∂_x(dτ_x y).
        let bend = |p: &Covector<T, N>, x: &Vector<T, N>, point: &R::Point<T>, y: &Vector<T, N>| {
            if !certified {
                return Ok(p * point.d() * point.dd(y));
            }
            let mut row = Covector::zeros();
            for a in 0..N {
                let moved = (self.retraction.at(&along(x, a))?.d() * y.map(Dual::constant)).map(|v| v.eps);
                row[a] = pair(p, &moved);
            }
            Ok(row)
        };
        Ok(StageSlopes {
            local: [
                bend(&by.eta, xi, &here, rate).map_err(&out)? - by.right * here.d(),
                by.eta * here.d(),
                bend(&by.psi, chi, &there, partner).map_err(&out)? + by.left * there.d(),
                by.psi * there.d(),
            ],
            left: by.left * there.ad_inv(),
            right: by.right * here.ad_inv(),
        })
    }

    /// H_i = v/h, Ψ_i = w/h and the multipliers that make them stationary for h → 0: those at V = W = e.
    fn start(&self, eta: &Vector<T, N>, u: &Matrix<T, D>, psi: &Vector<T, N>) -> Result<DVector<T>, DiscreteError> {
        let out = DiscreteError::domain("U");
        let by =
            self.lagrangian.partials(&VelocityPoint { time: self.time, eta: *eta, u: *u, psi: *psi }).map_err(out)?;
        let of_stages = |rate| std::iter::repeat_n(rate, self.tableau.stages()).flatten();
        Ok(unknowns(of_stages(eta).chain(of_stages(psi)), &by.eta, &by.psi))
    }

    /// What turns a velocity into a momentum, for the constraints to be measured like the conditions.
    fn weight(&self, eta: &Vector<T, N>, psi: &Vector<T, N>, x: &DVector<T>) -> T {
        let momentum = x.rows(2 * self.tableau.stages() * N, 2 * N).amax();
        let velocity = eta.amax().max(psi.amax());
        if momentum > T::zero() && velocity > T::zero() { momentum / velocity } else { T::one() }
    }
}

/// Rates and multipliers in one list.
fn unknowns<'a, T: Real, const N: usize>(
    rates: impl Iterator<Item = &'a T>,
    theta: &'a Covector<T, N>,
    phi: &'a Covector<T, N>,
) -> DVector<T> {
    DVector::from_vec(rates.chain(theta).chain(phi).copied().collect())
}

/// The k-th run of N entries.
fn block<T: Real, const N: usize>(x: &DVector<T>, k: usize) -> Vector<T, N> {
    Vector::from_fn(|a, _| x[k * N + a])
}

/// (H, Ψ) of s stages.
fn rates<T: Real, const N: usize>(x: &DVector<T>, s: usize) -> [Vec<Vector<T, N>>; 2] {
    [0, s].map(|from| (from..from + s).map(|k| block(x, k)).collect())
}

/// The conditions for an extremum, in the unknowns (H, Ψ, θ, φ): for each k
///
/// ∂_H l_k + h Σ_i (b_i a_ik / b_k) ∂_Ξ l_i = θ and ∂_Ψ l_k + h Σ_i (b_i a_ik / b_k) ∂_X l_i = φ,
///
/// the derivatives of the action sum divided by h b_k, and the two constraints.
struct Conditions<'a, T: Real, L, R, const N: usize, const D: usize> {
    l_d: &'a StageLagrangian<T, L, R, N, D>,
    u: &'a Matrix<T, D>,
    eta: Vector<T, N>,
    psi: Vector<T, N>,
    weight: T,
    /// The step, or the part of it that has been turned on.
    h: T,
    /// Whether derivatives of dτ are taken by dual numbers; else ddτ stands for them, which is several times cheaper.
    certified: bool,
}

impl<T, L, R, const N: usize, const D: usize> Equations<T> for Conditions<'_, T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    fn name(&self) -> &'static str {
        "the conditions for extremal stages"
    }

    fn residual(&mut self, x: &DVector<T>) -> Result<Residual<T>, DiscreteError> {
        let s = self.l_d.tableau.stages();
        let [first, second] = rates::<T, N>(x, s);
        let mut gradient = DMatrix::zeros(s, 4 * N);
        for i in 0..s {
            let stage = self.l_d.stage(i, self.h, &first, &second);
            let slopes = self.l_d.stage_slopes(i, self.u, &stage, self.certified)?;
            gradient
                .row_mut(i)
                .iter_mut()
                .zip(slopes.local.iter().flatten())
                .for_each(|(entry, slope)| *entry = *slope);
        }
        let mean: Vec<T> = self.eta.iter().chain(&self.psi).copied().collect();
        Ok(assembly::residual(&self.l_d.tableau, self.h, &gradient, x, &mean, self.weight))
    }

    /// By forward differences: near enough.
    fn jacobian(&mut self, x: &DVector<T>) -> Result<DMatrix<T>, DiscreteError> {
        let s = self.l_d.tableau.stages();
        let [first, second] = rates::<T, N>(x, s);
        let velocity = x.rows(0, 2 * s * N).amax();
        // Of positions in the group, and of velocities.
        let unit = T::unit_roundoff().sqrt();
        let steps = [unit, if velocity > T::zero() { unit * velocity } else { unit }];
        let mut second_derivatives = Vec::with_capacity(s);
        for i in 0..s {
            let here = self.l_d.stage(i, self.h, &first, &second);
            let gradient = |stage: &Stage<T, N>| {
                let slopes = self.l_d.stage_slopes(i, self.u, stage, false)?;
                Ok::<_, DiscreteError>(DVector::from_iterator(4 * N, slopes.local.iter().flatten().copied()))
            };
            let start = gradient(&here)?;
            let mut hessian = DMatrix::zeros(4 * N, 4 * N);
            for column in 0..4 * N {
                let (slot, step) = (column / N, steps[column / N % 2]);
                let mut moved = here;
                moved[slot][column % N] += step;
                hessian.set_column(column, &((gradient(&moved)? - &start) / step));
            }
            second_derivatives.push(hessian);
        }
        Ok(assembly::jacobian(&self.l_d.tableau, self.h, &second_derivatives, self.weight))
    }
}

impl<T, L, R, const N: usize, const D: usize> DiscreteLagrangian<T, N, D> for StageLagrangian<T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    type Memory = Option<Extremal<T, N>>;

    fn value(&self, x: &Triple<T, D>) -> Result<T, DiscreteError> {
        let (v, w) = self.coordinates(x)?;
        self.action(&x.u, &self.extremise(&v, &x.u, &w, None)?)
    }

    /// By the envelope theorem, at fixed stages: L*_V D₁ = θ dτ_v⁻¹, R*_V D₁ = θ dτ_{−v}⁻¹, likewise φ for W, and U is
    /// moved inside **l** alone.
    fn slopes_from(&self, x: &Triple<T, D>, memory: &mut Self::Memory) -> Result<Slopes<T, N>, DiscreteError> {
        let (v, w) = self.coordinates(x)?;
        let extremal = self.extremise(&v, &x.u, &w, memory.as_ref())?;
        let ends = |v: &Vector<T, N>, what| {
            let at = |v: &Vector<T, N>| self.retraction.at(v).map_err(DiscreteError::domain(what));
            Ok::<_, DiscreteError>((at(v)?, at(&-v)?))
        };
        let ((v, v_back), (w, w_back)) = (ends(&v, "V")?, ends(&w, "W")?);
        let (mut u_left, mut u_right) = (Covector::zeros(), Covector::zeros());
        for i in 0..self.tableau.stages() {
            let stage = self.stage(i, self.step, &extremal.first, &extremal.second);
            let slopes = self.stage_slopes(i, &x.u, &stage, false)?;
            let weight = self.step * self.tableau.b()[i];
            u_left += slopes.left * weight;
            u_right += slopes.right * weight;
        }
        let slopes = Slopes {
            v_left: extremal.theta * v.d_inv(),
            v_right: extremal.theta * v_back.d_inv(),
            u_left,
            u_right,
            w_left: extremal.phi * w.d_inv(),
            w_right: extremal.phi * w_back.d_inv(),
        };
        *memory = Some(extremal);
        Ok(slopes)
    }
}
