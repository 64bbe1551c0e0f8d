//! The kernels whose instructions are counted: each is one step in a run.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::expression::Expression;
use euler_poincare::group::{LieGroup, MatrixGroup, So3};
use euler_poincare::integrators::lanes::{
    self, Damping, EnsembleForce, FastRetraction, LaneForce, Term, Terms, VariationalInLanes,
};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::so3::{EnsembleSo3, Member, QuaternionSo3, QuaternionState};
use euler_poincare::integrators::{Doubled, DoubledState, MuntheKaas, OneStep, Solve, State, Variational};
use euler_poincare::mechanics::configuration::{Potential, WithPotential};
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::formula::{FormulaForce, FormulaLagrangian, Quantities};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Description, Tableau};

/// Takes the next step.
pub type Step = Box<dyn FnMut()>;

/// A name, and what makes the kernel.
pub struct Kernel {
    /// Its name in the snapshot: no spaces.
    pub name: &'static str,
    /// The run at its start.
    pub start: fn() -> Step,
}

/// Every kernel: a new one is a line here.
pub const KERNELS: &[Kernel] = &[
    Kernel { name: "so3/cayley/gauss-1", start: || llg("gauss-1", CayleySo3::new()) },
    Kernel { name: "so3/cayley/gauss-2", start: || llg("gauss-2", CayleySo3::new()) },
    Kernel { name: "so3/cayley/gauss-3", start: || llg("gauss-3", CayleySo3::new()) },
    Kernel { name: "so3/cayley/gauss-8", start: || llg("gauss-8", CayleySo3::new()) },
    Kernel { name: "so3/cayley/lobatto-iiib-3", start: || llg("lobatto-iiib-3", CayleySo3::new()) },
    Kernel {
        name: "so3/cayley/gauss-2/relaxed",
        start: || body(&relaxed_rigid_body::<f64>(), "gauss-2", CayleySo3::new()),
    },
    Kernel { name: "so3/cayley/gauss-2/first", start: first },
    Kernel {
        name: "so3/cayley/gauss-2/32-digits",
        start: || body(&landau_lifshitz_gilbert::<Dd>(), "gauss-2", CayleySo3::new()),
    },
    Kernel { name: "so3/cayley/gauss-2/potential", start: top },
    Kernel { name: "so3/cayley/gauss-2/formula", start: top_of_formulas },
    Kernel { name: "so3/exp/gauss-2", start: || llg("gauss-2", ExponentialSo3::new()) },
    Kernel { name: "so3/exp/gauss-3", start: || llg("gauss-3", ExponentialSo3::new()) },
    Kernel { name: "so3/exp/munthe-kaas/gauss-2", start: munthe_kaas },
    Kernel { name: "so3/cayley/doubled/gauss-2", start: doubled },
    Kernel { name: "so3/lanes/cayley/gauss-2", start: || in_lanes("gauss-2", CayleySo3::new(), Damping(1.0)) },
    Kernel { name: "so3/lanes/cayley/gauss-2/gravity", start: || in_lanes("gauss-2", CayleySo3::new(), heavy(1.0)) },
    Kernel { name: "so3/lanes/cayley/gauss-8", start: || in_lanes("gauss-8", CayleySo3::new(), Damping(1.0)) },
    Kernel { name: "so3/lanes/cayley/gauss-8/gravity", start: || in_lanes("gauss-8", CayleySo3::new(), heavy(1.0)) },
    Kernel { name: "so3/lanes/exp/gauss-8", start: || in_lanes("gauss-8", ExponentialSo3::new(), Damping(1.0)) },
    Kernel { name: "so3/lanes/exp/gauss-8/gravity", start: || in_lanes("gauss-8", ExponentialSo3::new(), heavy(1.0)) },
    Kernel { name: "so3/lanes/quaternion/gauss-2", start: || quaternion(Damping(1.0)) },
    Kernel { name: "so3/lanes/quaternion/gauss-2/gravity", start: || quaternion(heavy(1.0)) },
    Kernel { name: "so3/lanes/solve/1e-10", start: || solve(Damping(1.0), 1.0) },
    Kernel { name: "so3/lanes/solve/1e-10/gravity", start: || solve(heavy(1.0), 0.5) },
    Kernel { name: "so3/lanes/ensemble/gauss-2", start: || ensemble(Damping) },
    Kernel { name: "so3/lanes/ensemble/gauss-2/gravity", start: || ensemble(heavy) },
    Kernel { name: "se3/cayley/gauss-2", start: || fluid(Cayley::new(se3()).expect("se(3) admits the Cayley map")) },
    Kernel { name: "se3/exp/gauss-2", start: || fluid(Exponential::of_group(se3())) },
    Kernel { name: "se3/lanes/cayley/gauss-2", start: || fluid_in_lanes("gauss-2", false) },
    Kernel { name: "se3/lanes/cayley/gauss-2/gravity", start: || fluid_in_lanes("gauss-2", true) },
    Kernel { name: "se3/lanes/cayley/gauss-8", start: || fluid_in_lanes("gauss-8", false) },
    Kernel { name: "se3/lanes/cayley/gauss-8/gravity", start: || fluid_in_lanes("gauss-8", true) },
    Kernel { name: "se3/lanes/solve/1e-10", start: || solve_in_a_fluid(false) },
    Kernel { name: "se3/lanes/solve/1e-10/gravity", start: || solve_in_a_fluid(true) },
];

fn tableau<T: Real>(name: &str) -> Tableau<T> {
    let description: Description = name.parse().expect("the name of a tableau");
    description.build().expect("a tableau")
}

/// Steps of a tenth, one after the other: each starts from the stages of the one before.
fn steps<T: Real, const N: usize, const D: usize>(
    mut method: impl OneStep<T, N, D> + 'static,
    momentum: Covector<T, N>,
    attitude: Matrix<T, D>,
) -> Step {
    let (mut state, h) = (State { time: T::zero(), momentum, attitude }, T::ratio(1, 10));
    Box::new(move || {
        method.step(&mut state, h).expect("the step succeeds");
    })
}

fn body<T: Real>(model: &Model<T>, name: &str, retraction: impl Retraction<T, 3, 3> + 'static) -> Step {
    let (lagrangian, force) = (model.system.lagrangian.clone(), model.system.force.clone());
    let method = Variational::new(lagrangian, force, retraction, tableau(name));
    steps(method, model.momentum, Matrix::identity())
}

fn llg(name: &str, retraction: impl Retraction<f64, 3, 3> + 'static) -> Step {
    body(&landau_lifshitz_gilbert(), name, retraction)
}

/// Every step is a first one: it starts from another state than the last one ended with.
fn first() -> Step {
    let model = landau_lifshitz_gilbert::<f64>();
    let (lagrangian, force) = (model.system.lagrangian.clone(), model.system.force.clone());
    let mut method = Variational::new(lagrangian, force, CayleySo3::new(), tableau("gauss-2"));
    Box::new(move || {
        let mut state = State { time: 0.0, momentum: model.momentum, attitude: Matrix::identity() };
        method.step(&mut state, 0.1).expect("the step succeeds");
    })
}

/// A heavy top with linear drag.
#[derive(Clone)]
struct Gravity;

impl Potential<f64, 3> for Gravity {
    fn value<S: Scalar<Base = f64>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        g[(2, 0)] * S::ratio(39, 100) - g[(2, 1)] * S::ratio(26, 100) + g[(2, 2)] * S::ratio(65, 100)
    }
}

fn leaning() -> Covector<f64, 3> {
    Covector::from([0.5, 0.3, 0.9])
}

fn top() -> Step {
    let lagrangian = WithPotential::new(diagonal(), Gravity, So3::new());
    let drag = LinearDrag::new(Matrix::from_diagonal(&[0.1, 0.3, 0.2].into())).expect("finite");
    let method = Variational::new(lagrangian, drag, CayleySo3::new(), tableau("gauss-2"));
    steps(method, leaning(), Matrix::identity())
}

/// The same by formulas.
fn top_of_formulas() -> Step {
    let quantities = Quantities { dimension: 3, size: 3 };
    let names = quantities.names().expect("names");
    let formula = |text: &str| {
        let expression = Expression::parse(text, &names).expect("a formula");
        expression.compile::<f64>().expect("finite numbers")
    };
    let potential = formula("39/100*g_31 - 26/100*g_32 + 65/100*g_33");
    let drag = formula("-[eta_1, 3*eta_2, 2*eta_3]/10");
    let lagrangian = FormulaLagrangian::with_potential(diagonal(), potential, quantities, &So3::<f64>::new());
    let drag = FormulaForce::new(drag, quantities, lagrangian.clone());
    let method = Variational::new(lagrangian, drag, CayleySo3::new(), tableau("gauss-2"));
    steps(method, leaning(), Matrix::identity())
}

fn munthe_kaas() -> Step {
    let model = landau_lifshitz_gilbert::<f64>();
    let method = MuntheKaas::new(model.system.clone(), ExponentialSo3::new(), tableau("gauss-2"));
    steps(method, model.momentum, Matrix::identity())
}

fn doubled() -> Step {
    let model = landau_lifshitz_gilbert::<f64>();
    let (lagrangian, force) = (model.system.lagrangian, model.system.force);
    let forced = Forced::new(lagrangian, force, CayleySo3::new());
    let mut method = Doubled::new(tableau("gauss-2"), CayleySo3::new(), forced);
    let mut state = DoubledState::unit(0.0, model.momentum);
    Box::new(move || {
        method.step(&mut state, 0.1).expect("the step succeeds");
    })
}

fn diagonal() -> Quadratic<f64, 3> {
    Quadratic::diagonal([0.5, 2.0, 1.0]).expect("a regular inertia")
}

/// The damping, and a weight at the centre of mass of [`top`].
fn heavy(alpha: f64) -> (Damping, lanes::Gravity) {
    (Damping(alpha), lanes::Gravity([0.39, -0.26, 0.65]))
}

fn in_lanes(name: &str, retraction: impl FastRetraction + 'static, force: impl LaneForce + 'static) -> Step {
    let method = VariationalInLanes::new(diagonal(), force, retraction, tableau(name)).expect("it fits");
    steps(method, landau_lifshitz_gilbert::<f64>().momentum, Matrix::identity())
}

fn quaternion(force: impl LaneForce + 'static) -> Step {
    let momentum = landau_lifshitz_gilbert::<f64>().momentum;
    let method = VariationalInLanes::new(diagonal(), force, CayleySo3::new(), tableau("gauss-2")).expect("it fits");
    let mut method = QuaternionSo3::of(method);
    let mut state = QuaternionState::from(State { time: 0.0, momentum, attitude: Matrix::identity() });
    Box::new(move || {
        method.step(&mut state, 0.1).expect("the step succeeds");
    })
}

/// So much time to ten digits: as much as one step takes.
fn solve(force: impl LaneForce + 'static, span: f64) -> Step {
    let momentum = landau_lifshitz_gilbert::<f64>().momentum;
    let mut solve = Solve::in_lanes(diagonal(), force, CayleySo3::new()).tolerance(1e-10);
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    Box::new(move || {
        solve.run(&start, span).expect("the run succeeds");
    })
}

/// A step of eight bodies.
fn ensemble<F: EnsembleForce<Packed: 'static> + 'static>(force: fn(f64) -> F) -> Step {
    let momentum = landau_lifshitz_gilbert::<f64>().momentum;
    let member = |k: u8| Member {
        lagrangian: diagonal(),
        force: force(f64::from(k) / 8.0),
        state: State { time: 0.0, momentum, attitude: Matrix::identity() },
    };
    let members: Vec<_> = (0..8).map(member).collect();
    let ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2"));
    let mut ensemble = ensemble.expect("it fits");
    Box::new(move || ensemble.advance(0.01, 1).expect("the step succeeds"))
}

fn se3() -> MatrixGroup<f64, 6, 4> {
    MatrixGroup::from_entry(&Entry::Se3).expect("se(3) has dimension 6")
}

/// A rigid body with linear and quadratic drag.
fn submerged() -> (Quadratic<f64, 6>, AnyForce<f64, 6>, Covector<f64, 6>) {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).expect("a regular inertia");
    let drag = Matrix::from_diagonal_element;
    let force: AnyForce<f64, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(0.125)).expect("finite").into(),
        QuadraticDrag::new(drag(0.25)).expect("positive").into(),
    ]);
    (lagrangian, force, Covector::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]))
}

fn fluid(retraction: impl Retraction<f64, 6, 4> + 'static) -> Step {
    let (lagrangian, force, momentum) = submerged();
    let method = Variational::new(lagrangian, force, retraction, tableau("gauss-2"));
    steps(method, momentum, se3().identity())
}

/// The drag in lanes, and where it is asked for a weight.
fn loads(body: &Quadratic<f64, 6>, drag: &AnyForce<f64, 6>, heavy: bool) -> Terms<6> {
    let mut terms = Terms::new(drag, body, CayleySe3::new().algebra()).expect("drag has a form in lanes");
    if heavy {
        terms.0.push(Term::Gravity(1.3, [0.3, -0.2, 0.5]));
    }
    terms
}

fn fluid_in_lanes(name: &str, heavy: bool) -> Step {
    let (lagrangian, force, momentum) = submerged();
    let force = loads(&lagrangian, &force, heavy);
    let method = VariationalInLanes::new(lagrangian, force, CayleySe3::new(), tableau(name)).expect("it fits");
    steps(method, momentum, Matrix::identity())
}

/// A unit of time to ten digits.
fn solve_in_a_fluid(heavy: bool) -> Step {
    let (lagrangian, force, momentum) = submerged();
    let force = loads(&lagrangian, &force, heavy);
    let mut solve = Solve::in_lanes(lagrangian, force, CayleySe3::new()).tolerance(1e-10);
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    Box::new(move || {
        solve.run(&start, 1.0).expect("the run succeeds");
    })
}
