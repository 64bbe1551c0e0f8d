//! Lie algebras in exact rational arithmetic: what random algebras are made and known by.
//!
//! Spans, null spaces and coordinates by elimination on sparse rows. Nothing here is generic: it is compiled once.

use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A sparse vector: the non-zero entries by their index.
pub(crate) type Sparse = BTreeMap<usize, RBig>;

/// Of these entries; compiled once, whatever they are taken from: a map that is collected brings a sort of its own.
fn sparse(entries: &mut dyn Iterator<Item = (usize, RBig)>) -> Sparse {
    entries.collect()
}

/// x += factor · y.
pub(crate) fn add(x: &mut Sparse, factor: &RBig, y: &Sparse) {
    for (&k, value) in y {
        add_at(x, k, product(factor, value));
    }
}

/// x_k += value.
fn add_at(x: &mut Sparse, k: usize, value: RBig) {
    match x.entry(k) {
        Entry::Vacant(free) => {
            if !value.is_zero() {
                free.insert(value);
            }
        }
        Entry::Occupied(mut taken) => {
            let sum = sum(taken.get(), &value);
            if sum.is_zero() {
                taken.remove();
            } else {
                *taken.get_mut() = sum;
            }
        }
    }
}

// Nearly all numbers here are integers, for which a fraction would look for common factors in vain.

/// x + y.
fn sum(x: &RBig, y: &RBig) -> RBig {
    if x.is_int() && y.is_int() { RBig::from(x.numerator() + y.numerator()) } else { x + y }
}

/// x y.
fn product(x: &RBig, y: &RBig) -> RBig {
    if x.is_int() && y.is_int() { RBig::from(x.numerator() * y.numerator()) } else { x * y }
}

/// x / y.
fn quotient(x: &RBig, y: &RBig) -> RBig {
    if y.is_one() { x.clone() } else { x / y }
}

/// The integer, as a fraction.
pub(crate) fn integer(value: i64) -> RBig {
    RBig::from(IBig::from(value))
}

/// Numerator and denominator, where they have 64 bits.
pub(crate) fn small(value: &RBig) -> Option<(i64, i64)> {
    Some((i64::try_from(value.numerator()).ok()?, i64::try_from(value.denominator()).ok()?))
}

/// The same direction with integer entries without a common factor, the first of them positive.
fn primitive(row: &Sparse) -> Sparse {
    use dashu_int::ops::Gcd;
    if row.values().all(RBig::is_int) && row.values().next() == Some(&RBig::ONE) {
        return row.clone();
    }
    let denominator = row.values().fold(UBig::ONE, |m, v| &m * v.denominator() / (&m).gcd(v.denominator()));
    let scaled = |v: &RBig| (v * RBig::from(denominator.clone())).numerator().clone();
    let divisor = row.values().map(scaled).fold(IBig::ZERO, |g, v| match g == IBig::ZERO {
        true => v,
        false => IBig::from(g.gcd(&v)),
    });
    let negative = row.values().next().is_some_and(|first| *first < RBig::ZERO);
    let divisor = RBig::from(if (divisor < IBig::ZERO) == negative { divisor } else { -divisor });
    if divisor.is_zero() {
        return row.clone();
    }
    sparse(&mut row.iter().map(|(&k, v)| (k, RBig::from(scaled(v)) / &divisor)))
}

/// A row-echelon basis of a span, reduced: no pivot stands in another row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Span {
    /// By pivot, the first entry, which is 1.
    rows: BTreeMap<usize, Sparse>,
}

impl Span {
    /// What is left of a row outside the span.
    pub fn remainder(&self, row: &Sparse) -> Sparse {
        let mut left = row.clone();
        // Rows are reduced: what is subtracted for one pivot has no entry at another.
        for pivot in row.keys() {
            if let (Some(basis), Some(factor)) = (self.rows.get(pivot), row.get(pivot)) {
                add(&mut left, &-factor.clone(), basis);
            }
        }
        left
    }

    /// Adds a row; whether it was outside the span.
    pub fn insert(&mut self, row: &Sparse) -> bool {
        let mut left = self.remainder(row);
        let Some((pivot, first)) = left.iter().next().map(|(k, v)| (*k, v.clone())) else { return false };
        left.values_mut().for_each(|v| *v = quotient(v, &first));
        for other in self.rows.values_mut() {
            if let Some(factor) = other.get(&pivot).cloned() {
                add(other, &-factor, &left);
            }
        }
        self.rows.insert(pivot, left);
        true
    }

    /// The dimension of the span.
    pub fn dimension(&self) -> usize {
        self.rows.len()
    }

    /// Its basis.
    pub fn rows(&self) -> impl Iterator<Item = &Sparse> {
        self.rows.values()
    }

    /// The vectors x of a space of dimension `n` with ⟨row, x⟩ = 0 for all rows: a basis of integers.
    pub fn null_space(&self, n: usize) -> Vec<Sparse> {
        let free = (0..n).filter(|k| !self.rows.contains_key(k));
        let solution = |k: usize| {
            let mut x = sparse(&mut self.rows.iter().filter_map(|(&p, row)| Some((p, -row.get(&k)?.clone()))));
            x.insert(k, RBig::ONE);
            primitive(&x)
        };
        free.map(solution).collect()
    }
}

/// A square matrix of rationals, without its zeros.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RationalMatrix {
    /// The number of rows.
    pub size: usize,
    /// By row · size + column.
    pub entries: Sparse,
}

impl RationalMatrix {
    /// 0.
    pub fn zero(size: usize) -> Self {
        Self { size, entries: Sparse::new() }
    }

    /// The matrix with this entry.
    pub fn of(size: usize, entry: impl Fn(usize, usize) -> i64) -> Self {
        let mut entries = (0..size * size).filter_map(|k| match entry(k / size, k % size) {
            0 => None,
            value => Some((k, integer(value))),
        });
        Self { size, entries: sparse(&mut entries) }
    }

    /// The entry.
    pub fn get(&self, row: usize, column: usize) -> RBig {
        self.entries.get(&(row * self.size + column)).cloned().unwrap_or(RBig::ZERO)
    }

    /// Adds to an entry.
    pub fn add_to(&mut self, row: usize, column: usize, value: &RBig) {
        add_at(&mut self.entries, row * self.size + column, value.clone());
    }

    /// Adds a block with its first entry at (row, column).
    pub fn add_block(&mut self, row: usize, column: usize, block: &Self) {
        for (k, value) in &block.entries {
            self.add_to(row + k / block.size, column + k % block.size, value);
        }
    }

    /// factor · X.
    pub fn scaled(&self, factor: &RBig) -> Self {
        let mut entries = Sparse::new();
        add(&mut entries, factor, &self.entries);
        Self { size: self.size, entries }
    }

    /// X Y.
    pub fn times(&self, other: &Self) -> Self {
        let n = self.size;
        let mut entries = Sparse::new();
        for (k, x) in &self.entries {
            let (row, middle) = (k / n, k % n);
            for (j, y) in other.entries.range(middle * n..(middle + 1) * n) {
                add_at(&mut entries, row * n + j % n, product(x, y));
            }
        }
        Self { size: n, entries }
    }

    /// X Y − Y X.
    pub fn commutator(&self, other: &Self) -> Self {
        let mut difference = self.times(other);
        add(&mut difference.entries, &RBig::NEG_ONE, &other.times(self).entries);
        difference
    }

    /// Xᵀ.
    pub fn transposed(&self) -> Self {
        let n = self.size;
        Self { size: n, entries: sparse(&mut self.entries.iter().map(|(k, v)| (k % n * n + k / n, v.clone()))) }
    }
}

/// Why matrices do not span a Lie algebra.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SpanError {
    /// This one is a combination of those before it.
    Dependent(usize),
    /// The commutator of these two is not a combination of all.
    NotClosed(usize, usize),
}

/// Coordinates in a basis of matrices.
pub(crate) struct MatrixSpan {
    /// Rows of the entries, and after them of the coordinates.
    span: Span,
    offset: usize,
}

impl MatrixSpan {
    /// The span of matrices of one size.
    ///
    /// # Errors
    /// Linear dependence.
    pub fn new(basis: &[RationalMatrix]) -> Result<Self, SpanError> {
        let offset = basis.first().map_or(0, |matrix| matrix.size * matrix.size);
        let mut span = Span::default();
        for (a, matrix) in basis.iter().enumerate() {
            if span.remainder(&matrix.entries).range(..offset).next().is_none() {
                return Err(SpanError::Dependent(a));
            }
            let mut row = matrix.entries.clone();
            row.insert(offset + a, RBig::ONE);
            span.insert(&row);
        }
        Ok(Self { span, offset })
    }

    /// The coordinates of a matrix, if it is in the span.
    pub fn coordinates(&self, matrix: &RationalMatrix) -> Option<Sparse> {
        let left = self.span.remainder(&matrix.entries);
        let inside = left.range(..self.offset).next().is_none();
        inside.then(|| sparse(&mut left.into_iter().map(|(k, v)| (k - self.offset, -v))))
    }
}

/// A Lie algebra by its structure constants, exactly.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RationalAlgebra {
    n: usize,
    /// [e_a, e_b] at a n + b.
    brackets: Vec<Sparse>,
}

impl RationalAlgebra {
    /// The algebra with [e_a, e_b] = Σ value e_c over the entries (a, b, c, value) given, each for one order of a and b; `None`
    /// where the Jacobi identity fails, or an index is too large.
    pub fn of_constants(n: usize, constants: impl IntoIterator<Item = ([usize; 3], RBig)>) -> Option<Self> {
        let mut brackets = vec![Sparse::new(); n * n];
        for ([a, b, c], value) in constants {
            if a.max(b).max(c) >= n {
                return None;
            }
            add_at(&mut brackets[a * n + b], c, value.clone());
            add_at(&mut brackets[b * n + a], c, -value);
        }
        let algebra = Self { n, brackets };
        algebra.is_lie().then_some(algebra)
    }

    /// The algebra that matrices span.
    ///
    /// # Errors
    /// Linear dependence; a commutator outside the span.
    pub fn of_matrices(basis: &[RationalMatrix]) -> Result<Self, SpanError> {
        let n = basis.len();
        let span = MatrixSpan::new(basis)?;
        let mut brackets = vec![Sparse::new(); n * n];
        for a in 0..n {
            for b in a + 1..n {
                let commutator = basis[a].commutator(&basis[b]);
                let coordinates = span.coordinates(&commutator).ok_or(SpanError::NotClosed(a, b))?;
                brackets[b * n + a] = sparse(&mut coordinates.iter().map(|(&c, v)| (c, -v.clone())));
                brackets[a * n + b] = coordinates;
            }
        }
        Ok(Self { n, brackets })
    }

    /// n.
    pub fn dimension(&self) -> usize {
        self.n
    }

    /// [e_a, e_b].
    pub fn of_basis(&self, a: usize, b: usize) -> &Sparse {
        &self.brackets[a * self.n + b]
    }

    /// The constants that are not zero, with a < b.
    pub fn constants(&self) -> impl Iterator<Item = ([usize; 3], &RBig)> {
        let n = self.n;
        let pairs = self.brackets.iter().enumerate().filter(move |(k, _)| k / n < k % n);
        pairs.flat_map(move |(k, bracket)| bracket.iter().map(move |(&c, v)| ([k / n, k % n, c], v)))
    }

    /// [x, y].
    pub fn bracket(&self, x: &Sparse, y: &Sparse) -> Sparse {
        let mut sum = Sparse::new();
        for (&a, p) in x {
            for (&b, q) in y {
                add(&mut sum, &product(p, q), self.of_basis(a, b));
            }
        }
        sum
    }

    /// The Jacobi identity on the basis.
    fn is_lie(&self) -> bool {
        let unit = |a: usize| Sparse::from([(a, RBig::ONE)]);
        let cyclic = |a, b, c| {
            let mut sum = self.bracket(&unit(a), self.of_basis(b, c));
            for (x, y, z) in [(b, c, a), (c, a, b)] {
                add(&mut sum, &RBig::ONE, &self.bracket(&unit(x), self.of_basis(y, z)));
            }
            sum.is_empty()
        };
        let antisymmetric = (0..self.n).all(|a| self.of_basis(a, a).is_empty());
        antisymmetric && (0..self.n).all(|a| (0..a).all(|b| (0..b).all(|c| cyclic(a, b, c))))
    }

    /// The matrix of ad of a basis vector.
    pub fn adjoint(&self, a: usize) -> RationalMatrix {
        let mut matrix = RationalMatrix::zero(self.n);
        for b in 0..self.n {
            for (&c, value) in self.of_basis(a, b) {
                matrix.add_to(c, b, value);
            }
        }
        matrix
    }

    /// A basis of the centre.
    pub fn centre(&self) -> Vec<Sparse> {
        let mut equations = Span::default();
        for b in 0..self.n {
            for c in 0..self.n {
                let mut row = (0..self.n).filter_map(|a| Some((a, self.of_basis(a, b).get(&c)?.clone())));
                equations.insert(&sparse(&mut row));
            }
        }
        equations.null_space(self.n)
    }

    /// Whether all brackets vanish.
    pub fn is_abelian(&self) -> bool {
        self.brackets.iter().all(Sparse::is_empty)
    }

    /// The dimensions of the lower central series g = g₀ ⊃ g₁ ⊃ …, g_{k+1} = [g, g_k], or of the derived one, [g_k, g_k], to where they stay.
    pub fn series(&self, lower_central: bool) -> Vec<usize> {
        let whole: Vec<Sparse> = (0..self.n).map(|a| Sparse::from([(a, RBig::ONE)])).collect();
        let (mut dimensions, mut space) = (vec![self.n], whole.clone());
        loop {
            let mut next = Span::default();
            for x in if lower_central { &whole } else { &space } {
                for y in &space {
                    next.insert(&self.bracket(x, y));
                }
            }
            if next.dimension() == space.len() {
                return dimensions;
            }
            dimensions.push(next.dimension());
            space = next.rows().cloned().collect();
        }
    }

    /// Whether tr ad_ξ = 0 for all ξ.
    pub fn is_unimodular(&self) -> bool {
        (0..self.n).all(|a| {
            let trace = (0..self.n).filter_map(|b| self.of_basis(a, b).get(&b)).fold(RBig::ZERO, |sum, v| sum + v);
            trace.is_zero()
        })
    }

    /// How many squares of the Killing form are positive, negative and zero (Sylvester).
    pub fn killing_signature(&self) -> [usize; 3] {
        let ad: Vec<RationalMatrix> = (0..self.n).map(|a| self.adjoint(a)).collect();
        let trace = |x: &RationalMatrix, y: &RationalMatrix| {
            let n = self.n;
            x.entries.iter().fold(RBig::ZERO, |sum, (k, v)| sum + v * y.get(k % n, k / n))
        };
        signature((0..self.n).map(|a| (0..self.n).map(|b| trace(&ad[a], &ad[b])).collect()).collect())
    }

    /// A basis of the derivations D, D[x, y] = [Dx, y] + [x, Dy]: matrices D with De_b = D^c_b e_c.
    pub fn derivations(&self) -> Vec<RationalMatrix> {
        let n = self.n;
        let mut equations = Span::default();
        for a in 0..n {
            for b in a + 1..n {
                for c in 0..n {
                    // (D[e_a, e_b])^c − [De_a, e_b]^c − [e_a, De_b]^c, with D^c_b at c n + b.
                    let mut row = Sparse::new();
                    for (&d, value) in self.of_basis(a, b) {
                        add_at(&mut row, c * n + d, value.clone());
                    }
                    for d in 0..n {
                        for (x, y, at) in [(d, b, d * n + a), (a, d, d * n + b)] {
                            if let Some(value) = self.of_basis(x, y).get(&c) {
                                add_at(&mut row, at, -value.clone());
                            }
                        }
                    }
                    equations.insert(&row);
                }
            }
        }
        equations.null_space(n * n).into_iter().map(|entries| RationalMatrix { size: n, entries }).collect()
    }

    /// A basis of the 2-cocycles c([x, y], z) + cyclic = 0: antisymmetric matrices c_ab = c(e_a, e_b).
    pub fn cocycles(&self) -> Vec<RationalMatrix> {
        let n = self.n;
        let mut equations = Span::default();
        for a in 0..n {
            for b in 0..a {
                for c in 0..b {
                    let mut row = Sparse::new();
                    for (x, y, z) in [(a, b, c), (b, c, a), (c, a, b)] {
                        for (&d, value) in self.of_basis(x, y).iter().filter(|(d, _)| **d != z) {
                            // Unknowns c_ab with a < b.
                            let (at, factor) =
                                if d < z { (d * n + z, value.clone()) } else { (z * n + d, -value.clone()) };
                            add_at(&mut row, at, factor);
                        }
                    }
                    equations.insert(&row);
                }
            }
        }
        // What is no unknown is zero.
        for k in (0..n * n).filter(|k| k / n >= k % n) {
            equations.insert(&Sparse::from([(k, RBig::ONE)]));
        }
        let antisymmetric = |entries: Sparse| {
            let mut matrix = RationalMatrix { size: n, entries };
            let mirrored = matrix.transposed();
            add(&mut matrix.entries, &RBig::NEG_ONE, &mirrored.entries);
            matrix
        };
        equations.null_space(n * n).into_iter().map(antisymmetric).collect()
    }

    /// Generators of the Casimirs of degree 1 to `degree` (at most 3), each a homogeneous polynomial in μ: its monomials and their
    /// coefficients, integers. What is a combination of products of those of lower degree is left out.
    ///
    /// C is one when Σ_b C^c_ab μ_c ∂C/∂μ_b = 0 for all a: linear equations for its coefficients.
    pub fn casimirs(&self, degree: usize) -> Vec<Polynomial> {
        let mut all: Vec<Polynomial> = Vec::new();
        for d in 1..=degree {
            let monomials = monomials(self.n, d);
            let index: BTreeMap<&[usize], usize> = monomials.iter().enumerate().map(|(i, m)| (&m[..], i)).collect();
            let mut equations = Span::default();
            for a in 0..self.n {
                // By monomial of the derivative along ad*_{e_a} μ.
                let mut rows = vec![Sparse::new(); monomials.len()];
                for (i, monomial) in monomials.iter().enumerate() {
                    for (k, &b) in monomial.iter().enumerate() {
                        for (&c, value) in self.of_basis(a, b) {
                            let mut moved = monomial.clone();
                            moved[k] = c;
                            moved.sort_unstable();
                            add_at(&mut rows[index[&moved[..]]], i, value.clone());
                        }
                    }
                }
                for row in &rows {
                    equations.insert(row);
                }
            }
            let mut known = Span::default();
            for product in products(&all, d) {
                known.insert(&sparse(&mut product.into_iter().map(|(monomial, v)| (index[&monomial[..]], v))));
            }
            for solution in equations.null_space(monomials.len()) {
                if known.insert(&solution) {
                    all.push(solution.into_iter().map(|(i, v)| (monomials[i].clone(), v)).collect());
                }
            }
        }
        all
    }
}

/// A homogeneous polynomial in μ: coefficients by monomial, the sorted indices of its factors.
pub(crate) type Polynomial = BTreeMap<Vec<usize>, RBig>;

/// All monomials of a degree in n variables, as sorted indices.
fn monomials(n: usize, degree: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..degree {
        let longer = |m: &Vec<usize>| {
            let least = m.last().copied().unwrap_or(0);
            (least..n).map(|a| [&m[..], &[a]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// Products of known polynomials that have this degree.
fn products(known: &[Polynomial], degree: usize) -> Vec<Polynomial> {
    let of = |p: &Polynomial| p.keys().next().map_or(0, Vec::len);
    let mut found = Vec::new();
    // (product, the first factor that may follow).
    let mut open: Vec<(Polynomial, usize)> = known.iter().cloned().enumerate().map(|(i, p)| (p, i)).collect();
    while let Some((product, first)) = open.pop() {
        match of(&product).cmp(&degree) {
            Ordering::Equal => found.push(product),
            Ordering::Greater => {}
            Ordering::Less => {
                for (i, factor) in known.iter().enumerate().skip(first) {
                    let mut longer = Polynomial::new();
                    for (m, x) in &product {
                        for (k, y) in factor {
                            let mut monomial = [&m[..], &k[..]].concat();
                            monomial.sort_unstable();
                            *longer.entry(monomial).or_insert(RBig::ZERO) += x * y;
                        }
                    }
                    longer.retain(|_, v| !v.is_zero());
                    open.push((longer, i));
                }
            }
        }
    }
    found
}

/// The signature (positive, negative, zero) of a symmetric matrix, by congruence to a diagonal one.
fn signature(mut rows: Vec<Vec<RBig>>) -> [usize; 3] {
    let n = rows.len();
    let mut counts = [0; 3];
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let diagonal = left.iter().copied().find(|&k| !rows[k][k].is_zero());
        let pivot = diagonal.or_else(|| {
            // All squares vanish: e_i + e_j has one where the mixed entry is not zero.
            let pairs = left.iter().flat_map(|&i| left.iter().map(move |&j| (i, j)));
            let (i, j) = pairs.into_iter().find(|&(i, j)| !rows[i][j].is_zero())?;
            for k in 0..n {
                let moved = rows[j][k].clone();
                rows[i][k] += moved;
            }
            for k in 0..n {
                let moved = rows[k][j].clone();
                rows[k][i] += moved;
            }
            Some(i)
        });
        let Some(pivot) = pivot else {
            counts[2] = left.len();
            break;
        };
        let value = rows[pivot][pivot].clone();
        counts[usize::from(value < RBig::ZERO)] += 1;
        left.retain(|&k| k != pivot);
        for &i in &left {
            let factor = &rows[i][pivot] / &value;
            for &j in &left {
                let change = &factor * &rows[pivot][j];
                rows[i][j] -= change;
            }
        }
    }
    counts
}
