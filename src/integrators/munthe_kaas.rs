//! The classical Runge–Kutta–Munthe-Kaas methods: a comparator with the order of its tableau as it stands.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/munthe_kaas.md"))]

use super::picard::{Change, iterate};
use super::{OneStep, Report, State, StepError};
use crate::algebra::{Covector, Vector};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::Real;
use crate::tableau::Tableau;

/// A Runge–Kutta–Munthe-Kaas method; where the algebra has no group the attitude is left alone.
///
/// ```
/// use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, catalogue::Entry};
/// use euler_poincare::integrators::{MuntheKaas, OneStep, State};
/// use euler_poincare::mechanics::{equations::EulerPoincare, force::LinearDrag, lagrangian::Quadratic};
/// use euler_poincare::retraction::ExponentialSo3;
/// use euler_poincare::tableau::Classic;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(0.1))?;
/// let so3 = LieAlgebra::from_catalogue(&Entry::So3)?;
/// let body = EulerPoincare::new(so3, Quadratic::diagonal([0.5, 2.0, 1.0])?, drag);
/// let mut rkmk4 = MuntheKaas::new(body, ExponentialSo3::new(), Classic::Rk4.tableau()?);
/// let momentum = Covector::<f64, 3>::new(0.4, 0.1, 0.7);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
/// rkmk4.step(&mut state, 0.1)?;
/// assert!((state.attitude.transpose() * state.attitude - Matrix::<f64, 3>::identity()).amax() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct MuntheKaas<T: Real, const N: usize, L, F, R> {
    system: EulerPoincare<T, N, L, F>,
    retraction: R,
    tableau: Tableau<T>,
    explicit: bool,
    slopes: Vec<Covector<T, N>>,
    rates: Vec<Vector<T, N>>,
    velocities: Vec<Vector<T, N>>,
}

impl<T: Real, const N: usize, L, F, R> MuntheKaas<T, N, L, F, R> {
    /// The method of a tableau on a system, with a retraction of its group.
    pub fn new(system: EulerPoincare<T, N, L, F>, retraction: R, tableau: Tableau<T>) -> Self {
        let s = tableau.stages();
        let explicit = (0..s).all(|i| (i..s).all(|j| tableau.a()[(i, j)] == T::zero()));
        let (slopes, rates, velocities) =
            (vec![Covector::zeros(); s], vec![Vector::zeros(); s], vec![Vector::zeros(); s]);
        Self { system, retraction, tableau, explicit, slopes, rates, velocities }
    }

    /// (κ_i, K_i, η_i) of the last step, stage by stage; zero before the first.
    pub fn stages(&self) -> impl Iterator<Item = (&Covector<T, N>, &Vector<T, N>, &Vector<T, N>)> {
        self.slopes
            .iter()
            .zip(&self.rates)
            .zip(&self.velocities)
            .map(|((slope, rate), velocity)| (slope, rate, velocity))
    }

    /// h Σ_j w_j (κ_j, K_j).
    fn sums(&self, h: T, weight: impl Fn(usize) -> T) -> (Covector<T, N>, Vector<T, N>) {
        let mut sums = (Covector::zeros(), Vector::zeros());
        for (j, (slope, rate)) in self.slopes.iter().zip(&self.rates).enumerate() {
            let weight = h * weight(j);
            sums.0 += slope * weight;
            sums.1 += rate * weight;
        }
        sums
    }
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>, F: Force<T, N>, R> MuntheKaas<T, N, L, F, R> {
    /// Evaluates every stage with the slopes at hand.
    fn pass<const D: usize>(&mut self, state: &State<T, N, D>, h: T, moves: bool) -> Result<Change<T>, StepError>
    where
        R: Retraction<T, N, D>,
    {
        let step = h.to_f64();
        let [mut change, mut changed, mut size] = [T::zero(); 3];
        for i in 0..self.tableau.stages() {
            let (kick, displacement) = self.sums(h, |j| self.tableau.a()[(i, j)]);
            let time = state.time + self.tableau.c()[i] * h;
            let outside = |source| StepError::Domain { step, stage: Some(i), source };
            let momentum = state.momentum + kick;
            let rates = match moves {
                true => {
                    let attitude = state.attitude * self.retraction.tau(&displacement).map_err(outside)?;
                    self.system.rates_at(time, Configuration::of(&attitude), &momentum, &self.velocities[i])
                }
                false => self.system.reduced_rates(time, &momentum, &self.velocities[i]),
            };
            let rates = rates.map_err(|source| StepError::Legendre { step, source })?;
            let point = self.retraction.at(&displacement).map_err(outside)?;
            let rate = point.d_inv() * rates.velocity;
            for (new, old) in rates.momentum.iter().zip(&self.slopes[i]) {
                changed = changed.max((*new - *old).abs());
                size = size.max(new.abs());
            }
            for (new, old) in rate.iter().zip(&self.rates[i]) {
                change = change.max((*new - *old).abs());
                size = size.max(new.abs());
            }
            (self.slopes[i], self.rates[i], self.velocities[i]) = (rates.momentum, rate, rates.velocity);
        }
        let change = change.max(changed);
        Ok(Change { relative: if change == T::zero() { change } else { change / size }, momentum: changed })
    }
}

impl<T, const N: usize, const D: usize, L, F, R> OneStep<T, N, D> for MuntheKaas<T, N, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        state.check_finite(h)?;
        self.slopes.fill(Covector::zeros());
        self.rates.fill(Vector::zeros());
        let moves = self.system.uses_configuration();
        let explicit = self.explicit;
        let sensitivity = |method: &Self| method.system.sensitivity(state.time, &state.attitude, &method.velocities[0]);
        let (solver, iterations, residual) =
            iterate(self, explicit, h, T::zero(), |method| method.pass(state, h, moves), sensitivity)?;
        let step = h.to_f64();
        let (kick, increment) = self.sums(h, |j| self.tableau.b()[j]);
        let attitude = match self.retraction.tau(&increment) {
            Ok(tau) => state.attitude * tau,
            Err(RetractionError::NoGroup { .. }) => state.attitude,
            Err(source) => return Err(StepError::Domain { step, stage: None, source }),
        };
        let next = State { time: state.time + h, momentum: state.momentum + kick, attitude };
        next.check_finite(h)?;
        *state = next;
        Ok(Report { solver, iterations, residual })
    }
}
