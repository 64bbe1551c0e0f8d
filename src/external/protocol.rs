//! The lines of the protocol: what is asked, and how an answer is read.

use super::program::shown;
use crate::laws::method::{Point, Stage, StateForm};
use crate::mechanics::Lagrangian;
use crate::scalar::Number;
use crate::system::case::{Case, Dictionary, Drag, Force, Inertia, Monomial, Parameter, Potential};
use crate::system::force::{self, MATRIX};
use crate::system::{CaseError, System, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The version of the protocol.
pub const VERSION: u32 = 1;

/// The version of a request with `gyrostat` or `metric`: a program that ignored these keys would solve another system.
pub const LAGRANGIAN_VERSION: u32 = 2;

/// The version of a request on a system that depends on the configuration, or has formulas.
pub const CONFIGURATION_VERSION: u32 = 3;

/// One term of the force or of the potential, in numbers: its kind and its parameters.
#[derive(Clone, Debug, PartialEq)]
struct Term {
    kind: &'static str,
    parameters: Vec<(&'static str, Entry)>,
}

/// A parameter; a matrix is a list of n² numbers by rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
enum Entry {
    Number(f64),
    List(Vec<f64>),
    Text(String),
    Polynomial(Vec<(usize, f64, usize, usize, Vec<usize>)>),
}

impl Serialize for Term {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1 + self.parameters.len()))?;
        map.serialize_entry("kind", self.kind)?;
        for (key, entry) in &self.parameters {
            map.serialize_entry(key, entry)?;
        }
        map.end()
    }
}

/// A system in the numbers of the protocol: what the requests on it have in common.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Described {
    version: u32,
    dimension: usize,
    /// C^c_ab at (a n + b) n + c.
    constants: Vec<f64>,
    /// m; 0 without a group.
    size: usize,
    /// ê_a, n·m·m numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    basis: Vec<f64>,
    inertia: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quartic: Option<f64>,
    /// K, where it is not I.
    #[serde(skip_serializing_if = "Option::is_none")]
    metric: Option<Vec<f64>>,
    /// b.
    #[serde(skip_serializing_if = "Option::is_none")]
    gyrostat: Option<Vec<f64>>,
    /// A formula for the Lagrangian, of which inertia and metric say nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    lagrangian: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    potential: Vec<Term>,
    force: Vec<Term>,
    /// What formulas may name: parameters, and formulas with names.
    #[serde(skip_serializing_if = "Option::is_none")]
    names: Option<Names>,
    /// Whether the state has a point instead of the attitude.
    #[serde(skip)]
    point: bool,
}

/// What formulas may name.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Names {
    parameters: BTreeMap<String, Entry>,
    definitions: BTreeMap<String, String>,
}

#[derive(Serialize)]
struct Request<'a> {
    #[serde(flatten)]
    system: &'a Described,
    time: f64,
    step: f64,
    mu: &'a [f64],
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    g: &'a [f64],
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    x: &'a [f64],
}

/// Constants, matrices of the basis and inertia.
struct Numbers(usize);

impl Visitor<f64> for Numbers {
    type Output = [Vec<f64>; 3];

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Self::Output {
        let (n, m) = (system.dimension, self.0);
        let constant = |k: usize| system.algebra.constant(k / (n * n), k / n % n, k % n);
        let basis = system.group.iter().flat_map(|group| group.basis().iter().take(n));
        let basis = basis.flat_map(|matrix| (0..m * m).map(|k| matrix[(k / m, k % m)])).collect();
        // At rest the Hessian is the inertia, with a quartic term or without.
        let inertia = system.lagrangian.hessian(&crate::algebra::Vector::<f64, N>::zeros());
        let inertia = (0..n * n).map(|k| inertia[(k / n, k % n)]).collect();
        [(0..n * n * n).map(constant).collect(), basis, inertia]
    }
}

impl Described {
    /// The description of a case.
    ///
    /// # Errors
    /// A case that cannot be built.
    pub fn of(case: &Case) -> Result<Self, CaseError> {
        let (n, size) = (case.dimension(), case.matrix_size());
        let [constants, basis, inertia] = case.dispatch::<f64, _>(Numbers(size))?;
        // A case that can be built has finite numbers.
        let number = |x: &Number| x.eval::<f64>().unwrap_or(f64::NAN);
        let list = |list: &[Number]| list.iter().map(number).collect::<Vec<f64>>();
        let matrix = |drag: &Drag| match drag {
            Drag::Coefficient(k) => (0..n * n).map(|e| if e / n == e % n { number(k) } else { 0.0 }).collect(),
            Drag::Matrix(rows) => rows.iter().flatten().map(number).collect(),
        };
        let form = |form: &Inertia| {
            let n = form.dimension();
            (0..n * n).map(|e| number(&form.entry(e / n, e % n))).collect::<Vec<f64>>()
        };
        let plain = case.lagrangian.metric.is_none() && case.lagrangian.gyrostat.is_none();
        let entry = |(&force::Parameter { name, .. }, value): (&'static force::Parameter, force::Value)| match value {
            force::Value::Number(x) => (name, Entry::Number(number(&x))),
            force::Value::List(x) => (name, Entry::List(list(&x))),
            force::Value::Form(x) => (name, Entry::List(form(&x))),
            force::Value::Formula(text) => (name, Entry::Text(text)),
            force::Value::Drag(drag) => (MATRIX, Entry::List(matrix(&drag))),
            force::Value::Polynomial(terms) => {
                // A case that can be built has indices from 1.
                let below = |index: &usize| index.saturating_sub(1);
                let row = |x: &Monomial| {
                    let factors = x.factors.iter().map(below).collect();
                    (below(&x.component), number(&x.value), x.cos, x.sin, factors)
                };
                (name, Entry::Polynomial(terms.iter().map(row).collect()))
            }
        };
        let term = |force: &Force| Term { kind: force.kind(), parameters: force.parameters().map(entry).collect() };
        let potential = |potential: &Potential| Term {
            kind: potential.kind(),
            parameters: potential.parameters().map(entry).collect(),
        };
        let parameter = |(name, value): (&String, &Parameter)| match value {
            Parameter::Number(x) => (name.clone(), Entry::Number(number(x))),
            Parameter::Vector(x) => (name.clone(), Entry::List(list(x))),
        };
        let names = || Names {
            parameters: case.names.parameters.iter().map(parameter).collect(),
            definitions: case.names.definitions.clone(),
        };
        let version = match (case.is_general(), plain) {
            (true, _) => CONFIGURATION_VERSION,
            (false, true) => VERSION,
            (false, false) => LAGRANGIAN_VERSION,
        };
        Ok(Self {
            version,
            dimension: n,
            constants,
            size,
            basis,
            inertia,
            quartic: case.lagrangian.quartic.as_ref().map(number),
            metric: case.lagrangian.metric.as_ref().map(form),
            gyrostat: case.lagrangian.gyrostat.as_deref().map(list),
            lagrangian: case.lagrangian.formula.clone(),
            potential: case.potentials.iter().map(potential).collect(),
            force: case.forces.iter().map(term).collect(),
            names: (case.is_general() && case.names != Dictionary::default()).then(names),
            point: false,
        })
    }

    /// The same for a method with this state: without its matrices where the state is the momentum alone.
    pub fn with_state(mut self, form: &StateForm) -> Self {
        if *form == StateForm::Momentum {
            self.size = 0;
            self.basis.clear();
        }
        self.point = matches!(form, StateForm::Point(_));
        self
    }

    /// The key of what stands beside `mu`.
    pub(super) fn key(&self) -> &'static str {
        if self.point { "x" } else { "g" }
    }

    /// m: the size of the group's matrices; 0 where there is no group.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The request for a step of size h from `point`: one line, without its newline.
    pub fn request(&self, point: &Point<f64>, h: f64) -> String {
        let (g, x): (&[f64], &[f64]) = if self.point { (&[], &point.attitude) } else { (&point.attitude, &[]) };
        let request = Request { system: self, time: point.time, step: h, mu: &point.momentum, g, x };
        serde_json::to_string(&request).unwrap_or_default()
    }
}

/// What an answer says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reply {
    /// μ and g.
    State {
        /// n numbers.
        mu: Vec<f64>,
        /// m² numbers by rows, or m of a point; none where none were sent.
        g: Vec<f64>,
    },
    /// The method does not apply, and why.
    Unsupported(String),
    /// The method could not take the step, and why.
    Error(String),
}

/// Reads an answer to a request with n numbers of μ and `entries` of g.
///
/// # Errors
/// What is wrong with it, with its beginning.
pub fn parse(line: &[u8], n: usize, entries: usize) -> Result<Reply, String> {
    parse_beside(line, n, ("g", entries))
}

/// The same with `entries` numbers of another key instead of g.
pub(super) fn parse_beside(line: &[u8], n: usize, (key, entries): (&str, usize)) -> Result<Reply, String> {
    let said = || shown(line, 200);
    let value: Value = serde_json::from_slice(line).map_err(|error| {
        let text = String::from_utf8_lossy(line).to_lowercase();
        match ["nan", "infinity", "inf"].iter().any(|word| text.contains(word)) {
            true => format!("the stepper answers NaN or infinity, which JSON does not have: {}", said()),
            false => format!("the stepper's answer is not JSON ({error}): {}", said()),
        }
    })?;
    let Value::Object(object) = &value else {
        return Err(format!("the stepper's answer is not a JSON object: {}", said()));
    };
    let reason = |key: &str| {
        let text = object.get(key).map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_owned));
        text.map(|text| shown(text.as_bytes(), 120))
    };
    if let Some(why) = reason("unsupported") {
        return Ok(Reply::Unsupported(why));
    }
    if let Some(why) = reason("error") {
        return Ok(Reply::Error(why));
    }
    let numbers = |key: &str, wanted: usize| {
        numbers(object, key, wanted, "the stepper's answer").map_err(|why| format!("{why}: {}", said()))
    };
    let mu = numbers("mu", n)?;
    let g = if entries == 0 { Vec::new() } else { numbers(key, entries)? };
    Ok(Reply::State { mu, g })
}

/// The list of `wanted` numbers under a key of an object.
fn numbers(object: &Map<String, Value>, key: &str, wanted: usize, of: &str) -> Result<Vec<f64>, String> {
    let list = match object.get(key) {
        None => return Err(format!("{of} has no \"{key}\"")),
        Some(Value::Array(list)) => list,
        Some(_) => return Err(format!("\"{key}\" in {of} is not a list of numbers")),
    };
    if list.len() != wanted {
        let found = list.len();
        return Err(format!("\"{key}\" in {of} has {found} numbers, not {wanted}"));
    }
    let number = |(k, entry): (usize, &Value)| {
        let place = || format!("\"{key}\"[{k}] in {of} is {entry}, not a finite number");
        entry.as_f64().filter(|x| x.is_finite()).ok_or_else(place)
    };
    list.iter().enumerate().map(number).collect()
}

/// The stages of a step, where an answer tells them: under `stages` a list of objects with `b`, `t`, `eta` (n numbers) and `g` (`entries`).
///
/// # Errors
/// What is wrong with them, with the beginning of the answer.
pub(super) fn parse_stages(line: &[u8], n: usize, entries: usize) -> Result<Option<Vec<Stage<f64>>>, String> {
    // Most answers tell none: they are not read twice.
    if !line.windows(8).any(|word| word == b"\"stages\"") {
        return Ok(None);
    }
    let Ok(Value::Object(object)) = serde_json::from_slice(line) else { return Ok(None) };
    let Some(told) = object.get("stages") else { return Ok(None) };
    let said = |why: String| format!("{why}: {}", shown(line, 200));
    let Value::Array(list) = told else { return Err(said("\"stages\" in the stepper's answer is not a list".into())) };
    let stage = |(k, told): (usize, &Value)| {
        let of = format!("stage {k} of the stepper's answer");
        let Value::Object(told) = told else { return Err(said(format!("{of} is not an object"))) };
        let number = |key: &str| {
            let found = told.get(key).and_then(Value::as_f64).filter(|x| x.is_finite());
            found.ok_or_else(|| said(format!("{of} has no finite number \"{key}\"")))
        };
        let list = |key: &str, wanted: usize| numbers(told, key, wanted, &of).map_err(said);
        let (weight, time) = (number("b")?, number("t")?);
        Ok(Stage { weight, time, attitude: list("g", entries)?, velocity: list("eta", n)? })
    };
    list.iter().enumerate().map(stage).collect::<Result<_, _>>().map(Some)
}
