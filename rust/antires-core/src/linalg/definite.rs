//! Whether a symmetric matrix is positive semi-definite to working precision.

use std::sync::Arc;

use faer::Side;
use faer::linalg::solvers::Llt;

use super::sparse::factors::Definiteness;
use super::sparse::{SparseFactors, SparseMatrix, Symbolic};

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
#[must_use]
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
    SparseFactors::new(Arc::new(symbolic)).factorize_moved(&scaled) == Definiteness::Positive
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::super::sparse::Pattern;
    use super::*;

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
                for (row, column, value) in [
                    (i, i, 1.0),
                    (i - 1, i - 1, 1.0),
                    (i, i - 1, -1.0),
                    (i - 1, i, -1.0),
                ] {
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
