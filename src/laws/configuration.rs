//! Laws of systems that depend on the configuration: a potential V(t, g) and a force f(t, g, η) are put on the case, as formulas,
//! and an inertia that changes with the time.
//!
//! Potential and force are bounded functions of entries of g, in numbers that the case determines: on any group, at any attitude.

use super::CaseLaw;
use super::integrators::{Noether, PlainStep, spatial};
use super::order::{Which, forced};
use super::planted::step::{
    CHART, FORCE_INDEX, FORCE_TIME, FROM_LEFT, GRADIENT_SIGN, HALVED, INVERTED, LAGRANGIAN_TIME, NO_FORCE, NO_GRADIENT,
    NO_SECOND, NOT_TRANSPORTED, OF_START, SWAPPED_SECOND, UNCONJUGATED,
};
use super::precision::{Measured, alone};
use super::probe::{Probe, stream};
use super::question::{Answer, Problem, Question, ask, law, on_main, precisions, tried};
use super::source::Source;
use super::step::{End, displaced, subject};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, pair};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::derivative::Variation;
use crate::integrators::{OneStep, State, StepError};
use crate::laws::unbuilt;
use crate::mechanics::Lagrangian;
use crate::mechanics::configuration::Configuration;
use crate::retraction::{Exponential, Retraction};
use crate::scalar::{Dd, Dual, Real, Scalar, max_abs};
use crate::system::case::{Force as Term, Inertia, Potential, Structure};
use crate::system::force::Domain;
use crate::system::{Case, CaseError, Cases, System};
use nalgebra::{ComplexField, RealField};

const SOURCE: &str =
    "Martín de Diego and Sato Martín de Almagro 2019, §5.2, with ∂_gL + f at g τ(Ξ_i) instead of f(η_i)";

/// The potentials that do not depend on the time.
const STEADY: [&str; 4] = ["formula", "gravity", "buoyancy", "uniform-field"];

/// Systems on groups, half of them with potentials; what is put on a case comes on top.
pub(super) fn placed(cases: Cases) -> Cases {
    cases.with_group().potentials(&Potential::KINDS)
}

/// The bound of `configuration-symmetry`.
macro_rules! symmetric {
    ($of:ident) => {
        precisions!($of small(9, "floor 2⁸ s N² u of the state"))
    };
}

/// The laws of this file.
pub const fn laws() -> &'static [CaseLaw] {
    &[
        law!(Law {
            name: "configuration-plain-step",
            statement: "with L(t, g, η) the step with ∂_gL + f(t, g, η) at g τ(Ξ_i) is the stage equations, written plainly and solved by Newton's method on H",
            source: SOURCE,
            oracle: "a transcription of the equations apart from the integrator",
            bound: small(9, "floor 2⁸ s N u of the state"),
            needs: "a group",
            cost: Cost::Moderate,
            faults: &[OF_START, GRADIENT_SIGN, NO_GRADIENT, NO_FORCE, NOT_TRANSPORTED, FORCE_TIME, LAGRANGIAN_TIME],
            cases: |cases| placed(cases),
            on: placed_on,
            asks: PlainStep,
        }),
        law!(Law {
            name: "configuration-noether",
            statement: "Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ b_j Ad*_{g_j⁻¹} F_j, F_j = ∂_gL + f at g_j = g τ(Ξ_j): the spatial momentum \
                            changes by the impulses of force and potential, at any step and for any tableau",
            source: "Marsden and West 2001, §3.2, the forced discrete Noether theorem, on the scheme of Martín de Diego and Sato \
                         Martín de Almagro 2019, §5.2",
            oracle: "Ad by conjugation with group elements; the step has it from dτ",
            bound: small(9, "floor 2² s N² u of the terms"),
            needs: "a group",
            cost: Cost::Moderate,
            faults: &[
                OF_START,
                GRADIENT_SIGN,
                NO_GRADIENT,
                CHART,
                NO_FORCE,
                NOT_TRANSPORTED,
                FORCE_INDEX,
                INVERTED,
                HALVED,
                FROM_LEFT,
            ],
            cases: |cases| placed(cases),
            on: placed_on,
            asks: Noether,
        }),
        law!(Law {
            name: "configuration-symmetry",
            statement: "where V(kg) = V(g) for k = exp(s e_a) and there is no force: ⟨Ad*_{g⁻¹} μ, e_a⟩ is constant, and from k g the step \
                            leads to the same μ' and to k g'",
            source: "Noether's theorem for left translations; Marsden and West 2001, §1.3.3",
            oracle: "Ad by conjugation; a second step from k g",
            bound: symmetric!(text),
            needs: "a group with a one-parameter subgroup that leaves a row of matrices alone",
            cost: Cost::Moderate,
            faults: &[OF_START, CHART, INVERTED, HALVED, FROM_LEFT],
            cases: |cases| cases.with_group().main_dimensions().force_free().nonabelian(),
            check: symmetry,
        }),
        law!(Law {
            name: "configuration-symplectic",
            statement: "without force the step (g, μ) ↦ (g', μ') with a potential keeps the canonical form of T*G, ⟨β, ξ⟩ − ⟨α, η⟩ + ⟨μ, [ξ, η]⟩",
            source: "Abraham and Marsden 1978, §4.4; Marsden and West 2001, §1.3.2",
            oracle: "the tangent map of the step by central differences, in 32 digits",
            bound: "2⁸ times twice what doubling the displacement changes and rounding of 2¹⁰ N u over the displacement",
            needs: "a group; no force; an algebra that is not abelian",
            cost: Cost::Heavy,
            faults: &[OF_START, UNCONJUGATED, NO_SECOND, CHART, INVERTED],
            cases: |cases| cases.with_group().main_dimensions().force_free().nonabelian(),
            check: |case, fault| {
                on_main(&configured(case, What::Potential), fault, |system| Ok(alone(32, symplectic(system, fault)?)))
            },
        }),
        law!(Law {
            name: "configuration-order",
            statement: "with L(t, g, η) and f(t, g, η) Gauss 1–3 and Lobatto IIIA, IIIB 2–3 converge in μ and in g at the order of the pair (a, â)",
            source: SOURCE,
            oracle: "a classical Gauss method of order 16 on the vector field of (μ, g); the order computed from the bicoloured trees",
            bound: "a quarter: half the way to the point that is as near to the next integer",
            needs: "a group; a smooth force; an algebra that is not abelian",
            cost: Cost::Heavy,
            faults: &[OF_START, GRADIENT_SIGN, NO_GRADIENT, NOT_TRANSPORTED, SWAPPED_SECOND, LAGRANGIAN_TIME],
            cases: |cases| placed(forced(cases)),
            check: |case, fault| tried(&configured(case, What::All), fault, Which::Order),
        }),
        law!(Law {
            name: "configuration-energy",
            statement: "with V(g) and f(t, g, η): E(T) − E(0) − h Σ b_i ⟨f_i, η_i⟩ → 0 at least at the order of the method, E = ⟨∂L/∂η, η⟩ − L",
            source: "dE/dt = ⟨f, η⟩ where L does not depend on t",
            oracle: "the energy of the state; the work of the force from the stages",
            bound: "a quarter: half the way to the point that is as near to the next integer",
            needs: "a group; a smooth force; an algebra that is not abelian",
            cost: Cost::Heavy,
            faults: &[OF_START, GRADIENT_SIGN, NO_GRADIENT],
            cases: |cases| forced(cases).with_group().potentials(&STEADY),
            check: |case, fault| tried(&configured(case, What::Steady), fault, Which::Balance),
        }),
    ]
}

/// The laws of this file that judge Lagrangians of a user's own types, too.
pub const fn shared<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[law!(Law {
            name: "configuration-gradient",
            statement: "⟨∂_gL, ξ⟩ is the derivative of L(t, g exp(sξ), η) by s at 0, ⟨∂L/∂η, ζ⟩ that along ζ, and E = ⟨∂L/∂η, η⟩ − L",
            source: "Marsden and Ratiu 1999, §13.5: left trivialisation; §7.1: the energy",
            oracle: "dual numbers through L",
            bound: both("floor 2⁸ N u of the terms"),
            needs: "a group; a Lagrangian that depends on the configuration",
            faults: &[GRADIENT_SIGN, NO_GRADIENT],
            cases: |cases| placed(cases),
            on: placed_on,
            asks: Gradients,
        })]
    }
}

/// What is put on a case.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum What {
    /// V(t, g), f(t, g, η), and where l is quadratic perhaps (1 + s sin t) l(η).
    All,
    /// V(g) and f(t, g, η).
    Steady,
    /// V(t, g).
    Potential,
}

/// The k-th number of a coefficient, in eighths, of either sign.
fn eighth(probe: &mut Probe) -> String {
    let k = probe.integer(1, 8);
    if probe.next() & 1 == 0 { format!("{k}/8") } else { format!("-{k}/8") }
}

/// An entry of g by name, in rows from `first` on.
fn entry(probe: &mut Probe, size: usize, row: Option<usize>) -> String {
    let (any, column) = (probe.integer(1, size as i32), probe.integer(1, size as i32));
    let row = row.map_or(any, |row| row as i32 + 1);
    if size < 10 { format!("g_{row}{column}") } else { format!("g_{row}_{column}") }
}

/// Three bounded terms in entries of g, in one row if it is given.
fn potential(probe: &mut Probe, size: usize, row: Option<usize>) -> String {
    let terms: Vec<String> = (0..3)
        .map(|k| {
            let (a, b) = (entry(probe, size, row), entry(probe, size, row));
            let product = if k == 2 { format!("tanh({a})*tanh({b})") } else { format!("tanh({a})") };
            format!("({})*{product}", eighth(probe))
        })
        .collect();
    terms.join(" + ")
}

/// The case with a potential, and a force that depends on the configuration; on a user's own group, which formulas cannot name, as it is.
pub(super) fn configured(case: &Case, what: What) -> Case {
    if matches!(case.algebra.structure, Structure::Given { .. }) {
        return case.clone();
    }
    let mut probe = Probe::new(case, stream::CONFIGURATION);
    let (n, size) = (case.dimension(), case.matrix_size());
    let mut case = case.clone();
    let mut value = potential(&mut probe, size, None);
    if what == What::All && probe.next() & 1 == 0 {
        value = format!("(1 + cos(t)/2)*({value})");
    }
    case.potentials.push(Potential::Formula { value });
    if what != What::Potential {
        let component = |_| {
            let velocity = probe.integer(1, n as i32);
            let (first, second) = (eighth(&mut probe), eighth(&mut probe));
            let (there, here) = (entry(&mut probe, size, None), entry(&mut probe, size, None));
            format!("({first})*tanh({there})*eta_{velocity} + ({second})*sin(t)*tanh({here})")
        };
        let components: Vec<String> = (0..n).map(component).collect();
        case.forces.push(Term::Formula { components: format!("[{}]", components.join(", ")) });
    }
    // The gradient of gravity asks for the inertia, which a formula does not give.
    let standard = |potential: &Potential| potential.description().domain == Domain::StandardBody;
    let formula = case.lagrangian.is_quadratic() && !case.potentials.iter().any(standard);
    if what == What::All && formula && probe.next() & 1 == 0 {
        let size = probe.integer(1, 4);
        case.lagrangian.formula = Some(format!("(1 + {size}/8*sin(t))*({})", kinetic(&case.lagrangian.inertia)));
    }
    case
}

/// A source with all of this put on its case.
pub(super) fn placed_on<S: Source>(source: &S) -> S {
    source.with_case(configured(source.case(), What::All))
}

/// ½⟨Iη, η⟩ as a formula.
fn kinetic(inertia: &Inertia) -> String {
    let n = inertia.dimension();
    let term = |(i, j): (usize, usize)| {
        let (entry, half) = (inertia.entry(i, j), if i == j { "/2" } else { "" });
        let zero = entry.rational().is_some_and(|entry| entry.is_zero());
        (!zero).then(|| format!("({entry}){half}*eta_{}*eta_{}", i + 1, j + 1))
    };
    let upper = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    upper.filter_map(term).collect::<Vec<_>>().join(" + ")
}

/// Basis vectors e_a with a row r of ê_a that is 0, so that exp(s e_a) leaves row r of matrices alone; from 0.
fn symmetries(case: &Case) -> Result<Vec<(usize, usize)>, CaseError> {
    let (size, system) = (case.matrix_size(), case.main::<f64>(&())?);
    let places = (0..system.dimension).flat_map(|a| (0..size).map(move |r| (a, r)));
    Ok(system.group.map_or(Vec::new(), |group| places.filter(|(a, r)| leaves(&group, *a, *r)).collect()))
}

fn leaves<const N: usize, const D: usize>(group: &MatrixGroup<f64, N, D>, a: usize, r: usize) -> bool {
    let matrix: Matrix<f64, D> = group.hat(&basis_vector(a));
    matrix.row(r).iter().all(|entry| *entry == 0.0)
}

fn symmetry(case: &Case, fault: Option<&Fault>) -> Verdict {
    let size = case.matrix_size();
    let found = match symmetries(case) {
        Ok(found) => found,
        Err(e) => return unbuilt(&e),
    };
    let mut probe = Probe::new(case, stream::CONFIGURATION);
    if found.is_empty() {
        return Verdict::not_applicable("no basis vector leaves a row of the group's matrices alone");
    }
    let (a, row) = found[probe.integer(0, found.len() as i32 - 1) as usize];
    let mut case = case.clone();
    case.potentials.push(Potential::Formula { value: potential(&mut probe, size, Some(row)) });
    ask(&case, fault, Symmetric { a }, symmetric!(check))
}

/// What is left of ∂_gL with a fault: 1 without one.
pub(super) fn share_of_gradient<T: Real>(fault: Option<&Fault>) -> T {
    let wrong = 2.0 * GRADIENT_SIGN.size_in(fault) + NO_GRADIENT.size_in(fault);
    T::one() - T::exact(wrong)
}

/// A time, an attitude and vectors.
type Somewhere<T, const N: usize, const D: usize> = (T, Matrix<T, D>, [Vector<T, N>; 3]);

/// A random place of a system.
pub(super) fn somewhere<T: Real, const N: usize, const D: usize>(
    Problem { system, probe, .. }: &mut Problem<'_, T, N, D>,
) -> Result<Somewhere<T, N, D>, Measured> {
    let mut draw = || {
        let drawn = probe.vector::<T, N>();
        Vector::<T, N>::from_fn(|a, _| if a < system.dimension { drawn[a] } else { T::zero() })
    };
    let (x, vectors) = (draw() * T::half(), [draw(), draw(), draw()]);
    match system.retraction.tau(&x) {
        Ok(turn) => Ok((system.state.time + T::ratio(3, 8), system.state.attitude * turn, vectors)),
        Err(_) => Err(Measured::NotApplicable("τ(x) is not defined for the x that was drawn".into())),
    }
}

/// The derivatives of L at random places.
#[derive(Clone, Copy)]
struct Gradients;

impl Question for Gradients {
    const STREAM: Option<u64> = Some(stream::CONFIGURATION);

    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let lagrangian = &problem.system.lagrangian;
        if !lagrangian.uses_configuration() {
            let why = "the Lagrangian depends neither on the configuration nor on the time";
            return Err(Measured::NotApplicable(why.into()));
        }
        let group = problem.group()?;
        let (t, g, [along, eta, change]) = somewhere(&mut problem)?;
        let here = Configuration::of(&g);
        // Value and derivative along changes of g and η.
        let slope = |rate: Matrix<T, D>, zeta: &Vector<T, N>| {
            let moved = Matrix::<Dual<T>, D>::from_fn(|r, c| Dual { re: g[(r, c)], eps: rate[(r, c)] });
            let velocity = Vector::<Dual<T>, N>::from_fn(|a, _| Dual { re: eta[a], eps: zeta[a] });
            lagrangian.value_at(Dual::constant(t), Configuration::of(&moved), &velocity)
        };
        let hat: Matrix<T, D> = group.hat(&along);
        let (by_place, by_velocity) = (slope(g * hat, &Vector::zeros()), slope(Matrix::zeros(), &change));
        let mut gradient = lagrangian.configuration_gradient(t, here, &eta);
        gradient *= share_of_gradient::<T>(problem.fault);
        let momentum = lagrangian.gradient_at(t, here, &eta);
        let floor = problem.floor(256.0);
        let terms = |row: &Covector<T, N>, column: &Vector<T, N>| {
            row.iter().zip(column.iter()).fold(T::zero(), |sum, (a, b)| sum + (*a * *b).abs())
        };
        let equal = |what: &str, found: T, expected: T, size: T| {
            let size = size.max(found.abs()).max(expected.abs()).max(T::exact(f64::MIN_POSITIVE));
            Measured::defect((found - expected).abs(), size, floor, || {
                format!("{what} is {:e}, and {:e} by dual numbers", found.to_f64(), expected.to_f64())
            })
        };
        let energy = lagrangian.energy_at(t, here, &eta);
        // Of the terms ∂L/∂g_rc (g ξ̂)_rc, which may cancel in every component of ∂_gL.
        let rates = g.abs() * hat.abs();
        let mut places = T::zero();
        for (r, c) in (0..D).flat_map(|r| (0..D).map(move |c| (r, c))).filter(|at| rates[*at] > T::zero()) {
            let unit = Matrix::<T, D>::from_fn(|i, j| if (i, j) == (r, c) { T::one() } else { T::zero() });
            places += slope(unit, &Vector::zeros()).eps.abs() * rates[(r, c)];
        }
        Ok(equal("⟨∂_gL, ξ⟩", pair(&gradient, &along), by_place.eps, terms(&gradient, &along).max(places))
            .and(equal("⟨∂L/∂η, ζ⟩", pair(&momentum, &change), by_velocity.eps, terms(&momentum, &change)))
            .and(equal("E + L", energy + by_place.re, pair(&momentum, &eta), terms(&momentum, &eta) + energy.abs())))
    }
}

/// A step with a potential that has the symmetry e_a.
#[derive(Clone, Copy)]
struct Symmetric {
    a: usize,
}

impl Question for Symmetric {
    const STREAM: Option<u64> = Some(stream::CONFIGURATION);

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault, group) = (problem.system, problem.fault, problem.group()?);
        let mut along = Vector::<T, N>::zeros();
        along[self.a] = T::half();
        // By the exponential itself: τ(e_a/2) need not be in the subgroup.
        let turned = match Exponential::of_group(group.clone()).tau(&along) {
            Ok(k) => State { attitude: k * system.state.attitude, ..system.state.clone() },
            Err(_) => return Err(Measured::NotApplicable("k = exp(e_a/2) is not finite".into())),
        };
        let (mut end, mut other) = (system.state.clone(), turned.clone());
        for state in [&mut end, &mut other] {
            subject(system, fault).step(state, system.step)?;
        }
        // ⟨Ad*_{g⁻¹} μ, e_a⟩, and the size of its terms.
        let component = |state: &State<T, N, D>| {
            let (momentum, size) = spatial(group, &state.attitude, &state.momentum)?;
            Some((pair(&momentum, &along) / T::half(), size))
        };
        let Some(((before, size), (after, final_size))) = component(&system.state).zip(component(&end)) else {
            return Err(Measured::NotApplicable("the attitude is singular to working precision".into()));
        };
        let floor = 256.0 * (system.tableau.stages() * system.dimension * system.dimension) as f64;
        let kept = Measured::defect((after - before).abs(), size.max(final_size), floor, || {
            format!("the component went from {:e} to {:e}", before.to_f64(), after.to_f64())
        });
        let moved = max_abs(&(other.momentum - end.momentum));
        let momentum = Measured::defect(moved, end.momentum.amax().max(size), floor, || {
            format!("from k g the momentum differs by {:e}", moved.to_f64())
        });
        let Some(inverse) = group.inverse(&system.state.attitude) else { return Ok(kept.and(momentum)) };
        let expected = turned.attitude * inverse * end.attitude;
        let off = max_abs(&(other.attitude - expected));
        let extent = turned.attitude.amax() * inverse.amax() * end.attitude.amax();
        Ok(kept.and(momentum).and(Measured::defect(off, extent.max(expected.amax()), floor, || {
            format!("from k g the attitude differs from k g' by {:e}", off.to_f64())
        })))
    }
}

/// The displacement of the central differences: their error is its square.
const DISPLACEMENT: f64 = 1.0 / 17_179_869_184.0;

/// The largest |ω(Tφ v, Tφ w) − ω(v, w)| over a basis, Tφ the tangent map of the step by central differences.
fn symplectic<const N: usize, const D: usize>(
    system: &System<Dd, N, D>,
    fault: Option<&Fault>,
) -> Result<Measured, Measured> {
    let mut end = system.state.clone();
    subject(system, fault).step(&mut end, system.step)?;
    let (seen, n) = (End::of(system, &end)?, system.dimension);
    let in_momentum = |a: usize| Variation { momentum: basis_vector::<Dd, N>(a).transpose(), ..Variation::zero() };
    let in_attitude = |a: usize| Variation { attitude: basis_vector(a), ..Variation::zero() };
    let basis: Vec<Variation<Dd, N>> = (0..n).map(in_attitude).chain((0..n).map(in_momentum)).collect();
    let images = |delta: Dd| {
        let mut method = subject(system, fault);
        let mut moved = |along: &Variation<Dd, N>, by: Dd| {
            let mut state = displaced(system, along, by)?;
            method.step(&mut state, system.step)?;
            Ok::<_, StepError>(state)
        };
        let mut image = |along| Ok(seen.difference(&moved(along, delta)?, &moved(along, -delta)?, delta * Dd::int(2)));
        basis.iter().map(&mut image).collect::<Result<Vec<_>, StepError>>()
    };
    let delta = Dd::exact(DISPLACEMENT);
    let (fine, coarse) = (images(delta)?, images(delta * Dd::int(2))?);
    let form = |mu: &Covector<Dd, N>, v: &Variation<Dd, N>, w: &Variation<Dd, N>| {
        let bracket = system.algebra.bracket(&v.attitude, &w.attitude);
        pair(&w.momentum, &v.attitude) - pair(&v.momentum, &w.attitude) + pair(mu, &bracket)
    };
    let (mut defect, mut uncertainty, mut size) = (Dd::int(0), Dd::int(0), Dd::int(0));
    for j in 0..2 * n {
        for k in 0..j {
            let here = form(&system.state.momentum, &basis[j], &basis[k]);
            let there = form(&end.momentum, &fine[j], &fine[k]);
            defect = defect.max((there - here).abs());
            uncertainty = uncertainty.max((there - form(&end.momentum, &coarse[j], &coarse[k])).abs());
            let extent = |v: &Variation<Dd, N>| v.attitude.amax().max(v.momentum.amax());
            size = size.max(extent(&fine[j]) * extent(&fine[k]) * (Dd::int(1) + end.momentum.amax()));
        }
    }
    let rounding = size * Dd::unit_roundoff() * Dd::int(1024 * system.dimension as i64) / delta;
    let known = uncertainty * Dd::int(2) + rounding;
    Ok(Measured::within(defect, known, || {
        format!("the canonical form changes by {:e}, known to {:e}", defect.to_f64(), known.to_f64())
    }))
}
