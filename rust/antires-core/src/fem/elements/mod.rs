//! One element a file: its matrix as data, its formula beside it.

use nalgebra::{Matrix3, SMatrix};

pub mod beam2;
pub mod beam3;
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
            // Owned blocks: products of views are several times slower.
            let block = local.fixed_view::<3, 3>(row, col).into_owned();
            let turned = back * (block * axes);
            global.fixed_view_mut::<3, 3>(row, col).copy_from(&turned);
        }
    }
    global.fill_upper_triangle_with_lower_triangle();
    global
}
