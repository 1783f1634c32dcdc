//! Symmetric matrices in band or in sparse form, and the factors of K + cM.
//!
//! A sparse A = L D Lᵀ is formed without pivoting: stable for a positive definite A. Of K − xM, which is not, the growth
//! of the factors tells how far rounding may have gone, as in [`crate::linalg::banded`]. The ordering that keeps L
//! sparse (approximate minimum degree: Amestoy, Davis & Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886-905), its blocks
//! of columns of one structure (supernodes), each a dense matrix, and its values are faer's.
//!
//! Solutions read L twice in the order of its memory: for one vector several columns at a time, for [`LANES`] vectors
//! side by side once for all, so that what is read of L or A meets a whole row of X.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::solvers::Llt;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_numeric_ldlt, factorize_supernodal_numeric_ldlt_scratch,
    factorize_supernodal_symbolic_cholesky, factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Par, Side};

use super::banded::Banded;
use super::sparse::{Pattern, SparseMatrix};
use super::wide::{self, COLUMNS, LANES, dot, dot_block, subtract, subtract_block, widest};

/// What is known of the factors of every matrix of one pattern.
#[derive(Debug)]
pub struct Symbolic {
    /// `order[new] = old`.
    pub order: Vec<usize>,
    /// The pattern in the new order.
    pub pattern: Arc<Pattern>,
    /// For each place of `pattern` its number in the one analysed.
    pub origin: Vec<usize>,
    /// Multiplications and additions of a factorization.
    pub flops: f64,
    /// `pattern` as faer takes it.
    matrix: SymbolicSparseColMat<u32>,
    supernodes: SymbolicSupernodalCholesky<u32>,
}

impl Symbolic {
    /// Analysis of a pattern; none for one that is too large.
    pub fn new(pattern: &Pattern) -> Option<Self> {
        let n = pattern.n();
        if u32::try_from(pattern.n_places()).is_err() {
            return None;
        }
        let order = minimum_degree(pattern)?;
        let (permuted, origin) = pattern.permuted(&order);
        let starts: Vec<u32> = permuted.starts().iter().map(|&s| s as u32).collect();
        let own = SymbolicSparseColMat::new_checked(n, n, starts, None, permuted.rows().to_vec());
        let matrix = own.as_ref();
        let mut parents = vec![0_i32; n];
        let mut counts = vec![0_u32; n];
        let memory = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, pattern.n_places())
            .or(factorize_supernodal_symbolic_cholesky_scratch::<u32>(n));
        let mut memory = MemBuffer::try_new(memory).ok()?;
        let stack = MemStack::new(&mut memory);
        let tree = simplicial::prefactorize_symbolic_cholesky(&mut parents, &mut counts, matrix, stack);
        let supernodes =
            factorize_supernodal_symbolic_cholesky(matrix, tree, &counts, stack, Default::default()).ok()?;
        let flops = counts.iter().map(|&c| f64::from(c).powi(2)).sum();
        Some(Self { order, pattern: Arc::new(permuted), origin, matrix: own, supernodes, flops })
    }

    /// Number of values of L.
    pub fn n_values(&self) -> usize {
        self.supernodes.len_val()
    }

    /// A matrix on the pattern analysed, in the new order.
    fn moved(&self, a: &SparseMatrix) -> SparseMatrix {
        let mut moved = SparseMatrix::new(Arc::clone(&self.pattern));
        for (value, &at) in moved.values.iter_mut().zip(&self.origin) {
            *value = a.values[at];
        }
        moved
    }

    /// The blocks of L, from the first column on.
    fn blocks(&self) -> impl DoubleEndedIterator<Item = Block<'_>> {
        let nodes = &self.supernodes;
        (0..nodes.n_supernodes()).map(|s| {
            let (first, end) = (nodes.supernode_begin()[s] as usize, nodes.supernode_end()[s] as usize);
            let (rows, width) = (nodes.supernode(s).pattern(), end - first);
            let values = nodes.col_ptr_for_val()[s] as usize;
            Block { first, width, height: width + rows.len(), values, rows }
        })
    }
}

fn minimum_degree(pattern: &Pattern) -> Option<Vec<usize>> {
    let n = pattern.n();
    let starts: Vec<u32> = pattern.starts().iter().map(|&s| s as u32).collect();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, pattern.rows());
    let (mut order, mut place) = (vec![0_u32; n], vec![0_u32; n]);
    let memory = amd::order_maybe_unsorted_scratch::<u32>(n, pattern.n_places());
    let mut memory = MemBuffer::try_new(memory).ok()?;
    let stack = MemStack::new(&mut memory);
    amd::order_maybe_unsorted(&mut order, &mut place, matrix, Default::default(), stack).ok()?;
    Some(order.into_iter().map(|old| old as usize).collect())
}

/// A block of columns of one structure.
struct Block<'a> {
    /// First column.
    first: usize,
    /// Number of columns.
    width: usize,
    /// Number of rows, those of the diagonal block counted.
    height: usize,
    /// Where its values begin.
    values: usize,
    /// Rows below the diagonal block.
    rows: &'a [u32],
}

impl Block<'_> {
    /// Column `c` of L.
    #[inline(always)]
    fn column<'v>(&self, values: &'v [f64], c: usize) -> &'v [f64] {
        &values[self.values + c * self.height..][..self.height]
    }
}

// ---- factors

/// Factors of the matrices of one pattern, in the order of its [`Symbolic`] analysis.
pub struct SparseFactors {
    /// The analysis of the pattern.
    pub symbolic: Arc<Symbolic>,
    /// L by blocks of columns, D on its diagonal.
    values: Vec<f64>,
    /// 1 / D.
    inverse: Vec<f64>,
    memory: MemBuffer,
}

impl SparseFactors {
    /// Reserves the memory.
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let needed = factorize_supernodal_numeric_ldlt_scratch::<u32, f64>(
            &symbolic.supernodes,
            Par::Seq,
            Default::default(),
        );
        Self {
            values: Vec::new(),
            inverse: vec![0.0; symbolic.pattern.n()],
            memory: MemBuffer::new(needed),
            symbolic,
        }
    }

    /// Factorizes `a`, whose pattern is that of the analysis in the new order; returns the number of negative
    /// entries of D and the growth of the factors relative to A, infinite where a pivot is exactly zero.
    pub fn factorize(&mut self, a: &SparseMatrix) -> (usize, f64) {
        self.values.resize(self.symbolic.n_values(), 0.0);
        let matrix = SparseColMatRef::new(self.symbolic.matrix.as_ref(), &a.values);
        let done = factorize_supernodal_numeric_ldlt(
            &mut self.values,
            matrix,
            Default::default(),
            &self.symbolic.supernodes,
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        if done.is_err() {
            return (0, f64::INFINITY);
        }
        let (negative, growth) = pivots(&self.symbolic, &self.values, &mut self.inverse);
        if growth.is_nan() {
            return (0, f64::INFINITY);
        }
        (negative, growth / a.norm_max().max(f64::MIN_POSITIVE))
    }

    /// X = A⁻¹ X, several columns at once.
    pub fn solve_several(&self, x: &mut [Row]) {
        solve_rows(&self.symbolic, &self.values, &self.inverse, x);
    }

    /// x = A⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        solve(&self.symbolic, &self.values, &self.inverse, x);
    }
}

// ---- pivots

widest!(
    /// Number of negative pivots and growth of the factors, NaN where one is not a number; the inverse pivots.
    fn pivots(symbolic: &Symbolic, values: &[f64], inverse: &mut [f64]) -> (usize, f64) {
        let (mut negative, mut growth) = (0, 0.0_f64);
        for block in symbolic.blocks() {
            for c in 0..block.width {
                let column = &block.column(values, c)[c..];
                let pivot = column[0];
                negative += usize::from(pivot < 0.0);
                inverse[block.first + c] = pivot.recip();
                let largest = wide::largest(&column[1..]);
                let size = if largest > 1.0 { largest * largest } else { 1.0 + 0.0 * largest };
                let size = size * pivot.abs();
                // NaN stays.
                growth = if size <= growth { growth } else { size };
                if growth.is_nan() {
                    return (negative, growth);
                }
            }
        }
        (negative, growth)
    }
);

// ---- solution

widest!(
    /// [`SparseFactors::solve`], `inverse` 1 / D.
    fn solve(symbolic: &Symbolic, values: &[f64], inverse: &[f64], x: &mut [f64]) {
        // The rows of a block: its own, then those below.
        let mut rows: Vec<f64> = Vec::new();
        for block in symbolic.blocks() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.resize(block.height, 0.0);
            forward(&block, values, &mut rows);
            let (head, below) = rows.split_at(block.width);
            x[own].copy_from_slice(head);
            for (&row, value) in block.rows.iter().zip(below) {
                x[row as usize] += value;
            }
        }
        for (x, inverse) in x.iter_mut().zip(inverse) {
            *x *= inverse;
        }
        for block in symbolic.blocks().rev() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.extend(block.rows.iter().map(|&row| x[row as usize]));
            backward(&block, values, &mut rows);
            x[own].copy_from_slice(&rows[..block.width]);
        }
    }
);

/// Takes the own rows times L from those below them.
#[inline(always)]
fn forward(block: &Block<'_>, values: &[f64], rows: &mut [f64]) {
    let mut c = 0;
    while c + COLUMNS <= block.width {
        let columns: [&[f64]; COLUMNS] = std::array::from_fn(|q| block.column(values, c + q));
        for q in 0..COLUMNS {
            for r in q + 1..COLUMNS {
                rows[c + r] -= rows[c + q] * columns[q][c + r];
            }
        }
        let head = std::array::from_fn(|q| rows[c + q]);
        c += COLUMNS;
        subtract_block(&mut rows[c..], head, columns.map(|column| &column[c..]));
    }
    for c in c..block.width {
        let (head, rest) = rows.split_at_mut(c + 1);
        subtract(rest, head[c], &block.column(values, c)[c + 1..]);
    }
}

/// Takes Lᵀ times the rows below from the own ones.
#[inline(always)]
fn backward(block: &Block<'_>, values: &[f64], rows: &mut [f64]) {
    let blocked = block.width / COLUMNS * COLUMNS;
    for c in (blocked..block.width).rev() {
        let (head, rest) = rows.split_at_mut(c + 1);
        head[c] -= dot(&block.column(values, c)[c + 1..], rest);
    }
    for c in (0..blocked).step_by(COLUMNS).rev() {
        let columns: [&[f64]; COLUMNS] = std::array::from_fn(|q| block.column(values, c + q));
        let end = c + COLUMNS;
        let taken = dot_block(columns.map(|column| &column[end..]), &rows[end..]);
        for q in (0..COLUMNS).rev() {
            let own: f64 = (q + 1..COLUMNS).map(|r| columns[q][c + r] * rows[c + r]).sum();
            rows[c + q] -= taken[q] + own;
        }
    }
}

// ---- several

/// One row of the columns.
pub type Row = [f64; LANES];

/// Columns of L that are read side by side on the way back, where each has sums of its own.
const BACK: usize = 4;

widest!(
    /// [`SparseFactors::solve_several`].
    fn solve_rows(symbolic: &Symbolic, values: &[f64], inverse: &[f64], x: &mut [Row]) {
        let mut rows: Vec<Row> = Vec::new();
        for block in symbolic.blocks() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.resize(block.height, [0.0; LANES]);
            forward_rows(&block, values, &mut rows);
            let (head, below) = rows.split_at(block.width);
            x[own].copy_from_slice(head);
            for (&row, value) in block.rows.iter().zip(below) {
                for (x, value) in x[row as usize].iter_mut().zip(value) {
                    *x += value;
                }
            }
        }
        for (row, inverse) in x.iter_mut().zip(inverse) {
            row.iter_mut().for_each(|x| *x *= inverse);
        }
        for block in symbolic.blocks().rev() {
            let own = block.first..block.first + block.width;
            rows.clear();
            rows.extend_from_slice(&x[own.clone()]);
            rows.extend(block.rows.iter().map(|&row| x[row as usize]));
            backward_rows(&block, values, &mut rows);
            x[own].copy_from_slice(&rows[..block.width]);
        }
    }
);

/// x −= l a.
#[inline(always)]
pub fn take(x: &mut Row, l: f64, a: &Row) {
    for w in 0..LANES {
        x[w] -= l * a[w];
    }
}

/// Takes the own rows times L from those below them.
#[inline(always)]
fn forward_rows(block: &Block<'_>, values: &[f64], rows: &mut [Row]) {
    let mut c = 0;
    while c + COLUMNS <= block.width {
        let columns: [&[f64]; COLUMNS] =
            std::array::from_fn(|q| &block.column(values, c + q)[c..block.height]);
        let (head, below) = rows[c..].split_at_mut(COLUMNS);
        for q in 0..COLUMNS {
            for r in q + 1..COLUMNS {
                let own = head[q];
                take(&mut head[r], columns[q][r], &own);
            }
        }
        let columns = columns.map(|column| &column[COLUMNS..][..below.len()]);
        for (r, row) in below.iter_mut().enumerate() {
            let mut sum = *row;
            for q in 0..COLUMNS {
                take(&mut sum, columns[q][r], &head[q]);
            }
            *row = sum;
        }
        c += COLUMNS;
    }
    for c in c..block.width {
        let (head, below) = rows[c..].split_at_mut(1);
        let column = &block.column(values, c)[c + 1..];
        for (row, &l) in below.iter_mut().zip(column) {
            take(row, l, &head[0]);
        }
    }
}

/// Takes Lᵀ times the rows below from the own ones.
#[inline(always)]
fn backward_rows(block: &Block<'_>, values: &[f64], rows: &mut [Row]) {
    let paired = block.width / BACK * BACK;
    for c in (paired..block.width).rev() {
        let (head, below) = rows[c..].split_at_mut(1);
        for (row, &l) in below.iter().zip(&block.column(values, c)[c + 1..]) {
            take(&mut head[0], l, row);
        }
    }
    for c in (0..paired).step_by(BACK).rev() {
        let columns: [&[f64]; BACK] = std::array::from_fn(|q| &block.column(values, c + q)[c..block.height]);
        let (head, below) = rows[c..].split_at_mut(BACK);
        let mut own: [Row; BACK] = std::array::from_fn(|q| head[q]);
        let under = columns.map(|column| &column[BACK..][..below.len()]);
        for (r, row) in below.iter().enumerate() {
            for q in 0..BACK {
                take(&mut own[q], under[q][r], row);
            }
        }
        for q in (0..BACK).rev() {
            for r in q + 1..BACK {
                let done = own[r];
                take(&mut own[q], columns[q][r], &done);
            }
        }
        head.copy_from_slice(&own);
    }
}

/// The entries of a symmetric matrix that are not zero, for products with several columns at once.
#[derive(Debug, Clone, Default)]
pub struct Filled {
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Filled {
    /// Those of `a`.
    pub fn of(a: &SparseMatrix) -> Self {
        let pattern = a.pattern();
        let mut filled = Self::default();
        filled.starts.push(0);
        for j in 0..pattern.n() {
            for (&value, &row) in a.values[pattern.places(j)].iter().zip(pattern.column(j)) {
                if value != 0.0 {
                    filled.rows.push(row);
                    filled.values.push(value);
                }
            }
            filled.starts.push(filled.rows.len());
        }
        filled
    }

    /// Y = A X.
    pub fn multiply(&self, x: &[Row], y: &mut [Row]) {
        multiply_rows(self, x, y);
    }
}

widest!(
    /// [`Filled::multiply`].
    fn multiply_rows(a: &Filled, x: &[Row], y: &mut [Row]) {
        let (a, x, y) = (a, x, y);
        for (range, y) in a.starts.windows(2).zip(y) {
            let (start, end) = (range[0], range[1]);
            let mut sum = [0.0; LANES];
            // Symmetric: column j is row j.
            for (&value, &row) in a.values[start..end].iter().zip(&a.rows[start..end]) {
                take(&mut sum, -value, &x[row as usize]);
            }
            *y = sum;
        }
    }
);

// ---- form

/// A symmetric matrix.
pub enum Form {
    /// By diagonals.
    Band(Banded),
    /// By places.
    Sparse(SparseMatrix),
}

/// Evaluates an expression for a matrix in whichever form it has.
macro_rules! by_form {
    ($form:expr, $a:ident => $value:expr) => {
        match $form {
            Form::Band($a) => $value,
            Form::Sparse($a) => $value,
        }
    };
}

impl Form {
    /// Number of rows.
    pub fn n(&self) -> usize {
        by_form!(self, a => a.n())
    }

    /// Entries by which vectors are longer than n, to be kept at zero.
    pub fn padding(&self) -> usize {
        match self {
            Self::Band(a) => a.half(),
            Self::Sparse(_) => 0,
        }
    }

    /// Diagonal entry `j`.
    pub fn diagonal(&self, j: usize) -> f64 {
        by_form!(self, a => a.diagonal(j))
    }

    /// Largest diagonal entry.
    pub fn largest_diagonal(&self) -> f64 {
        (0..self.n()).fold(0.0, |largest, j| f64::max(largest, self.diagonal(j)))
    }

    /// y = A x; see [`Banded::multiply`].
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        by_form!(self, a => a.multiply(x, y));
    }

    /// Σ |x_i| |A_ij| |x_j|.
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        by_form!(self, a => a.absolute_form(x))
    }

    /// Σ (w_i A_ij u_j)².
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        by_form!(self, a => a.squared_form(w, u))
    }
}

// ---- factored

/// Factors of K + cM, with the memory to form them again.
pub enum Factors {
    /// Of band matrices.
    Band(Banded),
    /// Of sparse ones: what was factorized, and its factors.
    Sparse(SparseMatrix, SparseFactors),
}

/// What the factors tell of the matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signs {
    /// Number of negative pivots.
    pub negative: usize,
    /// Growth of the factors relative to the matrix.
    pub growth: f64,
}

impl Factors {
    /// Factorizes `k` + `c` `m`, all in the form that this is for, with row and column `pinned` replaced by
    /// those of the identity.
    ///
    /// # Panics
    /// For matrices of another form.
    pub fn factorize(&mut self, k: &Form, c: f64, m: &Form, pinned: Option<usize>) -> Signs {
        let (negative, growth) = match (self, k, m) {
            (Self::Band(factors), Form::Band(k), Form::Band(m)) => {
                factors.combine(k, c, m);
                if let Some(row) = pinned {
                    factors.pin(row);
                }
                factors.factorize()
            }
            (Self::Sparse(sum, factors), Form::Sparse(k), Form::Sparse(m)) => {
                for (out, (k, m)) in sum.values.iter_mut().zip(k.values.iter().zip(&m.values)) {
                    *out = k + c * m;
                }
                if let Some(row) = pinned {
                    sum.pin(row);
                }
                factors.factorize(sum)
            }
            _ => unreachable!("matrices and factors of one structure have one form"),
        };
        Signs { negative, growth }
    }

    /// Number of negative pivots among the rows that `counts` tells.
    pub fn negative_in(&self, counts: impl Fn(usize) -> bool) -> usize {
        let pivots = match self {
            Self::Band(factors) => &factors.inverse,
            Self::Sparse(_, factors) => &factors.inverse,
        };
        // NaN is not positive.
        let negative = |&row: &usize| !(pivots[row] > 0.0) && counts(row);
        (0..pivots.len()).filter(negative).count()
    }

    /// Solves in place with the factors last made.
    pub fn solve(&self, x: &mut [f64]) {
        match self {
            Self::Band(factors) => factors.solve(x),
            Self::Sparse(_, factors) => factors.solve(x),
        }
    }
}

// ---- definite

/// Most rows for which a dense factor is quicker than the analysis of the pattern.
const MOST_DENSE: usize = 500;

/// Negative stiffness (or mass) down to this part of a dof's own counts as zero. Matrices from other
/// programs come as text of some ten digits, so each entry is known to about this part of itself; a free
/// structure then has eigenvalues a little below 0. Symmetry is asked for to the same digits.
const ROUNDING: f64 = 1e-9;

/// Whether all eigenvalues of the symmetric `matrix` are at or above zero, for entries that are rounded.
///
/// Stiff and soft dofs (N/m beside N m/rad, steel beside a suspension) differ by many decades, so each is
/// measured by its own: with S = D A D, d_i = 1/sqrt(scale_i), an error of ε in every entry of A moves no
/// eigenvalue of S by more than ε max_i Σ_j abs(S_ij), and A is semi-definite if and only if S is. The scale is
/// the larger of the diagonals of `matrix` and of `whole`, which is what it was before stiffness was taken away:
/// a loss of all leaves rounding of what was there, not of the nothing that remains.
pub fn is_semidefinite(matrix: &SparseMatrix, whole: &SparseMatrix) -> bool {
    let n = matrix.n();
    // Below the rounding of the largest entry a dof has no scale of its own.
    let least = f64::EPSILON * matrix.norm_max().max(whole.norm_max());
    if least == 0.0 {
        return true;
    }
    let factors: Vec<f64> = (0..n)
        .map(|i| {
            let own = matrix.diagonal(i).abs().max(whole.diagonal(i).abs());
            own.max(least).sqrt().recip()
        })
        .collect();
    let mut scaled = matrix.clone();
    let mut sums = vec![0.0; n];
    for ((i, j, _), value) in matrix.entries().zip(&mut scaled.values) {
        *value = factors[i] * *value * factors[j];
        sums[i] += value.abs();
    }
    let slack = ROUNDING * sums.into_iter().fold(1.0, f64::max);
    for i in 0..n {
        scaled.add(i, i, slack);
    }
    if n <= MOST_DENSE {
        return Llt::new(scaled.to_dense().as_ref(), Side::Lower).is_ok();
    }
    let Some(symbolic) = Symbolic::new(scaled.pattern()) else {
        return false;
    };
    let moved = symbolic.moved(&scaled);
    let (negative, growth) = SparseFactors::new(Arc::new(symbolic)).factorize(&moved);
    negative == 0 && growth.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// A grid of `m` by `m` points, each joined to its neighbours, `shift` taken from the diagonal.
    fn grid(m: usize, shift: f64) -> SparseMatrix {
        let at = |x: usize, y: usize| (x * m + y) as u32;
        let mut places = Vec::new();
        for x in 0..m {
            for y in 0..m {
                if x + 1 < m {
                    places.push((at(x, y), at(x + 1, y)));
                }
                if y + 1 < m {
                    places.push((at(x, y), at(x, y + 1)));
                }
            }
        }
        let mut a = SparseMatrix::new(Arc::new(Pattern::new(m * m, places.iter().copied())));
        for &(i, j) in &places {
            let value = -1.0 - 0.1 * (f64::from(i) + 2.0 * f64::from(j)).sin();
            for (i, j) in [(i, j), (j, i)] {
                a.add(i as usize, j as usize, value);
                a.add(i as usize, i as usize, -value);
            }
        }
        for j in 0..m * m {
            a.add(j, j, 0.1 - shift);
        }
        a
    }

    fn factors(a: &SparseMatrix) -> (SparseFactors, SparseMatrix) {
        let symbolic = Arc::new(Symbolic::new(a.pattern()).unwrap());
        (SparseFactors::new(Arc::clone(&symbolic)), symbolic.moved(a))
    }

    #[test]
    fn solutions_of_definite_and_indefinite_matrices_meet_the_load() {
        for (shift, m) in [(0.0, 1), (0.0, 2), (0.0, 17), (0.73, 17), (3.1, 12)] {
            let (mut factors, a) = factors(&grid(m, shift));
            let (_, growth) = factors.factorize(&a);
            assert!(growth < 1e4, "{growth}");
            let load: Vec<f64> = (0..m * m).map(|j| (1.7 * j as f64).cos()).collect();
            let (mut x, mut back) = (load.clone(), load.clone());
            factors.solve(&mut x);
            a.multiply(&x, &mut back);
            let size = x.iter().fold(1.0_f64, |s, x| s.max(x.abs()));
            for (b, l) in back.iter().zip(&load) {
                assert!((b - l).abs() < 1e-13 * growth * size, "{b} {l}");
            }
        }
    }

    #[test]
    fn negative_pivots_count_the_eigenvalues_below_the_shift() {
        let whole = grid(13, 0.0).to_dense();
        let values = whole.self_adjoint_eigenvalues(Side::Lower).unwrap();
        for shift in [0.05, 0.5, 1.234, 3.3, 9.0] {
            let (mut factors, a) = factors(&grid(13, shift));
            let (negative, growth) = factors.factorize(&a);
            assert!(growth < 1e6);
            assert_eq!(negative, values.iter().filter(|&&v| v < shift).count());
        }
    }

    #[test]
    fn a_pivot_of_zero_is_told() {
        let mut a = SparseMatrix::new(Arc::new(Pattern::new(2, [(1, 0)].into_iter())));
        a.add(0, 1, 1.0);
        a.add(1, 0, 1.0);
        let (mut factors, a) = factors(&a);
        assert_eq!(factors.factorize(&a), (0, f64::INFINITY));
    }

    fn judged(matrix: &Mat<f64>, whole: &Mat<f64>) -> bool {
        let [matrix, whole] = [matrix, whole].map(|a| SparseMatrix::full(a.as_ref()));
        is_semidefinite(&matrix, &whole)
    }

    fn alone(matrix: &Mat<f64>) -> bool {
        judged(matrix, matrix)
    }

    #[test]
    fn many_rows_are_judged_alike() {
        let chain = |end: f64| {
            let pattern = Pattern::new(900, (1..900).map(|i| (i, i - 1)));
            let mut k = SparseMatrix::new(Arc::new(pattern));
            for i in 1..900 {
                for (row, column, value) in
                    [(i, i, 1.0), (i - 1, i - 1, 1.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]
                {
                    k.add(row, column, value);
                }
            }
            k.add(450, 450, end);
            is_semidefinite(&k, &k)
        };
        assert!(chain(0.0) && chain(1e-3) && !chain(-1e-3));
    }

    #[test]
    fn rigid_motions_are_allowed_and_negative_stiffness_is_not() {
        let spring = |low: f64| Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { low });
        assert!(alone(&spring(-1.0)));
        assert!(alone(&spring(-0.5)));
        assert!(!alone(&spring(-1.001)));
        assert!(alone(&Mat::zeros(3, 3)));
    }

    /// A stiff free spring beside a soft one, not joined.
    fn stiff_and_soft(stiff: f64, soft: f64, coupling: f64) -> Mat<f64> {
        let mut k = Mat::zeros(4, 4);
        for (first, own, across) in [(0, stiff, -stiff), (2, soft, -soft * coupling)] {
            for i in 0..2 {
                k[(first + i, first + i)] = own;
                k[(first + i, first + 1 - i)] = across;
            }
        }
        k
    }

    #[test]
    fn a_soft_part_is_judged_by_its_own_stiffness() {
        for soft in [1.0, 1e-3, 1e-6] {
            assert!(alone(&stiff_and_soft(1e9, soft, 1.0)));
            // 1e-9 of the largest entry is up to a million times what is wrong here.
            assert!(!alone(&stiff_and_soft(1e9, soft, 1.001)));
        }
        let mut sagging = stiff_and_soft(1e9, 1.0, 0.0);
        sagging[(3, 3)] = -0.5;
        assert!(!alone(&sagging));
    }

    #[test]
    fn a_soft_suspension_of_a_stiff_beam_is_seen_through_ten_digits() {
        // 40 stiff springs in a row, rounded to ten digits, hung softly at both ends.
        let n = 41;
        let k = Mat::from_fn(n, n, |i, j| {
            let ends = f64::from(u8::from(i == 0) + u8::from(i == n - 1));
            match i.abs_diff(j) {
                0 => 1.234_567_890_1e8 * (2.0 - ends) + 10.0 * ends,
                1 => -1.234_567_890_1e8,
                _ => 0.0,
            }
        });
        let rounded = Mat::from_fn(n, n, |i, j| format!("{:.9e}", k[(i, j)]).parse().unwrap());
        assert!(alone(&k) && alone(&rounded));
    }

    #[test]
    fn what_a_full_loss_leaves_is_rounding_of_what_was_there() {
        let whole = Mat::from_fn(2, 2, |i, j| if i == j { 3.0 } else { 0.0 });
        let mut left = whole.clone();
        left[(1, 1)] = -3.0 * f64::EPSILON;
        assert!(judged(&left, &whole));
        left[(1, 1)] = -3e-6;
        assert!(!judged(&left, &whole));
    }

    #[test]
    fn a_massless_dof_may_not_be_coupled() {
        let mut m = Mat::zeros(2, 2);
        m[(0, 0)] = 5.0;
        assert!(alone(&m));
        (m[(0, 1)], m[(1, 0)]) = (1e-3, 1e-3);
        assert!(!alone(&m));
    }
}
