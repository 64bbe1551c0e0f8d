//! The same system in other variables: the momentum in space, and a parameter that the motion carries along.

use super::CaseLaw;
use super::configuration::{placed, placed_on, share_of_gradient, somewhere};
use super::planted::step::{FROM_LEFT, GRADIENT_SIGN, HALVED, INVERTED, NO_GRADIENT, NOT_TRANSPORTED, OF_START};
use super::probe::{Probe, stream};
use super::question::{Answer, Measured, Problem, Question, ask_in_quad, law};
use super::source::Source;
use super::step::subject;
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::group::LieGroup;
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::OneStep;
use crate::integrators::advected::{Advected, AdvectedLagrangian, AdvectedState, Representation};
use crate::mechanics::configuration::{Configuration, ForceOnGroup, InSpace};
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::dual::moving;
use crate::scalar::{Real, Scalar, max_abs};
use crate::system::Case;
use crate::system::case::{Potential, Structure, Tau};

/// The law of this file that judges a user's own types, too.
pub const fn shared<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[law!(Law {
            name: "configuration-space-form",
            statement: "the momentum in space π = Ad*_{g⁻¹} μ has π̇ = Ad*_{g⁻¹} (f + ∂_gL), and Ad*_{g⁻¹} f = f_s(t, g, Ad_g η) for a force \
                            that is given in space",
            source: "Marsden and Ratiu 1999, §13.5 and §15.3: body and space form",
            oracle: "Ad by conjugation, differentiated by dual numbers along ġ = gη; f_s itself",
            bound: both("floor 2⁸ N u of the terms times |g| |g⁻¹|"),
            needs: "a group",
            faults: &[GRADIENT_SIGN, NO_GRADIENT, NOT_TRANSPORTED, INVERTED],
            cases: placed,
            on: placed_on,
            asks: SpaceForm,
        })]
    }
}

/// The law of this file on cases of the catalogue.
pub const fn laws() -> &'static [CaseLaw] {
    &[law!(Law {
        name: "configuration-advected",
        statement: "where g enters by a = g⁻¹·a₀ alone, the step of (μ, a) with l(t, η, a) is that of (μ, g) with L(t, g, η) = l(t, η, g⁻¹·a₀)",
        source: "Holm, Marsden and Ratiu 1998, Thm 3.3, on the scheme of Martín de Diego and Sato Martín de Almagro 2019, §5.2",
        oracle: "the unreduced step from an attitude that is not e; a is a row of g, by the representation −ê_aᵀ",
        bound: "32 digits; 2⁸ times 2⁸ s N² u of the state",
        needs: "a group; the exponential; a quadratic Lagrangian",
        // Second derivatives of L by nested dual numbers in 32 digits.
        cost: Cost::Heavy,
        faults: &[OF_START, GRADIENT_SIGN, NO_GRADIENT, INVERTED, HALVED, FROM_LEFT],
        cases: |cases| cases.with_group().main_dimensions().retraction(Tau::Exponential).quadratic().nonabelian(),
        check: advected,
    })]
}

/// A force in space: (1 + ½ cos t) c − g₁₁ K v.
struct Spatial<T: Real, const N: usize> {
    constant: Covector<T, N>,
    drag: Matrix<T, N>,
}

impl<T: Real, const N: usize, const D: usize> ForceOnGroup<T, N, D> for &Spatial<T, N> {
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, v: &Vector<S, N>) -> Covector<S, N> {
        let constant = self.constant.map(S::lift) * (S::one() + t.cos() * S::half());
        constant - (self.drag.map(S::lift) * v).transpose() * g[(0, 0)]
    }
}

/// Body and space form at a random place.
#[derive(Clone, Copy)]
struct SpaceForm;

impl Question for SpaceForm {
    const STREAM: Option<u64> = Some(stream::CONFIGURATION);

    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault, group) = (problem.system, problem.fault, problem.group()?);
        let l = &system.lagrangian;
        let (t, g, [eta, constant, along]) = somewhere(&mut problem)?;
        let here = Configuration::of(&g);
        let spread = |m: &Matrix<T, D>| m.amax().max(T::one());
        let singular = || Measured::NotApplicable("the attitude is singular to working precision".into());
        let inverse = group.inverse(&g).ok_or_else(singular)?;
        let (adjoint, back) = group.adjoint(&g).zip(group.adjoint(&inverse)).ok_or_else(singular)?;
        let condition = spread(&g) * spread(&inverse);
        let inverted = T::exact(INVERTED.size_in(fault));
        let untouched = T::exact(NOT_TRANSPORTED.size_in(fault));
        let mu = l.gradient_at(t, here, &eta);
        let Ok(rates) = problem.system.equations().rates_at(t, here, &mu, &eta) else {
            return Err(Measured::NotApplicable("l' is not regular here".into()));
        };
        let gradient = l.configuration_gradient(t, here, &rates.velocity);
        let rate = rates.momentum - gradient * (T::one() - share_of_gradient::<T>(fault));
        // π along ġ = gη, μ̇.
        let turning: Matrix<T, D> = g * group.hat(&rates.velocity);
        let spatial = group.inverse(&moving(&g, &turning));
        let spatial =
            spatial.and_then(|inverse| group.coadjoint(&inverse, &moving(&mu, &rate))).ok_or_else(singular)?;
        let floor = 256.0 * system.dimension as f64;
        let equal = |what: &str, found: &Covector<T, N>, expected: &Covector<T, N>, size: T| {
            let off = max_abs(&(found - expected));
            Measured::defect(off, size.max(T::exact(f64::MIN_POSITIVE)), floor, || {
                format!("{what} is off by {:e}", off.to_f64())
            })
        };
        let found = spatial.map(|x| x.eps);
        let pushed = rates.force * (back * (T::one() - inverted) + adjoint * inverted);
        let terms =
            (rate.amax() + mu.amax() * (system.algebra.ad(&rates.velocity).amax() + turning.amax())) * back.amax();
        let size = terms * condition * T::int(system.dimension as i64);
        let form = equal("π̇ − Ad*_{g⁻¹} (f + ∂_gL)", &found, &pushed, size.max(pushed.amax()));
        // A force that is given in space.
        let given =
            Spatial { constant: constant.transpose(), drag: Matrix::from_fn(|r, c| along[(r + c) % N] * T::half()) };
        let in_body: Covector<T, N> = InSpace::new(&given, group.clone()).force_at(t, here, &eta);
        let there: Covector<T, N> = (&given).force(t, &g, &(adjoint * eta));
        let in_space = in_body * back * (T::one() - untouched) + in_body * untouched;
        let size = (in_body.amax() * back.amax() + there.amax()) * condition * T::int(system.dimension as i64);
        Ok(form.and(equal("Ad*_{g⁻¹} f − f_s", &in_space, &there, size)))
    }
}

fn advected(case: &Case, fault: Option<&Fault>) -> Verdict {
    if matches!(case.algebra.structure, Structure::Given { .. }) {
        return Verdict::not_applicable("formulas cannot name the entries of a user's own matrices");
    }
    let size = case.matrix_size();
    let potential = RowPotential::draw(&mut Probe::new(case, stream::CONFIGURATION), size);
    let mut case = case.clone();
    case.potentials.push(Potential::Formula { value: potential.text(size) });
    ask_in_quad(&case, fault, potential)
}

/// V = Σ c tanh(a_i) + c' tanh(a_j) tanh(a_k) of a row a of g.
#[derive(Clone, Copy)]
struct RowPotential {
    row: usize,
    /// In eighths.
    coefficients: [i64; 2],
    columns: [usize; 3],
}

impl RowPotential {
    fn draw(probe: &mut Probe, size: usize) -> Self {
        let index = |probe: &mut Probe| probe.integer(0, size as i32 - 1) as usize;
        let coefficient =
            |probe: &mut Probe| i64::from(probe.integer(1, 8) * if probe.next() & 1 == 0 { 1 } else { -1 });
        Self {
            row: index(probe),
            coefficients: std::array::from_fn(|_| coefficient(probe)),
            columns: std::array::from_fn(|_| index(probe)),
        }
    }

    /// As a formula of g.
    fn text(&self, size: usize) -> String {
        let entry = |column: usize| match size < 10 {
            true => format!("g_{}{}", self.row + 1, column + 1),
            false => format!("g_{}_{}", self.row + 1, column + 1),
        };
        let ([c, d], [i, j, k]) = (self.coefficients, self.columns.map(entry));
        format!("({c})/8*tanh({i}) + ({d})/8*tanh({j})*tanh({k})")
    }

    /// As a function of a.
    fn value<S: Scalar, const D: usize>(&self, a: &Vector<S, D>) -> S {
        let ([c, d], [i, j, k]) = (self.coefficients.map(|c| S::ratio(c, 8)), self.columns.map(|i| a[i].tanh()));
        c * i + d * j * k
    }
}

/// l(t, η, a) = ½⟨Iη, η⟩ − V(a).
struct OfRow<T: Real, const N: usize> {
    inertia: Matrix<T, N>,
    potential: RowPotential,
}

impl<T: Real, const N: usize, const D: usize> AdvectedLagrangian<T, N, D> for OfRow<T, N> {
    fn value<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, N>, a: &Vector<S, D>) -> S {
        pair(&(self.inertia.map(S::lift) * eta).transpose(), eta) * S::half() - self.potential.value(a)
    }
}

/// The reduced step beside the unreduced one.
impl Question for RowPotential {
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, group) = (problem.system, problem.group()?);
        let representation: [Matrix<T, D>; N] = std::array::from_fn(|a| -group.basis()[a].transpose());
        let representation = Representation::new(system.algebra.clone(), representation)
            .map_err(|error| Measured::Broken(format!("−ê_aᵀ is no representation: {error}")))?;
        let inertia = system.lagrangian.hessian(&Vector::zeros());
        let lagrangian = OfRow { inertia, potential: self };
        let mut reduced = Advected::new(lagrangian, &system.force, representation, system.tableau.clone());
        let row = |g: &Matrix<T, D>| g.row(self.row).transpose();
        let mut full = system.state.clone();
        let mut state = AdvectedState { time: full.time, momentum: full.momentum, parameter: row(&full.attitude) };
        let mut size = full.momentum.amax().max(full.attitude.amax());
        for _ in 0..2 {
            subject(system, problem.fault).step(&mut full, system.step)?;
            reduced.step(&mut state, system.step)?;
            size = size.max(full.momentum.amax()).max(full.attitude.amax());
        }
        let floor = 256.0 * (system.tableau.stages() * system.dimension * system.dimension) as f64;
        let (momentum, parameter) =
            (max_abs(&(full.momentum - state.momentum)), max_abs(&(row(&full.attitude) - state.parameter)));
        Ok(Measured::defect(momentum, size, floor, || format!("μ differs by {:e}", momentum.to_f64()))
            .and(Measured::defect(parameter, size, floor, || format!("a differs by {:e}", parameter.to_f64()))))
    }
}
