//! Symmetric band matrices: product, A = L D Lᵀ, and the count of eigenvalues below a shift.
//!
//! Column j of the lower triangle is stored from its diagonal down, `half` entries below it. The factors
//! are formed without pivoting: stable for a positive definite A. For K − xM, which is not, only the signs
//! of D are used. By Sylvester's law as many of them are negative as there are eigenvalues of
//! K φ = λ M φ below x; the growth of the factors tells how far rounding may have shifted x.
//!
//! Reference: Golub & Van Loan, Matrix Computations, 4th ed., sections 4.3 and 8.4.

/// Growth of the factors, relative to the matrix, at which they are no longer trusted: rounding is then
/// still below 1e-9 of the matrix.
pub const LARGEST_GROWTH: f64 = 1e6;

/// A symmetric band matrix, or its factors L (unit, below the diagonal) and D (on it).
#[derive(Debug, Clone, Default)]
pub struct Banded {
    n: usize,
    half: usize,
    /// Column j at j (half + 1); `half` columns of zeros follow, so that no loop needs a shorter end.
    entries: Vec<f64>,
}

impl Banded {
    /// Zero matrix of `n` rows with `half` diagonals below the main one.
    #[must_use]
    pub fn new(n: usize, half: usize) -> Self {
        Self {
            n,
            half,
            entries: vec![0.0; (n + half) * (half + 1)],
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// Number of diagonals below the main one.
    #[must_use]
    pub fn half(&self) -> usize {
        self.half
    }

    /// Sets every entry (row, column), row >= column, within the band.
    pub fn fill(&mut self, entry: impl Fn(usize, usize) -> f64) {
        for j in 0..self.n {
            let rows = (self.n - j).min(self.half + 1);
            let start = j * (self.half + 1);
            for (d, value) in self.entries[start..start + rows].iter_mut().enumerate() {
                *value = entry(j + d, j);
            }
        }
    }

    /// self = a + factor · b, all of one shape.
    pub fn combine(&mut self, a: &Self, factor: f64, b: &Self) {
        for ((out, &x), &y) in self.entries.iter_mut().zip(&a.entries).zip(&b.entries) {
            *out = x + factor * y;
        }
    }

    /// Puts zeros into row and column `i`, and one on the diagonal.
    pub fn pin(&mut self, i: usize) {
        let width = self.half + 1;
        for d in 1..=self.half.min(i) {
            self.entries[(i - d) * width + d] = 0.0;
        }
        self.entries[i * width..(i + 1) * width].fill(0.0);
        self.entries[i * width] = 1.0;
    }

    fn column(&self, j: usize) -> &[f64] {
        &self.entries[j * (self.half + 1)..(j + 1) * (self.half + 1)]
    }

    /// Diagonal entry j, of the matrix or of D.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        self.entries[j * (self.half + 1)]
    }

    /// y = A x; both have `half` more entries than A has rows, zero in x and of no meaning in y.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for j in 0..self.n {
            let column = self.column(j);
            let xj = x[j];
            let (head, below) = y[j..=j + self.half].split_at_mut(1);
            let mut sum = column[0] * xj;
            for ((&a, &xi), yi) in column[1..].iter().zip(&x[j + 1..]).zip(below) {
                sum += a * xi;
                *yi += a * xj;
            }
            head[0] += sum;
        }
    }

    /// Σ |x_i| |A_ij| |x_j|: how far one ulp in each entry can move xᵀ A x, over ulp.
    #[must_use]
    pub fn absolute_form(&self, x: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| {
                let column = self.column(j);
                let below: f64 = column[1..]
                    .iter()
                    .zip(&x[j + 1..])
                    .map(|(a, xi)| (a * xi).abs())
                    .sum();
                x[j].abs() * (column[0].abs() * x[j].abs() + 2.0 * below)
            })
            .sum()
    }

    /// Replaces A by its factors; returns the number of negative entries of D and the growth of the
    /// factors relative to A.
    pub fn factorize(&mut self) -> (usize, f64) {
        let width = self.half + 1;
        let largest = self.entries.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        let (mut negative, mut growth) = (0, 0.0_f64);
        for j in 0..self.n {
            let (done, rest) = self.entries.split_at_mut((j + 1) * width);
            let column = &mut done[j * width..];
            if column[0] == 0.0 {
                // A pivot of exactly zero: the least shift of the matrix that makes it regular.
                column[0] = f64::EPSILON * largest + f64::MIN_POSITIVE;
            }
            let pivot = column[0];
            negative += usize::from(pivot < 0.0);
            let inverse = pivot.recip();
            for c in 1..width {
                let l = column[c] * inverse;
                if l != 0.0 {
                    let target = &mut rest[(c - 1) * width..(c - 1) * width + width - c];
                    for (t, &a) in target.iter_mut().zip(&column[c..]) {
                        *t -= l * a;
                    }
                }
            }
            for l in &mut column[1..] {
                growth = growth.max((*l * *l * inverse).abs());
                *l *= inverse;
            }
            growth = growth.max(pivot.abs());
        }
        (negative, growth / largest.max(f64::MIN_POSITIVE))
    }

    /// x = A⁻¹ x from the factors; x has `half` more entries than A has rows, kept at zero.
    pub fn solve(&self, x: &mut [f64]) {
        for j in 0..self.n {
            let (head, below) = x[j..=j + self.half].split_at_mut(1);
            for (xi, &l) in below.iter_mut().zip(&self.column(j)[1..]) {
                *xi -= l * head[0];
            }
        }
        x[self.n..].fill(0.0);
        for j in (0..self.n).rev() {
            let column = self.column(j);
            let (head, below) = x[j..=j + self.half].split_at_mut(1);
            let sum: f64 = column[1..]
                .iter()
                .zip(below.iter())
                .map(|(l, xi)| l * xi)
                .sum();
            head[0] = head[0] / column[0] - sum;
        }
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

/// Number of eigenvalues of K φ = λ M φ below `x`, and by how much rounding may have shifted x in it. M is
/// positive definite, with a diagonal near one.
pub fn count_below(k: &Banded, m: &Banded, x: f64, work: &mut Banded) -> (usize, f64) {
    work.combine(k, -x, m);
    let (negative, growth) = work.factorize();
    let largest = (0..k.n).fold(0.0_f64, |l, j| l.max(k.diagonal(j)));
    (negative, f64::EPSILON * largest * growth.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laplacian(n: usize, half: usize) -> Banded {
        let mut a = Banded::new(n, half);
        a.fill(|i, j| match i - j {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        a
    }

    #[test]
    fn solve_undoes_multiply() {
        let (n, half) = (17, 4);
        let mut a = Banded::new(n, half);
        a.fill(|i, j| {
            if i == j {
                9.0
            } else {
                ((3 * i + 5 * j) as f64).sin()
            }
        });
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
        let (k, mut m) = (laplacian(n, 3), Banded::new(n, 3));
        m.fill(|i, j| f64::from(u8::from(i == j)));
        let mut work = Banded::new(n, 3);
        for step in 1..60 {
            let x = 0.0671 * f64::from(step);
            let want = (1..=n)
                .filter(|&j| {
                    2.0 - 2.0 * (j as f64 * std::f64::consts::PI / (n + 1) as f64).cos() < x
                })
                .count();
            let (got, error) = count_below(&k, &m, x, &mut work);
            assert!(got == want && error < 1e-10, "{x} {error}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_told() {
        let mut a = laplacian(6, 2);
        let b = laplacian(6, 2);
        a.combine(&b, -2.0, &b);
        assert!(!a.factorize_definite(0.0));
    }
}
