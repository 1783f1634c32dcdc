//! Columns i and k of (K − xM)⁻¹ from all modes, where [`columns`](super::columns) has no factors.

use crate::linalg::symmetric::SymmetricSolver;

/// The columns from all modes: h_i = Σ φ_r φ_ir / (λ_r − x) + Σ ψ ψ_i; returns h_iᵀ M h_k.
pub fn modal_columns(
    modes: &SymmetricSolver,
    (i, k): (usize, usize),
    x: f64,
    left: &mut Vec<f64>,
    right: &mut Vec<f64>,
) -> f64 {
    let (lambda, phi) = (modes.eigenvalues(), modes.vectors());
    let n = phi.nrows();
    for column in [&mut *left, &mut *right] {
        column.clear();
        column.resize(n, 0.0);
    }
    let mut slope = 0.0;
    for r in 0..phi.ncols() {
        let stretch = lambda.get(r).map_or(1.0, |l| (l - x).recip());
        let (at_i, at_k) = (phi[(i, r)] * stretch, phi[(k, r)] * stretch);
        for dof in 0..n {
            left[dof] += at_i * phi[(dof, r)];
            right[dof] += at_k * phi[(dof, r)];
        }
        if r < lambda.len() {
            slope += at_i * at_k;
        }
    }
    slope
}
