//! Computes the solutions again, in 32 digits, and compares them with `references.txt`; with `--write`, prints that file.
//!
//! Gauss's method of order 20 in the crate's variational integrator, in two step sizes that must agree; the paper's two
//! systems at T = 1, from the exact initial values, must also agree with the digits of `mechanics::models`, which come
//! from another method in other arithmetic. That the packaged solvers come as close as they do is the third check.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::{MatrixGroup, So3};
use euler_poincare::integrators::{self, Variational, trajectory};
use euler_poincare::mechanics::configuration::WithPotential;
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag, Zero};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::{Cayley, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::Family;
use peers::ours::Gravity;
use peers::problem::System;
use peers::reference;
use std::error::Error;
use std::process::ExitCode;

const STAGES: usize = 10;
/// Steps in a unit of time of the coarse solution; the fine one has twice as many.
const STEPS: usize = 8;
/// Digits that are kept.
const DIGITS: usize = 25;
/// The largest difference of a component, of numbers of size 1 or so.
const BOUND: f64 = 1e-24;

/// The inertia of the bodies of six dimensions.
const LARGE: [(i64, i64); 6] = [(1, 2), (2, 1), (1, 1), (3, 1), (3, 2), (5, 4)];

type Numbers = Vec<Dd>;

/// μ and g at T.
fn solve<L, F, R, const N: usize, const D: usize>(
    (lagrangian, force, retraction): (&L, &F, &R),
    momentum: Covector<Dd, N>,
    end: f64,
    steps: usize,
) -> Result<(Covector<Dd, N>, Matrix<Dd, D>), Box<dyn Error>>
where
    L: Lagrangian<Dd, N>,
    F: Force<Dd, N>,
    R: Retraction<Dd, N, D>,
{
    let mut method = Variational::new(lagrangian, force, retraction, Family::Gauss.tableau(STAGES)?);
    let mut state = integrators::State { time: Dd::exact(0.0), momentum, attitude: Matrix::identity() };
    let steps = steps * end as usize;
    let h = Dd::exact(end) / Dd::int(steps as i64);
    trajectory::integrate(&mut method, &mut state, h, steps, |_, _, _| {})?;
    Ok((state.momentum, state.attitude))
}

fn rows<const D: usize>(g: &Matrix<Dd, D>, rows: usize, columns: usize) -> impl Iterator<Item = Dd> + '_ {
    (0..rows).flat_map(move |i| (0..columns).map(move |j| g[(i, j)]))
}

fn body(model: &Model<Dd>, momentum: Covector<Dd, 3>, end: f64, steps: usize) -> Result<Numbers, Box<dyn Error>> {
    let system = &model.system;
    let (m, g) =
        solve::<_, _, _, 3, 3>((&system.lagrangian, &system.force, &ExponentialSo3::new()), momentum, end, steps)?;
    Ok(m.iter().copied().chain(rows(&g, 3, 3)).collect())
}

fn top(momentum: Covector<Dd, 3>, end: f64, steps: usize) -> Result<Numbers, Box<dyn Error>> {
    let body = Quadratic::diagonal([(1, 2), (2, 1), (1, 1)].map(|(p, q)| Dd::ratio(p, q)))?;
    let top = WithPotential::new(body, Gravity, So3::new());
    let (m, g) = solve::<_, _, _, 3, 3>((&top, &Zero, &ExponentialSo3::new()), momentum, end, steps)?;
    Ok(m.iter().copied().chain(rows(&g, 3, 3)).collect())
}

/// μ and g at T of a body with drag.
fn dragged<const N: usize, const D: usize>(
    (entry, inertia): (Entry, [(i64, i64); N]),
    momentum: &[Dd],
    end: f64,
    steps: usize,
) -> Result<(Numbers, Matrix<Dd, D>), Box<dyn Error>> {
    let group = MatrixGroup::<Dd, N, D>::from_entry(&entry)?;
    let inertia = inertia.map(|(p, q)| Dd::ratio(p, q));
    let drag = |p, q| Matrix::from_diagonal_element(Dd::ratio(p, q));
    let force = AnyForce::Sum(vec![LinearDrag::new(drag(1, 8))?.into(), QuadraticDrag::new(drag(1, 4))?.into()]);
    let parts = (&Quadratic::diagonal(inertia)?, &force, &Cayley::new(group)?);
    let momentum = Covector::<Dd, N>::from_column_slice(&momentum[..N]);
    let (m, g) = solve::<_, _, _, N, D>(parts, momentum, end, steps)?;
    Ok((m.iter().copied().collect(), g))
}

/// The solution from the `f64` initial values.
fn solution(system: System, end: f64, steps: usize) -> Result<Numbers, Box<dyn Error>> {
    let start = system.start().map(Dd::exact);
    match system {
        System::LandauLifshitzGilbert => {
            body(&landau_lifshitz_gilbert(), Covector::from_column_slice(&start[..3]), end, steps)
        }
        System::Relaxed => body(&relaxed_rigid_body(), Covector::from_column_slice(&start[..3]), end, steps),
        System::HeavyTop => top(Covector::from_column_slice(&start[..3]), end, steps),
        System::Plane => {
            let (m, g) = dragged::<3, 3>((Entry::Se2, [(1, 2), (2, 1), (1, 1)]), &start, end, steps)?;
            Ok(m.into_iter().chain([g[(0, 0)], g[(1, 0)], g[(0, 2)], g[(1, 2)]]).collect())
        }
        System::Special => {
            let (m, g) = dragged::<3, 2>((Entry::Sl2, [(1, 1), (2, 1), (3, 2)]), &start, end, steps)?;
            Ok(m.into_iter().chain(rows(&g, 2, 2)).collect())
        }
        System::Fluid => {
            let (m, g) = dragged::<6, 4>((Entry::Se3, LARGE), &start, end, steps)?;
            Ok(m.into_iter().chain(rows(&g, 3, 3)).chain((0..3).map(|i| g[(i, 3)])).collect())
        }
        System::FourSpace => {
            let (m, g) = dragged::<6, 4>((Entry::So4, LARGE), &start, end, steps)?;
            Ok(m.into_iter().chain(rows(&g, 4, 4)).collect())
        }
    }
}

/// The largest difference, which must be below the bound.
fn agree(what: &str, x: &[Dd], y: &[Dd], bound: f64) -> Result<f64, Box<dyn Error>> {
    let worst = x.iter().zip(y).fold(0.0f64, |worst, (x, y)| worst.max((*x - *y).hi().abs()));
    if x.len() == y.len() && worst <= bound {
        Ok(worst)
    } else {
        Err(format!("{what}: a difference of {worst:e}").into())
    }
}

/// The paper's systems at T = 1, against the digits of the crate.
fn check_models() -> Result<(), Box<dyn Error>> {
    for model in [landau_lifshitz_gilbert::<Dd>(), relaxed_rigid_body()] {
        let known = model.reference_momentum().ok_or("the digits of a model are not numbers")?;
        let reached = body(&model, model.momentum, 1.0, 2 * STEPS)?;
        let difference = agree(model.name, &reached[..3], known.as_slice(), BOUND)?;
        eprintln!("{}, T = 1: {difference:.0e} from the digits of the model", model.name);
    }
    Ok(())
}

fn run(write: bool) -> Result<(), Box<dyn Error>> {
    check_models()?;
    if write {
        println!("# System, T, momentum and attitude (row by row; then the position) at T: see src/bin/reference.rs");
    }
    for system in System::ALL {
        for &end in system.ends() {
            let what = format!("{}, T = {end}", system.name());
            let fine = solution(system, end, 2 * STEPS)?;
            let difference = agree(&what, &solution(system, end, STEPS)?, &fine, BOUND)?;
            eprintln!("{what}: {difference:.0e} from the solution in half as many steps");
            if write {
                let digits: Vec<String> = fine.iter().map(|x| format!("{x:.*e}", DIGITS - 1)).collect();
                println!("{} {end} {}", system.name(), digits.join(" "));
                continue;
            }
            let stored: Option<Numbers> =
                reference::digits(system, end).and_then(|digits| digits.into_iter().map(Dd::parse_decimal).collect());
            let difference = agree(&what, &stored.ok_or("the stored digits are not numbers")?, &fine, BOUND)?;
            eprintln!("{what}: {difference:.0e} from the stored digits");
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(std::env::args().any(|word| word == "--write")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
