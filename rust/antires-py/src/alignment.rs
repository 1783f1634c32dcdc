//! Ascending lists put side by side: values and roots, roots of two states.

use antires_core::update::alignment::{Aligner, Places};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::doorway::guarded;

type Integers<'py> = PyReadonlyArray1<'py, i64>;
type Floats<'py> = PyReadonlyArray1<'py, f64>;

/// Column of each row of `cost`, −1 without one.
#[pyfunction]
pub fn align<'py>(
    py: Python<'py>,
    cost: PyReadonlyArray2<'py, f64>,
    alone_row: Floats<'py>,
    alone_column: Floats<'py>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (cost, rows, columns) = (cost.as_array(), alone_row.as_array(), alone_column.as_array());
    let found = guarded(py, || {
        let mut found = vec![0; cost.nrows()];
        let aligner = &mut Aligner::default();
        aligner.align(|i, j| cost[(i, j)], |i| rows[i], |j| columns[j], cost.ncols(), &mut found);
        Ok(found)
    })?;
    Ok(found.into_pyarray(py))
}

/// Root of each value, −1 without one.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn associate<'py>(
    py: Python<'py>,
    response: Integers<'py>,
    log_f: Floats<'py>,
    std: Floats<'py>,
    root_response: Integers<'py>,
    root_log_f: Floats<'py>,
    root_std: Floats<'py>,
    alone: f64,
    alone_root: Floats<'py>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let found = {
        let values = Places { response: response.as_slice()?, log_f: log_f.as_slice()? };
        let roots = Places { response: root_response.as_slice()?, log_f: root_log_f.as_slice()? };
        let (std, root_std, alone_root) = (std.as_slice()?, root_std.as_slice()?, alone_root.as_slice()?);
        guarded(py, || {
            Ok(antires_core::update::alignment::associate(values, std, roots, root_std, alone, alone_root))
        })?
    };
    Ok(found.into_pyarray(py))
}

/// Number of the earlier root that each root has been, −1 for a new one.
#[pyfunction]
pub fn follow<'py>(
    py: Python<'py>,
    response: Integers<'py>,
    log_f: Floats<'py>,
    response_after: Integers<'py>,
    log_f_after: Floats<'py>,
    born: f64,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let found = {
        let before = Places { response: response.as_slice()?, log_f: log_f.as_slice()? };
        let after = Places { response: response_after.as_slice()?, log_f: log_f_after.as_slice()? };
        guarded(py, || Ok(antires_core::update::alignment::follow(before, after, born)))?
    };
    Ok(found.into_pyarray(py))
}
