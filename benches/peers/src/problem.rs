//! The initial value problems, as plain vector fields y' = f(y).

use crate::reference;

/// The most numbers in a state.
pub const LARGEST: usize = 18;

/// μ, then the attitude row by row (and the position); zeros up to the full length.
pub type State = [f64; LARGEST];

/// An autonomous vector field on K numbers.
pub trait Field<const K: usize>: Copy + Send + Sync + 'static {
    /// `rate` ← f(y).
    fn rates(&self, y: &[f64; K], rate: &mut [f64; K]);
}

/// A rigid body with damping of Landau, Lifshitz and Gilbert: M' = M×Ω + M×(M×Ω), R' = R Ω̂.
#[derive(Clone, Copy, Debug)]
pub struct LandauLifshitzGilbert;

/// The relaxed rigid body: M' = M×Ω + (1/10) (Ω×M)×Ω, R' = R Ω̂.
#[derive(Clone, Copy, Debug)]
pub struct Relaxed;

/// A body in a fluid: π' = π×ω + p×v + f, p' = p×ω + f, f = −(1+|η|)/8 η, R' = R ω̂, x' = R v.
#[derive(Clone, Copy, Debug)]
pub struct Fluid;

/// 1 / I of the bodies on SO(3), I = diag(½, 2, 1).
const INVERSE_INERTIA: [f64; 3] = [2.0, 0.5, 1.0];

/// 1 / I of the body in a fluid, I = diag(½, 2, 1, 3, 3/2, 5/4).
const INVERSE_INERTIA_SE3: [f64; 6] = [2.0, 0.5, 1.0, 1.0 / 3.0, 2.0 / 3.0, 0.8];

fn cross(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// (M, Ω) of a body on SO(3).
fn body(y: &[f64; 12]) -> ([f64; 3], [f64; 3]) {
    let m = [y[0], y[1], y[2]];
    (m, [m[0] * INVERSE_INERTIA[0], m[1] * INVERSE_INERTIA[1], m[2] * INVERSE_INERTIA[2]])
}

/// R' = R Ω̂: the rows of R, at `from` in the state, times the hat matrix.
fn turn<const K: usize>(y: &[f64; K], omega: [f64; 3], rate: &mut [f64; K], from: usize) {
    for row in 0..3 {
        let k = from + 3 * row;
        let r = cross([y[k], y[k + 1], y[k + 2]], omega);
        rate[k..k + 3].copy_from_slice(&r);
    }
}

impl Field<12> for LandauLifshitzGilbert {
    #[inline(always)]
    fn rates(&self, y: &[f64; 12], rate: &mut [f64; 12]) {
        let (m, omega) = body(y);
        let torque = cross(m, omega);
        let damping = cross(m, torque);
        for a in 0..3 {
            rate[a] = torque[a] + damping[a];
        }
        turn(y, omega, rate, 3);
    }
}

impl Field<12> for Relaxed {
    #[inline(always)]
    fn rates(&self, y: &[f64; 12], rate: &mut [f64; 12]) {
        let (m, omega) = body(y);
        let torque = cross(m, omega);
        let damping = cross(torque, omega);
        for a in 0..3 {
            rate[a] = torque[a] - 0.1 * damping[a];
        }
        turn(y, omega, rate, 3);
    }
}

impl Field<18> for Fluid {
    #[inline(always)]
    fn rates(&self, y: &[f64; 18], rate: &mut [f64; 18]) {
        let mut eta = [0.0; 6];
        for a in 0..6 {
            eta[a] = y[a] * INVERSE_INERTIA_SE3[a];
        }
        let (omega, v) = ([eta[0], eta[1], eta[2]], [eta[3], eta[4], eta[5]]);
        let (pi, p) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
        let (turned, pushed, moved) = (cross(pi, omega), cross(p, v), cross(p, omega));
        let drag = 0.125 * (1.0 + eta.iter().map(|e| e * e).sum::<f64>().sqrt());
        for a in 0..3 {
            rate[a] = turned[a] + pushed[a] - drag * omega[a];
            rate[3 + a] = moved[a] - drag * v[a];
        }
        turn(y, omega, rate, 6);
        for row in 0..3 {
            let k = 6 + 3 * row;
            rate[15 + row] = y[k] * v[0] + y[k + 1] * v[1] + y[k + 2] * v[2];
        }
    }
}

/// Which vector field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum System {
    /// [`LandauLifshitzGilbert`].
    LandauLifshitzGilbert,
    /// [`Relaxed`].
    Relaxed,
    /// [`Fluid`].
    Fluid,
}

impl System {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::LandauLifshitzGilbert, Self::Relaxed, Self::Fluid];

    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LandauLifshitzGilbert => "llg",
            Self::Relaxed => "relaxed",
            Self::Fluid => "fluid",
        }
    }

    /// What it is, for titles.
    pub fn title(self) -> &'static str {
        match self {
            Self::LandauLifshitzGilbert => "SO(3), Landau–Lifshitz–Gilbert",
            Self::Relaxed => "SO(3), relaxed rigid body",
            Self::Fluid => "SE(3), body in a fluid",
        }
    }

    /// How many numbers the momentum has.
    pub fn momentum(self) -> usize {
        if self == Self::Fluid { 6 } else { 3 }
    }

    /// How many numbers the state has.
    pub fn numbers(self) -> usize {
        if self == Self::Fluid { 18 } else { 12 }
    }

    /// The ends T of the intervals [0, T] on which it is solved.
    pub fn ends(self) -> &'static [f64] {
        if self == Self::Relaxed { &[1.0, 10.0, 1000.0] } else { &[1.0, 10.0] }
    }

    /// The state at 0, at the identity. These `f64` are the initial values: the reference starts from them too.
    pub fn start(self) -> State {
        let mut start = [0.0; LARGEST];
        let c = std::f64::consts::FRAC_1_SQRT_2;
        let (momentum, n): (&[f64], _) = match self {
            Self::Fluid => (&[0.5, -0.25, 1.0, 1.0, 0.5, -0.5], 6),
            _ => (&[0.5 * c, 0.0, c], 3),
        };
        start[..n].copy_from_slice(momentum);
        for axis in 0..3 {
            start[n + 4 * axis] = 1.0;
        }
        start
    }
}

/// A system on an interval, with the solution at its end.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The vector field.
    pub system: System,
    /// T.
    pub end: f64,
    /// The state at 0.
    pub start: State,
    /// The state at T, known far better than any solver here can compute it.
    pub reference: State,
}

/// What a solver reached: the state at T, and in how many steps.
pub type Reached<const K: usize> = ([f64; K], usize);

/// A solver of any field, as its package is meant to be used.
pub trait Solve {
    /// The state at `end` from `start` at 0.
    ///
    /// # Errors
    /// Whatever the solver says.
    fn run<F: Field<K>, const K: usize>(
        &mut self,
        field: F,
        start: &[f64; K],
        end: f64,
        tolerance: f64,
    ) -> Result<Reached<K>, String>;
}

impl Problem {
    /// Every problem.
    pub fn all() -> Vec<Self> {
        let on = |system: System| {
            system.ends().iter().map(move |&end| Self {
                system,
                end,
                start: system.start(),
                reference: reference::stored(system, end).expect("every problem has a reference"),
            })
        };
        System::ALL.into_iter().flat_map(on).collect()
    }

    /// Solves it with a general-purpose solver: the state at T and the number of steps.
    ///
    /// # Errors
    /// The solver's.
    #[inline]
    pub fn solve_with(&self, solver: &mut impl Solve, tolerance: f64) -> Result<(State, usize), String> {
        match self.system {
            System::LandauLifshitzGilbert => self.on(LandauLifshitzGilbert, solver, tolerance),
            System::Relaxed => self.on(Relaxed, solver, tolerance),
            System::Fluid => self.on(Fluid, solver, tolerance),
        }
    }

    #[inline]
    fn on<F: Field<K>, const K: usize>(
        &self,
        field: F,
        solver: &mut impl Solve,
        tolerance: f64,
    ) -> Result<(State, usize), String> {
        let start = self.start.first_chunk::<K>().expect("a state is no longer than the longest");
        let (reached, steps) = solver.run(field, start, self.end, tolerance)?;
        let mut state = [0.0; LARGEST];
        state[..K].copy_from_slice(&reached);
        Ok((state, steps))
    }

    /// The largest error of a component of momentum or attitude; NaN if there is one.
    pub fn error(&self, state: &State) -> f64 {
        state.iter().zip(&self.reference).fold(0.0, |worst, (x, y)| {
            let error = (x - y).abs();
            if error > worst || error.is_nan() { error } else { worst }
        })
    }

    /// The title of its panel.
    pub fn title(&self) -> String {
        format!("{}, T = {}", self.system.title(), self.end)
    }
}
