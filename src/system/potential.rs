//! The potentials, each described once: its formula, its name, its parameters and what they are, where it is drawn and how often, its form in
//! lanes. What follows from the [`Role`] of a parameter is the same as for [forces](super::force).

use super::case::Case;
use super::error::Place;
use super::force::{Domain, Mut, Parameter, Role, Value, terms};
use super::scope::{filled, three_of};
use super::shares::Share;
use crate::integrators::lanes::Term;
use crate::scalar::Number;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A kind of potential.
#[derive(Debug)]
pub(crate) struct PotentialKind {
    /// The name in files.
    pub name: &'static str,
    /// In the order of files.
    pub parameters: &'static [Parameter],
    /// Its formula, with the names of parameters in braces.
    pub formula: &'static str,
    /// Of the formula.
    pub domain: Domain,
    /// As it is printed, in the same way.
    shown: &'static str,
    /// One of this kind with all parameters 0.
    zero: fn() -> Potential,
}

/// What most kinds have in common.
const USUAL: PotentialKind = PotentialKind {
    name: "",
    parameters: &[],
    formula: "{value}",
    domain: Domain::Body,
    shown: "{value}",
    zero: || Potential::Formula { value: String::new() },
};

fn three(values: &[Number]) -> Option<[f64; 3]> {
    three_of(values, &Place::root()).ok().map(Into::into)
}

macro_rules! lanes {
    ($({ $($of:tt)* } [$($field:ident as $role:ident)*] { $made:expr })*) => {
        impl Potential {
            /// As a term in lanes on SO(3) or SE(3), if it has such a form.
            fn term<const N: usize>(&self) -> Option<Term<N>> {
                match self {
                    $($($of)* => {
                        let _ = ($($field,)*);
                        $made
                    })*
                }
            }
        }
    };
}

terms! {
    /// A potential V(t, g). The kinds but `Formula` are for so(3) and se(3), with rotation R (body to space) and position x.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
    #[non_exhaustive]
    enum Potential;
    #[derive(Clone, Copy)]
    enum Kind;
    /// The shares of potentials where all kinds are asked for ([`Cases::potentials`](super::Cases::potentials)). Of the half on bodies two in
    /// five have two terms; the gradient of gravity needs the standard basis. Of the other half those with a group have a formula every second
    /// time.
    POTENTIAL_SHARES of "potential";
    PotentialKind, lanes;

    /// A formula in t and g.
    Formula {
        { value: String as Formula "Its text." }
        is { name: "formula", domain: Domain::Any };
        share 23.0, 25.0;
        makes None
    }

    /// A weight w at the point r of the body: V = w ⟨e₃, R r + x⟩.
    Gravity {
        {
            weight: Number as Weight "w, mass times the acceleration of gravity.",
            center: Vec<Number> as Vector "r.",
        }
        is {
            name: "gravity",
            shown: "gravity {weight} at {center}",
            formula: "({weight})*(dot(row(R, 3), {center}){above})",
        };
        share 17.7, 19.7;
        makes Some(Term::Gravity(weight.eval().ok()?, three(center)?))
    }

    /// A lift w at the point r of the body: V = −w ⟨e₃, R r + x⟩.
    Buoyancy {
        {
            lift: Number as Weight "w.",
            center: Vec<Number> as Vector "r.",
        }
        is {
            name: "buoyancy",
            shown: "buoyancy {lift} at {center}",
            formula: "-({lift})*(dot(row(R, 3), {center}){above})",
        };
        share 17.7, 19.7;
        makes Some(Term::Gravity(-lift.eval::<f64>().ok()?, three(center)?))
    }

    /// A moment m of the body in a uniform field B of space, magnetic or electric: V = −⟨R m, B⟩.
    UniformField {
        {
            moment: Vec<Number> as Amplitude "m.",
            field: Vec<Number> as Vector "B.",
        }
        is {
            name: "uniform-field",
            shown: "moment {moment} in the field {field}",
            formula: "-dot({field}, R*{moment})",
        };
        share 17.7, 19.7;
        makes Some(Term::UniformField(three(moment)?, three(field)?))
    }

    /// The gradient of gravity on a circular orbit about the third axis with mean motion n: V = (3/2) n² ⟨o, R I Rᵀ o⟩ with the direction
    /// o = (cos nt, sin nt, 0) and the rotational inertia I, up to a constant (Hughes 1986, Spacecraft Attitude Dynamics, chapter 8).
    GravityGradient {
        { rate: Number as Rate "n." }
        is {
            name: "gravity-gradient", domain: Domain::StandardBody,
            shown: "gravity gradient with n = {rate}",
            formula: "3/2*({rate})^2*dot([cos(({rate})*t), sin(({rate})*t), 0]*R, {inertia}*([cos(({rate})*t), sin(({rate})*t), 0]*R))",
        };
        share 7.1, 9.1;
        makes None
    }
}

impl Potential {
    /// The kinds, as in files.
    pub const KINDS: [&'static str; Kind::ALL.len()] = Kind::NAMES;

    /// V/2; of a gradient of gravity less.
    pub(super) fn halve(&mut self, half: impl Fn(&Number) -> Number) {
        self.scale(|x| *x = half(x));
        if let Self::Formula { value } = self {
            *value = format!("({value})/2");
        }
    }
}

impl fmt::Display for Potential {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&filled(self.description().shown, &self.parameters().collect::<Vec<_>>()))
    }
}

impl Case {
    /// The potentials as terms in lanes on SO(3) or SE(3); `None` where one of them has no such form.
    pub(crate) fn loads<const N: usize>(&self) -> Option<Vec<Term<N>>> {
        self.potentials.iter().map(Potential::term).collect()
    }
}
