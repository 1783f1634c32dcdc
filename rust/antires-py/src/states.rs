//! All roots or modes at many candidates, converted.

use antires_core::optimize::{Candidates, Objective, evaluate_many};
use antires_core::update::modal_objective::ModalObjective;
use antires_core::update::objective::{AntiresonanceObjective, Band, NullVectors};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::doorway::{Watch, guarded, to_python};

type Floats<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// Targets, frequencies, how much is shown, and slopes of the roots of one candidate.
pub type PyState<'py> = (Bound<'py, PyArray1<u32>>, Floats<'py>, Floats<'py>, Matrix<'py>);

/// Frequencies, shapes, and the slopes of both, of the modes of one candidate.
pub type PyModalState<'py> = (Floats<'py>, Matrix<'py>, Matrix<'py>, Bound<'py, PyArray3<f64>>);

/// Targets, frequencies, how much is shown, left and right null vectors (roots, n_dof), and leftᵀ M right.
pub type PyNullVectors<'py> =
    (Bound<'py, PyArray1<u32>>, Floats<'py>, Floats<'py>, Matrix<'py>, Matrix<'py>, Floats<'py>);

/// All roots at each row of (m, n), one tuple a row: number of the target, Hz and how much is shown of each
/// root, and d ln f / dp (roots, n) if asked for: of the roots between two limits, 0 for others.
pub fn root_states<'py>(
    py: Python<'py>,
    objective: &AntiresonanceObjective,
    candidates: &PyReadonlyArray2<'_, f64>,
    band: Option<&Band>,
    threads: usize,
) -> PyResult<Vec<PyState<'py>>> {
    let n = objective.unknowns.parameters.len();
    let found = evaluated(py, objective, candidates, threads, |o, x, ws| o.state(x, ws, band))?;
    let converted = found.into_iter().map(|state| {
        let rows = state.slopes.len() / n;
        Ok((
            state.target.into_pyarray(py),
            state.freq_hz.into_pyarray(py),
            state.shown.into_pyarray(py),
            state.slopes.into_pyarray(py).reshape([rows, n])?,
        ))
    });
    converted.collect()
}

/// Converts roots with their null vectors.
pub fn null_vectors_to_python(py: Python<'_>, found: NullVectors, n: usize) -> PyResult<PyNullVectors<'_>> {
    let shape = [found.state.target.len(), n];
    Ok((
        found.state.target.into_pyarray(py),
        found.state.freq_hz.into_pyarray(py),
        found.state.shown.into_pyarray(py),
        found.left.into_pyarray(py).reshape(shape)?,
        found.right.into_pyarray(py).reshape(shape)?,
        found.slope.into_pyarray(py),
    ))
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
    let (n, d) = (objective.unknowns.parameters.len(), objective.sensors().len());
    let found = evaluated(py, objective, candidates, threads, |o, x, ws| o.state(x, ws, with_slopes))?;
    let converted = found.into_iter().map(|state| {
        let (modes, rows) = (state.freq_hz.len(), state.slopes.len() / n);
        Ok((
            state.freq_hz.into_pyarray(py),
            state.shapes.into_pyarray(py).reshape([modes, d])?,
            state.slopes.into_pyarray(py).reshape([rows, n])?,
            state.shape_slopes.into_pyarray(py).reshape([rows, d, n])?,
        ))
    });
    converted.collect()
}

/// What is found at every row, detached from the interpreter, Ctrl-C watched.
pub fn evaluated<O: Objective, T: Send>(
    py: Python<'_>,
    objective: &O,
    candidates: &PyReadonlyArray2<'_, f64>,
    threads: usize,
    question: impl Fn(&O, &[f64], &mut O::Workspace) -> T + Sync,
) -> PyResult<Vec<T>> {
    let rows = candidates.as_array();
    let (n, genes): (usize, Vec<f64>) = (rows.ncols(), rows.iter().copied().collect());
    let mut watch = Watch::start(None);
    let found = guarded(py, || {
        evaluate_many(objective, Candidates::new(&genes, n), threads, &question, &mut || watch.poll())
            .map_err(to_python)
    })?;
    let found = found.continue_value();
    found.ok_or_else(|| watch.raised.unwrap_or_else(|| PyKeyboardInterrupt::new_err(())))
}
