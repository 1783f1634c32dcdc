//! The island search on a Python objective, and what both searches share.

use std::ops::ControlFlow;

use antires_core::optimize::{
    Bounds, Candidates, Evaluator, Failure, Hooks, Interrupt, IslandOptions, IslandState, Keep, Outcome,
    Population, Progress, minimize as minimize_core,
};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::checkpoint::Checkpoint;
use crate::doorway::{ObjectiveError, Watch, guarded, to_python};
use crate::options::read_options;

/// One search: its problem, its settings, and whoever watches it.
pub struct Search {
    bounds: Bounds,
    guesses: Vec<Vec<f64>>,
    options: IslandOptions,
    seed: u64,
    watch: Watch,
    on_progress: Option<Py<PyAny>>,
    checkpoint: Option<Checkpoint>,
    resume: Option<Vec<u8>>,
}

impl Search {
    pub fn new(
        lower: &PyReadonlyArray1<'_, f64>,
        upper: &PyReadonlyArray1<'_, f64>,
        guesses: Vec<Vec<f64>>,
        options: &Bound<'_, PyDict>,
        seed: u64,
        max_seconds: Option<f64>,
        on_progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let bounds = Bounds::new(lower.as_array().to_vec(), upper.as_array().to_vec());
        Ok(Self {
            bounds: bounds.map_err(to_python)?,
            guesses,
            options: read_options(options)?,
            seed,
            watch: Watch::start(max_seconds),
            on_progress,
            checkpoint: None,
            resume: None,
        })
    }

    /// Keeps the search in a checkpoint, and takes it up from there.
    pub fn kept_in(mut self, checkpoint: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        if let Some(object) = checkpoint {
            let (checkpoint, resume) = Checkpoint::new(object)?;
            (self.checkpoint, self.resume) = (Some(checkpoint), resume);
        }
        Ok(self)
    }

    /// Searches with the hooks in place; raises what a callback raised.
    pub fn run<E: Evaluator<Fault: Into<PyErr>>>(&mut self, evaluator: &mut E) -> PyResult<Outcome> {
        let on_progress = self.on_progress.as_ref();
        let watch = std::cell::RefCell::new(&mut self.watch);
        let mut should_stop = || watch.borrow_mut().poll();
        let mut progress = |p: &Progress<'_>| {
            let callback = on_progress?;
            match Python::attach(|py| report(py, callback, p)) {
                Ok(true) => Some(Interrupt::Callback),
                Ok(false) => None,
                Err(error) => Some(watch.borrow_mut().stop_for(error)),
            }
        };
        let mut hooks = Hooks {
            should_stop: Some(&mut should_stop),
            progress: Some(&mut progress),
            keep: None,
            resume: self.resume.as_deref(),
        };
        let mut keep = self.checkpoint.as_mut().map(|checkpoint| {
            |bytes| {
                if let Err(error) = checkpoint.take(bytes) {
                    watch.borrow_mut().stop_for(error);
                }
            }
        });
        hooks.keep = keep.as_mut().map(|keep| keep as &mut Keep<'_>);
        let outcome =
            minimize_core(evaluator, &self.bounds, &self.guesses, &self.options, self.seed, &mut hooks);
        if let Some(checkpoint) = &mut self.checkpoint {
            checkpoint.store()?;
        }
        let outcome = outcome.map_err(|failure| match failure {
            Failure::Input(error) => to_python(error),
            Failure::Evaluation(fault) => fault.into(),
        })?;
        match self.watch.raised.take() {
            Some(error) => Err(error),
            None => Ok(outcome),
        }
    }
}

/// Calls the callback with the state of the search; true asks for a stop.
fn report(py: Python<'_>, callback: &Py<PyAny>, progress: &Progress<'_>) -> PyResult<bool> {
    let state = PyDict::new(py);
    state.set_item("nit", progress.generation)?;
    state.set_item("nfev", progress.evaluations)?;
    state.set_item("migrations", progress.migrations)?;
    state.set_item("fun", progress.best_cost)?;
    state.set_item("x", progress.best_x.to_vec().into_pyarray(py))?;
    let islands: Vec<(f64, &str)> =
        progress.islands.iter().map(|i| (i.best_cost, state_name(i.state))).collect();
    state.set_item("islands", islands)?;
    callback.call1(py, (state,))?.extract::<Option<bool>>(py).map(|stop| stop == Some(true))
}

fn state_name(state: IslandState) -> &'static str {
    match state {
        IslandState::Searching => "searching",
        IslandState::Waiting => "waiting",
    }
}

/// A Python function of all candidates of a generation: their costs, and why some of them are missing (NaN).
struct PythonEvaluator {
    function: Py<PyAny>,
}

impl Evaluator for PythonEvaluator {
    type Fault = PyErr;

    fn evaluate(
        &mut self,
        candidates: Candidates<'_>,
        costs: &mut [f64],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, PyErr> {
        let shape = (candidates.len(), candidates.n_genes());
        let answer = Python::attach(|py| -> PyResult<(Vec<f64>, Option<String>)> {
            let rows = Array2::from_shape_vec(shape, candidates.as_slice().to_vec())
                .expect("as many values as the candidates have genes");
            let rows: Bound<'_, PyArray2<f64>> = rows.into_pyarray(py);
            self.function.call1(py, (rows,))?.extract(py)
        });
        let stopped = match answer {
            Ok((values, stopped)) if values.len() == costs.len() => {
                costs.copy_from_slice(&values);
                stopped
            }
            Ok((values, _)) => {
                return Err(ObjectiveError::new_err((
                    "fun",
                    format!("{} costs", values.len()),
                    format!("{}, one for each candidate", costs.len()),
                    "Return a float for each candidate.",
                )));
            }
            Err(error) if Python::attach(|py| error.is_instance_of::<PyKeyboardInterrupt>(py)) => {
                return Ok(ControlFlow::Break(Interrupt::User));
            }
            Err(error) => return Err(error),
        };
        if let Some(why) = stopped {
            return Ok(ControlFlow::Break(match why.as_str() {
                "interrupted" => Interrupt::User,
                "time" => Interrupt::TimeLimit,
                _ => Interrupt::Callback,
            }));
        }
        Ok(poll().map_or(ControlFlow::Continue(()), ControlFlow::Break))
    }
}

/// Searches the box for the least value of a Python function of (m, n) candidates.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn minimize<'py>(
    py: Python<'py>,
    function: Py<PyAny>,
    lower: PyReadonlyArray1<'_, f64>,
    upper: PyReadonlyArray1<'_, f64>,
    guesses: Vec<Vec<f64>>,
    options: &Bound<'py, PyDict>,
    seed: u64,
    max_seconds: Option<f64>,
    on_progress: Option<Py<PyAny>>,
    checkpoint: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut search =
        Search::new(&lower, &upper, guesses, options, seed, max_seconds, on_progress)?.kept_in(checkpoint)?;
    let outcome = guarded(py, || search.run(&mut PythonEvaluator { function }))?;
    outcome_to_python(py, &outcome)
}

/// The outcome as a dictionary of arrays and plain values.
pub fn outcome_to_python<'py>(py: Python<'py>, outcome: &Outcome) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("x", outcome.x.clone().into_pyarray(py))?;
    dict.set_item("fun", outcome.fun)?;
    dict.set_item("nfev", outcome.nfev)?;
    dict.set_item("njev", outcome.njev)?;
    dict.set_item("nit", outcome.nit)?;
    dict.set_item("migrations", outcome.migrations)?;
    dict.set_item("status", outcome.status.label())?;
    dict.set_item("success", outcome.status.success())?;
    dict.set_item("message", outcome.message())?;
    let history = &outcome.history;
    let shape = [history.evaluations.len(), history.n_islands];
    dict.set_item("history_cost", history.best_costs.clone().into_pyarray(py).reshape(shape)?)?;
    let counts = |all: &[usize]| all.iter().map(|&n| n as u64).collect::<Vec<_>>().into_pyarray(py);
    dict.set_item("history_nfev", counts(&history.evaluations))?;
    dict.set_item("history_migrations", counts(&history.migrations))?;
    let islands = &outcome.islands;
    let shape = [islands.len(), islands[0].population.size(), outcome.x.len()];
    let all = |of: fn(&Population) -> &Vec<f64>| islands.iter().flat_map(move |i| of(&i.population)).copied();
    let (genes, costs): (Vec<f64>, Vec<f64>) = (all(|p| &p.genes).collect(), all(|p| &p.costs).collect());
    dict.set_item("populations", genes.into_pyarray(py).reshape(shape)?)?;
    dict.set_item("population_costs", costs.into_pyarray(py).reshape([shape[0], shape[1]])?)?;
    let names: Vec<&str> = islands.iter().map(|i| i.crossover.name()).collect();
    dict.set_item("crossovers", names)?;
    Ok(dict)
}
