//! A stepper in Rust that speaks the protocol of `PROTOCOL.md`: this library's variational method with exp, of any tableau.
//!
//! `gauss [TABLEAU [TOLERANCE]]`: a name such as `gauss-2` (the default, order 4), `lobatto-iiia-3`, `radau-iia-2`; how well a step
//! solves its equations, relative (default: to round-off). `cargo build --release --example gauss`, then
//!
//!     euler-poincare probe --order 4 --conserves casimirs,momentum,poisson -- target/release/examples/gauss

use euler_poincare::algebra::{Covector, LieAlgebra, Matrix};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::{OneStep, State, Variational};
use euler_poincare::mechanics::force::{
    AnyForce, Constant, CubicDrag, DoubleBracket, LinearDrag, Metriplectic, Monomial, Periodic, Polynomial,
    QuadraticDrag,
};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Gyrostat, Quadratic, Quartic};
use euler_poincare::mechanics::lie_poisson::OrbitForce;
use euler_poincare::retraction::Exponential;
use euler_poincare::tableau::{Description, Tableau};
use serde::Deserialize;
use serde_json::{Value, json};
use std::env::args;
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};

#[derive(Deserialize)]
struct Request {
    version: u32,
    dimension: usize,
    constants: Vec<f64>,
    size: usize,
    #[serde(default)]
    basis: Vec<f64>,
    inertia: Vec<f64>,
    #[serde(default)]
    quartic: f64,
    #[serde(default)]
    metric: Vec<f64>,
    #[serde(default)]
    gyrostat: Vec<f64>,
    force: Vec<Term>,
    time: f64,
    step: f64,
    mu: Vec<f64>,
    #[serde(default)]
    g: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Term {
    DoubleBracket { alpha: f64 },
    Metriplectic { beta: f64 },
    LinearDrag { matrix: Vec<f64> },
    QuadraticDrag { matrix: Vec<f64> },
    CubicDrag { q: f64 },
    Polynomial { terms: Vec<Row> },
    Orbit { zeta: Vec<Row> },
    Constant { value: Vec<f64> },
    Periodic { value: Vec<f64>, frequency: f64, phase: f64 },
}

/// A term of a polynomial.
type Row = (usize, f64, usize, usize, Vec<usize>);

fn polynomial<const N: usize>(rows: &[Row]) -> Result<Polynomial<f64, N>, Box<dyn Error>> {
    let term =
        |(component, coefficient, cos, sin, factors): Row| Monomial { component, coefficient, cos, sin, factors };
    Ok(Polynomial::new(rows.iter().cloned().map(term).collect())?)
}

/// Which method.
struct Chosen {
    tableau: Tableau<f64>,
    settings: Settings<f64>,
}

impl Chosen {
    /// By the arguments of the command.
    fn of(arguments: &[String]) -> Result<Self, Box<dyn Error>> {
        let tableau: Description = arguments.first().map_or("gauss-2", String::as_str).parse()?;
        let mut settings = Settings::default();
        if let Some(tolerance) = arguments.get(1) {
            settings.tolerance = tolerance.parse()?;
        }
        Ok(Self { tableau: tableau.build()?, settings })
    }
}

/// A step on an algebra of dimension N, with matrices padded to D×D.
fn step<const N: usize, const D: usize>(chosen: &Chosen, q: &Request) -> Result<Value, Box<dyn Error>> {
    let m = q.size;
    if m > D {
        return Ok(json!({ "unsupported": "matrices of this size" }));
    }
    let algebra = LieAlgebra::<f64, N>::new(|a, b, c| q.constants[(a * N + b) * N + c])?;
    let inertia = Matrix::<f64, N>::from_row_slice(&q.inertia);
    let mut body: AnyLagrangian<f64, N> = match (q.quartic == 0.0, q.metric.is_empty()) {
        (true, _) => Quadratic::new(inertia)?.into(),
        (false, true) => Quartic::new(inertia, q.quartic)?.into(),
        (false, false) => Quartic::in_metric(inertia, q.quartic, &Matrix::from_row_slice(&q.metric))?.into(),
    };
    if !q.gyrostat.is_empty() {
        body = Gyrostat::new(body, Covector::from_row_slice(&q.gyrostat))?.into();
    }
    let term = |term: &Term| -> Result<AnyForce<f64, N>, Box<dyn Error>> {
        Ok(match term {
            Term::DoubleBracket { alpha } => DoubleBracket::new(algebra.clone(), body.clone(), *alpha)?.into(),
            Term::Metriplectic { beta } => Metriplectic::new(algebra.clone(), body.clone(), *beta)?.into(),
            Term::LinearDrag { matrix } => LinearDrag::new(Matrix::from_row_slice(matrix))?.into(),
            Term::QuadraticDrag { matrix } => QuadraticDrag::new(Matrix::from_row_slice(matrix))?.into(),
            Term::CubicDrag { q } => CubicDrag::new(*q)?.into(),
            Term::Polynomial { terms } => polynomial(terms)?.into(),
            Term::Orbit { zeta } => OrbitForce::new(algebra.clone(), body.clone(), polynomial(zeta)?).into(),
            Term::Constant { value } => Constant::new(Covector::from_row_slice(value))?.into(),
            Term::Periodic { value, frequency, phase } => {
                Periodic::new(Covector::from_row_slice(value), *frequency, *phase)?.into()
            }
        })
    };
    let force = AnyForce::Sum(q.force.iter().map(term).collect::<Result<_, _>>()?);
    // A padded matrix is zero outside its block in the algebra, and the identity there in the group.
    let block = |list: &[f64], outside: f64| {
        Matrix::<f64, D>::from_fn(|r, c| match (r < m && c < m, r == c) {
            (true, _) => list[r * m + c],
            (false, true) => outside,
            (false, false) => 0.0,
        })
    };
    let exp = if m == 0 {
        Exponential::of_algebra(algebra.clone())
    } else {
        Exponential::of_group(MatrixGroup::new(std::array::from_fn(|a| block(&q.basis[a * m * m..], 0.0)))?)
    };
    let Chosen { tableau, settings } = chosen;
    let mut method = Variational::with_settings(body, force, exp, tableau.clone(), *settings);
    let momentum = Covector::<f64, N>::from_row_slice(&q.mu);
    let attitude = if m == 0 { Matrix::identity() } else { block(&q.g, 1.0) };
    let mut state = State { time: q.time, momentum, attitude };
    if let Err(error) = method.step(&mut state, q.step) {
        return Ok(json!({ "error": error.to_string() }));
    }
    let mu: Vec<f64> = state.momentum.iter().copied().collect();
    let g: Vec<f64> = (0..m * m).map(|k| state.attitude[(k / m, k % m)]).collect();
    Ok(if m == 0 { json!({ "mu": mu }) } else { json!({ "mu": mu, "g": g }) })
}

fn answer(chosen: &Chosen, line: &str) -> Result<Value, Box<dyn Error>> {
    let q: Request = serde_json::from_str(line)?;
    if q.version > 2 {
        return Ok(json!({ "unsupported": "a later version of the protocol" }));
    }
    match q.dimension {
        2 => step::<2, 4>(chosen, &q),
        3 => step::<3, 5>(chosen, &q),
        6 => step::<6, 8>(chosen, &q),
        n => Ok(json!({ "unsupported": format!("dimension {n}: compiled for 2, 3 and 6") })),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let chosen = Chosen::of(&args().skip(1).collect::<Vec<_>>())?;
    for (number, line) in stdin().lock().lines().enumerate() {
        let mut answer = answer(&chosen, &line?).unwrap_or_else(|error| json!({ "error": error.to_string() }));
        if number == 0 {
            // Once: random systems are drawn of these.
            answer["supports"] = json!({ "dimensions": [2, 3, 6] });
        }
        let mut out = stdout().lock();
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}
