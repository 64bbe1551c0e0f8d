//! The laws of whole systems on a user's own group, retraction, Lagrangian, force and one-step method.
//!
//! [`Own`] is a user's types; [`GivenSystem`] is a [`Source`] of systems made of them, of which nothing is left but pointers, where a
//! [`Case`] fills in the rest: what is not one's own, the tableau, the state and the step. `laws` are the laws of the library that judge
//! such a system; up to dimension 6 they are compiled in this crate. The group that they see is a [`MatrixGroup`] of the matrices
//! ê_a = `hat(e_a)`, a view of it that does not use its constants, `vee`, `inverse` or `adjoint`; these are judged by
//! [`super::group`].

use super::super::{CaseLaw, Source};
use super::force::ForceLaws;
use super::group::GroupLaws;
use super::lagrangian::LagrangianLaws;
use super::part::Answers;
use crate::algebra::{Casimir, LieAlgebra, Matrix, basis_vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{About, Fault, Law, Verdict};
use crate::integrators::{OneStep, Report, StagePoint, State, StepError};
use crate::laws::method::{self, Claims, MethodLaw, MethodSource, Stepper, Untyped};
use crate::laws::planted::retraction::Plant;
use crate::mechanics::given::{UntypedForce, UntypedLagrangian};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::retraction::beside::UntypedRetraction;
use crate::scalar::{Dd, Real};
use crate::system::case::Structure;
use crate::system::dispatch::MAIN;
use crate::system::dispatch::has_class;
use crate::system::force::Argument;
use crate::system::given::{Supplied, tensor};
use crate::system::random::Given;
use crate::system::rates::Rates;
use crate::system::{Case, CaseError, CaseProblem, ForceTerm, Place, System, Visitor, Wrap, cases};
use proptest::strategy::{BoxedStrategy, Strategy};
use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// A one-step method on a system.
type Method<T, const N: usize, const D: usize> =
    Box<dyn for<'s> Fn(&'s System<T, N, D>) -> Box<dyn OneStep<T, N, D> + 's>>;

/// A user's own types over T: a group of dimension N, represented by D×D matrices, and what else is the user's.
///
/// [`laws!`](crate::laws!) makes it, for every scalar. What a system needs stands in it without its type, what a law on parts needs
/// once more with its type.
#[doc(hidden)]
pub struct Own<T: Real, const N: usize, const D: usize> {
    pub(super) group: Box<dyn Answers<T, GroupLaws<N, D>>>,
    /// The algebra that the group says it has, and Casimirs of it.
    pub(super) algebra: (LieAlgebra<T, N>, Vec<Casimir<T, N>>),
    pub(super) lagrangian: Option<Box<dyn Answers<T, LagrangianLaws<N>>>>,
    pub(super) force: Option<Box<dyn Answers<T, ForceLaws<N>>>>,
    pub(super) supplied: Supplied<T>,
    method: Option<Method<T, N, D>>,
    claims: Claims,
}

impl<T: Real, const N: usize, const D: usize> Own<T, N, D> {
    /// G alone.
    pub fn new(group: impl LieGroup<T, N, D> + Send + Sync + 'static) -> Self {
        let basis = (0..N).map(|a| group.hat(&basis_vector::<T, N>(a)).as_slice().to_vec()).collect();
        Self {
            algebra: (group.algebra().clone(), Vec::new()),
            group: Box::new(group),
            lagrangian: None,
            force: None,
            supplied: Supplied { dimension: N, size: D, basis, ..Supplied::default() },
            method: None,
            claims: Claims::default(),
        }
    }

    /// τ.
    pub fn retraction<R: Retraction<T, N, D> + Send + Sync + 'static>(mut self, make: impl Fn() -> R) -> Self {
        self.supplied.retraction = Some(UntypedRetraction::new::<N, D>(make()));
        self
    }

    /// l.
    pub fn lagrangian<L: Lagrangian<T, N> + Send + Sync + 'static>(mut self, make: impl Fn() -> L) -> Self {
        self.supplied.lagrangian = Some(UntypedLagrangian::new::<N>(make()));
        self.lagrangian = Some(Box::new(make()));
        self
    }

    /// f.
    pub fn force<F: Force<T, N> + Send + Sync + 'static>(mut self, make: impl Fn() -> F) -> Self {
        self.supplied.force = Some(UntypedForce::new::<N>(make()));
        self.force = Some(Box::new(make()));
        self
    }

    /// Casimirs of the algebra.
    pub fn casimirs(mut self, make: impl Fn() -> Vec<Casimir<T, N>>) -> Self {
        self.algebra.1 = make();
        self.supplied.casimirs = self.algebra.1.iter().map(tensor).collect();
        self
    }

    /// A one-step method.
    pub fn method(
        mut self,
        method: impl for<'s> Fn(&'s System<T, N, D>) -> Box<dyn OneStep<T, N, D> + 's> + 'static,
    ) -> Self {
        self.method = Some(Box::new(method));
        self
    }

    /// What is claimed of the method.
    pub fn claims(mut self, make: impl Fn() -> Claims) -> Self {
        self.claims = make();
        self
    }

    /// The method on the system of a case.
    fn stepper(self, case: &Case) -> Result<Box<dyn Stepper<T>>, StepError> {
        let unsupported = |why: String| StepError::Unsupported { why };
        let system = case.with_given::<T, N, D>(&self.supplied, &Plant(None), true);
        let system = system.map_err(|e| unsupported(e.to_string()))?;
        let method = self.method.ok_or_else(|| unsupported("there is no method".into()))?;
        Ok(Box::new(Untyped(Stepping { system, method, stages: None })))
    }
}

/// What makes a user's types, in `f64` and in 32 digits.
pub(super) type Makers<const N: usize, const D: usize> = (fn() -> Own<f64, N, D>, fn() -> Own<Dd, N, D>);

/// What a [`GivenSystem`] is made of over T.
type Supply<T> = Box<dyn Fn() -> Supplied<T> + Send + Sync>;

/// A user's types without their types.
#[doc(hidden)]
pub struct Supplier {
    structure: Structure,
    /// Whether the Lagrangian is one's own, and the force.
    lagrangian: bool,
    force: bool,
    double: Supply<f64>,
    quad: Supply<Dd>,
}

/// A system of a user's own types, of which nothing is left but pointers, with a case for what they leave open; beside spectators, where
/// N is above the dimension of the types.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenSystem<const N: usize, const D: usize> {
    case: Case,
    supplier: Arc<Supplier>,
}

impl<const N: usize, const D: usize> fmt::Debug for GivenSystem<N, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The case alone: the numbers that a law draws beyond it are a function of this text.
        fmt::Debug::fmt(&self.case, f)
    }
}

impl<const N: usize, const D: usize> Source for GivenSystem<N, D> {
    fn case(&self) -> &Case {
        &self.case
    }

    /// With what is one's own instead of what is not.
    fn with_case(&self, mut case: Case) -> Self {
        if self.supplier.force && !case.forces.is_empty() {
            case.forces = vec![ForceTerm::Given];
        }
        if self.supplier.lagrangian {
            case.forces.retain(|force| force.description().argument != Argument::Momentum);
        }
        Self { case, supplier: Arc::clone(&self.supplier) }
    }

    fn visit<T: Real, V: Visitor<T>>(&self, wrap: &impl Wrap, visitor: V) -> Result<V::Output, CaseError> {
        // T is one of two types; which, only its identity says.
        let sides: [&dyn Any; 2] = [&self.supplier.double, &self.supplier.quad];
        let supply = sides.into_iter().find_map(|side| side.downcast_ref::<Supply<T>>());
        let none = || Place::root().key("algebra").error(CaseProblem::given("the algebra"));
        let supplied = supply.ok_or_else(none)?();
        Ok(visitor.visit(self.case.with_given::<T, N, D>(&supplied, wrap, V::KNOWS_CONFIGURATION)?))
    }
}

/// A method of one's own on a system that it owns.
struct Stepping<T: Real, const N: usize, const D: usize> {
    system: System<T, N, D>,
    method: Method<T, N, D>,
    /// Of the last step.
    stages: Option<Vec<StagePoint<T, N, D>>>,
}

impl<T: Real, const N: usize, const D: usize> OneStep<T, N, D> for Stepping<T, N, D> {
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let mut method = (self.method)(&self.system);
        let report = method.step(state, h)?;
        self.stages = method.stages();
        Ok(report)
    }

    fn stages(&self) -> Option<Vec<StagePoint<T, N, D>>> {
        self.stages.clone()
    }
}

/// What `make` makes of a system: so that a closure in a macro knows what it is given.
#[doc(hidden)]
pub fn method_on<'s, T: Real, M: OneStep<T, N, D> + 's, const N: usize, const D: usize>(
    system: &'s System<T, N, D>,
    make: impl FnOnce(&'s System<T, N, D>) -> M,
) -> Box<dyn OneStep<T, N, D> + 's> {
    Box::new(make(system))
}

/// The one-step method of one's own.
struct UserMethod<const N: usize, const D: usize>(Makers<N, D>);

impl<const N: usize, const D: usize, S: Source> MethodSource<S> for UserMethod<N, D> {
    fn double<'a>(&'a self, system: &S) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        self.0.0().stepper(system.case()).map(|stepper| stepper as _)
    }

    fn quad<'a>(&'a self, system: &S) -> Option<Result<Box<dyn Stepper<Dd> + 'a>, StepError>> {
        Some(self.0.1().stepper(system.case()).map(|stepper| stepper as _))
    }
}

/// A method on the systems of a class, and what is claimed of it.
type Claimed<const N: usize, const D: usize> = (Box<dyn MethodSource<GivenSystem<N, D>> + Send + Sync>, Claims);

/// What judges systems of one's own types, or a one-step method of one's own on them.
enum Judge<const N: usize, const D: usize> {
    System(&'static CaseLaw<GivenSystem<N, D>>),
    Method(&'static MethodLaw, Arc<Claimed<N, D>>),
}

/// A law on systems of one's own types.
struct SystemLaw<const N: usize, const D: usize> {
    judge: Judge<N, D>,
    given: Given,
    supplier: Arc<Supplier>,
}

/// The laws that judge systems of one's own types.
///
/// Of the laws of [`all`](crate::laws::all) these are left out: those that stand in a `LAWS` of their file, and those of groupoids, algebroids and the
/// Poisson groupoid, because they judge the library on any group, and nothing that one has written, or draw algebras and forces of the
/// catalogue; so do those of orbits; `derivative-step`, `derivative-run` and
/// most of `configuration-…`, which put factors and random potentials on the catalogue's cases; and those of motions, `variational-order` and
/// `variational-error`, because they take minutes, and what they compare is judged apart by `order-predicted` and the laws of
/// discrete actions. Of those on a one-step method, which are off without a claim that they need, `method-presentation`, which needs the
/// method in another basis.
///
/// Up to dimension 6 the laws are those that are compiled in this crate; beyond, they are compiled for these types.
///
/// # Errors
/// The matrices of the group do not span an algebra, as text.
pub(super) fn laws<const N: usize, const D: usize>(makers: Makers<N, D>) -> Result<Vec<Box<dyn Law<Case>>>, String> {
    let Own { supplied, method, claims, .. } = makers.0();
    let matrices = std::array::from_fn(|a| Matrix::from_column_slice(&supplied.basis[a]));
    let group =
        MatrixGroup::<f64, N, D>::new(matrices).map_err(|e| format!("the matrices hat(e_a) of the group: {e}"))?;
    let supplier = Arc::new(Supplier {
        structure: Structure::Given { dimension: N, abelian: group.algebra().is_abelian() },
        lagrangian: supplied.lagrangian.is_some(),
        force: supplied.force.is_some(),
        double: Box::new(move || makers.0().supplied),
        quad: Box::new(move || makers.1().supplied),
    });
    let method = method.is_some();
    Ok(if const { has_class(N, D, true) } {
        main_laws(supplier, method.then(|| (Box::new(UserMethod(makers)) as _, claims)))
    } else {
        laws_on::<N, D>(supplier, method.then(|| (Box::new(UserMethod(makers)) as _, claims)))
    })
}

/// Generic over nothing, so that what it takes is compiled here.
fn main_laws(supplier: Arc<Supplier>, method: Option<Claimed<{ MAIN.0 }, { MAIN.1 }>>) -> Vec<Box<dyn Law<Case>>> {
    laws_on(supplier, method)
}

fn laws_on<const N: usize, const D: usize>(
    supplier: Arc<Supplier>,
    method: Option<Claimed<N, D>>,
) -> Vec<Box<dyn Law<Case>>> {
    let by = Arc::clone(&supplier);
    let rates = move |case: &Case| {
        let system = GivenSystem::<N, D> { case: case.clone(), supplier: Arc::clone(&by) };
        Rates::by(case, true, |measure| system.visit::<f64, _>(&Plant(None), measure).ok().flatten())
    };
    let (lagrangian, force) = (supplier.lagrangian, supplier.force);
    let given = Given { structure: supplier.structure.clone(), lagrangian, force, rates: Arc::new(rates) };
    let of_method = method.map(Arc::new).into_iter().flat_map(|method| {
        let laws = method::LAWS.iter().filter(|law| law.about.name != "method-presentation");
        laws.map(move |law| Judge::Method(law, Arc::clone(&method)))
    });
    let law = |judge| -> Box<dyn Law<Case>> {
        Box::new(SystemLaw { judge, given: given.clone(), supplier: Arc::clone(&supplier) })
    };
    of_method.chain(table().into_iter().map(Judge::System)).map(law).collect()
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
    .collect()
}

impl<const N: usize, const D: usize> Law<Case> for SystemLaw<N, D> {
    fn about(&self) -> &About {
        match &self.judge {
            Judge::System(law) => &law.about,
            Judge::Method(law, _) => &law.about,
        }
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        let base = cases().given(self.given.clone());
        match &self.judge {
            Judge::System(law) => (law.cases)(base).boxed(),
            Judge::Method(law, _) => law.cases(base).boxed(),
        }
    }

    fn check(&self, case: &Case, fault: Option<&Fault>) -> Verdict {
        let system = GivenSystem { case: case.clone(), supplier: Arc::clone(&self.supplier) };
        match &self.judge {
            Judge::System(law) => (law.check)(&system, fault),
            Judge::Method(law, claimed) => method::check_case(law, &*claimed.0, &system, &claimed.1).verdict,
        }
    }
}
