//! `f64` as a [`Scalar`].

use super::{Real, Scalar};

impl Scalar for f64 {
    super::without_duals!();

    #[inline]
    fn unit_roundoff() -> f64 {
        f64::EPSILON / 2.0
    }

    #[inline]
    fn exact(x: f64) -> f64 {
        x
    }

    #[inline]
    fn int(n: i64) -> f64 {
        n as f64
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline]
    fn vanishes(self) -> bool {
        self == 0.0
    }

    #[inline]
    fn all_finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for f64 {
    const NAME: &'static str = "f64";

    #[inline]
    fn parse_decimal(text: &str) -> Option<f64> {
        text.parse().ok().filter(|x: &f64| x.is_finite())
    }
}
