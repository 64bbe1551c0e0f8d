//! Lie algebras spanned by rational matrices: constants and Casimirs that are exact, and a faithful group by definition.

use super::rational::{Polynomial, RationalAlgebra, RationalMatrix, SpanError, add, small};
use super::{AlgebraInvariants, Casimir, LieAlgebra, Matrix};
use crate::scalar::{Number, Real};
use dashu_ratio::RBig;
use std::sync::{Arc, OnceLock};

/// Up to this dimension Casimirs of degree 3 are looked for, too; above, there are many coefficients.
const CUBIC_DIMENSION: usize = 6;

/// Why matrices are not a basis of a Lie algebra. The fields count from 0, the messages from 1, as files do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MatricesError {
    /// There are none.
    #[error("no matrices: at least one is needed")]
    None,
    /// A matrix has another number of rows than the first, or a row another length.
    #[error("matrix {} is not {size}×{size}, as its first row and the first matrix are", .index + 1)]
    NotSquare {
        /// Which.
        index: usize,
        /// The length of the first row of the first.
        size: usize,
    },
    /// An entry is not rational, so that constants would not be exact.
    #[error(
        "the entry {entry} (matrix {}, row {}, column {}) is not rational, with numerators and denominators of 64 bits; \
         an irrational basis is given by `basis`",
        .index + 1, .row + 1, .column + 1
    )]
    NotRational {
        /// Which matrix.
        index: usize,
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// As it stands.
        entry: String,
    },
    /// A matrix is a combination of those before it.
    #[error("matrix {} is a combination of those before it", .index + 1)]
    Dependent {
        /// Which.
        index: usize,
    },
    /// The commutator of two is no combination of all.
    #[error("the matrices do not span a Lie algebra: the commutator of matrices {} and {} is outside their span", .a + 1, .b + 1)]
    NotClosed {
        /// The first.
        a: usize,
        /// The second.
        b: usize,
    },
    /// A structure constant that is too long to compute with.
    #[error("a structure constant of matrices {} and {} has more than 64 bits", .a + 1, .b + 1)]
    TooLong {
        /// The first.
        a: usize,
        /// The second.
        b: usize,
    },
}

/// A fraction p/q.
type Fraction = (i64, i64);

/// What is known of the algebra, once for all copies.
struct Facts {
    matrices: Vec<Vec<Vec<Number>>>,
    size: usize,
    /// (row, column, p/q) of ê_a.
    entries: Vec<Vec<(usize, usize, Fraction)>>,
    algebra: RationalAlgebra,
    /// (a, b, c, C^c_ab), a < b.
    constants: Vec<([usize; 3], Fraction)>,
    casimirs: OnceLock<Vec<Terms>>,
    cayley: OnceLock<bool>,
}

/// The same text whatever has been asked for before: laws draw numbers from the text of a case.
impl std::fmt::Debug for Facts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.polynomials();
        self.admits_cayley();
        let Self { matrices, size, entries, algebra, constants, casimirs, cayley } = self;
        f.debug_struct("Facts")
            .field("matrices", matrices)
            .field("size", size)
            .field("entries", entries)
            .field("algebra", algebra)
            .field("constants", constants)
            .field("casimirs", casimirs)
            .field("cayley", cayley)
            .finish()
    }
}

impl Facts {
    fn polynomials(&self) -> &[Terms] {
        self.casimirs.get_or_init(|| terms(&self.algebra))
    }

    fn admits_cayley(&self) -> bool {
        *self.cayley.get_or_init(|| {
            let basis = self.rational();
            let Ok(span) = super::rational::MatrixSpan::new(&basis) else { return false };
            let n = basis.len();
            let pairs: Vec<_> = (0..n * n).map(|k| basis[k / n].times(&basis[k % n])).collect();
            let inside = |a: usize, b: usize, c: usize| {
                let mut sum = pairs[a * n + b].times(&basis[c]);
                add(&mut sum.entries, &RBig::ONE, &pairs[c * n + b].times(&basis[a]).entries);
                span.coordinates(&sum).is_some()
            };
            (0..n).all(|a| (0..n).all(|b| (0..=a).all(|c| inside(a, b, c))))
        })
    }

    fn rational(&self) -> Vec<RationalMatrix> {
        let matrix = |entries: &Vec<(usize, usize, Fraction)>| {
            let mut matrix = RationalMatrix::zero(self.size);
            for &(r, c, (p, q)) in entries {
                matrix.add_to(r, c, &(super::rational::integer(p) / super::rational::integer(q)));
            }
            matrix
        };
        self.entries.iter().map(matrix).collect()
    }
}

/// The Lie algebra with a basis of rational matrices ê_a, closed under the commutator: [e_a, e_b] = C^c_ab e_c as for the matrices.
///
/// Its structure constants are exact, and so are its Casimirs (of degree 1 and 2, up to dimension 6 of degree 3, by the null space of
/// their equations). The
/// representation is faithful by definition. Copies share what has been computed.
///
/// ```
/// use euler_poincare::algebra::{MatricesError, MatrixAlgebra};
/// use euler_poincare::scalar::Number;
///
/// let matrix = |entries: [[i64; 2]; 2]| entries.map(|row| row.map(Number::from).to_vec()).to_vec();
/// // sl(2): H, E, F.
/// let basis = [[[1, 0], [0, -1]], [[0, 1], [0, 0]], [[0, 0], [1, 0]]].map(matrix).to_vec();
/// let sl2 = MatrixAlgebra::new(basis.clone())?;
/// assert_eq!((sl2.dimension(), sl2.matrix_size(), sl2.casimir_count()), (3, 2, 1));
/// assert_eq!(sl2.invariants().killing, [2, 1, 0]);
/// assert!(sl2.admits_cayley() && sl2.invariants().unimodular);
/// // [E, F] = H is not in the span of E and F.
/// assert_eq!(MatrixAlgebra::new(basis[1..].to_vec()), Err(MatricesError::NotClosed { a: 0, b: 1 }));
/// # Ok::<(), MatricesError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MatrixAlgebra(Arc<Facts>);

impl PartialEq for MatrixAlgebra {
    fn eq(&self, other: &Self) -> bool {
        self.0.matrices == other.0.matrices
    }
}

impl MatrixAlgebra {
    /// The algebra with this basis, each matrix by rows.
    ///
    /// # Errors
    /// See [`MatricesError`].
    pub fn new(matrices: Vec<Vec<Vec<Number>>>) -> Result<Self, MatricesError> {
        let size = matrices.first().ok_or(MatricesError::None)?.len();
        let square = |matrix: &Vec<Vec<Number>>| matrix.len() == size && matrix.iter().all(|row| row.len() == size);
        if let Some(index) = matrices.iter().position(|matrix| !square(matrix)) {
            return Err(MatricesError::NotSquare { index, size });
        }
        let rational = |(index, matrix): (usize, &Vec<Vec<Number>>)| {
            let mut rational = RationalMatrix::zero(size);
            for (row, column) in (0..size * size).map(|k| (k / size, k % size)) {
                let entry = &matrix[row][column];
                let value = entry.rational().filter(|value| small(value).is_some());
                let refused = || MatricesError::NotRational { index, row, column, entry: entry.to_string() };
                rational.add_to(row, column, &value.ok_or_else(refused)?);
            }
            Ok(rational)
        };
        let basis = matrices.iter().enumerate().map(rational).collect::<Result<Vec<_>, _>>()?;
        Self::of(matrices, &basis)
    }

    /// The algebra with this basis; `None` where an entry has more than 64 bits.
    pub(crate) fn of_rational(basis: &[RationalMatrix]) -> Option<Self> {
        let number = |value: &RBig| small(value).map(|(p, q)| Number::ratio(p, q));
        let rows = |matrix: &RationalMatrix| -> Option<Vec<Vec<Number>>> {
            let n = matrix.size;
            (0..n).map(|r| (0..n).map(|c| number(&matrix.get(r, c))).collect()).collect()
        };
        Self::of(basis.iter().map(rows).collect::<Option<_>>()?, basis).ok()
    }

    fn of(matrices: Vec<Vec<Vec<Number>>>, basis: &[RationalMatrix]) -> Result<Self, MatricesError> {
        let size = basis.first().ok_or(MatricesError::None)?.size;
        let algebra = RationalAlgebra::of_matrices(basis).map_err(|error| match error {
            SpanError::Dependent(index) => MatricesError::Dependent { index },
            SpanError::NotClosed(a, b) => MatricesError::NotClosed { a, b },
        })?;
        let fraction = |([a, b, c], value): ([usize; 3], &RBig)| match small(value) {
            Some(value) => Ok(([a, b, c], value)),
            None => Err(MatricesError::TooLong { a, b }),
        };
        let constants = algebra.constants().map(fraction).collect::<Result<_, _>>()?;
        let entries = |matrix: &RationalMatrix| {
            let of = |(k, value): (&usize, &RBig)| Some((k / size, k % size, small(value)?));
            matrix.entries.iter().filter_map(of).collect()
        };
        let entries = basis.iter().map(entries).collect();
        let (casimirs, cayley) = (OnceLock::new(), OnceLock::new());
        Ok(Self(Arc::new(Facts { matrices, size, entries, algebra, constants, casimirs, cayley })))
    }

    /// n.
    pub fn dimension(&self) -> usize {
        self.0.entries.len()
    }

    /// The number of rows of the matrices.
    pub fn matrix_size(&self) -> usize {
        self.0.size
    }

    /// ê_a, each by rows.
    pub fn matrices(&self) -> &[Vec<Vec<Number>>] {
        &self.0.matrices
    }

    /// Whether all brackets vanish.
    pub fn is_abelian(&self) -> bool {
        self.0.algebra.is_abelian()
    }

    /// What it is, by numbers that do not depend on the basis.
    pub fn invariants(&self) -> AlgebraInvariants {
        AlgebraInvariants::of(&self.0.algebra)
    }

    /// Whether ½(x y z + z y x) stays in the span, which the [Cayley map](crate::retraction::Cayley) needs.
    pub fn admits_cayley(&self) -> bool {
        self.0.admits_cayley()
    }

    /// The basis, exactly.
    pub(crate) fn rational(&self) -> Vec<RationalMatrix> {
        self.0.rational()
    }

    /// The structure constants, exactly.
    pub(crate) fn algebra(&self) -> &RationalAlgebra {
        &self.0.algebra
    }

    /// The algebra in a dimension N that may be larger: further coordinates have no brackets.
    pub(crate) fn beside_spectators<T: Real, const N: usize>(&self) -> LieAlgebra<T, N> {
        let mut table = [[[T::zero(); N]; N]; N];
        for ([a, b, c], (p, q)) in &self.0.constants {
            let value = T::int(*p) / T::int(*q);
            table[*a][*b][*c] = value;
            table[*b][*a][*c] = -value;
        }
        LieAlgebra::unchecked(|a, b, c| table[a][b][c])
    }

    /// ê_a in the leading block.
    pub(crate) fn padded<T: Real, const D: usize>(&self, a: usize) -> Matrix<T, D> {
        let mut matrix = Matrix::zeros();
        for &(r, c, (p, q)) in &self.0.entries[a] {
            matrix[(r, c)] = T::int(p) / T::int(q);
        }
        matrix
    }

    /// How many Casimirs are known, those of lower degree and their products apart.
    pub fn casimir_count(&self) -> usize {
        self.0.polynomials().len()
    }

    /// The Casimirs in a dimension N that may be larger.
    pub(crate) fn casimirs_beside_spectators<T: Real, const N: usize>(&self) -> Vec<Casimir<T, N>> {
        self.0.polynomials().iter().map(casimir).collect()
    }
}

/// The monomials of a Casimir, with their coefficients.
type Terms = Vec<(Vec<usize>, Fraction)>;

fn terms(algebra: &RationalAlgebra) -> Vec<Terms> {
    let all = algebra.casimirs(if algebra.dimension() <= CUBIC_DIMENSION { 3 } else { 2 });
    let terms = |p: &Polynomial| p.iter().map(|(m, v)| Some((m.clone(), small(v)?))).collect();
    all.iter().filter_map(terms).collect()
}

fn casimir<T: Real, const N: usize>(terms: &Terms) -> Casimir<T, N> {
    Casimir::of(terms.iter().map(|(monomial, (p, q))| (monomial.clone(), T::int(*p) / T::int(*q))))
}

impl RationalAlgebra {
    /// The algebra of the adjoint representation, where that is faithful.
    pub(crate) fn of_adjoint(&self) -> Option<MatrixAlgebra> {
        let faithful = self.dimension() > 0 && self.centre().is_empty();
        faithful.then(|| MatrixAlgebra::of_rational(&super::families::adjoint(self)))?
    }

    /// How many [`casimirs_beside_spectators`](Self::casimirs_beside_spectators) there are.
    pub(crate) fn casimir_count(&self) -> usize {
        terms(self).len()
    }

    /// The Casimirs in a dimension N that may be larger.
    pub(crate) fn casimirs_beside_spectators<T: Real, const N: usize>(&self) -> Vec<Casimir<T, N>> {
        terms(self).iter().map(casimir).collect()
    }
}
