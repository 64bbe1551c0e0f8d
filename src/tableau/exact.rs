//! Tableaux of exact rationals, and their order conditions in integers.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/tableau/exact.md"))]

use super::description::{check_count, no_row_sum};
use super::order::{Conditions, Verdict};
use super::quantity::{Coefficients, Quantity, decimal};
use super::trees::{MAX_ORDER, Tree};
use super::{Description, Entries, TableauError, check_entries, entry_name};
use crate::scalar::Number;
use dashu_int::ops::{Abs, BitTest, Gcd};
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;

/// Tableaux whose common denominator has more bits are analysed in floating point only.
pub const MOST_BITS: usize = 16384;

impl<Q: Quantity> Coefficients<Q> {
    /// With the conjugate and the row sums.
    pub(super) fn conjugated(a: Vec<Vec<Q>>, b: Vec<Q>) -> Self {
        let s = b.len();
        let entry = |i: usize, j: usize| b[j].minus(&b[j].times(&a[j][i]).over(&b[i]));
        let hat = (0..s).map(|i| (0..s).map(|j| entry(i, j)).collect()).collect();
        Self::new(a, hat, b)
    }
}

impl Coefficients<RBig> {
    /// The order conditions, for trees with edges of 1 or 2 `colours`; `None` if a common denominator is too long.
    pub fn conditions(&self, colours: usize) -> Option<Conditions<RBig>> {
        integers(self, colours)
    }
}

impl Description {
    /// The tableau in exact arithmetic, if all its entries are rational as written; the members of families with few
    /// stages and the explicit classical tableaux are.
    ///
    /// Σb = 1 must hold exactly or to the digits given, as in [`Entries::build`].
    ///
    /// # Errors
    /// Those of [`Entries::build`].
    pub fn rational(&self) -> Result<Option<Coefficients<RBig>>, TableauError> {
        let named = match self {
            Description::Entries(entries) => return entries.rational(),
            Description::Family(family, stages) => family.rational(*stages),
            Description::Classic(classic) => classic.rational(),
        };
        Ok(named.map(|(a, b)| Coefficients::conjugated(a, b)))
    }
}

impl Entries {
    /// The tableau in rationals, where all entries are.
    pub(super) fn rational(&self) -> Result<Option<Coefficients<RBig>>, TableauError> {
        let row = |numbers: &[Number]| numbers.iter().map(Number::rational).collect::<Option<Vec<_>>>();
        let a: Option<Vec<Vec<RBig>>> = self.a.iter().map(|numbers| row(numbers)).collect();
        let (Some(a), Some(mut b)) = (a, row(&self.b)) else { return Ok(None) };
        check_entries(&a, &b, |_| true, RBig::is_zero)?;
        let sum = total(&b);
        let off = (&sum - RBig::ONE).abs();
        let slack = total(&self.b.iter().map(Number::exact_uncertainty).collect::<Vec<_>>());
        if off > slack {
            return Err(TableauError::Inconsistent { excess: (sum - RBig::ONE).to_f64().value() });
        }
        b.iter_mut().for_each(|x| *x /= &sum);
        let tableau = Coefficients::conjugated(a, b);
        self.check_exact_row_sums(&tableau)?;
        Ok(Some(tableau))
    }

    /// Σb − 1 of the weights as given, where they are rational and do not sum to 1.
    pub(super) fn excess(&self) -> Option<f64> {
        let b = self.b.iter().map(Number::rational).collect::<Option<Vec<_>>>()?;
        Some(total(&b) - RBig::ONE).filter(|excess| !excess.is_zero()).map(|excess| excess.to_f64_fast())
    }

    fn check_exact_row_sums(&self, tableau: &Coefficients<RBig>) -> Result<(), TableauError> {
        let Some(given) = &self.c else { return Ok(()) };
        check_count(given.len(), tableau.stages())?;
        for (i, (given, sum)) in given.iter().zip(&tableau.c).enumerate() {
            let slack = total(&self.a[i].iter().map(Number::exact_uncertainty).collect::<Vec<_>>());
            let Some(c) = given.rational() else { continue };
            if (&c - sum).abs() > slack + given.exact_uncertainty() {
                return Err(no_row_sum(i, c.show(), sum.show()));
            }
        }
        Ok(())
    }

    /// The name of the first entry of a or b that is a rounded decimal.
    pub fn first_rounded(&self) -> Option<String> {
        let rounded = |x: &Number| !x.exact_uncertainty().is_zero();
        let of_a =
            self.a.iter().enumerate().find_map(|(i, row)| row.iter().position(rounded).map(|j| entry_name(i, j)));
        of_a.or_else(|| self.b.iter().position(rounded).map(|j| format!("b_{}", j + 1)))
    }
}

fn total(terms: &[RBig]) -> RBig {
    terms.iter().fold(RBig::ZERO, |sum, x| sum + x)
}

impl Quantity for RBig {
    fn fraction(p: i64, q: i64) -> Self {
        RBig::from_parts_signed(p.into(), q.into())
    }

    fn plus(&self, other: &Self) -> Self {
        // For integers a fraction would look for common factors in vain.
        if self.is_int() && other.is_int() { RBig::from(self.numerator() + other.numerator()) } else { self + other }
    }

    fn minus(&self, other: &Self) -> Self {
        if self.is_int() && other.is_int() { RBig::from(self.numerator() - other.numerator()) } else { self - other }
    }

    fn times(&self, other: &Self) -> Self {
        if self.is_int() && other.is_int() { RBig::from(self.numerator() * other.numerator()) } else { self * other }
    }

    fn over(&self, other: &Self) -> Self {
        self / other
    }

    fn vanishes(&self, _operations: usize) -> bool {
        self.is_zero()
    }

    fn verdict(&self, tree: &Tree, _stages: usize) -> Verdict {
        let defect = self - expected(tree);
        if defect.is_zero() {
            return Verdict::exact(tree);
        }
        Verdict { holds: false, weight: self.to_f64_fast(), defect: defect.to_f64_fast(), tolerance: 0.0 }
    }

    fn fractions(&self, tree: &Tree) -> Option<[String; 2]> {
        Some([self.to_string(), (self - expected(tree)).to_string()])
    }

    fn to_f64(&self) -> f64 {
        self.to_f64_fast()
    }

    /// The fraction while it is short, else a decimal.
    fn show(&self) -> String {
        let text = self.to_string();
        if text.len() <= 24 { text } else { decimal(self.to_f64_fast()) }
    }
}

/// 1/γ.
fn expected(tree: &Tree) -> RBig {
    RBig::from_parts(IBig::ONE, UBig::from(tree.density()))
}

/// With the common denominator D, integers D^{n−1} Φ_i and D^n Σ b Φ for trees of order n.
fn integers(coefficients: &Coefficients<RBig>, colours: usize) -> Option<Conditions<RBig>> {
    let matrices: Vec<_> = [&coefficients.a, &coefficients.hat].into_iter().take(colours.max(1)).collect();
    let mut denominator = UBig::ONE;
    for x in matrices.iter().copied().flatten().flatten().chain(&coefficients.b) {
        let shared = (&denominator).gcd(x.denominator());
        denominator = denominator / shared * x.denominator();
        if denominator.bit_len() > MOST_BITS {
            return None;
        }
    }
    let row = |row: &Vec<RBig>| row.iter().map(|x| x * &denominator).collect::<Vec<RBig>>();
    let matrices = matrices.iter().map(|matrix| matrix.iter().map(row).collect()).collect();
    let weights = row(&coefficients.b);
    let units = (0..=MAX_ORDER).map(|n| RBig::from(denominator.pow(n))).collect();
    Some(Conditions::with(matrices, weights, units))
}
