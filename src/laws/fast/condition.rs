//! How much a trajectory amplifies what is left of its stage equations: measured, on the general engine.

use crate::integrators::StepError;
use crate::laws::method::library::Library;
use crate::laws::method::{Point, Stepper, difference};
use crate::scalar::{Dd, Number, Real, Scalar, max_abs};
use crate::system::Case;
use crate::system::case::Force;

/// θ, the size of an impulse relative to μ: rounding of the perturbed trajectory is 2⁻²⁹ of what it measures.
const IMPULSE: f64 = 1.0 / (1 << 24) as f64;

/// What a solver leaves of its equations per step, in units of u, beside its residual: each is a sum of s products and of
/// less than 64 more terms.
pub(super) const ROUNDINGS: f64 = 64.0;

/// A residual r is left by an iteration that contracts at 0.8 or faster, r/(1 − 0.8) away from the root.
pub(super) const CONTRACTION: f64 = 5.0;

/// The largest amplification that a case is judged at: the residual that solvers accept, 2¹⁴ u, becomes 10⁻⁸ there, and its
/// square rounding.
const WORST: f64 = (1 << 13) as f64;

/// The size of a trajectory's parts and how much impulses are amplified in them, after each step: of μ and of g.
#[derive(Clone, Copy, Debug)]
pub(super) struct Condition {
    size: [f64; 2],
    amplification: [f64; 2],
    /// The largest |t|.
    time: f64,
}

/// The general engine.
const GENERAL: Library = Library { fault: None, quad: false };

/// The points after each of `steps` steps.
pub(super) fn trajectory<T: Real>(
    method: &mut dyn Stepper<T>,
    start: &Point<T>,
    h: T,
    steps: usize,
) -> Result<Vec<Point<T>>, StepError> {
    let mut points = Vec::with_capacity(steps);
    for _ in 0..steps {
        points.push(method.step(points.last().unwrap_or(start), h)?);
    }
    Ok(points)
}

/// |x − y|, largest component; infinite where it is no number.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    let distance = difference(x, y).0;
    if distance.is_nan() { f64::INFINITY } else { distance }
}

fn parts(point: &Point<f64>) -> [&[f64]; 2] {
    [&point.momentum, &point.attitude]
}

/// How a trajectory is perturbed.
#[derive(Clone, Copy)]
enum Impulse {
    /// By a torque that differs from stage to stage; of two signs.
    Stages(usize),
    /// By a torque about one axis throughout.
    Axis(usize),
}

/// The case with a torque that gives a momentum of θ `size`: in a step of size h, or about one axis in all of the steps.
fn perturbed(case: &Case, size: f64, h: f64, steps: usize, impulse: Impulse) -> Case {
    let (whole, phase) = (IMPULSE * size / h, if let Impulse::Stages(k) = impulse { k } else { 0 });
    let amplitude = |a: usize| match impulse {
        Impulse::Stages(k) if (a + k).is_multiple_of(2) => whole,
        Impulse::Stages(_) => 0.5 * whole,
        Impulse::Axis(axis) if a == axis => whole / steps as f64,
        Impulse::Axis(_) => 0.0,
    };
    let value = (0..case.dimension()).map(|a| Number::from(amplitude(a))).collect();
    let mut perturbed = case.clone();
    perturbed.forces.push(match impulse {
        Impulse::Axis(_) => Force::Constant { value },
        Impulse::Stages(_) => {
            Force::Periodic { value, frequency: Number::from(5.0 / h.abs()), phase: Number::from(phase as f64) }
        }
    });
    perturbed
}

/// The conditions after each of `steps` steps of size h from `start`: the largest of what impulses that differ from stage to stage
/// show, what impulses about the axes show together, and what such impulses at the start do. Rounding of a stage equation is not always that of
/// a torque: where b_j = a_ji, as with one stage at c = 1, torques cancel from it, and what they round stays.
///
/// # Errors
/// Those of the general engine.
pub(super) fn conditions(case: &Case, start: &Point<f64>, h: f64, steps: usize) -> Result<Vec<Condition>, StepError> {
    let run = |case: &Case| trajectory(&mut *GENERAL.build(case)?, start, h, steps);
    let plain = run(case)?;
    let moving = plain.iter().fold(max_abs(&start.momentum), |m, point| m.max(max_abs(&point.momentum)));
    let perturbed = |impulse: Impulse| run(&perturbed(case, moving, h, steps, impulse));
    let stages = [perturbed(Impulse::Stages(0))?, perturbed(Impulse::Stages(1))?];
    let axes = (0..case.dimension()).map(|a| perturbed(Impulse::Axis(a))).collect::<Result<Vec<_>, _>>()?;
    let pushed = |a: usize| {
        let mut start = start.clone();
        start.momentum[a] += IMPULSE * moving;
        trajectory(&mut *GENERAL.build(case)?, &start, h, steps)
    };
    let pushed = (0..case.dimension()).map(pushed).collect::<Result<Vec<_>, _>>()?;
    let (mut size, mut time) = (parts(start).map(max_abs), start.time.abs());
    let mut found = Vec::with_capacity(steps);
    for (n, point) in plain.iter().enumerate() {
        let mut amplification = [0.0; 2];
        for part in 0..2 {
            size[part] = size[part].max(max_abs(parts(point)[part]));
            let moved = |other: &Vec<Point<f64>>| distance(parts(&other[n])[part], parts(point)[part]);
            let together = |runs: &[Vec<Point<f64>>]| runs.iter().map(moved).sum();
            let worst = stages.iter().map(moved).fold(0.0, f64::max).max(together(&axes)).max(together(&pushed));
            amplification[part] = worst / (IMPULSE * size[part]);
        }
        time = time.max(point.time.abs());
        found.push(Condition { size, amplification, time });
    }
    Ok(found)
}

/// A defect and its bound, in units of u, and what it is the defect of.
pub(super) type Judged = (f64, f64, &'static str);

impl Condition {
    /// Whether rounding is amplified more than can be judged.
    pub fn hopeless(&self) -> bool {
        self.amplification.iter().any(|kappa| kappa.is_nan() || *kappa > WORST)
    }

    /// The worst of the defects in μ, g and t of two points after n steps whose equations were solved to `residual`.
    pub fn judge(&self, n: usize, residual: f64, mine: &Point<f64>, other: &Point<f64>) -> Judged {
        self.within(n, n as f64 * CONTRACTION * residual / f64::unit_roundoff(), mine, other)
    }

    /// The same for steps that leave `more`, in units of u, beside what they round.
    pub fn within(&self, n: usize, more: f64, mine: &Point<f64>, other: &Point<f64>) -> Judged {
        let u = f64::unit_roundoff();
        let judged = |part: usize, name: &'static str| {
            let defect = distance(parts(mine)[part], parts(other)[part]) / (u * self.size[part]);
            (defect, (n as f64 * ROUNDINGS + more) * (1.0 + self.amplification[part]), name)
        };
        // A sum of n steps.
        let late = (mine.time - other.time).abs() / (u * self.time.max(f64::MIN_POSITIVE));
        let worse = |x: Judged, y: Judged| if y.0 * x.1 > x.0 * y.1 || y.0.is_nan() { y } else { x };
        worse(worse(judged(0, "μ"), judged(1, "g")), (late, 2.0 * n as f64, "t"))
    }
}

/// The trajectory of the general engine in 32 digits, from a start in 16.
///
/// # Errors
/// Those of the general engine.
pub(super) fn exact(case: &Case, start: &Point<f64>, h: f64, steps: usize) -> Result<Vec<Point<f64>>, StepError> {
    let points = trajectory(&mut *GENERAL.build(case)?, &start.convert::<Dd>(), Dd::exact(h), steps)?;
    Ok(points.iter().map(Point::convert).collect())
}
