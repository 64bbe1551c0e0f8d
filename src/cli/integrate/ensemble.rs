//! `integrate --ensemble`: many members in batches, to final states or to statistics over time.

use super::Arguments;
use super::columns::Columns;
use super::rows::Rows;
use super::run::Bar;
use super::states::{Members, States};
use crate::cli::interrupt::Interrupt;
use crate::cli::summary::count;
use crate::cli::table::paragraph;
use crate::cli::{Failure, complain};
use euler_poincare::system::ensemble::{Batch, Ensemble, Origin, Sample, Statistics};
use euler_poincare::system::{Compiled, SystemFile};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// The most times of which statistics are kept.
const MOST_TIMES: u64 = 100_000;

/// How long the members of a batch go on before the keyboard and the progress are looked at.
const SLICE: Duration = Duration::from_millis(100);

/// What is asked for.
pub struct Task<'a> {
    pub file: &'a SystemFile,
    pub system: &'a Path,
    pub states: &'a Path,
    pub out: Option<&'a Path>,
    pub arguments: &'a Arguments,
}

impl Task<'_> {
    /// Does it, in the arithmetic `T`.
    pub fn run<T: Compiled>(&self) -> Result<ExitCode, Failure> {
        let Arguments { statistics, general, jobs, .. } = *self.arguments;
        let (steps, last) = self.file.plan::<T>().map_err(|refused| Failure::file(self.system, refused))?;
        let step = self.file.case.step.eval::<T>().map_err(|refused| Failure::file(self.system, refused))?;
        let columns = Columns::new(&self.file.case);
        let states = States::open(self.states, self.file, &columns)?;
        let ensemble = Ensemble::new(&self.file.case).with_parameters(states.parameters.clone());
        let ensemble = if general { ensemble.general() } else { ensemble };
        let times = times(steps + u64::from(last.is_some()), self.file.output.every);
        if statistics && times > MOST_TIMES {
            let every = (steps + 1).div_ceil(MOST_TIMES - 2);
            return Err(Failure::Usage(format!(
                "statistics of {times} times are more than {MOST_TIMES}: --every {every} or more is needed"
            )));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.map_or(0, usize::from)).build();
        let pool = pool.map_err(|error| Failure::System(format!("cannot start the threads: {error}")))?;
        let total = pool.install(|| states.check::<T>(&ensemble))?;
        let interrupt = Interrupt::catch()?;
        let (out, shown) = Rows::create(self.out)?;
        let mut run = Run {
            ensemble: &ensemble,
            columns: &columns,
            parts: [(steps, step), (u64::from(last.is_some()), last.unwrap_or(step))],
            every: self.file.output.every,
            interrupt,
            bar: Bar::new(shown),
            members: total,
            done: 0,
            slice: 1,
            out,
            ended: Ended::default(),
        };
        let members = states.members::<T>()?;
        let outcome = pool.install(|| if statistics { run.statistics(members) } else { run.states(members) });
        run.bar.clear();
        outcome?;
        run.out.finish(self.out)?;
        self.end(&run.ended, total, run.bar.elapsed())
    }

    fn end(&self, ended: &Ended, total: u64, time: Duration) -> Result<ExitCode, Failure> {
        let Ended { members, failed, steps, first, interrupted } = ended;
        let members_of = |n: u64| count(n, "member");
        if let Some(out) = self.out {
            let seconds = time.as_secs_f64();
            let rate = *steps as f64 / seconds.max(1e-9);
            let (members, steps) = (members_of(*members), count(*steps, "step"));
            let text = format!("{}: {members}, {steps}, {rate:.1e} a second", out.display());
            crate::cli::print(&format!("{}\n", paragraph(&text)))?;
        }
        if *interrupted {
            complain(&format!("INTERRUPTED after {} of {total}: their rows are kept", members_of(*members)));
            return Ok(Interrupt::exit_code());
        }
        match first {
            None => Ok(ExitCode::SUCCESS),
            Some(first) => {
                let of = format!("{failed} of {} failed; the first: {first}", members_of(total));
                Err(Failure::Computation(of))
            }
        }
    }
}

/// The number of rows of statistics: the start, one per `every` steps, and the end.
fn times(steps: u64, every: u64) -> u64 {
    1 + steps.div_ceil(every)
}

/// What has become of the members.
#[derive(Debug, Default)]
struct Ended {
    /// Whole batches of them.
    members: u64,
    failed: u64,
    steps: u64,
    /// The first that failed, and why.
    first: Option<String>,
    interrupted: bool,
}

struct Run<'a, T> {
    ensemble: &'a Ensemble,
    columns: &'a Columns,
    /// Steps of one size, and a last one of another.
    parts: [(u64, T); 2],
    every: u64,
    interrupt: Interrupt,
    bar: Bar,
    /// How many there are.
    members: u64,
    /// Steps of all members, those of members that failed too when their batch is done.
    done: u64,
    /// How many steps a batch takes between two looks at the keyboard.
    slice: u64,
    out: Rows,
    ended: Ended,
}

impl<T: Compiled> Run<'_, T> {
    /// Batch after batch, to the end of their time.
    fn each(
        &mut self,
        mut members: Members<'_, T>,
        mut drive: impl FnMut(&mut Self, &mut dyn Batch<T>),
    ) -> Result<(), Failure> {
        let most = self.ensemble.batch();
        while !self.interrupt.is_set() {
            // What cannot be written ends the run, too.
            if self.out.failed() {
                return Ok(());
            }
            let origins: Vec<Origin<T>> = members.batch(most)?.into_iter().map(|(_, origin)| origin).collect();
            if origins.is_empty() {
                return Ok(());
            }
            let ensemble = self.ensemble;
            ensemble
                .run(&origins, &mut |batch| drive(self, batch))
                .map_err(|error| Failure::Computation(format!("after member {}: {error}", self.ended.members)))?;
        }
        self.ended.interrupted = true;
        Ok(())
    }

    /// `steps` more steps are done.
    fn did(&mut self, steps: u64) {
        self.done += steps;
        let template = "{bar:32} {percent:>3} %  {human_pos}/{human_len} steps, {per_sec}, {eta} left";
        self.bar.set(self.done, self.members.saturating_mul(self.steps()), template);
    }

    /// Those of a member.
    fn steps(&self) -> u64 {
        self.parts.iter().map(|(steps, _)| steps).sum()
    }

    /// `steps` steps of a batch of members, in slices; whether it came to the end of them.
    fn advance(&mut self, batch: &mut dyn Batch<T>, h: T, steps: u64) -> bool {
        let mut left = steps;
        let mut slice = self.slice;
        while left > 0 && batch.going() > 0 {
            if self.interrupt.is_set() {
                return false;
            }
            let (now, clock) = (left.min(slice), Instant::now());
            batch.advance(h, now);
            left -= now;
            self.did(now * batch.going() as u64);
            let time = clock.elapsed();
            if time < SLICE / 2 && now == slice {
                slice *= 2;
            } else if time > SLICE * 2 {
                slice = (slice / 2).max(1);
            }
        }
        self.slice = slice;
        true
    }

    /// One row a member.
    fn states(&mut self, members: Members<'_, T>) -> Result<(), Failure> {
        self.out.header(&self.columns.states());
        self.each(members, |run, batch| {
            let parts = run.parts;
            let whole = parts.into_iter().all(|(steps, h)| run.advance(batch, h, steps));
            batch.samples().iter().for_each(|sample| run.row(sample, whole));
            run.done = run.ended.members.saturating_mul(run.steps());
            run.did(0);
        })?;
        self.out.flush();
        Ok(())
    }

    fn row(&mut self, sample: &Sample<T>, whole: bool) {
        let member = self.count(sample);
        let out = &mut self.out;
        out.text(&member.to_string());
        sample.values.iter().for_each(|value| out.number(*value));
        match sample.work {
            Some((residual, iterations)) => {
                out.number(residual);
                out.text(&iterations.to_string());
            }
            None => ["", ""].into_iter().for_each(|text| out.text(text)),
        }
        match &sample.failure {
            Some(failure) => out.text(failure),
            None if whole => out.text("ok"),
            None => out.text(&format!("interrupted after {}", count(sample.steps, "step"))),
        }
        out.end();
    }

    /// Notes what has become of a member; its number.
    fn count(&mut self, sample: &Sample<T>) -> u64 {
        let ended = &mut self.ended;
        ended.members += 1;
        ended.steps += sample.steps;
        if let Some(failure) = &sample.failure {
            ended.failed += 1;
            let member = ended.members;
            ended.first.get_or_insert_with(|| format!("member {member}, {failure}"));
        }
        ended.members
    }

    /// One row a time.
    fn statistics(&mut self, members: Members<'_, T>) -> Result<(), Failure> {
        let [(whole, _), (rest, _)] = self.parts;
        let rows = times(whole + rest, self.every) as usize;
        let mut table = vec![Statistics::<T>::none(self.columns.dimension + 1 + self.columns.casimirs); rows];
        self.each(members, |run, batch| {
            let mut rows = table.iter_mut();
            let mut look = |batch: &dyn Batch<T>| rows.next().map(|row| row.merge(&batch.statistics()));
            look(batch);
            let (parts, every, mut done) = (run.parts, run.every, 0);
            'parts: for (steps, h) in parts {
                let end = done + steps;
                while done < end {
                    let next = (done + every - done % every).min(end);
                    if !run.advance(batch, h, next - done) {
                        break 'parts;
                    }
                    done = next;
                    if done.is_multiple_of(every) || done == whole + rest {
                        look(batch);
                    }
                }
            }
            for sample in batch.samples() {
                run.count(&sample);
            }
            run.done = run.ended.members.saturating_mul(run.steps());
            run.did(0);
        })?;
        self.table(&table);
        Ok(())
    }

    fn table(&mut self, table: &[Statistics<T>]) {
        let [(whole, h), (_, last)] = self.parts;
        let out = &mut self.out;
        out.header(&self.columns.statistics());
        for (k, row) in table.iter().enumerate() {
            let step = k as u64 * self.every;
            // The end, where it is not a multiple.
            let elapsed = if step <= whole {
                T::int(step as i64) * h
            } else {
                T::int(whole as i64) * h + if self.parts[1].0 > 0 { last } else { T::zero() }
            };
            out.number(elapsed);
            out.text(&row.members.to_string());
            for moments in &row.moments {
                match moments.summary() {
                    Some(values) => values.into_iter().for_each(|value| out.number(value)),
                    None => (0..4).for_each(|_| out.text("")),
                }
            }
            if self.columns.attitude > 0 {
                out.number(row.departure);
            }
            out.end();
        }
        out.flush();
    }
}
