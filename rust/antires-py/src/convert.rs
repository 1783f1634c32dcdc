//! Between numpy arrays and the core's matrices.

use antires_core::fem::term::Term;
use faer::{Mat, MatRef};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// A term as Python gives it: rows, columns, values.
pub type TermArrays<'py> = (
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray1<'py, f64>,
);

/// Dense matrix of an array.
pub fn matrix(array: &PyReadonlyArray2<'_, f64>) -> Mat<f64> {
    let view = array.as_array();
    Mat::from_fn(view.nrows(), view.ncols(), |i, j| view[(i, j)])
}

/// Array of a dense matrix.
pub fn array<'py>(py: Python<'py>, matrix: MatRef<'_, f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((matrix.nrows(), matrix.ncols()), |(i, j)| matrix[(i, j)])
        .into_pyarray(py)
}

/// Core terms of Python's arrays.
pub fn terms(arrays: &[TermArrays<'_>]) -> Vec<Term> {
    arrays
        .iter()
        .map(|(rows, cols, values)| {
            let (rows, cols, values) = (rows.as_array(), cols.as_array(), values.as_array());
            let entries = rows
                .iter()
                .zip(cols)
                .zip(values)
                .map(|((&i, &j), &v)| (i, j, v));
            Term::from_entries(entries.collect())
        })
        .collect()
}
