//! Real numbers described exactly: `1/3`, `0.1`, `sqrt(3)/6`, `2*pi`.
//!
//! A constant that is stored as an `f64` is wrong in the 17th digit as soon as it is used with more of them. A
//! [`Number`] keeps the description instead and evaluates it in the scalar at hand.

use super::{Real, decimal};
#[cfg(feature = "harness")]
use dashu_int::ops::{Abs, BitTest, SquareRoot};
#[cfg(feature = "harness")]
use dashu_int::{IBig, UBig};
#[cfg(feature = "harness")]
use dashu_ratio::RBig;
use std::fmt;
use std::str::FromStr;

/// The longest text that is parsed, in bytes; it also bounds the depth of the expression.
pub const LONGEST: usize = 1000;
/// The deepest nesting of parentheses, roots and signs that is parsed.
pub const DEEPEST: usize = 50;
/// The largest decimal exponent in absolute value; anything beyond is out of range in every scalar anyway.
const LARGEST_EXPONENT: i32 = 9999;

/// A decimal with at least this many places after the point counts as rounded, unless it is dyadic; one with fewer as exact.
///
/// So 0.5 + 0.4 is a mistake, not a rounded 1, while tables printed with 3, 10 or 16 digits can be typed in.
pub const ROUNDED_PLACES: i32 = 3;

/// A numerator or denominator longer than this is not computed by [`Number::rational`].
#[cfg(feature = "harness")]
pub const MOST_BITS: usize = 8192;

/// An exact description of a real number.
///
/// Grammar: `sum = product {("+" | "-") product}`, `product = sign {("*" | "/") sign | "deg"}`, `sign = "-" sign | atom`,
/// `atom = decimal | "pi" | "deg" | "sqrt(" sum ")" | "(" sum ")"`, decimals with an optional fraction and exponent (`12`,
/// `0.5`, `1.2e-3`), white space anywhere between. `deg` is π/180; as a unit it multiplies the product before it, so that
/// `1/2 deg` is half a degree. There is no other implicit multiplication.
///
/// Display prints a canonical text that parses back to an equal `Number`. Equality is that of the description
/// (`1/2`, `2/4` and `0.5` differ; `0.50` and `5e-1` are the same decimal).
///
/// With the feature `harness`, (de)serialisation reads a number or a text, and writes a number where reading it gives
/// back an equal `Number` (integers of 64 bits, and decimals that an `f64` prints as), a text otherwise.
///
/// ```
/// use euler_poincare::scalar::Number;
/// let x: Number = "1/2 - sqrt(3)/6".parse()?;
/// assert_eq!(x.eval::<f64>()?, 0.5 - 3f64.sqrt() / 6.0);
/// assert_eq!(x.to_string(), "1/2 - sqrt(3)/6");
/// assert_eq!(Number::from(0.1), Number::parse("0.1")?);
/// assert_eq!(Number::parse("30 deg")?.eval::<f64>()?, 30.0 * (std::f64::consts::PI / 180.0));
/// # Ok::<(), euler_poincare::scalar::NumberError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    tree: Tree,
}

#[derive(Clone, Debug, PartialEq)]
enum Tree {
    Decimal(Decimal),
    Pi,
    /// π/180.
    Degree,
    Minus(Box<Tree>),
    Root(Box<Tree>),
    Binary(Box<Tree>, Operation, Box<Tree>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Add,
    Sub,
    Mul,
    Div,
}

/// digits × 10^exponent; no zeros at either end of `digits`, which is empty (and the exponent 0) for zero.
#[derive(Clone, Debug, PartialEq)]
struct Decimal {
    digits: String,
    exponent: i32,
}

/// Why a text is not a [`Number`], or a [`Number`] has no value in a scalar.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NumberError {
    /// The text does not follow the grammar.
    #[error("`{text}` is not a number: {expected} expected at byte {at}")]
    Syntax {
        /// The text.
        text: String,
        /// Byte offset of the first thing that does not fit.
        at: usize,
        /// What would fit there.
        expected: &'static str,
    },
    /// The text, or its canonical form, is longer than [`LONGEST`].
    #[error("a number of {length} bytes is too long (at most {LONGEST})")]
    TooLong {
        /// Its length in bytes.
        length: usize,
    },
    /// Parentheses, roots and signs are nested more deeply than [`DEEPEST`].
    #[error("a number nested more than {DEEPEST} deep at byte {at}")]
    TooDeep {
        /// Byte offset of the first level too many.
        at: usize,
    },
    /// A divisor is zero.
    #[error("division by `{divisor}`, which is zero")]
    DivisionByZero {
        /// The divisor.
        divisor: String,
    },
    /// The argument of a square root is negative.
    #[error("square root of `{argument}` = {value}, which is negative")]
    NegativeRoot {
        /// The argument.
        argument: String,
        /// Its value.
        value: f64,
    },
    /// A value is too large for the scalar, or is not zero but too small.
    #[error("`{text}` is out of the range of {scalar}")]
    OutOfRange {
        /// The expression whose value it is.
        text: String,
        /// [`Real::NAME`] of the scalar.
        scalar: &'static str,
    },
}

impl Number {
    /// The number that `text` describes, by the grammar above.
    ///
    /// # Errors
    /// `Syntax`, `TooLong` and `TooDeep`; whether there is a value is seen by [`Number::eval`].
    pub fn parse(text: &str) -> Result<Self, NumberError> {
        if text.len() > LONGEST {
            return Err(NumberError::TooLong { length: text.len() });
        }
        let mut parser = Parser { text, at: 0 };
        let tree = parser.sum(0)?;
        if parser.peek().is_some() {
            return Err(parser.expected("an operation or the end"));
        }
        let number = Self { tree };
        // The canonical text can be the longer one (`1e9` is `1000000000`), and has to parse too.
        let length = number.to_string().len();
        if length > LONGEST { Err(NumberError::TooLong { length }) } else { Ok(number) }
    }

    /// p/q (p alone if q = 1).
    pub fn ratio(p: i64, q: i64) -> Self {
        if q == 1 { Self::from(p) } else { Self { tree: binary(integer(p), Operation::Div, integer(q)) } }
    }

    /// π/180, a degree.
    pub fn degree() -> Self {
        Self { tree: Tree::Degree }
    }

    /// The value in `T`: decimals and π correct to working precision, and one rounding for each operation, in the
    /// order written (so a description that cancels loses digits like any other sum).
    ///
    /// # Errors
    /// `DivisionByZero`; `NegativeRoot`; `OutOfRange` if a value on the way overflows, or underflows to zero.
    pub fn eval<T: Real>(&self) -> Result<T, NumberError> {
        self.tree.eval()
    }

    /// The exact value, if it is rational as written: no π, and roots of perfect squares only.
    ///
    /// `None` also for a number that has no value, and for one that needs more than [`MOST_BITS`] bits on the way.
    #[cfg(feature = "harness")]
    pub fn rational(&self) -> Option<RBig> {
        self.tree.rational()
    }

    /// How far the number may be from what the writer meant, if it is a decimal that counts as rounded; else 0.
    ///
    /// A decimal counts as rounded if it has at least [`ROUNDED_PLACES`] places after the point and is no dyadic rational
    /// (0.125 and 0.4 are exact, 0.167 is not). Then it is half a unit of its last non-zero place, and for 16 or 17
    /// significant digits, which is how an `f64` is printed, at least half a unit in the last place of an `f64`.
    pub fn uncertainty<T: Real>(&self) -> T {
        let Some(decimal) = self.rounded() else { return T::zero() };
        let half_unit = T::half() / T::int(10).powi(-decimal.exponent);
        let printed = matches!(decimal.digits.len(), 16 | 17);
        let size = self.eval().map_or(T::zero(), |x: T| x.abs());
        if printed { half_unit.max(size * T::exact(f64::EPSILON / 2.0)) } else { half_unit }
    }

    /// [`Number::uncertainty`], exactly.
    #[cfg(feature = "harness")]
    pub fn exact_uncertainty(&self) -> RBig {
        let Some(decimal) = self.rounded() else { return RBig::ZERO };
        let half = RBig::from_parts(IBig::ONE, UBig::from(2u8));
        let half_unit = power_of_ten(decimal.exponent) * half;
        match self.rational() {
            Some(x) if matches!(decimal.digits.len(), 16 | 17) => {
                let ulp = x.abs() / RBig::from(UBig::ONE << 53);
                if ulp > half_unit { ulp } else { half_unit }
            }
            _ => half_unit,
        }
    }

    /// The decimal, if it counts as rounded.
    fn rounded(&self) -> Option<&Decimal> {
        let mut tree = &self.tree;
        while let Tree::Minus(x) = tree {
            tree = x;
        }
        match tree {
            Tree::Decimal(decimal) if -decimal.exponent >= ROUNDED_PLACES && !decimal.is_dyadic() => Some(decimal),
            _ => None,
        }
    }
}

#[cfg(feature = "harness")]
fn power_of_ten(exponent: i32) -> RBig {
    let power = UBig::from(10u8).pow(exponent.unsigned_abs() as usize);
    if exponent < 0 { RBig::from_parts(IBig::ONE, power) } else { RBig::from(power) }
}

/// √x, if x is a square.
#[cfg(feature = "harness")]
fn exact_root(x: &RBig) -> Option<RBig> {
    let numerator = UBig::try_from(x.numerator().clone()).ok()?;
    let (p, q) = (numerator.sqrt(), x.denominator().sqrt());
    (&p * &p == numerator && &q * &q == *x.denominator()).then(|| RBig::from_parts(IBig::from(p), q))
}

impl Default for Number {
    /// 0.
    fn default() -> Self {
        Self::from(0)
    }
}

impl From<i64> for Number {
    fn from(n: i64) -> Self {
        Self { tree: integer(n) }
    }
}

impl From<f64> for Number {
    /// The shortest decimal that rounds to `x`: 0.1 is 1/10, in every scalar. Decimals of few bits are exact.
    ///
    /// What is not finite becomes the expression that says so, `1/0`, `-1/0` or `0/0`, and [`Number::eval`] refuses it.
    fn from(x: f64) -> Self {
        if x.is_finite() {
            let text = format!("{:e}", x.abs());
            let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
            let decimal = Decimal::new(whole, fraction, exponent.parse().unwrap_or(0));
            let tree = Tree::Decimal(decimal);
            Self { tree: if x.is_sign_negative() { Tree::Minus(Box::new(tree)) } else { tree } }
        } else if x.is_nan() {
            Self::ratio(0, 0)
        } else {
            Self::ratio(if x > 0.0 { 1 } else { -1 }, 0)
        }
    }
}

impl FromStr for Number {
    type Err = NumberError;
    fn from_str(text: &str) -> Result<Self, NumberError> {
        Self::parse(text)
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.tree)
    }
}

fn binary(left: Tree, operation: Operation, right: Tree) -> Tree {
    Tree::Binary(Box::new(left), operation, Box::new(right))
}

fn integer(n: i64) -> Tree {
    let tree = Tree::Decimal(Decimal::new(&n.unsigned_abs().to_string(), "", 0));
    if n < 0 { Tree::Minus(Box::new(tree)) } else { tree }
}

impl Tree {
    /// How tightly the expression binds: sums 1, products 2, signs 3, atoms 4.
    fn strength(&self) -> u8 {
        match self {
            Tree::Binary(_, Operation::Add | Operation::Sub, _) => 1,
            Tree::Binary(_, Operation::Mul | Operation::Div, _) => 2,
            Tree::Minus(_) => 3,
            Tree::Decimal(_) | Tree::Pi | Tree::Degree | Tree::Root(_) => 4,
        }
    }

    /// The expression, in parentheses if it binds less than `strength`.
    fn print(&self, f: &mut fmt::Formatter<'_>, strength: u8) -> fmt::Result {
        if self.strength() < strength { write!(f, "({self})") } else { write!(f, "{self}") }
    }

    fn eval<T: Real>(&self) -> Result<T, NumberError> {
        let value = match self {
            Tree::Pi => return Ok(T::pi()),
            Tree::Degree => return Ok(T::pi() / T::int(180)),
            Tree::Minus(x) => return Ok(-x.eval::<T>()?),
            Tree::Decimal(decimal) => {
                if decimal.digits.is_empty() {
                    return Ok(T::zero());
                }
                let value = match decimal.integer() {
                    Some(n) => Some(T::int(n)),
                    None => T::parse_decimal(&decimal.to_string()),
                };
                value.filter(|x| !x.is_zero())
            }
            Tree::Root(x) => {
                let argument: T = x.eval()?;
                if argument < T::zero() {
                    return Err(NumberError::NegativeRoot { argument: x.to_string(), value: argument.to_f64() });
                }
                Some(argument.sqrt())
            }
            Tree::Binary(x, operation, y) => {
                let (a, b): (T, T) = (x.eval()?, y.eval()?);
                match operation {
                    Operation::Add => Some(a + b),
                    Operation::Sub => Some(a - b),
                    Operation::Mul => Some(a * b).filter(|ab| !ab.is_zero() || a.is_zero() || b.is_zero()),
                    Operation::Div if b.is_zero() => {
                        return Err(NumberError::DivisionByZero { divisor: y.to_string() });
                    }
                    Operation::Div => Some(a / b).filter(|q| !q.is_zero() || a.is_zero()),
                }
            }
        };
        value
            .filter(|x| x.all_finite())
            .ok_or_else(|| NumberError::OutOfRange { text: self.to_string(), scalar: T::NAME })
    }

    #[cfg(feature = "harness")]
    fn rational(&self) -> Option<RBig> {
        let value = match self {
            Tree::Pi | Tree::Degree => return None,
            Tree::Minus(x) => -x.rational()?,
            Tree::Root(x) => exact_root(&x.rational()?)?,
            Tree::Decimal(decimal) => decimal.rational()?,
            Tree::Binary(x, operation, y) => {
                let (a, b) = (x.rational()?, y.rational()?);
                match operation {
                    Operation::Add => a + b,
                    Operation::Sub => a - b,
                    Operation::Mul => a * b,
                    Operation::Div if b.is_zero() => return None,
                    Operation::Div => a / b,
                }
            }
        };
        let length = value.numerator().bit_len().max(value.denominator().bit_len());
        (length <= MOST_BITS).then_some(value)
    }
}

impl fmt::Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tree::Decimal(decimal) => write!(f, "{decimal}"),
            Tree::Pi => f.write_str("pi"),
            Tree::Degree => f.write_str("deg"),
            Tree::Minus(x) => {
                f.write_str("-")?;
                x.print(f, 3)
            }
            Tree::Root(x) => write!(f, "sqrt({x})"),
            Tree::Binary(x, operation, y) => {
                let strength = self.strength();
                x.print(f, strength)?;
                f.write_str(match operation {
                    Operation::Add => " + ",
                    Operation::Sub => " - ",
                    Operation::Mul => "*",
                    Operation::Div => "/",
                })?;
                y.print(f, strength + 1)
            }
        }
    }
}

impl Decimal {
    /// whole.fraction × 10^exponent.
    fn new(whole: &str, fraction: &str, exponent: i32) -> Self {
        let all = format!("{whole}{fraction}");
        let digits = all.trim_end_matches('0');
        let exponent = exponent - fraction.len() as i32 + (all.len() - digits.len()) as i32;
        let digits = digits.trim_start_matches('0').to_string();
        let exponent = if digits.is_empty() { 0 } else { exponent };
        Self { digits, exponent }
    }

    #[cfg(feature = "harness")]
    fn rational(&self) -> Option<RBig> {
        if self.digits.is_empty() {
            return Some(RBig::ZERO);
        }
        let digits: UBig = self.digits.parse().ok()?;
        // A larger power has more than MOST_BITS bits.
        (self.exponent.unsigned_abs() < 2500).then(|| RBig::from(digits) * power_of_ten(self.exponent))
    }

    /// Whether the value is an integer over a power of 2: 5^places divides the digits.
    fn is_dyadic(&self) -> bool {
        let mut digits: Vec<u8> = self.digits.bytes().map(|digit| digit - b'0').collect();
        for _ in 0..-self.exponent {
            let mut rest = 0;
            for digit in &mut digits {
                let value = 10 * rest + *digit;
                (*digit, rest) = (value / 5, value % 5);
            }
            if rest != 0 {
                return false;
            }
        }
        true
    }

    /// The value, if it is an integer of 63 bits.
    fn integer(&self) -> Option<i64> {
        let power = 10i64.checked_pow(u32::try_from(self.exponent).ok()?)?;
        if self.digits.is_empty() { Some(0) } else { self.digits.parse::<i64>().ok()?.checked_mul(power) }
    }
}

impl fmt::Display for Decimal {
    /// Positional while that takes few zeros, with an exponent otherwise.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = &self.digits;
        // Position of the decimal point: the value is 0.digits × 10^point.
        let point = digits.len() as i32 + self.exponent;
        if digits.is_empty() {
            return f.write_str("0");
        }
        let few_zeros = if self.exponent >= 0 { point <= 18 } else { point > -5 };
        let spelled = if few_zeros { decimal::positional } else { decimal::scientific };
        f.write_str(&spelled(digits, point - 1))
    }
}

/// Recursive descent over the bytes of the text.
struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl Parser<'_> {
    fn expected(&self, expected: &'static str) -> NumberError {
        NumberError::Syntax { text: self.text.to_string(), at: self.at, expected }
    }

    /// The next byte, without skipping white space.
    fn byte(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// The next byte after white space.
    fn peek(&mut self) -> Option<u8> {
        while self.byte().is_some_and(|b| b.is_ascii_whitespace()) {
            self.at += 1;
        }
        self.byte()
    }

    fn sum(&mut self, depth: usize) -> Result<Tree, NumberError> {
        let mut tree = self.product(depth)?;
        loop {
            let operation = match self.peek() {
                Some(b'+') => Operation::Add,
                Some(b'-') => Operation::Sub,
                _ => return Ok(tree),
            };
            self.at += 1;
            tree = binary(tree, operation, self.product(depth)?);
        }
    }

    fn product(&mut self, depth: usize) -> Result<Tree, NumberError> {
        let mut tree = self.sign(depth)?;
        loop {
            let operation = match self.peek() {
                Some(b'*') => Operation::Mul,
                Some(b'/') => Operation::Div,
                Some(b'd') if self.name() == "deg" => {
                    self.at += "deg".len();
                    tree = binary(tree, Operation::Mul, Tree::Degree);
                    continue;
                }
                _ => return Ok(tree),
            };
            self.at += 1;
            tree = binary(tree, operation, self.sign(depth)?);
        }
    }

    fn sign(&mut self, depth: usize) -> Result<Tree, NumberError> {
        if depth > DEEPEST {
            return Err(NumberError::TooDeep { at: self.at });
        }
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                Ok(Tree::Minus(Box::new(self.sign(depth + 1)?)))
            }
            Some(b'(') => self.parenthesis(depth),
            Some(b'0'..=b'9' | b'.') => self.decimal(),
            Some(b'a'..=b'z' | b'A'..=b'Z') => self.word(depth),
            _ => Err(self.expected("a number")),
        }
    }

    fn parenthesis(&mut self, depth: usize) -> Result<Tree, NumberError> {
        self.at += 1;
        let tree = self.sum(depth + 1)?;
        if self.peek() != Some(b')') {
            return Err(self.expected("an operation or `)`"));
        }
        self.at += 1;
        Ok(tree)
    }

    /// The name from here on.
    fn name(&self) -> &str {
        let rest = &self.text[self.at..];
        &rest[..rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len())]
    }

    fn word(&mut self, depth: usize) -> Result<Tree, NumberError> {
        let start = self.at;
        self.at += self.name().len();
        match &self.text[start..self.at] {
            "pi" => Ok(Tree::Pi),
            "deg" => Ok(Tree::Degree),
            "sqrt" if self.peek() == Some(b'(') => Ok(Tree::Root(Box::new(self.parenthesis(depth)?))),
            "sqrt" => Err(self.expected("`(`")),
            _ => {
                self.at = start;
                Err(self.expected("a number, `pi`, `deg` or `sqrt`"))
            }
        }
    }

    /// The digits from here on, possibly none.
    fn digits(&mut self) -> &str {
        let start = self.at;
        while self.byte().is_some_and(|b| b.is_ascii_digit()) {
            self.at += 1;
        }
        &self.text[start..self.at]
    }

    fn decimal(&mut self) -> Result<Tree, NumberError> {
        let whole = self.digits().to_string();
        let mut fraction = String::new();
        if self.byte() == Some(b'.') {
            self.at += 1;
            fraction = self.digits().to_string();
        }
        if whole.is_empty() && fraction.is_empty() {
            return Err(self.expected("a digit"));
        }
        let mut exponent = 0;
        if matches!(self.byte(), Some(b'e' | b'E')) {
            self.at += 1;
            exponent = self.exponent()?;
        }
        Ok(Tree::Decimal(Decimal::new(&whole, &fraction, exponent)))
    }

    fn exponent(&mut self) -> Result<i32, NumberError> {
        let start = self.at;
        let negative = self.byte() == Some(b'-');
        if matches!(self.byte(), Some(b'-' | b'+')) {
            self.at += 1;
        }
        let digits = self.digits();
        if digits.is_empty() {
            return Err(self.expected("a digit"));
        }
        match digits.parse::<i32>() {
            Ok(n) if n <= LARGEST_EXPONENT => Ok(if negative { -n } else { n }),
            _ => {
                self.at = start;
                Err(self.expected("an exponent of at most four digits"))
            }
        }
    }
}

#[cfg(feature = "serde")]
mod serial {
    use super::{Number, Tree};
    use serde::de::{Error, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::fmt;

    impl Serialize for Number {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let (decimal, negative) = match &self.tree {
                Tree::Decimal(decimal) => (decimal, false),
                Tree::Minus(x) => match &**x {
                    Tree::Decimal(decimal) => (decimal, true),
                    _ => return serializer.collect_str(self),
                },
                _ => return serializer.collect_str(self),
            };
            let integer = decimal.integer().map(|n| if negative { -n } else { n });
            if let Some(n) = integer.filter(|n| Number::from(*n) == *self) {
                return serializer.serialize_i64(n);
            }
            match self.to_string().parse::<f64>() {
                Ok(x) if Number::from(x) == *self => serializer.serialize_f64(x),
                _ => serializer.collect_str(self),
            }
        }
    }

    impl<'de> Deserialize<'de> for Number {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(NumberVisitor)
        }
    }

    struct NumberVisitor;

    impl Visitor<'_> for NumberVisitor {
        type Value = Number;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a finite number, or a text such as \"1/3\" or \"sqrt(2)/2\"")
        }

        fn visit_i64<E: Error>(self, n: i64) -> Result<Number, E> {
            Ok(Number::from(n))
        }

        fn visit_u64<E: Error>(self, n: u64) -> Result<Number, E> {
            Number::parse(&n.to_string()).map_err(E::custom)
        }

        fn visit_f64<E: Error>(self, x: f64) -> Result<Number, E> {
            if x.is_finite() { Ok(Number::from(x)) } else { Err(E::custom(format_args!("{x} is not finite"))) }
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Number, E> {
            Number::parse(text).map_err(E::custom)
        }
    }
}
