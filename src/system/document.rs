//! The serialised form of a case: what TOML files and JSON records hold. Unknown keys are errors everywhere.
//!
//! Shapes that no single serde type can express (a name *or* constants, velocity *or* momentum, a diagonal *or* a
//! matrix) are options here; the conversion to [`Case`] demands exactly one of them and says where.

use super::case::{
    Algebra, Case, Constant, Dictionary, Drag, Force, Inertia, Lagrangian, MAX_DIMENSION, Method, Monomial, Motion,
    Orientation, Parameter as Row, Potential, Start, Structure, Tau,
};
use super::error::{CaseError, CaseProblem, Place};
use super::event::EventFormula;
use super::force::{Kind, MATRIX, Parameter, Role, Value};
use crate::algebra::catalogue;
use crate::algebra::{AlgebraFamily, MatricesError, MatrixAlgebra, known};
use crate::scalar::Number;
use crate::tableau::{Description, Entries};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::LazyLock;

/// The version of the schema.
pub const FORMAT: i64 = 1;

/// The largest number of steps of a run.
pub const MAX_STEPS: u64 = 1_000_000_000;

/// The largest dimension of a crate's own types whose failures are kept.
const MOST_GIVEN: usize = 1024;

/// The whole file; its forces are tables where it is read, and terms where it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Document<F = ForceTable> {
    pub format: i64,
    pub algebra: AlgebraTable,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lagrangian: Option<LagrangianTable>,
    #[serde(default = "Vec::new", skip_serializing_if = "Vec::is_empty")]
    pub force: Vec<F>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub potential: Vec<Potential>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, Row>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub definitions: BTreeMap<String, String>,
    pub method: MethodTable,
    pub state: StateTable,
    pub run: RunTable,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<OutputTable>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub event: Vec<EventFormula>,
}

/// Tables of which every key may be missing: each is an option, with its attributes.
macro_rules! tables {
    ($($(#[$about:meta])* $table:ident { $($(#[$attribute:meta])* $key:ident: $value:ty,)* })*) => {$(
        $(#[$about])*
        #[derive(Clone, Default, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $table {
            $(
                $(#[$attribute])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $key: Option<$value>,
            )*
        }
    )*};
}

tables! {
    /// `[algebra]`.
    AlgebraTable {
        name: String,
        dimension: i64,
        constants: Vec<(i64, i64, i64, Number)>,
        matrices: Vec<Vec<Vec<Number>>>,
        /// Where matrices were drawn from; it says nothing else.
        family: AlgebraFamily,
        basis: Vec<Vec<Number>>,
        /// In the record of a failure on a user's own types, which has the dimension alone.
        given: Given,
    }

    /// `[lagrangian]`.
    LagrangianTable {
        inertia: Vec<Row>,
        indefinite: bool,
        gyrostat: Vec<Number>,
        quartic: Number,
        metric: Vec<Row>,
        formula: String,
    }

    /// `[state]`.
    StateTable {
        velocity: Vec<Number>,
        momentum: Vec<Number>,
        attitude: Vec<Number>,
        #[serde(rename = "rotation-vector")]
        rotation_vector: Vec<Number>,
        quaternion: Vec<Number>,
        matrix: Vec<Vec<Number>>,
        euler: Vec<Number>,
        axes: String,
        position: Vec<Number>,
        time: Number,
    }

    /// `[run]`.
    RunTable {
        step: Number,
        tolerance: Number,
        horizon: Number,
        steps: i64,
        max_step: Number,
        max_steps: i64,
        scalar: ScalarName,
    }

    /// `[output]`.
    OutputTable {
        every: i64,
        save_at: Vec<Number>,
        save_every: Number,
        csv: String,
        svg: String,
        events: String,
    }
}

/// What is known of an algebra of a user's own types.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Given {
    Abelian,
    Nonabelian,
}

/// One `[[force]]`, as it is read: its kind, and the keys that are there.
pub(crate) struct ForceTable {
    kind: Kind,
    entries: Vec<(&'static str, Entry)>,
}

/// What stands at a key of a force.
enum Entry {
    Terms(Vec<TermRow>),
    Form(Vec<Row>),
    Other(Value),
}

/// `[component, value, p, q, [i, j, …]]`: a term of a polynomial, with indices from 1.
type TermRow = (i64, Number, i64, i64, Vec<i64>);

/// `[method]`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MethodTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tableau: Option<String>,
    /// The reader of the text replaces the name by the tableau.
    #[serde(rename = "tableau-file", skip_serializing_if = "Option::is_none")]
    pub tableau_file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub a: Option<Vec<Vec<Number>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<Number>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub c: Option<Vec<Number>>,
    pub retraction: Tau,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub argument: Option<Vec<(i64, Number, Vec<i64>)>>,
}

/// In which scalar a run computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScalarName {
    /// `f64`, 16 digits.
    #[default]
    #[serde(rename = "f64")]
    F64,
    /// `Dd`, about 32 digits.
    #[serde(rename = "dd")]
    Dd,
}

impl<'de> Deserialize<'de> for Row {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RowVisitor)
    }
}

struct RowVisitor;

macro_rules! one {
    ($($visit:ident $of:ty),*) => {$(
        fn $visit<E: Error>(self, value: $of) -> Result<Row, E> {
            Number::deserialize(value.into_deserializer()).map(Row::Number)
        }
    )*};
}

impl<'de> Visitor<'de> for RowVisitor {
    type Value = Row;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, a text such as \"1/2\", or a list of them")
    }

    one!(visit_i64 i64, visit_u64 u64, visit_f64 f64, visit_str &str);

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<Row, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(items)).map(Row::Vector)
    }
}

/// A formula for a vector, or one for each component.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a text such as \"-k*eta\", or a list of texts and numbers, one for each component")]
enum Texts {
    One(Text),
    Many(Vec<Text>),
}

/// A formula, which may be a number.
#[derive(Deserialize)]
#[serde(untagged)]
enum Text {
    Formula(String),
    Number(Number),
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Formula(text) => f.write_str(text),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl Texts {
    /// One formula.
    fn joined(self) -> String {
        match self {
            Self::One(text) => text.to_string(),
            Self::Many(texts) => {
                let texts: Vec<String> = texts.iter().map(Text::to_string).collect();
                format!("[{}]", texts.join(", "))
            }
        }
    }
}

impl Serialize for Case {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Document::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Case {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Document::<ForceTable>::deserialize(deserializer)?.try_into().map_err(D::Error::custom)
    }
}

impl TryFrom<Document> for Case {
    type Error = CaseError;

    fn try_from(document: Document) -> Result<Self, CaseError> {
        if document.format != FORMAT {
            return Err(Place::root().key("format").range(document.format, FORMAT.to_string()));
        }
        let step = fixed_step(&document)?;
        let algebra = document.algebra.algebra(&Place::root().key("algebra"))?;
        let n = algebra.dimension();
        let lagrangian = match document.lagrangian {
            Some(table) => table.lagrangian(n, &Place::root().key("lagrangian"))?,
            None => Lagrangian::unit(n),
        };
        let place = Place::root().key("force");
        let forces = document.force.into_iter().enumerate();
        let forces = forces.map(|(i, table)| table.force(&place.index(i))).collect::<Result<_, _>>()?;
        let names = Dictionary { parameters: document.parameters, definitions: document.definitions };
        let method = document.method.method(&Place::root().key("method"))?;
        let start = document.state.start(&Place::root().key("state"))?;
        let potentials = document.potential;
        Ok(Self { algebra, lagrangian, potentials, forces, names, method, start, step })
    }
}

/// A tolerance where a step is needed.
pub(super) fn no_steps() -> CaseError {
    Place::root()
        .key("run")
        .key("tolerance")
        .inapplicable("a tolerance", "fixed steps are needed here: give `step` instead of `tolerance`")
}

/// What says how long steps are.
const STEP: &str = "`step` (a number that is not 0, such as \"1/8\"); for `integrate` also `tolerance` (such as 1e-10)";

/// The step of a document for fixed steps; what runs with a tolerance have is refused.
fn fixed_step(document: &Document) -> Result<Number, CaseError> {
    let (run, output) = (Place::root().key("run"), Place::root().key("output"));
    if document.run.tolerance.is_some() {
        return Err(no_steps());
    }
    let Some(step) = &document.run.step else {
        return Err(run.missing("the step", STEP));
    };
    let table = document.output.as_ref();
    let others = [
        (run.key("max_step"), "a largest step", document.run.max_step.is_some()),
        (run.key("max_steps"), "a largest number of steps", document.run.max_steps.is_some()),
        (Place::root().key("event").index(0), "an event", !document.event.is_empty()),
        (output.key("save_at"), "`save_at`", table.is_some_and(|table| table.save_at.is_some())),
        (output.key("save_every"), "`save_every`", table.is_some_and(|table| table.save_every.is_some())),
        (output.key("events"), "a table of events", table.is_some_and(|table| table.events.is_some())),
    ];
    match others.into_iter().find(|(_, _, given)| *given) {
        Some((place, what, _)) => Err(place.inapplicable(what, "it is for runs with `tolerance` instead of `step`")),
        None => Ok(step.clone()),
    }
}

impl AlgebraTable {
    fn algebra(self, place: &Place) -> Result<Algebra, CaseError> {
        let Self { name, dimension, constants, matrices, family, basis, given } = self;
        let excess = |key, allowed: &str| Err(place.key(key).excess(allowed));
        let structure = match (name, dimension, constants, matrices) {
            (None, Some(n), None, _) if given.is_some() && basis.is_none() => {
                let dimension = usize::try_from(n).ok().filter(|n| *n <= MOST_GIVEN);
                let range = || place.key("dimension").range(n, format!("0 to {MOST_GIVEN}"));
                Structure::Given { dimension: dimension.ok_or_else(range)?, abelian: given == Some(Given::Abelian) }
            }
            _ if given.is_some() => {
                return excess(
                    "given",
                    "it marks the record of a failure on types of a crate of its own, and stands there with `dimension` alone",
                );
            }
            (None, None, None, Some(matrices)) => from_matrices(family, matrices, &place.key("matrices"))?,
            (.., Some(_)) => {
                return excess(
                    "matrices",
                    "either `name`, or `matrices`, or `dimension` and `constants`, one of these alone",
                );
            }
            _ if family.is_some() => {
                return excess("family", "it stands beside `matrices`, and says where they were drawn from");
            }
            (Some(name), None, None, _) => from_name(&name, &place.key("name"))?,
            (Some(_), n, ..) => {
                let key = if n.is_some() { "dimension" } else { "constants" };
                return excess(key, "either `name`, or `dimension` and `constants`, not both");
            }
            (None, Some(dimension), Some(constants), _) => from_constants(dimension, constants, place)?,
            (None, Some(_), None, _) => {
                return Err(place.missing(
                    "`constants`",
                    "a list of [a, b, c, value] with [e_a, e_b] = value e_c, indices from 1 (empty for an abelian algebra)",
                ));
            }
            (None, None, Some(_), _) => return Err(place.missing("`dimension`", "an integer from 1 to 10")),
            (None, None, None, _) => {
                return Err(place.missing("the algebra", "give `name`, or `matrices`, or `dimension` and `constants`"));
            }
        };
        Ok(Algebra { structure, basis })
    }
}

pub(super) fn from_name(name: &str, place: &Place) -> Result<Structure, CaseError> {
    if let Ok(entry) = name.parse::<catalogue::Entry>() {
        dimension_allowed(entry.dimension() as i64, place)?;
        return Ok(Structure::Named(entry));
    }
    let factors = known::factors(name).map_err(|unknown| {
        place.error(CaseProblem::Part(format!(
            "unknown algebra {unknown:?}; allowed: r1 to r{MAX_DIMENSION}, {}, {}, and products of these with `+`, as in \
             so3+r2, of dimension {MAX_DIMENSION} at most",
            catalogue::Entry::names().join(", "),
            known::names().collect::<Vec<_>>().join(", ")
        )))
    })?;
    dimension_allowed(factors.iter().map(|factor| factor.len() as i64).sum(), place)?;
    match known::product(&factors) {
        Some(algebra) => Ok(Structure::Matrices { family: None, algebra }),
        None => Err(place.error(CaseProblem::Part(format!("{name:?} is no product of algebras")))),
    }
}

fn dimension_allowed(dimension: i64, place: &Place) -> Result<usize, CaseError> {
    match usize::try_from(dimension) {
        Ok(n) if (1..=MAX_DIMENSION).contains(&n) => Ok(n),
        _ => Err(place.range(
            format!("of dimension {dimension}"),
            format!("dimension 1 to {MAX_DIMENSION} (what holds the larger ones is not compiled in)"),
        )),
    }
}

fn from_matrices(
    family: Option<AlgebraFamily>,
    matrices: Vec<Vec<Vec<Number>>>,
    place: &Place,
) -> Result<Structure, CaseError> {
    dimension_allowed(matrices.len() as i64, place)?;
    let algebra = MatrixAlgebra::new(matrices).map_err(|error| {
        let place = match &error {
            MatricesError::NotSquare { index, .. } | MatricesError::Dependent { index } => place.index(*index),
            MatricesError::NotRational { index, row, column, .. } => place.index(*index).index(*row).index(*column),
            MatricesError::NotClosed { a, .. } | MatricesError::TooLong { a, .. } => place.index(*a),
            _ => place.clone(),
        };
        place.error(CaseProblem::Part(error.to_string()))
    })?;
    if !super::dispatch::has_class(algebra.dimension(), algebra.matrix_size(), false) {
        let (n, size) = (algebra.dimension(), algebra.matrix_size());
        return Err(place.range(
            format!("{size}×{size} matrices for dimension {n}"),
            "matrices of at most 12×12 with those of spectators",
        ));
    }
    Ok(Structure::Matrices { family, algebra })
}

fn from_constants(
    dimension: i64,
    constants: Vec<(i64, i64, i64, Number)>,
    place: &Place,
) -> Result<Structure, CaseError> {
    let n = dimension_allowed(dimension, &place.key("dimension"))?;
    let place = place.key("constants");
    let mut seen = BTreeSet::new();
    let mut list = Vec::new();
    for (i, (a, b, c, value)) in constants.into_iter().enumerate() {
        let place = place.index(i);
        let index = |position: usize, k: i64| match usize::try_from(k) {
            Ok(k) if (1..=n).contains(&k) => Ok(k),
            _ => Err(place
                .index(position)
                .range(format!("the index {k}"), format!("1 to {n}, the dimension (indices count from 1)"))),
        };
        let (a, b, c) = (index(0, a)?, index(1, b)?, index(2, c)?);
        if a == b {
            return Err(
                place.range(format!("a constant for [e_{a}, e_{a}], which is 0"), "two different lower indices")
            );
        }
        if !seen.insert((a.min(b), a.max(b), c)) {
            return Err(place.error(CaseProblem::Duplicate { a, b, c }));
        }
        list.push(Constant { a, b, c, value });
    }
    Ok(Structure::Constants { dimension: n, constants: list })
}

/// What the inertia is.
const INERTIA: &str = "n numbers (its diagonal) or n rows of n numbers; or in its place `formula`, the whole Lagrangian (without the table \
                       [lagrangian] the inertia is the unit matrix)";

impl LagrangianTable {
    fn lagrangian(self, n: usize, place: &Place) -> Result<Lagrangian, CaseError> {
        let written = self.inertia.is_some() || self.gyrostat.is_some() || self.quartic.is_some();
        let inertia = match (self.inertia, &self.formula) {
            (Some(rows), _) => form(rows, &place.key("inertia"))?,
            (None, Some(_)) => Lagrangian::unit(n).inertia,
            (None, None) => return Err(place.missing("`inertia`", INERTIA)),
        };
        let metric = self.metric.map(|rows| form(rows, &place.key("metric"))).transpose()?;
        if metric.is_some() && self.quartic.is_none() {
            return Err(place
                .key("metric")
                .excess("it is the metric of the quartic term, and stands beside `quartic`"));
        }
        let (indefinite, gyrostat, quartic) = (self.indefinite == Some(true), self.gyrostat, self.quartic);
        if let (Some(_), true) = (&self.formula, written) {
            return Err(place.key("formula").excess("it is the whole Lagrangian, and stands alone"));
        }
        Ok(Lagrangian { inertia, indefinite, gyrostat, quartic, metric, formula: self.formula })
    }
}

/// A symmetric matrix: its diagonal, or its rows.
fn form(rows: Vec<Row>, place: &Place) -> Result<Inertia, CaseError> {
    let matrix = matches!(rows.first(), Some(Row::Vector(_)));
    let (mut diagonal, mut full) = (Vec::new(), Vec::new());
    for (i, row) in rows.into_iter().enumerate() {
        match row {
            Row::Number(number) if !matrix => diagonal.push(number),
            Row::Vector(numbers) if matrix => full.push(numbers),
            _ => {
                return Err(place.index(i).excess("a list of diagonal entries, or a list of rows, not a mixture"));
            }
        }
    }
    Ok(if matrix { Inertia::Full(full) } else { Inertia::Diagonal(diagonal) })
}

impl From<Inertia> for Vec<Row> {
    fn from(form: Inertia) -> Self {
        match form {
            Inertia::Diagonal(diagonal) => diagonal.into_iter().map(Row::Number).collect(),
            Inertia::Full(rows) => rows.into_iter().map(Row::Vector).collect(),
        }
    }
}

impl From<Lagrangian> for LagrangianTable {
    fn from(lagrangian: Lagrangian) -> Self {
        let Lagrangian { inertia, indefinite, gyrostat, quartic, metric, formula } = lagrangian;
        let (inertia, indefinite) = (formula.is_none().then(|| inertia.into()), indefinite.then_some(true));
        Self { inertia, indefinite, gyrostat, quartic, metric: metric.map(Vec::from), formula }
    }
}

/// The keys of a force, `kind` first.
static FORCE_KEYS: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let mut keys = vec!["kind"];
    for key in Kind::ALL.iter().flat_map(|kind| kind.parameters).flat_map(Parameter::keys) {
        if !keys.contains(key) {
            keys.push(key);
        }
    }
    keys
});

/// The parameter that has a key, of the first kind that has it.
fn parameter(key: &str) -> Option<&'static Parameter> {
    Kind::ALL.iter().flat_map(|kind| kind.parameters).find(|parameter| parameter.keys().contains(&key))
}

/// A key of a force.
struct Key(&'static str);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let known = FORCE_KEYS.iter().find(|key| **key == name);
        known.map(|key| Self(key)).ok_or_else(|| D::Error::unknown_field(&name, &FORCE_KEYS))
    }
}

impl<'de> Deserialize<'de> for ForceTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_struct("ForceTable", &FORCE_KEYS, ForceVisitor)
    }
}

struct ForceVisitor;

impl<'de> Visitor<'de> for ForceVisitor {
    type Value = ForceTable;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("struct ForceTable")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ForceTable, A::Error> {
        let (mut kind, mut seen, mut entries) = (None, Vec::new(), Vec::new());
        while let Some(Key(key)) = map.next_key()? {
            if seen.contains(&key) {
                return Err(A::Error::duplicate_field(key));
            }
            seen.push(key);
            let value = match parameter(key).map(|parameter| parameter.role) {
                None => {
                    kind = Some(map.next_value()?);
                    continue;
                }
                Some(Role::CovectorPolynomial | Role::VectorPolynomial | Role::OddPolynomial) => {
                    map.next_value::<Option<_>>()?.map(Entry::Terms)
                }
                Some(Role::Form) => map.next_value::<Option<_>>()?.map(Entry::Form),
                Some(Role::Drag | Role::SymmetricDrag) if key == MATRIX => {
                    map.next_value::<Option<_>>()?.map(Drag::Matrix).map(Value::Drag).map(Entry::Other)
                }
                Some(Role::Drag | Role::SymmetricDrag) => {
                    map.next_value::<Option<_>>()?.map(Drag::Coefficient).map(Value::Drag).map(Entry::Other)
                }
                Some(Role::Amplitude | Role::Vector) => {
                    map.next_value::<Option<_>>()?.map(Value::List).map(Entry::Other)
                }
                Some(Role::Formula) => {
                    map.next_value::<Option<Texts>>()?.map(Texts::joined).map(Value::Formula).map(Entry::Other)
                }
                Some(Role::Strength | Role::Weight | Role::Rate | Role::Frequency | Role::Phase) => {
                    map.next_value::<Option<_>>()?.map(Value::Number).map(Entry::Other)
                }
            };
            entries.extend(value.map(|value| (key, value)));
        }
        Ok(ForceTable { kind: kind.ok_or_else(|| A::Error::missing_field("kind"))?, entries })
    }
}

impl ForceTable {
    fn force(mut self, place: &Place) -> Result<Force, CaseError> {
        let kind = self.kind.description();
        let keys: Vec<&str> = kind.parameters.iter().flat_map(Parameter::keys).copied().collect();
        let external =
            |key: &&&'static str| !keys.contains(*key) && self.entries.iter().any(|(found, _)| found == *key);
        if let Some(key) = FORCE_KEYS.iter().find(external) {
            return Err(place.key(key).excess(format!("this kind of force takes `{}`", keys.join("`, `"))));
        }
        let values = kind.parameters.iter().map(|parameter| self.value(parameter, place));
        Ok(kind.with(values.collect::<Result<Vec<_>, _>>()?))
    }

    /// The value of a parameter, of which the keys are taken out.
    fn value(&mut self, parameter: &'static Parameter, place: &Place) -> Result<Value, CaseError> {
        let (of_it, others) = self.entries.drain(..).partition(|(key, _)| parameter.keys().contains(key));
        self.entries = others;
        let of_it: Vec<(&str, Entry)> = of_it;
        if of_it.len() > 1 {
            return Err(place.key(MATRIX).excess("either `coefficient` or `matrix`, not both"));
        }
        let missing = |allowed| Err(place.missing(format!("`{}`", parameter.name), allowed));
        match (of_it.into_iter().next(), parameter.role) {
            (Some((_, Entry::Other(value))), _) => Ok(value),
            (Some((key, Entry::Terms(rows))), _) => {
                let place = place.key(key);
                let terms = rows.into_iter().enumerate().map(|(k, row)| monomial(row, &place.index(k), (TERMS, 4)));
                Ok(Value::Polynomial(terms.collect::<Result<_, _>>()?))
            }
            (Some((key, Entry::Form(rows))), _) => Ok(Value::Form(form(rows, &place.key(key))?)),
            (None, Role::Phase) => Ok(Value::Number(Number::default())),
            (None, Role::Form) => missing("n numbers (its diagonal) or n rows of n numbers"),
            (None, Role::Vector) => missing("a list of n numbers, a vector"),
            (None, Role::Amplitude) => missing("a list of n numbers, a covector"),
            (None, Role::CovectorPolynomial | Role::VectorPolynomial) => missing(TERMS),
            (None, Role::Formula) => missing(FORMULA),
            (None, Role::Drag | Role::SymmetricDrag) => {
                Err(place.missing("the drag", "`coefficient` (a number) or `matrix` (n rows)"))
            }
            (None, _) => missing("a number"),
        }
    }
}

/// What the value of a formula is.
const FORMULA: &str = "a text such as \"-k*eta\", a vector with n components; or a list of n texts";

/// What the terms of a polynomial are; in the same order the place of the factors is the fifth.
const TERMS: &str =
    "a list of terms [a, value, p, q, [i, j, …]]: value cos(t)^p sin(t)^q eta_i eta_j … in component a, indices from 1";

/// The same of the argument of a retraction.
const ODD_TERMS: &str = "a list of terms [a, value, [i, j, k, …]], indices from 1";

fn monomial(
    (component, value, cos, sin, factors): TermRow,
    place: &Place,
    (allowed, last): (&str, usize),
) -> Result<Monomial, CaseError> {
    let natural = |place: Place, x: i64| {
        let range = |_| place.range(x, allowed);
        usize::try_from(x).map_err(range)
    };
    let factors = factors.into_iter().enumerate();
    Ok(Monomial {
        component: natural(place.index(0), component)?,
        value,
        cos: natural(place.index(2), cos)?,
        sin: natural(place.index(3), sin)?,
        factors: factors.map(|(j, i)| natural(place.index(last).index(j), i)).collect::<Result<_, _>>()?,
    })
}

impl MethodTable {
    /// This tableau alone.
    pub fn put(&mut self, tableau: Description) {
        (self.tableau, self.tableau_file, self.a, self.b, self.c) = (None, None, None, None, None);
        match tableau {
            Description::Entries(Entries { a, b, c }) => (self.a, self.b, self.c) = (Some(a), Some(b), c),
            named => self.tableau = Some(named.to_string()),
        }
    }

    fn method(self, place: &Place) -> Result<Method, CaseError> {
        if self.tableau_file.is_some() {
            let why =
                "a text alone does not say in which directory it is: give the tableau itself, or the directory".into();
            return Err(place
                .key("tableau-file")
                .error(CaseProblem::NotApplicable { what: "a tableau file".into(), why }));
        }
        if let (Some(_), Some(_)) = (&self.tableau, &self.c) {
            return Err(place.key("c").excess("either `tableau`, or `a` and `b`, not both"));
        }
        let c = self.c;
        let tableau = match (self.tableau, self.a, self.b) {
            (Some(name), None, None) => {
                let place = place.key("tableau");
                name.parse::<Description>().map_err(|e| place.error(CaseProblem::Tableau(e)))?
            }
            (None, Some(a), Some(b)) => Description::Entries(Entries { a, b, c }),
            (None, None, None) => {
                return Err(place.missing(
                    "the tableau",
                    "`tableau` (a name such as \"gauss-2\"), or `tableau-file`, or `a` and `b`",
                ));
            }
            (None, Some(_), None) => return Err(place.missing("`b`", "the list of the s weights")),
            (None, None, Some(_)) => return Err(place.missing("`a`", "the s rows of coefficients")),
            (Some(_), a, _) => {
                let key = if a.is_some() { "a" } else { "b" };
                return Err(place.key(key).excess("either `tableau`, or `a` and `b`, not both"));
            }
        };
        let place = place.key("argument");
        let terms = self.argument.unwrap_or_default().into_iter().enumerate();
        let term = |(k, (component, value, factors)): (usize, (i64, Number, Vec<i64>))| {
            monomial((component, value, 0, 0, factors), &place.index(k), (ODD_TERMS, 2))
        };
        let argument = terms.map(term).collect::<Result<_, CaseError>>()?;
        Ok(Method { tableau, retraction: self.retraction, argument })
    }
}

impl From<Method> for MethodTable {
    fn from(method: Method) -> Self {
        let row =
            |term: Monomial| (natural(term.component), term.value, term.factors.into_iter().map(natural).collect());
        let argument: Vec<_> = method.argument.into_iter().map(row).collect();
        let (retraction, argument) = (method.retraction, (!argument.is_empty()).then_some(argument));
        let mut table = Self { tableau: None, tableau_file: None, a: None, b: None, c: None, retraction, argument };
        table.put(method.tableau);
        table
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        MethodTable::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = MethodTable::deserialize(deserializer)?;
        table.method(&Place::root()).map_err(D::Error::custom)
    }
}

impl StateTable {
    fn start(self, place: &Place) -> Result<Start, CaseError> {
        let useless = self.axes.is_some() && self.euler.is_none();
        let axes = self.axes.unwrap_or_else(|| "zyx".into());
        // At most one way of saying where the system is.
        let forms = [
            ("attitude", self.attitude.as_ref().map(|_| None)),
            ("rotation-vector", self.rotation_vector.map(Orientation::RotationVector).map(Some)),
            ("quaternion", self.quaternion.map(Orientation::Quaternion).map(Some)),
            ("matrix", self.matrix.map(Orientation::Matrix).map(Some)),
            ("euler", self.euler.map(|angles| Some(Orientation::Euler { angles, axes }))),
        ];
        let mut given = forms.into_iter().filter_map(|(key, form)| Some((key, form?)));
        let (first, second) = (given.next(), given.next());
        if let (Some((first, _)), Some((second, _))) = (&first, second) {
            return Err(place.key(second).excess(format!("either `{first}` or `{second}`, not both")));
        }
        if useless {
            return Err(place.key("axes").excess("it names the axes of `euler`, and stands beside it"));
        }
        if self.attitude.is_some() && self.position.is_some() {
            return Err(place.key("position").excess("`attitude` has the position in it"));
        }
        let motion = match (self.velocity, self.momentum) {
            (Some(eta), None) => Motion::Velocity(eta),
            (None, Some(mu)) => Motion::Momentum(mu),
            (None, None) => {
                return Err(place.missing("the initial motion", "`velocity` or `momentum`, a list of n numbers"));
            }
            (Some(_), Some(_)) => {
                return Err(place.key("momentum").excess("either `velocity` or `momentum`, not both"));
            }
        };
        let (orientation, time) = (first.and_then(|(_, form)| form), self.time.unwrap_or_default());
        Ok(Start { motion, attitude: self.attitude, orientation, position: self.position, time })
    }
}

impl From<Start> for StateTable {
    fn from(Start { motion, attitude, orientation, position, time }: Start) -> Self {
        let time = Some(time).filter(|t| *t != Number::default());
        let mut table = Self { attitude, position, time, ..Self::default() };
        match motion {
            Motion::Velocity(eta) => table.velocity = Some(eta),
            Motion::Momentum(mu) => table.momentum = Some(mu),
        }
        match orientation {
            None => {}
            Some(Orientation::RotationVector(x)) => table.rotation_vector = Some(x),
            Some(Orientation::Quaternion(q)) => table.quaternion = Some(q),
            Some(Orientation::Matrix(rows)) => table.matrix = Some(rows),
            Some(Orientation::Euler { angles, axes }) => (table.euler, table.axes) = (Some(angles), Some(axes)),
        }
        table
    }
}

impl From<Algebra> for AlgebraTable {
    fn from(Algebra { structure, basis }: Algebra) -> Self {
        let mut table = Self { basis, ..Self::default() };
        match structure {
            Structure::Named(entry) => table.name = Some(entry.to_string()),
            Structure::Matrices { family: None, algebra } if known::name_of(&algebra).is_some() => {
                table.name = known::name_of(&algebra).map(String::from);
            }
            Structure::Matrices { family, algebra } => {
                (table.matrices, table.family) = (Some(algebra.matrices().to_vec()), family);
            }
            Structure::Constants { dimension, constants } => {
                let row = |k: Constant| (natural(k.a), natural(k.b), natural(k.c), k.value);
                table.dimension = Some(natural(dimension));
                table.constants = Some(constants.into_iter().map(row).collect());
            }
            Structure::Given { dimension, abelian } => {
                table.dimension = Some(natural(dimension));
                table.given = Some(if abelian { Given::Abelian } else { Given::Nonabelian });
            }
        }
        table
    }
}

impl From<Case> for Document<Force> {
    fn from(case: Case) -> Self {
        Self {
            format: FORMAT,
            algebra: case.algebra.into(),
            lagrangian: Some(case.lagrangian.into()),
            force: case.forces,
            potential: case.potentials,
            parameters: case.names.parameters,
            definitions: case.names.definitions,
            method: case.method.into(),
            state: case.start.into(),
            run: RunTable { step: Some(case.step), ..RunTable::default() },
            output: None,
            event: Vec::new(),
        }
    }
}

/// An index or a degree as it is written.
fn natural(x: usize) -> i64 {
    i64::try_from(x).unwrap_or(i64::MAX)
}

impl Serialize for Force {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut table = serializer.serialize_map(None)?;
        table.serialize_entry("kind", self.kind())?;
        for (parameter, value) in self.parameters() {
            let key = if let Value::Drag(drag) = &value { drag.key() } else { parameter.name };
            table.serialize_entry(key, &value)?;
        }
        table.end()
    }
}

impl Serialize for Monomial {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.component, &self.value, self.cos, self.sin, &self.factors).serialize(serializer)
    }
}
