//! The variational scheme of a tableau and a retraction, to be compared with: its step in 32 digits, and how much the end of a step
//! shows of what is left of its stage equations.
//!
//! A step solves r(H) = 0 for the rates H of its stages. A method makes up r_k by sums, products and series of n×n matrices in 16
//! digits, or stops its iteration at a tolerance. So r_k is not 0, but up to
//!
//! ```text
//! ρ_k = c u (S + Σ_l |∂r_k/∂H_l H_l|),   c = 16 n (1 + A h |C||η|)   or   c u = 16 times the tolerance that is claimed
//! ```
//!
//! with S the largest term of the equations, forces included. The sum is what a relative change of the rates, of the inertia or of the
//! tableau does. A h |C||η| is what rounded structure constants do to ad of a displacement; A is the largest of the sums Σ_j |a_ij|,
//! Σ_j |b_j a_ji/b_i|, Σ_j |b_j|. By the implicit function theorem the end of the step moves by Σ_k |∂(g', μ')/∂H J⁻¹ e_k| ρ_k,
//! J = ∂r/∂H, all of it from dual numbers ([`Linearised`]). The last products g' = g τ(ξ) and μ' = m Ad_τ(ξ) round as well: c u of
//! their terms. Nothing of this is fitted.
//!
//! Near a fold J⁻¹ is large, and beyond it there is no step: there the scheme refuses, and nothing is compared.

use super::theory::NO_INVERSE;
use super::{Point, StateForm, SystemParts};
use crate::algebra::{Matrix, Vector, basis_vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::integrators::derivative::{Linearised, Variation};
use crate::integrators::{OneStep, StepError};
use crate::laws::planted::retraction::Plant;
use crate::laws::source::Source;
use crate::retraction::Retraction;
use crate::scalar::Dd;
use crate::system::case::Method;
use crate::system::{Case, CaseError, System, Visitor};
use crate::tableau::Tableau;

/// The variational scheme of a tableau and a retraction on a system.
pub struct Scheme {
    /// A step in 32 digits; its errors are those of [`Variational`].
    pub exact: OfStep<Dd, Point<Dd>>,
    /// How far the end of a step moves; its errors are those of [`Linearised::step`], in 16 digits.
    pub(super) spread: OfStep<f64, Spread>,
    /// A.
    pub(super) sums: f64,
}

/// What is asked of a step from a state, of this size.
type OfStep<T, O> = Box<dyn Fn(&Point<T>, T) -> Result<O, StepError>>;

/// How far the end of a step moves, the largest components of μ' and of what stands beside it, where the stage equations and the last
/// products hold up to their terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// Of μ'.
    pub momentum: f64,
    /// Of g', or of the point.
    pub beside: f64,
}

impl Scheme {
    /// The scheme on the system of a source, for a method with this state.
    ///
    /// # Errors
    /// [`StepError::Unsupported`] where it does not apply: a retraction that the group does not have.
    pub fn of<S: Source>(source: &S, method: &Method, form: &StateForm) -> Result<Self, StepError> {
        let unsupported = |error: CaseError| StepError::Unsupported { why: error.to_string() };
        let mut case: Case = source.case().clone();
        case.method = method.clone();
        // Its coordinates are those of the retraction of the case; where a step starts is said anew.
        case.start.attitude = None;
        let source = source.with_case(case);
        let tableau = method.tableau.build::<f64>();
        let tableau = tableau.map_err(|error| StepError::Unsupported { why: error.to_string() })?;
        Ok(Self {
            exact: source.visit::<Dd, _>(&Plant(None), Exact(form.clone())).map_err(unsupported)?,
            spread: source.visit::<f64, _>(&Plant(None), Linear(form.clone())).map_err(unsupported)?,
            sums: sums(&tableau),
        })
    }
}

/// The largest of Σ_j |a_ij|, Σ_j |b_j a_ji/b_i| and Σ_j |b_j|, which is 1 at least.
fn sums(tableau: &Tableau<f64>) -> f64 {
    let (a, b, s) = (tableau.a(), tableau.b(), tableau.stages());
    let sum = |term: &dyn Fn(usize) -> f64| (0..s).map(|j| term(j).abs()).sum::<f64>();
    let rows = (0..s).map(|i| sum(&|j| a[(i, j)]).max(sum(&|j| b[j] * a[(j, i)] / b[i])));
    rows.fold(sum(&|j| b[j]), f64::max)
}

/// Builds the step in 32 digits, for a method with this state. The integrators are made for each step, of references to the parts: as in
/// the other laws, so that they are compiled once.
struct Exact(StateForm);

impl Visitor<Dd> for Exact {
    type Output = OfStep<Dd, Point<Dd>>;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<Dd, N, D>) -> Self::Output {
        let on = SystemParts::of(system, self.0);
        Box::new(move |start, h| {
            let mut state = on.state(start);
            on.system.scheme().step(&mut state, h)?;
            Ok(on.reached(&state, start)?.0)
        })
    }
}

/// Builds the linearised step, likewise.
struct Linear(StateForm);

impl Visitor<f64> for Linear {
    type Output = OfStep<f64, Spread>;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Self::Output {
        let on = SystemParts::of(system, self.0);
        Box::new(move |start, h| spread(&on, start, h))
    }
}

fn spread<const N: usize, const D: usize>(
    on: &SystemParts<f64, N, D>,
    start: &Point<f64>,
    h: f64,
) -> Result<Spread, StepError> {
    let before = on.state(start);
    let mut after = before.clone();
    let mut linearised = Linearised::new(on.system.scheme(), ());
    let Variation { attitude, momentum } = linearised.moved(&mut after, h)?;
    let momentum = momentum.iter().take(start.momentum.len()).fold(0.0, |most: f64, x| most.max(*x));
    let Some(group) = on.system.group.as_ref().filter(|_| !start.attitude.is_empty()) else {
        return Ok(Spread { momentum, beside: 0.0 });
    };
    let turned = turned(group, &attitude);
    let beside = match on.form {
        // δx' = −ω̂ x', and the terms of τ(ξ)⁻¹ x.
        StateForm::Point(_) => {
            let (inverse, x) = (group.inverse(&after.attitude).ok_or(NO_INVERSE)?, &start.attitude);
            let term = |r: usize, c: usize| (inverse[(r, c)] * x[c]).abs();
            let size: Vec<f64> = (0..x.len()).map(|r| (0..x.len()).map(|c| term(r, c)).sum()).collect();
            let of = |r: usize| (0..size.len()).map(|c| turned[(r, c)] * size[c]).sum::<f64>() + size[r];
            (0..size.len()).map(of).fold(0.0, f64::max)
        }
        // δg' = g' ω̂, and the terms of g τ(ξ).
        _ => {
            let method = linearised.method();
            let step = method.retraction().tau(method.increment());
            let step = step.map_err(|source| StepError::Domain { step: h, stage: None, source })?;
            (after.attitude.abs() * turned + before.attitude.abs() * step.abs()).amax()
        }
    };
    Ok(Spread { momentum, beside })
}

/// Σ_a |Ê_a| ω_a of sizes ω_a.
fn turned<const N: usize, const D: usize>(group: &MatrixGroup<f64, N, D>, omega: &Vector<f64, N>) -> Matrix<f64, D> {
    let term = |a: usize| {
        let hat: Matrix<f64, D> = group.hat(&basis_vector::<f64, N>(a));
        hat.abs() * omega[a]
    };
    (0..N).fold(Matrix::zeros(), |sum, a| sum + term(a))
}
