//! The method of order 8 of Dormand and Prince, written out, in fixed steps.
//!
//! The coefficients are those of E. Hairer and G. Wanner's code DOP853 (E. Hairer, S. P. Nørsett, G. Wanner, *Solving
//! Ordinary Differential Equations I*, second edition, 1993, II.5), rounded to `f64`; the stages that only its error
//! estimate and its interpolation need are left out, and so are the zeros.

use crate::fields::Field;
use crate::hindsight::FixedSteps;
use crate::problem::{Reached, Solve};

const A2: [f64; 1] = [0.05260015195876773];
const A3: [f64; 2] = [0.0197250569845379, 0.0591751709536137];
const A4: [f64; 2] = [0.02958758547680685, 0.08876275643042054];
const A5: [f64; 3] = [0.2413651341592667, -0.8845494793282861, 0.924834003261792];
const A6: [f64; 3] = [0.037037037037037035, 0.17082860872947386, 0.12546768756682242];
const A7: [f64; 4] = [0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125];
const A8: [f64; 5] =
    [0.03709200011850479, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023];
const A9: [f64; 6] = [
    0.6241109587160757,
    -3.3608926294469414,
    -0.868219346841726,
    27.59209969944671,
    20.154067550477894,
    -43.48988418106996,
];
const A10: [f64; 7] = [
    0.47766253643826434,
    -2.4881146199716677,
    -0.590290826836843,
    21.230051448181193,
    15.279233632882423,
    -33.28821096898486,
    -0.020331201708508627,
];
const A11: [f64; 8] = [
    -0.9371424300859873,
    5.186372428844064,
    1.0914373489967295,
    -8.149787010746927,
    -18.52006565999696,
    22.739487099350505,
    2.4936055526796523,
    -3.0467644718982196,
];
const A12: [f64; 9] = [
    2.273310147516538,
    -10.53449546673725,
    -2.0008720582248625,
    -17.9589318631188,
    27.94888452941996,
    -2.8589982771350235,
    -8.87285693353063,
    12.360567175794303,
    0.6433927460157636,
];
const B: [f64; 8] = [
    0.054293734116568765,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
];

/// y + h Σ a_j k_j.
#[inline(always)]
fn stage<const K: usize, const S: usize>(y: &[f64; K], h: f64, a: &[f64; S], slopes: [&[f64; K]; S]) -> [f64; K] {
    let mut out = [0.0; K];
    for i in 0..K {
        let mut sum = a[0] * slopes[0][i];
        for j in 1..S {
            sum += a[j] * slopes[j][i];
        }
        out[i] = y[i] + h * sum;
    }
    out
}

/// So many equal steps.
#[derive(Default)]
pub struct Dop853(usize);

impl FixedSteps for Dop853 {
    const NAME: &'static str = "DOP853 by hand, best step";

    fn with_steps(steps: usize) -> Self {
        Self(steps)
    }
}

impl Solve for Dop853 {
    fn run<F: Field<K>, const K: usize>(&mut self, field: F, start: &[f64; K], end: f64, _: f64) -> Reached<K> {
        let h = end / self.0 as f64;
        let slope = |y: [f64; K]| {
            let mut rate = [0.0; K];
            field.rates(&y, &mut rate);
            rate
        };
        let mut y = *start;
        for _ in 0..self.0 {
            let k1 = slope(y);
            let k2 = slope(stage(&y, h, &A2, [&k1]));
            let k3 = slope(stage(&y, h, &A3, [&k1, &k2]));
            let k4 = slope(stage(&y, h, &A4, [&k1, &k3]));
            let k5 = slope(stage(&y, h, &A5, [&k1, &k3, &k4]));
            let k6 = slope(stage(&y, h, &A6, [&k1, &k4, &k5]));
            let k7 = slope(stage(&y, h, &A7, [&k1, &k4, &k5, &k6]));
            let k8 = slope(stage(&y, h, &A8, [&k1, &k4, &k5, &k6, &k7]));
            let k9 = slope(stage(&y, h, &A9, [&k1, &k4, &k5, &k6, &k7, &k8]));
            let k10 = slope(stage(&y, h, &A10, [&k1, &k4, &k5, &k6, &k7, &k8, &k9]));
            let k11 = slope(stage(&y, h, &A11, [&k1, &k4, &k5, &k6, &k7, &k8, &k9, &k10]));
            let k12 = slope(stage(&y, h, &A12, [&k1, &k4, &k5, &k6, &k7, &k8, &k9, &k10, &k11]));
            y = stage(&y, h, &B, [&k1, &k6, &k7, &k8, &k9, &k10, &k11, &k12]);
        }
        Ok((y, self.0))
    }
}
