//! One element a file: its matrix as data, its formula beside it.

use nalgebra::{Matrix3, SMatrix};

pub mod beam2;
pub mod beam3;
pub mod bending;
pub mod lumped;
pub mod spring;

/// Tᵀ A T of a symmetric element matrix A in local axes, T block-diagonal with the 3 x 3 rotation
/// `axes` from global to local. The upper triangle mirrors the lower: symmetric to the last bit.
fn to_global<const N: usize>(
    local: &SMatrix<f64, N, N>,
    axes: &Matrix3<f64>,
) -> SMatrix<f64, N, N> {
    let mut global = SMatrix::<f64, N, N>::zeros();
    let back = axes.transpose();
    for row in (0..N).step_by(3) {
        for col in (0..=row).step_by(3) {
            let block = Matrix3::from_fn(|i, j| local[(row + i, col + j)]);
            let turned = product(&back, &product(&block, axes));
            for j in 0..3 {
                for i in 0..3 {
                    global[(row + i, col + j)] = turned[(i, j)];
                }
            }
        }
    }
    global.fill_upper_triangle_with_lower_triangle();
    global
}

/// A · B written out: several times faster at this size than the general product.
fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// Writes the matrix of one motion to its local dofs.
fn set<const N: usize, const D: usize>(
    target: &mut SMatrix<f64, N, N>,
    dofs: [usize; D],
    values: [[f64; D]; D],
) {
    for (&i, row) in dofs.iter().zip(values) {
        for (&j, value) in dofs.iter().zip(row) {
            target[(i, j)] = value;
        }
    }
}
