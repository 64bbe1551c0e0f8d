//! Laws of invariant vector fields and of Lie algebroids: of any Lie groupoid, and here on two groupoids of each case.

use super::groupoid::axiom;
use super::instances::{CoordinatePolynomial, Instance, Second, groupoid_law, judged, lifted};
use super::planted::groupoid::{
    ACTION_INVERTED, ANCHOR_SIGN, ENDS_KEPT, Flat, INVERSE_KEEPS_U, PRODUCT_KEEPS_END, SECOND_INVERTED, STRUCTURE_SIGN,
    blend_vector,
};
use super::probe::{Probe, stream};
use super::question::{Answer, Measured, Precisions, Problem, Question, ask};
use super::{CaseLaw, Source};
use crate::groupoid::calculus::{along, constant, derivatives, infinitesimal, values};
use crate::groupoid::{LieAlgebroid, Lowered, Tangent, bracket_of_fields, section_bracket};
use crate::harness::{About, Fault};
use crate::scalar::{Dual, Real, max_abs};
use nalgebra::DVector;

const BOUND: &str = "two precisions; floor 2⁶ m u relative to the terms, m the number of coordinates of an element";
const LEFT_AT_SOURCE: Fault = Fault::new(
    "left-field-at-source",
    "X←(g) with the value of X at α(g) instead of β(g)",
    "groupoids over more than a point",
);
const RIGHT_SIGN: Fault =
    Fault::new("right-field-sign", "X→(g) = +T(R_g ι) X(α(g)), without the sign of (4.3)", "every groupoid");
const NO_DERIVATIVES: Fault = Fault::new(
    "bracket-no-derivatives",
    "⟦X, Y⟧ without ρ(X)(Y) − ρ(Y)(X), as if sections were constant",
    "anchors other than 0",
);

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            groupoid_law!(FIELDS, Named(FIELDS.name)),
            groupoid_law!(BRACKET, Named(BRACKET.name)),
            groupoid_law!(
                About { faults: &[ANCHOR_SIGN, STRUCTURE_SIGN, NO_DERIVATIVES, ACTION_INVERTED], ..ANCHOR },
                Named(ANCHOR.name)
            ),
            groupoid_law!(
                About { faults: &[RIGHT_SIGN, STRUCTURE_SIGN, ANCHOR_SIGN, NO_DERIVATIVES, ACTION_INVERTED], ..RIGHT },
                Named(RIGHT.name)
            ),
            groupoid_law!(INVERSION, Named(INVERSION.name)),
        ]
    }
}

/// What the laws on Lie groupoids have in common.
pub(super) const LAW: About = About { source: "", oracle: "", bound: BOUND, ..axiom("", "", &[]) };

/// Definition 4.3.
pub(super) const FIELDS: About = About {
    name: "invariant-fields",
    statement: "Tα X← = 0, Tβ X→ = 0, X←(gh) = T L_g X←(h), X→(gh) = T R_h X→(g), [X←, Y→] = 0",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Def 4.3, (4.1) and (4.3)",
    oracle: "random quadratic sections, the invariant fields and their derivatives on dual numbers through the structure maps of the \
             groupoid",
    faults: &[LEFT_AT_SOURCE, SECOND_INVERTED, PRODUCT_KEEPS_END],
    ..LAW
};

/// The bracket of (4.2).
pub(super) const BRACKET: About = About {
    name: "algebroid-bracket",
    statement: "[X←, Y←] = ⟦X, Y⟧← off the units, ⟦X, Y⟧ in closed form; ⟦X, Y⟧ = −⟦Y, X⟧; Jacobi",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Defs 4.4 and 4.5, (4.2)",
    oracle: "the commutator of the invariant fields by duals, against structure constants and anchor in closed form",
    faults: &[STRUCTURE_SIGN, ANCHOR_SIGN, NO_DERIVATIVES, LEFT_AT_SOURCE, SECOND_INVERTED],
    ..LAW
};

/// The anchor of (4.2).
pub(super) const ANCHOR: About = About {
    name: "algebroid-anchor",
    statement: "ρ = Tβ on the fibres of AG, ρ⟦X, Y⟧ = [ρX, ρY], ⟦X, fY⟧ = f⟦X, Y⟧ + ρ(X)(f) Y",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Defs 4.4 and 4.5, (4.2)",
    oracle: "Tβ and the commutator of vector fields on the base by duals; ⟦X, fY⟧ from the commutator of invariant fields",
    faults: &[ANCHOR_SIGN, STRUCTURE_SIGN, NO_DERIVATIVES],
    ..LAW
};

/// Right-invariant fields.
pub(super) const RIGHT: About = About {
    name: "algebroid-right-fields",
    statement: "⟦X, Y⟧→ = −[X→, Y→]",
    source: "Martín de Diego and Sato Martín de Almagro 2019, §4.1, after (4.3)",
    oracle: "the commutator of the right-invariant fields by duals, against the bracket in closed form",
    faults: &[RIGHT_SIGN, STRUCTURE_SIGN, ANCHOR_SIGN, NO_DERIVATIVES],
    ..LAW
};

/// Proposition 4.6.
pub(super) const INVERSION: About = About {
    name: "inversion-invariant-field",
    statement: "Z = W + ι_*W has Tι Z(g) = Z(g⁻¹) and is tangent to the units there, for random W; so is X← − X→",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 4.6",
    oracle: "Z against Tε Tα Z, by duals of ι, α and ε",
    faults: &[INVERSE_KEEPS_U, ENDS_KEPT, RIGHT_SIGN],
    ..LAW
};

/// The law of a name, asked of one groupoid.
#[derive(Clone, Copy)]
struct Named(&'static str);

type Point<T> = DVector<Dual<T>>;

/// The invariant fields of sections of a groupoid, over duals; faults may be planted in them.
#[derive(Clone, Copy)]
struct Fields<'a, T: Real> {
    instance: &'a Instance<'a, Second<T>>,
    fault: Option<&'a Fault>,
}

impl<'a, T: Real> Fields<'a, T> {
    fn groupoid(&self) -> &'a Flat<'a, Second<T>> {
        self.instance.groupoid.as_ref()
    }

    /// X←(g).
    fn left(&self, section: &dyn Fn(&Point<T>) -> Point<T>, g: &Point<T>) -> Option<Point<T>> {
        let source = || values(&self.groupoid().source(&constant(g)));
        let wrong = LEFT_AT_SOURCE.size_in(self.fault);
        let value = |y: &Point<T>| {
            if wrong > 0.0 { blend_vector(&section(y), &section(&source()), wrong) } else { section(y) }
        };
        self.groupoid().left_field(value, g)
    }

    /// X→(g).
    fn right(&self, section: &dyn Fn(&Point<T>) -> Point<T>, g: &Point<T>) -> Option<Point<T>> {
        let right = self.groupoid().right_field(section, g)?;
        Some(blend_vector(&right, &-&right, RIGHT_SIGN.size_in(self.fault)))
    }

    /// ⟦X, Y⟧(x) in closed form, over duals.
    fn bracket(&self, x: &CoordinatePolynomial<T>, y: &CoordinatePolynomial<T>, at: &Point<T>) -> Point<T> {
        let algebroid = Lowered(self.groupoid());
        let right = section_bracket(&algebroid, &|z| x.at(z), &|z| y.at(z), at);
        match NO_DERIVATIVES.size_in(self.fault) {
            0.0 => right,
            size => blend_vector(&right, &algebroid.structure(at, &x.at(at), &y.at(at)), size),
        }
    }
}

/// DY·X and DX·Y at g, with X(g) and Y(g): the terms of a commutator.
fn crossed<T: Real>(
    x: &dyn Fn(&Point<T>) -> Option<Point<T>>,
    y: &dyn Fn(&Point<T>) -> Option<Point<T>>,
    g: &DVector<T>,
) -> Option<[DVector<T>; 2]> {
    let (at_x, at_y) = (values(&x(&constant(g))?), values(&y(&constant(g))?));
    Some([derivatives(&y(&along(g, &at_x))?), derivatives(&x(&along(g, &at_y))?)])
}

impl Question for Named {
    const STREAM: Option<u64> = Some(stream::GROUPOID);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let fault = problem.fault;
        judged(problem, None, |material, kind, probe| {
            let instance = material.instance::<Second<T>>(kind, fault, probe)?;
            Some(judge(&instance, self.0, fault, probe))
        })
    }
}

/// Defects of the parts of one law on one groupoid, for three random sections.
struct Judge<'a, T: Real> {
    fields: Fields<'a, T>,
    sections: &'a [CoordinatePolynomial<T>; 3],
    measured: Measured,
}

/// The verdict on one groupoid.
pub(super) fn judge<T: Real>(
    instance: &Instance<'_, Second<T>>,
    law: &str,
    fault: Option<&Fault>,
    probe: &mut Probe,
) -> Measured {
    let q = instance.groupoid.as_ref();
    let base = q.source(&lifted(&instance.chain[0])).len();
    let mut section = || CoordinatePolynomial::<T>::new(probe, base, q.rank());
    let sections = &[section(), section(), section()];
    let measured = Measured::NotApplicable("nothing to compare".into());
    let mut judge = Judge { fields: Fields { instance, fault }, sections, measured };
    let done = match law {
        "invariant-fields" => judge.invariance(),
        "algebroid-bracket" => judge.bracket(),
        "algebroid-anchor" => judge.anchor(probe),
        "algebroid-right-fields" => judge.right(),
        "inversion-invariant-field" => judge.inversion(probe),
        other => return Measured::Broken(format!("there is no law `{other}` of Lie groupoids")),
    };
    match done {
        Some(()) => judge.measured,
        None => Measured::Broken(format!("{:?}: a product or an inverse does not exist", instance.kind)),
    }
}

impl<T: Real> Judge<'_, T> {
    /// a = b, as vectors of which the terms are of size `terms`.
    fn equal(&mut self, what: &str, a: &DVector<T>, b: &DVector<T>, terms: &[&DVector<T>]) {
        let largest = terms.iter().fold(T::one(), |size, term| size.max(term.amax()));
        if a.is_empty() {
            return;
        }
        let floor = 64.0 * self.fields.instance.chain[0].len().max(4) as f64;
        let kind = self.fields.instance.kind;
        let judged = Measured::defect(max_abs(&(a - b)), largest * self.fields.instance.scale, floor, || {
            format!("{kind:?}: {what}")
        });
        self.measured = std::mem::replace(&mut self.measured, Measured::NotApplicable(String::new())).and(judged);
    }

    fn invariance(&mut self) -> Option<()> {
        let (fields, [x, y, _]) = (self.fields, self.sections);
        let q = fields.groupoid();
        let [g, h, _] = fields.instance.chain.each_ref().map(constant);
        let gh = values(&q.compose(&constant(&g), &constant(&h)).ok()?);
        let (left_h, right_g) = (fields.left(&|z| x.at(z), &h)?, fields.right(&|z| y.at(z), &g)?);
        let zero = DVector::zeros(0);
        let small = |v: &Point<T>| (v.map(|v| v.re), DVector::zeros(v.len()));
        let (down, none) = small(&q.push_source(&h, &left_h));
        self.equal("Tα X← = 0", &down, &none, &[&values(&left_h)]);
        let (down, none) = small(&q.push_target(&g, &right_g));
        self.equal("Tβ X→ = 0", &down, &none, &[&values(&right_g)]);
        let (there, pushed) = (values(&fields.left(&|z| x.at(z), &gh)?), values(&q.push_left(&g, &h, &left_h)?));
        self.equal("X←(gh) = T L_g X←(h)", &there, &pushed, &[&there]);
        let (there, pushed) = (values(&fields.right(&|z| y.at(z), &gh)?), values(&q.push_right(&h, &g, &right_g)?));
        self.equal("X→(gh) = T R_h X→(g)", &there, &pushed, &[&there]);
        let g = &fields.instance.chain[0];
        let [one, two] = crossed(&|g| fields.left(&|z| x.at(z), g), &|g| fields.right(&|z| y.at(z), g), g)?;
        self.equal("[X←, Y→] = 0", &one, &two, &[&one, &two, &zero]);
        Some(())
    }

    fn bracket(&mut self) -> Option<()> {
        let (fields, [x, y, z]) = (self.fields, self.sections);
        let q = fields.groupoid();
        let g = &fields.instance.chain[0];
        let [one, two] = crossed(&|g| fields.left(&|p| x.at(p), g), &|g| fields.left(&|p| y.at(p), g), g)?;
        let closed = values(&fields.left(&|p| fields.bracket(x, y, p), &constant(g))?);
        self.equal("[X←, Y←] = ⟦X, Y⟧←", &(&one - &two), &closed, &[&one, &two]);
        let at = values(&values(&q.source(&lifted(g))));
        let point = constant(&at);
        let (forth, back) = (values(&fields.bracket(x, y, &point)), values(&fields.bracket(y, x, &point)));
        self.equal("⟦X, Y⟧ = −⟦Y, X⟧", &forth, &-&back, &[&forth]);
        let algebroid = Lowered(q);
        let lower = Lowered(&algebroid);
        let nested = |a: &CoordinatePolynomial<T>, b: &CoordinatePolynomial<T>, c: &CoordinatePolynomial<T>| {
            section_bracket(&lower, &|p| a.at(p), &|p| fields.bracket(b, c, p), &at)
        };
        let (one, two, three) = (nested(x, y, z), nested(y, z, x), nested(z, x, y));
        self.equal("Jacobi", &(&one + &two), &-&three, &[&one, &two, &three]);
        Some(())
    }

    fn anchor(&mut self, probe: &mut Probe) -> Option<()> {
        let (fields, [x, y, _]) = (self.fields, self.sections);
        let q = fields.groupoid();
        let at = values(&values(&q.target(&lifted(&fields.instance.chain[0]))));
        let point = constant(&at);
        let algebroid = Lowered(q);
        let unit = values(&q.unit(&constant(&point)));
        let a = x.at(&point);
        let closed = values(&algebroid.anchor(&point, &a));
        let by_definition = values(&q.push_target(&unit, &q.at_unit(&point, &a)));
        self.equal("ρ = Tβ", &closed, &by_definition, &[&closed]);
        let of_bracket = values(&algebroid.anchor(&point, &fields.bracket(x, y, &point)));
        let field = |section: &CoordinatePolynomial<T>, z: &Point<T>| Some(algebroid.anchor(z, &section.at(z)));
        let [one, two] = crossed(&|z| field(x, z), &|z| field(y, z), &at)?;
        self.equal("ρ⟦X, Y⟧ = [ρX, ρY]", &of_bracket, &(&one - &two), &[&one, &two]);
        let f = CoordinatePolynomial::<T>::new(probe, at.len(), 1);
        let scaled = |z: &Point<T>| y.at(z) * f.at(z)[0];
        let by_fields = bracket_of_fields(q, &|z| x.at(z), &scaled, &at)?;
        let value = f.at(&at)[0];
        let slope = f.at(&along(&at, &closed))[0].eps;
        let plain = values(&fields.bracket(x, y, &point)) * value;
        let other = y.at(&at) * slope;
        self.equal("⟦X, fY⟧ = f⟦X, Y⟧ + ρ(X)(f) Y", &by_fields, &(&plain + &other), &[&plain, &other]);
        Some(())
    }

    fn right(&mut self) -> Option<()> {
        let (fields, [x, y, _]) = (self.fields, self.sections);
        let g = &fields.instance.chain[0];
        let [one, two] = crossed(&|g| fields.right(&|p| x.at(p), g), &|g| fields.right(&|p| y.at(p), g), g)?;
        let closed = values(&fields.right(&|p| fields.bracket(x, y, p), &constant(g))?);
        self.equal("⟦X, Y⟧→ = −[X→, Y→]", &closed, &(&two - &one), &[&one, &two]);
        Some(())
    }

    fn inversion(&mut self, probe: &mut Probe) -> Option<()> {
        let (fields, [x, y, _]) = (self.fields, self.sections);
        let q = fields.groupoid();
        // Z = W + ι_*W with W = X← + Y→, at g and at g⁻¹.
        let field = |g: &Point<T>| -> Option<Point<T>> {
            let w = |g: &Point<T>| Some(fields.left(&|p| x.at(p), g)? + fields.right(&|p| y.at(p), g)?);
            let inverse = values(&q.inverse(&constant(g))?);
            Some(w(g)? + q.push_inverse(&inverse, &w(&inverse)?)?)
        };
        let g = constant(&fields.instance.chain[0]);
        let inverse = values(&q.inverse(&constant(&g))?);
        let (moved, there) = (values(&q.push_inverse(&g, &field(&g)?)?), values(&field(&inverse)?));
        self.equal("Tι Z(g) = Z(g⁻¹)", &moved, &there, &[&moved, &there]);
        // At a unit, with any W there is.
        let at = q.target(&constant(&g));
        let (v, a) = (random(probe, q.base_dimension()), random(probe, q.rank()));
        let element = q.near_unit(&q.near_point(&at, &infinitesimal(&v)), &infinitesimal(&a));
        let w = derivatives(&element);
        let unit = values(&q.unit(&at));
        let z = &w + q.push_inverse(&unit, &w)?;
        let point = values(&at);
        let projected = |z: &Point<T>| values(&q.push_unit(&point, &q.push_source(&unit, z)));
        self.equal("Z is tangent to the units", &values(&z), &projected(&z), &[&values(&z), &values(&w)]);
        let difference = fields.left(&|p| x.at(p), &unit)? - fields.right(&|p| x.at(p), &unit)?;
        let size = values(&difference);
        self.equal("X← − X→ is tangent to the units", &size, &projected(&difference), &[&size]);
        Some(())
    }
}

fn random<T: Real>(probe: &mut Probe, length: usize) -> Point<T> {
    DVector::from_fn(length, |_, _| probe.unit())
}
