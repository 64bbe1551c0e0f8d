//! Optimal control: the turn of a body from rest to rest with the least torque, ½ ∫ |f|² dt. The end of the run and its derivatives by the
//! parameters of the torque come from one run; the optimiser replaces the conditions at the end by their tangents.
//!
//! `cargo run --release --example turn`

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::integrators::derivative::{Linearised, Parameters};
use euler_poincare::integrators::{State, Variational};
use euler_poincare::mechanics::configuration::Configuration;
use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
use euler_poincare::retraction::{ExponentialSo3, Retraction, TangentPoint};
use euler_poincare::scalar::Scalar;
use euler_poincare::tableau::Family;
use nalgebra::{SMatrix, SVector};
use std::error::Error;

/// Polynomials for each component of the torque: Legendre's P₀ … P₃.
const SHAPES: usize = 4;
const PARAMETERS: usize = 3 * SHAPES;
/// Conditions at the end: the attitude and rest.
const CONDITIONS: usize = 6;

/// The duration T, and the steps of a run.
const DURATION: f64 = 2.0;
const STEPS: usize = 20;

/// How often the conditions are replaced by their tangents.
const ROUNDS: usize = 20;

type Values = SVector<f64, PARAMETERS>;
type Ends = SVector<f64, CONDITIONS>;
type Slopes = SMatrix<f64, CONDITIONS, PARAMETERS>;

/// f_a(t) = Σ_k p_ak P_k(2t/T − 1), for which ½ ∫ |f|² dt = ½ Σ p_ak² T/(2k + 1).
#[derive(Clone)]
struct Torque(Values);

impl Torque {
    fn shapes<S: Scalar<Base = f64>>(t: S) -> [S; SHAPES] {
        let x = t * S::exact(2.0 / DURATION) - S::one();
        let square = x * x;
        [S::one(), x, (square * S::int(3) - S::one()) * S::half(), x * (square * S::int(5) - S::int(3)) * S::half()]
    }

    /// The weight of p_k² in twice the cost.
    fn weight(k: usize) -> f64 {
        DURATION / (2 * (k % SHAPES) + 1) as f64
    }
}

impl Force<f64, 3> for Torque {
    fn force<S: Scalar<Base = f64>>(&self, t: S, _: &Vector<S, 3>) -> Covector<S, 3> {
        let shapes = Self::shapes(t);
        Covector::from_fn(|_, a| {
            (0..SHAPES).fold(S::zero(), |sum, k| sum + S::exact(self.0[SHAPES * a + k]) * shapes[k])
        })
    }
}

/// How the torque depends on its parameters.
struct Shapes;

impl Parameters<f64, 3> for Shapes {
    fn count(&self) -> usize {
        PARAMETERS
    }

    fn force(&self, k: usize, t: f64, _: Configuration<'_, f64>, _: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if a == k / SHAPES { Torque::shapes(t)[k % SHAPES] } else { 0.0 })
    }
}

/// A turn that is looked for, to a target attitude.
struct Turn {
    body: Quadratic<f64, 3>,
    target: Matrix<f64, 3>,
}

impl Turn {
    /// To exp(x).
    fn new(body: &Quadratic<f64, 3>, x: Vector<f64, 3>) -> Result<Self, Box<dyn Error>> {
        Ok(Self { body: body.clone(), target: ExponentialSo3::<f64>::new().tau(&x)? })
    }

    /// The conditions log(target⁻¹ g) = 0, μ = 0 at the end, and their derivatives by the parameters.
    fn end(&self, values: &Values) -> Result<(Ends, Slopes), Box<dyn Error>> {
        let tau = ExponentialSo3::new();
        let gauss = Family::Gauss.tableau(2)?;
        let method = Variational::new(self.body.clone(), Torque(*values), tau.clone(), gauss);
        let mut state = State::at_identity(Covector::<f64, 3>::zeros());
        let step = DURATION / STEPS as f64;
        let derivative = Linearised::new(method, Shapes).sensitivity(&mut state, step, STEPS, |_, _, _| {})?;
        let off = tau.tau_inv(&(self.target.transpose() * state.attitude))?;
        let ends = Ends::from_fn(|c, _| if c < 3 { off[c] } else { state.momentum[c - 3] });
        // log(g exp ζ) = log g + dτ⁻¹ ζ.
        let point = tau.at(&off)?;
        let mut slopes = Slopes::zeros();
        for (k, along) in derivative.by_parameters().enumerate() {
            slopes.fixed_view_mut::<3, 1>(0, k).copy_from(&(point.d_inv() * along.attitude));
            slopes.fixed_view_mut::<3, 1>(3, k).copy_from(&along.momentum.transpose());
        }
        Ok((ends, slopes))
    }

    /// The least torque. Where the conditions c(p) = 0 are replaced by their tangents c + J δ = 0 at the last p, it is
    /// W⁻¹Jᵀ (J W⁻¹ Jᵀ)⁻¹ (J p − c) with the weights W of the cost; each round leaves a fifth of the error.
    fn least(&self) -> Result<Values, Box<dyn Error>> {
        let mut values = Values::zeros();
        for _ in 0..ROUNDS {
            let (ends, slopes) = self.end(&values)?;
            let weighted = SMatrix::<f64, PARAMETERS, CONDITIONS>::from_fn(|k, c| slopes[(c, k)] / Torque::weight(k));
            let normal = (slopes * weighted).cholesky().ok_or("the conditions depend on each other")?;
            values = weighted * normal.solve(&(slopes * values - ends));
        }
        Ok(values)
    }
}

/// ½ ∫ |f|² dt.
fn cost(values: &Values) -> f64 {
    (0..PARAMETERS).map(|k| Torque::weight(k) * values[k].powi(2) / 2.0).sum()
}

fn main() -> Result<(), Box<dyn Error>> {
    // About a principal axis f = 6 I θ (1 − 2t/T)/T², and the cost is 6 I² θ²/T³.
    let (moment, angle) = (2.0, 2.0);
    let body = Quadratic::diagonal([0.5, moment, 1.0])?;
    let simple = Turn::new(&body, Vector::<f64, 3>::new(0.0, angle, 0.0))?;
    let values = simple.least()?;
    let formula = 6.0 * (moment * angle).powi(2) / DURATION.powi(3);
    println!("about the second axis: cost {:.9}, by the formula {formula}", cost(&values));
    assert!(simple.end(&values)?.0.amax() < 1e-12 && (cost(&values) / formula - 1.0).abs() < 1e-9);

    // About another, all components of the torque are needed.
    let turn = Turn::new(&body, Vector::<f64, 3>::new(0.5, 1.0, -0.75))?;
    let values = turn.least()?;
    let (ends, slopes) = turn.end(&values)?;
    println!("about another: cost {:.9}, conditions at the end to {:.1e}", cost(&values), ends.amax());
    // Along the conditions the cost is stationary: its gradient is a combination of theirs.
    let gradient = Values::from_fn(|k, _| Torque::weight(k) * values[k]);
    let normals = slopes.transpose().qr().q();
    let along = (gradient - normals * (normals.transpose() * gradient)).amax() / gradient.amax();
    println!("gradient of the cost along the conditions: {along:.1e} of all");
    assert!(ends.amax() < 1e-12 && along < 1e-10);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
