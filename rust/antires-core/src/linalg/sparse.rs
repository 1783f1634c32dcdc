//! Sparse symmetric matrices on a fixed pattern: both triangles by columns, rows ascending, every diagonal place.

use std::ops::Range;
use std::sync::Arc;

use faer::{Mat, MatRef};

use super::wide::{LANES, total};

/// The pattern of a symmetric matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    starts: Vec<usize>,
    rows: Vec<u32>,
}

impl Pattern {
    /// Pattern of `n` rows with the given places, their mirror images and the diagonal. A place outside is
    /// a bug of the caller.
    pub fn new(n: usize, places: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let all = || {
            let mirrored = places.clone().filter(|(i, j)| i != j);
            mirrored.flat_map(|(i, j)| [(i, j), (j, i)])
        };
        let mut starts = vec![0_usize; n + 1];
        for j in 0..n {
            starts[j + 1] = 1;
        }
        for (_, j) in all() {
            starts[j as usize + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut rows = vec![0_u32; starts[n]];
        for j in 0..n {
            rows[next[j]] = j as u32;
            next[j] += 1;
        }
        for (i, j) in all() {
            rows[next[j as usize]] = i;
            next[j as usize] += 1;
        }
        // Sorted, each place once.
        let (mut kept, mut first) = (0, 0);
        for j in 0..n {
            let end = starts[j + 1];
            rows[first..end].sort_unstable();
            starts[j] = kept;
            for at in first..end {
                if at == first || rows[at] != rows[at - 1] {
                    rows[kept] = rows[at];
                    kept += 1;
                }
            }
            first = end;
        }
        starts[n] = kept;
        rows.truncate(kept);
        rows.shrink_to_fit();
        Self { starts, rows }
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of places.
    pub fn n_places(&self) -> usize {
        self.rows.len()
    }

    /// Where each column begins, and the end of the last.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Numbers of the places of column `j`.
    pub fn places(&self, j: usize) -> Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    /// Rows of all columns, one after the other.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Rows of column `j`, ascending.
    pub fn column(&self, j: usize) -> &[u32] {
        &self.rows[self.places(j)]
    }

    /// Number of the place (i, j), if it is one.
    pub fn find(&self, i: usize, j: usize) -> Option<usize> {
        let found = self.column(j).binary_search(&(i as u32));
        found.ok().map(|at| self.starts[j] + at)
    }

    /// Those of the places that `kept` tells, mirror images alike, and the diagonal; for each its number here.
    pub fn kept(&self, kept: impl Fn(usize) -> bool) -> (Self, Vec<usize>) {
        let mirrors = self.mirrors();
        let (mut starts, mut rows, mut origin) = (vec![0], Vec::new(), Vec::new());
        for j in 0..self.n() {
            for at in self.places(j) {
                if kept(at) || kept(mirrors[at]) || self.rows[at] as usize == j {
                    rows.push(self.rows[at]);
                    origin.push(at);
                }
            }
            starts.push(rows.len());
        }
        (Self { starts, rows }, origin)
    }

    /// The pattern with row and column `order[new]` moved to `new`, and for each of its places the number
    /// that it has here.
    pub fn permuted(&self, order: &[usize]) -> (Self, Vec<usize>) {
        let n = self.n();
        let mut place = vec![0_u32; n];
        let mut starts = Vec::with_capacity(n + 1);
        starts.push(0);
        for (new, &old) in order.iter().enumerate() {
            place[old] = new as u32;
            starts.push(starts[new] + self.column(old).len());
        }
        let mirrors = self.mirrors();
        let (mut rows, mut origin) = (vec![0_u32; self.rows.len()], vec![0; self.rows.len()]);
        // Row after row of the new pattern, so that the columns come out sorted.
        let mut next = starts.clone();
        for (new, &old) in order.iter().enumerate() {
            for at in self.places(old) {
                let free = &mut next[place[self.rows[at] as usize] as usize];
                rows[*free] = new as u32;
                origin[*free] = mirrors[at];
                *free += 1;
            }
        }
        (Self { starts, rows }, origin)
    }

    /// For each place (i, j) the number of the place (j, i).
    fn mirrors(&self) -> Vec<usize> {
        let mut next = self.starts.clone();
        let mirror = |&i: &u32| {
            let at = next[i as usize];
            next[i as usize] += 1;
            at
        };
        self.rows.iter().map(mirror).collect()
    }
}

// ---- matrix

/// Values on a [`Pattern`], which other matrices may share.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    pattern: Arc<Pattern>,
    /// One for each place, in its order.
    pub values: Vec<f64>,
}

impl SparseMatrix {
    /// Zero matrix.
    pub fn new(pattern: Arc<Pattern>) -> Self {
        let values = vec![0.0; pattern.n_places()];
        Self { pattern, values }
    }

    /// A dense symmetric matrix, every place of it.
    pub fn full(dense: MatRef<'_, f64>) -> Self {
        let n = dense.nrows() as u32;
        let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let mut matrix = Self::new(Arc::new(Pattern::new(n as usize, places)));
        for j in 0..dense.ncols() {
            for i in 0..dense.nrows() {
                matrix.add(i, j, dense[(i, j)]);
            }
        }
        matrix
    }

    /// The places of its entries.
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Entry (i, j), zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.pattern.find(i, j).map_or(0.0, |at| self.values[at])
    }

    /// Diagonal entry `j`.
    pub fn diagonal(&self, j: usize) -> f64 {
        self.get(j, j)
    }

    /// Adds to the entry (i, j), which has to be a place of the pattern.
    ///
    /// # Panics
    /// If it is none.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.pattern.find(i, j).expect("a place of the pattern");
        self.values[at] += value;
    }

    /// Puts zeros into row and column `j`, and one on the diagonal.
    pub fn pin(&mut self, j: usize) {
        for at in self.pattern.places(j) {
            let i = self.pattern.rows()[at] as usize;
            self.values[at] = f64::from(u8::from(i == j));
            if let Some(mirrored) = self.pattern.find(j, i).filter(|_| i != j) {
                self.values[mirrored] = 0.0;
            }
        }
    }

    /// All places (row, column) with their values, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.n()).flat_map(move |j| {
            self.pattern.places(j).map(move |at| (self.pattern.rows()[at] as usize, j, self.values[at]))
        })
    }

    /// Largest modulus of the entries.
    pub fn norm_max(&self) -> f64 {
        self.values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
    }

    /// The same as a dense matrix.
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.n(), self.n());
        self.write_dense(&mut dense);
        dense
    }

    /// [`to_dense`](Self::to_dense) into a matrix that is zero outside the pattern.
    pub fn write_dense(&self, dense: &mut Mat<f64>) {
        for j in 0..self.n() {
            let column = dense.col_as_slice_mut(j);
            for at in self.pattern.places(j) {
                column[self.pattern.rows()[at] as usize] = self.values[at];
            }
        }
    }

    /// The dense matrix without some rows and as many columns.
    pub fn deleted(&self, rows: &[usize], columns: &[usize]) -> Mat<f64> {
        let n = self.n() - rows.len();
        let mut dense = Mat::zeros(n, n);
        let place = |dof: usize, gone: &[usize]| dof - gone.iter().filter(|&&g| g < dof).count();
        for (row, column, value) in self.entries() {
            if !rows.contains(&row) && !columns.contains(&column) {
                dense[(place(row, rows), place(column, columns))] = value;
            }
        }
        dense
    }

    /// y = A x.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for j in 0..self.n() {
            // Symmetric: column j is row j.
            y[j] = gathered_dot(&self.values[self.pattern.places(j)], self.pattern.column(j), x);
        }
    }

    /// Σ |x_i| |A_ij| |x_j|: how far one ulp in each entry can move xᵀ A x, over ulp.
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        self.summed(|i, j, a| (x[i] * a * x[j]).abs())
    }

    /// Σ (w_i A_ij u_j)²: the square of how far one ulp of random sign in each entry moves wᵀ A u, over ulp.
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        self.summed(|i, j, a| (w[i] * a * u[j]).powi(2))
    }

    fn summed(&self, term: impl Fn(usize, usize, f64) -> f64) -> f64 {
        let column = |j: usize| {
            let pairs = self.values[self.pattern.places(j)].iter().zip(self.pattern.column(j));
            pairs.map(|(&a, &i)| term(i as usize, j, a)).sum::<f64>()
        };
        (0..self.n()).map(column).sum()
    }
}

/// Σ a_q x_(rows_q), in sums side by side: one alone waits for each addition.
#[inline]
fn gathered_dot(a: &[f64], rows: &[u32], x: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (rows, rows_rest) = rows.as_chunks::<LANES>();
    for (a, rows) in a.iter().zip(rows) {
        for l in 0..LANES {
            sums[l] += a[l] * x[rows[l] as usize];
        }
    }
    let rest = a_rest.iter().zip(rows_rest);
    total(sums) + rest.map(|(a, &row)| a * x[row as usize]).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_mirrored_sorted_and_kept_once() {
        let pattern = Pattern::new(4, [(2, 0), (0, 2), (3, 0), (1, 1)].into_iter());
        assert_eq!(pattern.column(0), [0, 2, 3]);
        assert_eq!(pattern.column(1), [1]);
        assert_eq!(pattern.column(2), [0, 2]);
        assert_eq!(pattern.column(3), [0, 3]);
        assert_eq!(pattern.find(3, 0), Some(2));
        assert_eq!(pattern.find(3, 1), None);
        assert_eq!(pattern.n_places(), 8);
    }

    #[test]
    fn a_permuted_pattern_knows_where_its_places_come_from() {
        let pattern = Pattern::new(4, [(2, 0), (3, 0), (1, 3)].into_iter());
        let order = [3, 1, 0, 2];
        let (moved, origin) = pattern.permuted(&order);
        for j in 0..4 {
            for (at, &i) in (moved.starts[j]..).zip(moved.column(j)) {
                assert_eq!(pattern.find(order[i as usize], order[j]), Some(origin[at]));
            }
        }
        assert_eq!(moved.n_places(), pattern.n_places());
    }

    #[test]
    fn a_part_of_a_pattern_keeps_mirror_images_and_the_diagonal() {
        let pattern = Pattern::new(4, [(2, 0), (3, 0), (1, 3)].into_iter());
        let wanted = pattern.find(3, 0).unwrap();
        let (part, origin) = pattern.kept(|at| at == wanted);
        assert_eq!(part, Pattern::new(4, [(3, 0)].into_iter()));
        for j in 0..4 {
            for (at, &i) in (part.starts[j]..).zip(part.column(j)) {
                assert_eq!(pattern.find(i as usize, j), Some(origin[at]));
            }
        }
    }

    fn sample() -> SparseMatrix {
        let pattern = Arc::new(Pattern::new(4, [(1, 0), (3, 1), (3, 2)].into_iter()));
        let mut a = SparseMatrix::new(pattern);
        for (i, j, v) in [(1, 0, -2.0), (3, 1, 0.5), (3, 2, 4.0)] {
            a.add(i, j, v);
            a.add(j, i, v);
        }
        for j in 0..4 {
            a.add(j, j, 1.0 + j as f64);
        }
        a
    }

    #[test]
    fn products_and_forms_are_those_of_the_dense_matrix() {
        let (a, dense) = (sample(), sample().to_dense());
        let (w, u) = ([1.0, -2.0, 0.5, 3.0], [0.3, 1.0, -1.0, 2.0]);
        let mut y = [0.0; 4];
        a.multiply(&u, &mut y);
        let (mut absolute, mut squared) = (0.0, 0.0);
        for i in 0..4 {
            let want: f64 = (0..4).map(|j| dense[(i, j)] * u[j]).sum();
            assert!((y[i] - want).abs() < 1e-15);
            for j in 0..4 {
                absolute += (u[i] * dense[(i, j)] * u[j]).abs();
                squared += (w[i] * dense[(i, j)] * u[j]).powi(2);
            }
        }
        assert!((a.absolute_form(&u) - absolute).abs() < 1e-13);
        assert!((a.squared_form(&w, &u) - squared).abs() < 1e-12);
    }

    #[test]
    fn a_row_and_a_column_can_be_left_out() {
        let (a, dense) = (sample(), sample().to_dense());
        let left = a.deleted(&[1], &[3]);
        for (r, i) in [0, 2, 3].into_iter().enumerate() {
            for (c, j) in [0, 1, 2].into_iter().enumerate() {
                assert_eq!(left[(r, c)], dense[(i, j)]);
            }
        }
    }
}
