//! Forces and Lagrangians by formulas in named quantities.

use super::configuration::Configuration;
use super::lagrangian::AnyLagrangian;
use super::legendre::newton_velocity;
use super::{Force, Lagrangian, LegendreError, at_the_identity, hessian_by_duals, of_spectators};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, pair};
use crate::expression::{ExpressionError, Names, Program};
use crate::group::LieGroup;
use crate::scalar::{Dual, Real, Scalar};

/// The quantities of a system on a group: t, η (n components), μ = ∂L/∂η (n components), and the entries of g.
///
/// Their names are `t`, `eta`, `mu` and `g`; a group without matrices has no `g`.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::expression::Expression;
/// use euler_poincare::group::So3;
/// use euler_poincare::integrators::{OneStep, State, Variational};
/// use euler_poincare::mechanics::formula::{FormulaForce, FormulaLagrangian, Quantities};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::ExponentialSo3;
/// use euler_poincare::scalar::Number;
/// use euler_poincare::tableau::Family;
///
/// // A heavy top with drag: r is the centre of mass times the weight, Γ = gᵀ e₃.
/// let quantities = Quantities { dimension: 3, size: 3 };
/// let mut names = quantities.names()?;
/// names.parameters("r", ["39/100", "-26/100", "65/100"].map(|r| Number::parse(r).unwrap()).to_vec())?;
/// names.definition("Gamma", "row(g, 3)")?;
/// let potential = Expression::parse("dot(r, Gamma)", &names)?;
/// let drag = Expression::parse("-[eta_1, 3*eta_2, 2*eta_3]/10", &names)?;
///
/// let body = Quadratic::<f64, 3>::diagonal([0.5, 2.0, 1.0])?;
/// let top = FormulaLagrangian::with_potential(body, potential.compile()?, quantities, &So3::<f64>::new());
/// let drag = FormulaForce::new(drag.compile()?, quantities, top.clone());
/// let mut method = Variational::new(top, drag, ExponentialSo3::new(), Family::Gauss.tableau(2)?);
/// let momentum = Covector::<f64, 3>::new(0.5, 0.3, 0.9);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
/// method.step(&mut state, 0.125)?;
/// assert!((state.momentum - momentum).norm() > 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantities {
    /// n.
    pub dimension: usize,
    /// The number of rows of g; 0 without a group.
    pub size: usize,
}

/// As many quantities as fit on the stack: those of small systems, and those of the largest.
const PLACES: [usize; 2] = [32, 192];

/// Calls `with` with at least this many zeros.
fn on_stack<S: Scalar, Out>(count: usize, with: impl FnOnce(&mut [S]) -> Out) -> Out {
    if count <= PLACES[0] { with(&mut [S::zero(); PLACES[0]]) } else { with(&mut [S::zero(); PLACES[1]]) }
}

impl Quantities {
    /// Their names.
    ///
    /// # Errors
    /// None; those of [`Names`].
    pub fn names(&self) -> Result<Names, ExpressionError> {
        let mut names = Names::new();
        names.scalar("t")?.vector("eta", self.dimension)?.vector("mu", self.dimension)?;
        if self.size > 0 {
            names.matrix("g", self.size, self.size)?;
        }
        Ok(names)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        1 + 2 * self.dimension + self.size * self.size
    }

    /// The place of η_a, from 0.
    fn velocity(&self, a: usize) -> usize {
        1 + a
    }

    /// The place of μ_a, from 0.
    fn momentum(&self, a: usize) -> usize {
        1 + self.dimension + a
    }

    /// The place of g_rc, from 0.
    pub(crate) fn entry(&self, r: usize, c: usize) -> usize {
        1 + 2 * self.dimension + r * self.size + c
    }

    /// Whether a program asks for μ.
    fn with_momentum<T: Real>(&self, program: &Program<T>) -> bool {
        (0..self.dimension).any(|a| program.uses(self.momentum(a)))
    }

    fn with_configuration<T: Real>(&self, program: &Program<T>) -> bool {
        (0..self.size).any(|r| (0..self.size).any(|c| program.uses(self.entry(r, c))))
    }

    /// Calls `with` with the quantities in their places.
    fn filled<S: Scalar, const N: usize, Out>(
        &self,
        (t, g, eta, mu): (S, Configuration<'_, S>, &Vector<S, N>, Option<Covector<S, N>>),
        with: impl FnOnce(&[S]) -> Out,
    ) -> Out {
        on_stack(self.count(), |places| {
            places[0] = t;
            for a in 0..self.dimension {
                places[self.velocity(a)] = eta[a];
                if let Some(mu) = &mu {
                    places[self.momentum(a)] = mu[a];
                }
            }
            for r in 0..self.size {
                for c in 0..self.size {
                    places[self.entry(r, c)] = g.entry(r, c);
                }
            }
            with(places)
        })
    }
}

/// A force by a formula: a vector of n components in the quantities of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaForce<T: Real, const N: usize> {
    program: Program<T>,
    quantities: Quantities,
    /// The Lagrangian that gives μ, where the formula asks for it.
    lagrangian: Option<Box<AnyLagrangian<T, N>>>,
    smooth: bool,
}

impl<T: Real, const N: usize> FormulaForce<T, N> {
    /// The force of a program with n values, and the Lagrangian with μ = ∂L/∂η. Of n < N components the others are 0.
    pub fn new(program: Program<T>, quantities: Quantities, lagrangian: impl Into<AnyLagrangian<T, N>>) -> Self {
        let lagrangian = quantities.with_momentum(&program).then(|| Box::new(lagrangian.into()));
        let smooth = program.is_smooth();
        Self { program, quantities, lagrangian, smooth }
    }
}

impl<T: Real, const N: usize> Force<T, N> for FormulaForce<T, N> {
    at_the_identity!(force);

    // Apart from those that choose among forces, as it is large.
    #[inline(never)]
    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        let mu = self.lagrangian.as_ref().map(|lagrangian| lagrangian.gradient_at(t, g, eta));
        let mut force = Covector::<S, N>::zeros();
        self.quantities.filled((t, g, eta, mu), |places| self.program.eval(places, force.as_mut_slice()));
        force
    }

    fn uses_configuration(&self) -> bool {
        let momentum = self.lagrangian.as_ref().is_some_and(|lagrangian| lagrangian.uses_configuration());
        momentum || self.quantities.with_configuration(&self.program)
    }

    fn is_smooth(&self) -> bool {
        self.smooth
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        let mu = self.lagrangian.as_ref().map(|lagrangian| lagrangian.gradient_at(t, g, eta));
        let why = self.quantities.filled((t, g, eta, mu), |places| self.program.undefined(places));
        why.map(|why| why.to_string())
    }
}

/// A function of the state (t, g, μ) by a formula with one value; η is the velocity of μ.
#[cfg(feature = "harness")]
#[derive(Clone, Debug)]
pub(crate) struct FormulaValue<T: Real, const N: usize> {
    program: Program<T>,
    quantities: Quantities,
    /// Whether the formula asks for η.
    asks: bool,
    /// That of the last state, where the next is looked for.
    velocity: Vector<T, N>,
}

#[cfg(feature = "harness")]
impl<T: Real, const N: usize> FormulaValue<T, N> {
    pub fn new(program: Program<T>, quantities: Quantities) -> Self {
        let asks = (0..quantities.dimension).any(|a| program.uses(quantities.velocity(a)));
        Self { program, quantities, asks, velocity: Vector::zeros() }
    }

    /// The value at a state, or why there is none.
    pub fn value<const D: usize>(
        &mut self,
        lagrangian: &impl Lagrangian<T, N>,
        time: T,
        attitude: &Matrix<T, D>,
        momentum: &Covector<T, N>,
    ) -> Result<T, String> {
        let g = Configuration::of(attitude);
        if self.asks {
            let found = lagrangian.velocity_at(time, g, momentum, &self.velocity);
            self.velocity = found.map_err(|error| error.to_string())?;
        }
        self.quantities.filled((time, g, &self.velocity, Some(*momentum)), |places| {
            let mut value = [T::zero()];
            self.program.eval(places, &mut value);
            if value[0].all_finite() {
                return Ok(value[0]);
            }
            Err(self.program.undefined(places).map_or_else(|| "it is not finite".into(), |why| why.to_string()))
        })
    }
}

/// (ê_a)_rc = value.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Generator<T> {
    a: usize,
    r: usize,
    c: usize,
    value: T,
}

/// L(t, g, η) = l(η) − V(t, g), or L itself, by a formula with one value.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaLagrangian<T: Real, const N: usize> {
    /// l; none where the formula is L.
    body: Option<Box<AnyLagrangian<T, N>>>,
    program: Program<T>,
    quantities: Quantities,
    /// The entries of the basis matrices that are not 0.
    generators: Vec<Generator<T>>,
    /// −1 for a potential, 1 for L.
    sign: T,
}

impl<T: Real, const N: usize> FormulaLagrangian<T, N> {
    /// l(η) − V(t, g), with V by a program that does not ask for η and μ, on a group.
    pub fn with_potential<const D: usize>(
        body: impl Into<AnyLagrangian<T, N>>,
        potential: Program<T>,
        quantities: Quantities,
        group: &impl LieGroup<T, N, D>,
    ) -> Self {
        let body = Some(Box::new(body.into()));
        Self { body, program: potential, quantities, generators: generators(quantities, Some(group)), sign: -T::one() }
    }

    /// L(t, g, η) by a program that does not ask for μ. Components of η beyond n are those of spectators with unit inertia.
    pub fn new<const D: usize>(
        lagrangian: Program<T>,
        quantities: Quantities,
        group: Option<&impl LieGroup<T, N, D>>,
    ) -> Self {
        let generators = generators(quantities, group);
        Self { body: None, program: lagrangian, quantities, generators, sign: T::one() }
    }

    /// What a potential is beside; none where the formula is the whole Lagrangian.
    pub fn body(&self) -> Option<&AnyLagrangian<T, N>> {
        self.body.as_deref()
    }

    fn formula<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        let mut value = [S::zero()];
        self.quantities.filled((t, g, eta, None), |places| self.program.eval(places, &mut value));
        value[0] * S::lift(self.sign)
    }

    /// The derivatives of the formula by every quantity, handed to `with`.
    fn slopes<S: Scalar<Base = T>, Out>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
        with: impl FnOnce(&[S]) -> Out,
    ) -> Out {
        self.quantities.filled((t, g, eta, None), |places| {
            on_stack(self.quantities.count(), |slopes| {
                self.program.gradient(places, slopes);
                with(slopes)
            })
        })
    }

    /// ∂L/∂η where L is the formula.
    fn gradient_of_formula<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        let n = self.quantities.dimension;
        self.slopes(t, g, eta, |slopes| {
            Covector::from_fn(|_, a| if a < n { slopes[self.quantities.velocity(a)] } else { eta[a] })
        })
    }

    /// ∂²L/∂η² where L is the formula.
    fn hessian_of_formula<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Matrix<S, N> {
        let mut entries = [Dual::constant(S::zero()); PLACES[1]];
        let size = self.quantities.size;
        (0..size * size).for_each(|k| entries[k] = Dual::constant(g.entry(k % size, k / size)));
        let g = Configuration::sized(&entries[..size * size], size);
        hessian_by_duals(eta, |eta| self.gradient_of_formula(Dual::constant(t), g, eta))
    }
}

fn generators<T: Real, const N: usize, const D: usize>(
    quantities: Quantities,
    group: Option<&impl LieGroup<T, N, D>>,
) -> Vec<Generator<T>> {
    let mut found = Vec::new();
    let Some(group) = group else { return found };
    for a in 0..quantities.dimension {
        let matrix: Matrix<T, D> = group.hat(&basis_vector(a));
        for r in 0..quantities.size.min(D) {
            for c in 0..quantities.size.min(D) {
                let value = matrix[(r, c)];
                if value != T::zero() {
                    found.push(Generator { a, r, c, value });
                }
            }
        }
    }
    found
}

impl<T: Real, const N: usize> Lagrangian<T, N> for FormulaLagrangian<T, N> {
    at_the_identity!(lagrangian);

    #[inline(never)]
    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        match &self.body {
            Some(body) => body.hessian(eta),
            None => self.hessian_of_formula(S::zero(), Configuration::identity(), eta),
        }
    }

    fn uses_configuration(&self) -> bool {
        self.body.is_some() || self.program.uses(0) || self.quantities.with_configuration(&self.program)
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        let why = self.quantities.filled((t, g, eta, None), |places| self.program.undefined(places));
        why.map(|why| why.to_string()).or_else(|| self.body.as_ref().and_then(|body| body.undefined(t, g, eta)))
    }

    #[inline(never)]
    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        let formula = self.formula(t, g, eta);
        match &self.body {
            Some(body) => body.value_at(t, g, eta) + formula,
            None => formula + of_spectators(eta, self.quantities.dimension),
        }
    }

    #[inline(never)]
    fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        match &self.body {
            Some(body) => body.gradient_at(t, g, eta),
            None => self.gradient_of_formula(t, g, eta),
        }
    }

    #[inline(never)]
    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        if let Some(body) = &self.body {
            return body.velocity_at(t, g, mu, guess);
        }
        let mut entries = [T::zero(); PLACES[1]];
        let size = self.quantities.size;
        (0..size * size).for_each(|k| entries[k] = g.entry(k % size, k / size).base());
        let base = Configuration::sized(&entries[..size * size], size);
        let time = t.base();
        newton_velocity(
            (&|eta| self.gradient_of_formula(time, base, eta), &|eta| self.hessian_of_formula(time, base, eta)),
            (&|eta| self.gradient_of_formula(t, g, eta), &|eta| self.hessian_of_formula(t, g, eta)),
            mu,
            guess,
        )
        .map_err(|error| error.of_leading(self.quantities.dimension))
    }

    #[inline(never)]
    fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        match &self.body {
            Some(body) => body.energy_at(t, g, eta) - self.formula(t, g, eta),
            None => pair(&self.gradient_at(t, g, eta), eta) - self.value_at(t, g, eta),
        }
    }

    #[inline(never)]
    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        let (size, places) = (self.quantities.size, self.quantities);
        let own = self.slopes(t, g, eta, |slopes| {
            let mut gradient = Covector::<S, N>::zeros();
            for generator in &self.generators {
                // Σ_i ∂F/∂g_ic g_ir (ê_a)_rc.
                let column = |i: usize| slopes[places.entry(i, generator.c)] * g.entry(i, generator.r);
                let sum = (0..size).fold(S::zero(), |sum, i| sum + column(i));
                gradient[generator.a] += sum * S::lift(generator.value * self.sign);
            }
            gradient
        });
        match &self.body {
            Some(body) if body.uses_configuration() => own + body.configuration_gradient(t, g, eta),
            _ => own,
        }
    }
}
