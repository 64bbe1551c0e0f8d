//! Laws of groupoids: the axioms of Definition 4.1 on G×G×G ⇉ G and on g*×G×g* ⇉ g*.

use super::CaseLaw;
use super::precision::{Measured, settle};
use super::probe::Probe;
use crate::algebra::{Covector, Matrix};
use crate::group::{LieGroup, MatrixGroup};
use crate::groupoid::{Arrow, Axiom, GaugeGroupoid, Groupoid, PoissonGroupoid};
use crate::harness::{Cost, Fault};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::Real;
use crate::system::{Case, System, Visitor, cases};
use proptest::strategy::Strategy;

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, Def 4.1 and §4.3";
const BOUND: &str = "two precisions; floor 2⁵ D u times the sizes of the group elements";
const FAULTS: &[Fault] = &[
    Fault::new(
        "inverse-keeps-u",
        "ι(λ, U, μ) = (μ, U, λ), without the inverse of U (as printed in (4.4))",
        "every group, U ≠ U⁻¹",
    ),
    // (λ, VU, κ) is none: it is the groupoid of the opposite group.
    Fault::new("second-inverted", "(λ, U, μ)(μ, V, κ) = (λ, UV⁻¹, κ)", "every group"),
    Fault::new("ends-kept", "ι(λ, U, μ) = (λ, U⁻¹, μ)", "every group"),
];

/// The laws of this file.
pub const LAWS: &[CaseLaw] = &[
    CaseLaw {
        name: "groupoid-gauge",
        statement: "the groupoid axioms on G×G×G: (V,U,W)(W,U',X) = (V,UU',X), ι(V,U,W) = (W,U⁻¹,V)",
        source: SOURCE,
        oracle: "the axioms",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: FAULTS,
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, fault, Check { case, fault, poisson: false }),
    },
    CaseLaw {
        name: "groupoid-poisson",
        statement: "the groupoid axioms on g*×G×g*: (λ,U,μ)(μ,V,κ) = (λ,UV,κ), ι(λ,U,μ) = (μ,U⁻¹,λ)",
        source: SOURCE,
        oracle: "the axioms",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: FAULTS,
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, fault, Check { case, fault, poisson: true }),
    },
];

/// A groupoid of arrows with a fault planted in it.
struct Planted<'a, G> {
    groupoid: G,
    fault: Option<&'a Fault>,
}

impl<B, U, G> Groupoid for Planted<'_, G>
where
    B: Clone + std::fmt::Debug + PartialEq,
    U: Clone + std::fmt::Debug,
    G: Groupoid<Element = Arrow<B, U>, Base = B>,
{
    type Element = Arrow<B, U>;
    type Base = B;

    fn source(&self, g: &Arrow<B, U>) -> B {
        self.groupoid.source(g)
    }

    fn target(&self, g: &Arrow<B, U>) -> B {
        self.groupoid.target(g)
    }

    fn unit(&self, x: &B) -> Arrow<B, U> {
        self.groupoid.unit(x)
    }

    fn inverse(&self, g: &Arrow<B, U>) -> Option<Arrow<B, U>> {
        let inverse = self.groupoid.inverse(g)?;
        Some(match self.fault.map(|fault| fault.name) {
            Some("inverse-keeps-u") => Arrow { group: g.group.clone(), ..inverse },
            Some("ends-kept") => Arrow { source: inverse.target, target: inverse.source, ..inverse },
            _ => inverse,
        })
    }

    fn product(&self, first: &Arrow<B, U>, second: &Arrow<B, U>) -> Arrow<B, U> {
        match self.groupoid.inverse(second) {
            Some(inverse) if Fault::planted(self.fault, "second-inverted") => {
                self.groupoid.product(first, &Arrow { group: inverse.group, ..second.clone() })
            }
            _ => self.groupoid.product(first, second),
        }
    }
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a Case,
    fault: Option<&'a Fault>,
    poisson: bool,
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>>(self, system: System<T, N, D, R>) -> Measured {
        let Some(group) = &system.group else {
            return Measured::NotApplicable("the algebra has no group".into());
        };
        match self.axioms(group, &system.retraction) {
            Ok(measured) => measured,
            Err(RetractionError::NoGroup { .. }) => Measured::NotApplicable("the algebra has no group".into()),
            Err(_) => Measured::NotApplicable("a group element is outside the domain of the retraction".into()),
        }
    }
}

impl Check<'_> {
    fn axioms<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>>(
        &self,
        group: &MatrixGroup<T, N, D>,
        retraction: &R,
    ) -> Result<Measured, RetractionError> {
        let mut probe = Probe::new(self.case, 2);
        let mut element = || retraction.tau(&(probe.vector::<T, N>() * T::half()));
        let [u, v, w] = [element()?, element()?, element()?];
        if self.poisson {
            let mut point = || probe.covector::<T, N>();
            let ends: [Covector<T, N>; 4] = [point(), point(), point(), point()];
            let groupoid = PoissonGroupoid::<_, T, N, D>::new(group);
            Ok(self.judge(groupoid, ends, [u, v, w], group))
        } else {
            let ends: [Matrix<T, D>; 4] = [element()?, element()?, element()?, element()?];
            let groupoid = GaugeGroupoid::<_, T, N, D>::new(group);
            Ok(self.judge(groupoid, ends, [u, v, w], group))
        }
    }

    fn judge<T: Real, B, G, const N: usize, const D: usize>(
        &self,
        groupoid: G,
        ends: [B; 4],
        elements: [Matrix<T, D>; 3],
        group: &MatrixGroup<T, N, D>,
    ) -> Measured
    where
        B: Clone + std::fmt::Debug + PartialEq,
        G: Groupoid<Element = Arrow<B, Matrix<T, D>>, Base = B>,
    {
        let size = elements.iter().fold(T::one(), |size, u| {
            let inverse = group.inverse(u).map_or(T::one(), |inverse| inverse.amax());
            size * u.amax().max(T::one()) * inverse.max(T::one())
        });
        let [u, v, w] = elements;
        let [a, b, c, d] = ends;
        let chain = [
            Arrow { source: a, group: u, target: b.clone() },
            Arrow { source: b, group: v, target: c.clone() },
            Arrow { source: c, group: w, target: d },
        ];
        let planted = Planted { groupoid, fault: self.fault };
        let distance = |g: &Arrow<B, Matrix<T, D>>, h: &Arrow<B, Matrix<T, D>>| {
            if g.source != h.source || g.target != h.target {
                return f64::INFINITY;
            }
            // In units of u already here: the subtraction is done in T.
            (group.distance(&g.group, &h.group) / (size * T::unit_roundoff())).to_f64()
        };
        Axiom::ALL
            .into_iter()
            .map(|axiom| Measured::Defect {
                amplification: axiom.defect(&planted, [&chain[0], &chain[1], &chain[2]], distance),
                floor: 32.0 * D as f64,
                witness: axiom.statement().into(),
            })
            .reduce(Measured::and)
            .unwrap_or(Measured::Broken("there are no axioms".into()))
    }
}
