//! Serde for [`Dd`]: decimals as texts, with as many digits as give the same number back.

use super::{Dd, Real};
use serde::de::{Unexpected, Visitor};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Digits after the first that are tried in turn where those that are printed are too few: 33 are enough for two parts without a
/// gap between them, and the last for any sum of `f64`.
const DIGITS: [usize; 4] = [33, 66, 400, 1400];

/// The first decimal that is read as x.
fn lossless(x: Dd) -> Option<String> {
    let texts = DIGITS.iter().map(|digits| format!("{x:.digits$e}"));
    std::iter::once(x.to_string()).chain(texts).find(|text| Dd::parse_decimal(text) == Some(x))
}

/// Reads a decimal number from a text.
struct Text;

impl Visitor<'_> for Text {
    type Value = Dd;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a decimal number as a text, such as \"0.1\"")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Dd, E> {
        Dd::parse_decimal(text).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
    }
}

/// A decimal as a text, of which every digit is kept; what is not finite is refused.
impl Serialize for Dd {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let text = lossless(*self).ok_or_else(|| S::Error::custom(format_args!("{self} is no decimal number")))?;
        serializer.serialize_str(&text)
    }
}

impl<'de> Deserialize<'de> for Dd {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(Text)
    }
}
