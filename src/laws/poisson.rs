//! Laws of the Poisson groupoids over g*: Γ = g*×G×g*, P×P⁻ for P = g*, and T*G. Their brackets, their structure maps, and
//! Hamiltonians odd under inversion.

mod gamma;

use self::gamma::{
    ADJOINT_MISSING, EVEN_PART, GROUP_SIGN, Gamma, LAMBDA_FLIPPED, LAST_SIGN, MU_FLIPPED, ONE_SIDED, OTHERS, basis,
    column, least_pivot, stack,
};
use super::instances::{CoordinatePolynomial, GroupoidKind, Material};
use super::planted::groupoid::{ENDS_KEPT, INVERSE_KEEPS_U, PRODUCT_WITHOUT_GROUP, SECOND_INVERTED, SOURCE_BLIND};
use super::precision::Measured;
use super::probe::{Probe, stream};
use super::question::{Answer, Precisions, Problem, Question, ask};
use super::{CaseLaw, Source};
use crate::groupoid::Tangent;
use crate::groupoid::calculus::{along, constant, derivatives};
use crate::harness::{About, Cost};
use crate::scalar::{Dual, Real, Scalar};
use nalgebra::{DMatrix, DVector};

const BOUND: &str = "two precisions; floor 2⁸ n u relative to the terms, n = dim g";
const RANK: &str = "pivots of an elimination with complete pivoting above 2⁸ n u of the largest entry, n = dim g";

macro_rules! poisson_law {
    ($name:literal, $statement:literal, $source:literal, $oracle:literal, $question:expr, $faults:expr) => {
        poisson_law!($name, $statement, $source, $oracle, BOUND, $question, $faults)
    };
    ($name:literal, $statement:literal, $source:literal, $oracle:literal, $bound:expr, $question:expr, $faults:expr) => {
        CaseLaw {
            about: About {
                name: $name,
                statement: $statement,
                source: concat!("Martín de Diego and Sato Martín de Almagro 2019, ", $source),
                oracle: $oracle,
                bound: $bound,
                needs: "a group",
                cost: Cost::Cheap,
                faults: $faults,
            },
            cases: |cases| cases.with_group(),
            check: |case, fault| ask(case, fault, $question, Precisions::Both),
        }
    };
}

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            poisson_law!(
                "poisson-bivector",
                "the intrinsic bracket of Γ is that of the generators, {Ξ₁,Ξ'₁} = ⟨λ,[ξ,ξ']⟩, {Ξ₂,Ξ'₂} = −⟨μ,[ξ,ξ']⟩, \
         {Ξ₁,F} = −ξ→F, {Ξ₂,F} = −ξ←F, for all entries of (λ, U, μ) and for random functions",
                "(4.5) and the bracket after it",
                "the definition (4.5) with commutators and invariant fields of matrices, without Ad or structure constants",
                Which::Generators,
                &[LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, GROUP_SIGN, ONE_SIDED]
            ),
            poisson_law!(
                "poisson-bracket",
                "{f + cg, h} = {f, h} + c{g, h}, {f, g} = −{g, f}, {fg, h} = f{g, h} + g{f, h}, {f, {g, h}} + cyclic = 0",
                "Def 4.7 (1)",
                "the axioms, for random quadratic functions of the entries of (λ, U, μ); differentials and the derivative of \
         {g, h} along the Hamiltonian field of f by duals",
                Which::Axioms,
                &[LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, GROUP_SIGN, ONE_SIDED]
            ),
            poisson_law!(
                "inversion-anti-poisson",
                "Tι Π Tιᵀ = −Π∘ι, and the graph of ι is coisotropic in Γ×Γ, on Γ, P×P⁻ and T*G",
                "Thm 4.8 (2)",
                "Tι by duals of ι; the graph by the null space of its tangent vectors",
                Which::Inversion,
                &[INVERSE_KEEPS_U, ENDS_KEPT, LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, LAST_SIGN]
            ),
            poisson_law!(
                "units-coisotropic",
                "the units are coisotropic, on Γ, P×P⁻ and T*G: NᵀΠN = 0 for a basis N of the conormal space at ε(λ)",
                "Thm 4.8 (1)",
                "the null space of the tangent vectors of ε by duals",
                Which::Units,
                &[LAMBDA_FLIPPED, MU_FLIPPED]
            ),
            poisson_law!(
                "product-coisotropic",
                "the graph of ν is coisotropic in Γ×Γ×Γ⁻, on Γ, P×P⁻ and T*G",
                "Def 4.7 (2)",
                "the null space of the tangent vectors of the graph, by duals of ν",
                Which::Product,
                &[
                    LAST_SIGN,
                    SECOND_INVERTED,
                    PRODUCT_WITHOUT_GROUP,
                    LAMBDA_FLIPPED,
                    MU_FLIPPED,
                    ADJOINT_MISSING,
                    GROUP_SIGN
                ]
            ),
            poisson_law!(
                "ends-poisson",
                "α is Poisson and β anti-Poisson onto g* with the bracket +⟨μ, [·,·]⟩, on Γ, P×P⁻ and T*G",
                "Thm 4.8 (3)",
                "commutators of the matrices of the algebra; Tα and Tβ by duals",
                Which::Ends,
                &[SOURCE_BLIND, LAMBDA_FLIPPED, MU_FLIPPED]
            ),
            poisson_law!(
                "structure-submersions",
                "α, β and ν are submersions: Tα, Tβ and Tν have full rank, on Γ, P×P⁻ and T*G",
                "Def 4.1",
                "the rank, by elimination, of tangent maps by duals of α, β and ν",
                RANK,
                Which::Submersions,
                &[SOURCE_BLIND, PRODUCT_WITHOUT_GROUP]
            ),
            poisson_law!(
                "odd-hamiltonian-invariant",
                "Tι X_E(g) = X_E(g⁻¹) for E∘ι = −E, X_E(F) = {F, E}, on Γ, P×P⁻ and T*G",
                "Prop 4.9, proof",
                "the field at the inverse, and Tι by duals; E is the odd part of a random quadratic function",
                Which::Invariant,
                &[EVEN_PART, INVERSE_KEEPS_U, ENDS_KEPT, LAMBDA_FLIPPED, ADJOINT_MISSING]
            ),
            poisson_law!(
                "odd-hamiltonian-tangent",
                "X_E is tangent to the units there, for E∘ι = −E, X_E(F) = {F, E}, on Γ, P×P⁻ and T*G",
                "Prop 4.9",
                "X_E against Tε Tα X_E, by duals of ε and α; E is the odd part of a random quadratic function",
                Which::Tangent,
                &[EVEN_PART, LAMBDA_FLIPPED, MU_FLIPPED, GROUP_SIGN]
            ),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Generators,
    Axioms,
    Inversion,
    Units,
    Product,
    Ends,
    Submersions,
    Invariant,
    Tangent,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::POISSON);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let material = Material::of(problem.system, &mut problem.probe)?;
        let (group, fault) = (&material.group, problem.fault);
        let judge = |kind, probe: &mut Probe| {
            let singular = || Measured::Broken("an element is singular".into());
            let instance = material.instance::<Dual<T>>(kind, fault, probe).ok_or_else(singular)?;
            let none = || Measured::Broken("a product, an inverse or a null space does not exist".into());
            Gamma { group, instance, fault }.judge(self, probe).ok_or_else(none)
        };
        let mut measured = judge(GroupoidKind::Poisson, &mut problem.probe)?;
        if !matches!(self, Self::Generators | Self::Axioms) {
            // Of their own, so that the points of Γ are those of always.
            let mut probe = problem.draws(stream::OTHER_POISSON);
            for kind in OTHERS {
                measured = measured.and(judge(kind, &mut probe)?);
            }
        }
        Ok(measured)
    }
}

impl<T: Real> Gamma<'_, T> {
    fn judge(&self, question: Which, probe: &mut Probe) -> Option<Measured> {
        let entries = self.instance.chain[0].len();
        let mut polynomial = || CoordinatePolynomial::new(probe, entries, 1);
        let functions = [polynomial(), polynomial(), polynomial()];
        match question {
            Which::Generators => self.generators(&functions),
            Which::Axioms => self.axioms(&functions),
            Which::Inversion => self.inversion(),
            Which::Units => self.units(),
            Which::Product => self.product(),
            Which::Ends => self.ends(),
            Which::Submersions => self.submersions(),
            Which::Invariant => self.invariant(&functions[0]),
            Which::Tangent => self.tangent(&functions[0]),
        }
    }

    fn generators(&self, [f, g, _]: &[CoordinatePolynomial<T>; 3]) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let (pi, size) = (self.bivector(z)?, self.size());
        let columns: Vec<_> = (0..size).map(|i| self.push(z, &basis(size, i))).collect();
        let frame = DMatrix::from_columns(&columns);
        let intrinsic = &frame * &pi * frame.transpose();
        let defined = self.generator_brackets(z);
        let largest = frame.amax().max(T::one());
        let entries = self.near("the brackets of the entries", &intrinsic, &defined, largest * largest * pi.amax());
        let (df, dg) = (self.differential(&|z| f.at(z)[0], z), self.differential(&|z| g.at(z)[0], z));
        let here = df.dot(&(&pi * &dg));
        let terms = df.abs().dot(&(pi.abs() * dg.abs()));
        // By the chain rule on the entries.
        let gradient =
            |f: &CoordinatePolynomial<T>| DVector::from_fn(z.len(), |i, _| f.at(&along(z, &basis(z.len(), i)))[0].eps);
        let chained = gradient(f).dot(&(defined * gradient(g)));
        let functions = self.number("{f, g}", here, chained, &[terms]);
        Some(entries.and(functions))
    }

    fn axioms(&self, [f, g, h]: &[CoordinatePolynomial<T>; 3]) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let pi = self.bivector(z)?;
        let d = |function: &dyn Fn(&DVector<Dual<T>>) -> Dual<T>| self.differential(function, z);
        let [df, dg, dh] = [d(&|z| f.at(z)[0]), d(&|z| g.at(z)[0]), d(&|z| h.at(z)[0])];
        let bracket = |a: &DVector<T>, b: &DVector<T>| a.dot(&(&pi * b));
        let terms = |a: &DVector<T>, b: &DVector<T>| a.abs().dot(&(pi.abs() * b.abs()));
        let c = T::exact(1.5);
        let sum = d(&|z| f.at(z)[0] + g.at(z)[0] * Dual::lift(c));
        let (fh, gh) = (bracket(&df, &dh), bracket(&dg, &dh));
        let (size_fh, size_gh) = (terms(&df, &dh), terms(&dg, &dh));
        let linear = self.number("bilinear", bracket(&sum, &dh), fh + c * gh, &[size_fh + c * size_gh]);
        let sizes = &[terms(&df, &dg)];
        let antisymmetric = self.number("antisymmetric", bracket(&df, &dg), -bracket(&dg, &df), sizes);
        let product = d(&|z| f.at(z)[0] * g.at(z)[0]);
        let (at_f, at_g) = (f.at(z)[0], g.at(z)[0]);
        let sizes = &[at_f.abs() * size_gh + at_g.abs() * size_fh];
        let leibniz = self.number("Leibniz", bracket(&product, &dh), at_f * gh + at_g * fh, sizes);
        // {f, k} is the derivative of k along Πᵀ df.
        let nested = |df: &DVector<T>, g: &CoordinatePolynomial<T>, h: &CoordinatePolynomial<T>| {
            let direction = self.push(z, &pi.tr_mul(df));
            Some(self.bracket_at(g, h, &along(z, &direction))?.eps)
        };
        let (one, two, three) = (nested(&df, g, h)?, nested(&dg, h, f)?, nested(&dh, f, g)?);
        // The terms of a term: df Π (dΠ) dg and df Π d²g Π, with entries of the functions about 1.
        let size = pi.abs().row_sum().amax().max(T::one());
        let inner = [&df, &dg, &dh].iter().fold(T::one(), |size, d| size.max(d.amax()));
        let terms = size * size * inner * inner * inner;
        let jacobi = self.number("Jacobi", one + two, -three, &[one, two, three, terms]);
        Some(linear.and(antisymmetric).and(leibniz).and(jacobi))
    }

    fn inversion(&self) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let inverse = self.inverse(z)?;
        let (here, there) = (self.bivector(z)?, self.bivector(&inverse)?);
        let tangent = self.inversion_tangent(z, &inverse)?;
        let mapped = &tangent * &here * tangent.transpose();
        let bound = tangent.abs();
        let size = (&bound * here.abs() * bound.transpose()).amax().max(T::one());
        let anti = self.near("Tι Π Tιᵀ = −Π∘ι", &mapped, &-&there, size);
        let n = here.nrows();
        let graph = stack(&[&DMatrix::identity(n, n), &tangent]);
        let graph =
            self.coisotropic("graph(ι) in Γ×Γ", &graph, &[(&here, T::one()), (&there, self.last_sign(T::one()))])?;
        Some(anti.and(graph))
    }

    fn units(&self) -> Option<Measured> {
        let q = self.groupoid();
        let z = &self.instance.chain[0];
        let lambda = q.source(&constant(z));
        let unit = q.unit(&lambda).map(|v| v.re);
        let (lambda, n) = (lambda.map(|v| v.re), self.dimension());
        let column = |i| self.pull(&unit, &q.push_unit(&lambda, &basis(n, i)));
        let tangent = DMatrix::from_columns(&(0..n).map(column).collect::<Option<Vec<_>>>()?);
        self.coisotropic("units", &tangent, &[(&self.bivector(&unit)?, T::one())])
    }

    fn product(&self) -> Option<Measured> {
        let q = self.groupoid();
        let [g, h, _] = &self.instance.chain;
        let gh = q.compose(&constant(g), &constant(h)).ok()?.map(|v| v.re);
        let tangent = self.product_tangent(g, h, &gh)?;
        let (of_g, of_h, of_gh) = (self.bivector(g)?, self.bivector(h)?, self.bivector(&gh)?);
        let factors = [(&of_g, T::one()), (&of_h, T::one()), (&of_gh, self.last_sign(-T::one()))];
        self.coisotropic("graph(ν) in Γ×Γ×Γ⁻", &tangent, &factors)
    }

    fn ends(&self) -> Option<Measured> {
        let q = self.groupoid();
        let z = &self.instance.chain[0];
        let pi = self.bivector(z)?;
        let source = self.end_tangent(&|tangent| q.push_source(z, tangent), z);
        let target = self.end_tangent(&|tangent| q.push_target(z, tangent), z);
        let value = |point: DVector<Dual<T>>| point.map(|v| v.re);
        let (lambda, mu) = (value(q.source(&constant(z))), value(q.target(&constant(z))));
        let size = pi.amax().max(T::one());
        let alpha = self.near("α is Poisson", &(&source * &pi * source.transpose()), &self.commutators(&lambda), size);
        let beta = self.near("β is anti-Poisson", &(&target * &pi * target.transpose()), &-self.commutators(&mu), size);
        Some(alpha.and(beta))
    }

    fn submersions(&self) -> Option<Measured> {
        let q = self.groupoid();
        let [g, h, _] = &self.instance.chain;
        let gh = q.product(&constant(g), &constant(h)).map(|v| v.re);
        let source = self.end_tangent(&|tangent| q.push_source(g, tangent), g);
        let target = self.end_tangent(&|tangent| q.push_target(g, tangent), g);
        let graph = self.product_tangent(g, h, &gh)?;
        let product = graph.rows(2 * self.size(), self.size()).into_owned();
        let bound = T::unit_roundoff() * T::int(256 * self.dimension() as i64);
        for (of, map) in [("Tα", &source), ("Tβ", &target), ("Tν", &product)] {
            let pivot = least_pivot(map);
            if !(pivot.is_finite() && pivot > bound) {
                let (kind, rows) = (self.instance.kind, map.nrows());
                return Some(Measured::Broken(format!(
                    "{kind:?}: the rank of {of} is below {rows}: a pivot is {pivot:?}"
                )));
            }
        }
        Some(Measured::exact())
    }

    fn invariant(&self, f: &CoordinatePolynomial<T>) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let inverse = self.inverse(z)?;
        let (here, there) = (self.hamiltonian_field(f, z)?, self.hamiltonian_field(f, &inverse)?);
        let mapped = self.groupoid().push_inverse(z, &here)?;
        let size = here.amax().max(there.amax()).max(T::one());
        Some(self.near("Tι X_E(g) = X_E(g⁻¹)", &column(mapped), &column(there), size))
    }

    fn tangent(&self, f: &CoordinatePolynomial<T>) -> Option<Measured> {
        let q = self.groupoid();
        let lambda = q.source(&constant(&self.instance.chain[0]));
        let unit = q.unit(&lambda).map(|v| v.re);
        let field = self.hamiltonian_field(f, &unit)?;
        let down = q.push_source(&unit, &field);
        let back = derivatives(&q.unit(&along(&lambda.map(|v| v.re), &down)));
        let size = field.amax().max(T::one());
        Some(self.near("X_E = Tε Tα X_E", &column(field), &column(back), size))
    }
}
