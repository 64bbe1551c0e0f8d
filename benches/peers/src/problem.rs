//! The initial value problems.

use crate::fields::{Field, Fluid, FourSpace, HeavyTop, LandauLifshitzGilbert, Plane, Relaxed, Special};
use crate::reference;

/// The most numbers in a state.
pub const LARGEST: usize = 22;

/// μ, then the attitude; zeros up to the full length.
///
/// The attitude is a matrix, row by row; on SE(3) that of the rotation and then the position, on SE(2) the cosine and the sine of the
/// angle and then the position.
pub type State = [f64; LARGEST];

/// Which vector field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum System {
    /// [`LandauLifshitzGilbert`].
    LandauLifshitzGilbert,
    /// [`Relaxed`].
    Relaxed,
    /// [`HeavyTop`].
    HeavyTop,
    /// [`Plane`].
    Plane,
    /// [`Special`].
    Special,
    /// [`Fluid`].
    Fluid,
    /// [`FourSpace`].
    FourSpace,
}

impl System {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::LandauLifshitzGilbert,
        Self::Relaxed,
        Self::HeavyTop,
        Self::Plane,
        Self::Special,
        Self::Fluid,
        Self::FourSpace,
    ];

    /// The word for it in files, and what it is, for titles.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::LandauLifshitzGilbert => ("llg", "SO(3), Landau–Lifshitz–Gilbert"),
            Self::Relaxed => ("relaxed", "SO(3), relaxed rigid body"),
            Self::HeavyTop => ("top", "SO(3), heavy top"),
            Self::Plane => ("plane", "SE(2), body with drag"),
            Self::Special => ("sl2", "SL(2), body with drag"),
            Self::Fluid => ("fluid", "SE(3), body in a fluid"),
            Self::FourSpace => ("so4", "SO(4), body with drag"),
        }
    }

    /// The word for it in files.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// How many numbers the momentum has.
    pub fn momentum(self) -> usize {
        self.initial().0.len()
    }

    /// How many numbers the state has.
    pub fn numbers(self) -> usize {
        let (momentum, attitude) = self.initial();
        momentum.len() + attitude.len()
    }

    /// The ends T of the intervals [0, T] on which it is solved.
    pub fn ends(self) -> &'static [f64] {
        if self == Self::Relaxed { &[1.0, 10.0, 1000.0] } else { &[1.0, 10.0] }
    }

    /// Momentum and attitude at 0, the identity.
    fn initial(self) -> (&'static [f64], &'static [f64]) {
        const C: f64 = std::f64::consts::FRAC_1_SQRT_2;
        const ROTATION: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        const MOTION: [f64; 12] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        const FOUR: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        match self {
            Self::LandauLifshitzGilbert | Self::Relaxed => (&[0.5 * C, 0.0, C], &ROTATION),
            Self::HeavyTop => (&[0.5, 0.3, 0.9], &ROTATION),
            Self::Plane => (&[0.5, 1.0, -0.5], &[1.0, 0.0, 0.0, 0.0]),
            Self::Special => (&[0.25, 1.0, -1.0], &[1.0, 0.0, 0.0, 1.0]),
            Self::Fluid => (&[0.5, -0.25, 1.0, 1.0, 0.5, -0.5], &MOTION),
            Self::FourSpace => (&[0.5, -0.25, 1.0, 1.0, 0.5, -0.5], &FOUR),
        }
    }

    /// The state at 0, at the identity. These `f64` are the initial values: the reference starts from them too.
    pub fn start(self) -> State {
        let mut start = [0.0; LARGEST];
        let (momentum, attitude) = self.initial();
        start[..momentum.len()].copy_from_slice(momentum);
        start[momentum.len()..][..attitude.len()].copy_from_slice(attitude);
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
pub type Reached<const K: usize> = Result<([f64; K], usize), String>;

/// A solver of any field, as its package is meant to be used.
pub trait Solve {
    /// The state at `end` from `start` at 0.
    ///
    /// # Errors
    /// Whatever the solver says.
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, tolerance: f64) -> Reached<K>;
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
            System::HeavyTop => self.on(HeavyTop, solver, tolerance),
            System::Plane => self.on(Plane, solver, tolerance),
            System::Special => self.on(Special, solver, tolerance),
            System::Fluid => self.on(Fluid, solver, tolerance),
            System::FourSpace => self.on(FourSpace, solver, tolerance),
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
        format!("{}, T = {}", self.system.words().1, self.end)
    }
}
