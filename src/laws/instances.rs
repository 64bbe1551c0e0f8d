//! The groupoids of a case, each in its coordinates, with a fault planted in their structure or none.

use super::planted::groupoid::{ACTION_INVERTED, Flat, Planted, blend_vector};
use super::probe::Probe;
use super::question::{Answer, Measured, Problem};
use crate::algebra::Matrix;
use crate::groupoid::{ActionGroupoid, Arrow, AtiyahGroupoid, DenseGroup, DenseSpace, LieGroupoid, TrivialGroupoid};
use crate::harness::Fault;
use crate::retraction::{CayleySo3, Retraction, RetractionError};
use crate::scalar::{Dual, Real, Scalar};
use crate::system::dispatch::System;
use nalgebra::{DMatrix, DVector};

/// Mixed second derivatives, which brackets of invariant fields need.
pub type Second<T> = Dual<Dual<T>>;

/// The groupoids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupoidKind {
    /// Q×Q for Q = G.
    Pair,
    /// G over a point.
    Point,
    /// G×G×G.
    Gauge,
    /// g*×G×g*.
    Poisson,
    /// (SO(3)×SO(3))/SO(2) over the sphere.
    Sphere,
    /// g*⋊G by the coadjoint action.
    Coadjoint,
    /// g*×g*; not drawn, since few laws know it.
    Momenta,
    /// One that a user brings; not drawn.
    User,
}

impl GroupoidKind {
    /// Four trivial groupoids, and with each another that is drawn with it.
    const DRAWN: [Self; 8] = [
        Self::Pair,
        Self::Point,
        Self::Gauge,
        Self::Poisson,
        Self::Sphere,
        Self::Sphere,
        Self::Coadjoint,
        Self::Coadjoint,
    ];

    /// Two of them, for laws that are too dear for all in each case.
    pub fn two(probe: &mut Probe) -> [Self; 2] {
        let first = probe.integer(0, 3) as usize;
        [Self::DRAWN[first], Self::DRAWN[first + 4]]
    }
}

/// y − x·g of an element of an action groupoid.
type Excess<'a, S> = Box<dyn Fn(&DVector<S>) -> Option<DVector<S>> + 'a>;

/// A groupoid over S with elements to check it on.
pub struct Instance<'a, S: Scalar> {
    /// Which.
    pub kind: GroupoidKind,
    /// The groupoid.
    pub groupoid: Box<Flat<'a, S>>,
    /// g₁, g₂, g₃ with β(g₁) = α(g₂) and β(g₂) = α(g₃).
    pub chain: [DVector<S::Base>; 3],
    /// The product of |U| and |U⁻¹| over the group parts, and of the size of the rest: what rounding is amplified by.
    pub scale: S::Base,
    /// For action groupoids.
    pub excess: Option<Excess<'a, S>>,
}

/// Group elements of a case: what all groupoids over its group are made from.
pub struct Material<T: Real> {
    /// G.
    pub group: DenseGroup<T>,
    /// Seven elements of G.
    pub elements: [DMatrix<T>; 7],
}

impl<T: Real> Material<T> {
    /// Three elements τ(x) of the group of a system and products of two of them.
    ///
    /// # Errors
    /// There is no group, or an element is outside the domain of the retraction.
    pub fn of<const N: usize, const D: usize>(system: &System<T, N, D>, probe: &mut Probe) -> Result<Self, Measured> {
        let none = || Measured::NotApplicable("the algebra has no group".into());
        let group = system.group.as_ref().ok_or_else(none)?;
        let mut element = || match system.retraction.tau(&(probe.vector::<T, N>() * T::half())) {
            Ok(tau) => Ok(DMatrix::from_column_slice(D, D, tau.as_slice())),
            Err(RetractionError::NoGroup { .. }) => Err(none()),
            Err(_) => Err(Measured::NotApplicable("a group element is outside the domain of the retraction".into())),
        };
        let [u, v, w]: [DMatrix<T>; 3] = [element()?, element()?, element()?];
        let [a, b, c, d] = [&u * &v, &v * &w, &w * &u, &u * &w];
        Ok(Self { group: DenseGroup::of(group), elements: [u, v, w, a, b, c, d] })
    }

    /// max(1, |U|) max(1, |U⁻¹|) of an element.
    pub fn size_of(&self, u: &DMatrix<T>) -> T {
        let inverse = self.group.inverse(u).map_or(T::one(), |inverse| inverse.amax());
        u.amax().max(T::one()) * inverse.max(T::one())
    }

    /// One of the groupoids, with a fault or without; `None` when an element is singular.
    pub fn instance<'a, S: Scalar<Base = T> + 'a>(
        &'a self,
        kind: GroupoidKind,
        fault: Option<&'a Fault>,
        probe: &mut Probe,
    ) -> Option<Instance<'a, S>> {
        let (group, n) = (|| self.group.clone(), self.group.dimension());
        let [u, v, w, ends @ ..] = &self.elements;
        let groups = [u, v, w].map(|u| u.map(S::lift));
        let points = |probe: &mut Probe, length: usize| -> [DVector<S>; 4] {
            std::array::from_fn(|_| DVector::from_fn(length, |_, _| probe.unit()))
        };
        let places = || std::array::from_fn(|i| flat(&ends[i].map(S::lift)));
        let middles = || groups.each_ref().map(flat);
        let none = || std::array::from_fn(|_| DVector::zeros(0));
        let mut scale = [u, v, w].iter().fold(T::one(), |size, u| size * self.size_of(u));
        let mut excess: Option<Excess<'a, S>> = None;
        let (groupoid, chain): (Box<Flat<'a, S>>, _) = match kind {
            GroupoidKind::Pair => {
                (Box::new(Planted::new(TrivialGroupoid::pairs(group()), fault)), chain_of(&places(), &none()))
            }
            GroupoidKind::Momenta => {
                scale = T::one();
                let pairs = TrivialGroupoid::pairs(DenseSpace { dimension: n });
                (Box::new(Planted::new(pairs, fault)), chain_of(&points(probe, n), &none()))
            }
            GroupoidKind::Point => {
                let ends = std::array::from_fn(|_| DVector::zeros(0));
                (Box::new(Planted::new(TrivialGroupoid::point(group()), fault)), chain_of(&ends, &middles()))
            }
            GroupoidKind::Gauge => {
                scale = ends.iter().fold(scale, |size, u| size * self.size_of(u));
                (Box::new(Planted::new(TrivialGroupoid::gauge(group()), fault)), chain_of(&places(), &middles()))
            }
            GroupoidKind::Poisson => {
                let ends = points(probe, n);
                (Box::new(Planted::new(TrivialGroupoid::poisson(group()), fault)), chain_of(&ends, &middles()))
            }
            GroupoidKind::Sphere => {
                let [a, b, b1, c, c1, d] = rotations::<T, 6>(probe).ok()?.map(|turn| turn.map(S::lift));
                let q = AtiyahGroupoid::<S>::new();
                // Other representatives over the same points: b·k and c·k.
                let turned = |p: &Matrix<S, 3>, k: &Matrix<S, 3>| p * AtiyahGroupoid::divide(&Matrix::identity(), k);
                let chain = [(a, b), (turned(&b, &b1), c), (turned(&c, &c1), d)].map(|g| q.coordinates(&g));
                let unmatched = move |g: &_, h: &_| q.coordinates(&(q.element(g).0, q.element(h).1));
                scale = T::one();
                let mut planted = Planted::new(q, fault);
                planted.unmatched = Some(Box::new(unmatched));
                (Box::new(planted), chain)
            }
            GroupoidKind::Coadjoint => {
                let size = ACTION_INVERTED.size_in(fault);
                // Part of it with g inverted.
                let act = move |x: &DVector<S>, g: &DMatrix<S>| {
                    let right = self.group.coadjoint(g, x)?;
                    if size == 0.0 {
                        return Some(right);
                    }
                    Some(blend_vector(&right, &self.group.coadjoint(&self.group.inverse(g)?, x)?, size))
                };
                let q = ActionGroupoid::<S>::new(group());
                let arrow = |x: &DVector<S>, g| Some(Arrow { target: act(x, g)?, ..q.arrow(x, g)? });
                let [x, ..] = points(probe, n);
                let one = arrow(&x, &groups[0])?;
                let two = arrow(&one.target, &groups[1])?;
                let three = arrow(&two.target, &groups[2])?;
                let chain = [&one, &two, &three].map(|g| q.coordinates(g));
                let other = q.clone();
                excess = Some(Box::new(move |z| {
                    let g = other.element(z);
                    Some(&g.target - act(&g.source, &g.group)?)
                }));
                let (other, mut planted) = (q.clone(), Planted::new(q, fault));
                if size > 0.0 {
                    planted.near_unit = Some(Box::new(move |x, a| {
                        let right = other.near_unit(x, a);
                        let target = act(x, &right.group).unwrap_or_else(|| right.target.clone());
                        other.coordinates(&Arrow { target, ..right })
                    }));
                }
                (Box::new(planted), chain)
            }
            GroupoidKind::User => return None,
        };
        let chain = chain.map(|g| g.map(|v| v.base()));
        let largest = chain.iter().fold(T::one(), |size, g| size.max(g.amax()));
        Some(Instance { kind, groupoid, chain, scale: scale * largest, excess })
    }
}

/// Random rotations.
pub fn rotations<T: Real, const K: usize>(probe: &mut Probe) -> Result<[Matrix<T, 3>; K], RetractionError> {
    let mut rotations = [Matrix::identity(); K];
    for rotation in &mut rotations {
        *rotation = CayleySo3::<T>::new().tau(&(probe.vector::<T, 3>() * T::int(2)))?;
    }
    Ok(rotations)
}

fn flat<S: Scalar>(matrix: &DMatrix<S>) -> DVector<S> {
    DVector::from_column_slice(matrix.as_slice())
}

/// (x₀, u, x₁), (x₁, v, x₂), (x₂, w, x₃).
fn chain_of<S: Scalar>(ends: &[DVector<S>; 4], groups: &[DVector<S>; 3]) -> [DVector<S>; 3] {
    std::array::from_fn(|k| {
        let parts = [&ends[k], &groups[k], &ends[k + 1]];
        let entries: Vec<&[S]> = parts.iter().map(|part| part.as_slice()).collect();
        DVector::from_vec(entries.concat())
    })
}

/// z over S.
pub fn lifted<S: Scalar>(z: &DVector<S::Base>) -> DVector<S> {
    z.map(S::lift)
}

/// A quadratic map c + p (k·x) + q (k·x)(m·x) with random coefficients: a section in a frame, or a function.
#[derive(Clone, Debug)]
pub struct CoordinatePolynomial<T: Real> {
    coefficients: [DVector<T>; 3],
    forms: [DVector<T>; 2],
}

impl<T: Real> CoordinatePolynomial<T> {
    /// From ℝ^`from` to ℝ^`to`; k·x and m·x are about 1 for x of entries about 1.
    pub fn new(probe: &mut Probe, from: usize, to: usize) -> Self {
        let scale = 2f64.powi(-((from.max(1) as f64).log2() / 2.0).ceil() as i32);
        let mut vector = |length, scale| DVector::from_fn(length, |_, _| probe.unit::<T>() * T::exact(scale));
        let coefficients = std::array::from_fn(|_| vector(to, 1.0));
        Self { coefficients, forms: std::array::from_fn(|_| vector(from, scale)) }
    }

    /// Its value.
    pub fn at<S: Scalar<Base = T>>(&self, x: &DVector<S>) -> DVector<S> {
        let form = |k: usize| {
            let terms = self.forms[k].iter().zip(x.iter());
            terms.fold(S::zero(), |sum, (c, x)| sum + S::lift(*c) * *x)
        };
        let (one, two) = (form(0), form(1));
        let [c, p, q] = &self.coefficients;
        DVector::from_fn(c.len(), |i, _| S::lift(c[i]) + S::lift(p[i]) * one + S::lift(q[i]) * one * two)
    }
}

/// What is measured on a groupoid of a case, and on two that are drawn if it is none.
///
/// # Errors
/// Those of [`Material::of`].
pub fn judged<T: Real, const N: usize, const D: usize>(
    Problem { system, mut probe, .. }: Problem<'_, T, N, D>,
    kind: Option<GroupoidKind>,
    judge: impl Fn(&Material<T>, GroupoidKind, &mut Probe) -> Option<Measured>,
) -> Answer {
    let material = Material::of(system, &mut probe)?;
    let two = GroupoidKind::two(&mut probe);
    let mut measured = Measured::NotApplicable("no groupoid".into());
    for kind in kind.as_ref().map_or(&two[..], std::slice::from_ref) {
        let singular = || Measured::Broken(format!("{kind:?}: an element is singular"));
        measured = measured.and(judge(&material, *kind, &mut probe).unwrap_or_else(singular));
    }
    Ok(measured)
}

/// A law that asks a question about some of the groupoids of a case.
macro_rules! groupoid_law {
    ($about:expr, $question:expr) => {
        CaseLaw {
            about: About { needs: "a group", ..$about },
            cases: |cases| cases.with_group(),
            check: |case, fault| ask(case, fault, $question, Precisions::Both),
        }
    };
}

pub(super) use groupoid_law;
