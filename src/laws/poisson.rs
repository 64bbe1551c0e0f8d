//! Laws of the Poisson groupoid Γ = g*×G×g* ⇉ g*: its bracket, its structure maps, and Hamiltonians odd under inversion.

use super::CaseLaw;
use super::instances::{ENDS_KEPT, INVERSE_KEEPS_U, Instance, Kind, Material, Planted, Polynomial, SECOND_INVERTED};
use super::planted::blend_scalar;
use super::precision::{Measured, settle};
use super::probe::Probe;
use crate::algebra::{Covector, Matrix};
use crate::group::{LieGroup, MatrixGroup};
use crate::groupoid::calculus::{along, constant, derivatives};
use crate::groupoid::{
    Arrow, DenseGroup, Group, Groupoid, Phase, PhaseFunction, bracket, generator_brackets, poisson_bivector,
    push_inverse, push_product, push_source, push_target, push_unit,
};
use crate::harness::{Cost, Fault};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Dual, Real, Scalar};
use crate::system::{Case, System, Visitor, cases};
use nalgebra::{DMatrix, DVector};
use proptest::strategy::Strategy;

const BOUND: &str = "two precisions; floor 2⁸ n u relative to the terms, n = dim g";

const LAMBDA_FLIPPED: Fault =
    Fault::new("bivector-lambda-flipped", "−⟨λ, [A_λ, B_λ]⟩, the sign of the λ term flipped", "non-abelian algebras");
const MU_FLIPPED: Fault =
    Fault::new("bivector-mu-flipped", "+⟨μ, [A_μ, B_μ]⟩, the sign of the μ term flipped", "non-abelian algebras");
const ADJOINT_MISSING: Fault =
    Fault::new("bivector-adjoint-missing", "B_λ in the place of Ad_{U⁻¹} B_λ", "non-abelian algebras");
const GROUP_SIGN: Fault = Fault::new(
    "bivector-group-sign",
    "{Ξ₂, F} = +ξ←F: the sign of ⟨L*_U A_U, B_μ⟩ and of its mirror flipped",
    "every algebra",
);
const ONE_SIDED: Fault =
    Fault::new("bivector-one-sided", "⟨L*_U A_U, B_μ⟩ left out, but not its mirror", "every algebra");
const LAST_SIGN: Fault = Fault::new(
    "product-last-sign",
    "the sign of the last factor flipped: Γ×Γ×Γ in the place of Γ×Γ×Γ⁻, Γ×Γ⁻ in the place of Γ×Γ",
    "every algebra",
);
const EVEN_PART: Fault =
    Fault::new("hamiltonian-even-part", "E = f in the place of f − f∘ι, its even part left in", "every algebra");

macro_rules! law {
    ($name:literal, $statement:literal, $source:literal, $oracle:literal, $question:expr, $faults:expr) => {
        CaseLaw {
            name: $name,
            statement: $statement,
            source: concat!("Martín de Diego and Sato Martín de Almagro 2019, ", $source),
            oracle: $oracle,
            bound: BOUND,
            cost: Cost::Cheap,
            faults: $faults,
            cases: || cases().with_group().boxed(),
            check: |case, fault| settle(case, Check { case, fault, question: $question }),
        }
    };
}

/// The laws of this file.
pub const LAWS: &[CaseLaw] = &[
    law!(
        "poisson-bivector",
        "the intrinsic bracket of Γ is that of the generators, {Ξ₁,Ξ'₁} = ⟨λ,[ξ,ξ']⟩, {Ξ₂,Ξ'₂} = −⟨μ,[ξ,ξ']⟩, \
         {Ξ₁,F} = −ξ→F, {Ξ₂,F} = −ξ←F, for all entries of (λ, U, μ) and for random functions",
        "(4.5) and the bracket after it",
        "the definition (4.5) with commutators and invariant fields of matrices, without Ad or structure constants",
        Question::Generators,
        &[LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, GROUP_SIGN, ONE_SIDED]
    ),
    law!(
        "poisson-bracket",
        "{f + cg, h} = {f, h} + c{g, h}, {f, g} = −{g, f}, {fg, h} = f{g, h} + g{f, h}, {f, {g, h}} + cyclic = 0",
        "Def 4.7 (1)",
        "the axioms, for random quadratic functions of the entries of (λ, U, μ); differentials and the derivative of \
         {g, h} along the Hamiltonian field of f by duals",
        Question::Axioms,
        &[LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, GROUP_SIGN, ONE_SIDED]
    ),
    law!(
        "inversion-anti-poisson",
        "Tι Π Tιᵀ = −Π∘ι, and the graph of ι is coisotropic in Γ×Γ",
        "Thm 4.8 (2)",
        "Tι by duals of ι; the graph by the null space of its tangent vectors",
        Question::Inversion,
        &[INVERSE_KEEPS_U, ENDS_KEPT, LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, LAST_SIGN]
    ),
    law!(
        "units-coisotropic",
        "the units are coisotropic: NᵀΠN = 0 for a basis N of the conormal space at (λ, e, λ)",
        "Thm 4.8 (1)",
        "the null space of the tangent vectors of ε by duals",
        Question::Units,
        &[LAMBDA_FLIPPED, MU_FLIPPED]
    ),
    law!(
        "product-coisotropic",
        "the graph of ν is coisotropic in Γ×Γ×Γ⁻",
        "Def 4.7 (2)",
        "the null space of the tangent vectors of the graph, by duals of ν",
        Question::Product,
        &[LAST_SIGN, SECOND_INVERTED, LAMBDA_FLIPPED, MU_FLIPPED, ADJOINT_MISSING, GROUP_SIGN]
    ),
    law!(
        "ends-poisson",
        "α is Poisson and β anti-Poisson onto g* with the bracket +⟨μ, [·,·]⟩",
        "Thm 4.8 (3)",
        "commutators of the matrices of the algebra; Tα and Tβ by duals",
        Question::Ends,
        &[LAMBDA_FLIPPED, MU_FLIPPED]
    ),
    law!(
        "odd-hamiltonian-invariant",
        "Tι X_E(g) = X_E(g⁻¹) for E∘ι = −E, X_E(F) = {F, E}",
        "Prop 4.9, proof",
        "the field at the inverse, and Tι by duals; E is the odd part of a random quadratic function",
        Question::Invariant,
        &[EVEN_PART, INVERSE_KEEPS_U, ENDS_KEPT, LAMBDA_FLIPPED, ADJOINT_MISSING]
    ),
    law!(
        "odd-hamiltonian-tangent",
        "X_E is tangent to the units there, for E∘ι = −E, X_E(F) = {F, E}",
        "Prop 4.9",
        "X_E against Tε Tα X_E, by duals of ε and α; E is the odd part of a random quadratic function",
        Question::Tangent,
        &[EVEN_PART, LAMBDA_FLIPPED, MU_FLIPPED, GROUP_SIGN]
    ),
];

#[derive(Clone, Copy)]
enum Question {
    Generators,
    Axioms,
    Inversion,
    Units,
    Product,
    Ends,
    Invariant,
    Tangent,
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a Case,
    fault: Option<&'a Fault>,
    question: Question,
}

/// (λ, U, μ) of its coordinates.
fn phase<S: Scalar, const N: usize, const D: usize>(z: &DVector<S>) -> Phase<S, N, D> {
    Arrow {
        source: Covector::from_fn(|_, a| z[a]),
        group: Matrix::from_fn(|r, c| z[N + c * D + r]),
        target: Covector::from_fn(|_, a| z[N + D * D + a]),
    }
}

/// A function of the coordinates.
struct OfEntries<'a, T: Real>(&'a Polynomial<T>);

impl<T: Real, const N: usize, const D: usize> PhaseFunction<T, N, D> for OfEntries<'_, T> {
    fn value<S: Scalar<Base = T>>(&self, point: &Phase<S, N, D>) -> S {
        let entries = point.source.iter().chain(point.group.iter()).chain(point.target.iter());
        self.0.at(&DVector::from_iterator(2 * N + D * D, entries.copied()))[0]
    }
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>>(self, system: System<T, N, D, R>) -> Measured {
        let mut probe = Probe::new(self.case, 11);
        let Some(group) = &system.group else {
            return Measured::NotApplicable("the algebra has no group".into());
        };
        let material = match Material::draw(group, &system.retraction, &mut probe) {
            Ok(material) => material,
            Err(RetractionError::NoGroup { .. }) => {
                return Measured::NotApplicable("the algebra has no group".into());
            }
            Err(_) => return Measured::NotApplicable("a group element is outside the domain of the retraction".into()),
        };
        let library = library::<T, N, D>(group);
        let Some(instance) = material.instance::<Dual<T>>(Kind::Poisson, self.fault, &mut probe) else {
            return Measured::Broken("an element is singular".into());
        };
        Gamma { group: &material.group, instance, library: &library, fault: self.fault }
            .judge(self.question, &mut probe)
            .unwrap_or_else(|| Measured::Broken("a product, an inverse or a null space does not exist".into()))
    }
}

/// What the library says about Γ of a group, on coordinates.
struct Library<'a, T: Real> {
    /// Π in the coordinates (λ, u, μ) of `Differential`.
    bivector: Box<dyn Fn(&DVector<Dual<T>>) -> Option<DMatrix<Dual<T>>> + 'a>,
    /// The brackets of the entries.
    generators: Box<dyn Fn(&DVector<T>) -> DMatrix<T> + 'a>,
    /// {f, g}.
    bracket: Box<dyn Fn(&Polynomial<T>, &Polynomial<T>, &DVector<T>) -> Option<T> + 'a>,
}

fn library<T: Real, const N: usize, const D: usize>(group: &MatrixGroup<T, N, D>) -> Library<'_, T>
where
    MatrixGroup<T, N, D>: LieGroup<T, N, D>,
{
    Library {
        bivector: Box::new(|z| Some(poisson_bivector(group, &phase::<_, N, D>(z))?.dense())),
        generators: Box::new(|z| generator_brackets(group, &phase::<_, N, D>(z))),
        bracket: Box::new(|f, g, z| bracket(group, &OfEntries(f), &OfEntries(g), &phase::<T, N, D>(z))),
    }
}

/// Γ with its bivector, in which faults may be planted. Vectors of 3n components are in the coordinates (λ, u, μ) of
/// `Differential`, others in the ambient ones.
struct Gamma<'a, T: Real> {
    group: &'a DenseGroup<T>,
    instance: Instance<'a, Dual<T>>,
    library: &'a Library<'a, T>,
    fault: Option<&'a Fault>,
}

impl<'a, T: Real> Gamma<'a, T> {
    fn groupoid(&self) -> &Planted<'a, Dual<T>> {
        &self.instance.groupoid
    }

    fn size(&self, fault: &Fault) -> f64 {
        Fault::size_of(self.fault, fault.name)
    }

    fn dimension(&self) -> usize {
        crate::groupoid::Manifold::<T>::dimension(self.group)
    }

    /// U of (λ, U, μ).
    fn matrix<S: Scalar<Base = T>>(&self, z: &DVector<S>) -> DMatrix<S> {
        let (n, d) = (self.dimension(), self.group.matrix_size());
        DMatrix::from_fn(d, d, |r, c| z[n + c * d + r])
    }

    /// (δλ, Uû, δμ) of (δλ, u, δμ).
    fn push<S: Scalar<Base = T>>(&self, z: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        let n = self.dimension();
        let moved = self.matrix(z) * self.group.hat(&w.rows(n, n).into_owned());
        let entries = w.rows(0, n).iter().chain(moved.iter()).chain(w.rows(2 * n, n).iter()).copied().collect();
        DVector::from_vec(entries)
    }

    /// (δλ, u, δμ) of (δλ, Uû, δμ).
    fn pull(&self, z: &DVector<T>, tangent: &DVector<T>) -> Option<DVector<T>> {
        let n = self.dimension();
        let u = self.group.vee(&(self.group.inverse(&self.matrix(z))? * self.matrix(tangent)));
        let end = tangent.rows(tangent.len() - n, n).into_owned();
        Some(DVector::from_fn(3 * n, |i, _| {
            if i < n {
                tangent[i]
            } else if i < 2 * n {
                u[i - n]
            } else {
                end[i - 2 * n]
            }
        }))
    }

    /// Π, over duals.
    fn bivector_at(&self, z: &DVector<Dual<T>>) -> Option<DMatrix<Dual<T>>> {
        let right = (self.library.bivector)(z)?;
        let n = self.dimension();
        let block = |i: usize, j: usize, i0: usize, j0: usize| i / n == i0 && j / n == j0;
        let wrong = |fault: &Fault, entry: &dyn Fn(usize, usize, Dual<T>) -> Dual<T>| {
            let size = self.size(fault);
            (size > 0.0).then(|| right.map_with_location(|i, j, v| blend_scalar(v, entry(i, j, v), size)))
        };
        let spoiled = wrong(&LAMBDA_FLIPPED, &|i, j, v| if block(i, j, 0, 0) { -v } else { v })
            .or_else(|| wrong(&MU_FLIPPED, &|i, j, v| if block(i, j, 2, 2) { -v } else { v }))
            .or_else(|| wrong(&GROUP_SIGN, &|i, j, v| if block(i, j, 1, 2) || block(i, j, 2, 1) { -v } else { v }))
            .or_else(|| wrong(&ONE_SIDED, &|i, j, v| if block(i, j, 1, 2) { Dual::lift(T::zero()) } else { v }))
            .or_else(|| {
                let unit = |i: usize, j: usize| Dual::lift(if i % n == j % n { T::one() } else { T::zero() });
                wrong(&ADJOINT_MISSING, &|i, j, v| {
                    if block(i, j, 1, 0) {
                        unit(i, j)
                    } else if block(i, j, 0, 1) {
                        -unit(i, j)
                    } else {
                        v
                    }
                })
            });
        Some(spoiled.unwrap_or(right))
    }

    /// Π.
    fn bivector(&self, z: &DVector<T>) -> Option<DMatrix<T>> {
        Some(self.bivector_at(&constant(z))?.map(|v| v.re))
    }

    /// dF at z, in the 3n directions.
    fn differential<S: Scalar<Base = T>>(
        &self,
        function: &dyn Fn(&DVector<Dual<S>>) -> Dual<S>,
        z: &DVector<S>,
    ) -> DVector<S> {
        let size = 3 * self.dimension();
        DVector::from_fn(size, |i, _| function(&along(z, &self.push(z, &basis(size, i)))).eps)
    }

    /// {f, g}(z) over duals.
    fn bracket_at(&self, f: &Polynomial<T>, g: &Polynomial<T>, z: &DVector<Dual<T>>) -> Option<Dual<T>> {
        let (df, dg) = (self.differential(&|z| f.at(z)[0], z), self.differential(&|z| g.at(z)[0], z));
        Some(df.dot(&(self.bivector_at(z)? * dg)))
    }

    fn judge(&self, question: Question, probe: &mut Probe) -> Option<Measured> {
        let entries = self.instance.chain[0].len();
        let mut polynomial = || Polynomial::new(probe, entries, 1);
        let functions = [polynomial(), polynomial(), polynomial()];
        match question {
            Question::Generators => self.generators(&functions),
            Question::Axioms => self.axioms(&functions),
            Question::Inversion => self.inversion(),
            Question::Units => self.units(),
            Question::Product => self.product(),
            Question::Ends => self.ends(),
            Question::Invariant => self.invariant(&functions[0]),
            Question::Tangent => self.tangent(&functions[0]),
        }
    }

    fn near(&self, what: &'static str, a: &DMatrix<T>, b: &DMatrix<T>, size: T) -> Measured {
        let floor = 256.0 * self.dimension() as f64;
        Measured::defect((a - b).amax(), size * self.instance.scale, floor, || what.into())
    }

    fn number(&self, what: &'static str, a: T, b: T, terms: &[T]) -> Measured {
        let size = terms.iter().fold(T::one(), |size, term| size.max(term.abs()));
        self.near(what, &DMatrix::from_element(1, 1, a), &DMatrix::from_element(1, 1, b), size)
    }

    fn generators(&self, [f, g, _]: &[Polynomial<T>; 3]) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let (pi, size) = (self.bivector(z)?, 3 * self.dimension());
        let columns: Vec<_> = (0..size).map(|i| self.push(z, &basis(size, i))).collect();
        let frame = DMatrix::from_columns(&columns);
        let intrinsic = &frame * &pi * frame.transpose();
        let defined = (self.library.generators)(z);
        let largest = frame.amax().max(T::one());
        let entries = self.near("the brackets of the entries", &intrinsic, &defined, largest * largest * pi.amax());
        let (df, dg) = (self.differential(&|z| f.at(z)[0], z), self.differential(&|z| g.at(z)[0], z));
        let here = df.dot(&(&pi * &dg));
        let terms = absolute(&df).dot(&(absolute_matrix(&pi) * absolute(&dg)));
        // By the chain rule on the entries.
        let gradient = |f: &Polynomial<T>| DVector::from_fn(z.len(), |i, _| f.at(&along(z, &basis(z.len(), i)))[0].eps);
        let chained = gradient(f).dot(&(defined * gradient(g)));
        let functions = self.number("{f, g}", here, chained, &[terms]);
        let of_library = self.number("{f, g} of the library", here, (self.library.bracket)(f, g, z)?, &[terms]);
        Some(entries.and(functions).and(of_library))
    }

    fn axioms(&self, [f, g, h]: &[Polynomial<T>; 3]) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let pi = self.bivector(z)?;
        let d = |function: &dyn Fn(&DVector<Dual<T>>) -> Dual<T>| self.differential(function, z);
        let [df, dg, dh] = [d(&|z| f.at(z)[0]), d(&|z| g.at(z)[0]), d(&|z| h.at(z)[0])];
        let bracket = |a: &DVector<T>, b: &DVector<T>| a.dot(&(&pi * b));
        let terms = |a: &DVector<T>, b: &DVector<T>| absolute(a).dot(&(absolute_matrix(&pi) * absolute(b)));
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
        let nested = |df: &DVector<T>, g: &Polynomial<T>, h: &Polynomial<T>| {
            let direction = self.push(z, &pi.tr_mul(df));
            Some(self.bracket_at(g, h, &along(z, &direction))?.eps)
        };
        let (one, two, three) = (nested(&df, g, h)?, nested(&dg, h, f)?, nested(&dh, f, g)?);
        // The terms of a term: df Π (dΠ) dg and df Π d²g Π, with entries of the functions about 1.
        let size = absolute_matrix(&pi).row_sum().amax().max(T::one());
        let inner = [&df, &dg, &dh].iter().fold(T::one(), |size, d| size.max(d.amax()));
        let terms = size * size * inner * inner * inner;
        let jacobi = self.number("Jacobi", one + two, -three, &[one, two, three, terms]);
        Some(linear.and(antisymmetric).and(leibniz).and(jacobi))
    }

    /// Tι at z, from 3n coordinates to 3n coordinates.
    fn inversion_tangent(&self, z: &DVector<T>, inverse: &DVector<T>) -> Option<DMatrix<T>> {
        let size = 3 * self.dimension();
        let column = |i| self.pull(inverse, &push_inverse(self.groupoid(), z, &self.push(z, &basis(size, i)))?);
        Some(DMatrix::from_columns(&(0..size).map(column).collect::<Option<Vec<_>>>()?))
    }

    fn inverse(&self, z: &DVector<T>) -> Option<DVector<T>> {
        Some(self.groupoid().inverse(&constant(z))?.map(|v| v.re))
    }

    fn last_sign(&self, sign: T) -> T {
        blend_scalar(sign, -sign, self.size(&LAST_SIGN))
    }

    fn inversion(&self) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let inverse = self.inverse(z)?;
        let (here, there) = (self.bivector(z)?, self.bivector(&inverse)?);
        let tangent = self.inversion_tangent(z, &inverse)?;
        let mapped = &tangent * &here * tangent.transpose();
        let bound = absolute_matrix(&tangent);
        let size = (&bound * absolute_matrix(&here) * bound.transpose()).amax().max(T::one());
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
        let column = |i| self.pull(&unit, &push_unit(q, &lambda, &basis(n, i)));
        let tangent = DMatrix::from_columns(&(0..n).map(column).collect::<Option<Vec<_>>>()?);
        self.coisotropic("units", &tangent, &[(&self.bivector(&unit)?, T::one())])
    }

    fn product(&self) -> Option<Measured> {
        let q = self.groupoid();
        let [g, h, _] = &self.instance.chain;
        let gh = q.compose(&constant(g), &constant(h)).ok()?.map(|v| v.re);
        let n = self.dimension();
        let column = |i: usize| {
            // (δλ, u, δμ) and (δμ, v, δκ) of (δλ, u, δμ, v, δκ).
            let all = basis(5 * n, i);
            let part = |from: usize| all.rows(from, 3 * n).into_owned();
            let (along_g, along_h) = (part(0), part(2 * n));
            let moved = push_product(q, (g, &self.push(g, &along_g)), (h, &self.push(h, &along_h)))?;
            let moved = self.pull(&gh, &moved)?;
            let entries = along_g.iter().chain(along_h.iter()).chain(moved.iter()).copied().collect();
            Some(DVector::from_vec(entries))
        };
        let tangent = DMatrix::from_columns(&(0..5 * n).map(column).collect::<Option<Vec<_>>>()?);
        let (of_g, of_h, of_gh) = (self.bivector(g)?, self.bivector(h)?, self.bivector(&gh)?);
        let factors = [(&of_g, T::one()), (&of_h, T::one()), (&of_gh, self.last_sign(-T::one()))];
        self.coisotropic("graph(ν) in Γ×Γ×Γ⁻", &tangent, &factors)
    }

    /// NᵀΠN = 0 for a basis N of the conormal space of the columns, Π block-diagonal.
    fn coisotropic(&self, what: &'static str, tangent: &DMatrix<T>, factors: &[(&DMatrix<T>, T)]) -> Option<Measured> {
        let conormal = null_space(tangent)?;
        let size = factors[0].0.nrows();
        let mut all = DMatrix::zeros(size * factors.len(), size * factors.len());
        for (k, (bivector, sign)) in factors.iter().enumerate() {
            all.view_mut((k * size, k * size), (size, size)).copy_from(&(*bivector * *sign));
        }
        let product = conormal.tr_mul(&(&all * &conormal));
        let bound = absolute_matrix(&conormal);
        let terms = bound.tr_mul(&(absolute_matrix(&all) * &bound)).amax();
        Some(self.near(what, &product, &DMatrix::zeros(product.nrows(), product.ncols()), terms))
    }

    fn ends(&self) -> Option<Measured> {
        let q = self.groupoid();
        let z = &self.instance.chain[0];
        let (pi, n) = (self.bivector(z)?, self.dimension());
        let columns = |map: &dyn Fn(&DVector<T>) -> DVector<T>| {
            DMatrix::from_columns(&(0..3 * n).map(|i| map(&self.push(z, &basis(3 * n, i)))).collect::<Vec<_>>())
        };
        let source = columns(&|tangent| push_source(q, z, tangent));
        let target = columns(&|tangent| push_target(q, z, tangent));
        let hats: Vec<DMatrix<T>> = (0..n).map(|a| self.group.hat(&basis(n, a))).collect();
        let commutators = |point: &DVector<T>| {
            DMatrix::from_fn(n, n, |a, b| point.dot(&self.group.vee(&(&hats[a] * &hats[b] - &hats[b] * &hats[a]))))
        };
        let value = |point: DVector<Dual<T>>| point.map(|v| v.re);
        let (lambda, mu) = (value(q.source(&constant(z))), value(q.target(&constant(z))));
        let size = pi.amax().max(T::one());
        let alpha = self.near("α is Poisson", &(&source * &pi * source.transpose()), &commutators(&lambda), size);
        let beta = self.near("β is anti-Poisson", &(&target * &pi * target.transpose()), &-commutators(&mu), size);
        Some(alpha.and(beta))
    }

    /// X_E(z) = Π dE for E = f − f∘ι, in ambient coordinates.
    fn hamiltonian_field(&self, f: &Polynomial<T>, z: &DVector<T>) -> Option<DVector<T>> {
        self.groupoid().inverse(&constant(z))?;
        let size = self.size(&EVEN_PART);
        let energy = |z: &DVector<Dual<T>>| {
            let here = f.at(z)[0];
            // It exists at z and so near z.
            let there = self.groupoid().inverse(z).map_or(here, |inverse| f.at(&inverse)[0]);
            blend_scalar(here - there, here, size)
        };
        Some(self.push(z, &(self.bivector(z)? * self.differential(&energy, z))))
    }

    fn invariant(&self, f: &Polynomial<T>) -> Option<Measured> {
        let z = &self.instance.chain[0];
        let inverse = self.inverse(z)?;
        let (here, there) = (self.hamiltonian_field(f, z)?, self.hamiltonian_field(f, &inverse)?);
        let mapped = push_inverse(self.groupoid(), z, &here)?;
        let size = here.amax().max(there.amax()).max(T::one());
        Some(self.near("Tι X_E(g) = X_E(g⁻¹)", &column(mapped), &column(there), size))
    }

    fn tangent(&self, f: &Polynomial<T>) -> Option<Measured> {
        let q = self.groupoid();
        let lambda = q.source(&constant(&self.instance.chain[0]));
        let unit = q.unit(&lambda).map(|v| v.re);
        let field = self.hamiltonian_field(f, &unit)?;
        let down = push_source(q, &unit, &field);
        let back = derivatives(&q.unit(&along(&lambda.map(|v| v.re), &down)));
        let size = field.amax().max(T::one());
        Some(self.near("X_E = Tε Tα X_E", &column(field), &column(back), size))
    }
}

fn basis<S: Scalar>(size: usize, i: usize) -> DVector<S> {
    DVector::from_fn(size, |j, _| if i == j { S::one() } else { S::zero() })
}

fn column<T: Real>(v: DVector<T>) -> DMatrix<T> {
    DMatrix::from_columns(&[v])
}

fn absolute<T: Real>(v: &DVector<T>) -> DVector<T> {
    v.map(|v| v.abs())
}

fn absolute_matrix<T: Real>(m: &DMatrix<T>) -> DMatrix<T> {
    m.map(|v| v.abs())
}

/// The matrices one below the other.
fn stack<T: Real>(parts: &[&DMatrix<T>]) -> DMatrix<T> {
    let rows: Vec<_> = parts.iter().flat_map(|part| part.row_iter().map(|row| row.into_owned())).collect();
    DMatrix::from_rows(&rows)
}

/// A basis N of the vectors with `columns`ᵀ N = 0, by elimination with complete pivoting; `None` where the columns are
/// dependent.
fn null_space<T: Real>(columns: &DMatrix<T>) -> Option<DMatrix<T>> {
    let mut left = columns.transpose();
    let (rank, size) = left.shape();
    let mut pivots = Vec::new();
    for k in 0..rank {
        let (mut at, mut largest) = ((k, 0), T::zero());
        for j in (0..size).filter(|j| !pivots.contains(j)) {
            for i in k..rank {
                if left[(i, j)].abs() > largest {
                    (at, largest) = ((i, j), left[(i, j)].abs());
                }
            }
        }
        if !(largest > T::unit_roundoff()) {
            return None;
        }
        left.swap_rows(k, at.0);
        pivots.push(at.1);
        let scaled = left.row(k) / left[(k, at.1)];
        left.set_row(k, &scaled);
        for i in (0..rank).filter(|i| *i != k) {
            let reduced = left.row(i) - &scaled * left[(i, at.1)];
            left.set_row(i, &reduced);
        }
    }
    let free: Vec<usize> = (0..size).filter(|j| !pivots.contains(j)).collect();
    Some(DMatrix::from_fn(size, free.len(), |i, c| match pivots.iter().position(|pivot| *pivot == i) {
        Some(k) => -left[(k, free[c])],
        None if free[c] == i => T::one(),
        None => T::zero(),
    }))
}
