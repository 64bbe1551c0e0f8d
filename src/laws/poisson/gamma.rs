//! Poisson groupoids over g* on coordinates, with the faults that can be planted in their bivectors, and the tests of coisotropy.

use crate::groupoid::calculus::{along, constant, derivatives};
use crate::groupoid::{Arrow, DenseGroup, Tangent, poisson_bivector};
use crate::harness::Fault;
use crate::laws::instances::{CoordinatePolynomial, GroupoidKind, Instance};
use crate::laws::planted::blend_scalar;
use crate::laws::planted::groupoid::Flat;
use crate::laws::precision::Measured;
use crate::scalar::{Dual, Real, Scalar, max_abs};
use nalgebra::{DMatrix, DVector, FullPivLU};

pub(super) const LAMBDA_FLIPPED: Fault =
    Fault::new("bivector-lambda-flipped", "−⟨λ, [A_λ, B_λ]⟩, the sign of the λ term flipped", "non-abelian algebras");
pub(super) const MU_FLIPPED: Fault =
    Fault::new("bivector-mu-flipped", "+⟨μ, [A_μ, B_μ]⟩, the sign of the μ term flipped", "non-abelian algebras");
pub(super) const ADJOINT_MISSING: Fault =
    Fault::new("bivector-adjoint-missing", "B_λ instead of Ad_{U⁻¹} B_λ", "non-abelian algebras");
pub(super) const GROUP_SIGN: Fault = Fault::new(
    "bivector-group-sign",
    "{Ξ₂, F} = +ξ←F: the sign of ⟨L*_U A_U, B_μ⟩ and of its mirror flipped",
    "every algebra",
);
pub(super) const ONE_SIDED: Fault =
    Fault::new("bivector-one-sided", "⟨L*_U A_U, B_μ⟩ left out, but not its mirror", "every algebra");
pub(super) const LAST_SIGN: Fault = Fault::new(
    "product-last-sign",
    "the sign of the last factor flipped: Γ×Γ×Γ instead of Γ×Γ×Γ⁻, Γ×Γ⁻ instead of Γ×Γ",
    "every algebra",
);
pub(super) const EVEN_PART: Fault =
    Fault::new("hamiltonian-even-part", "E = f instead of f − f∘ι, its even part left in", "every algebra");

/// The Poisson groupoids over g* whose bivector is part of that of Γ = g*×G×g*: P×P⁻ and T*G.
pub(super) const OTHERS: [GroupoidKind; 2] = [GroupoidKind::Momenta, GroupoidKind::Coadjoint];

/// Which of λ, u, μ are the coordinates of a Poisson groupoid over g*, and so which blocks of the bivector of Γ make its own.
///
/// P×P⁻ for P = g* has {A, B} = ⟨λ, [A_λ, B_λ]⟩ − ⟨μ, [A_μ, B_μ]⟩. T*G ≅ g*⋊G by the coadjoint action, (λ, U) with α = λ and
/// β = Ad*_U λ, has {A, B} = ⟨λ, [A_λ, B_λ]⟩ + ⟨L*_U A_U, Ad_{U⁻¹} B_λ⟩ − ⟨L*_U B_U, Ad_{U⁻¹} A_λ⟩.
fn blocks(of: GroupoidKind) -> &'static [usize] {
    match of {
        GroupoidKind::Momenta => &[0, 2],
        GroupoidKind::Coadjoint => &[0, 1],
        _ => &[0, 1, 2],
    }
}

/// A Poisson groupoid with its bivector, in which faults may be planted. Vectors of `size` components are in those of the
/// coordinates (λ, u, μ) that it has, others in the ambient ones.
pub(super) struct Gamma<'a, T: Real> {
    pub(super) group: &'a DenseGroup<T>,
    pub(super) instance: Instance<'a, Dual<T>>,
    pub(super) fault: Option<&'a Fault>,
}

impl<'a, T: Real> Gamma<'a, T> {
    pub(super) fn groupoid(&self) -> &Flat<'a, Dual<T>> {
        self.instance.groupoid.as_ref()
    }

    /// n = dim g.
    pub(super) fn dimension(&self) -> usize {
        self.group.dimension()
    }

    fn name(&self) -> &'static str {
        match self.instance.kind {
            GroupoidKind::Momenta => "P×P⁻: ",
            GroupoidKind::Coadjoint => "T*G: ",
            _ => "",
        }
    }

    /// The dimension of the groupoid, 3n or 2n.
    pub(super) fn size(&self) -> usize {
        blocks(self.instance.kind).len() * self.dimension()
    }

    /// U of (λ, U, μ).
    pub(super) fn matrix<S: Scalar<Base = T>>(&self, z: &DVector<S>) -> DMatrix<S> {
        let (n, d) = (self.dimension(), self.group.matrix_size());
        DMatrix::from_fn(d, d, |r, c| z[n + c * d + r])
    }

    /// (δλ, Uû, δμ) of (δλ, u, δμ), of those that there are; on T*G, μ follows from λ and U.
    pub(super) fn push<S: Scalar<Base = T>>(&self, z: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        let n = self.dimension();
        if self.instance.kind == GroupoidKind::Momenta {
            return w.clone();
        }
        let (lambda, moved) = (w.rows(0, n), self.matrix(z) * self.group.hat(&w.rows(n, n).into_owned()));
        let mu = match self.instance.kind {
            GroupoidKind::Coadjoint => {
                let moving = |z: S, v: S| Dual { re: z, eps: v };
                let point = DVector::from_fn(n, |a, _| moving(z[a], lambda[a]));
                let element = self.matrix(z).zip_map(&moved, moving);
                let acted = self.group.coadjoint(&element, &point);
                acted.map_or_else(|| DVector::zeros(n), |acted| derivatives(&acted))
            }
            _ => w.rows(2 * n, n).into_owned(),
        };
        DVector::from_vec(lambda.iter().chain(moved.iter()).chain(mu.iter()).copied().collect())
    }

    /// (δλ, u, δμ) of (δλ, Uû, δμ), of those that there are.
    pub(super) fn pull(&self, z: &DVector<T>, tangent: &DVector<T>) -> Option<DVector<T>> {
        let n = self.dimension();
        let of_group = blocks(self.instance.kind).contains(&1);
        let u = if of_group {
            self.group.vee(&(self.group.inverse(&self.matrix(z))? * self.matrix(tangent)))
        } else {
            DVector::zeros(n)
        };
        let end = tangent.len() - n;
        let entries = blocks(self.instance.kind).iter().flat_map(|block| {
            (0..n).map(|a| match block {
                0 => tangent[a],
                1 => u[a],
                _ => tangent[end + a],
            })
        });
        Some(DVector::from_vec(entries.collect()))
    }

    /// Π of Γ, over duals.
    fn bivector_of_gamma(&self, z: &DVector<Dual<T>>) -> Option<DMatrix<Dual<T>>> {
        let n = self.dimension();
        let end = |from| z.rows(from, n).into_owned();
        let at = Arrow { source: end(0), group: self.matrix(z), target: end(z.len() - n) };
        let right = poisson_bivector(self.group, &at)?;
        if self.fault.is_none() {
            return Some(right);
        }
        Some(right.map_with_location(|i, j, v| {
            let wrong = |fault: &Fault, entry| blend_scalar(v, entry, fault.size_in(self.fault));
            let unit = Dual::lift(if i % n == j % n { T::one() } else { T::zero() });
            match (i / n, j / n) {
                (0, 0) => wrong(&LAMBDA_FLIPPED, -v),
                (2, 2) => wrong(&MU_FLIPPED, -v),
                (1, 0) => wrong(&ADJOINT_MISSING, unit),
                (0, 1) => wrong(&ADJOINT_MISSING, -unit),
                (1, 2) if ONE_SIDED.size_in(self.fault) > 0.0 => wrong(&ONE_SIDED, Dual::lift(T::zero())),
                (1, 2) | (2, 1) => wrong(&GROUP_SIGN, -v),
                _ => v,
            }
        }))
    }

    /// The brackets of the generators λ_a, U_ij, μ_a of Γ, the entries of U column by column, from their definition:
    ///
    /// {Ξ₁, Ξ'₁} = ⟨λ, \[ξ, ξ'\]⟩, {Ξ₂, Ξ'₂} = −⟨μ, \[ξ, ξ'\]⟩, {Ξ₁, F} = −ξ→F, {Ξ₂, F} = −ξ←F, all others zero,
    ///
    /// with ξ→ = ξ̂U and ξ← = Uξ̂, and the bracket of the algebra the commutator of matrices. No inverse of U is taken.
    ///
    /// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.5).
    pub(super) fn generator_brackets(&self, z: &DVector<T>) -> DMatrix<T> {
        let n = self.dimension();
        let (last, u) = (z.len() - n, self.matrix(z));
        let mut brackets = DMatrix::zeros(z.len(), z.len());
        brackets.view_mut((0, 0), (n, n)).copy_from(&self.commutators(&z.rows(0, n).into_owned()));
        brackets.view_mut((last, last), (n, n)).copy_from(&-self.commutators(&z.rows(last, n).into_owned()));
        for a in 0..n {
            let hat = self.group.hat(&basis(n, a));
            for (row, field) in [(a, &hat * &u), (last + a, &u * &hat)] {
                for (k, entry) in field.iter().enumerate() {
                    brackets[(row, n + k)] = -*entry;
                    brackets[(n + k, row)] = *entry;
                }
            }
        }
        brackets
    }

    /// ⟨λ, [ξ, ξ']⟩ for the elements ξ of the basis of g, by commutators of their matrices.
    pub(super) fn commutators(&self, point: &DVector<T>) -> DMatrix<T> {
        let n = self.dimension();
        let hats: Vec<DMatrix<T>> = (0..n).map(|a| self.group.hat(&basis(n, a))).collect();
        DMatrix::from_fn(n, n, |a, b| point.dot(&self.group.vee(&(&hats[a] * &hats[b] - &hats[b] * &hats[a]))))
    }

    /// Π, over duals.
    pub(super) fn bivector_at(&self, z: &DVector<Dual<T>>) -> Option<DMatrix<Dual<T>>> {
        let n = self.dimension();
        let all = match self.instance.kind {
            // U does not enter its blocks.
            GroupoidKind::Momenta => {
                let d = self.group.matrix_size();
                let unit = DMatrix::<Dual<T>>::identity(d, d);
                let entries = z.rows(0, n).iter().chain(unit.iter()).chain(z.rows(n, n).iter()).copied().collect();
                self.bivector_of_gamma(&DVector::from_vec(entries))?
            }
            _ => self.bivector_of_gamma(z)?,
        };
        let blocks = blocks(self.instance.kind);
        let at = |i: usize| blocks[i / n] * n + i % n;
        Some(DMatrix::from_fn(self.size(), self.size(), |i, j| all[(at(i), at(j))]))
    }

    /// Π.
    pub(super) fn bivector(&self, z: &DVector<T>) -> Option<DMatrix<T>> {
        Some(self.bivector_at(&constant(z))?.map(|v| v.re))
    }

    /// dF at z, in all directions.
    pub(super) fn differential<S: Scalar<Base = T>>(
        &self,
        function: &dyn Fn(&DVector<Dual<S>>) -> Dual<S>,
        z: &DVector<S>,
    ) -> DVector<S> {
        let size = self.size();
        DVector::from_fn(size, |i, _| function(&along(z, &self.push(z, &basis(size, i)))).eps)
    }

    /// {f, g}(z) over duals.
    pub(super) fn bracket_at(
        &self,
        f: &CoordinatePolynomial<T>,
        g: &CoordinatePolynomial<T>,
        z: &DVector<Dual<T>>,
    ) -> Option<Dual<T>> {
        let (df, dg) = (self.differential(&|z| f.at(z)[0], z), self.differential(&|z| g.at(z)[0], z));
        Some(df.dot(&(self.bivector_at(z)? * dg)))
    }

    pub(super) fn near(&self, what: &'static str, a: &DMatrix<T>, b: &DMatrix<T>, size: T) -> Measured {
        let floor = 256.0 * self.dimension() as f64;
        Measured::defect(max_abs(&(a - b)), size * self.instance.scale, floor, || format!("{}{what}", self.name()))
    }

    pub(super) fn number(&self, what: &'static str, a: T, b: T, terms: &[T]) -> Measured {
        let size = terms.iter().fold(T::one(), |size, term| size.max(term.abs()));
        self.near(what, &DMatrix::from_element(1, 1, a), &DMatrix::from_element(1, 1, b), size)
    }

    /// Tα or Tβ at z, of the coordinates there.
    pub(super) fn end_tangent(&self, end: &dyn Fn(&DVector<T>) -> DVector<T>, z: &DVector<T>) -> DMatrix<T> {
        let size = self.size();
        DMatrix::from_columns(&(0..size).map(|i| end(&self.push(z, &basis(size, i)))).collect::<Vec<_>>())
    }

    /// Tι at z, from coordinates to coordinates.
    pub(super) fn inversion_tangent(&self, z: &DVector<T>, inverse: &DVector<T>) -> Option<DMatrix<T>> {
        let size = self.size();
        let column = |i| self.pull(inverse, &self.groupoid().push_inverse(z, &self.push(z, &basis(size, i)))?);
        Some(DMatrix::from_columns(&(0..size).map(column).collect::<Option<Vec<_>>>()?))
    }

    /// The tangent vectors of the graph of ν at (g, h, gh), as columns: any vector at g, and one at h whose first n components
    /// are those of its end.
    pub(super) fn product_tangent(&self, g: &DVector<T>, h: &DVector<T>, gh: &DVector<T>) -> Option<DMatrix<T>> {
        let (q, n, size) = (self.groupoid(), self.dimension(), self.size());
        let column = |i: usize| {
            let along_g = DVector::from_fn(size, |k, _| if k == i { T::one() } else { T::zero() });
            let end = q.push_target(g, &self.push(g, &along_g));
            let rest = |k: usize| if k + size == i + n { T::one() } else { T::zero() };
            let along_h = DVector::from_fn(size, |k, _| if k < n { end[k] } else { rest(k) });
            let moved = q.push_product((g, &self.push(g, &along_g)), (h, &self.push(h, &along_h)))?;
            let moved = self.pull(gh, &moved)?;
            Some(DVector::from_vec(along_g.iter().chain(along_h.iter()).chain(moved.iter()).copied().collect()))
        };
        Some(DMatrix::from_columns(&(0..2 * size - n).map(column).collect::<Option<Vec<_>>>()?))
    }

    pub(super) fn inverse(&self, z: &DVector<T>) -> Option<DVector<T>> {
        Some(self.groupoid().inverse(&constant(z))?.map(|v| v.re))
    }

    pub(super) fn last_sign(&self, sign: T) -> T {
        blend_scalar(sign, -sign, LAST_SIGN.size_in(self.fault))
    }

    /// NᵀΠN = 0 for a basis N of the conormal space of the columns, Π block-diagonal.
    pub(super) fn coisotropic(
        &self,
        what: &'static str,
        tangent: &DMatrix<T>,
        factors: &[(&DMatrix<T>, T)],
    ) -> Option<Measured> {
        let conormal = null_space(tangent)?;
        let size = factors[0].0.nrows();
        let mut all = DMatrix::zeros(size * factors.len(), size * factors.len());
        for (k, (bivector, sign)) in factors.iter().enumerate() {
            all.view_mut((k * size, k * size), (size, size)).copy_from(&(*bivector * *sign));
        }
        let product = conormal.tr_mul(&(&all * &conormal));
        let bound = conormal.abs();
        let terms = bound.tr_mul(&(all.abs() * &bound)).amax();
        Some(self.near(what, &product, &DMatrix::zeros(product.nrows(), product.ncols()), terms))
    }

    /// X_E(z) = Π dE for E = f − f∘ι, in ambient coordinates.
    pub(super) fn hamiltonian_field(&self, f: &CoordinatePolynomial<T>, z: &DVector<T>) -> Option<DVector<T>> {
        self.groupoid().inverse(&constant(z))?;
        let size = EVEN_PART.size_in(self.fault);
        let energy = |z: &DVector<Dual<T>>| {
            let here = f.at(z)[0];
            // It exists at z and so near z.
            let there = self.groupoid().inverse(z).map_or(here, |inverse| f.at(&inverse)[0]);
            blend_scalar(here - there, here, size)
        };
        Some(self.push(z, &(self.bivector(z)? * self.differential(&energy, z))))
    }
}

pub(super) fn basis<S: Scalar>(size: usize, i: usize) -> DVector<S> {
    DVector::from_fn(size, |j, _| if i == j { S::one() } else { S::zero() })
}

pub(super) fn column<T: Real>(v: DVector<T>) -> DMatrix<T> {
    DMatrix::from_columns(&[v])
}

/// The matrices one below the other.
pub(super) fn stack<T: Real>(parts: &[&DMatrix<T>]) -> DMatrix<T> {
    let rows: Vec<_> = parts.iter().flat_map(|part| part.row_iter().map(|row| row.into_owned())).collect();
    DMatrix::from_rows(&rows)
}

/// A basis N of the vectors with `columns`ᵀ N = 0, by elimination with complete pivoting; `None` where the columns are
/// dependent.
pub(super) fn null_space<T: Real>(columns: &DMatrix<T>) -> Option<DMatrix<T>> {
    let (size, rank) = columns.shape();
    let lu = FullPivLU::new(columns.transpose());
    let u = lu.u();
    if !(0..rank).all(|k| u[(k, k)].abs() > T::unit_roundoff()) {
        return None;
    }
    let solved = u.columns(0, rank).solve_upper_triangular(&u.columns(rank, size - rank).into_owned())?;
    let mut basis = stack(&[&-solved, &DMatrix::identity(size - rank, size - rank)]);
    lu.q().inv_permute_rows(&mut basis);
    Some(basis)
}

/// The least pivot of an elimination with complete pivoting, relative to the largest entry; 0 where all entries are.
pub(super) fn least_pivot<T: Real>(map: &DMatrix<T>) -> T {
    let u = FullPivLU::new(map.clone()).u();
    let least = (0..u.nrows()).fold(map.amax(), |least, k| least.min(u[(k, k)].abs()));
    if least == T::zero() { least } else { least / map.amax() }
}
