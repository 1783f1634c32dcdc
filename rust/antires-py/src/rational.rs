//! Loops of the identification: Forsythe's basis, roots, dominant eigenpairs.

use antires_core::linalg::hermitian::{Hermitian, Workspace};
use antires_core::rational;
use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::doorway::{NumericalError, guarded};

/// φ_0 … φ_m at complex points, (n_points, m + 1).
#[pyfunction]
pub fn forsythe_basis_at<'py>(
    py: Python<'py>,
    points: PyReadonlyArray1<'py, Complex64>,
    b: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let (points, b) = (points.as_array().to_vec(), b.as_array().to_vec());
    let shape = [points.len(), b.len()];
    let values = guarded(py, move || Ok(rational::basis_at(&points, &b)))?;
    values.into_pyarray(py).reshape(shape)
}

/// Roots of Σ c_k φ_k from approximations, or None where they do not all stand.
#[pyfunction]
pub fn refined_roots<'py>(
    py: Python<'py>,
    coefficients: PyReadonlyArray1<'py, f64>,
    b: PyReadonlyArray1<'py, f64>,
    start: PyReadonlyArray1<'py, Complex64>,
) -> PyResult<Option<Bound<'py, PyArray1<Complex64>>>> {
    let (c, b) = (coefficients.as_array().to_vec(), b.as_array().to_vec());
    let start = start.as_array().to_vec();
    let found = guarded(py, move || Ok(rational::refined(&c, &b, &start)))?;
    Ok(found.map(|z| z.into_pyarray(py)))
}

/// The first eigenvalue, the mean of the others and the first eigenvector of the transpose of every matrix,
/// (n, m, m), with rows and columns over the roots of `scale`.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn dominant_pairs<'py>(
    py: Python<'py>,
    matrices: PyReadonlyArray3<'py, Complex64>,
    scale: PyReadonlyArray1<'py, f64>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<Complex64>>)> {
    let matrices = matrices.as_array();
    let over: Vec<f64> = scale.as_array().iter().map(|s| 1.0 / s.sqrt()).collect();
    let (count, n) = (matrices.shape()[0], matrices.shape()[1]);
    let (first, rest, vectors) = guarded(py, || {
        let mut work = Workspace::new(n);
        let (mut first, mut rest) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut vectors = vec![Complex64::new(0.0, 0.0); count * n];
        for (matrix, vector) in matrices.outer_iter().zip(vectors.chunks_exact_mut(n)) {
            let found = work.solve(|i, j| matrix[(j, i)] * (over[i] * over[j]), vector);
            first.push(found.first);
            rest.push(found.rest);
        }
        Ok((first, rest, vectors))
    })?;
    Ok((first.into_pyarray(py), rest.into_pyarray(py), vectors.into_pyarray(py).reshape([count, n])?))
}

/// Ascending eigenvalues of the transpose of every matrix, (n, m, m), scaled in the same way; (n, m).
#[pyfunction]
pub fn hermitian_values<'py>(
    py: Python<'py>,
    matrices: PyReadonlyArray3<'py, Complex64>,
    scale: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let matrices = matrices.as_array();
    let over: Vec<f64> = scale.as_array().iter().map(|s| 1.0 / s.sqrt()).collect();
    let (count, n) = (matrices.shape()[0], matrices.shape()[1]);
    let values = guarded(py, || {
        let mut work = Hermitian::default();
        let mut values = vec![0.0; count * n];
        for (matrix, own) in matrices.outer_iter().zip(values.chunks_exact_mut(n)) {
            if !work.eigenvalues(|i, j| matrix[(j, i)] * (over[i] * over[j]), own) {
                return Ok(None);
            }
        }
        Ok(Some(values))
    })?;
    values
        .ok_or_else(|| {
            NumericalError::new_err(("eigenvalues of spectral matrices", "the iteration did not converge"))
        })?
        .into_pyarray(py)
        .reshape([count, n])
}
