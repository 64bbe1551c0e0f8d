//! How much of an error is of lower order than claimed, from signed errors at a sequence of step sizes.
//!
//! The local slopes of a line ([`convergence`](super::convergence)) are told after its levels reach their limit. This test does
//! not wait for that: it takes the whole Taylor series into account.
//!
//! A claim says that the errors fall at least as h^m: e(h) = h^m (a_0 + a_1 h + a_2 h² + …). Then g(h) = e(h)/h^{m−1} is a
//! smooth function with g(0) = 0. The polynomial of degree K through the values of g at K + 1 steps h_0 > … > h_K takes at 0 the
//! value B = Σ c_i g(h_i), c_i = Π_{j≠i} h_j/(h_j − h_i), and by the remainder of Lagrange
//!
//! B = g(0) − g^{(K+1)}(ϑ)/(K+1)! Π_i (−h_i),  0 ≤ ϑ ≤ h_0.
//!
//! The *share* |B|/|g(h_K)| is how much of the finest error is of the order m − 1 or lower.
//!
//! * Where the claim is right, B is the remainder alone: the first K terms of the series cancel exactly, however large they are
//!   and whatever their signs. So the share falls as h^K or faster: at K = 3, eight times an octave.
//! * Where the errors go as b h^{m−1}, B tends to b and the share to 1; where they go as b h^{m−1−k}, the share tends to
//!   a number above 1 (for k = 1 it is Σ h_K/h_i).
//!
//! The terms of a right claim may cancel in the finest error, so that the remainder is a large share of it. To refute a claim the unit
//! is therefore the largest of |g(h_i)| h_K/h_i, the size of the terms of order m. Where the errors are of the order m − 1 this is
//! |g(h_K)| itself.
//!
//! A claim is refuted where the share is at least a half for K = 2 and for K = 3, ending at each of the three finest levels of two
//! interlaced sequences of halved steps, and does not fall from the coarsest of these to the finest; and where the finest error is no
//! smaller, against those one to two octaves coarser, than the claim asks for. Without the last condition errors of a much higher order than claimed
//! could have a large remainder: with K = 2 that of h^{m+3} is larger than the finest error. A right claim is refuted only
//! if its series has a remainder that outweighs the three terms before it, at steps over an octave, and grows against them as the
//! steps shrink: no convergent series does so at steps well below its radius. The noise enters with its bound, amplified as the
//! formula says.

use super::convergence::{NOISE_MARGIN, TOLERANCE};

/// A signed error (the components of a vector) at one step size.
#[derive(Clone, Debug, PartialEq)]
pub struct Signed {
    /// The step, > 0.
    pub h: f64,
    /// The components of the error.
    pub error: Vec<f64>,
    /// What rounding may do to a component, ≥ 0; may be short by a factor of [`NOISE_MARGIN`].
    pub noise: f64,
}

/// What a line says about a claim that its errors fall at least as a power of the step.
#[derive(Clone, Debug, PartialEq)]
pub enum Share {
    /// No more than this much of the finest error is of lower order: at most a quarter.
    Small(f64),
    /// No less than this much of it is of lower order: at least a half.
    Large(f64),
    /// Neither is certain.
    Open,
}

/// The share from which a claim is refuted.
const LARGE: f64 = 0.5;

/// The most noise that a share may have.
const NOISY: f64 = 0.125;

/// The degrees of the polynomials.
const DEGREES: [usize; 2] = [2, 3];

/// How many levels in a row must agree.
const ENDS: usize = 3;

/// By how much the share may fall from one octave to the next and still be taken as one that does not: three quarters of it
/// remain. A share that goes as h² keeps a quarter.
const KEPT: f64 = 0.75;

/// The ratio of two steps that counts as an octave: 2 but for rounding.
const OCTAVE: f64 = 1.9;

/// The same of two octaves.
const OCTAVES: f64 = 4.2;

fn size(error: &[f64]) -> f64 {
    error.iter().fold(0.0, |m: f64, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// B in units of the finest error, and its direction.
struct Part {
    share: f64,
    noise: f64,
    direction: Vec<f64>,
    /// That unit in units of the largest error of the nodes, each reduced to the finest step as the claim says: at most 1.
    unit: f64,
}

impl Part {
    /// How much of the errors is of lower order at least, where the claimed terms may cancel in the finest one.
    fn low(&self) -> f64 {
        (self.share - self.noise) * self.unit
    }
}

/// B h_K^{m−1} from the levels `nodes` (the finest last) for errors claimed to go as h^m.
fn part(nodes: &[&Signed], power: f64) -> Part {
    let finest = nodes[nodes.len() - 1];
    let mut direction = vec![0.0; finest.error.len()];
    let mut noise = 0.0;
    for (i, node) in nodes.iter().enumerate() {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = others.map(|(_, other)| other.h / (other.h - node.h)).product();
        let weight = weight * (finest.h / node.h).powf(power - 1.0);
        direction.iter_mut().zip(&node.error).for_each(|(sum, e)| *sum += weight * e);
        noise += weight.abs() * NOISE_MARGIN * node.noise;
    }
    // Where the error passes through 0, the level before it says how large it is otherwise.
    let before = nodes[nodes.len() - 2];
    let unit = size(&finest.error).max(0.5 * size(&before.error) * (finest.h / before.h).powf(power));
    let reduced = nodes.iter().map(|node| size(&node.error) * (finest.h / node.h).powf(power)).fold(unit, f64::max);
    Part { share: size(&direction) / unit, noise: noise / unit, direction, unit: unit / reduced }
}

/// Whether the finest of these levels (the finest last) is smaller, against one that is coarser by up to two octaves, than the claim
/// asks for; or there is none.
fn falls(line: &[&Signed], power: f64) -> bool {
    let finest = line[line.len() - 1];
    let mut coarser =
        line.iter().filter(|level| level.h >= OCTAVE * finest.h && level.h < OCTAVES * finest.h).peekable();
    coarser.peek().is_none()
        || coarser.any(|level| size(&finest.error) < size(&level.error) * (finest.h / level.h).powf(power))
}

/// What the levels (any sequence) say about the claim that the errors fall at least as h^power; `None` at less than six levels
/// above the noise, over two and a half octaves if the levels are two an octave.
///
/// The levels of two interlaced sequences of halved steps are wanted: with nine or more of them the polynomials go through every
/// second one.
pub fn share(levels: &[Signed], power: u32) -> Option<Share> {
    let mut line: Vec<&Signed> = levels.iter().collect();
    line.sort_by(|a, b| b.h.total_cmp(&a.h));
    let valid = |level: &&Signed| level.h > 0.0 && level.noise >= 0.0 && (size(&level.error) + level.noise).is_finite();
    if !line.iter().all(valid) || line.windows(2).any(|pair| pair[0].h < 1.05 * pair[1].h) {
        return None;
    }
    let power = f64::from(power);
    let most = DEGREES[DEGREES.len() - 1];
    let at = |end: usize, degree: usize, stride: usize| {
        let nodes: Vec<&Signed> = (0..=degree).rev().map(|k| line[end - k * stride]).collect();
        part(&nodes, power)
    };
    let mut open = None;
    for stride in [2, 1] {
        let first = most * stride + ENDS - 1;
        // The finest level at which noise does not matter.
        let end = (first..line.len()).rev().find(|end| {
            (0..ENDS).all(|k| {
                let finest = line[end - k];
                size(&finest.error) > NOISE_MARGIN * finest.noise && at(end - k, most, stride).noise <= NOISY
            })
        });
        let Some(end) = end else { continue };
        let parts: Vec<Part> = (0..ENDS).flat_map(|k| DEGREES.map(|degree| at(end - k, degree, stride))).collect();
        let low = parts.iter().map(Part::low).fold(f64::INFINITY, f64::min);
        let high = parts.iter().map(|part| part.share + part.noise).fold(0.0, f64::max);
        let (last, before) = (at(end, most, stride), at(end + 1 - ENDS, most, stride));
        let same: f64 = last.direction.iter().zip(&before.direction).map(|(x, y)| x * y).sum();
        let stays = last.share >= KEPT * before.share && same > 0.0 && !falls(&line[..=end], power);
        let finest = line[end];
        let explained = line[end + 1..].iter().all(|level| {
            let predicted = size(&finest.error) * (level.h / finest.h).powf(power - TOLERANCE);
            size(&level.error) <= 1.25 * predicted + NOISE_MARGIN * level.noise.max(finest.noise)
        });
        match () {
            () if low >= LARGE && stays => return Some(Share::Large(low)),
            () if high <= TOLERANCE && explained => return Some(Share::Small(high)),
            () => open = Some(Share::Open),
        }
    }
    open
}
