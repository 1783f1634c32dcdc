//! Symmetric band matrices: product, A = L D Lᵀ, and the count of eigenvalues below a shift.
//!
//! Column j of the lower triangle is stored from its diagonal down, `half` entries below it. The factors
//! are formed without pivoting: stable for a positive definite A. For K − xM, which is not, only the signs
//! of D are used. By Sylvester's law as many of them are negative as there are eigenvalues of
//! K φ = λ M φ below x; the growth of the factors tells how far rounding may have shifted x.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 4.3 and 8.4.
//!
//! # ordering
//!
//! Reverse Cuthill-McKee: an ordering of the dofs that brings the entries of K and M near the diagonal.
//!
//! Breadth first from a dof at the end of a longest path, neighbours of low degree first, the whole
//! reversed (George & Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, ch. 4).
//! A frame without many loops comes out with a half-bandwidth of a few nodes.

use super::wide::{LANES, dot, subtract, widest};

/// Growth of the factors, relative to the matrix, at which they are no longer trusted: rounding is then
/// still below 1e-9 of the matrix.
pub const LARGEST_GROWTH: f64 = 1e6;

/// A symmetric band matrix, or its factors L (unit, below the diagonal) and D.
#[derive(Debug, Clone, Default)]
pub struct Banded {
    n: usize,
    /// Diagonals below the main one.
    band: usize,
    /// Their number padded to whole lanes.
    half: usize,
    diagonal: Vec<f64>,
    /// Column j below the diagonal at j half; `half` columns of zeros follow, so that no loop needs a
    /// shorter end.
    below: Vec<f64>,
    /// 1 / D of the factors.
    pub inverse: Vec<f64>,
}

impl Banded {
    /// Zero matrix of `n` rows with `band` diagonals below the main one.
    pub fn new(n: usize, band: usize) -> Self {
        let half = band.next_multiple_of(LANES);
        Self {
            n,
            band,
            half,
            diagonal: vec![0.0; n + half],
            below: vec![0.0; (n + half) * half],
            inverse: vec![0.0; n],
        }
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Entries by which vectors are longer than n, to be kept at zero.
    pub fn half(&self) -> usize {
        self.half
    }

    /// Zero matrix again.
    pub fn clear(&mut self) {
        self.diagonal.fill(0.0);
        self.below.fill(0.0);
    }

    /// Sets the entry (row, column), row >= column, within the band.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        if row == column {
            self.diagonal[row] = value;
        } else {
            self.below[column * self.half + row - column - 1] = value;
        }
    }

    /// self = a + factor · b, all of one shape.
    pub fn combine(&mut self, a: &Self, factor: f64, b: &Self) {
        for (out, a, b) in
            [(&mut self.diagonal, &a.diagonal, &b.diagonal), (&mut self.below, &a.below, &b.below)]
        {
            for ((out, &x), &y) in out.iter_mut().zip(a).zip(b) {
                *out = x + factor * y;
            }
        }
    }

    /// Puts zeros into row and column `i`, and one on the diagonal.
    pub fn pin(&mut self, i: usize) {
        for d in 1..=self.band.min(i) {
            self.below[(i - d) * self.half + d - 1] = 0.0;
        }
        self.below[i * self.half..(i + 1) * self.half].fill(0.0);
        self.diagonal[i] = 1.0;
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &[f64] {
        &self.below[j * self.half..(j + 1) * self.half]
    }

    /// Diagonal entry j, of the matrix or of D.
    pub fn diagonal(&self, j: usize) -> f64 {
        self.diagonal[j]
    }

    /// y = A x; both have [`half`](Self::half) more entries than A has rows, zero in x and of no meaning in
    /// y.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        multiply(self, x, y);
    }

    /// Σ |x_i| |A_ij| |x_j|: how far one ulp in each entry can move xᵀ A x, over ulp.
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| {
                let rows = self.column(j).iter().zip(&x[j + 1..]);
                let below: f64 = rows.map(|(a, xi)| (a * xi).abs()).sum();
                x[j].abs() * (self.diagonal[j].abs() * x[j].abs() + 2.0 * below)
            })
            .sum()
    }

    /// Σ (w_i A_ij u_j)²: the square of how far one ulp of random sign in each entry moves wᵀ A u, over ulp.
    pub fn squared_form(&self, w: &[f64], u: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| {
                let pairs = w[j + 1..].iter().zip(&u[j + 1..]);
                let rows = self.column(j).iter().zip(pairs);
                let below: f64 =
                    rows.map(|(a, (wi, ui))| (a * wi * u[j]).powi(2) + (a * w[j] * ui).powi(2)).sum();
                (w[j] * self.diagonal[j] * u[j]).powi(2) + below
            })
            .sum()
    }

    /// Replaces A by its factors; returns the number of negative entries of D and the growth of the
    /// factors relative to A.
    pub fn factorize(&mut self) -> (usize, f64) {
        let larger = |m: f64, a: &f64| m.max(a.abs());
        let largest = self.diagonal.iter().fold(0.0, larger);
        let largest = self.below.iter().fold(largest, larger);
        let (half, mut negative, mut growth) = (self.half, 0, 0.0_f64);
        for j in 0..self.n {
            if self.diagonal[j] == 0.0 {
                // A pivot of exactly zero: the least shift of the matrix that makes it regular.
                self.diagonal[j] = f64::EPSILON * largest + f64::MIN_POSITIVE;
            }
            let pivot = self.diagonal[j];
            // NaN is not positive.
            negative += usize::from(!(pivot > 0.0));
            let inverse = pivot.recip();
            self.inverse[j] = inverse;
            let (done, rest) = self.below.split_at_mut((j + 1) * half);
            let column = &mut done[j * half..];
            for c in 0..self.band {
                let l = column[c] * inverse;
                if l != 0.0 {
                    self.diagonal[j + 1 + c] -= l * column[c];
                    let target = &mut rest[c * half..(c + 1) * half - c - 1];
                    for (t, &a) in target.iter_mut().zip(&column[c + 1..]) {
                        *t -= l * a;
                    }
                }
            }
            for l in column {
                growth = growth.max((*l * *l * inverse).abs());
                *l *= inverse;
            }
            growth = growth.max(pivot.abs());
        }
        (negative, growth / largest.max(f64::MIN_POSITIVE))
    }

    /// x = A⁻¹ x from the factors; x has [`half`](Self::half) more entries than A has rows, kept at zero.
    pub fn solve(&self, x: &mut [f64]) {
        solve(self, x);
    }

    /// Whether the matrix is positive definite by more than `least` of each diagonal entry; the matrix is
    /// replaced by its factors.
    pub fn factorize_definite(&mut self, least: f64) -> bool {
        let diagonal: Vec<f64> = (0..self.n).map(|j| self.diagonal(j)).collect();
        self.factorize();
        // NaN compares false.
        (0..self.n).all(|j| self.diagonal(j) > least * diagonal[j])
    }
}

widest!(
    /// [`Banded::solve`].
    fn solve(factors: &Banded, x: &mut [f64]) {
        let (n, half) = (factors.n, factors.half);
        for j in 0..n {
            let (head, rows) = x[j..=j + half].split_at_mut(1);
            subtract(rows, head[0], factors.column(j));
        }
        x[n..].fill(0.0);
        for (x, inverse) in x.iter_mut().zip(&factors.inverse) {
            *x *= inverse;
        }
        for j in (0..n).rev() {
            let (head, rows) = x[j..=j + half].split_at_mut(1);
            head[0] -= dot(factors.column(j), rows);
        }
    }
);

widest!(
    /// [`Banded::multiply`].
    fn multiply(matrix: &Banded, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for j in 0..matrix.n {
            let (column, xj) = (matrix.column(j), x[j]);
            let (head, rows) = y[j..=j + matrix.half].split_at_mut(1);
            subtract(rows, -xj, column);
            head[0] += matrix.diagonal[j] * xj + dot(column, &x[j + 1..=j + matrix.half]);
        }
    }
);

// ---- ordering

/// Ordering of the vertices of a graph: `order[new] = old`. Components follow one another.
pub fn reverse_cuthill_mckee(neighbours: &[Vec<usize>]) -> Vec<usize> {
    let n = neighbours.len();
    let mut placed = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for seed in 0..n {
        if placed[seed] {
            continue;
        }
        let start = far_end(neighbours, seed);
        let first = order.len();
        placed[start] = true;
        order.push(start);
        let mut next = first;
        while next < order.len() {
            let mut fresh: Vec<usize> =
                neighbours[order[next]].iter().copied().filter(|&v| !placed[v]).collect();
            fresh.sort_unstable_by_key(|&v| (neighbours[v].len(), v));
            fresh.dedup();
            for v in fresh {
                placed[v] = true;
                order.push(v);
            }
            next += 1;
        }
    }
    order.reverse();
    order
}

/// A vertex from which the breadth-first levels are many (pseudo-peripheral).
fn far_end(neighbours: &[Vec<usize>], seed: usize) -> usize {
    let (mut start, mut depth) = (seed, 0);
    loop {
        let levels = levels(neighbours, start);
        let last = levels.iter().filter_map(|l| *l).max().unwrap_or(0);
        let end = (0..neighbours.len())
            .filter(|&v| levels[v] == Some(last))
            .min_by_key(|&v| (neighbours[v].len(), v));
        match end {
            Some(end) if last > depth => (start, depth) = (end, last),
            _ => return start,
        }
    }
}

fn levels(neighbours: &[Vec<usize>], start: usize) -> Vec<Option<usize>> {
    let mut level = vec![None; neighbours.len()];
    level[start] = Some(0);
    let mut queue = std::collections::VecDeque::from([(start, 0)]);
    while let Some((v, depth)) = queue.pop_front() {
        for &w in &neighbours[v] {
            if level[w].is_none() {
                level[w] = Some(depth + 1);
                queue.push_back((w, depth + 1));
            }
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrix of the entries (row, column), row >= column, within the band.
    fn filled(n: usize, band: usize, entry: impl Fn(usize, usize) -> f64) -> Banded {
        let mut a = Banded::new(n, band);
        for j in 0..n {
            for i in j..n.min(j + band + 1) {
                a.set(i, j, entry(i, j));
            }
        }
        a
    }

    fn laplacian(n: usize, half: usize) -> Banded {
        filled(n, half, |i, j| match i - j {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        })
    }

    #[test]
    fn solve_undoes_multiply() {
        let (n, half) = (17, 8);
        let mut a = filled(n, 6, |i, j| if i == j { 9.0 } else { ((3 * i + 5 * j) as f64).sin() });
        assert_eq!(a.half(), half);
        let mut x = vec![0.0; n + half];
        for (i, v) in x[..n].iter_mut().enumerate() {
            *v = (i as f64).cos();
        }
        let mut y = vec![0.0; n + half];
        a.multiply(&x, &mut y);
        y[n..].fill(0.0);
        assert!(a.factorize_definite(1e-3));
        a.solve(&mut y);
        for (got, want) in y.iter().zip(&x) {
            assert!((got - want).abs() < 1e-14);
        }
    }

    #[test]
    fn the_count_is_that_of_the_closed_form() {
        // 2 − 2 cos(j π / (n + 1)) for the fixed-fixed chain.
        let n = 30;
        let k = laplacian(n, 3);
        let m = filled(n, 3, |i, j| f64::from(u8::from(i == j)));
        let mut work = Banded::new(n, 3);
        for step in 1..60 {
            let x = 0.0671 * f64::from(step);
            let want = (1..=n)
                .filter(|&j| 2.0 - 2.0 * (j as f64 * std::f64::consts::PI / (n + 1) as f64).cos() < x)
                .count();
            work.combine(&k, -x, &m);
            let (got, growth) = work.factorize();
            assert!(got == want && growth < 1e5, "{x} {growth}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_told() {
        let mut a = laplacian(6, 2);
        let b = laplacian(6, 2);
        a.combine(&b, -2.0, &b);
        assert!(!a.factorize_definite(0.0));
    }

    #[test]
    fn a_shuffled_path_becomes_a_band_of_one() {
        // Vertices 0..12 of a path, visited in steps of 5 modulo 13.
        let at = |j: usize| (5 * j) % 13;
        let mut neighbours = vec![Vec::new(); 13];
        for j in 0..12 {
            neighbours[at(j)].push(at(j + 1));
            neighbours[at(j + 1)].push(at(j));
        }
        let order = reverse_cuthill_mckee(&neighbours);
        for pair in order.windows(2) {
            assert!(neighbours[pair[0]].contains(&pair[1]));
        }
    }

    #[test]
    fn every_vertex_of_every_component_appears_once() {
        let neighbours = vec![vec![3], vec![], vec![4], vec![0], vec![2]];
        let mut order = reverse_cuthill_mckee(&neighbours);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4]);
    }
}
