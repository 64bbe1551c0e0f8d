//! A tableau as a plain value that a person can read and write: a name, or its entries as exact numbers.

use super::families::MAX_STAGES;
use super::{ALIKE, Classic, Family, Tableau, TableauError, entry_name};
use crate::scalar::{Number, Real};
use std::fmt;
use std::str::FromStr;

/// Which tableau; [`Description::build`] makes it, at the full precision of any scalar.
///
/// As text: `gauss-S`, `lobatto-iiia-S` to `lobatto-iiie-S`, `radau-ia-S`, `radau-iia-S` with the number of stages S, or
/// `euler`, `heun2`, `ralston3`, `rk4`, `kutta38`, `sdirk2`, `sdirk3`, `alexander2`, `alexander3`. With the feature `harness`,
/// (de)serialised as that text, or as a table `{ a = [[…], …], b = […] }` with an optional `c`.
///
/// ```
/// use euler_poincare::tableau::{Description, variational_order};
/// let radau: Description = "radau-iia-2".parse()?;
/// assert_eq!(variational_order(&radau.build::<f64>()?, 6).order, 3);
/// let unknown = "gauss-0".parse::<Description>().unwrap_err();
/// assert_eq!(unknown.to_string(), "gauss-0: the number of stages must be from 1 to 64");
/// # Ok::<(), euler_poincare::tableau::TableauError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Description {
    /// The member of a family with this many stages.
    Family(Family, usize),
    /// A classical tableau.
    Classic(Classic),
    /// Any tableau.
    Entries(Entries),
}

/// The entries of a tableau, exactly as given.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "harness", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Entries {
    /// a_ij, by rows.
    pub a: Vec<Vec<Number>>,
    /// b_j, none of them 0.
    pub b: Vec<Number>,
    /// c_i: redundant, but checked if given: it must be the row sum Σ_j a_ij.
    #[cfg_attr(feature = "harness", serde(default, skip_serializing_if = "Option::is_none"))]
    pub c: Option<Vec<Number>>,
}

impl Description {
    /// The tableau with these entries; see [`Entries::build`].
    pub fn entries(a: Vec<Vec<Number>>, b: Vec<Number>) -> Self {
        Description::Entries(Entries { a, b, c: None })
    }

    /// The tableau in `T`.
    ///
    /// # Errors
    /// Those of [`Family::tableau`] and [`Entries::build`].
    pub fn build<T: Real>(&self) -> Result<Tableau<T>, TableauError> {
        match self {
            Description::Family(family, stages) => family.tableau(*stages),
            Description::Classic(classic) => classic.tableau(),
            Description::Entries(entries) => entries.build(),
        }
    }

    /// The number of stages.
    pub fn stages(&self) -> usize {
        match self {
            Description::Family(_, stages) => *stages,
            Description::Classic(classic) => classic.stages(),
            Description::Entries(entries) => entries.b.len(),
        }
    }

    /// The order as a plain Runge–Kutta method that the literature gives for this name; `None` for entries.
    pub fn declared(&self) -> Option<usize> {
        match self {
            Description::Family(family, stages) => Some(family.declared(*stages)),
            Description::Classic(classic) => Some(classic.declared()),
            Description::Entries(_) => None,
        }
    }

    /// What to count it under: the name of the family or of the classical tableau, or `explicit`, `diagonally-implicit` or
    /// `fully-implicit` by the zeros of the entries.
    pub fn kind(&self) -> &'static str {
        match self {
            Description::Family(family, _) => family.name(),
            Description::Classic(classic) => classic.name(),
            Description::Entries(entries) => entries.kind(),
        }
    }
}

impl Entries {
    /// The tableau in `T`.
    ///
    /// Σb = 1 must hold to round-off, or to the digits given: each b_j that is a rounded decimal may be off
    /// by its [uncertainty](Number::uncertainty), and everything else is exact. If the sum is off by no more than
    /// that, b is divided by its sum. The same allowance is made in comparing c with the row sums of a; a itself is
    /// never changed.
    ///
    /// # Errors
    /// [`TableauError::BadEntry`] for an entry without a value in `T` or a c_i that is not the row sum, and those of
    /// [`Tableau::new`].
    pub fn build<T: Real>(&self) -> Result<Tableau<T>, TableauError> {
        let mut a = Vec::with_capacity(self.a.len());
        for (i, row) in self.a.iter().enumerate() {
            a.push(row.iter().enumerate().map(|(j, x)| value(x, || entry_name(i, j))).collect::<Result<Vec<T>, _>>()?);
        }
        let mut b = vector(&self.b, "b")?;
        let sum = b.iter().fold(T::zero(), |sum, &x| sum + x);
        let off = (sum - T::one()).abs();
        let noise = roundoff(&b);
        if off > noise && off <= self.b.iter().fold(noise, |slack, x| slack + x.uncertainty()) {
            b.iter_mut().for_each(|x| *x /= sum);
        }
        let tableau = Tableau::new(&a, &b)?;
        if let Some(c) = &self.c {
            self.check_row_sums(&tableau, &vector(c, "c")?, c)?;
        }
        Ok(tableau)
    }

    /// Half the widths of the intervals that the entries of a (by rows), then of b, stand for; 0 for what is exact, and throughout where
    /// no entry [counts as rounded](Number::uncertainty).
    ///
    /// Each entry has its [uncertainty](Number::uncertainty), and a decimal of 16 or 17 significant digits, which is how an `f64` is
    /// printed, eight times that: coefficients computed in `f64` are seldom right to the last bit. With `uniform`, decimals of fewer
    /// places (dyadic ones apart) are taken to have had zeros at the end, and the smallest of these widths, or that of an `f64`.
    pub fn allowances(&self, uniform: bool) -> Vec<f64> {
        let numbers = || self.a.iter().flatten().chain(&self.b);
        let own: Vec<f64> = numbers().map(own_allowance).collect();
        let least = own.iter().copied().filter(|&own| own > 0.0).fold(f64::INFINITY, f64::min);
        if !uniform || least.is_infinite() {
            return own;
        }
        let printed = numbers().any(|x| matches!(significant(&x.to_string()), 16 | 17));
        let alike = |(x, own): (&Number, f64)| match x.eval::<f64>() {
            Ok(value) if own > 0.0 || is_short(x, value) => {
                let unit = 4.0 * f64::EPSILON * value.abs();
                if !printed {
                    least
                } else if own > 0.0 {
                    own.min(unit.max(least))
                } else {
                    unit
                }
            }
            _ => 0.0,
        };
        numbers().zip(own).map(alike).collect()
    }

    fn check_row_sums<T: Real>(&self, tableau: &Tableau<T>, c: &[T], given: &[Number]) -> Result<(), TableauError> {
        check_count(c.len(), tableau.stages())?;
        for i in 0..c.len() {
            let mut terms = self.a[i].iter().map(|x| value(x, String::new)).collect::<Result<Vec<T>, _>>()?;
            terms.push(c[i]);
            let slack = self.a[i].iter().fold(given[i].uncertainty(), |slack: T, x| slack + x.uncertainty());
            let sum = tableau.c()[i];
            if (c[i] - sum).abs() > roundoff(&terms) + slack {
                let (c, sum, apart) = (c[i].to_f64(), sum.to_f64(), (c[i] - sum).to_f64());
                let apart =
                    if apart.abs() < ALIKE { format!(", which differs by {:e}", apart.abs()) } else { String::new() };
                return Err(no_row_sum(i, c, format!("{sum}{apart}")));
            }
        }
        Ok(())
    }

    fn kind(&self) -> &'static str {
        let zero = |i: usize, j: usize| self.a[i][j].eval::<f64>() == Ok(0.0);
        let all = |first: usize| (0..self.a.len()).all(|i| (i + first..self.a[i].len()).all(|j| zero(i, j)));
        match (all(0), all(1)) {
            (true, _) => "explicit",
            (_, true) => "diagonally-implicit",
            _ => "fully-implicit",
        }
    }
}

/// Refuses a c with another number of entries than there are stages.
pub(super) fn check_count(found: usize, stages: usize) -> Result<(), TableauError> {
    let why = || format!("has {found} entries, but b has {stages}");
    if found == stages { Ok(()) } else { Err(TableauError::BadEntry { entry: "c".into(), why: why() }) }
}

/// A c_i, i from 0, that is not the sum of its row.
pub(super) fn no_row_sum(i: usize, c: impl fmt::Display, sum: impl fmt::Display) -> TableauError {
    let row = i + 1;
    let why = format!("is {c}, but row {row} of a sums to {sum} (c may be left out: it is the row sum)");
    TableauError::BadEntry { entry: format!("c_{row}"), why }
}

/// Half the width of the interval of one entry.
fn own_allowance(x: &Number) -> f64 {
    let uncertainty: f64 = x.uncertainty();
    if matches!(significant(&x.to_string()), 16 | 17) { 8.0 * uncertainty } else { uncertainty }
}

/// The number of significant digits of a decimal.
pub(super) fn significant(text: &str) -> usize {
    let mantissa = text.split(['e', 'E']).next().unwrap_or(text);
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    digits.trim_matches('0').len()
}

/// Whether a number is a decimal with one or two places, and no multiple of 1/4.
fn is_short(x: &Number, value: f64) -> bool {
    let text = x.to_string();
    let places = text.split_once('.').map_or("", |(_, places)| places);
    matches!(places.len(), 1 | 2) && places.bytes().all(|digit| digit.is_ascii_digit()) && (4.0 * value).fract() != 0.0
}

fn value<T: Real>(x: &Number, name: impl Fn() -> String) -> Result<T, TableauError> {
    x.eval().map_err(|why| TableauError::BadEntry { entry: name(), why: why.to_string() })
}

fn vector<T: Real>(values: &[Number], name: &str) -> Result<Vec<T>, TableauError> {
    values.iter().enumerate().map(|(i, x)| value(x, || format!("{name}_{}", i + 1))).collect()
}

/// What summing the terms may lose: 64 n u Σ|x|, as in [`Tableau::new`].
fn roundoff<T: Real>(terms: &[T]) -> T {
    T::int(64 * terms.len() as i64) * T::unit_roundoff() * terms.iter().fold(T::zero(), |size, x| size + x.abs())
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Description::Family(family, stages) => write!(f, "{}-{stages}", family.name()),
            Description::Classic(classic) => f.write_str(classic.name()),
            Description::Entries(entries) => {
                let list = |row: &[Number]| row.iter().map(Number::to_string).collect::<Vec<_>>().join(", ");
                let rows: Vec<String> = entries.a.iter().map(|row| format!("[{}]", list(row))).collect();
                write!(f, "a = [{}], b = [{}]", rows.join(", "), list(&entries.b))?;
                entries.c.as_ref().map_or(Ok(()), |c| write!(f, ", c = [{}]", list(c)))
            }
        }
    }
}

/// What may stand for a name.
fn allowed() -> String {
    let families: Vec<String> = Family::ALL.iter().map(|family| format!("{}-S", family.name())).collect();
    let classics: Vec<&str> = Classic::ALL.iter().map(|classic| classic.name()).collect();
    format!(
        "allowed are {} with S stages, S from 1 (Lobatto: 2) to {MAX_STAGES}, and {}",
        families.join(", "),
        classics.join(", ")
    )
}

impl FromStr for Description {
    type Err = TableauError;

    /// A name, as listed at [`Description`]; `rk-4` and `ralston-3` are the classic ones, too.
    fn from_str(name: &str) -> Result<Self, TableauError> {
        let unknown = |why: String| TableauError::Unknown { name: name.into(), why };
        let plain = name.replace('-', "");
        if let Some(&classic) = Classic::ALL.iter().find(|classic| classic.name() == plain) {
            return Ok(Description::Classic(classic));
        }
        let (prefix, count) = name.rsplit_once('-').unwrap_or((name, ""));
        let digits = !count.is_empty() && count.bytes().all(|digit| digit.is_ascii_digit());
        let family = Family::ALL.into_iter().find(|family| family.name() == prefix);
        match family {
            Some(family) if digits => {
                // What does not fit a usize is too many stages like any other.
                let stages = count.parse().unwrap_or(usize::MAX);
                family.check(stages).map_err(|error| match error {
                    TableauError::Unknown { why, .. } => unknown(why),
                    other => other,
                })?;
                Ok(Description::Family(family, stages))
            }
            _ if matches!(name, "midpoint" | "explicit-midpoint") => Err(unknown(format!(
                "the explicit midpoint rule has b_1 = 0, and every weight must be non-zero; {}",
                allowed()
            ))),
            _ => Err(unknown(format!("no such tableau; {}", allowed()))),
        }
    }
}

#[cfg(feature = "harness")]
mod serial {
    use super::{Description, Entries};
    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Error, MapAccess, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::fmt;

    impl Serialize for Description {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Description::Entries(entries) => entries.serialize(serializer),
                _ => serializer.collect_str(self),
            }
        }
    }

    /// Refuses what cannot be built, so that the reader of a file can say where.
    impl<'de> Deserialize<'de> for Description {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(Either)
        }
    }

    struct Either;

    impl<'de> Visitor<'de> for Either {
        type Value = Description;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("the name of a tableau, such as \"gauss-2\", or a table with its entries a and b")
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<Description, E> {
            name.parse().map_err(E::custom)
        }

        fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Description, M::Error> {
            let entries = Entries::deserialize(MapAccessDeserializer::new(map))?;
            entries.build::<f64>().map_err(M::Error::custom)?;
            Ok(Description::Entries(entries))
        }
    }
}
