//! A suite of laws as tests: cases drawn, failures shrunk, saved, printed and replayed.
//!
//! [`laws!`](crate::laws!) makes a `#[test]` of each law of a suite. What it does is set by the environment:
//!
//! | variable | meaning |
//! |---|---|
//! | `EULER_POINCARE_CASES` | cases for a cheap law (default 32); a quarter of that for a moderate one, an eighth for others |
//! | `EULER_POINCARE_SEED` | the seed of the cases (default 0); a run with the same seed draws the same cases |
//! | `EULER_POINCARE_REPLAY` | a file: that case alone, for its law; the other laws do nothing |
//!
//! A failing case is saved under `snapshots/regressions/` of the crate, in a folder with the name of the module, and replayed
//! first from then on, until the user deletes it.

use super::algebra::AlgebraLaws;
use super::part::{self, Kind, Part};
use super::system::{self, Own};
use super::values::Values;
use crate::file;
use crate::harness::evidence::{Evidence, gather};
use crate::harness::{About, Campaign, Cost, Failure, Law, Summary, Verdict, hash, verdict_on};
use crate::laws::replay::{evidence_row, indented, records, save_as, verdict_rows};
use crate::scalar::Dd;
use crate::system::given::Supplied;
use crate::system::{Case, Replay};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt::{self, Debug, Display};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Where a suite stands in a user's code: [`laws!`](crate::laws!) fills it in.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Site {
    /// `module_path!()`.
    pub module: &'static str,
    /// `env!("CARGO_MANIFEST_DIR")`.
    pub manifest: &'static str,
}

impl Site {
    /// The module without the crate: what `cargo test` takes.
    fn path(&self) -> &'static str {
        self.module.split_once("::").map_or(self.module, |(_, path)| path)
    }

    fn folder(&self) -> PathBuf {
        Path::new(self.manifest).join("snapshots").join("regressions").join(self.module.replace("::", "-"))
    }
}

/// How a suite runs.
#[derive(Clone, Debug)]
pub struct SuiteSettings {
    /// Cases for a cheap law.
    pub cases: usize,
    /// The seed.
    pub seed: u64,
    /// How many checks the shrinking of a failing case may take.
    pub shrinking: usize,
    /// A saved case, to be replayed alone.
    pub replay: Option<PathBuf>,
    /// Where failing cases are saved, and replayed from; `None`: nowhere.
    pub regressions: Option<PathBuf>,
}

impl SuiteSettings {
    /// 32 cases, seed 0, 300 checks for shrinking; nothing is saved.
    pub fn new() -> Self {
        Self { cases: 32, seed: 0, shrinking: 300, replay: None, regressions: None }
    }

    /// From the environment; failing cases are saved in the crate of the site.
    ///
    /// # Errors
    /// A variable that is no number, as text.
    pub fn from_env(site: &Site) -> Result<Self, String> {
        let number = |name: &str, otherwise: u64| match std::env::var(name) {
            Err(_) => Ok(otherwise),
            Ok(text) => text.trim().parse().map_err(|_| format!("{name}={text}: expected a whole number, 0 or more")),
        };
        let standard = Self::new();
        Ok(Self {
            cases: number("EULER_POINCARE_CASES", standard.cases as u64)? as usize,
            seed: number("EULER_POINCARE_SEED", standard.seed)?,
            replay: std::env::var_os("EULER_POINCARE_REPLAY").map(PathBuf::from),
            regressions: Some(site.folder()),
            ..standard
        })
    }
}

impl Default for SuiteSettings {
    fn default() -> Self {
        Self::new()
    }
}

/// What a law of a suite came to.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It holds.
    Held {
        /// The number of cases.
        cases: usize,
        /// The largest defect relative to its bound.
        worst: f64,
        /// The numbers of inconclusive and of not applicable cases.
        undecided: (usize, usize),
    },
    /// Another law's case is replayed.
    Skipped,
    /// It says nothing about these types.
    Off {
        /// Why.
        why: String,
    },
    /// No case could be decided.
    Undecided {
        /// Why.
        why: String,
    },
    /// It is broken.
    Broken(Box<Broken>),
}

/// A broken law: all that there is to know.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Broken {
    /// The law, and what it says.
    pub about: About,
    /// The verdict on the case.
    pub verdict: Verdict,
    /// What was measured, in each precision.
    pub evidence: Vec<Evidence>,
    /// The case, shrunk, as a few lines.
    pub case: String,
    /// Where the case comes from.
    pub origin: String,
    /// The file that it was saved in, and how to replay it; the reason if it could not be saved.
    pub replay: String,
}

impl Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let About { name, statement, source, oracle, .. } = self.about;
        writeln!(f, "the law `{name}` is broken: {statement}")?;
        let mut rows = vec![("source", source.to_owned()), ("oracle", oracle.to_owned())];
        rows.extend(self.evidence.iter().map(evidence_row));
        rows.extend(verdict_rows(&self.verdict));
        rows.push(("case", self.origin.clone()));
        for (name, text) in rows {
            writeln!(f, "  {name:<11}{text}")?;
        }
        writeln!(f, "{}", indented(&indented(&self.case)))?;
        writeln!(f, "  {:<11}{}", "replay", self.replay)
    }
}

/// Runs a law on its cases, whatever their type.
type Run = Box<dyn Fn(&Site, &SuiteSettings) -> Outcome + Send + Sync>;

/// How a case prints.
type Show<C> = Box<dyn Fn(&C) -> String + Send + Sync>;

struct Entry<C> {
    law: Box<dyn Law<C>>,
    show: Show<C>,
}

impl<C: Clone + Debug + Send + Serialize + DeserializeOwned + 'static> Entry<C> {
    /// All about a case on which the law is broken; none if it is not.
    fn judge(&self, case: &C, origin: String, replay: impl FnOnce() -> String) -> Result<Verdict, Box<Broken>> {
        let verdict = verdict_on(&*self.law, case, None);
        if !verdict.is_broken() {
            return Ok(verdict);
        }
        let (_, evidence) = gather(|| verdict_on(&*self.law, case, None));
        Err(Box::new(Broken {
            about: *self.law.about(),
            verdict,
            evidence,
            case: (self.show)(case),
            origin,
            replay: replay(),
        }))
    }

    fn command(&self, site: &Site, path: &Path) -> String {
        let path = path.strip_prefix(site.manifest).unwrap_or(path).display();
        format!("EULER_POINCARE_REPLAY={path} cargo test {}::{}", site.path(), self.law.name().replace('-', "_"))
    }

    fn save(&self, folder: &Path, record: &Replay<C>) -> Result<PathBuf, String> {
        let case = serde_json::to_string(&record.case).map_err(|e| e.to_string())?;
        let name = format!("{}-{:08x}.json", self.law.name(), hash(case.bytes()) >> 32);
        save_as(folder, &name, record).map_err(|e| format!("{}: {e}", folder.join(name).display()))
    }

    /// The saved cases of this law, by name of the file.
    fn saved(&self, folder: &Path) -> Vec<PathBuf> {
        let of_law = |path: &PathBuf| {
            let stem = path.file_stem().and_then(|stem| stem.to_str()?.rsplit_once('-'));
            stem.is_some_and(|(law, hash)| law == self.law.name() && hash.len() == 8)
        };
        records(folder).unwrap_or_default().into_iter().filter(of_law).collect()
    }

    fn again(&self, site: &Site, path: &Path) -> Result<Verdict, Box<Broken>> {
        let origin = format!("as saved in {}", path.display());
        let read = || {
            let text = file::read(path, file::LONGEST).map_err(|e| e.to_string())?;
            Replay::<C>::parse(&text)
        };
        match read() {
            Ok(record) => self.judge(&record.case, origin, || self.command(site, path)),
            Err(why) => Err(Box::new(Broken {
                about: *self.law.about(),
                verdict: Verdict::broken(format!("{} is no case of this law: {why}", path.display())),
                evidence: Vec::new(),
                case: String::new(),
                origin,
                replay: "correct the file, or delete it".into(),
            })),
        }
    }

    fn random(&self, site: &Site, settings: &SuiteSettings) -> Outcome {
        let campaign = Campaign::new(settings.seed, settings.cases).share(share).shrinking(1, settings.shrinking);
        let laws = campaign.run(&[&*self.law]).laws;
        // The report has one summary for each law.
        let mut found = laws.into_iter().next().unwrap_or_else(|| Summary::new(self.law.name()));
        let line = found.line();
        match found.failures.pop() {
            Some(failure) => self.broken(site, settings, failure),
            None if line.broken > 0 => Outcome::Undecided { why: AT_ODDS.into() },
            None if line.held > 0 => Outcome::Held {
                cases: line.held,
                worst: found.worst.map_or(0.0, |worst| worst.ratio()),
                undecided: (line.inconclusive, line.not_applicable),
            },
            None if line.inconclusive > 0 => Outcome::Undecided { why: most_frequent(found.inconclusive) },
            None => Outcome::Off { why: most_frequent(found.not_applicable) },
        }
    }

    fn broken(&self, site: &Site, settings: &SuiteSettings, failure: Failure<C>) -> Outcome {
        let Failure { seed, index, case, checks, .. } = failure;
        let origin = format!("number {index} of seed {seed}, shrunk with {checks} checks");
        let (module, law, index) = (Some(site.module.into()), self.law.name().into(), index as u64);
        let record = Replay { module, law, seed, index, fault: None, case };
        let replay = || match &settings.regressions {
            None => "not saved".into(),
            Some(folder) => match self.save(folder, &record) {
                Ok(path) => format!("{}\n           (saved; replayed first from now on)", self.command(site, &path)),
                Err(why) => format!("could not be saved: {why}"),
            },
        };
        match self.judge(&record.case, origin, replay) {
            Err(broken) => Outcome::Broken(broken),
            Ok(_) => Outcome::Undecided { why: AT_ODDS.into() },
        }
    }

    fn run(&self, site: &Site, settings: &SuiteSettings) -> Outcome {
        if let Some(path) = &settings.replay {
            return match whose(path) {
                Ok((module, law)) if module != site.module || law != self.law.name() => Outcome::Skipped,
                _ => self.again(site, path).map_or_else(Outcome::Broken, held),
            };
        }
        for path in settings.regressions.iter().flat_map(|folder| self.saved(folder)) {
            if let Err(broken) = self.again(site, &path) {
                return Outcome::Broken(broken);
            }
        }
        self.random(site, settings)
    }
}

/// A check that is not a function of the case.
const AT_ODDS: &str = "broken once, and not when it was checked again";

/// The cases of a law of a cost, where a cheap one has so many.
fn share(cost: Cost, cases: usize) -> usize {
    match cost {
        Cost::Cheap => cases,
        Cost::Moderate => cases.div_ceil(4),
        Cost::Expensive | Cost::Heavy => cases.div_ceil(8),
    }
}

fn most_frequent(reasons: BTreeMap<String, usize>) -> String {
    reasons.into_iter().max_by_key(|(_, count)| *count).map(|(why, _)| why).unwrap_or_default()
}

/// The outcome of a replayed case on which the law is not broken.
fn held(verdict: Verdict) -> Outcome {
    match verdict {
        Verdict::NotApplicable { why } => Outcome::Off { why },
        Verdict::Inconclusive { why } => Outcome::Undecided { why },
        verdict => Outcome::Held { cases: 1, worst: verdict.ratio().unwrap_or(0.0), undecided: (0, 0) },
    }
}

/// The module and the law of a saved case.
fn whose(path: &Path) -> Result<(String, String), String> {
    let text = file::read(path, file::LONGEST).map_err(|e| e.to_string())?;
    let record = Replay::<serde_json::Value>::parse(&text)?;
    let again = || format!("`verify` saved it: run it again with `euler-poincare replay {}`", path.display());
    Ok((record.module.ok_or_else(again)?, record.law))
}

/// Laws on a user's own types, by name.
pub struct Suite {
    site: Site,
    laws: Vec<(&'static str, Run)>,
    /// Why there are no laws of systems.
    refused: Option<String>,
}

impl Suite {
    /// No laws yet.
    pub fn new(site: Site) -> Self {
        Self { site, laws: Vec::new(), refused: None }
    }

    fn with<C>(
        mut self,
        laws: Vec<Box<dyn Law<C>>>,
        show: impl Fn(&C) -> String + Clone + Send + Sync + 'static,
    ) -> Self
    where
        C: Clone + Debug + Send + Serialize + DeserializeOwned + 'static,
    {
        let entry = |law: Box<dyn Law<C>>| -> (&'static str, Run) {
            let (name, entry) = (law.name(), Entry { law, show: Box::new(show.clone()) });
            (name, Box::new(move |site, settings| entry.run(site, settings)))
        };
        self.laws.extend(laws.into_iter().map(entry));
        self
    }

    /// Adds the laws of a single part.
    pub fn part<K: Kind>(self, part: Part<K>) -> Self {
        self.on_parts(part::laws(part).into_iter().map(|law| Box::new(law) as _).collect())
    }

    /// Generic over nothing, so that it is compiled here.
    fn on_parts(self, laws: Vec<Box<dyn Law<Values>>>) -> Self {
        self.with(laws, Values::to_string)
    }

    /// Likewise.
    fn on_systems(self, laws: Result<Vec<Box<dyn Law<Case>>>, String>, own: [bool; 3]) -> Self {
        match laws {
            Ok(laws) => self.with(laws, move |case| shown(case, own)),
            Err(why) => Self { refused: Some(why), ..self },
        }
    }

    /// The laws on a user's own types, as two functions make them: those of the parts, of a one-step method and of systems.
    #[doc(hidden)]
    pub fn of<const N: usize, const D: usize>(
        site: Site,
        double: fn() -> Own<f64, N, D>,
        quad: fn() -> Own<Dd, N, D>,
    ) -> Self {
        let (one, two) = (double(), quad());
        let Supplied { retraction, lagrangian, force, .. } = &one.supplied;
        let own = [retraction.is_some(), lagrangian.is_some(), force.is_some()];
        let mut suite = Self::new(site)
            .part(Part::of(one.group, Some(two.group)))
            .part(Part::<AlgebraLaws<N>>::at_both(one.algebra, two.algebra));
        if let Some(lagrangian) = one.lagrangian {
            suite = suite.part(Part::of(lagrangian, two.lagrangian));
        }
        if let Some(force) = one.force {
            suite = suite.part(Part::of(force, two.force));
        }
        suite.on_systems(system::laws((double, quad)), own)
    }

    /// The names of the laws, in order.
    pub fn names(&self) -> Vec<&'static str> {
        self.laws.iter().map(|(name, _)| *name).collect()
    }

    /// Runs the law called `name`; [`Outcome::Undecided`] where there is none.
    pub fn run(&self, name: &str, settings: &SuiteSettings) -> Outcome {
        // Nothing else reports a case to be replayed whose law is none of these.
        if let Some(Ok((module, law))) = settings.replay.as_deref().map(whose)
            && module == self.site.module
            && !self.names().contains(&law.as_str())
        {
            return Outcome::Undecided { why: self.none(&law) };
        }
        match self.laws.iter().find(|(known, _)| *known == name) {
            Some((_, run)) => run(&self.site, settings),
            None => Outcome::Undecided { why: self.none(name) },
        }
    }

    /// Why there is no such law.
    fn none(&self, name: &str) -> String {
        self.refused.clone().unwrap_or_else(|| format!("there is no law called `{name}` on these types"))
    }

    /// Runs the law whose name has `_` for `-` and panics unless it holds; says, past what the test runner captures, when
    /// it is off.
    ///
    /// # Panics
    /// The law is broken or could not be decided; a variable of the environment is no number.
    pub fn test(&self, name: &str) {
        let name = name.replace('_', "-");
        let settings = SuiteSettings::from_env(&self.site).unwrap_or_else(|why| panic!("{why}"));
        self.report(&name, self.run(&name, &settings));
    }

    fn report(&self, name: &str, outcome: Outcome) {
        match outcome {
            Outcome::Skipped => {}
            Outcome::Held { cases, worst, undecided: (inconclusive, off) } => {
                println!("{name}: holds on {cases} cases, worst defect {worst:.2e} of its bound");
                if inconclusive + off > 0 {
                    println!("{name}: {inconclusive} inconclusive, {off} not applicable");
                }
            }
            Outcome::Off { why } => {
                // Not by eprintln, which the test runner captures: the user would not see it.
                let _ = writeln!(std::io::stderr(), "{}: the law `{name}` is off: {why}", self.site.path());
            }
            Outcome::Undecided { why } => panic!("the law `{name}` could not be decided: {why}"),
            Outcome::Broken(broken) => panic!("{broken}"),
        }
    }
}

/// A case on one's own types as a few lines: what is one's own says so.
fn shown(case: &Case, [retraction, lagrangian, force]: [bool; 3]) -> String {
    let line = |line: &str| {
        let key = line.split_whitespace().next().unwrap_or("");
        match key {
            "lagrangian" if lagrangian => "lagrangian yours".into(),
            "force" if force => line.replace("given", "yours"),
            "algebra" => line.replace("given", "yours"),
            "method" if retraction => match line.rsplit_once(',') {
                Some((tableau, _)) => format!("{tableau}, your retraction"),
                None => line.into(),
            },
            _ => line.to_string(),
        }
    };
    case.to_string().lines().map(line).collect::<Vec<String>>().join("\n")
}
