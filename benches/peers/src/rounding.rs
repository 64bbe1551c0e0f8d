//! How rounding errors grow over 10⁷ steps: what the method keeps exactly changes by rounding alone.
//!
//! A free body keeps |μ|² and the spatial momentum g μ exactly, whatever the step, and every body keeps gᵀg = 1. With a
//! force |μ|² is not kept by the method; there each body has a twin, the same one in axes (y, x, −z), whose numbers
//! differ from its own by rounding alone.

use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::integrators::lanes::{Damping, EnsembleForce, Free, Registers, VariationalInLanes};
use euler_poincare::integrators::so3::{EnsembleSo3, Member};
use euler_poincare::integrators::{OneStep, State, Variational};
use euler_poincare::mechanics::force::Zero;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::CayleySo3;
use euler_poincare::tableau::{Description, Tableau};
use std::error::Error;
use std::time::Instant;

/// Bodies of a run.
const BODIES: usize = 64;
/// The step.
const STEP: f64 = 0.1;
/// What the exponent is asked to stay below; a random walk has ½, a drift 1.
const MOST: f64 = 0.6;

type Body = State<f64, 3, 3>;
type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The rms of each quantity at each number of steps.
struct Growth {
    title: &'static str,
    names: Vec<&'static str>,
    steps: Vec<u64>,
    /// By number of steps, then by quantity.
    rms: Vec<Vec<f64>>,
    /// Of a step of a body, since the number of steps before.
    nanoseconds: Vec<f64>,
}

/// The exponent of a power law through the points, by least squares in log-log, and its standard error.
fn exponent(steps: &[u64], rms: &[f64]) -> (f64, f64) {
    let points: Vec<(f64, f64)> = steps.iter().zip(rms).map(|(n, y)| ((*n as f64).ln(), y.ln())).collect();
    let count = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / count;
    let (x0, y0) = (mean(&|p| p.0), mean(&|p| p.1));
    let (xx, xy) = (mean(&|p| (p.0 - x0).powi(2)), mean(&|p| (p.0 - x0) * (p.1 - y0)));
    let slope = xy / xx;
    let left = mean(&|p| (p.1 - y0 - slope * (p.0 - x0)).powi(2));
    (slope, (left / (xx * (count - 2.0))).sqrt())
}

impl Growth {
    fn text(&self) -> String {
        let mut text = format!("{}\n{:>10}", self.title, "steps");
        self.names.iter().for_each(|name| text.push_str(&format!("  {name:>20}")));
        text.push_str("   ns a step");
        for ((steps, rms), time) in self.steps.iter().zip(&self.rms).zip(&self.nanoseconds) {
            text.push_str(&format!("\n{steps:>10}"));
            rms.iter().for_each(|value| text.push_str(&format!("  {value:>20.2e}")));
            text.push_str(&format!("  {time:>10.0}"));
        }
        text.push_str(&format!("\n{:>10}", "exponent"));
        for (slope, error) in self.exponents() {
            let cell = format!("{slope:.3} ± {error:.3}");
            text.push_str(&format!("  {cell:>20}"));
        }
        text + "\n"
    }

    fn exponents(&self) -> Vec<(f64, f64)> {
        let column = |k: usize| self.rms.iter().map(|row| row[k]).collect::<Vec<_>>();
        (0..self.names.len()).map(|k| exponent(&self.steps, &column(k))).collect()
    }
}

/// 10³, 10³·⁵, …, 10^last.
fn decades(last: u32) -> Vec<u64> {
    (6..=2 * last).map(|k| 10f64.powf(f64::from(k) / 2.0).round() as u64).collect()
}

/// Inertia and initial state of body k: a fixed list without any order in it.
fn body(k: usize) -> ([f64; 3], Body) {
    let x = |n: f64| ((k as f64 + 1.0) * (n + 0.5).sqrt()).fract();
    let g = euler_poincare::algebra::Vector::<f64, 3>::new(x(6.0) - 0.5, x(7.0) - 0.5, x(10.0) - 0.5);
    let momentum = Covector::<f64, 3>::new(x(2.0) - 0.5, 0.25 + x(3.0), x(5.0) - 0.5);
    let tau = CayleySo3::new();
    let attitude = euler_poincare::retraction::Retraction::tau(&tau, &g).unwrap_or_else(|_| Matrix::identity());
    ([0.5 + x(11.0), 0.75 + x(13.0), 1.0], State { time: 0.0, momentum, attitude })
}

/// The same body in axes (y, x, −z).
fn twin(([a, b, c], state): ([f64; 3], Body)) -> ([f64; 3], Body) {
    let m = state.momentum;
    let g = state.attitude;
    let attitude = Matrix::<f64, 3>::from_fn(|r, a| [g[(r, 1)], g[(r, 0)], -g[(r, 2)]][a]);
    ([b, a, c], State { momentum: Covector::<f64, 3>::new(m[1], m[0], -m[2]), attitude, ..state })
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0usize, 0.0), |(count, sum), v| (count + 1, sum + v * v));
    (sum / count as f64).sqrt()
}

/// a² + b² + c² − (A² + B² + C²), without the rounding of the squares: the quantity itself is as small as u.
fn change_of_square(m: &Covector<f64, 3>, start: &Covector<f64, 3>) -> f64 {
    (0..3).map(|a| (m[a] - start[a]) * (m[a] + start[a])).sum::<f64>() / start.norm_squared()
}

/// |gᵀg − 1|, the largest entry, each product and sum to twice the digits.
fn departure(g: &Matrix<f64, 3>) -> f64 {
    let mut most = 0.0f64;
    for a in 0..3 {
        for b in 0..=a {
            let (mut sum, mut rest) = (if a == b { -1.0 } else { 0.0 }, 0.0);
            for r in 0..3 {
                let product = g[(r, a)] * g[(r, b)];
                rest += g[(r, a)].mul_add(g[(r, b)], -product);
                let next = sum + product;
                let part = next - sum;
                rest += (sum - (next - part)) + (product - part);
                sum = next;
            }
            most = most.max((sum + rest).abs());
        }
    }
    most
}

fn spatial(state: &Body) -> euler_poincare::algebra::Vector<f64, 3> {
    state.attitude * state.momentum.transpose()
}

/// |μ|², g μ and gᵀg of free bodies, as they are moved on by `advance` (by a number of steps).
fn free(
    title: &'static str,
    last: u32,
    starts: &[Body],
    mut advance: impl FnMut(u64) -> Result<Vec<Body>>,
) -> Result<Growth> {
    let steps = decades(last);
    let (mut taken, mut table, mut nanoseconds) = (0, Vec::new(), Vec::new());
    for &n in &steps {
        let clock = Clock::start();
        let states = advance(n - taken)?;
        nanoseconds.push(clock.nanoseconds() / ((n - taken) as f64 * starts.len() as f64));
        taken = n;
        let pairs = || starts.iter().zip(&states);
        table.push(vec![
            rms(pairs().map(|(start, state)| change_of_square(&state.momentum, &start.momentum))),
            rms(pairs().map(|(start, state)| (spatial(state) - spatial(start)).norm() / start.momentum.norm())),
            rms(states.iter().map(|state| departure(&state.attitude))),
        ]);
    }
    let names = vec!["|mu|^2", "g mu", "g'g - 1"];
    Ok(Growth { title, names, steps, rms: table, nanoseconds })
}

fn members<F: Clone>(bodies: &[([f64; 3], Body)], force: &F) -> Result<Vec<Member<F>>> {
    let member = |(inertia, state): &([f64; 3], Body)| {
        Ok(Member { lagrangian: Quadratic::diagonal(*inertia)?, force: force.clone(), state: state.clone() })
    };
    bodies.iter().map(member).collect()
}

fn ensemble<F: EnsembleForce>(
    bodies: &[([f64; 3], Body)],
    force: &F,
    tableau: &Tableau<f64>,
) -> Result<EnsembleSo3<F, CayleySo3<f64>>> {
    let members = members(bodies, force)?;
    Ok(EnsembleSo3::new(&members, CayleySo3::new(), tableau.clone())?.in_registers(Registers::detect()))
}

/// Time that this thread has run, in nanoseconds: where the system says so (Linux), it does not depend on what else runs.
struct Clock(Instant, Option<f64>);

impl Clock {
    fn start() -> Self {
        Self(Instant::now(), Self::running())
    }

    fn running() -> Option<f64> {
        std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
    }

    fn nanoseconds(&self) -> f64 {
        let running = self.1.and_then(|start| Some(Self::running()? - start));
        running.unwrap_or_else(|| self.0.elapsed().as_secs_f64() * 1e9)
    }
}

/// |μ|² of damped bodies against their twins', and gᵀg.
fn damped(last: u32, bodies: &[([f64; 3], Body)], tableau: &Tableau<f64>) -> Result<Growth> {
    let steps = decades(last);
    let twins: Vec<_> = bodies.iter().cloned().map(twin).collect();
    let mut both = [bodies, &twins]
        .into_iter()
        .map(|bodies| ensemble(bodies, &Damping(1.0), tableau))
        .collect::<Result<Vec<_>>>()?;
    let (mut taken, mut table, mut nanoseconds) = (0, Vec::new(), Vec::new());
    for &n in &steps {
        let clock = Clock::start();
        for ensemble in &mut both {
            ensemble.advance(STEP, (n - taken) as usize)?;
        }
        nanoseconds.push(clock.nanoseconds() / ((n - taken) as f64 * 2.0 * bodies.len() as f64));
        taken = n;
        let turned = |state: Body| twin(([0.0; 3], state)).1.momentum;
        let pairs = both[0].states().zip(both[1].states());
        table.push(vec![
            rms(pairs.map(|(x, y)| change_of_square(&turned(y), &x.momentum) / 2f64.sqrt())),
            rms(both[0].states().map(|state| departure(&state.attitude))),
        ]);
    }
    let title = "EnsembleSo3, damped (LLG, alpha = 1)";
    let names = vec!["|mu|^2 against twin", "g'g - 1"];
    Ok(Growth { title, names, steps, rms: table, nanoseconds })
}

/// So many steps of each body by a method of its own.
fn each<M: OneStep<f64, 3, 3>>(pairs: &mut [(M, Body)], steps: u64) -> Result<Vec<Body>> {
    for (method, state) in pairs.iter_mut() {
        for _ in 0..steps {
            method.step(state, STEP)?;
        }
    }
    Ok(pairs.iter().map(|(_, state)| state.clone()).collect())
}

/// Runs all and prints the tables; fails where an exponent of the fast step is above 0.6.
///
/// # Errors
/// A step that fails; an exponent that is too large.
pub fn run() -> Result<()> {
    let tableau = "gauss-2".parse::<Description>()?.build()?;
    let bodies: Vec<_> = (0..BODIES).map(body).collect();
    let starts: Vec<Body> = bodies.iter().map(|(_, state)| state.clone()).collect();
    println!("rms of {BODIES} bodies, Gauss-2 with the Cayley map, h = {STEP}\n");

    let mut many = ensemble(&bodies, &Free, &tableau)?;
    let first = free("EnsembleSo3, free", 7, &starts, |steps| {
        many.advance(STEP, steps as usize)?;
        Ok(many.states().collect())
    })?;
    println!("{}", first.text());
    let second = damped(5, &bodies, &tableau)?;
    println!("{}", second.text());

    let few = &bodies[..BODIES / 2];
    let quadratic = |inertia: &[f64; 3]| Quadratic::diagonal(*inertia);
    let mut pairs = few
        .iter()
        .map(|(i, s)| Ok((VariationalInLanes::new(quadratic(i)?, Free, CayleySo3::new(), tableau.clone())?, s.clone())))
        .collect::<Result<Vec<_>>>()?;
    let third =
        free("VariationalInLanes, free, the first 32", 6, &starts[..few.len()], |steps| each(&mut pairs, steps))?;
    println!("{}", third.text());
    let mut pairs = few
        .iter()
        .map(|(i, s)| Ok((Variational::new(quadratic(i)?, Zero, CayleySo3::new(), tableau.clone()), s.clone())))
        .collect::<Result<Vec<_>>>()?;
    let fourth = free("Variational (sums not compensated), free, the first 32", 5, &starts[..few.len()], |steps| {
        each(&mut pairs, steps)
    })?;
    println!("{}", fourth.text());

    let fast = [first, second, third];
    let over = fast.iter().flat_map(|growth| {
        let worst = growth.exponents().into_iter().zip(&growth.names).filter(|((slope, _), _)| *slope > MOST);
        worst.map(|((slope, _), name)| format!("{}: {name} grows with exponent {slope:.3}", growth.title))
    });
    let over: Vec<String> = over.collect();
    if over.is_empty() { Ok(()) } else { Err(over.join("\n").into()) }
}
