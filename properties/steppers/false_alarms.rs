//! The false alarms of the laws of methods: correct methods, each with the claims that are true of it, on random systems.
//!
//! `cargo run --example false_alarms -- FILE SEEDS CASES ORDER_SEEDS`: seeds 1 to SEEDS with CASES cases each for the laws of balance and
//! reversibility, seeds 1 to ORDER_SEEDS for the law of the order. Writes a line of CSV for each method and law to FILE, anew
//! after each seed, and prints what is broken. Exits with 1 if anything is.
//!
//! All methods are judged on the same case: what the theory knows of it is found once.

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::LieGroup;
use euler_poincare::harness::evidence::gather;
use euler_poincare::harness::{BoxedStrategy, Verdict, draw};
use euler_poincare::integrators::{Classical, MuntheKaas, OneStep, Report, Solver, State, StepError, Variational};
use euler_poincare::laws::method::{
    Claims, LAWS, MethodLaw, Other, Point, Quantity, Scheme, Setup, Side, Solved, Stage, StateForm, Stepper, Theory,
    Untyped, Value, Wanted, check, theory_of,
};
use euler_poincare::mechanics::{Force, Lagrangian, equations::EulerPoincare};
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::study::problem;
use euler_poincare::system::{Case, Cases, System, Visitor, cases};
use euler_poincare::tableau::{Classic, Description, Family, Tableau, variational_order};
use proptest::strategy::{Just, Strategy};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::error::Error;
use std::fmt::Write;
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// The entries of DOP853 below the diagonal: row and column from 1. Hairer, Nørsett and Wanner 1993, II.10; their program
/// `dop853.f`.
const DOP853: [(usize, usize, f64); 50] = [
    (2, 1, 0.05260015195876773),
    (3, 1, 0.0197250569845379),
    (3, 2, 0.0591751709536137),
    (4, 1, 0.02958758547680685),
    (4, 3, 0.08876275643042054),
    (5, 1, 0.2413651341592667),
    (5, 3, -0.8845494793282861),
    (5, 4, 0.924834003261792),
    (6, 1, 0.037037037037037035),
    (6, 4, 0.17082860872947386),
    (6, 5, 0.12546768756682242),
    (7, 1, 0.037109375),
    (7, 4, 0.17025221101954405),
    (7, 5, 0.06021653898045596),
    (7, 6, -0.017578125),
    (8, 1, 0.03709200011850479),
    (8, 4, 0.17038392571223998),
    (8, 5, 0.10726203044637328),
    (8, 6, -0.015319437748624402),
    (8, 7, 0.008273789163814023),
    (9, 1, 0.6241109587160757),
    (9, 4, -3.3608926294469414),
    (9, 5, -0.868219346841726),
    (9, 6, 27.59209969944671),
    (9, 7, 20.154067550477894),
    (9, 8, -43.48988418106996),
    (10, 1, 0.47766253643826434),
    (10, 4, -2.4881146199716677),
    (10, 5, -0.590290826836843),
    (10, 6, 21.230051448181193),
    (10, 7, 15.279233632882423),
    (10, 8, -33.28821096898486),
    (10, 9, -0.020331201708508627),
    (11, 1, -0.9371424300859873),
    (11, 4, 5.186372428844064),
    (11, 5, 1.0914373489967295),
    (11, 6, -8.149787010746927),
    (11, 7, -18.52006565999696),
    (11, 8, 22.739487099350505),
    (11, 9, 2.4936055526796523),
    (11, 10, -3.0467644718982196),
    (12, 1, 2.273310147516538),
    (12, 4, -10.53449546673725),
    (12, 5, -2.0008720582248625),
    (12, 6, -17.9589318631188),
    (12, 7, 27.94888452941996),
    (12, 8, -2.8589982771350235),
    (12, 9, -8.87285693353063),
    (12, 10, 12.360567175794303),
    (12, 11, 0.6433927460157636),
];

/// Its weights that are not 0.
const DOP853_WEIGHTS: [(usize, f64); 8] = [
    (1, 0.054293734116568765),
    (6, 4.450312892752409),
    (7, 1.8915178993145003),
    (8, -5.801203960010585),
    (9, 0.3111643669578199),
    (10, -0.1521609496625161),
    (11, 0.20136540080403034),
    (12, 0.04471061572777259),
];

/// How a method makes its step of a tableau.
#[derive(Clone, Copy)]
enum Engine {
    /// On (μ, g) as a vector.
    Classical,
    /// [`Dop853`], whatever the tableau.
    Dop853,
    /// On the algebra, by the retraction of the case.
    MuntheKaas,
    /// The variational integrator of the pair (a, â).
    Variational,
}

/// A method, and what is true of it.
struct Method {
    name: &'static str,
    engine: Engine,
    tableau: Tableau<f64>,
    claims: Claims,
}

/// DOP853 at a fixed step, on (μ, g) as a vector. Not a [`Tableau`]: weights of it are 0.
struct Dop853<const N: usize, L, F, G> {
    body: EulerPoincare<f64, N, L, F>,
    group: Option<G>,
}

impl<const N: usize, const D: usize, L, F, G> OneStep<f64, N, D> for Dop853<N, L, F, G>
where
    L: Lagrangian<f64, N>,
    F: Force<f64, N>,
    G: LieGroup<f64, N, D>,
{
    fn step(&mut self, state: &mut State<f64, N, D>, h: f64) -> Result<Report<f64>, StepError> {
        let mut slopes: Vec<(Covector<f64, N>, Matrix<f64, D>)> = Vec::new();
        for stage in 1..=12 {
            let (mut momentum, mut attitude, mut time) = (state.momentum, state.attitude, state.time);
            for &(_, column, value) in DOP853.iter().filter(|(row, ..)| *row == stage) {
                momentum += slopes[column - 1].0 * (h * value);
                attitude += slopes[column - 1].1 * (h * value);
                time += h * value;
            }
            let rates = self.body.rates(time, &momentum, &Vector::zeros());
            let rates = rates.map_err(|source| StepError::Legendre { step: h, source })?;
            let hat = self.group.as_ref().map_or_else(Matrix::zeros, |group| group.hat(&rates.velocity));
            slopes.push((rates.momentum, attitude * hat));
        }
        for &(column, value) in &DOP853_WEIGHTS {
            state.momentum += slopes[column - 1].0 * (h * value);
            state.attitude += slopes[column - 1].1 * (h * value);
        }
        state.time += h;
        Ok(Report { solver: Solver::Explicit, iterations: 0, residual: 0.0 })
    }
}

/// The methods. The variational ones keep Casimirs without force, whatever their tableau. With a force they are not reversible, which the
/// classical Gauss methods are.
fn methods() -> Result<Vec<Method>, Box<dyn Error>> {
    let plain = |order| Claims { order: Some(order), ..Claims::default() };
    let mut methods = vec![
        Method { name: "rk4", engine: Engine::Classical, tableau: Classic::Rk4.tableau()?, claims: plain(4) },
        Method { name: "rkmk4", engine: Engine::MuntheKaas, tableau: Classic::Rk4.tableau()?, claims: plain(4) },
        Method { name: "dop853", engine: Engine::Dop853, tableau: Classic::Rk4.tableau()?, claims: plain(8) },
        Method {
            name: "classical-radau-iia-3",
            engine: Engine::Classical,
            tableau: Family::RadauIIA.tableau(3)?,
            claims: plain(5),
        },
        Method {
            name: "classical-gauss-2",
            engine: Engine::Classical,
            tableau: Family::Gauss.tableau(2)?,
            claims: Claims { reversible: true, ..plain(4) },
        },
    ];
    let variational = [
        ("gauss-1", Family::Gauss, 1),
        ("gauss-2", Family::Gauss, 2),
        ("gauss-3", Family::Gauss, 3),
        ("gauss-4", Family::Gauss, 4),
        ("lobatto-iiia-3", Family::LobattoIIIA, 3),
        ("lobatto-iiib-3", Family::LobattoIIIB, 3),
        ("radau-iia-2", Family::RadauIIA, 2),
        ("radau-iia-3", Family::RadauIIA, 3),
    ];
    for (name, family, stages) in variational {
        let order = variational_order(&Description::Family(family, stages).build::<Dd>()?, 9).order as u32;
        let claims = Claims { order: Some(order), casimirs: true, ..Claims::default() };
        methods.push(Method { name, engine: Engine::Variational, tableau: family.tableau(stages)?, claims });
    }
    Ok(methods)
}

/// Builds a stepper on a system.
struct Build<'m>(&'m Method);

impl Visitor<f64> for Build<'_> {
    type Output = Box<dyn Stepper<f64>>;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Self::Output {
        let System { algebra, group, lagrangian, force, retraction, .. } = system;
        let tableau = self.0.tableau.clone();
        match self.0.engine {
            Engine::Classical => {
                let body = EulerPoincare::new(algebra, lagrangian, force);
                Box::new(Untyped::<_, N, D>(Classical::new(body, group, tableau)))
            }
            Engine::Dop853 => {
                let body = EulerPoincare::new(algebra, lagrangian, force);
                Box::new(Untyped::<_, N, D>(Dop853 { body, group }))
            }
            Engine::MuntheKaas => {
                let body = EulerPoincare::new(algebra, lagrangian, force);
                Box::new(Untyped::<_, N, D>(MuntheKaas::new(body, retraction, tableau)))
            }
            Engine::Variational => {
                Box::new(Untyped::<_, N, D>(Variational::new(lagrangian, force, retraction, tableau)))
            }
        }
    }
}

/// A solution, and what was asked for.
type Known<T> = (Wanted<T>, Result<Vec<Solved<T>>, StepError>);

/// What the theory knows, with what it was asked before.
struct Memory<T: Real> {
    theory: Box<dyn Theory<T>>,
    solved: RefCell<Vec<Known<T>>>,
}

/// A part in a memory.
struct Shared<T: Real>(Rc<Memory<T>>);

impl<T: Real> Theory<T> for Shared<T> {
    fn start(&self) -> Point<T> {
        self.0.theory.start()
    }

    fn step(&self) -> T {
        self.0.theory.step()
    }

    fn is_free(&self) -> bool {
        self.0.theory.is_free()
    }

    fn keeps_energy(&self) -> bool {
        self.0.theory.keeps_energy()
    }

    fn is_autonomous(&self) -> bool {
        self.0.theory.is_autonomous()
    }

    fn has_attitude(&self) -> bool {
        self.0.theory.has_attitude()
    }

    fn parts(&self) -> Vec<String> {
        self.0.theory.parts()
    }

    fn casimirs(&self) -> usize {
        self.0.theory.casimirs()
    }

    fn value(&self, quantity: Quantity, point: &Point<T>) -> Option<Value<T>> {
        self.0.theory.value(quantity, point)
    }

    fn solve(&self, wanted: &Wanted<T>) -> Result<Vec<Solved<T>>, StepError> {
        if let Some((_, known)) = self.0.solved.borrow().iter().find(|(asked, _)| asked == wanted) {
            return known.clone();
        }
        let found = self.0.theory.solve(wanted);
        self.0.solved.borrow_mut().push((wanted.clone(), found.clone()));
        found
    }

    fn pace(&self, point: &Point<T>) -> f64 {
        self.0.theory.pace(point)
    }

    fn turn(&self, point: &Point<T>) -> f64 {
        self.0.theory.turn(point)
    }

    fn brackets(&self, point: &Point<T>) -> Vec<T> {
        self.0.theory.brackets(point)
    }

    fn element(&self) -> Option<Vec<T>> {
        self.0.theory.element()
    }

    fn symmetry(&self) -> Option<Vec<T>> {
        self.0.theory.symmetry()
    }

    fn force(&self, stage: &Stage<T>) -> Option<Vec<T>> {
        self.0.theory.force(stage)
    }

    fn transported(&self, point: &Point<T>) -> Option<Vec<(T, T)>> {
        self.0.theory.transported(point)
    }
}

/// A case with what is known of it, and its variations.
struct Body {
    case: Case,
    double: Rc<Memory<f64>>,
    quad: Rc<Memory<Dd>>,
    variations: RefCell<HashMap<i64, Rc<Body>>>,
}

/// The k of the variation that is the same body for all cases.
const GENERIC: i64 = 4;

impl Body {
    fn of(case: &Case) -> Result<Rc<Self>, StepError> {
        let unsupported = |error: euler_poincare::system::CaseError| StepError::Unsupported { why: error.to_string() };
        let double = theory_of::<f64>(case).map_err(unsupported)?;
        let quad = theory_of::<Dd>(case).map_err(unsupported)?;
        Ok(Rc::new(Self {
            case: case.clone(),
            double: Rc::new(Memory { theory: double, solved: RefCell::default() }),
            quad: Rc::new(Memory { theory: quad, solved: RefCell::default() }),
            variations: RefCell::default(),
        }))
    }

    fn variation(&self, k: i64) -> Result<Option<Rc<Self>>, StepError> {
        if let Some(known) = self.variations.borrow().get(&k) {
            return Ok(Some(known.clone()));
        }
        let case = match k {
            1..GENERIC => problem::varied(&self.case, k),
            _ => match problem::generic() {
                Ok(file) => Case { method: self.case.method.clone(), ..file.case },
                Err(_) => return Ok(None),
            },
        };
        let body = Self::of(&case)?;
        self.variations.borrow_mut().insert(k, body.clone());
        Ok(Some(body))
    }
}

fn setup<'a>(body: &Rc<Body>, method: &'a Method) -> Result<Setup<'a>, StepError> {
    let built = body.case.dispatch::<f64, _>(Build(method));
    let stepper = built.map_err(|error| StepError::Unsupported { why: error.to_string() })?;
    let again = body.clone();
    let case = body.case.clone();
    let scheme = move |of: &euler_poincare::system::case::Method| Scheme::of(&case, of, &StateForm::default());
    let others = move |other: Other| match other {
        Other::Variation(k) => match again.variation(k)? {
            Some(varied) => setup(&varied, method).map(|setup| Some((setup, Vec::new()))),
            None => Ok(None),
        },
        Other::Presentation => Ok(None),
    };
    Ok(Setup {
        double: Side { theory: Box::new(Shared(body.double.clone())), method: RefCell::new(stepper) },
        quad: None,
        reference: Some(Box::new(Shared(body.quad.clone()))),
        others: Box::new(others),
        scheme: Box::new(scheme),
    })
}

/// Verdicts of a method by a law.
#[derive(Clone, Default)]
struct Count {
    seeds: u64,
    cases: usize,
    held: usize,
    broken: usize,
    inconclusive: usize,
    not_applicable: usize,
    why: BTreeMap<String, usize>,
}

type Counts = BTreeMap<(usize, usize), Count>;

fn table(methods: &[Method], counts: &Counts) -> String {
    let mut text = String::from("method,law,seeds,cases,held,broken,inconclusive,not_applicable\n");
    for ((method, law), count) in counts {
        let Count { seeds, cases, held, broken, inconclusive, not_applicable, .. } = count;
        let (method, law) = (methods[*method].name, LAWS[*law].about.name);
        let _ = writeln!(text, "{method},{law},1-{seeds},{cases},{held},{broken},{inconclusive},{not_applicable}");
    }
    text
}

/// Draws of which little depends on the tableau, which is the method's.
fn base() -> Cases {
    cases().with_group().main_dimensions().with_tableaux(Just(Description::Family(Family::Gauss, 1)))
}

/// Judges all methods on a case.
fn judge(law: usize, case: &Case, methods: &[Method], told: &mut impl FnMut(usize, Verdict)) {
    let judged: &MethodLaw = &LAWS[law];
    let body = match Body::of(case) {
        Ok(body) => body,
        Err(error) => return (0..methods.len()).for_each(|k| told(k, Verdict::broken(error.to_string()))),
    };
    for (k, method) in methods.iter().enumerate() {
        let verdict = match setup(&body, method) {
            Ok(setup) => check(judged, &setup, &method.claims).verdict,
            Err(error) => Verdict::not_applicable(error.to_string()),
        };
        if verdict.is_broken()
            && let Ok(setup) = setup(&body, method)
        {
            gather(|| check(judged, &setup, &method.claims)).1.iter().for_each(|evidence| println!("{evidence:?}"));
        }
        told(k, verdict);
    }
}

struct Campaign {
    methods: Vec<Method>,
    file: String,
    cases: usize,
    /// How many seeds for each law.
    seeds: Vec<u64>,
    next: AtomicU64,
    counts: Mutex<Counts>,
}

impl Campaign {
    fn work(&self) {
        let strategies: Vec<BoxedStrategy<Case>> = LAWS.iter().map(|law| law.cases(base()).boxed()).collect();
        let most = self.seeds.iter().copied().max().unwrap_or(0);
        loop {
            let seed = self.next.fetch_add(1, Ordering::SeqCst);
            if seed > most {
                return;
            }
            for law in 0..self.seeds.len() {
                if seed <= self.seeds[law] {
                    self.seed(law, seed, &strategies[law]);
                }
            }
        }
    }

    fn seed(&self, law: usize, seed: u64, strategy: &BoxedStrategy<Case>) {
        let mut found: Vec<Count> = vec![Count::default(); self.methods.len()];
        for index in 0..self.cases {
            let Ok((case, _)) = draw(strategy, seed, LAWS[law].about.name, index).case else { continue };
            judge(law, &case, &self.methods, &mut |method, verdict| {
                let count = &mut found[method];
                count.cases += 1;
                match &verdict {
                    Verdict::Holds { .. } => count.held += 1,
                    Verdict::Broken { .. } => {
                        count.broken += 1;
                        let (method, law) = (self.methods[method].name, LAWS[law].about.name);
                        println!("BROKEN {method} {law} seed {seed} case {index}: {verdict}");
                    }
                    Verdict::Inconclusive { why } => {
                        count.inconclusive += 1;
                        *count.why.entry(why.clone()).or_default() += 1;
                    }
                    Verdict::NotApplicable { .. } => count.not_applicable += 1,
                }
            });
        }
        let Ok(mut counts) = self.counts.lock() else { return };
        for (method, new) in found.into_iter().enumerate() {
            let sum = counts.entry((method, law)).or_default();
            sum.seeds += 1;
            sum.cases += new.cases;
            sum.held += new.held;
            sum.broken += new.broken;
            sum.inconclusive += new.inconclusive;
            sum.not_applicable += new.not_applicable;
            new.why.into_iter().for_each(|(why, count)| *sum.why.entry(why).or_default() += count);
        }
        if let Err(error) = std::fs::write(&self.file, table(&self.methods, &counts)) {
            eprintln!("{}: {error}", self.file);
        }
        eprintln!("{} seed {seed}", LAWS[law].about.name);
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, seeds, cases, order] = &arguments[..] else {
        return Err("usage: false_alarms FILE SEEDS CASES ORDER_SEEDS".into());
    };
    let (seeds, order): (u64, u64) = (seeds.parse()?, order.parse()?);
    let campaign = Campaign {
        methods: methods()?,
        file: file.clone(),
        cases: cases.parse()?,
        // The order; Casimirs, energy and reversibility.
        seeds: vec![order, seeds, seeds, seeds],
        next: AtomicU64::new(1),
        counts: Mutex::default(),
    };
    std::thread::scope(|scope| (0..2).for_each(|_| drop(scope.spawn(|| campaign.work()))));
    let counts = campaign.counts.lock().map_err(|_| "a thread panicked")?;
    println!("{}", table(&campaign.methods, &counts));
    for ((method, law), count) in counts.iter() {
        for (why, times) in &count.why {
            println!("{} {}: {times} {why}", campaign.methods[*method].name, LAWS[*law].about.name);
        }
    }
    let broken = counts.values().any(|count| count.broken > 0);
    Ok(if broken { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
