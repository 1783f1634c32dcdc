//! Nelson's adjoint solution for one mode: the derivative of any function of its shape, for all parameters.
//!
//! The derivative of a function of a shape whose size it ignores, with slope g there (gᵀφ = 0), needs one
//! solution for each mode, whatever the number of parameters:
//!
//! ```text
//! (K − λM) dφ/dp = −(K' − λM' − λ'M) φ        differentiated K φ = λ M φ
//! (K − λM) z = g,  zᵀMφ = 0                   gᵀ dφ/dp = −zᵀ (K' − λM') φ
//! ```
//!
//! K − λM is singular. By factors it is solved with the row and the column of the largest entry of φ taken
//! out; from all modes z = Σ φ_s (φ_sᵀg) / (λ_s − λ) over the others.
//!
//! Source: R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA J. 14 (1976) 1201-1205,
//! doi 10.2514/3.7211.

use super::scaled::ScaledMatrices;
use crate::linalg::banded::LARGEST_GROWTH;
use crate::linalg::symmetric::SymmetricSolver;

/// Whether a solution could be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjoint {
    /// It is in place.
    Solved,
    /// Rounding spoils the factors.
    Spoiled,
}

/// z for the mode (λ, φ) by the matrices.
pub fn by_factors(
    matrices: &mut ScaledMatrices,
    (lambda, phi): (f64, &[f64]),
    g: &[f64],
    z: &mut Vec<f64>,
) -> Adjoint {
    let (n, padding) = (matrices.n(), matrices.stride() - matrices.n());
    let by_row = |values: &[f64], times: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let rows =
            (0..n).map(|row| values[matrices.structure().dof(row)] * times(matrices.scale()[row]));
        rows.chain(std::iter::repeat_n(0.0, padding)).collect()
    };
    let shape = by_row(phi, &f64::recip);
    let mut solution = by_row(g, &|scale| scale);
    let largest = (0..n).fold(0, |at, row| {
        if shape[row].abs() > shape[at].abs() {
            row
        } else {
            at
        }
    });
    solution[largest] = 0.0;
    if matrices.factorize_without(largest, lambda) > LARGEST_GROWTH {
        return Adjoint::Spoiled;
    }
    matrices.solve(&mut solution);
    let mut weighted = vec![0.0; matrices.stride()];
    matrices.mass().multiply(&shape, &mut weighted);
    let part: f64 = solution[..n]
        .iter()
        .zip(&weighted)
        .map(|(s, w)| s * w)
        .sum();
    for (value, along) in solution[..n].iter_mut().zip(&shape) {
        *value -= part * along;
    }
    z.clear();
    z.resize(n, 0.0);
    matrices.by_dof(&solution[..n], z);
    Adjoint::Solved
}

/// z for mode `r` from all modes.
pub fn by_all_modes(modes: &SymmetricSolver, r: usize, g: &[f64], z: &mut Vec<f64>) {
    let (all, vectors) = (modes.eigenvalues(), modes.vectors());
    let n = vectors.nrows();
    z.clear();
    z.resize(n, 0.0);
    for s in (0..n).filter(|&s| s != r) {
        let along: f64 = (0..n).map(|dof| vectors[(dof, s)] * g[dof]).sum();
        let stretch = all.get(s).map_or(1.0, |l| (l - all[r]).recip());
        for (dof, z) in z.iter_mut().enumerate() {
            *z += along * stretch * vectors[(dof, s)];
        }
    }
}
