//! Numbers that a law needs beyond those of its case: a stream that the case determines.
//!
//! Group elements, directions and variations are drawn from a splitmix64 stream seeded with an FNV-1a hash of the
//! printed case, so a case that is replayed meets the same ones. All are dyadic with few bits: exact in every scalar.

use crate::algebra::{Covector, Vector};
use crate::scalar::Scalar;
use std::fmt::Debug;

/// The stream of a case.
#[derive(Clone, Debug)]
pub struct Probe(u64);

impl Probe {
    /// The stream of `case`; `salt` tells the uses within a law apart.
    pub fn new(case: &dyn Debug, salt: u64) -> Self {
        let text = format!("{case:?}");
        let hash = text
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
        Self(hash ^ salt.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Sixty-four random bits.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// An integer in low ..= high.
    pub fn integer(&mut self, low: i32, high: i32) -> i32 {
        low + (self.next() % (high - low + 1) as u64) as i32
    }

    /// k/64 with |k| ≤ 64, never 0.
    pub fn unit<S: Scalar>(&mut self) -> S {
        let k = i64::from(self.integer(1, 64));
        S::int(if self.next() & 1 == 0 { k } else { -k }) * S::exact(1.0 / 64.0)
    }

    /// A vector with such components.
    pub fn vector<S: Scalar, const N: usize>(&mut self) -> Vector<S, N> {
        Vector::from_fn(|_, _| self.unit())
    }

    /// A covector with such components.
    pub fn covector<S: Scalar, const N: usize>(&mut self) -> Covector<S, N> {
        Covector::from_fn(|_, _| self.unit())
    }

    /// 2^k with k in low ..= high.
    pub fn power_of_two<S: Scalar>(&mut self, low: i32, high: i32) -> S {
        S::exact(2f64.powi(self.integer(low, high)))
    }
}
