//! The precision ladder: the same defect at several precisions tells rounding from error.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/harness/ladder.md"))]

/// A defect at one precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// u, > 0.
    pub unit_roundoff: f64,
    /// |lhs − rhs|, relative to the size of the terms, ≥ 0.
    pub defect: f64,
}

/// What a defect is.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// It shrinks with u: defect ≤ `amplification` u at every precision.
    Rounding {
        /// The largest defect/u.
        amplification: f64,
    },
    /// It stays: this much of it is left at the highest precision.
    Error {
        /// The defect there.
        remains: f64,
    },
    /// Neither.
    Unclear {
        /// The exponent s, where there is one.
        exponent: Option<f64>,
        /// The reason.
        why: &'static str,
    },
}

/// How far the amplifications of rounding at different precisions may be apart: they are samples of one distribution.
pub const SPREAD: f64 = 256.0;

/// The cause of a defect, from the same evaluation at two precisions or more, in any sequence.
///
/// Rounding: the amplifications defect/u agree within [`SPREAD`], or are below it. Error: from the lowest to the highest
/// precision the defect loses less than a quarter of the digits that it would lose as rounding, or one in the middle does not
/// go on shrinking.
pub fn cause(samples: &[Sample]) -> Cause {
    let unclear = |exponent, why| Cause::Unclear { exponent, why };
    let valid = |sample: &Sample| {
        sample.unit_roundoff > 0.0
            && sample.unit_roundoff.is_finite()
            && sample.defect >= 0.0
            && sample.defect.is_finite()
    };
    if !samples.iter().all(valid) {
        return unclear(None, "a defect or a unit round-off is not a number in its range");
    }
    let mut samples = samples.to_vec();
    samples.sort_by(|a, b| b.unit_roundoff.total_cmp(&a.unit_roundoff));
    let ([first, ..], [.., last]) = (samples.as_slice(), samples.as_slice()) else {
        return unclear(None, "there are no precisions");
    };
    if first.unit_roundoff < 1e3 * last.unit_roundoff {
        return unclear(None, "two precisions are needed, three digits or more apart");
    }
    let amplifications = || samples.iter().map(|sample| sample.defect / sample.unit_roundoff);
    let largest = amplifications().fold(0.0, f64::max);
    let least = amplifications().fold(f64::INFINITY, f64::min);
    if largest <= SPREAD * least.max(1.0) {
        return Cause::Rounding { amplification: largest };
    }
    // How much of the digits between two samples the defect followed; a defect of 0 has followed them all.
    let exponent = |coarse: &Sample, fine: &Sample| {
        let least = fine.unit_roundoff.min(coarse.unit_roundoff) * 1e-3;
        (coarse.defect.max(least) / fine.defect.max(least)).ln() / (coarse.unit_roundoff / fine.unit_roundoff).ln()
    };
    let (whole, tail) = (exponent(first, last), exponent(&samples[samples.len() - 2], last));
    if whole.min(tail) < 0.25 {
        return Cause::Error { remains: last.defect };
    }
    unclear(Some(whole), "the defect shrinks with the precision, but not in proportion")
}
