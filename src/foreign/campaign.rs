//! The laws of methods on a program: case after case, the first broken one of each law shrunk.

use super::program::Exchange;
use super::stepper::Foreign;
use crate::harness::convergence::Estimate;
use crate::harness::{BoxedStrategy, Verdict, draw};
use crate::laws::method::{Claims, MethodLaw, Point, Stepper, check_case, theory_of};
use crate::scalar::{Dd, Scalar};
use crate::system::{Case, CaseError, Cases, Place, Problem};
use proptest::strategy::{Strategy, ValueTree};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Which systems.
#[non_exhaustive]
pub enum Drawn {
    /// One.
    This(Box<Case>),
    /// Random ones of these, so many for each law, from a seed.
    Random {
        /// What they may be.
        of: Box<Cases>,
        /// How many for each law.
        cases: usize,
        /// The seed.
        seed: u64,
    },
}

/// A campaign on a program.
///
/// ```no_run
/// use euler_poincare::foreign::{
///     Broken, Described, Drawn, Exchange, Foreign, LawReport, Limits, Probe, Program, Record, Reply, Report, Silence, parse,
/// };
/// use euler_poincare::laws::method::{Claims, LAWS, Point};
/// use euler_poincare::study::problem;
/// use euler_poincare::system::cases;
///
/// let command = ["python3".to_owned(), "stepper.py".to_owned()];
/// let foreign = Foreign::new(&command, Limits::default());
/// let probe = Probe {
///     foreign: &foreign,
///     laws: &LAWS.iter().collect::<Vec<_>>(),
///     systems: Drawn::Random { of: Box::new(cases()), cases: 20, seed: 1 },
///     claims: Claims { order: Some(4), ..Claims::default() },
///     shrink_checks: 200,
/// };
/// let report: Report = probe.run(|_, _| {});
/// for law in &report.laws {
///     let LawReport { law, held, failure, .. } = law;
///     println!("{}: held on {held} cases", law.name);
///     if let Some(Broken { index, case, verdict, exchanges, .. }) = failure {
///         println!("{verdict}");
///         let record = Record {
///             law: law.name.into(),
///             command: command.to_vec(),
///             timeout: 10.0,
///             claims: probe.claims,
///             seed: 1,
///             index: *index as u64,
///             case: case.clone(),
///             exchanges: exchanges.clone(),
///         };
///         std::fs::write("failing.json", record.to_json()?)?;
///     }
/// }
///
/// // One exchange by hand.
/// let case = problem::generic()?.case;
/// let system = Described::of(&case)?;
/// let start = Point { time: 0.0, momentum: vec![0.4, 0.1, 0.7], attitude: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] };
/// let mut program = Program::new(&command, Limits::default());
/// match program.ask(&system.request(&start, 0.125)) {
///     Ok(line) => match parse(&line, 3, 9)? {
///         Reply::State { mu, g } => println!("{mu:?} {g:?}"),
///         refusal => println!("{refusal:?}"),
///     },
///     Err(Silence::Hung { seconds, .. }) => println!("no answer after {seconds} s"),
///     Err(other) => println!("{other}"),
/// }
/// let last: Option<&Exchange> = program.exchanges().last();
/// # let _ = last;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Probe<'a> {
    /// The program.
    pub foreign: &'a Foreign,
    /// Which laws.
    pub laws: &'a [&'static MethodLaw],
    /// On which systems.
    pub systems: Drawn,
    /// What is claimed of the method.
    pub claims: Claims,
    /// How many checks a broken case is shrunk with.
    pub shrink_checks: usize,
}

/// A broken case.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Broken {
    /// Its index, before it was shrunk.
    pub index: usize,
    /// The simplest case found that is broken.
    pub case: Case,
    /// The verdict on it.
    pub verdict: Verdict,
    /// How many checks were spent on shrinking.
    pub checks: usize,
    /// Whether the program failed: it hung, died, flooded, or answered with something else than a state.
    pub failed: bool,
    /// The request that did it, where the program failed; else one step from the start of the case.
    pub exchanges: Vec<Exchange>,
    /// The solution after that step, where the program did not fail: (μ, g).
    pub solution: Option<(Vec<f64>, Vec<f64>)>,
}

/// What was found about one law.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LawReport {
    /// The law.
    pub law: &'static MethodLaw,
    /// Cases asked.
    pub cases: usize,
    /// On which it holds.
    pub held: usize,
    /// The indices of those on which it is broken.
    pub broken: Vec<usize>,
    /// Those that could not be decided, by reason.
    pub inconclusive: BTreeMap<String, usize>,
    /// Those about which it says nothing, by reason.
    pub not_applicable: BTreeMap<String, usize>,
    /// The largest defect against its bound.
    pub worst: Option<(f64, f64)>,
    /// The slopes measured, less what local errors have in excess.
    pub slopes: Vec<f64>,
    /// The first broken case, shrunk.
    pub failure: Option<Broken>,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// One for each law.
    pub laws: Vec<LawReport>,
    /// How often the program failed.
    pub failures: usize,
    /// Whether it was given up before the end.
    pub given_up: bool,
}

impl Report {
    /// Whether a law is broken.
    pub fn is_broken(&self) -> bool {
        self.laws.iter().any(|law| !law.broken.is_empty())
    }

    /// Whether any law holds on any case.
    pub fn holds_anywhere(&self) -> bool {
        self.laws.iter().any(|law| law.held > 0)
    }
}

impl LawReport {
    fn new(law: &'static MethodLaw) -> Self {
        Self {
            law,
            cases: 0,
            held: 0,
            broken: Vec::new(),
            inconclusive: BTreeMap::new(),
            not_applicable: BTreeMap::new(),
            worst: None,
            slopes: Vec::new(),
            failure: None,
        }
    }

    fn record(&mut self, index: usize, verdict: &Verdict) {
        self.cases += 1;
        match verdict {
            Verdict::Holds { .. } => self.held += 1,
            Verdict::Broken { .. } => self.broken.push(index),
            Verdict::Inconclusive { why } => *self.inconclusive.entry(why.clone()).or_default() += 1,
            Verdict::NotApplicable { why } => *self.not_applicable.entry(why.clone()).or_default() += 1,
        }
        if let Some((defect, bound)) = verdict.measured()
            && self.worst.is_none_or(|(d, b)| verdict.ratio() > Verdict::Holds { defect: d, bound: b }.ratio())
        {
            self.worst = Some((defect, bound));
        }
    }
}

impl Probe<'_> {
    /// How many checks there will be, shrinking apart.
    pub fn checks(&self) -> usize {
        match &self.systems {
            Drawn::This(_) => self.laws.len(),
            Drawn::Random { cases, .. } => self.laws.len() * cases,
        }
    }

    /// Runs it; `progress` is told the law and the verdict after each case.
    pub fn run(&self, mut progress: impl FnMut(&'static str, &Verdict)) -> Report {
        let mut laws = Vec::new();
        for law in self.laws {
            let mut report = LawReport::new(law);
            let cases = match &self.systems {
                Drawn::This(_) => 1,
                Drawn::Random { cases, .. } => *cases,
            };
            let strategy = self.strategy(law);
            for index in 0..cases {
                if self.foreign.is_given_up() {
                    break;
                }
                self.case(&mut report, strategy.as_ref(), index, &mut progress);
            }
            laws.push(report);
        }
        Report { laws, failures: self.foreign.failures(), given_up: self.foreign.is_given_up() }
    }

    fn strategy(&self, law: &MethodLaw) -> Option<BoxedStrategy<Case>> {
        match &self.systems {
            Drawn::This(_) => None,
            Drawn::Random { of, .. } => Some(law.cases((**of).clone()).boxed()),
        }
    }

    /// The verdict, the slope, and whether the program failed.
    fn judge(&self, law: &MethodLaw, case: &Case) -> (Verdict, Option<f64>, bool) {
        self.foreign.forget();
        let before = self.foreign.failures();
        let outcome = check_case(law, self.foreign, case, &self.claims);
        let slope = outcome.slope.as_ref().and_then(Estimate::slope);
        (outcome.verdict, slope, self.foreign.failures() > before)
    }

    fn case(
        &self,
        report: &mut LawReport,
        strategy: Option<&BoxedStrategy<Case>>,
        index: usize,
        progress: &mut impl FnMut(&'static str, &Verdict),
    ) {
        let law = report.law;
        let (case, tree) = match (&self.systems, strategy) {
            (Drawn::Random { seed, .. }, Some(strategy)) => match draw(strategy, *seed, law.name, index).case {
                Ok((case, tree)) => (case, Some(tree)),
                Err(why) => return report.record(index, &Verdict::Inconclusive { why }),
            },
            (Drawn::This(case), _) => ((**case).clone(), None),
            (Drawn::Random { .. }, None) => return,
        };
        let (verdict, slope, failed) = self.judge(law, &case);
        report.slopes.extend(slope);
        report.record(index, &verdict);
        progress(law.name, &verdict);
        if !verdict.is_broken() || report.failure.is_some() {
            return;
        }
        let exchanges = self.foreign.exchanges();
        let mut broken = Broken { index, case, verdict, checks: 0, failed, exchanges, solution: None };
        // Who hangs on one case hangs on its simpler ones, a time limit each.
        if !failed && let Some(mut tree) = tree {
            self.shrink(law, &mut *tree, &mut broken);
        }
        self.explain(&mut broken);
        report.failure = Some(broken);
    }

    fn shrink(&self, law: &MethodLaw, tree: &mut dyn ValueTree<Value = Case>, best: &mut Broken) {
        let mut moved = tree.simplify();
        while moved && best.checks < self.shrink_checks && !self.foreign.is_given_up() {
            let case = tree.current();
            let (verdict, _, failed) = self.judge(law, &case);
            best.checks += 1;
            let broken = verdict.is_broken() && !failed;
            if broken {
                (best.case, best.verdict) = (case, verdict);
            }
            moved = if broken { tree.simplify() } else { tree.complicate() };
        }
    }

    /// What a person needs to debug it: the request that did it, or one step with the solution beside it.
    fn explain(&self, broken: &mut Broken) {
        if broken.failed {
            broken.exchanges = broken.exchanges.pop().into_iter().collect();
            return;
        }
        self.foreign.forget();
        let Ok(theory) = theory_of::<Dd>(&broken.case) else { return };
        let (start, h) = (theory.start().convert::<f64>(), theory.step());
        if let Ok(mut stepper) = self.foreign.on(&broken.case) {
            let _ = stepper.step(&start, h.to_f64());
        }
        broken.exchanges = self.foreign.exchanges();
        let solved = theory.solution(&[h], 8).ok().and_then(|mut list| list.pop());
        broken.solution = solved.map(|(point, _)| {
            let Point { momentum, attitude, .. } = point.convert::<f64>();
            (momentum, attitude)
        });
    }
}

/// A broken case on file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Name of the law.
    pub law: String,
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Its time limit for an answer, in seconds.
    pub timeout: f64,
    /// What was claimed of it.
    #[serde(default)]
    pub claims: Claims,
    /// Seed of the campaign.
    #[serde(default)]
    pub seed: u64,
    /// Index of the case in it, before it was shrunk.
    #[serde(default)]
    pub index: u64,
    /// The case, shrunk.
    pub case: Case,
    /// A request and its answer, for the reader.
    #[serde(default)]
    pub exchanges: Vec<Exchange>,
}

impl Record {
    /// The record as indented JSON.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_json(&self) -> Result<String, CaseError> {
        serde_json::to_string_pretty(self).map_err(|error| Place::root().error(Problem::Part(error.to_string())))
    }

    /// The record in a JSON text; the case is built once to check it.
    ///
    /// # Errors
    /// Malformed JSON (with line and column), unknown keys, or a case that cannot be built.
    pub fn from_json(text: &str) -> Result<Self, CaseError> {
        let part = |error: String| Place::root().error(Problem::Part(error));
        let record: Self = serde_json::from_str(text).map_err(|error| part(error.to_string()))?;
        if !(record.timeout > 0.0 && record.timeout <= 86400.0) || record.command.is_empty() {
            return Err(part("a record has a command, and a time limit from 0 to 86400 s".into()));
        }
        record.case.check()?;
        Ok(record)
    }
}
