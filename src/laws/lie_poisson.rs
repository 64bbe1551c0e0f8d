//! Laws of g*: the Lie–Poisson bracket, the forced equations, energy and Casimirs.

use super::planted::{blend, blend_scalar};
use super::polynomial::Cubic;
use super::question::{Answer, Measured, Precisions, Problem, Question, ask, law, precisions, singular, stream};
use super::sizes::{forcing, turning};
use super::user::force::FORCE_SIGN;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, dot, pair};
use crate::group::LieGroup;
use crate::harness::Fault;
use crate::mechanics::equations::{EulerPoincare, Rates};
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::lie_poisson::{Bracket, MomentumFunction, hamiltonian_field};
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::retraction::Retraction;
use crate::scalar::{Dual, Number, Real, Scalar, dual};
use crate::system::Cases;
use crate::system::case::Force as Term;

const BRACKET_SIGN: Fault = Fault::new("lie-poisson-sign", "{F, K} = +⟨μ, [F', K']⟩", "non-abelian algebras");
const BRACKET_SYMMETRIC: Fault =
    Fault::new("lie-poisson-symmetric", "{F, K} = −⟨μ, [F', K']⟩ + ⟨μ, F'⟩⟨μ, K'⟩", "every algebra");
pub(super) const NO_FORCE: Fault = Fault::new("rates-no-force", "μ̇ = ad*_η μ", "forced systems");
pub(super) const COAD_SIGN: Fault = Fault::new("rates-coad-sign", "μ̇ = −ad*_η μ + f", "non-abelian algebras");
pub(super) const TRANSPOSED: Fault = Fault::new(
    "rates-transposed",
    "μ̇ = (ad_η μᵀ)ᵀ + f, the transpose of ad* left out",
    "algebras and bases in which ad_η is not antisymmetric",
);
pub(super) const NOT_GRADIENT: Fault =
    Fault::new("rates-not-gradient", "μ̇ = ad*_ζ μ + f, with ζ_a = a η_a, a = 1 … n", "non-abelian algebras");
const ENERGY_SUM: Fault = Fault::new("energy-sum", "h = ⟨μ, η⟩ + l(η)", "every system");

/// Algebras with Casimirs that are known.
pub(super) fn with_casimirs(cases: Cases) -> Cases {
    cases.main_dimensions().with_casimirs()
}

/// Forces of double brackets and of metriplectic relaxation alone, on algebras that are not abelian: those among the forces of a case,
/// or one double bracket.
pub(super) fn with_brackets(cases: Cases) -> Cases {
    cases.forced_nonabelian().mapped(|mut case| {
        case.forces.retain(|term| matches!(term, Term::DoubleBracket { .. } | Term::Metriplectic { .. }));
        if case.forces.is_empty() {
            case.forces.push(Term::DoubleBracket { alpha: Number::ratio(1, 4) });
        }
        case
    })
}

/// The laws of this file that say nothing about a user's system: they judge the library on any group, or draw algebras and forces of the catalogue.
pub static LAWS: &[CaseLaw] = &[
    law!(Law {
        name: "lie-poisson-bracket",
        statement: "{F, K} = −⟨μ, [F', K']⟩ is antisymmetric, a derivation, obeys Jacobi, and is dF along μ̇ = ad*_{K'} μ; \
            {⟨·, ξ⟩, ⟨·, ζ⟩} \
            = −⟨·, ξζ − ζξ⟩",
        source: "Martín de Diego and Sato Martín de Almagro 2019, (2.7)",
        oracle: "the identities, for random cubic polynomials and nested dual numbers; commutators of matrices (structure \
         constants where there is no group)",
        bound: both("floor 2⁸ N u relative to the terms"),
        needs: "an algebra that is not abelian",
        faults: &[BRACKET_SIGN, BRACKET_SYMMETRIC],
        cases: |cases| cases.main_dimensions().nonabelian(),
        asks: Which::Bracket,
    }),
    law!(Law {
        name: "casimir-rate",
        statement: "ad*_{C'(μ)} μ = 0, and dC/dt = ⟨f, C'⟩ along forced motion, for every Casimir C",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2",
        oracle: "the value of C on dual numbers along the rates, and along ad*_ξ μ for random ξ",
        bound: both("floor 2⁸ N u relative to the terms"),
        needs: "a force; Casimir functions that are known",
        faults: &[NO_FORCE, TRANSPOSED],
        cases: |cases| with_casimirs(cases).forced(),
        asks: Which::Casimirs,
    }),
    law!(Law {
        name: "dissipation-rate",
        statement: "with double brackets and metriplectic forces of strengths α, β ≥ 0 in all: dE/dt = −α |ad*_η μ|² ≤ 0, and \
                        dC/dt = β C''(ad*_η μ, ad*_η μ) for every Casimir C: 2β C(ad*_η μ) for quadratic ones, ≥ 0 if C is a square; 0 for linear ones",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5.3.1 and §5.3.2; Bloch, Krishnaprasad, Marsden and Ratiu \
                     1996; Morrison 1986",
        oracle: "the energy and the Casimirs on dual numbers along the rates; the strengths as the case says them",
        bound: precisions!(text both("floor 2³ N u relative to the terms")),
        needs: "double brackets or metriplectic forces; an algebra that is not abelian",
        faults: &[NO_FORCE, TRANSPOSED, FORCE_SIGN],
        cases: |cases| with_brackets(cases.main_dimensions()),
        check: |case, fault| {
            let which = Which::Dissipation(&case.case().forces);
            ask(case, fault, which, Precisions::Both)
        },
    }),
];

/// The laws of this file that users' systems are asked, too.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "lie-poisson-equations",
                statement: "Ḟ = {F, h} + ⟨f̃, F'⟩ along μ̇ = ad*_η μ + f, for any function F",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2, (2.5) and (2.8)",
                oracle: "the bracket of F with the Legendre transform h of l, differentiated on dual numbers",
                bound: both("floor 2⁸ N u relative to the terms"),
                needs: "a force; an algebra that is not abelian",
                faults: &[BRACKET_SIGN, BRACKET_SYMMETRIC, NO_FORCE, COAD_SIGN, TRANSPOSED, NOT_GRADIENT, ENERGY_SUM,],
                cases: |cases| cases.main_dimensions().forced_nonabelian(),
                asks: Which::Equations,
            }),
            law!(Law {
                name: "energy-rate",
                statement: "h'(μ) = η, h(l'(η)) = E(η), and dE/dt = ⟨f, η⟩",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2",
                oracle: "h on dual numbers, through the inverse Legendre transform",
                bound: both("floor 2⁸ N u relative to the terms"),
                needs: "a force",
                faults: &[NO_FORCE, TRANSPOSED, ENERGY_SUM],
                cases: |cases| cases.main_dimensions().forced(),
                asks: Which::Energy,
            }),
            law!(Law {
                name: "dalembert-principle",
                statement: "δl(g⁻¹ġ) + ⟨f, g⁻¹δg⟩ = d/dt ⟨l', g⁻¹δg⟩ along solutions on G, for variations δg = φ(t) ξ̂ g + g σ̂(t) that \
                                depend on g",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.1, (2.3): the principle of Lagrange and d'Alembert",
                oracle: "the value of l along curves of matrices, varied on dual numbers, without a formula for δη",
                bound: both("floor 2³ N u relative to the terms"),
                needs: "a group",
                faults: &[NO_FORCE, COAD_SIGN, TRANSPOSED, FORCE_SIGN],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Variation,
            }),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which<'a> {
    Bracket,
    Equations,
    Energy,
    Casimirs,
    /// With the forces of the case.
    Dissipation(&'a [Term]),
    Variation,
}

/// The sums of the strengths α of double brackets and β of metriplectic forces.
///
/// # Errors
/// A number that cannot be evaluated, as text.
pub(super) fn strengths<T: Real>(forces: &[Term]) -> Result<(T, T), String> {
    let mut sums = (T::zero(), T::zero());
    for force in forces {
        let (sum, strength) = match force {
            Term::DoubleBracket { alpha } => (&mut sums.0, alpha),
            Term::Metriplectic { beta } => (&mut sums.1, beta),
            other => return Err(format!("{} is neither of the two", other.kind())),
        };
        *sum += strength.eval().map_err(|e| e.to_string())?;
    }
    Ok(sums)
}

impl Question for Which<'_> {
    const STREAM: Option<u64> = Some(stream::LIE_POISSON);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        match self {
            Self::Bracket => Ok(bracket(&mut problem)),
            Self::Equations => equations(&mut problem),
            Self::Energy => energy(&mut problem),
            Self::Casimirs => casimirs(&mut problem),
            Self::Dissipation(forces) => dissipation(&problem, forces),
            Self::Variation => variation(&mut problem),
        }
    }
}

/// The brackets of an algebra, with a fault or without.
struct Brackets<'a, T: Real, const N: usize> {
    algebra: &'a LieAlgebra<T, N>,
    fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize> Brackets<'a, T, N> {
    fn of<F, K>(&self, first: &'a F, second: &'a K) -> TestedFlow<'a, T, N, F, K> {
        TestedFlow { bracket: Bracket { algebra: self.algebra, first, second }, fault: self.fault }
    }
}

/// {F, K}, with a fault or without.
struct TestedFlow<'a, T: Real, const N: usize, F, K> {
    bracket: Bracket<'a, T, N, F, K>,
    fault: Option<&'a Fault>,
}

impl<T: Real, const N: usize, F: MomentumFunction<T, N>, K: MomentumFunction<T, N>> MomentumFunction<T, N>
    for TestedFlow<'_, T, N, F, K>
{
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        let right = self.bracket.value(mu);
        if self.fault.is_none() {
            return right;
        }
        let along = pair(mu, &self.bracket.first.differential(mu)) * pair(mu, &self.bracket.second.differential(mu));
        let value = blend_scalar(right, -right, BRACKET_SIGN.size_in(self.fault));
        blend_scalar(value, value + along, BRACKET_SYMMETRIC.size_in(self.fault))
    }
}

/// F K.
struct Product<'a, F, K>(&'a F, &'a K);

impl<T: Real, const N: usize, F: MomentumFunction<T, N>, K: MomentumFunction<T, N>> MomentumFunction<T, N>
    for Product<'_, F, K>
{
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        self.0.value(mu) * self.1.value(mu)
    }
}

/// μ ↦ ⟨μ, ξ⟩.
struct Linear<T: Real, const N: usize>(Vector<T, N>);

impl<T: Real, const N: usize> MomentumFunction<T, N> for Linear<T, N> {
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        pair(mu, &self.0.map(S::lift))
    }
}

/// [`EulerPoincare::rates`], with a fault or without.
pub(super) fn rates<T: Real, S: Scalar<Base = T>, const N: usize, L: Lagrangian<T, N>, F: Force<T, N>>(
    flow: &EulerPoincare<T, N, L, F>,
    t: S,
    mu: &Covector<S, N>,
    fault: Option<&Fault>,
) -> Result<Rates<S, N>, LegendreError> {
    let mut rates = flow.rates(t, mu, &Vector::zeros())?;
    if fault.is_some() {
        let free = flow.algebra.coad(&rates.velocity, mu);
        let transposed = flow.algebra.bracket(&rates.velocity, &mu.transpose()).transpose() + rates.force;
        let zeta = Vector::from_fn(|a, _| rates.velocity[a] * S::int(1 + a as i64));
        rates.momentum = blend(rates.momentum, free, NO_FORCE.size_in(fault));
        rates.momentum = blend(rates.momentum, rates.force - free, COAD_SIGN.size_in(fault));
        rates.momentum = blend(rates.momentum, transposed, TRANSPOSED.size_in(fault));
        rates.momentum = blend(rates.momentum, flow.algebra.coad(&zeta, mu) + rates.force, NOT_GRADIENT.size_in(fault));
        rates.momentum = blend(rates.momentum, free - rates.force, FORCE_SIGN.size_in(fault));
    }
    Ok(rates)
}

type Flow<'a, T, const N: usize> = EulerPoincare<T, N, &'a AnyLagrangian<T, N>, &'a AnyForce<T, N>>;

/// [`EulerPoincare::hamiltonian`] and its derivative along a covector.
fn hamiltonian<T: Real, const N: usize>(
    flow: &Flow<'_, T, N>,
    mu: &Covector<T, N>,
    along: &Covector<T, N>,
    eta: &Vector<T, N>,
    fault: Option<&Fault>,
) -> Result<Dual<T>, LegendreError> {
    let moved = dual::moving(mu, along);
    let guess = eta.map(Dual::constant);
    let mut value = flow.hamiltonian(&moved, &guess)?;
    let wrong = ENERGY_SUM.size_in(fault);
    if wrong != 0.0 {
        let velocity = flow.lagrangian.velocity(&moved, &guess)?;
        value += flow.lagrangian.value(&velocity) * Dual::exact(2.0 * wrong);
    }
    Ok(value)
}

fn bracket<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Measured {
    let (system, algebra, fault, probe) = (problem.system, &problem.system.algebra, problem.fault, &mut problem.probe);
    let mu = probe.covector::<T, N>();
    let [a, b, c] = [Cubic::<T, N>::new(probe), Cubic::new(probe), Cubic::new(probe)];
    let ones = (Vector::from_element(T::one()), Covector::from_element(T::one()));
    let scale = turning(algebra, &ones.0, &ones.1).max(T::one());
    let size = |functions: &[&Vector<T, N>]| functions.iter().fold(scale, |size, v| size * v.amax()) * mu.amax();
    let near = |what: &'static str, defect: T, size: T| {
        Measured::defect(defect.abs(), size, 256.0 * system.dimension as f64, || what.into())
    };
    let brackets = Brackets { algebra, fault };
    let (ab, ba) = (brackets.of(&a, &b), brackets.of(&b, &a));
    let moving = dual::moving(&mu, &hamiltonian_field(algebra, &b, &mu));
    let [da, db, dc] = [&a, &b, &c].map(|f| f.differential(&mu));
    let antisymmetric = near("{A, B} + {B, A}", ab.value(&mu) + ba.value(&mu), size(&[&da, &db]));

    let along = near("{A, B} − dA(X_B)", ab.value(&mu) - a.value(&moving).eps, size(&[&da, &db]));

    let (bc, ac) = (Product(&b, &c), brackets.of(&a, &c));
    let whole = brackets.of(&a, &bc).value(&mu);
    let parts = ab.value(&mu) * c.value(&mu) + b.value(&mu) * ac.value(&mu);
    let weight = b.value(&mu).abs() + c.value(&mu).abs();
    let leibniz = near("{A, BC} − {A, B}C − B{A, C}", whole - parts, size(&[&da]) * (db.amax() + dc.amax()) * weight);

    let (b_c, c_a) = (brackets.of(&b, &c), brackets.of(&c, &a));
    let cyclic = [brackets.of(&a, &b_c).value(&mu), brackets.of(&b, &c_a).value(&mu), brackets.of(&c, &ab).value(&mu)];
    let terms = cyclic.iter().fold(T::zero(), |sum, v| sum + v.abs());
    let sum = cyclic.iter().fold(T::zero(), |sum, v| sum + *v);
    let jacobi = near("{A, {B, C}} + cyclic", sum, terms + size(&[&da, &db, &dc]) * scale);

    let (xi, zeta) = (probe.vector::<T, N>(), probe.vector::<T, N>());
    let commutator = match &system.group {
        Some(group) => {
            let (x, z) = (group.hat(&xi), group.hat(&zeta));
            group.vee(&(x * z - z * x))
        }
        None => Vector::from_fn(|d, _| {
            let pairs = (0..N * N).map(|k| (k / N, k % N));
            pairs.fold(T::zero(), |sum, (a, b)| sum + algebra.constant(a, b, d) * xi[a] * zeta[b])
        }),
    };
    let linear = brackets.of(&Linear(xi), &Linear(zeta)).value(&mu) + pair(&mu, &commutator);
    let linear = near("{⟨·, ξ⟩, ⟨·, ζ⟩} + ⟨·, ξζ − ζξ⟩", linear, size(&[&xi, &zeta]));
    antisymmetric.and(along).and(leibniz).and(jacobi).and(linear)
}

fn equations<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Answer {
    let (system, fault, flow) = (problem.system, problem.fault, problem.system.equations());
    let (mu, function) = (system.state.momentum, Cubic::<T, N>::new(&mut problem.probe));
    let rates = rates(&flow, system.state.time, &mu, fault)?;
    let along = function.value(&dual::moving(&mu, &rates.momentum)).eps;
    let mut slope = Vector::<T, N>::zeros();
    for a in 0..N {
        let e = Covector::from_fn(|_, b| if a == b { T::one() } else { T::zero() });
        slope[a] = hamiltonian(&flow, &mu, &e, &rates.velocity, fault)?.eps;
    }
    let slope = Linear(slope);
    let bracket = Brackets { algebra: &problem.system.algebra, fault }.of(&function, &slope).value(&mu);
    let differential = function.differential(&mu);
    let expected = bracket + pair(&rates.force, &differential);
    let turn = problem.turning(&rates.velocity, &mu);
    let size = (turn + rates.force.amax()) * differential.amax() * T::int(system.dimension as i64);
    Ok(Measured::defect((along - expected).abs(), size, problem.floor(256.0), || {
        format!("Ḟ = {:e}, {{F, h}} + ⟨f̃, F'⟩ = {:e}", along.to_f64(), expected.to_f64())
    }))
}

fn energy<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Answer {
    let (system, fault, flow) = (problem.system, problem.fault, problem.system.equations());
    let (time, mu) = (system.state.time, system.state.momentum);
    let rates = rates(&flow, time, &mu, fault)?;
    let eta = rates.velocity;
    let floor = problem.floor(256.0);
    let near = |what: &'static str, defect: T, size: T| Measured::defect(defect.abs(), size, floor, || what.into());
    let energy = hamiltonian(&flow, &mu, &rates.momentum, &eta, fault)?;
    let turn = problem.turning(&eta, &mu) * eta.amax() * T::int(system.dimension as i64);
    let power = flow.power(time, &eta);
    let terms = turn + pair(&rates.force.abs(), &eta.abs());
    let balance = near("dE/dt − ⟨f, η⟩", energy.eps - power, terms);
    let along = problem.probe.covector::<T, N>();
    let slope = hamiltonian(&flow, &mu, &along, &eta, fault)?;
    let velocity = near("h'(μ) − η", slope.eps - pair(&along, &eta), eta.amax());
    // The terms of μ cancel where a gyrostat term stands against the velocity.
    let kinetic = pair(&(eta.abs().transpose() * flow.lagrangian.hessian(&eta).abs()), &eta.abs());
    let size = pair(&mu.abs(), &eta.abs()) + kinetic;
    let value = near("h(l'(η)) − E(η)", energy.re - flow.lagrangian.energy(&eta), size);
    Ok(balance.and(velocity).and(value))
}

fn casimirs<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Answer {
    let (system, flow) = (problem.system, problem.system.equations());
    let mu = system.state.momentum;
    let rates = rates(&flow, system.state.time, &mu, problem.fault)?;
    let xi = problem.probe.vector::<T, N>();
    let along = |to: &Covector<T, N>| dual::moving(&mu, to);
    let floor = problem.floor(256.0);
    let mut found = Measured::NotApplicable("the algebra has no Casimirs".into());
    for casimir in &system.casimirs {
        let slope = casimir.gradient(&mu);
        // The terms of the slope may cancel.
        let terms = casimir.gradient_terms(&mu);
        let free = system.algebra.coad(&slope, &mu).amax();
        let size = problem.turning(&terms, &mu);
        let free = Measured::defect(free, size, floor, || "ad*_{C'} μ ≠ 0".into());
        let turn = casimir.value(&along(&system.algebra.coad(&xi, &mu))).eps;
        let size = problem.turning(&xi, &mu) * terms.amax();
        let still = Measured::defect(turn.abs(), size, floor, || "dC(ad*_ξ μ) ≠ 0".into());
        let rate = casimir.value(&along(&rates.momentum)).eps;
        let expected = pair(&rates.force, &slope);
        let size = problem.turning(&rates.velocity, &mu) + rates.force.amax();
        let moved = Measured::defect((rate - expected).abs(), size * terms.amax(), floor, || {
            format!("dC/dt = {:e}, ⟨f, C'⟩ = {:e}", rate.to_f64(), expected.to_f64())
        });
        found = [free, still, moved].into_iter().fold(found, Measured::and);
    }
    Ok(found)
}

fn dissipation<T: Real, const N: usize, const D: usize>(problem: &Problem<'_, T, N, D>, forces: &[Term]) -> Answer {
    let (alpha, beta) = strengths::<T>(forces).map_err(Measured::Broken)?;
    let (system, algebra, fault, flow) =
        (problem.system, &problem.system.algebra, problem.fault, problem.system.equations());
    let mu = system.state.momentum;
    let rates = rates(&flow, system.state.time, &mu, fault)?;
    let turned = algebra.coad(&rates.velocity, &mu);
    let terms = turning(algebra, &rates.velocity, &mu) + forcing(algebra, &rates.force, &rates.velocity, &mu);
    let floor = problem.floor(8.0);
    let (energy, loss) = (
        hamiltonian(&flow, &mu, &rates.momentum, &rates.velocity, fault)?.eps,
        alpha * dot(turned.as_slice(), turned.as_slice()),
    );
    let size = terms * rates.velocity.amax() * T::int(system.dimension as i64);
    let falls = Measured::defect((energy + loss).abs(), size, floor, || {
        format!("dE/dt = {:e}, −α|ad*_η μ|² = {:e}", energy.to_f64(), -loss.to_f64())
    });
    let moved = dual::moving(&mu, &rates.momentum);
    Ok(system.casimirs.iter().fold(falls, |found, casimir| {
        let growth = beta * casimir.second(&mu, &turned);
        let rate = casimir.value(&moved).eps;
        let size = terms * casimir.gradient_terms(&mu).amax() + growth.abs();
        found.and(Measured::defect((rate - growth).abs(), size, floor, || {
            format!("dC/dt = {:e}, β C''(ad*_η μ, ad*_η μ) = {:e}", rate.to_f64(), growth.to_f64())
        }))
    }))
}

fn variation<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Answer {
    let (system, flow, probe) = (problem.system, problem.system.equations(), &mut problem.probe);
    let (Some(group), Ok(g)) = (&system.group, system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.25))))
    else {
        return Ok(Measured::NotApplicable("no group element".into()));
    };
    let mu = system.state.momentum;
    let rates = rates(&flow, system.state.time, &mu, problem.fault)?;
    let (eta, one) = (rates.velocity, Matrix::<Dual<T>, D>::identity());
    let along = |re: &Matrix<T, D>, eps: &Matrix<T, D>| dual::moving(re, eps);
    let (still, small) = (Matrix::<T, D>::zeros(), |m: &Matrix<T, D>| along(&Matrix::zeros(), m));
    // φ and σ at t = 0 with their rates.
    let [xi, sigma, sigma_rate] = [probe.vector::<T, N>(), probe.vector(), probe.vector()].map(|v| group.hat(&v));
    let (phi, phi_rate) = (probe.unit::<T>(), probe.unit::<T>());

    // g_ε = (1 + εφξ̂) g (1 + εσ̂), with ġ_ε by the product rule.
    let rate = g * group.hat(&eta);
    let (before, after) = (one + small(&(xi * phi)), one + small(&sigma));
    let varied = before * along(&g, &still) * after;
    let varied_rate = small(&(xi * phi_rate)) * along(&g, &still) * after
        + before * along(&rate, &still) * after
        + before * along(&g, &still) * small(&sigma_rate);
    let inverse = group.inverse(&varied).ok_or_else(singular)?;
    let change = flow.lagrangian.value(&group.vee(&(inverse * varied_rate))).eps;

    // g⁻¹δg = φ g⁻¹ξ̂g + σ̂, in time along the solution.
    let moving = along(&g, &rate);
    let back = group.inverse(&moving).ok_or_else(singular)?;
    let delta = back * along(&(xi * phi), &(xi * phi_rate)) * moving + along(&sigma, &sigma_rate);
    let delta = group.vee(&delta);
    let boundary = pair(&dual::moving(&mu, &rates.momentum), &delta).eps;
    let work = pair(&rates.force, &delta.map(|v| v.re));

    let largest = delta.iter().fold(T::zero(), |size, v| size.max(v.re.abs()).max(v.eps.abs()));
    let scale = g.amax().max(T::one()) * back.iter().fold(T::one(), |size, v| size.max(v.re.abs()));
    let terms = turning(&problem.system.algebra, &eta, &mu) + mu.amax() * (T::one() + eta.amax()) + rates.force.amax();
    let size = terms * (largest + scale) * scale * T::int(system.dimension as i64);
    Ok(Measured::defect((change + work - boundary).abs(), size, problem.floor(8.0), || {
        let [change, work, boundary] = [change, work, boundary].map(|v| v.to_f64());
        format!("δl = {change:e}, ⟨f, g⁻¹δg⟩ = {work:e}, d/dt⟨l', g⁻¹δg⟩ = {boundary:e}")
    }))
}
