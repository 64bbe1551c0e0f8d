//! Polynomials in (cos t, sin t, η): forces, and fields of orbit forces.

use super::ForceError;
use crate::algebra::{Covector, Vector};
use crate::mechanics::Force;
use crate::mechanics::lie_poisson::OrbitField;
use crate::scalar::{Real, Scalar};

/// The largest power of cos t and of sin t, and the largest degree in η.
pub const MAX_DEGREE: usize = 16;

/// One term: coefficient cos(t)^p sin(t)^q η^i η^j … in one component.
#[derive(Clone, Debug, PartialEq)]
pub struct Monomial<T> {
    /// Which component, from 0.
    pub component: usize,
    /// The coefficient.
    pub coefficient: T,
    /// p.
    pub cos: usize,
    /// q.
    pub sin: usize,
    /// i, j, …, from 0: an index as often as it is a factor.
    pub factors: Vec<usize>,
}

/// A sum of terms in (cos t, sin t, η) with N components: a force f(t, η) ∈ g*, or a field ζ(t, η) ∈ g.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial<T, const N: usize> {
    terms: Vec<Monomial<T>>,
}

impl<T: Real, const N: usize> Polynomial<T, N> {
    /// The sum of these terms.
    ///
    /// # Errors
    /// A coefficient that is not finite; an index that is not below N; a degree beyond [`MAX_DEGREE`].
    pub fn new(terms: Vec<Monomial<T>>) -> Result<Self, ForceError> {
        for (k, term) in terms.iter().enumerate() {
            let refused = |why: String| ForceError::BadTerm { term: k + 1, why };
            if !term.coefficient.all_finite() {
                return Err(refused("its coefficient is not finite".into()));
            }
            if let Some(index) = term.factors.iter().chain([&term.component]).find(|index| **index >= N) {
                return Err(refused(format!("there is no component {} of {N}", index + 1)));
            }
            let degree = term.factors.len().max(term.cos).max(term.sin);
            if degree > MAX_DEGREE {
                return Err(refused(format!("its degree {degree} is larger than {MAX_DEGREE}")));
            }
        }
        Ok(Self { terms })
    }
}

/// Adds the terms to `out`.
fn add<S: Scalar>(terms: &[Monomial<S::Base>], t: S, eta: &[S], out: &mut [S]) {
    let (cos, sin) = match terms.iter().any(|term| term.cos + term.sin > 0) {
        true => (t.cos(), t.sin()),
        false => (S::one(), S::zero()),
    };
    for term in terms {
        let mut value = S::lift(term.coefficient);
        (0..term.cos).for_each(|_| value *= cos);
        (0..term.sin).for_each(|_| value *= sin);
        term.factors.iter().for_each(|&i| value *= eta[i]);
        out[term.component] += value;
    }
}

impl<T: Real, const N: usize> Force<T, N> for Polynomial<T, N> {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        self.zeta(t, eta).transpose()
    }

    fn is_zero(&self) -> bool {
        self.terms.iter().all(|term| term.coefficient == T::zero())
    }
}

impl<T: Real, const N: usize> OrbitField<T, N> for Polynomial<T, N> {
    fn zeta<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Vector<S, N> {
        let mut sum = Vector::<S, N>::zeros();
        add(&self.terms, t, eta.as_slice(), sum.as_mut_slice());
        sum
    }
}
