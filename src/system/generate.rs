//! Random parts of a case, valid by construction, with dyadic numbers of few digits.

use super::case::{
    Algebra, Case, Constant, Dictionary, Drag, Force, Inertia, Lagrangian, Monomial, Motion, Potential, Start,
    Structure, Tau,
};
use super::fixed::Fixed;
use super::force::{Argument, Domain, ForceKind, Kind, Role, Value};
use super::numbers::{dyadic, from_dyadic};
use super::potential::PotentialKind;
use super::random::{Cases, Forcing, USUAL_STEPS};
use super::restriction::of_body;
use crate::algebra::catalogue::Entry;
use crate::algebra::rational::{RationalAlgebra, small};
use crate::scalar::Number;
use dashu_ratio::RBig;
use proptest::prelude::Rng;
use proptest::test_runner::TestRng;

/// Draws from a generator; the same on every machine.
pub(crate) struct Draw<'a>(pub &'a mut TestRng);

impl Draw<'_> {
    /// 0, …, n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n.max(1) as u64) as usize
    }

    /// low, …, high.
    pub fn int(&mut self, low: i64, high: i64) -> i64 {
        low + self.below((high - low + 1) as usize) as i64
    }

    /// True in `percent` of 100 draws.
    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn pick<T: Clone>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())].clone()
    }

    /// The index drawn with these weights.
    pub fn weighted(&mut self, weights: &[usize]) -> usize {
        let mut rest = self.below(weights.iter().sum());
        for (i, weight) in weights.iter().enumerate() {
            if rest < *weight {
                return i;
            }
            rest -= weight;
        }
        0
    }

    /// p/q with |p| ≤ most.
    fn fraction(&mut self, most: i64, q: i64) -> Number {
        dyadic(self.int(-most, most), q)
    }

    fn fractions(&mut self, n: usize, most: i64, q: i64) -> Vec<Number> {
        (0..n).map(|_| self.fraction(most, q)).collect()
    }
}

/// Of 100 draws; those of the catalogue's names are [there](Entry::drawn) (so(3) has two code paths), and the rest are spans of
/// matrices, by family.
const PRODUCTS: usize = 3;
const CONSTANTS: usize = 3;

/// A structure that the knobs admit.
pub(super) fn structure(draw: &mut Draw<'_>, knobs: &Cases) -> Structure {
    let mut allowed = Entry::drawn();
    let matrices = 100 - PRODUCTS - CONSTANTS - allowed.iter().map(|(_, weight)| weight).sum::<usize>();
    allowed.retain(|(entry, _)| entry.dimension() <= knobs.most);
    let mut weights: Vec<usize> = allowed.iter().map(|(_, weight)| *weight).collect();
    weights.push(if knobs.most >= 2 { PRODUCTS } else { 0 });
    weights.push(if knobs.with_group { 0 } else { CONSTANTS });
    weights.push(if knobs.most >= 2 { matrices } else { 0 });
    let kind = draw.weighted(&weights);
    if let Some((entry, _)) = allowed.get(kind) {
        return Structure::Named(match entry {
            // Small ones mostly, every dimension sometimes.
            Entry::Abelian(_) => {
                let most = if draw.chance(80) { knobs.most.min(4) } else { knobs.most };
                Entry::Abelian(1 + draw.below(most))
            }
            entry => entry.clone(),
        });
    }
    match kind - allowed.len() {
        0 => Structure::Named(product(draw, knobs.most)),
        1 => constants(draw, knobs.most),
        _ => match super::algebras::matrices(draw, knobs) {
            Some((family, algebra)) => Structure::Matrices { family, algebra },
            // Where there is no room for one.
            None => Structure::Named(product(draw, knobs.most)),
        },
    }
}

/// A direct product of two, of dimension at most `most` (at least 2).
fn product(draw: &mut Draw<'_>, most: usize) -> Entry {
    let mut factors = vec![Entry::Abelian(1), Entry::Abelian(2)];
    factors.extend_from_slice(Entry::NAMED);
    factors.sort_by_key(Entry::dimension);
    for _ in 0..100 {
        let (one, two) = (draw.pick(&factors), draw.pick(&factors));
        let abelian = matches!((&one, &two), (Entry::Abelian(_), Entry::Abelian(_)));
        if one.dimension() + two.dimension() <= most && !abelian {
            return Entry::Product(vec![one, two]);
        }
    }
    Entry::Product(vec![Entry::Abelian(1), Entry::Abelian(1)])
}

/// An algebra by constants alone: one of the catalogue without its name, ℝ ⋉_A ℝᵐ with any matrix A ([e_1, e_j] =
/// A_ij e_i), or a nilpotent one of two steps (brackets of the first m vectors are any combination of the others).
fn constants(draw: &mut Draw<'_>, most: usize) -> Structure {
    let kind = draw.below(3);
    if kind == 0 || most < 3 {
        let named = Entry::drawn().into_iter().map(|(entry, _)| entry).filter(|entry| entry.dimension() <= most);
        return erased(&draw.pick(&named.collect::<Vec<_>>()));
    }
    let dimension = draw.int(3, most.min(5) as i64) as usize;
    let mut list = Vec::new();
    let mut push = |a: usize, b: usize, c: usize, p: i64, q: i64| {
        if p != 0 {
            list.push(Constant { a: a + 1, b: b + 1, c: c + 1, value: dyadic(p, q) });
        }
    };
    if kind == 1 {
        for j in 1..dimension {
            for i in 1..dimension {
                push(0, j, i, draw.int(-4, 4), 4);
            }
        }
    } else {
        let m = draw.int(2, dimension as i64 - 1) as usize;
        for a in 0..m {
            for b in a + 1..m {
                for c in m..dimension {
                    push(a, b, c, draw.int(-4, 4), 4);
                }
            }
        }
    }
    Structure::Constants { dimension, constants: list }
}

/// The constants of a catalogue entry, which are integers, without its name.
fn erased(entry: &Entry) -> Structure {
    let constant = |([a, b, c], value): ([usize; 3], &RBig)| {
        let value = Number::from(small(value).map_or(0, |(p, _)| p));
        Constant { a: a + 1, b: b + 1, c: c + 1, value }
    };
    let algebra = Structure::Named(entry.clone()).rational();
    let constants = algebra.iter().flat_map(RationalAlgebra::constants).map(constant).collect();
    Structure::Constants { dimension: entry.dimension(), constants }
}

/// L U with unit triangular factors of entries p/8: determinant 1, and a condition number of a few tens at most (n = 1: a
/// scale).
pub(super) fn basis(draw: &mut Draw<'_>, n: usize) -> Vec<Vec<Number>> {
    if n == 1 {
        return vec![vec![dyadic(draw.pick(&[2, 3, 5, 6, 8]), 4)]];
    }
    let most = if n <= 3 { 4 } else { 2 };
    // lower[i][k] in eighths, upper[k][j] in eighths: products in sixty-fourths.
    let mut triangular = |below: bool| -> Vec<Vec<i64>> {
        let entry = |i: usize, j: usize, draw: &mut Draw<'_>| match (i == j, (i > j) == below) {
            (true, _) => 8,
            (false, true) => draw.int(-most, most),
            (false, false) => 0,
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j, draw)).collect()).collect()
    };
    let (lower, upper) = (triangular(true), triangular(false));
    let product = |i: usize, j: usize| (0..n).map(|k| lower[i][k] * upper[k][j]).sum::<i64>();
    (0..n).map(|i| (0..n).map(|j| dyadic(product(i, j), 64)).collect()).collect()
}

/// Weights out of 100 of what stands beside ½⟨Iη, η⟩: whether there is a quartic term, a metric of its own, a gyrostat term.
const BESIDE: [([bool; 3], usize); 5] = [
    ([false, false, false], 60),
    ([true, false, false], 12),
    ([true, true, false], 9),
    ([false, false, true], 12),
    ([true, true, true], 7),
];

/// A Lagrangian that the knobs admit.
pub(super) fn lagrangian(draw: &mut Draw<'_>, n: usize, knobs: &Cases) -> Lagrangian {
    let allowed = |[quartic, metric, gyrostat]: [bool; 3]| {
        let kinetic = !metric && !gyrostat;
        (kinetic && !quartic) || (!knobs.quadratic && (kinetic || !knobs.kinetic))
    };
    let weights = BESIDE.map(|(beside, weight)| if allowed(beside) { weight } else { 0 });
    let [quartic, metric, gyrostat] = BESIDE[draw.weighted(&weights)].0;
    let physical = knobs.restriction.physical;
    let (mut inertia, indefinite) =
        inertia(draw, n, !quartic && !knobs.kinetic && !physical, knobs.restriction.diagonal);
    if physical && [3, 6].contains(&n) {
        inertia = of_body(&inertia).unwrap_or(inertia);
    }
    Lagrangian {
        inertia,
        indefinite,
        quartic: quartic.then(|| dyadic(draw.int(1, 4), 8)),
        metric: metric.then(|| self::metric(draw, n)),
        gyrostat: gyrostat.then(|| amplitude(draw, n)),
        formula: None,
    }
}

/// The metric of a quartic term: positive semidefinite, singular now and then.
fn metric(draw: &mut Draw<'_>, n: usize) -> Inertia {
    if draw.chance(50) {
        return Inertia::Full(positive(draw, n, 2, 8));
    }
    let mut diagonal: Vec<Number> = (0..n).map(|_| dyadic(draw.pick(&[0, 1, 2, 4, 6, 8]), 4)).collect();
    if diagonal.iter().all(|x| *x == Number::default()) {
        diagonal[0] = Number::from(1);
    }
    Inertia::Diagonal(diagonal)
}

/// Weights out of 100: the identity; diagonal; full; diagonal with one small moment; nearly the identity; of any signature, where
/// that is allowed.
const INERTIAS: [usize; 6] = [10, 33, 28, 14, 10, 5];

/// A symmetric and regular inertia, and whether it is indefinite.
fn inertia(draw: &mut Draw<'_>, n: usize, any_signature: bool, diagonal: bool) -> (Inertia, bool) {
    let mut weights = INERTIAS;
    if diagonal {
        weights[2] = 0;
    }
    if !any_signature {
        weights[5] = 0;
    }
    let inertia = match draw.weighted(&weights) {
        5 => return (indefinite(draw, n), true),
        0 => Inertia::Diagonal(vec![Number::from(1); n]),
        1 => Inertia::Diagonal((0..n).map(|_| dyadic(draw.pick(&[1, 2, 3, 4, 5, 6, 8, 12, 16]), 4)).collect()),
        2 => Inertia::Full(positive(draw, n, 2, 8)),
        3 => {
            // One moment far below the others.
            let (thin, small) = (draw.below(n), [16, 64, 256][draw.weighted(&[60, 25, 15])]);
            let moment = |a: usize, draw: &mut Draw<'_>| if a == thin { (1, small) } else { (draw.int(4, 12), 4) };
            Inertia::Diagonal((0..n).map(|a| moment(a, draw)).map(|(p, q)| dyadic(p, q)).collect())
        }
        // Nearly a multiple of the identity: moments in 1 ± 4/1024.
        _ => Inertia::Diagonal((0..n).map(|_| dyadic(1024 + draw.int(-4, 4), 1024)).collect()),
    };
    (inertia, false)
}

/// A symmetric and regular matrix with a negative direction: diagonal, or L D Lᵀ with L unit lower triangular of entries p/4.
fn indefinite(draw: &mut Draw<'_>, n: usize) -> Inertia {
    let mut moments: Vec<i64> = (0..n).map(|_| draw.pick(&[-6, -4, -3, 2, 4, 5, 8])).collect();
    if moments.iter().all(|x| *x > 0) {
        let a = draw.below(n);
        moments[a] = -moments[a];
    }
    if draw.chance(50) {
        return Inertia::Diagonal(moments.into_iter().map(|p| dyadic(p, 4)).collect());
    }
    let lower: Vec<Vec<i64>> =
        (0..n).map(|r| (0..n).map(|c| if c < r { draw.int(-2, 2) } else { 4 * i64::from(c == r) }).collect()).collect();
    let entry = |r: usize, c: usize| (0..n).map(|k| lower[r][k] * lower[c][k] * moments[k]).sum::<i64>();
    Inertia::Full((0..n).map(|r| (0..n).map(|c| dyadic(entry(r, c), 64)).collect()).collect())
}

/// A covector that is not 0.
fn amplitude(draw: &mut Draw<'_>, n: usize) -> Vec<Number> {
    let mut value = draw.fractions(n, 6, 8);
    if value.iter().all(|v| *v == Number::default()) {
        value[0] = dyadic(1, 2);
    }
    value
}

/// B Bᵀ + diagonal in sixteenths: B lower triangular with entries |p/4| ≤ most/4, diagonal from `shift`/16 to twice that.
fn positive(draw: &mut Draw<'_>, n: usize, most: i64, shift: i64) -> Vec<Vec<Number>> {
    let mut b = vec![vec![0; n]; n];
    for (i, row) in b.iter_mut().enumerate() {
        for entry in row.iter_mut().take(i + 1) {
            *entry = draw.int(-most, most);
        }
    }
    let diagonal: Vec<i64> = (0..n).map(|_| draw.int(shift, 2 * shift)).collect();
    let entry = |i: usize, j: usize| {
        let sum: i64 = (0..n).map(|k| b[i][k] * b[j][k]).sum();
        dyadic(if i == j { sum + diagonal[i] } else { sum }, 16)
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// A sum of force terms that the knobs admit.
pub(super) fn forces(draw: &mut Draw<'_>, n: usize, abelian: bool, knobs: &Cases) -> Vec<Force> {
    match knobs.forcing {
        Forcing::Free => return Vec::new(),
        Forcing::Any if draw.chance(if knobs.showing_order { 15 } else { 25 }) => return Vec::new(),
        _ => {}
    }
    let given = knobs.given.as_ref();
    if given.is_some_and(|given| given.force) {
        return vec![Force::Given];
    }
    // A bracket is made of the Lagrangian; it does not know one that is given.
    let no_brackets = given.is_some_and(|given| given.lagrangian);
    let count = 1 + draw.weighted(if knobs.showing_order { &[30, 40, 30] } else { &[60, 30, 10] });
    // The first term does not vanish identically: brackets do on abelian algebras.
    (0..count).map(|i| force(draw, n, no_brackets || (abelian && i == 0), knobs)).collect()
}

/// A force of a kind that the knobs admit, with random parameters.
fn force(draw: &mut Draw<'_>, n: usize, no_bracket: bool, knobs: &Cases) -> Force {
    let weight = |kind: &ForceKind| match kind {
        _ if no_bracket && kind.argument == Argument::Momentum => 0,
        _ if !knobs.restriction.has_force(kind.name) => 0,
        _ if knobs.smooth && !kind.smooth => 0,
        _ if knobs.showing_order => kind.showing_order,
        _ => kind.weight,
    };
    let weights: Vec<usize> = Kind::ALL.iter().map(weight).collect();
    // Without any weight it is the first, and such a case is not admitted.
    let kind = &Kind::ALL[draw.weighted(&weights)];
    kind.with(kind.parameters.iter().map(|parameter| match value(draw, (n, 0), parameter.role, knobs) {
        Value::Drag(drag) => Value::Drag(knobs.restriction.drag.of(drag)),
        other => other,
    }))
}

/// A random value of a parameter, for vectors of n components and a group of matrices of this size.
fn value(draw: &mut Draw<'_>, (n, size): (usize, usize), role: Role, knobs: &Cases) -> Value {
    let strength = |draw: &mut Draw<'_>| dyadic(draw.int(1, 8), 8);
    match role {
        Role::Strength => Value::Number(strength(draw)),
        Role::Weight => Value::Number(dyadic(draw.int(1, 8), 4)),
        Role::Rate => Value::Number(dyadic(draw.int(1, 6), 4)),
        Role::Amplitude | Role::Vector => Value::List(amplitude(draw, n)),
        Role::Form => Value::Form(Inertia::Full(positive(draw, n, 1, 4))),
        Role::Drag if draw.chance(if knobs.showing_order { 20 } else { 50 }) => {
            Value::Drag(Drag::Coefficient(strength(draw)))
        }
        Role::Drag => {
            let mut rows: Vec<Vec<Number>> = (0..n).map(|_| draw.fractions(n, 3, 8)).collect();
            for (a, row) in rows.iter_mut().enumerate() {
                row[a] = strength(draw);
            }
            Value::Drag(Drag::Matrix(rows))
        }
        Role::SymmetricDrag if draw.chance(50) => Value::Drag(Drag::Coefficient(strength(draw))),
        Role::SymmetricDrag => Value::Drag(Drag::Matrix(positive(draw, n, 1, 4))),
        Role::CovectorPolynomial | Role::VectorPolynomial => Value::Polynomial(polynomial(draw, n)),
        Role::Frequency => Value::Number(dyadic(draw.int(1, 6), 2)),
        Role::Phase => Value::Number(dyadic(draw.int(0, 3), 2)),
        Role::OddPolynomial => Value::Polynomial(argument(draw, n)),
        // Of a potential; forces by formulas are not drawn.
        Role::Formula => {
            let mut entry = || {
                let (row, column) = (1 + draw.below(size), 1 + draw.below(size));
                let name = if size < 10 { format!("g_{row}{column}") } else { format!("g_{row}_{column}") };
                (name, draw.pick(&[-4, -3, -2, -1, 1, 2, 3, 4]))
            };
            // Bounded, whatever the group.
            let ((a, k), (b, m), (c, _)) = (entry(), entry(), entry());
            Value::Formula(format!("{k}/8*tanh({a}) + {m}/8*tanh({b})*tanh({c})"))
        }
    }
}

/// Weights out of 100 of the degrees 0, 1, 2, 3 of a term in η.
const DEGREES: [usize; 4] = [10, 30, 35, 25];

/// Weights out of 100 of the factors of a term that depend on the time, as powers of cos t and of sin t.
const TIMES: [((usize, usize), usize); 5] = [((0, 0), 60), ((1, 0), 14), ((0, 1), 14), ((1, 1), 6), ((0, 2), 6)];

/// A polynomial in (cos t, sin t, η): from a single term to two for each component.
fn polynomial(draw: &mut Draw<'_>, n: usize) -> Vec<Monomial> {
    let most = [1, n, 2 * n][draw.weighted(&[30, 40, 30])];
    let term = |draw: &mut Draw<'_>| {
        let (cos, sin) = TIMES[draw.weighted(&TIMES.map(|(_, weight)| weight))].0;
        let degree = draw.weighted(&DEGREES);
        Monomial {
            component: 1 + draw.below(n),
            value: dyadic(draw.pick(&[-4, -3, -2, -1, 1, 2, 3, 4]), 8),
            cos,
            sin,
            factors: (0..degree).map(|_| 1 + draw.below(n)).collect(),
        }
    };
    (0..1 + draw.below(most)).map(|_| term(draw)).collect()
}

/// Percent of the cases with a potential, where the knobs ask for some.
const POTENTIALS: usize = 50;

/// Percent of these with two.
const TWO_POTENTIALS: usize = 40;

/// The body that gets potentials; `None` for other groups, or for none.
fn posed(draw: &mut Draw<'_>, knobs: &Cases) -> Option<Entry> {
    let of_bodies =
        knobs.potentials.iter().filter_map(|name| PotentialKind::named(name)).any(|kind| kind.domain != Domain::Any);
    let bodies = [Entry::So3, Entry::Se3].into_iter().filter(|entry| {
        knobs.admits_dimension(entry.dimension())
            && knobs.algebras.as_ref().is_none_or(|allowed| allowed.contains(entry))
            && knobs.restriction.has_matrices(entry.matrix_size())
    });
    let bodies: Vec<Entry> = bodies.collect();
    let free = knobs.given.is_none() && knobs.fixed.algebra.is_none();
    let posed = of_bodies && free && !bodies.is_empty() && draw.chance(POTENTIALS);
    posed.then(|| draw.pick(&bodies))
}

/// One or two potentials that the knobs admit; those of bodies where it is one.
fn potentials(draw: &mut Draw<'_>, algebra: &Algebra, body: bool, knobs: &Cases) -> Vec<Potential> {
    let kinds = knobs.potentials.iter().filter_map(|name| PotentialKind::named(name));
    let standard = algebra.basis.is_none();
    let possible = |kind: &&PotentialKind| {
        (kind.domain != Domain::Any) == body && (standard || kind.domain != Domain::StandardBody)
    };
    let kinds: Vec<&PotentialKind> = kinds.filter(possible).collect();
    if kinds.is_empty() || !(body || draw.chance(POTENTIALS)) {
        return Vec::new();
    }
    let count = 1 + usize::from(draw.chance(TWO_POTENTIALS));
    let size = algebra.structure.matrix_size();
    let drawn = |_| {
        let kind = draw.pick(&kinds);
        kind.with(kind.parameters.iter().map(|parameter| value(draw, (3, size), parameter.role, knobs)))
    };
    (0..count).map(drawn).collect()
}

/// A start: momentum or velocity of size about 1, sometimes 1/64 or 4; sometimes an attitude and a time.
pub(super) fn start(draw: &mut Draw<'_>, n: usize, group: bool, showing_order: bool) -> Start {
    let q = if showing_order { 8 } else { [8, 512, 2][draw.weighted(&[80, 10, 10])] };
    let mut list = draw.fractions(n, 12, q);
    if list.iter().all(|v| *v == Number::default()) {
        list[0] = dyadic(8, q);
    }
    let motion = if draw.chance(70) { Motion::Momentum(list) } else { Motion::Velocity(list) };
    let attitude = (group && draw.chance(50)).then(|| draw.fractions(n, 4, 8));
    // Where many forces that depend on the time are even in it, a wrong time does not show at t = 0.
    let time =
        if draw.chance(if showing_order { 10 } else { 75 }) { Number::default() } else { dyadic(draw.int(-8, 8), 4) };
    Start { attitude, time, ..Start::moving(motion) }
}

/// Weights out of 100 of the attitudes that are not e: of components to 1/2; tiny; turned by an angle near π.
const ATTITUDES: [usize; 3] = [45, 15, 40];

/// Makes an attitude tiny, or scales it so that it turns something by nearly π, where τ⁻¹ is nearly singular.
fn turn(draw: &mut Draw<'_>, case: &mut Case, knobs: &Cases) {
    let scale = |case: &mut Case, factor: f64, grid: f64| {
        let moved = |x: &Number| {
            let x = (x.eval::<f64>().ok()? * factor * grid).round() / grid;
            from_dyadic(x)
        };
        case.start.attitude = case.start.attitude.as_ref().map(|list| {
            let scaled: Option<Vec<Number>> = list.iter().map(moved).collect();
            scaled.unwrap_or_else(|| list.clone())
        });
    };
    // After an odd map, what turns by a certain angle is no multiple of what turns by another one.
    if case.start.attitude.is_none() || !case.method.argument.is_empty() {
        return;
    }
    match draw.weighted(&ATTITUDES) {
        0 => {}
        1 => scale(case, 0.5_f64.powi(16), f64::from(1 << 20)),
        _ => {
            let Some(rates) = knobs.rates(case) else { return };
            let frequency = rates.frequency;
            // Below π by 2^−k of it.
            let known = case.method.retraction.known();
            let (most, grid) = known.nearest;
            let angle = std::f64::consts::PI * (1.0 - 0.5_f64.powi(draw.int(4, most) as i32));
            let wanted = (known.frequency)(angle);
            // Without a rotation, or with one among much faster boosts, the attitude stays as it is.
            if frequency >= 0.125 {
                let old = case.start.attitude.clone();
                scale(case, wanted / frequency, grid);
                if !knobs.rates(case).is_some_and(|rates| rates.in_domain()) {
                    case.start.attitude = old;
                }
            }
        }
    }
}

/// Percent of the retractions that stand after an odd map.
const COMPOSED: usize = 20;

/// The terms of an odd map φ(x) − x: c |x|² x, which commutes with orthogonal changes of basis, or a few random cubic terms.
fn argument(draw: &mut Draw<'_>, n: usize) -> Vec<Monomial> {
    let term = |component, value, factors| Monomial { component, value, cos: 0, sin: 0, factors };
    if draw.chance(30) {
        let value = dyadic(draw.pick(&[-2, -1, 1, 2]), 16);
        let pairs = (1..=n).flat_map(|a| (1..=n).map(move |b| (a, b)));
        return pairs.map(|(a, b)| term(a, value.clone(), vec![a, b, b])).collect();
    }
    let count = 1 + draw.below(2 * n);
    let random = |draw: &mut Draw<'_>| {
        let value = dyadic(draw.pick(&[-3, -2, -1, 1, 2, 3]), 16);
        term(1 + draw.below(n), value, (0..3).map(|_| 1 + draw.below(n)).collect())
    };
    (0..count).map(|_| random(draw)).collect()
}

/// A whole case but for the tableau; its step is made small enough for its rates, and its motion slower if need be.
pub(super) fn case(draw: &mut Draw<'_>, knobs: &Cases, tableau: crate::tableau::Description) -> Option<Case> {
    let given = knobs.given.as_ref();
    let fixed = &knobs.fixed;
    let posed = posed(draw, knobs);
    let body = posed.is_some();
    let structure = match &knobs.algebras {
        _ if body => Structure::Named(posed?),
        _ if given.is_some() => given?.structure.clone(),
        _ if fixed.algebra.is_some() => fixed.algebra.as_ref()?.structure.clone(),
        Some(entries) if entries.is_empty() => return None,
        Some(entries) => Structure::Named(draw.pick(entries)),
        None => structure(draw, knobs),
    };
    if knobs.with_casimirs && given.is_none() && structure.casimir_count() == 0 {
        return None;
    }
    if given.is_none() && !knobs.restriction.has_matrices(structure.matrix_size()) {
        return None;
    }
    let grouped = structure.matrix_size() > 0 || given.is_some();
    let mut retractions = Tau::ALL.to_vec();
    retractions.retain(|tau| structure.admits(*tau));
    let mut algebra = Algebra { structure, basis: None };
    let n = algebra.dimension();
    if let Some(fixed) = &fixed.algebra {
        algebra.basis.clone_from(&fixed.basis);
    } else if given.is_none() && knobs.changed_basis.unwrap_or_else(|| draw.chance(50)) {
        algebra.basis = Some(basis(draw, n));
    }
    let abelian = super::labels::abelian(&algebra);
    if !(given.is_some() || knobs.admits_dimension(n)) || (knobs.nonabelian && abelian) {
        return None;
    }
    let retraction = match knobs.retraction {
        _ if given.is_some() || !grouped => Tau::Exponential,
        Some(tau) => tau,
        // Nothing is drawn where there is no choice.
        None if retractions.len() == 1 => retractions[0],
        None => retractions[draw.weighted(&retractions.iter().map(|tau| tau.known().weight).collect::<Vec<_>>())],
    };
    let unit = || given.is_some_and(|given| given.lagrangian).then(|| Lagrangian::unit(n));
    let lagrangian = fixed.lagrangian.clone().or_else(unit).unwrap_or_else(|| lagrangian(draw, n, knobs));
    let forces = fixed.forces.clone().unwrap_or_else(|| forces(draw, n, abelian, knobs));
    let start = fixed.start.clone().unwrap_or_else(|| start(draw, n, grouped, knobs.showing_order));
    let (largest, smallest) = knobs.exponents;
    let mut exponent = draw.int(i64::from(largest), i64::from(smallest)) as u32;
    // Beyond this the motion is slowed down instead: large steps are wanted too.
    let mut limit = draw.int(i64::from(exponent), i64::from(smallest)) as u32;
    let composed = knobs.retraction.is_none() && !knobs.fast && given.is_none() && draw.chance(COMPOSED);
    let argument = if composed { argument(draw, n) } else { Vec::new() };
    let method = super::case::Method { tableau, retraction, argument };
    let names = Dictionary::default();
    let potentials = if grouped && given.is_none() { potentials(draw, &algebra, body, knobs) } else { Vec::new() };
    let step = dyadic(1, 1 << exponent);
    let mut case = Case { algebra, lagrangian, potentials, forces, names, method, start, step };
    match &fixed.start {
        None => turn(draw, &mut case, knobs),
        // The step is all that can be smaller.
        Some(_) if fixed.forces.is_some() => limit = 30,
        Some(_) => {}
    }
    let (negative, large) = unusual(draw, knobs);
    let special = special(draw, knobs);
    if matches!(special, Special::Rest | Special::Ramp) {
        rest(draw, &mut case, special == Special::Ramp);
    }
    for attempt in 0..MAX_SLOWER {
        let rates = knobs.rates(&case)?;
        if !rates.in_domain() {
            if fixed.start.is_some() {
                return None;
            }
            case.start.attitude = case.start.attitude.map(|x| x.iter().map(halved).collect());
            continue;
        }
        let calm = |exponent: u32| rates.step_stiffness(0.5_f64.powi(exponent as i32)) <= super::rates::MOST;
        while !calm(exponent) && exponent < limit {
            exponent += 1;
        }
        let calm = match &fixed.step {
            None => {
                case.step = dyadic(1, 1 << exponent);
                calm(exponent)
            }
            Some(step) => {
                case.step = step.clone();
                rates.step_stiffness(step.eval::<f64>().ok()?.abs()) <= super::rates::MOST
            }
        };
        if calm {
            if large {
                enlarge(&mut case, |h| rates.step_stiffness(h) <= LARGEST);
            }
            if negative {
                case.step = case.step.eval::<f64>().ok().and_then(|h| from_dyadic(-h))?;
            }
            if special == Special::Turning {
                turning(draw, &mut case)?;
            }
            return Some(case);
        }
        slower(&mut case, fixed);
        // What is given cannot be slowed down.
        if given.is_some() && attempt >= SLOWER_BEFORE_SHORTER {
            exponent += 1;
        }
    }
    // What was chosen may be as fast as it likes.
    fixed.any().then_some(case)
}

/// Percent of the steps that are negative, and of those that are large, of cases that need not show an order.
const UNUSUAL: (usize, usize) = (8, 8);

/// The largest stiffness of a large step: beyond it stage equations fold more often than not, and there is no step.
const LARGEST: f64 = 2.0;

/// Whether the step is to be negative, and whether it is to be large.
fn unusual(draw: &mut Draw<'_>, knobs: &Cases) -> (bool, bool) {
    // Orders show at small steps, and what is asked for, fixed or given is as it is.
    if knobs.exponents != USUAL_STEPS
        || knobs.showing_order
        || knobs.smooth
        || knobs.fast
        || knobs.fixed.any()
        || knobs.given.is_some()
    {
        return (false, false);
    }
    let (negative, large) = (draw.chance(UNUSUAL.0), draw.chance(UNUSUAL.1));
    (negative && !knobs.restriction.forward, large)
}

/// Where a motion starts that has no size of its own: what is relative to the start is relative to 0.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Special {
    /// Somewhere else.
    None,
    /// At rest; where no force acts there, on an equilibrium.
    Rest,
    /// At rest, with a force that is 0 at the start and grows.
    Ramp,
    /// With a momentum that a constant force takes through 0 in the middle of the step.
    Turning,
}

/// Percent of each of them, of cases that need not show an order.
const SPECIAL: [(Special, usize); 4] =
    [(Special::None, 94), (Special::Rest, 2), (Special::Ramp, 2), (Special::Turning, 2)];

/// Which of them a case has, where the knobs admit it.
fn special(draw: &mut Draw<'_>, knobs: &Cases) -> Special {
    if knobs.exponents != USUAL_STEPS || knobs.showing_order || knobs.smooth || knobs.fixed.start.is_some() {
        return Special::None;
    }
    let special = SPECIAL[draw.weighted(&SPECIAL.map(|(_, weight)| weight))].0;
    let chosen = knobs.fixed.forces.is_some() || knobs.given.as_ref().is_some_and(|given| given.force);
    let may_have = |kind| !chosen && knobs.forcing != Forcing::Free && knobs.restriction.has_force(kind);
    match special {
        Special::Ramp if !may_have("polynomial") || knobs.fast => Special::None,
        Special::Turning if !may_have("constant") => Special::None,
        special => special,
    }
}

/// Starts at rest; on a ramp with k sin t as the only force, from t = 0.
fn rest(draw: &mut Draw<'_>, case: &mut Case, ramp: bool) {
    let n = case.dimension();
    case.start.motion = Motion::Velocity(vec![Number::default(); n]);
    if ramp {
        case.start.time = Number::default();
        let value = dyadic(draw.pick(&[-4, -2, -1, 1, 2, 4]), 8);
        let term = Monomial { component: 1 + draw.below(n), value, cos: 0, sin: 1, factors: Vec::new() };
        case.forces = vec![Force::Polynomial { terms: vec![term] }];
    }
}

/// A constant force f as the only one, and the momentum −f h/2.
fn turning(draw: &mut Draw<'_>, case: &mut Case) -> Option<()> {
    let (value, h) = (amplitude(draw, case.dimension()), case.step.eval::<f64>().ok()?);
    let momentum = value.iter().map(|f| from_dyadic(-f.eval::<f64>().ok()? * h / 2.0)).collect::<Option<_>>()?;
    case.start.motion = Motion::Momentum(momentum);
    case.forces = vec![Force::Constant { value }];
    Some(())
}

/// Doubles the step as often as it may be.
fn enlarge(case: &mut Case, may_be: impl Fn(f64) -> bool) {
    let Ok(mut step) = case.step.eval::<f64>() else { return };
    while step < 4.0 && may_be(2.0 * step) {
        step *= 2.0;
    }
    if let Some(step) = from_dyadic(step) {
        case.step = step;
    }
}

/// How often motion and forces are halved at most until a case is calm: 2⁻⁴⁰ of what was drawn hardly moves.
const MAX_SLOWER: usize = 40;

/// After this many halvings the step is halved too: a part that is given cannot be slowed down, and 2⁻⁸ of what can be is
/// still a motion.
const SLOWER_BEFORE_SHORTER: usize = 8;

/// Half the motion (with the momentum of a rotor, which is one at rest) and half of every force coefficient, of what is not fixed.
fn slower(case: &mut Case, fixed: &Fixed) {
    let half = |list: &mut Vec<Number>| list.iter_mut().for_each(|v| *v = halved(v));
    if let (None, Some(rotor)) = (&fixed.lagrangian, &mut case.lagrangian.gyrostat) {
        half(rotor);
    }
    if fixed.start.is_none() {
        match &mut case.start.motion {
            Motion::Velocity(list) | Motion::Momentum(list) => half(list),
        }
    }
    if fixed.forces.is_some() {
        return;
    }
    for force in &mut case.forces {
        force.scale(|k| *k = halved(k));
    }
    case.potentials.iter_mut().for_each(|potential| potential.halve(halved));
}

/// x/2 of a dyadic number.
fn halved(x: &Number) -> Number {
    match x.eval::<f64>() {
        Ok(value) => from_dyadic(value / 2.0).unwrap_or_else(|| x.clone()),
        Err(_) => x.clone(),
    }
}
