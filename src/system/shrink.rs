//! Simpler cases than a given one: a pure function of the case, so saved cases shrink as well as generated ones.
//!
//! Every candidate lowers (dimension, rank of the algebra, parts, distances of numbers from their targets on their
//! own dyadic grid) in lexicographic order, so greedy descent ends.

use super::case::{
    Algebra, Case, Coordinates, Drag, Force, Inertia, Lagrangian, Monomial, Motion, Potential, Structure, Tau,
};
use super::force::{ForceKind, Role, Value};
use super::numbers::{dyadic, from_dyadic};
use crate::algebra::MatrixAlgebra;
use crate::algebra::catalogue::Entry;
use crate::retraction::is_odd;
use crate::scalar::Number;

/// Simpler values than `x` on the way to the integer `target`, the simplest first.
fn towards(x: &Number, target: i64) -> Vec<Number> {
    let Ok(value) = x.eval::<f64>() else { return Vec::new() };
    let distance = value - target as f64;
    if distance == 0.0 || !distance.is_finite() {
        return Vec::new();
    }
    let mut found = vec![Number::from(target)];
    // Truncated towards the target on coarser and coarser grids: strictly nearer each time.
    for bits in [0, 1, 2, 3] {
        let scale = f64::from(1 << bits);
        for closer in [(distance * 0.5 * scale).trunc() / scale, (distance * scale).trunc() / scale] {
            if closer != 0.0 && closer != distance {
                found.extend(from_dyadic(target as f64 + closer));
            }
        }
    }
    found.dedup();
    found
}

/// One list for each way to move one entry of `list` towards its target.
fn entries(list: &[Number], target: impl Fn(usize) -> i64) -> Vec<Vec<Number>> {
    let mut found = Vec::new();
    for (i, x) in list.iter().enumerate() {
        for simpler in towards(x, target(i)) {
            let mut list = list.to_vec();
            list[i] = simpler;
            found.push(list);
        }
    }
    found
}

/// The same for a matrix with the target 1 on the diagonal (`unit`) or 0 everywhere; mirrored entries move together.
fn matrices(rows: &[Vec<Number>], diagonal: i64, mirrored: bool) -> Vec<Vec<Vec<Number>>> {
    let mut found = Vec::new();
    for r in 0..rows.len() {
        for c in 0..if mirrored { r + 1 } else { rows.len() } {
            for simpler in towards(&rows[r][c], if r == c { diagonal } else { 0 }) {
                let mut rows = rows.to_vec();
                if mirrored {
                    rows[c][r] = simpler.clone();
                }
                rows[r][c] = simpler;
                found.push(rows);
            }
        }
    }
    found
}

/// The same for a symmetric matrix, towards the identity.
fn forms(form: &Inertia) -> Vec<Inertia> {
    match form {
        Inertia::Diagonal(list) => entries(list, |_| 1).into_iter().map(Inertia::Diagonal).collect(),
        Inertia::Full(rows) => matrices(rows, 1, true).into_iter().map(Inertia::Full).collect(),
    }
}

/// Algebras from the simplest on; later ones may be replaced by earlier ones.
const LADDER: [Entry; 9] = [
    Entry::Abelian(1),
    Entry::Aff1,
    Entry::So3,
    Entry::Heisenberg,
    Entry::Se2,
    Entry::Sl2,
    Entry::Abelian(2),
    Entry::So4,
    Entry::Se3,
];

/// All simplifications of a case, the boldest first; no step below 1/`finest`.
pub(super) fn candidates(case: &Case, finest: i64) -> Vec<Case> {
    let mut found = Vec::new();
    algebra(case, &mut found);
    forces(case, &mut found);
    potentials(case, &mut found);
    lagrangian(case, &mut found);
    method(case, finest, &mut found);
    start(case, &mut found);
    numbers(case, &mut found);
    found
}

fn with(case: &Case, change: impl FnOnce(&mut Case)) -> Case {
    let mut case = case.clone();
    change(&mut case);
    case
}

/// Those of these changes that change something.
fn offer<const K: usize>(case: &Case, changes: [fn(&mut Case); K], found: &mut Vec<Case>) {
    found.extend(changes.map(|change| with(case, change)).into_iter().filter(|simpler| simpler != case));
}

fn rank(structure: &Structure) -> usize {
    match structure {
        Structure::Named(entry) => LADDER.iter().position(|known| known == entry).unwrap_or(LADDER.len()),
        Structure::Matrices { .. } | Structure::Constants { .. } | Structure::Given { .. } => LADDER.len() + 1,
    }
}

fn algebra(case: &Case, found: &mut Vec<Case>) {
    let (n, rank_now) = (case.dimension(), rank(&case.algebra.structure));
    let mut replace = |entry: Entry| {
        let (m, structure) = (entry.dimension(), Structure::Named(entry));
        if m < n || (m == n && rank(&structure) < rank_now) {
            found.push(with(case, |case| {
                case.algebra = Algebra { structure, basis: None };
                truncate(case, m);
            }));
        }
    };
    LADDER.into_iter().for_each(&mut replace);
    match &case.algebra.structure {
        Structure::Named(Entry::Abelian(n)) => (3..*n).for_each(|m| replace(Entry::Abelian(m))),
        Structure::Named(Entry::Product(factors)) => factors.iter().cloned().for_each(replace),
        Structure::Named(_) | Structure::Given { .. } => {}
        Structure::Matrices { family, algebra } => {
            // The subalgebras of the first basis vectors.
            for m in 1..n {
                if let Ok(algebra) = MatrixAlgebra::new(algebra.matrices()[..m].to_vec()) {
                    found.push(with(case, |case| {
                        case.algebra =
                            Algebra { structure: Structure::Matrices { family: *family, algebra }, basis: None };
                        truncate(case, m);
                    }));
                }
            }
        }
        Structure::Constants { constants, .. } => {
            for i in 0..constants.len() {
                found.push(with(case, |case| {
                    if let Structure::Constants { constants, .. } = &mut case.algebra.structure {
                        constants.remove(i);
                    }
                }));
            }
        }
    }
    offer(case, [|case| case.algebra.basis = None], found);
}

/// Cuts every list to dimension m (principal submatrices stay definite).
fn truncate(case: &mut Case, m: usize) {
    for part in case.coordinates_mut() {
        match part {
            Coordinates::Vector(list) | Coordinates::Covector(list) | Coordinates::Form(Inertia::Diagonal(list)) => {
                list.truncate(m);
            }
            Coordinates::Form(Inertia::Full(rows)) | Coordinates::Drag(Drag::Matrix(rows)) => {
                rows.truncate(m);
                rows.iter_mut().for_each(|row| row.truncate(m));
            }
            Coordinates::Polynomial(terms, _) => terms.retain(|term| term.largest() <= m),
            Coordinates::Drag(Drag::Coefficient(_)) => {}
        }
    }
}

fn forces(case: &Case, found: &mut Vec<Case>) {
    if case.forces.len() > 1 {
        found.push(with(case, |case| case.forces.clear()));
    }
    for i in 0..case.forces.len() {
        found.push(with(case, |case| drop(case.forces.remove(i))));
    }
    for (i, force) in case.forces.iter().enumerate() {
        for (k, (_, value)) in force.parameters().enumerate() {
            if let Value::Drag(Drag::Matrix(_)) = value {
                let unit = Drag::Coefficient(Number::from(1));
                found.push(with(case, |case| case.forces[i].set(k, Value::Drag(unit))));
            }
        }
        if let Some(simpler) = simpler_kind(force) {
            found.push(with(case, |case| case.forces[i] = simpler));
        }
    }
}

fn potentials(case: &Case, found: &mut Vec<Case>) {
    if case.potentials.len() > 1 {
        found.push(with(case, |case| case.potentials.clear()));
    }
    for (i, potential) in case.potentials.iter().enumerate() {
        found.push(with(case, |case| drop(case.potentials.remove(i))));
        let simpler = simpler_potential(potential).into_iter();
        found.extend(simpler.map(|potential| with(case, |case| case.potentials[i] = potential)));
    }
}

/// The potential with one number of it nearer to 0 or 1.
fn simpler_potential(potential: &Potential) -> Vec<Potential> {
    let mut found = Vec::new();
    for (k, (_, value)) in potential.parameters().into_iter().enumerate() {
        found.extend(simpler_values(value, None).into_iter().map(|value| {
            let mut potential = potential.clone();
            if let Some((_, place)) = potential.parameters_mut().into_iter().nth(k) {
                place.put(value);
            }
            potential
        }));
    }
    found
}

fn lagrangian(case: &Case, found: &mut Vec<Case>) {
    let changes: [fn(&mut Case); 7] = [
        |case| case.lagrangian = Lagrangian::unit(case.dimension()),
        |case| case.lagrangian.inertia = Lagrangian::unit(case.dimension()).inertia,
        |case| {
            if let Inertia::Full(rows) = &case.lagrangian.inertia {
                let diagonal = rows.iter().enumerate().map(|(a, row)| row[a].clone()).collect();
                case.lagrangian.inertia = Inertia::Diagonal(diagonal);
            }
        },
        |case| case.lagrangian.indefinite = false,
        |case| case.lagrangian.gyrostat = None,
        |case| case.lagrangian.metric = None,
        |case| (case.lagrangian.quartic, case.lagrangian.metric) = (None, None),
    ];
    offer(case, changes, found);
}

fn method(case: &Case, finest: i64, found: &mut Vec<Case>) {
    offer(case, [|case| case.method.argument.clear(), |case| case.method.retraction = Tau::Exponential], found);
    // The smallest step that is generated, then larger ones.
    let Ok(step) = case.step.eval::<f64>() else { return };
    if step < 0.0 {
        found.extend(from_dyadic(-step).map(|step| with(case, |case| case.step = step)));
    }
    let mut q = finest.max(1);
    while q >= 1 && 1.0 / (q as f64) < step {
        found.push(with(case, |case| case.step = dyadic(1, q)));
        q /= 2;
    }
}

fn start(case: &Case, found: &mut Vec<Case>) {
    let changes: [fn(&mut Case); 3] = [
        |case| case.start.attitude = None,
        |case| case.start.time = Number::default(),
        |case| {
            if let Motion::Velocity(list) = &case.start.motion {
                case.start.motion = Motion::Momentum(list.clone());
            }
        },
    ];
    offer(case, changes, found);
}

/// Single numbers, towards 0 or 1.
fn numbers(case: &Case, found: &mut Vec<Case>) {
    let (Motion::Velocity(motion) | Motion::Momentum(motion)) = &case.start.motion;
    found.extend(entries(motion, |_| 0).into_iter().map(|simpler| {
        with(case, |case| match &mut case.start.motion {
            Motion::Velocity(list) | Motion::Momentum(list) => *list = simpler,
        })
    }));
    if let Some(x) = &case.start.attitude {
        found.extend(entries(x, |_| 0).into_iter().map(|x| with(case, |case| case.start.attitude = Some(x))));
    }
    let simpler = forms(&case.lagrangian.inertia).into_iter();
    found.extend(simpler.map(|form| with(case, |case| case.lagrangian.inertia = form)));
    if let Some(metric) = &case.lagrangian.metric {
        let simpler = forms(metric).into_iter();
        found.extend(simpler.map(|form| with(case, |case| case.lagrangian.metric = Some(form))));
    }
    if let Some(rotor) = &case.lagrangian.gyrostat {
        let simpler = entries(rotor, |_| 0).into_iter();
        found.extend(simpler.map(|rotor| with(case, |case| case.lagrangian.gyrostat = Some(rotor))));
    }
    let odd = |terms: &Vec<Monomial>| terms.iter().all(|term| is_odd(term.factors.len()));
    let simpler = polynomials(&case.method.argument).into_iter().filter(odd);
    found.extend(simpler.map(|argument| with(case, |case| case.method.argument = argument)));
    for (i, force) in case.forces.iter().enumerate() {
        found.extend(simpler_force(force).into_iter().map(|force| with(case, |case| case.forces[i] = force)));
    }
    if let Some(basis) = &case.algebra.basis {
        found.extend(
            matrices(basis, 1, false).into_iter().map(|basis| with(case, |case| case.algebra.basis = Some(basis))),
        );
    }
    if let Structure::Matrices { family, algebra } = &case.algebra.structure {
        let (family, all) = (*family, algebra.matrices());
        for (a, matrix) in all.iter().enumerate() {
            for simpler in matrices(matrix, 0, false) {
                let mut all = all.to_vec();
                all[a] = simpler;
                if let Ok(algebra) = MatrixAlgebra::new(all) {
                    let structure = Structure::Matrices { family, algebra };
                    found.push(with(case, |case| case.algebra.structure = structure));
                }
            }
        }
    }
    if let Structure::Constants { constants, .. } = &case.algebra.structure {
        for (i, constant) in constants.iter().enumerate() {
            for value in towards(&constant.value, 1) {
                found.push(with(case, |case| {
                    if let Structure::Constants { constants, .. } = &mut case.algebra.structure {
                        constants[i].value = value;
                    }
                }));
            }
        }
    }
}

/// The polynomial without one term, or with one term simpler: of lower degree, in the first component, or with another coefficient.
fn polynomials(terms: &[Monomial]) -> Vec<Vec<Monomial>> {
    let mut found = Vec::new();
    for (k, term) in terms.iter().enumerate() {
        if terms.len() > 1 {
            let mut fewer = terms.to_vec();
            fewer.remove(k);
            found.push(fewer);
        }
        let mut exchange = |change: &dyn Fn(&mut Monomial)| {
            let mut terms = terms.to_vec();
            change(&mut terms[k]);
            found.push(terms);
        };
        if term.cos > 0 {
            exchange(&|term| term.cos = 0);
        }
        if term.sin > 0 {
            exchange(&|term| term.sin = 0);
        }
        for factor in 0..term.factors.len() {
            exchange(&|term| {
                term.factors.remove(factor);
            });
        }
        if term.component > 1 {
            exchange(&|term| term.component = 1);
        }
        towards(&term.value, 1).iter().for_each(|value| exchange(&|term| term.value = value.clone()));
    }
    found
}

/// The force of the simpler kind, with the parameters that have the same names.
fn simpler_kind(force: &Force) -> Option<Force> {
    let kind = ForceKind::named(force.description().simpler?)?;
    let mut simpler = kind.force([]);
    for (k, wanted) in kind.parameters.iter().enumerate() {
        if let Some((_, value)) = force.parameters().find(|(parameter, _)| parameter.name == wanted.name) {
            simpler.set(k, value);
        }
    }
    Some(simpler)
}

/// The force with one number of it nearer to 0 or 1; a phase stays.
fn simpler_force(force: &Force) -> Vec<Force> {
    let mut found = Vec::new();
    for (k, (parameter, value)) in force.parameters().enumerate() {
        found.extend(simpler_values(value, Some(parameter.role)).into_iter().map(|value| {
            let mut force = force.clone();
            force.set(k, value);
            force
        }));
    }
    found
}

/// The value of a parameter with one number of it nearer to 0 or 1.
fn simpler_values(value: Value, role: Option<Role>) -> Vec<Value> {
    match value {
        Value::Number(_) if role == Some(Role::Phase) => Vec::new(),
        Value::Number(x) => towards(&x, 1).into_iter().map(Value::Number).collect(),
        Value::Covector(list) => entries(&list, |_| 0).into_iter().map(Value::Covector).collect(),
        Value::Drag(Drag::Coefficient(x)) => {
            towards(&x, 1).into_iter().map(Drag::Coefficient).map(Value::Drag).collect()
        }
        Value::Polynomial(terms) => polynomials(&terms).into_iter().map(Value::Polynomial).collect(),
        Value::Formula(_) => Vec::new(),
        Value::Drag(Drag::Matrix(rows)) => {
            let simpler = matrices(&rows, 1, role == Some(Role::SymmetricDrag));
            simpler.into_iter().map(Drag::Matrix).map(Value::Drag).collect()
        }
    }
}
