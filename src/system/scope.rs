//! The formulas of a case: what they may name, and what they become in a scalar.

use super::case::{Case, Dictionary, Inertia, Orientation, Parameter, Potential, Structure};
use super::error::{CaseError, CaseProblem, Place};
use super::force::{self, Domain, Value};
use super::numbers::{length, list, number, square_of, vector_of};
use crate::algebra::catalogue::Entry;
use crate::algebra::{Matrix, Vector};
use crate::expression::{Expression, ExpressionError, Names, Shape};
use crate::group::so3::hat;
use crate::group::{MatrixGroup, departure, nearest_rotations};
use crate::mechanics::force::AnyForce;
use crate::mechanics::formula::{FormulaForce, FormulaLagrangian, Quantities};
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::retraction::{ExponentialSo3, Retraction};
use crate::scalar::{Number, Real};

/// The group on which a body turns, so(3) or se(3).
fn body_of(case: &Case) -> Option<Entry> {
    match &case.algebra.structure {
        Structure::Named(entry @ (Entry::So3 | Entry::Se3)) => Some(entry.clone()),
        _ => None,
    }
}

impl Quantities {
    /// Those of a case.
    pub(super) fn of(case: &Case) -> Self {
        Self { dimension: case.dimension(), size: case.matrix_size() }
    }
}

/// The names of a case.
#[derive(Clone, Debug)]
pub(crate) struct Scope {
    names: Names,
    quantities: Quantities,
    body: Option<Entry>,
    /// Whether the basis is that of the catalogue.
    standard: bool,
    /// The rotational inertia as the text of a matrix; none where the Lagrangian is a formula.
    inertia: Option<String>,
}

/// By how much a matrix that is typed may violate gᵀg = 1. Entries of three digits are off by 5e-4, which makes 2√3 · 5e-4 = 1.7e-3; a
/// wrong entry or sign makes more than 0.01, unless it is small.
const ROUNDED: f64 = 0.01;

/// By how much what is no rotation may violate the equations of the group: it stays as it is.
const UNCORRECTED: f64 = 1e-5;

impl Scope {
    /// The scope of a case.
    ///
    /// # Errors
    /// A name that is none, or that has another meaning; a parameter without a value.
    pub fn of(case: &Case) -> Result<Self, CaseError> {
        if case.is_general() || case.names != Dictionary::default() {
            return Self::with_names(case);
        }
        // Nothing asks for names, which most cases would be asked for in vain.
        Ok(Self::nameless(case))
    }

    /// Without names.
    fn nameless(case: &Case) -> Self {
        Self {
            names: Names::new(),
            quantities: Quantities::of(case),
            body: body_of(case),
            standard: case.algebra.basis.is_none(),
            inertia: case.lagrangian.formula.is_none().then(|| rotational(&case.lagrangian.inertia)),
        }
    }

    /// The scope of a case for formulas that are not in it.
    ///
    /// # Errors
    /// Those of [`Scope::of`].
    pub fn with_names(case: &Case) -> Result<Self, CaseError> {
        let mut scope = Self::nameless(case);
        let (quantities, body) = (scope.quantities, scope.body.clone());
        let refused = |e: ExpressionError| Place::root().error(CaseProblem::Formula(e));
        let mut names = quantities.names().map_err(refused)?;
        if body.is_some() {
            let rows = (0..3).map(|r| (0..3).map(|c| quantities.entry(r, c)).collect()).collect();
            names.matrix_of("R", rows).map_err(refused)?;
        }
        if body == Some(Entry::Se3) {
            names.vector_of("x", (0..3).map(|r| quantities.entry(r, 3)).collect()).map_err(refused)?;
        }
        for (name, value) in &case.names.parameters {
            let place = Place::root().key("parameters").name(name);
            let declared = match value {
                Parameter::Number(value) => {
                    number::<f64>(value, &place)?;
                    names.parameter(name, value.clone())
                }
                Parameter::Vector(list) => {
                    for (k, value) in list.iter().enumerate() {
                        number::<f64>(value, &place.index(k))?;
                    }
                    names.parameters(name, list.clone())
                }
            };
            declared.map_err(|e| place.error(CaseProblem::Part(e.message().into())))?;
        }
        for (name, text) in &case.names.definitions {
            let place = Place::root().key("definitions").name(name);
            names.definition(name, text).map_err(|e| place.error(CaseProblem::Part(e.message().into())))?;
        }
        scope.names = names;
        // Definitions that nothing uses are read, too.
        for name in case.names.definitions.keys() {
            scope.expression(name, &Place::root().key("definitions").name(name))?;
        }
        Ok(scope)
    }

    fn expression(&self, text: &str, place: &Place) -> Result<Expression, CaseError> {
        Expression::parse(text, &self.names).map_err(|e| match e.definition() {
            Some(name) => Place::root().key("definitions").name(name).error(CaseProblem::Formula(e.clone())),
            None => place.error(CaseProblem::Formula(e)),
        })
    }

    /// A formula with one value.
    pub fn number(&self, text: &str, place: &Place) -> Result<Expression, CaseError> {
        let expression = self.expression(text, place)?;
        match expression.shape() {
            Shape::Scalar => Ok(expression),
            found => Err(place.range(found, "a number")),
        }
    }

    /// Which of these quantities a formula asks for, by name.
    fn asks(&self, expression: &Expression, from: usize, name: &str) -> Option<String> {
        let n = self.quantities.dimension;
        (0..n).find(|a| expression.uses(from + a)).map(|a| format!("{name}_{}", a + 1))
    }

    /// The force of a formula.
    ///
    /// # Errors
    /// What is wrong with the text; another number of components than n.
    pub fn force<T: Real, const N: usize>(
        &self,
        text: &str,
        lagrangian: &AnyLagrangian<T, N>,
        place: &Place,
    ) -> Result<AnyForce<T, N>, CaseError> {
        let (expression, n) = (self.expression(text, place)?, self.quantities.dimension);
        match expression.shape() {
            Shape::Vector(found) if found == n => {}
            Shape::Scalar if n == 1 => {}
            found => {
                return Err(place.range(found, format!("a vector of {n} components, as the algebra has dimension {n}")));
            }
        }
        let program = expression.compile::<T>().map_err(|e| place.error(CaseProblem::Formula(e)))?;
        Ok(AnyForce::Formula(Box::new(FormulaForce::new(program, self.quantities, lagrangian.clone()))))
    }

    /// The body of so(3) or se(3) whose rotation and position a kind is about, in any basis of the algebra; whose velocity or inertia, in the
    /// standard one.
    fn body(&self, what: &'static str, is_standard: bool, place: &Place) -> Result<Entry, CaseError> {
        self.body.clone().filter(|_| self.standard || !is_standard).ok_or_else(|| {
            let basis = if is_standard { " in its standard basis" } else { "" };
            let why = format!("it is for a body: the algebra so3 or se3{basis}; elsewhere write a formula");
            place.inapplicable(what, why)
        })
    }

    /// The formula of a kind of force or potential, and its place. In braces are the names of parameters; on se(3) `above` is what its position
    /// adds to a height, `rest` the other components of a covector.
    pub fn formula(
        &self,
        (kind, domain, text): (&'static str, Domain, &str),
        parameters: impl Iterator<Item = (&'static force::Parameter, Value)>,
        place: &Place,
    ) -> Result<(String, Place), CaseError> {
        let values: Vec<_> = parameters.collect();
        let mut text = filled(text, &values);
        if domain == Domain::Any {
            let place = values.first().map_or(place.clone(), |(parameter, _)| place.key(parameter.name));
            return Ok((text, place));
        }
        let body = self.body(kind, domain == Domain::StandardBody, place)?;
        for (parameter, value) in values {
            let place = place.key(parameter.name);
            match value {
                Value::Number(x) => drop(number::<f64>(&x, &place)?),
                Value::List(x) => drop(three_of::<f64>(&x, &place)?),
                _ => {}
            }
        }
        if text.contains("{inertia}") {
            let why = "it needs the inertia, which a formula for the Lagrangian does not give";
            let inertia = self.inertia.as_ref().ok_or_else(|| place.inapplicable(kind, why))?;
            text = text.replace("{inertia}", inertia);
        }
        let (above, rest) = if body == Entry::Se3 { (" + x_3", ", 0, 0, 0") } else { ("", "") };
        Ok((text.replace("{above}", above).replace("{rest}", rest), place.clone()))
    }

    /// L = l − V for each potential of a case.
    ///
    /// # Errors
    /// What is wrong with a text; a potential that asks for velocities; no group.
    pub fn with_potentials<T: Real, const N: usize, const D: usize>(
        &self,
        potentials: &[Potential],
        group: &Option<MatrixGroup<T, N, D>>,
        mut lagrangian: AnyLagrangian<T, N>,
    ) -> Result<AnyLagrangian<T, N>, CaseError> {
        for (k, potential) in potentials.iter().enumerate() {
            let (kind, place) = (potential.description(), Place::root().key("potential").index(k));
            let (text, place) = self.formula((kind.name, kind.domain, kind.formula), potential.parameters(), &place)?;
            let expression = self.number(&text, &place)?;
            let n = self.quantities.dimension;
            let found = self.asks(&expression, 1, "eta").or_else(|| self.asks(&expression, 1 + n, "mu"));
            if let Some(name) = found {
                return Err(place.range(format!("a function of {name}"), "a function of t and g"));
            }
            let Some(group) = group else {
                return Err(place.inapplicable(
                    "a potential",
                    "the algebra is given by structure constants alone, without a group",
                ));
            };
            let program = expression.compile::<T>().map_err(|e| place.error(CaseProblem::Formula(e)))?;
            lagrangian = FormulaLagrangian::with_potential(lagrangian, program, self.quantities, group).into();
        }
        Ok(lagrangian)
    }

    /// The Lagrangian of a formula.
    ///
    /// # Errors
    /// What is wrong with the text; one that asks for μ.
    pub fn lagrangian<T: Real, const N: usize, const D: usize>(
        &self,
        text: &str,
        group: &Option<MatrixGroup<T, N, D>>,
    ) -> Result<AnyLagrangian<T, N>, CaseError> {
        let place = Place::root().key("lagrangian").key("formula");
        let (expression, n) = (self.number(text, &place)?, self.quantities.dimension);
        if let Some(name) = self.asks(&expression, 1 + n, "mu") {
            return Err(place.range(format!("a function of {name}"), "a function of t, eta and g"));
        }
        let program = expression.compile::<T>().map_err(|e| place.error(CaseProblem::Formula(e)))?;
        Ok(FormulaLagrangian::new(program, self.quantities, group.as_ref()).into())
    }
}

/// A text with the values of parameters instead of their names in braces.
pub(super) fn filled(text: &str, parameters: &[(&force::Parameter, Value)]) -> String {
    parameters.iter().fold(text.to_owned(), |filled, (parameter, value)| {
        let value = match value {
            Value::Number(x) => x.to_string(),
            Value::List(x) => list(x),
            Value::Formula(text) => text.clone(),
            Value::Form(_) | Value::Drag(_) | Value::Polynomial(_) => return filled,
        };
        filled.replace(&format!("{{{}}}", parameter.name), &value)
    })
}

/// A vector of space or of the body.
pub(super) fn three_of<T: Real>(values: &[Number], place: &Place) -> Result<Vector<T, 3>, CaseError> {
    vector_of(values, 3, "a vector of space or of the body", place)
}

/// The first three rows and columns of an inertia as the text of a matrix.
fn rotational(inertia: &Inertia) -> String {
    let entry = |r: usize, c: usize| inertia.entry(r, c);
    let row = |r: usize| format!("[{}, {}, {}]", entry(r, 0), entry(r, 1), entry(r, 2));
    format!("[{}, {}, {}]", row(0), row(1), row(2))
}

/// The rotation of a quaternion (w, v) of any length: 1 + 2 (w v̂ + v̂²)/(w² + |v|²).
fn rotation<T: Real>(w: T, v: &Vector<T, 3>) -> Matrix<T, 3> {
    let hat = hat(v);
    Matrix::<T, 3>::identity() + (hat * w + hat * hat) * (T::int(2) / (w * w + v.dot(v)))
}

impl Case {
    /// The attitude of the orientation and the position, whatever the retraction; none where the case has neither.
    pub(super) fn placed<T: Real, const N: usize, const D: usize>(
        &self,
        group: &Option<MatrixGroup<T, N, D>>,
    ) -> Result<Option<Matrix<T, D>>, CaseError> {
        let place = Place::root().key("state");
        let body = body_of(self);
        let mut attitude = Matrix::<T, D>::identity();
        let about = |x: &Vector<T, 3>| ExponentialSo3::new().tau(x);
        let three = |values: &[Number], key: &'static str| -> Result<Vector<T, 3>, CaseError> {
            let place = place.key(key);
            if body.is_none() {
                return Err(
                    place.inapplicable(key, "it is for the algebras so3 and se3; allowed: `attitude`, `matrix`")
                );
            }
            three_of(values, &place)
        };
        let turned = match &self.start.orientation {
            None => None,
            Some(Orientation::RotationVector(x)) => {
                let place = place.key("rotation-vector");
                Some(about(&three(x, "rotation-vector")?).map_err(|e| place.error(e))?)
            }
            Some(Orientation::Quaternion(q)) => {
                let place = place.key("quaternion");
                length(q.len(), 4, "w, x, y, z", &place)?;
                let (w, v) = (number::<T>(&q[0], &place.index(0))?, three(&q[1..], "quaternion")?);
                if w == T::zero() && v.iter().all(|x| *x == T::zero()) {
                    return Err(place.range("0", "a quaternion that is not 0"));
                }
                Some(rotation(w, &v))
            }
            Some(Orientation::Euler { angles, axes }) => {
                let (angles, place) = (three(angles, "euler")?, place.key("axes"));
                let named: Option<Vec<usize>> = axes.chars().map(|axis| "xyz".find(axis)).collect();
                let named = named.as_deref().filter(|axes| axes.windows(2).all(|pair| pair[0] != pair[1]));
                let Some([a, b, c]) = named else {
                    return Err(place.range(
                        format!("{axes:?}"),
                        "three of x, y and z, no two neighbours alike, such as \"zyx\" or \"zxz\"",
                    ));
                };
                let turn =
                    |axis: usize, angle: T| about(&Vector::from_fn(|k, _| if k == axis { angle } else { T::zero() }));
                let turn = |axis: usize, angle: T| turn(axis, angle).map_err(|e| place.error(e));
                Some(turn(*a, angles[0])? * turn(*b, angles[1])? * turn(*c, angles[2])?)
            }
            Some(Orientation::Matrix(rows)) => return self.matrix(rows, group, &place.key("matrix")).map(Some),
        };
        if let Some(turned) = turned {
            (0..3).for_each(|r| (0..3).for_each(|c| attitude[(r, c)] = turned[(r, c)]));
        }
        if let Some(position) = &self.start.position {
            if body != Some(Entry::Se3) {
                return Err(place.key("position").inapplicable("position", "it is for the algebra se3"));
            }
            let position = three(position, "position")?;
            (0..3).for_each(|r| attitude[(r, 3)] = position[r]);
        }
        let given = self.start.orientation.is_some() || self.start.position.is_some();
        Ok(given.then_some(attitude))
    }

    /// The attitude with this matrix; rotations with rounded entries are replaced by the nearest ones.
    fn matrix<T: Real, const N: usize, const D: usize>(
        &self,
        rows: &[Vec<Number>],
        group: &Option<MatrixGroup<T, N, D>>,
        place: &Place,
    ) -> Result<Matrix<T, D>, CaseError> {
        let size = self.matrix_size();
        if group.is_none() || size == 0 {
            return Err(
                place.inapplicable("matrix", "the algebra is given by structure constants alone, without a group")
            );
        }
        let mut attitude = square_of::<T, D>(rows, (size, "the size of the group's matrices"), T::one(), place)?;
        let Structure::Named(entry) = &self.algebra.structure else { return Ok(attitude) };
        let departure = |attitude: &Matrix<T, D>| departure(entry, &|r, c| attitude[(r, c)]).to_f64();
        let before = departure(&attitude);
        if before <= ROUNDED {
            nearest_rotations(entry, &mut attitude);
        }
        // What is no rotation is not corrected.
        if before > ROUNDED || departure(&attitude) > UNCORRECTED {
            let found = format!("not in the group: its equations (gᵀg = 1 for rotations) are violated by {before:.1e}");
            let allowed = format!(
                "an element of the group, with entries of at least three digits (violated by at most {ROUNDED:e})"
            );
            return Err(place.range(found, allowed));
        }
        Ok(attitude)
    }
}
