//! Methods made of a program.

use super::program::{Limits, Program, Silence};
use super::protocol::{Described, Reply, parse_beside, parse_stages};
use super::supports::{self, Supports};
use crate::integrators::StepError;
use crate::laws::method::{MethodSource, Point, Stage, StateForm, Stepper};
use crate::system::{Case, CaseError};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The states of the systems that are asked about are of size 10⁻² to 10³: beyond this a run has diverged.
const BLOWN_UP: f64 = 1e6;

/// A program that takes steps, to be asked on any described system.
#[derive(Clone)]
pub struct External {
    program: Arc<Mutex<Program>>,
    supports: Arc<OnceLock<Supports>>,
}

/// Why a request says nothing: with its answer the program told what it supports.
const TELLS: &str = "the stepper tells what it supports: the system is to be drawn again";

/// An answer as it was read: its stages are looked at on request.
type Answer = Vec<u8>;

/// Why a step back is not asked for.
const FORWARD: &str = "not asked: the stepper says that it takes positive steps only";

impl From<Program> for External {
    fn from(program: Program) -> Self {
        Self { program: Arc::new(Mutex::new(program)), supports: Arc::default() }
    }
}

impl External {
    /// The program and its arguments; it is started when it is first asked.
    pub fn new(command: &[String], limits: Limits) -> Self {
        Program::new(command, limits).into()
    }

    /// What the program says that it supports; `None` as long as it has said nothing.
    pub fn supports(&self) -> Option<&Supports> {
        self.supports.get()
    }

    /// What its state is.
    pub fn state(&self) -> StateForm {
        self.supports().map(|supports| supports.state.clone()).unwrap_or_default()
    }

    /// A case in the numbers of its requests.
    ///
    /// # Errors
    /// A case that cannot be built.
    pub(super) fn described(&self, case: &Case) -> Result<Described, CaseError> {
        Ok(Described::of(case)?.with_state(&self.state()))
    }

    /// Whether the run was interrupted.
    pub(super) fn is_interrupted(&self) -> bool {
        self.program().is_interrupted()
    }

    /// Whether the program is asked nothing more: the run was interrupted, or it failed too often.
    pub(super) fn has_ended(&self) -> bool {
        let program = self.program();
        program.is_interrupted() || program.is_given_up()
    }

    /// The program, for this thread alone.
    pub(super) fn program(&self) -> MutexGuard<'_, Program> {
        self.program.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the program, where it is not running.
    ///
    /// # Errors
    /// [`Silence::NotStarted`].
    pub fn start(&self) -> Result<(), Silence> {
        self.program().start()
    }

    /// One request and what came of it, with the answer itself.
    ///
    /// # Errors
    /// [`StepError::Unsupported`], [`StepError::Refused`] and [`StepError::NoAnswer`], as the program answers.
    fn ask(
        &self,
        system: &Described,
        point: &Point<f64>,
        h: f64,
        usual: f64,
    ) -> Result<(Point<f64>, Answer), StepError> {
        let mut program = self.program();
        let silent = |silence: Silence| match silence {
            Silence::GivenUp { .. } | Silence::Interrupted => StepError::Refused { step: h, why: silence.to_string() },
            _ => StepError::NoAnswer { why: silence.to_string() },
        };
        let request = system.request(point, h);
        let mut line = program.ask(&request).map_err(silent)?;
        match supports::said(&line) {
            Err(why) => {
                program.failed(&why);
                return Err(StepError::NoAnswer { why });
            }
            Ok(Some((supports, _))) if self.supports.get().is_none() => {
                // This thread holds the program: no other can have set it.
                let _ = self.supports.set(supports);
                return Err(StepError::Unsupported { why: TELLS.into() });
            }
            // It was started again, and tells it once more.
            Ok(Some((_, true))) => line = program.ask(&request).map_err(silent)?,
            Ok(_) => {}
        }
        match parse_beside(&line, point.momentum.len(), (system.key(), point.attitude.len())) {
            Ok(Reply::State { mu, g }) => Ok((Point { time: point.time + h, momentum: mu, attitude: g }, line)),
            Ok(Reply::Unsupported(why)) => Err(StepError::Unsupported { why }),
            Ok(Reply::Error(why)) => Err(StepError::Refused { step: h, why }),
            // With a step larger than that of the system, or at a state that has diverged, infinity is a right answer.
            Err(_) if (h.abs() > usual || is_blown_up(point)) && not_finite(&line) => {
                let why = "the method diverges with this step".into();
                Err(StepError::Refused { step: h, why })
            }
            Err(why) => {
                program.failed(&why);
                Err(StepError::NoAnswer { why })
            }
        }
    }

    /// The program as a method on a described system, whatever its dimension.
    ///
    /// # Errors
    /// A case that cannot be built.
    pub fn on(&self, case: &Case) -> Result<impl Stepper<f64> + use<>, CaseError> {
        let usual = case.step.eval::<f64>().map_or(f64::INFINITY, f64::abs);
        Ok(Steps { external: self.clone(), system: self.described(case)?, usual, answer: Answer::new() })
    }
}

/// Whether a state is far beyond those of any system that is asked about.
fn is_blown_up(point: &Point<f64>) -> bool {
    point.momentum.iter().chain(&point.attitude).any(|x| x.abs() > BLOWN_UP)
}

/// Whether a line holds a number that is not finite, as programs write it.
fn not_finite(line: &[u8]) -> bool {
    let line = String::from_utf8_lossy(line).to_ascii_lowercase();
    ["nan", "inf", "null"].iter().any(|word| line.contains(word))
}

impl MethodSource for External {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        if let Some(key) = self.supports().and_then(|supports| supports.excludes(case)) {
            let why = format!("not asked: the stepper does not support such a system (\"{key}\")");
            return Err(StepError::Unsupported { why });
        }
        match self.on(case) {
            Ok(steps) => Ok(Box::new(steps)),
            Err(error) => Err(StepError::Unsupported { why: error.to_string() }),
        }
    }

    fn form(&self) -> StateForm {
        self.state()
    }

    fn knows(&self, case: &Case) -> bool {
        self.supports().is_none_or(|supports| supports.admits(case))
    }

    fn adapted(&self, case: Case) -> Option<Case> {
        match self.supports() {
            Some(supports) => supports.adapted(case),
            None => Some(case),
        }
    }
}

struct Steps {
    external: External,
    system: Described,
    /// |h| of the system.
    usual: f64,
    /// Of the last step; empty before the first.
    answer: Answer,
}

impl Stepper<f64> for Steps {
    fn step(&mut self, point: &Point<f64>, h: f64) -> Result<Point<f64>, StepError> {
        if h < 0.0 && self.external.supports().is_some_and(|supports| supports.positive_steps) {
            return Err(StepError::Unsupported { why: FORWARD.into() });
        }
        let (next, answer) = self.external.ask(&self.system, point, h, self.usual)?;
        self.answer = answer;
        Ok(next)
    }

    /// Stages that are none are a failure of the program.
    fn stages(&self, start: &Point<f64>, _: f64) -> Option<Vec<Stage<f64>>> {
        // Of a point that stands beside the momentum there are no attitudes.
        if self.system.key() != "g" || start.attitude.is_empty() {
            return None;
        }
        parse_stages(&self.answer, start.momentum.len(), start.attitude.len()).unwrap_or_else(|why| {
            self.external.program().failed(&why);
            None
        })
    }
}
