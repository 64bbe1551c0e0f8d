//! Many bodies at once: what each of them would do alone, whatever is next to it and however many threads there are.

use super::condition::conditions;
use super::engine::{
    BodyParts, Form, Group, OTHER_RETRACTION, STOPPED, TERM_MISSING, fast, group, mix, other, settings, unsupported,
};
use super::step::{ABOUT, ROTATIONS, hopeless, settled, step_of, together, verdict, weighted};
use crate::harness::{About, Cost, Fault, Verdict, evidence};
use crate::integrators::EnsembleError;
use crate::integrators::StepError;
use crate::integrators::lanes::Registers;
use crate::integrators::lanes::Terms;
use crate::integrators::so3::{EnsembleSo3, HalfAngle, Member};
use crate::laws::CaseLaw;
use crate::laws::method::Point;
use crate::laws::planted::tableau::{COEFFICIENT, planted};
use crate::laws::precision::of_relative;
use crate::retraction::beside::{Core, Typed};
use crate::scalar::Scalar;
use crate::study::problem::varied;
use crate::system::case::Tau;
use crate::system::{Case, Cases};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::LazyLock;

pub const NEIGHBOUR: Fault =
    Fault::new("neighbour", "μ' of a body gets h times that of the next body in the ensemble", "ensembles");
pub const THREADS: Fault =
    Fault::new("threads-show", "μ' of the last body multiplied by 1 + h times the number of threads", "ensembles");

/// Steps of a run: more than an ensemble extrapolates from.
const STEPS: usize = 8;

/// Copies of a body with less and less momentum, beside the body itself; a group has eight.
const COPIES: usize = 5;

/// Other bodies.
const OTHERS: i64 = 3;

pub(super) static LAWS: &[CaseLaw] = &[
    CaseLaw {
        about: About {
            name: "fast-ensemble",
            statement: "each body of an ensemble goes where it goes alone",
            source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2, on a product of groups without interaction",
            oracle: "the fast step of each body alone, which extrapolates and iterates in another way",
            needs: ROTATIONS,
            cost: Cost::Moderate,
            faults: &[NEIGHBOUR, THREADS, STOPPED, TERM_MISSING, OTHER_RETRACTION, COEFFICIENT],
            ..ABOUT
        },
        cases: drawn,
        check: |case, fault| settled(each_alone(case, fault)),
    },
    CaseLaw {
        about: About {
            name: "fast-weight-ensemble",
            statement: "each body of an ensemble goes where it goes alone, with a weight or a field, too",
            source: "Marsden and West 2001, §3.2, on a product of groups without interaction",
            oracle: "the fast step of each body alone, which extrapolates and iterates in another way",
            needs: ROTATIONS,
            cost: Cost::Moderate,
            faults: &[NEIGHBOUR, STOPPED, TERM_MISSING],
            ..ABOUT
        },
        cases: drawn,
        check: |case, fault| settled(each_alone(&weighted(case), fault)),
    },
    CaseLaw {
        about: About {
            name: "fast-ensemble-bits",
            statement: "an ensemble gives the same bits on 1 and on 2 threads, in 2 runs and in 1, with a group in another order",
            source: "the definition: every lane has the same operations",
            oracle: "the ensemble itself",
            bound: "none: bits",
            needs: ROTATIONS,
            faults: &[NEIGHBOUR, THREADS],
            ..ABOUT
        },
        cases: drawn,
        check: |case, fault| settled(same_bits(case, fault)),
    },
];

fn drawn(cases: Cases) -> Cases {
    super::step::on_bodies(cases).algebras(&[crate::algebra::catalogue::Entry::So3])
}

/// Pools of one thread and of two.
static POOLS: LazyLock<[Option<ThreadPool>; 2]> =
    LazyLock::new(|| [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().ok()));

fn unfit(why: impl ToString) -> EnsembleError {
    EnsembleError { member: 0, step: 0, time: 0.0, source: StepError::Unsupported { why: why.to_string() } }
}

/// An ensemble's run.
struct Run<'a> {
    parts: &'a BodyParts<3, 3>,
    members: &'a [Member<Terms>],
    h: f64,
    /// How many steps, in how many calls.
    calls: &'a [usize],
    registers: Registers,
    threads: usize,
    fault: Option<&'a Fault>,
}

impl Run<'_> {
    fn with<R>(&self, retraction: R, members: &[Member<Terms>]) -> Result<Vec<Point<f64>>, EnsembleError>
    where
        R: HalfAngle + Send + Sync,
    {
        let tableau = planted(&self.parts.tableau, self.fault);
        let mut ensemble = EnsembleSo3::new(members, retraction, tableau)
            .map_err(unfit)?
            .in_registers(self.registers)
            .with_settings(settings(self.fault));
        let mut run = || self.calls.iter().try_for_each(|steps| ensemble.advance(self.h, *steps));
        // On a thread of its own: one of a campaign's would take up the next case while it waits.
        match &POOLS[self.threads - 1] {
            Some(pool) => std::thread::scope(|scope| {
                scope.spawn(|| pool.install(run)).join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })?,
            None => run()?,
        }
        Ok(ensemble.states().map(|state| Point::of(&state, 3)).collect())
    }

    fn by(&self, tau: Tau, members: &[Member<Terms>]) -> Result<Vec<Point<f64>>, EnsembleError> {
        match tau.closed() {
            Some(Core::Cayley(Typed(tau))) => self.with(tau, members),
            Some(Core::Exponential(Typed(tau))) => self.with(tau, members),
            _ => Err(unfit("the retraction has no closed form on SO(3)")),
        }
    }

    /// Where the bodies end, with the fault or without.
    fn ends(&self) -> Result<Vec<Point<f64>>, EnsembleError> {
        let mut ends = self.by(self.parts.tau, self.members)?;
        let Some(fault) = self.fault else { return Ok(ends) };
        let wrong = if fault.name == TERM_MISSING.name {
            let mut members = self.members.to_vec();
            for member in &mut members {
                member.force.0.pop();
            }
            Some(self.by(self.parts.tau, &members)?)
        } else if fault.name == OTHER_RETRACTION.name {
            Some(self.by(other(self.parts.tau), self.members)?)
        } else {
            None
        };
        for (end, wrong) in ends.iter_mut().zip(wrong.iter().flatten()) {
            mix(&mut end.momentum, &wrong.momentum, fault.size);
        }
        let size = |planted: Fault| planted.size_in(Some(fault));
        let next: Vec<_> = ends.iter().skip(1).chain(&ends[..1]).map(|point| point.momentum.clone()).collect();
        let last = ends.len() - 1;
        for (k, end) in ends.iter_mut().enumerate() {
            let threads = if k == last { size(THREADS) * self.threads as f64 } else { 0.0 };
            for a in 0..3 {
                end.momentum[a] += self.h * size(NEIGHBOUR) * next[k][a];
                end.momentum[a] *= 1.0 + self.h * threads;
            }
        }
        Ok(ends)
    }
}

fn so3(case: &Case) -> Result<BodyParts<3, 3>, StepError> {
    match group(case)? {
        Group::So3 => BodyParts::of(case, None),
        _ => Err(unsupported("ensembles are on SO(3)")),
    }
}

/// The body with (1 − k/16) of its momentum.
fn copy(parts: &BodyParts<3, 3>, k: usize) -> BodyParts<3, 3> {
    let mut copy = parts.clone();
    copy.state.momentum *= 1.0 - k as f64 / 16.0;
    copy
}

fn member(parts: &BodyParts<3, 3>) -> Member<Terms> {
    Member { lagrangian: parts.lagrangian.clone(), force: parts.terms.clone(), state: parts.state.clone() }
}

fn each_alone(case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let (parts, h) = (so3(case)?, step_of(case)?);
    let mut bodies: Vec<_> = (0..=COPIES).map(|k| (case.clone(), copy(&parts, k))).collect();
    for k in 1..=OTHERS {
        let other = varied(case, k);
        bodies.push((other.clone(), so3(&other)?));
    }
    let members: Vec<_> = bodies.iter().map(|(_, parts)| member(parts)).collect();
    let mut alone = Vec::with_capacity(bodies.len());
    for (case, parts) in &bodies {
        let (mut point, mut residual) = (Point::of(&parts.state, 3), 0.0);
        let conditions = conditions(case, &point, h, STEPS)?;
        if let Some(verdict) = hopeless(&conditions) {
            return Ok(verdict);
        }
        let mut method = fast(Form::Matrix, case, Registers::detect(), None)?;
        for _ in 0..STEPS {
            let taken = method(&point, h)?;
            (point, residual) = (taken.end, f64::max(residual, taken.report.residual));
        }
        alone.push((point, residual, conditions[STEPS - 1]));
    }
    let mut verdicts = Vec::new();
    for registers in Registers::all() {
        let run = Run { parts: &parts, members: &members, h, calls: &[STEPS], registers, threads: 2, fault };
        let ends = match run.ends() {
            Ok(ends) => ends,
            Err(error) => return Ok(Verdict::broken(format!("{registers:?}: {error}"))),
        };
        for (k, (found, (expected, residual, condition))) in ends.iter().zip(&alone).enumerate() {
            // Both round: twice what one may.
            let found = verdict(condition.judge(2 * STEPS, *residual, found, expected), || {
                format!("{registers:?}, body {k}: μ' = {:?}, expected {:?}", found.momentum, expected.momentum)
            });
            verdicts.push(found);
        }
    }
    Ok(together(verdicts))
}

fn same_bits(case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let (parts, h) = (so3(case)?, step_of(case)?);
    // Two groups: one of eight, one of four.
    let members: Vec<_> = (0..12).map(|k| member(&copy(&parts, k))).collect();
    let turned: Vec<_> = members.chunks(8).flat_map(|group| group.iter().rev().cloned()).collect();
    let registers = Registers::detect();
    let plain = Run { parts: &parts, members: &members, h, calls: &[STEPS], registers, threads: 1, fault };
    let refused = |error: EnsembleError| error.source;
    let ends = plain.ends().map_err(refused)?;
    let others = [
        ("on two threads", Run { threads: 2, ..plain }.ends()),
        ("in two runs", Run { calls: &[3, STEPS - 3], ..plain }.ends()),
        (
            "with each group turned round",
            Run { members: &turned, ..plain }
                .ends()
                .map(|ends| ends.chunks(8).flat_map(|group| group.iter().rev().cloned()).collect()),
        ),
    ];
    let bits = |point: &Point<f64>| -> Vec<u64> {
        let all = point.momentum.iter().chain(&point.attitude).chain([&point.time]);
        all.map(|x| x.to_bits()).collect()
    };
    let mut defect = 0.0;
    let mut witness = String::new();
    for (what, other) in others {
        let other = other.map_err(refused)?;
        for (k, (x, y)) in ends.iter().zip(&other).enumerate() {
            if bits(x) != bits(y) {
                defect += 1.0;
                witness = format!("body {k} {what}: {x:?}, {y:?}");
            }
        }
    }
    evidence::note(|| of_relative::<f64>(16, defect * f64::unit_roundoff(), 0.0, witness.clone()));
    Ok(Verdict::judge(defect, 0.0, || witness))
}
