//! The laws of whole systems on a user's own group, retraction, Lagrangian, force and one-step method.
//!
//! [`Types`] says which types; [`GivenSystem`] is a [`Source`] of systems made of them, of which nothing is left but pointers, where a
//! [`Case`] fills in the rest: what is not one's own, the tableau, the state and the step. `laws` are the laws of the library that judge
//! such a system; up to dimension 6 they are compiled in this crate. The group that they see is a [`MatrixGroup`] of the matrices
//! ê_a = `hat(e_a)`, a view of it that does not use its constants, `vee`, `inverse` or `adjoint`; these are judged by
//! [`super::group`].

use super::super::{CaseLaw, Source};
use super::algebra::Bracket;
use crate::algebra::{AlgebraError, Casimir, Covector, LieAlgebra, Matrix, Vector, basis_vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{About, Fault, Law, Verdict};
use crate::integrators::{OneStep, Report, StagePoint, State, StepError};
use crate::laws::method::{self, Claims, MethodLaw, MethodSource, Stepper, Untyped};
use crate::laws::planted::retraction::Plant;
use crate::mechanics::force::{AnyForce, Zero};
use crate::mechanics::given::Untyped as UntypedPart;
use crate::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::given::Untyped as UntypedRetraction;
use crate::retraction::{Exponential, Retraction};
use crate::scalar::{Dd, Real, Scalar};
use crate::system::case::Structure;
use crate::system::dispatch::MAIN;
use crate::system::given::{Supplied, has_class};
use crate::system::random::Given;
use crate::system::rates::Rates;
use crate::system::{Case, CaseError, ForceTerm, Place, Problem, System, Visitor, Wrap, cases};
use proptest::strategy::{BoxedStrategy, Strategy};
use std::any::{Any, TypeId};
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// A user's own types, for every scalar: a group of dimension N, represented by D×D matrices, and what else is the user's.
///
/// [`laws!`](crate::laws!) writes the implementation.
#[doc(hidden)]
pub trait Types<const N: usize, const D: usize>: Send + Sync + 'static {
    /// Which parts are one's own, beside the group.
    const OWN: Parts = Parts::NONE;

    /// G.
    fn group<T: Real>() -> impl LieGroup<T, N, D> + Send + Sync + 'static;

    /// τ; exp of the group unless it is one's own.
    fn retraction<T: Real>(group: MatrixGroup<T, N, D>) -> impl Retraction<T, N, D> + Send + Sync + 'static {
        Exponential::of_group(group)
    }

    /// l; the one that was drawn unless it is one's own.
    fn lagrangian<T: Real>(drawn: AnyLagrangian<T, N>) -> impl Lagrangian<T, N> + Send + Sync + 'static {
        drawn
    }

    /// f; the one that was drawn unless it is one's own.
    fn force<T: Real>(drawn: AnyForce<T, N>) -> impl Force<T, N> + Send + Sync + 'static {
        drawn
    }

    /// The one-step method on a system; the library's unless it is one's own.
    fn method<'s, T: Real>(system: &'s System<T, N, D>) -> impl OneStep<T, N, D> + 's {
        system.scheme()
    }

    /// What is claimed of the method.
    fn claims() -> Claims {
        Claims::default()
    }

    /// Casimirs of the algebra; none are known unless they are given.
    fn casimirs<T: Real>() -> Vec<Casimir<T, N>> {
        Vec::new()
    }
}

/// Which parts are one's own, beside the group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub struct Parts {
    /// τ.
    pub retraction: bool,
    /// τ, of which dτ, ddτ and τ⁻¹ are derived ([`FromMap`](super::FromMap)).
    pub map: bool,
    /// l.
    pub lagrangian: bool,
    /// f.
    pub force: bool,
    /// Casimirs.
    pub casimirs: bool,
    /// A one-step method.
    pub method: bool,
    /// What is claimed of it.
    pub claims: bool,
}

impl Parts {
    /// The group alone.
    pub const NONE: Self = Self {
        retraction: false,
        map: false,
        lagrangian: false,
        force: false,
        casimirs: false,
        method: false,
        claims: false,
    };
}

fn given<P: Types<N, D>, const N: usize, const D: usize>() -> Result<Given, String> {
    let group = matrices::<P, f64, N, D>().map_err(|e| format!("the matrices hat(e_a) of the group: {e}"))?;
    let structure = Structure::Given { dimension: N, abelian: group.algebra().is_abelian() };
    Ok(Given { structure, lagrangian: P::OWN.lagrangian, force: P::OWN.force, rates: rates::<P, N, D> })
}

fn matrices<P: Types<N, D>, T: Real, const N: usize, const D: usize>() -> Result<MatrixGroup<T, N, D>, AlgebraError> {
    let group = P::group::<T>();
    MatrixGroup::new(std::array::from_fn(|a| group.hat(&basis_vector::<T, N>(a))))
}

/// The rates of a case on a user's types.
fn rates<P: Types<N, D>, const N: usize, const D: usize>(case: &Case) -> Option<Rates> {
    let supplier = &Supply::<P, N, D>::IT;
    if const { has_class(N, D) } { main_rates(supplier, case) } else { rates_on::<N, D>(supplier, case) }
}

/// A user's types without their types: what a [`GivenSystem`] is made of.
#[doc(hidden)]
pub trait Supplier: Send + Sync {
    /// Which parts are one's own, beside the group.
    fn own(&self) -> Parts;

    /// The parts in `f64`.
    ///
    /// # Errors
    /// The matrices of the group do not span an algebra.
    fn double(&self) -> Result<Supplied<f64>, AlgebraError>;

    /// The parts in 32 digits.
    ///
    /// # Errors
    /// The matrices of the group do not span an algebra.
    fn quad(&self) -> Result<Supplied<Dd>, AlgebraError>;
}

/// Supplies the types of P.
struct Supply<P, const N: usize, const D: usize>(PhantomData<fn() -> P>);

impl<P: Types<N, D>, const N: usize, const D: usize> Supply<P, N, D> {
    const IT: Self = Self(PhantomData);

    /// Those parts alone that are one's own: the others are compiled in this crate.
    fn supplied<T: Real>() -> Result<Supplied<T>, AlgebraError> {
        let group = matrices::<P, T, N, D>()?;
        let basis = group.basis().iter().map(|matrix| matrix.as_slice().to_vec()).collect();
        let casimirs = P::casimirs::<T>().iter().map(Into::into).collect();
        let mut supplied =
            Supplied { dimension: N, size: D, basis, casimirs, retraction: None, lagrangian: None, force: None };
        if const { P::OWN.retraction || P::OWN.map } {
            supplied.retraction = Some(Arc::new(UntypedRetraction::<_, N, D>(P::retraction::<T>(group))));
        }
        if const { P::OWN.lagrangian } {
            supplied.lagrangian = Some(Arc::new(UntypedPart::<_, N>(lagrangian::<P, T, N, D>())));
        }
        if const { P::OWN.force } {
            supplied.force = Some(Arc::new(UntypedPart::<_, N>(force::<P, T, N, D>())));
        }
        Ok(supplied)
    }
}

impl<P: Types<N, D>, const N: usize, const D: usize> Supplier for Supply<P, N, D> {
    fn own(&self) -> Parts {
        P::OWN
    }

    fn double(&self) -> Result<Supplied<f64>, AlgebraError> {
        Self::supplied()
    }

    fn quad(&self) -> Result<Supplied<Dd>, AlgebraError> {
        Self::supplied()
    }
}

/// A system of a user's own types, of which nothing is left but pointers, with a case for what they leave open; beside spectators, where
/// N is above the dimension of the types.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenSystem<const N: usize, const D: usize> {
    case: Case,
    supplier: &'static dyn Supplier,
}

/// Of the class that laws are compiled for in this crate.
type Main = GivenSystem<{ MAIN.0 }, { MAIN.1 }>;

impl<const N: usize, const D: usize> fmt::Debug for GivenSystem<N, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The case alone: the numbers that a law draws beyond it are a function of this text.
        fmt::Debug::fmt(&self.case, f)
    }
}

impl<const N: usize, const D: usize> GivenSystem<N, D> {
    /// The parts over T, which is one of two types; which, only its identity says.
    fn supplied<T: Real>(&self) -> Result<Supplied<T>, CaseError> {
        let place = || Place::root().key("algebra");
        let supplied: Box<dyn Any> = match TypeId::of::<T>() {
            double if double == TypeId::of::<f64>() => Box::new(self.supplier.double()),
            quad if quad == TypeId::of::<Dd>() => Box::new(self.supplier.quad()),
            _ => return Err(place().error(Problem::given("the algebra"))),
        };
        match supplied.downcast::<Result<Supplied<T>, AlgebraError>>() {
            Ok(supplied) => supplied.map_err(|e| place().error(Problem::Algebra(e))),
            Err(_) => Err(place().error(Problem::given("the algebra"))),
        }
    }
}

impl<const N: usize, const D: usize> Source for GivenSystem<N, D> {
    fn case(&self) -> &Case {
        &self.case
    }

    /// With what is one's own instead of what is not.
    fn with_case(&self, case: Case) -> Self {
        Self { case: completed(case, self.supplier.own()), supplier: self.supplier }
    }

    fn visit<T: Real, V: Visitor<T>>(&self, wrap: &impl Wrap, visitor: V) -> Result<V::Output, CaseError> {
        let supplied = self.supplied::<T>()?;
        Ok(visitor.visit(self.case.with_given::<T, N, D>(&supplied, wrap, V::KNOWS_CONFIGURATION)?))
    }
}

fn rates_on<const N: usize, const D: usize>(supplier: &'static dyn Supplier, case: &Case) -> Option<Rates> {
    let system = GivenSystem::<N, D> { case: case.clone(), supplier };
    Rates::by(case, true, |measure| system.visit::<f64, _>(&Plant(None), measure).ok().flatten())
}

/// Generic over nothing, so that what it takes is compiled here.
fn main_rates(supplier: &'static dyn Supplier, case: &Case) -> Option<Rates> {
    rates_on::<{ MAIN.0 }, { MAIN.1 }>(supplier, case)
}

/// An algebra with the Casimirs that are known of it.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct WithCasimirs<T: Real, const N: usize> {
    /// g.
    pub algebra: LieAlgebra<T, N>,
    /// C.
    pub casimirs: Vec<Casimir<T, N>>,
}

impl<T: Real, const N: usize> Bracket<T, N> for WithCasimirs<T, N> {
    fn bracket<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Vector<S, N> {
        self.algebra.bracket(x, y)
    }

    fn ad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        self.algebra.ad(x)
    }

    fn coad<S: Scalar<Base = T>>(&self, x: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        self.algebra.coad(x, mu)
    }

    fn casimirs(&self) -> usize {
        self.casimirs.len()
    }

    fn casimir<S: Scalar<Base = T>>(&self, k: usize, mu: &Covector<S, N>) -> S {
        self.casimirs.get(k).map_or(S::zero(), |casimir| casimir.value(mu))
    }
}

/// The algebra that a group of one's own says it has, with its Casimirs.
#[doc(hidden)]
pub fn constants<P: Types<N, D>, T: Real, const N: usize, const D: usize>() -> WithCasimirs<T, N> {
    WithCasimirs { algebra: P::group::<T>().algebra().clone(), casimirs: P::casimirs() }
}

/// A Lagrangian of one's own.
#[doc(hidden)]
pub fn lagrangian<P: Types<N, D>, T: Real, const N: usize, const D: usize>()
-> impl Lagrangian<T, N> + Send + Sync + 'static {
    let unit = Quadratic::new(Matrix::identity()).expect("the identity is regular");
    P::lagrangian::<T>(unit.into())
}

/// A force of one's own.
#[doc(hidden)]
pub fn force<P: Types<N, D>, T: Real, const N: usize, const D: usize>() -> impl Force<T, N> + Send + Sync + 'static {
    P::force::<T>(AnyForce::Zero(Zero))
}

/// The case with what is one's own instead of what is not.
fn completed(mut case: Case, own: Parts) -> Case {
    if own.force && !case.forces.is_empty() {
        case.forces = vec![ForceTerm::Given];
    }
    if own.lagrangian {
        case.forces.retain(|force| !force.is_bracket());
    }
    case
}

/// The method of one's own on a system that it owns.
struct Stepping<P, T: Real, const N: usize, const D: usize> {
    system: System<T, N, D>,
    /// Of the last step.
    stages: Option<Vec<StagePoint<T, N, D>>>,
    types: PhantomData<fn() -> P>,
}

impl<P, T, const N: usize, const D: usize> OneStep<T, N, D> for Stepping<P, T, N, D>
where
    P: Types<N, D>,
    T: Real,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let mut method = P::method(&self.system);
        let report = method.step(state, h)?;
        self.stages = method.stages();
        Ok(report)
    }

    fn stages(&self) -> Option<Vec<StagePoint<T, N, D>>> {
        self.stages.clone()
    }
}

/// What `f` makes of `a`: so that a closure in a macro knows what it is given.
#[doc(hidden)]
pub fn applied<'s, A, B>(a: &'s A, f: impl FnOnce(&'s A) -> B) -> B {
    f(a)
}

/// A law on a one-step method of one's own.
struct UserMethodLaw<P: 'static, const N: usize, const D: usize> {
    law: &'static MethodLaw,
    given: Given,
    types: PhantomData<fn() -> P>,
}

/// Every law on a one-step method but `method-presentation`, which needs the method in another basis. Those that need a claim are off
/// without it.
///
/// # Errors
/// The matrices of the group do not span an algebra, as text.
pub(super) fn method_laws<P: Types<N, D>, const N: usize, const D: usize>() -> Result<Vec<Box<dyn Law<Case>>>, String> {
    let given = given::<P, N, D>()?;
    let laws = method::LAWS.iter().filter(|law| law.about.name != "method-presentation");
    let law = |law| -> Box<dyn Law<Case>> {
        Box::new(UserMethodLaw::<P, N, D> { law, given: given.clone(), types: PhantomData })
    };
    Ok(laws.map(law).collect())
}

/// A method of one's own.
struct UserMethod<P, const N: usize, const D: usize>(PhantomData<fn() -> P>);

impl<P: Types<N, D>, const N: usize, const D: usize> UserMethod<P, N, D> {
    fn stepper<T: Real>(case: &Case) -> Result<Box<dyn Stepper<T>>, StepError> {
        let unsupported = |why: String| StepError::Unsupported { why };
        let supplied = Supply::<P, N, D>::supplied::<T>().map_err(|e| unsupported(e.to_string()))?;
        let system =
            case.with_given::<T, N, D>(&supplied, &Plant(None), true).map_err(|e| unsupported(e.to_string()))?;
        Ok(Box::new(Untyped(Stepping { system, stages: None, types: PhantomData::<fn() -> P> })))
    }
}

impl<P: Types<N, D>, const N: usize, const D: usize, S: Source> MethodSource<S> for UserMethod<P, N, D> {
    fn double<'a>(&'a self, system: &S) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        Self::stepper(system.case()).map(|stepper| stepper as _)
    }

    fn quad<'a>(&'a self, system: &S) -> Option<Result<Box<dyn Stepper<Dd> + 'a>, StepError>> {
        Some(Self::stepper(system.case()).map(|stepper| stepper as _))
    }
}

/// Generic over nothing, as [`main_rates`].
fn check_main(law: &MethodLaw, method: &dyn MethodSource<Main>, system: &Main, claims: &Claims) -> Verdict {
    method::check_source(law, method, system, claims).verdict
}

impl<P: Types<N, D>, const N: usize, const D: usize> Law<Case> for UserMethodLaw<P, N, D> {
    fn about(&self) -> &About {
        &self.law.about
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        self.law.cases(cases().given(self.given.clone())).boxed()
    }

    fn check(&self, case: &Case, _: Option<&Fault>) -> Verdict {
        let (method, claims) = (UserMethod::<P, N, D>(PhantomData), P::claims());
        let (case, supplier) = (case.clone(), &Supply::<P, N, D>::IT);
        if const { has_class(N, D) } {
            return check_main(self.law, &method, &GivenSystem { case, supplier }, &claims);
        }
        method::check_source(self.law, &method, &GivenSystem::<N, D> { case, supplier }, &claims).verdict
    }
}

/// A law on systems of one's own types.
struct SystemLaw<const N: usize, const D: usize> {
    law: &'static CaseLaw<GivenSystem<N, D>>,
    given: Given,
    supplier: &'static dyn Supplier,
}

/// The laws that judge systems of one's own types.
///
/// Of the laws of [`all`](crate::laws::all) these are left out: those of groupoids, algebroids and the Poisson groupoid, of
/// discrete equations of random polynomials, of the discrete Euler–Poincaré equations, `lie-poisson-bracket` and
/// `odd-lagrangian-units`, because they judge the library on any group, and nothing that one has written; those of orbits, `casimir-rate` and
/// `dissipation-rate`, because they draw algebras of the catalogue or need the library's brackets; `derivative-step`, `derivative-run` and
/// `configuration-…`, which put factors and random potentials on the catalogue's cases; and those of motions, `variational-order` and
/// `variational-error`, because they take minutes, and what they compare is judged apart by `order-predicted` and the laws of
/// discrete actions.
///
/// Up to dimension 6 the laws are those that are compiled in this crate; beyond, they are compiled for these types.
///
/// # Errors
/// The matrices of the group do not span an algebra, as text.
pub(super) fn laws<P: Types<N, D>, const N: usize, const D: usize>() -> Result<Vec<Box<dyn Law<Case>>>, String> {
    let (given, supplier) = (given::<P, N, D>()?, &Supply::<P, N, D>::IT);
    Ok(if const { has_class(N, D) } { main_laws(&given, supplier) } else { laws_on::<N, D>(&given, supplier) })
}

/// Generic over nothing, as [`main_rates`].
fn main_laws(given: &Given, supplier: &'static dyn Supplier) -> Vec<Box<dyn Law<Case>>> {
    laws_on::<{ MAIN.0 }, { MAIN.1 }>(given, supplier)
}

fn laws_on<const N: usize, const D: usize>(given: &Given, supplier: &'static dyn Supplier) -> Vec<Box<dyn Law<Case>>> {
    let law = |law| -> Box<dyn Law<Case>> { Box::new(SystemLaw::<N, D> { law, given: given.clone(), supplier }) };
    table().into_iter().map(law).collect()
}

fn table<S: Source>() -> Vec<&'static CaseLaw<S>> {
    use crate::laws::*;
    [
        retraction::laws(),
        accuracy::laws(),
        integrators::laws(),
        doubled::laws(),
        lie_poisson::laws(),
        mechanics::laws(),
        euler_lagrange::laws(),
        legendre::laws(),
        hamiltonian::laws(),
        two_hamiltonians::laws(),
        discrete::action::laws(),
        discrete::exact::laws(),
        munthe_kaas::laws(),
        order::laws(),
        predicted::laws(),
        branch::laws(),
        solve::laws(),
        configuration::shared(),
        frames::shared(),
    ]
    .into_iter()
    .flatten()
    .filter(|law| !LEFT_OUT.contains(&law.about.name))
    .collect()
}

/// They draw algebras of the catalogue, or say nothing about anybody's types.
const LEFT_OUT: [&str; 4] = ["casimir-rate", "dissipation-rate", "lie-poisson-bracket", "odd-lagrangian-units"];

impl<const N: usize, const D: usize> Law<Case> for SystemLaw<N, D> {
    fn about(&self) -> &About {
        &self.law.about
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        (self.law.cases)(cases().given(self.given.clone())).boxed()
    }

    fn check(&self, case: &Case, fault: Option<&Fault>) -> Verdict {
        (self.law.check)(&GivenSystem { case: case.clone(), supplier: self.supplier }, fault)
    }
}
