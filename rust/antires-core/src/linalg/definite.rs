//! Whether a symmetric matrix is positive semi-definite to working precision.

use faer::linalg::solvers::Llt;
use faer::{Mat, MatRef, Side};

/// Negative eigenvalues down to this part of the largest entry count as zero: matrices from elsewhere
/// are rounded, and a free structure has eigenvalues at 0.
const ROUNDING: f64 = 1e-9;

/// Whether all eigenvalues of the symmetric `matrix` are at or above zero: A + ε max|A| I has a Cholesky
/// factor.
#[must_use]
pub fn is_semidefinite(matrix: MatRef<'_, f64>) -> bool {
    let n = matrix.nrows();
    let slack = ROUNDING * matrix.norm_max();
    if slack == 0.0 {
        return true;
    }
    let shifted = Mat::from_fn(n, n, |i, j| {
        matrix[(i, j)] + if i == j { slack } else { 0.0 }
    });
    Llt::new(shifted.as_ref(), Side::Lower).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_motions_are_allowed_and_negative_stiffness_is_not() {
        let spring = |low: f64| Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { low });
        assert!(is_semidefinite(spring(-1.0).as_ref()));
        assert!(is_semidefinite(spring(-0.5).as_ref()));
        assert!(!is_semidefinite(spring(-1.001).as_ref()));
        assert!(is_semidefinite(Mat::zeros(3, 3).as_ref()));
    }
}
