//! Simpler cases than a given one: a pure function of the case, so saved cases shrink as well as generated ones.
//!
//! Every candidate lowers (dimension, rank of the algebra, parts, distances of numbers from their targets on their
//! own dyadic grid) in lexicographic order, so greedy descent ends.

use super::case::{Algebra, Case, Drag, Force, Inertia, Lagrangian, Monomial, Motion, Structure, Tau};
use super::force::{ForceKind, Role, Value};
use super::numbers::{dyadic, from_dyadic};
use crate::algebra::MatrixAlgebra;
use crate::algebra::catalogue::Entry;
use crate::retraction::is_odd;
use crate::scalar::Number;
use std::sync::LazyLock;

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
fn entries(list: &[Number], target: i64) -> Vec<Vec<Number>> {
    let mut found = Vec::new();
    for (i, x) in list.iter().enumerate() {
        for simpler in towards(x, target) {
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

/// Algebras from the simplest on; later ones may be replaced by earlier ones: ℝ, then by dimension, in each those of rotations first, then
/// by name. ℝ² tells less than those of dimension 3.
static LADDER: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let mut ladder = Entry::NAMED.to_vec();
    ladder.sort_by_cached_key(|entry| (entry.dimension(), entry.rotation() < entry.matrix_size(), entry.to_string()));
    ladder.insert(ladder.partition_point(|entry| entry.dimension() <= 3), Entry::Abelian(2));
    ladder.insert(0, Entry::Abelian(1));
    ladder
});

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
    let mut replace = |structure: Structure| {
        let algebra = Algebra { structure, basis: None };
        let m = algebra.dimension();
        if m < n || (m == n && rank(&algebra.structure) < rank_now) {
            found.push(with(case, |case| {
                case.algebra = algebra;
                truncate(case, m);
            }));
        }
    };
    LADDER.iter().cloned().map(Structure::Named).for_each(&mut replace);
    match &case.algebra.structure {
        Structure::Named(Entry::Abelian(n)) => (3..*n).map(Entry::Abelian).map(Structure::Named).for_each(replace),
        Structure::Named(Entry::Product(factors)) => factors.iter().cloned().map(Structure::Named).for_each(replace),
        Structure::Named(_) | Structure::Given { .. } => {}
        Structure::Matrices { family, algebra } => {
            // The subalgebras of the first basis vectors.
            let first = |m: usize| MatrixAlgebra::new(algebra.matrices()[..m].to_vec()).ok();
            let structure = |algebra| Structure::Matrices { family: *family, algebra };
            (1..n).filter_map(first).map(structure).for_each(replace);
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
    for (_, part) in case.parts_mut() {
        match part {
            Value::List(list) | Value::Form(Inertia::Diagonal(list)) => list.truncate(m),
            Value::Form(Inertia::Full(rows)) | Value::Drag(Drag::Matrix(rows)) => {
                rows.truncate(m);
                rows.iter_mut().for_each(|row| row.truncate(m));
            }
            Value::Polynomial(terms) => terms.retain(|term| term.largest() <= m),
            Value::Number(_) | Value::Drag(Drag::Coefficient(_)) | Value::Formula(_) => {}
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
        for (k, (parameter, value)) in potential.parameters().enumerate() {
            let put = |value| with(case, |case| case.potentials[i].set(k, value));
            found.extend(simpler_values(value, parameter.role).into_iter().map(put));
        }
    }
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
    for (k, (role, value)) in case.clone().parts_mut().into_iter().enumerate() {
        let put = |value| with(case, |case| case.parts_mut().swap_remove(k).1.put(value));
        found.extend(simpler_values(value.get(), role).into_iter().map(put));
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
    let mut simpler = kind.with([]);
    for (k, wanted) in kind.parameters.iter().enumerate() {
        if let Some((_, value)) = force.parameters().find(|(parameter, _)| parameter.name == wanted.name) {
            simpler.set(k, value);
        }
    }
    Some(simpler)
}

/// The value with one number of it nearer to 0 or 1, mirrored entries together; a phase stays.
fn simpler_values(value: Value, role: Role) -> Vec<Value> {
    let odd = |terms: &Vec<Monomial>| terms.iter().all(|term| is_odd(term.factors.len()));
    match value {
        Value::Number(_) if role == Role::Phase => Vec::new(),
        Value::Number(x) => towards(&x, 1).into_iter().map(Value::Number).collect(),
        Value::List(list) => entries(&list, 0).into_iter().map(Value::List).collect(),
        Value::Form(Inertia::Diagonal(list)) => {
            entries(&list, 1).into_iter().map(Inertia::Diagonal).map(Value::Form).collect()
        }
        Value::Form(Inertia::Full(rows)) => {
            matrices(&rows, 1, true).into_iter().map(Inertia::Full).map(Value::Form).collect()
        }
        Value::Drag(Drag::Coefficient(x)) => {
            towards(&x, 1).into_iter().map(Drag::Coefficient).map(Value::Drag).collect()
        }
        Value::Drag(Drag::Matrix(rows)) => {
            let simpler = matrices(&rows, 1, role == Role::SymmetricDrag);
            simpler.into_iter().map(Drag::Matrix).map(Value::Drag).collect()
        }
        Value::Polynomial(terms) => {
            let simpler = polynomials(&terms).into_iter().filter(|terms| role != Role::OddPolynomial || odd(terms));
            simpler.map(Value::Polynomial).collect()
        }
        Value::Formula(_) => Vec::new(),
    }
}
