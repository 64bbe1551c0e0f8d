//! From the run-time description to types: the one door through which a [`Case`] becomes a [`System`].
//!
//! The dimension N is a const generic of one of two classes: 6 or 10, with matrices of size D = 8 and 12. A [`Visitor`] is compiled
//! once for each class and each scalar; most laws know the first class alone ([`Visitor::LARGE`]). Runs of systems have a third
//! class, 3 and 4, without spectators: there speed counts.
//!
//! A system of dimension n runs in the smallest class that holds it, next to N − n *spectators*: the algebra is g ⊕ ℝᴺ⁻ⁿ,
//! the group G × ℝᴺ⁻ⁿ; the spectators have unit inertia, no force, and start at rest, where they stay. Coordinates and
//! matrices of g come first, so that the leading n components and the leading block of a matrix are those of the case.

use super::case::{Case, Force as ForceTerm, Inertia, Monomial, Motion, Structure, Tau};
use super::error::{CaseError, CaseProblem, Place};
use super::numbers::{below, number, square, symmetric, vector};
use super::scope::Scope;
use crate::algebra::catalogue::Entry;
use crate::algebra::{Casimir, Covector, LieAlgebra, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::group::{LieGroup, MatrixGroup};
use crate::integrators::{State, Variational};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::force::{AnyForce, Monomial as Typed};
use crate::mechanics::lagrangian::{AnyLagrangian, Gyrostat, Quadratic, Quartic};
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::retraction::beside::BesideRetraction;
use crate::retraction::{AnyRetraction, Composed, ODD, OddTerm, Retraction, is_odd};
use crate::scalar::Real;
use crate::tableau::families::MAX_STAGES;
use crate::tableau::file::spot::Spot;
use crate::tableau::{Description, Tableau};

/// What laws of reduced systems do not know.
pub(crate) const PLACED: &str = "a force or a Lagrangian that depends on the configuration";

/// What an inertia may be.
const INDEFINITE: &str = "positive definite; with `indefinite = true` any regular one, where there is no quartic term";

/// A case, built: every part typed, every number in `T`.
#[derive(Clone, Debug)]
pub struct System<T: Real, const N: usize, const D: usize> {
    /// n ≤ N: the first n coordinates are those of the case, the others those of spectators.
    pub dimension: usize,
    /// m: the leading m×m block of a matrix is that of the case, the rest is spectators' or padding.
    pub size: usize,
    /// g, in the case's basis.
    pub algebra: LieAlgebra<T, N>,
    /// G; `None` when the algebra is given by structure constants alone.
    pub group: Option<MatrixGroup<T, N, D>>,
    /// l.
    pub lagrangian: AnyLagrangian<T, N>,
    /// f.
    pub force: AnyForce<T, N>,
    /// τ.
    pub retraction: AnyRetraction<T, N, D>,
    /// (a, b).
    pub tableau: Tableau<T>,
    /// The initial state.
    pub state: State<T, N, D>,
    /// h.
    pub step: T,
    /// Casimirs of the algebra in the case's basis; none are known when it is given by constants alone.
    pub casimirs: Vec<Casimir<T, N>>,
}

/// The variational integrator of a system, of references: one type, which is compiled once.
pub(crate) type Scheme<'a, T, const N: usize, const D: usize> =
    Variational<T, N, D, &'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>>;

impl<T: Real, const N: usize, const D: usize> System<T, N, D> {
    /// The variational integrator.
    pub(crate) fn scheme(&self) -> Scheme<'_, T, N, D> {
        self.scheme_of(self.tableau.clone())
    }

    /// The same of another tableau.
    pub(crate) fn scheme_of(&self, tableau: Tableau<T>) -> Scheme<'_, T, N, D> {
        Variational::new(&self.lagrangian, &self.force, &self.retraction, tableau)
    }

    /// The vector field of (μ, g), whose solutions are the reference.
    pub(crate) fn equations(&self) -> EulerPoincare<T, N, &AnyLagrangian<T, N>, &AnyForce<T, N>> {
        EulerPoincare::new(self.algebra.clone(), &self.lagrangian, &self.force)
    }

    /// How many products make n linear combinations of matrices, or of ad where they are larger: what rounding is counted by.
    pub fn products(&self) -> usize {
        self.dimension * self.size.max(self.dimension)
    }
}

/// The dimension of the class that most laws know, and the size of its matrices.
pub(crate) const MAIN: (usize, usize) = (6, 8);

/// Those of the class of runs in dimension 3.
const SMALL: (usize, usize) = (3, 4);

/// Those of the class of everything larger.
const LARGE: (usize, usize) = (10, 12);

/// A system of the class that most laws know.
pub(crate) type Main<T> = System<T, { MAIN.0 }, { MAIN.1 }>;

/// What is done with a system, whatever its dimension.
pub trait Visitor<T: Real> {
    /// The result.
    type Output;

    /// Whether it knows forces and Lagrangians of a user's own types that depend on the configuration: laws of systems f(t, η), l(η) do
    /// not speak of them.
    const KNOWS_CONFIGURATION: bool = false;

    /// Whether it is compiled for dimensions above 6, too. Most laws are not: that is half as much to compile.
    const LARGE: bool = true;

    /// Does it.
    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Self::Output;
}

/// What is done to the retraction of a system before it is handed on: laws put a faulty one in its place, which has to stand behind a
/// pointer. So its type is the same, and what works on systems is compiled once.
#[doc(hidden)]
pub trait Wrap {
    /// The retraction to be used instead of `retraction`.
    fn wrap<T: Real, const N: usize, const D: usize>(
        &self,
        retraction: AnyRetraction<T, N, D>,
    ) -> AnyRetraction<T, N, D>;
}

/// The retraction as it is.
impl Wrap for () {
    fn wrap<T: Real, const N: usize, const D: usize>(&self, tau: AnyRetraction<T, N, D>) -> AnyRetraction<T, N, D> {
        tau
    }
}

/// Builds and does nothing.
struct Build;

impl<T: Real> Visitor<T> for Build {
    type Output = ();

    fn visit<const N: usize, const D: usize>(self, _: System<T, N, D>) {}
}

/// g, G if there is one, the Casimirs that are known, and the size of the matrices of G.
pub(crate) type BuiltParts<T, const N: usize, const D: usize> =
    (LieAlgebra<T, N>, Option<MatrixGroup<T, N, D>>, Vec<Casimir<T, N>>, usize);

/// l and f.
type Mechanics<T, const N: usize> = (AnyLagrangian<T, N>, AnyForce<T, N>);

/// Whether a class holds algebras of dimension n with matrices of a size; `main`: one that every law knows.
pub(crate) const fn has_class(n: usize, size: usize, main: bool) -> bool {
    Beside::fits(n, size, MAIN.0, MAIN.1) || (!main && Beside::fits(n, size, LARGE.0, LARGE.1))
}

impl Case {
    /// Builds the case over `T` and hands it to `visitor`.
    ///
    /// # Errors
    /// A [`CaseError`] that says where and what is allowed, when any part cannot be built.
    pub fn dispatch<T: Real, V: Visitor<T>>(&self, visitor: V) -> Result<V::Output, CaseError> {
        self.dispatch_with(&(), visitor)
    }

    /// The same with the retraction wrapped.
    ///
    /// # Errors
    /// Those of [`Case::dispatch`].
    pub fn dispatch_with<T: Real, V: Visitor<T>>(&self, wrap: &impl Wrap, visitor: V) -> Result<V::Output, CaseError> {
        if self.fits(MAIN) {
            return Ok(visitor.visit(self.system::<T, { MAIN.0 }, { MAIN.1 }>(wrap)?));
        }
        if const { V::LARGE } && self.fits(LARGE) {
            return Ok(visitor.visit(self.system::<T, { LARGE.0 }, { LARGE.1 }>(wrap)?));
        }
        Err(self.too_large(if V::LARGE { LARGE } else { MAIN }))
    }

    /// The system, of a dimension up to 6, with the retraction wrapped.
    ///
    /// # Errors
    /// Those of [`Case::dispatch`]; another dimension.
    pub(crate) fn main<T: Real>(&self, wrap: &impl Wrap) -> Result<Main<T>, CaseError> {
        if self.fits(MAIN) { self.system(wrap) } else { Err(self.too_large(MAIN)) }
    }

    /// The same for a run: in dimension 3 without spectators, since there speed counts.
    ///
    /// # Errors
    /// Those of [`Case::dispatch`].
    pub(super) fn run<T: Real, V: Visitor<T>>(&self, visitor: V) -> Result<V::Output, CaseError> {
        if self.fits(SMALL) {
            return Ok(visitor.visit(self.system::<T, { SMALL.0 }, { SMALL.1 }>(&())?));
        }
        self.dispatch(visitor)
    }

    /// Whether the algebra is so(3) in its standard basis, where retractions have closed forms.
    fn is_standard_so3(&self) -> bool {
        self.algebra.structure == Structure::Named(Entry::So3)
            && self.algebra.basis.is_none()
            && self.method.argument.is_empty()
    }

    /// Whether a class holds the algebra and its matrices, with spectators.
    fn fits(&self, class: (usize, usize)) -> bool {
        Beside::fits(self.dimension(), self.matrix_size(), class.0, class.1)
    }

    /// Why a class does not.
    fn too_large(&self, (most, _): (usize, usize)) -> CaseError {
        let place = Place::root().key("algebra");
        let n = self.dimension();
        if n > most {
            return place.range(format!("of dimension {n}"), format!("dimension 1 to {most}"));
        }
        let size = self.matrix_size();
        let found = format!("represented by {size}×{size} matrices, too large for dimension {n}");
        let key = if matches!(self.algebra.structure, Structure::Named(_)) { "name" } else { "matrices" };
        place.key(key).range(found, format!("at most {0}×{0}", n + 2))
    }

    /// Whether the case can be built (in `f64`).
    ///
    /// # Errors
    /// Those of [`Case::dispatch`].
    pub fn check(&self) -> Result<(), CaseError> {
        self.dispatch::<f64, _>(Build)
    }

    /// The system of the case, the same for every visitor: no visitor's type is in it, so that it is compiled once.
    ///
    /// # Errors
    /// Those of [`Case::dispatch`]; another dimension than N, where matrices of size D leave no room for spectators.
    pub(crate) fn system<T: Real, const N: usize, const D: usize>(
        &self,
        wrap: &impl Wrap,
    ) -> Result<System<T, N, D>, CaseError> {
        let parts = self.structure::<T, N, D>()?;
        let retraction = wrap.wrap(self.tau(&parts.0, &parts.1)?);
        if let Some(i) = self.forces.iter().position(|term| *term == ForceTerm::Given) {
            return Err(Place::root().key("force").index(i).error(CaseProblem::given("the force")));
        }
        self.complete(parts, retraction, &|drawn| drawn, false)
    }

    /// The retraction: a closed form on so(3) in its standard basis, else a general one.
    fn tau<T: Real, const N: usize, const D: usize>(
        &self,
        algebra: &LieAlgebra<T, N>,
        group: &Option<MatrixGroup<T, N, D>>,
    ) -> Result<AnyRetraction<T, N, D>, CaseError> {
        let core = self.is_standard_so3().then(|| self.method.retraction.closed().zip(Beside::new(3, 3, N))).flatten();
        match core.and_then(|(core, beside)| BesideRetraction::new(core, algebra.clone(), beside)) {
            Some(closed) => Ok(AnyRetraction::Beside(closed)),
            None => general(algebra, group, self),
        }
    }

    /// The system of these parts, with the Lagrangian and the force of the case or what is put in their place. What depends on the
    /// configuration is refused where it is not known.
    pub(crate) fn complete<T: Real, const N: usize, const D: usize>(
        &self,
        (algebra, group, casimirs, size): BuiltParts<T, N, D>,
        retraction: AnyRetraction<T, N, D>,
        exchange: &dyn Fn(Mechanics<T, N>) -> Mechanics<T, N>,
        knows_configuration: bool,
    ) -> Result<System<T, N, D>, CaseError> {
        let scope = Scope::of(self)?;
        let drawn = self.lagrangian::<T, N, D>(&scope, &group)?;
        let force = self.force(&algebra, &drawn, &scope)?;
        let (lagrangian, force) = exchange((drawn, force));
        // Of a user's own types: those of the case are known.
        let known = knows_configuration || self.is_general();
        if !known && (force.uses_configuration() || lagrangian.uses_configuration()) {
            return Err(Place::root().inapplicable(PLACED, "this law is for f(t, η) and l(η)"));
        }
        let tableau = self.tableau::<T>(&Place::root().key("method"))?;
        let state = self.state(&lagrangian, &retraction, &group)?;
        let place = Place::root().key("run").key("step");
        let step = number::<T>(&self.step, &place)?;
        if step == T::zero() {
            return Err(place.range(&self.step, "any number but 0"));
        }
        let dimension = self.dimension();
        Ok(System { dimension, size, algebra, group, lagrangian, force, retraction, tableau, state, step, casimirs })
    }

    fn structure<T: Real, const N: usize, const D: usize>(&self) -> Result<BuiltParts<T, N, D>, CaseError> {
        let place = Place::root().key("algebra");
        let basis_place = place.key("basis");
        let (n, basis) = (self.dimension(), self.algebra.basis.as_ref());
        // The file lists the columns.
        let basis = basis.map(|b| Ok(square::<T, N>(b, n, T::one(), &basis_place)?.transpose())).transpose()?;
        let (mut algebra, mut group, mut casimirs, size) = match &self.algebra.structure {
            Structure::Named(entry) => {
                let refused = |e| place.key("name").error(CaseProblem::Algebra(e));
                let group = MatrixGroup::<T, N, D>::beside_spectators(entry).map_err(refused)?;
                (group.algebra().clone(), Some(group), entry.casimirs_beside_spectators::<T, N>(), entry.matrix_size())
            }
            Structure::Matrices { algebra, .. } => {
                let refused = |e| place.key("matrices").error(CaseProblem::Algebra(e));
                let group = MatrixGroup::<T, N, D>::of_matrices(algebra).map_err(refused)?;
                let casimirs = algebra.casimirs_beside_spectators::<T, N>();
                (group.algebra().clone(), Some(group), casimirs, algebra.matrix_size())
            }
            Structure::Constants { .. } => {
                let place = place.key("constants");
                let (algebra, rational) = (self.constants::<T, N>(&place)?, self.algebra.structure.rational());
                let casimirs = rational.as_ref().map_or_else(Vec::new, |r| r.casimirs_beside_spectators::<T, N>());
                let adjoint = rational.and_then(|rational| rational.of_adjoint());
                let size = adjoint.as_ref().map_or(0, |adjoint| adjoint.matrix_size());
                let group = adjoint.map(|adjoint| MatrixGroup::of_matrices(&adjoint)).transpose();
                (algebra, group.map_err(|e| place.error(CaseProblem::Algebra(e)))?, casimirs, size)
            }
            Structure::Given { .. } => return Err(place.error(CaseProblem::given("the algebra"))),
        };
        if let Some(basis) = basis {
            let refused = |e| basis_place.error(CaseProblem::Algebra(e));
            algebra = algebra.in_basis(&basis).map_err(refused)?;
            group = group.map(|group| group.in_basis(&basis)).transpose().map_err(refused)?;
            casimirs = casimirs.iter().map(|c| c.in_basis(&basis)).collect::<Result<_, _>>().map_err(refused)?;
        }
        Ok((algebra, group, casimirs, size))
    }

    fn constants<T: Real, const N: usize>(&self, place: &Place) -> Result<LieAlgebra<T, N>, CaseError> {
        let mut table = [[[T::zero(); N]; N]; N];
        if let Structure::Constants { constants, .. } = &self.algebra.structure {
            for (i, k) in constants.iter().enumerate() {
                let place = place.index(i);
                let value = number::<T>(&k.value, &place.index(3))?;
                let n = self.dimension();
                let (Some(a), Some(b), Some(c)) = (below(k.a, n), below(k.b, n), below(k.c, n)) else {
                    return Err(place.range(format!("the indices {}, {}, {}", k.a, k.b, k.c), format!("1 to {n}")));
                };
                table[a][b][c] += value;
                table[b][a][c] -= value;
            }
        }
        LieAlgebra::new(|a, b, c| table[a][b][c]).map_err(|e| place.error(CaseProblem::Algebra(e)))
    }

    fn lagrangian<T: Real, const N: usize, const D: usize>(
        &self,
        scope: &Scope,
        group: &Option<MatrixGroup<T, N, D>>,
    ) -> Result<AnyLagrangian<T, N>, CaseError> {
        let body = match &self.lagrangian.formula {
            Some(text) => scope.lagrangian(text, group)?,
            None => self.kinetic()?,
        };
        scope.with_potentials(&self.potentials, group, body)
    }

    /// ½⟨Iη, η⟩ + ⟨b, η⟩ + ¼ κ ⟨Kη, η⟩².
    fn kinetic<T: Real, const N: usize>(&self) -> Result<AnyLagrangian<T, N>, CaseError> {
        let (described, table) = (&self.lagrangian, Place::root().key("lagrangian"));
        let place = table.key("inertia");
        let inertia = self.form::<T, N>(&described.inertia, T::one(), &place)?;
        if let Inertia::Diagonal(_) = &described.inertia
            && let Some(a) = (0..N).find(|&a| inertia[(a, a)] == T::zero())
        {
            return Err(place.index(a).range("0", "moments that are not 0"));
        }
        let body = match &described.quartic {
            None => {
                let quadratic = Quadratic::new(inertia).map_err(|e| place.error(e))?;
                if !described.indefinite && !quadratic.is_positive_definite() {
                    return Err(place.range("not positive definite", INDEFINITE));
                }
                quadratic.into()
            }
            Some(kappa) => {
                let (place, metric_place) = (table.key("quartic"), table.key("metric"));
                let value = number::<T>(kappa, &place)?;
                if value < T::zero() {
                    return Err(place.range(kappa, "0 or more"));
                }
                let metric = described.metric.as_ref();
                let metric = metric.map(|metric| self.form::<T, N>(metric, T::zero(), &metric_place)).transpose()?;
                let made = match &metric {
                    None => Quartic::new(inertia, value),
                    Some(metric) => Quartic::in_metric(inertia, value, metric),
                };
                let is_of_metric = |e: &LegendreError| matches!(e, LegendreError::BadTerm { .. });
                made.map_err(|e| if is_of_metric(&e) { metric_place.error(e) } else { table.key("inertia").error(e) })?
                    .into()
            }
        };
        let Some(rotor) = &described.gyrostat else { return Ok(body) };
        let place = table.key("gyrostat");
        let rotor = vector::<T, N>(rotor, self.dimension(), &place)?.transpose();
        Ok(Gyrostat::new(body, rotor).map_err(|e| place.error(e))?.into())
    }

    /// A symmetric matrix, with `spectators` on the diagonal for spectators.
    fn form<T: Real, const N: usize>(
        &self,
        form: &Inertia,
        spectators: T,
        place: &Place,
    ) -> Result<Matrix<T, N>, CaseError> {
        match form {
            Inertia::Diagonal(diagonal) => {
                let mut diagonal = vector::<T, N>(diagonal, self.dimension(), place)?;
                (self.dimension()..N).for_each(|spectator| diagonal[spectator] = spectators);
                Ok(Matrix::from_diagonal(&diagonal))
            }
            Inertia::Full(rows) => {
                let matrix = square::<T, N>(rows, self.dimension(), spectators, place)?;
                symmetric(&matrix, rows, place)?;
                Ok(matrix)
            }
        }
    }

    fn force<T: Real, const N: usize>(
        &self,
        algebra: &LieAlgebra<T, N>,
        lagrangian: &AnyLagrangian<T, N>,
        scope: &Scope,
    ) -> Result<AnyForce<T, N>, CaseError> {
        let place = Place::root().key("force");
        let terms = self.forces.iter().enumerate().filter(|(_, term)| **term != ForceTerm::Given);
        let terms = terms.map(|(i, term)| term.typed(self.dimension(), algebra, lagrangian, scope, &place.index(i)));
        let mut terms = terms.collect::<Result<Vec<_>, _>>()?;
        Ok(match terms.len() {
            0 => AnyForce::Zero(crate::mechanics::force::Zero),
            1 => terms.remove(0),
            _ => AnyForce::Sum(terms),
        })
    }

    fn tableau<T: Real>(&self, method: &Place) -> Result<Tableau<T>, CaseError> {
        let tableau = &self.method.tableau;
        let Description::Entries(entries) = tableau else {
            return tableau.build::<T>().map_err(|e| method.key("tableau").error(e));
        };
        if entries.b.len() > MAX_STAGES {
            let found = format!("{} long", entries.b.len());
            return Err(method.key("b").range(found, format!("at most {MAX_STAGES} stages")));
        }
        entries.build::<T>().map_err(|e| {
            let Spot { key, indices } = Spot::blamed(&e, entries);
            indices.into_iter().fold(method.key(key), |place, index| place.index(index)).error(e)
        })
    }

    fn state<T: Real, const N: usize, const D: usize>(
        &self,
        lagrangian: &impl Lagrangian<T, N>,
        retraction: &impl Retraction<T, N, D>,
        group: &Option<MatrixGroup<T, N, D>>,
    ) -> Result<State<T, N, D>, CaseError> {
        let (n, place) = (self.dimension(), Place::root().key("state"));
        let time = number(&self.start.time, &place.key("time"))?;
        let attitude = match (&self.start.attitude, self.placed(group)?) {
            (_, Some(attitude)) => attitude,
            (None, None) => Matrix::identity(),
            (Some(x), None) => {
                let place = place.key("attitude");
                retraction.tau(&vector::<T, N>(x, n, &place)?).map_err(|e| place.error(e))?
            }
        };
        let g = Configuration::of(&attitude);
        let momentum = match &self.start.motion {
            Motion::Velocity(eta) => {
                let place = place.key("velocity");
                let eta = vector::<T, N>(eta, n, &place)?;
                let momentum = finite(lagrangian.gradient_at(time, g, &eta), &place)?;
                if self.lagrangian.formula.is_some() {
                    let place = Place::root().key("lagrangian").key("formula");
                    lagrangian.velocity_at(time, g, &momentum, &eta).map_err(|e| place.error(e))?;
                }
                momentum
            }
            Motion::Momentum(mu) => {
                let place = place.key("momentum");
                let momentum = vector::<T, N>(mu, n, &place)?.transpose();
                lagrangian.velocity_at(time, g, &momentum, &Vector::zeros()).map_err(|e| place.error(e))?;
                momentum
            }
        };
        Ok(State { time, momentum, attitude })
    }
}

/// The retraction of a general algebra.
fn general<T: Real, const N: usize, const D: usize>(
    algebra: &LieAlgebra<T, N>,
    group: &Option<MatrixGroup<T, N, D>>,
    case: &Case,
) -> Result<AnyRetraction<T, N, D, MatrixGroup<T, N, D>>, CaseError> {
    let place = Place::root().key("method");
    let inner =
        plain(algebra, group, case.method.retraction).map_err(|problem| place.key("retraction").error(problem))?;
    if case.method.argument.is_empty() {
        return Ok(inner);
    }
    let (place, n) = (place.key("argument"), case.dimension());
    let term = |(k, term): (usize, &Monomial)| {
        let place = place.index(k);
        if !is_odd(term.factors.len()) {
            return Err(place.index(2).error(CaseProblem::Part(ODD.into())));
        }
        let Typed { component, coefficient, factors, .. } = term.typed(n, &place, 2)?;
        Ok(OddTerm { component, coefficient, factors })
    };
    let terms = case.method.argument.iter().enumerate().map(term).collect::<Result<_, CaseError>>()?;
    Ok(AnyRetraction::Composed(Box::new(Composed::new(inner, terms).map_err(|e| place.error(e))?)))
}

/// That of a name, of a general algebra.
pub(super) fn plain<T: Real, const N: usize, const D: usize>(
    algebra: &LieAlgebra<T, N>,
    group: &Option<MatrixGroup<T, N, D>>,
    tau: Tau,
) -> Result<AnyRetraction<T, N, D>, CaseProblem> {
    if tau.known().of_matrices && group.is_none() {
        let why = "it works on matrices, and the algebra is given by structure constants alone, with a centre or irrational, so without a \
                   group; allowed: \"exp\", or an algebra by name or by `matrices`";
        return Err(CaseProblem::NotApplicable { what: format!("{:?}", tau.name()).into(), why: why.into() });
    }
    AnyRetraction::named(tau, algebra, group.as_ref()).map_err(CaseProblem::Part)
}

fn finite<T: Real, const N: usize>(mu: Covector<T, N>, place: &Place) -> Result<Covector<T, N>, CaseError> {
    if mu.iter().all(|v| v.all_finite()) {
        return Ok(mu);
    }
    Err(place.range("too large", "velocities of finite momentum"))
}
