//! All roots or modes at many candidates, converted.

use std::ops::{ControlFlow, RangeInclusive};

use antires_core::error::Result;
use antires_core::optimize::Candidates;
use antires_core::optimize::Interrupt;
use antires_core::update::modal_objective::{ModalObjective, modal_states};
use antires_core::update::objective::{AntiresonanceObjective, NullVectors, states};
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::doorway::{Watch, guarded, to_python};

/// Targets, frequencies, how much is shown, and slopes of the roots of one candidate.
pub type PyState<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Frequencies, shapes, and the slopes of both, of the modes of one candidate.
pub type PyModalState<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray3<f64>>,
);

/// All roots at each row of (m, n), one tuple a row: number of the target, Hz and how much is shown of each
/// root, and d ln f / dp (roots, n) if asked for: of the roots between two limits, 0 for others.
pub fn root_states<'py>(
    py: Python<'py>,
    objective: &AntiresonanceObjective,
    candidates: &PyReadonlyArray2<'_, f64>,
    band: Option<&RangeInclusive<f64>>,
    threads: usize,
) -> PyResult<Vec<PyState<'py>>> {
    let n = objective.unknowns().len();
    let found = evaluated(py, candidates, |rows, stop| states(objective, rows, band, threads, stop))?;
    let converted = found.into_iter().map(|state| {
        let rows = state.slopes.len() / n.max(1);
        let slopes = Array2::from_shape_fn((rows, n), |(root, p)| state.slopes[root * n + p]);
        (
            state.target.into_pyarray(py),
            state.freq_hz.into_pyarray(py),
            state.shown.into_pyarray(py),
            slopes.into_pyarray(py),
        )
    });
    Ok(converted.collect())
}

/// Targets, frequencies, how much is shown, left and right null vectors (roots, n_dof), and leftᵀ M right.
pub type PyNullVectors<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// Converts roots with their null vectors.
pub fn null_vectors_to_python(py: Python<'_>, found: NullVectors, n: usize) -> PyNullVectors<'_> {
    let rows = found.state.target.len();
    let array = |values: &[f64]| {
        Array2::from_shape_fn((rows, n), |(root, dof)| values[root * n + dof]).into_pyarray(py)
    };
    (
        found.state.target.into_pyarray(py),
        found.state.freq_hz.into_pyarray(py),
        found.state.shown.into_pyarray(py),
        array(&found.left),
        array(&found.right),
        found.slope.into_pyarray(py),
    )
}

/// All modes at each row of (m, n), one tuple a row: Hz, shapes (modes, dofs) of unit length at all measured
/// dofs in ascending order, and if asked for d ln f / dp (modes, n) and du/dp (modes, dofs, n).
pub fn mode_states<'py>(
    py: Python<'py>,
    objective: &ModalObjective,
    candidates: &PyReadonlyArray2<'_, f64>,
    with_slopes: bool,
    threads: usize,
) -> PyResult<Vec<PyModalState<'py>>> {
    let (n, d) = (objective.unknowns().len(), objective.sensors().len());
    let found =
        evaluated(py, candidates, |rows, stop| modal_states(objective, rows, with_slopes, threads, stop))?;
    let converted = found.into_iter().map(|state| {
        let modes = state.freq_hz.len();
        let rows = if with_slopes { modes } else { 0 };
        let shapes = Array2::from_shape_fn((modes, d), |(r, s)| state.shapes[r * d + s]);
        let slopes = Array2::from_shape_fn((rows, n), |(r, p)| state.slopes[r * n + p]);
        let of_shapes = |(r, s, p): (usize, usize, usize)| state.shape_slopes[(r * d + s) * n + p];
        let shape_slopes = Array3::from_shape_fn((rows, d, n), of_shapes);
        (
            state.freq_hz.into_pyarray(py),
            shapes.into_pyarray(py),
            slopes.into_pyarray(py),
            shape_slopes.into_pyarray(py),
        )
    });
    Ok(converted.collect())
}

/// What is found at every row, detached from the interpreter, Ctrl-C watched.
fn evaluated<T: Send>(
    py: Python<'_>,
    candidates: &PyReadonlyArray2<'_, f64>,
    find: impl Fn(Candidates<'_>, &mut dyn FnMut() -> Option<Interrupt>) -> Result<ControlFlow<Interrupt, Vec<T>>>
    + Sync,
) -> PyResult<Vec<T>> {
    let rows = candidates.as_array();
    let (n, genes): (usize, Vec<f64>) = (rows.ncols(), rows.iter().copied().collect());
    let mut watch = Watch::start(None);
    let found = guarded(py, || find(Candidates::new(&genes, n), &mut || watch.poll()).map_err(to_python))?;
    match found {
        ControlFlow::Continue(found) => Ok(found),
        ControlFlow::Break(_) => Err(watch.raised.unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))),
    }
}
