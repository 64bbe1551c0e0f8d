//! To which classes an algebra belongs, computed from its structure constants.
//!
//! Decisions of rank take as zero what is below √u relative to max|C| (to its square for the Killing form). In a
//! basis of condition number κ the smallest true value may be as small as κ⁻² of the largest and the rounding of the
//! constants as large as κ u, so the answers can be relied on while κ² < u^(−1/2): κ < 10⁴ in `f64`. What is zero
//! exactly, as every constant of an abelian algebra in any basis, is seen exactly.

use super::{LieAlgebra, Matrix, Vector, elimination};
use crate::scalar::Real;

impl<T: Real, const N: usize> LieAlgebra<T, N> {
    /// [g, g] = 0: every structure constant is zero (exactly: constants alone have no scale to compare with).
    pub fn is_abelian(&self) -> bool {
        self.size() == T::zero()
    }

    /// tr ad_ξ = 0 for all ξ.
    pub fn is_unimodular(&self) -> bool {
        self.ad_basis.iter().all(|ad| ad.trace().abs() <= self.negligible())
    }

    /// The lower central series g, [g, g], [g, [g, g]], … ends in 0.
    pub fn is_nilpotent(&self) -> bool {
        let whole = self.whole();
        self.series_vanishes(|space| self.commutator(&whole, space))
    }

    /// The derived series g, [g, g], [[g, g], [g, g]], … ends in 0.
    pub fn is_solvable(&self) -> bool {
        self.series_vanishes(|space| self.commutator(space, space))
    }

    /// The Killing form is regular (Cartan's criterion); false for N = 0.
    pub fn is_semisimple(&self) -> bool {
        N > 0 && self.killing_rank() == N
    }

    /// The rank of the Killing form.
    pub(crate) fn killing_rank(&self) -> usize {
        elimination::rank(&self.killing(), self.negligible() * self.size())
    }

    /// The Killing form K_ab = tr(ad_a ad_b).
    pub fn killing(&self) -> Matrix<T, N> {
        Matrix::from_fn(|a, b| (self.ad_basis[a] * self.ad_basis[b]).trace())
    }

    /// The dimension of [g, g].
    pub fn derived_dimension(&self) -> usize {
        self.commutator(&self.whole(), &self.whole()).len()
    }

    /// √u max|C|.
    fn negligible(&self) -> T {
        T::unit_roundoff().sqrt() * self.size()
    }

    fn whole(&self) -> Vec<Vector<T, N>> {
        (0..N).map(super::basis_vector).collect()
    }

    fn series_vanishes(&self, next: impl Fn(&[Vector<T, N>]) -> Vec<Vector<T, N>>) -> bool {
        let mut space = self.whole();
        while !space.is_empty() {
            let smaller = next(&space);
            if smaller.len() == space.len() {
                return false;
            }
            space = smaller;
        }
        true
    }

    /// An orthonormal basis of the span of all [x, y], by Gram–Schmidt with the largest remainder first.
    fn commutator(&self, xs: &[Vector<T, N>], ys: &[Vector<T, N>]) -> Vec<Vector<T, N>> {
        let mut rest: Vec<_> = xs.iter().flat_map(|x| ys.iter().map(move |y| self.bracket(x, y))).collect();
        let mut span = Vec::new();
        while span.len() < N {
            let (largest, norm) = rest.iter().fold((None, self.negligible()), |(at, size), v| {
                let norm = v.norm();
                if norm > size { (Some(*v), norm) } else { (at, size) }
            });
            let Some(direction) = largest.map(|v| v / norm) else { break };
            for v in &mut rest {
                let twice = *v - direction * direction.dot(v);
                *v = twice - direction * direction.dot(&twice);
            }
            span.push(direction);
        }
        span
    }
}
