//! Between numpy arrays and the core's matrices.

use antires_core::fem::model::Entry;
use antires_core::fem::term::Term;
use antires_core::linalg::sparse::SparseMatrix;
use faer::MatRef;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;

/// A term as Python gives it: rows, columns, values.
pub type TermArrays<'py> =
    (PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, f64>);

/// Array of a dense matrix.
pub fn array<'py>(py: Python<'py>, matrix: MatRef<'_, f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((matrix.nrows(), matrix.ncols()), |(i, j)| matrix[(i, j)]).into_pyarray(py)
}

/// A sparse matrix as scipy has it: starts of the columns, rows, values.
pub type ColumnArrays<'py> =
    (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

/// Arrays of a sparse matrix, without its zeros.
pub fn columns<'py>(py: Python<'py>, matrix: &SparseMatrix) -> ColumnArrays<'py> {
    let mut starts = vec![0; matrix.n() + 1];
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for (row, column, value) in matrix.entries().filter(|e| e.2 != 0.0) {
        rows.push(row as i64);
        values.push(value);
        starts[column + 1] = rows.len() as i64;
    }
    for j in 0..matrix.n() {
        starts[j + 1] = starts[j + 1].max(starts[j]);
    }
    (starts.into_pyarray(py), rows.into_pyarray(py), values.into_pyarray(py))
}

/// Entries of Python's arrays.
pub fn entries((rows, columns, values): &TermArrays<'_>) -> Vec<Entry> {
    let (rows, columns, values) = (rows.as_array(), columns.as_array(), values.as_array());
    let places = rows.iter().zip(columns).zip(values);
    places.map(|((&i, &j), &v)| (i, j, v)).collect()
}

/// A term by rows, columns and values.
pub type PyTerm<'py> = (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>);

/// Arrays of the core's terms.
pub fn terms_to_python<'py>(py: Python<'py>, terms: &[Term]) -> Vec<PyTerm<'py>> {
    let converted = terms.iter().map(|term| {
        let entries = term.entries();
        let index = |of: fn(&Entry) -> u32| entries.iter().map(of).collect::<Vec<_>>();
        let values: Vec<f64> = entries.iter().map(|entry| entry.2).collect();
        (
            index(|entry| entry.0).into_pyarray(py),
            index(|entry| entry.1).into_pyarray(py),
            values.into_pyarray(py),
        )
    });
    converted.collect()
}

/// Core terms of Python's arrays.
pub fn terms(arrays: &[TermArrays<'_>]) -> Vec<Term> {
    let terms = arrays.iter().map(entries);
    terms.map(Term::from_entries).collect()
}
