//! The antiresonance objective, evaluated and minimized in the core.

use std::ops::ControlFlow;

use antires_core::error::Error;
use antires_core::optimize::{
    Candidates, Failure, Objective, ObjectiveEvaluator, evaluate_many, minimize as minimize_core,
};
use antires_core::update::misfit::Misfit;
use antires_core::update::objective::{AntiresonanceObjective as CoreObjective, Target};
use antires_core::update::penalties::Penalty;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::doorway::{Watch, guarded, run, to_python};
use crate::model::Model;
use crate::optimizer::{Search, outcome_to_python};
use crate::parameters::{ParameterParts, core_parameters};

/// J(x) of one model, parameter set and measurement.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct AntiresonanceObjective {
    core: CoreObjective,
}

#[pymethods]
impl AntiresonanceObjective {
    /// Parameters as in `parameters.rs`, targets (dof, excitation, frequencies), the penalty (gamma1, gamma2),
    /// weights one for each measured value.
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        model: &Model,
        parameters: Vec<ParameterParts>,
        targets: Vec<(usize, usize, PyReadonlyArray1<'_, f64>)>,
        misfit: &str,
        penalty: Option<(f64, f64)>,
        snap: f64,
        weights: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Self> {
        let parameters = core_parameters(&model.core, parameters).map_err(to_python)?;
        let targets = targets
            .into_iter()
            .map(|(dof, excitation, freq)| Target {
                dof,
                excitation,
                freq_hz: freq.as_array().to_vec(),
            })
            .collect();
        let misfit = match misfit {
            "absolute" => Misfit::Absolute,
            "squared" => Misfit::Squared,
            "largest" => Misfit::Largest,
            _ => {
                let wanted = "'absolute', 'squared' or 'largest'";
                return Err(to_python(Error::input(
                    "misfit",
                    format!("{misfit:?}"),
                    wanted,
                )));
            }
        };
        let penalty = penalty.map(|(gamma1, gamma2)| Penalty { gamma1, gamma2 });
        let core = CoreObjective::new(
            model.core.clone(),
            parameters,
            targets,
            misfit,
            penalty,
            snap,
        )
        .map_err(to_python)?;
        let core = match weights {
            Some(weights) => core
                .with_weights(weights.as_array().to_vec())
                .map_err(to_python)?,
            None => core,
        };
        Ok(Self { core })
    }

    /// J at x (n,).
    fn cost(&self, x: PyReadonlyArray1<'_, f64>) -> f64 {
        self.core
            .cost(&x.as_array().to_vec(), &mut self.core.workspace())
    }

    /// x (n,) with negligible severities at zero: the point that is evaluated.
    fn repaired<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> Bound<'py, PyArray1<f64>> {
        let mut x = x.as_array().to_vec();
        self.core.repair(&mut x);
        x.into_pyarray(py)
    }

    /// Analytic partner in Hz of each measured value at x (n,), NaN where there is none.
    fn pairs<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let x = x.as_array().to_vec();
        let pairs = run(py, || self.core.pairs(&x, &mut self.core.workspace()))?;
        Ok(pairs
            .into_iter()
            .map(|p| p.unwrap_or(f64::NAN))
            .collect::<Vec<_>>()
            .into_pyarray(py))
    }

    /// The model at x (n,).
    fn model_at(&self, x: PyReadonlyArray1<'_, f64>) -> PyResult<Model> {
        let core = self
            .core
            .model_at(&x.as_array().to_vec())
            .map_err(to_python)?;
        Ok(Model { core })
    }

    /// J of each row of (m, n), (m,).
    fn evaluate_many<'py>(
        &self,
        py: Python<'py>,
        candidates: PyReadonlyArray2<'_, f64>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let genes: Vec<f64> = candidates.as_array().iter().copied().collect();
        let n_genes = self.core.n_parameters();
        let mut watch = Watch::start(None);
        let costs = guarded(py, || {
            let rows = Candidates::new(&genes, n_genes);
            evaluate_many(&self.core, rows, threads, &mut || watch.poll()).map_err(to_python)
        })?;
        match costs {
            ControlFlow::Continue(costs) => Ok(costs.into_pyarray(py)),
            ControlFlow::Break(_) => Err(watch
                .raised
                .unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))),
        }
    }

    /// Searches the box for the least J.
    #[allow(clippy::too_many_arguments)]
    fn minimize<'py>(
        &self,
        py: Python<'py>,
        lower: PyReadonlyArray1<'_, f64>,
        upper: PyReadonlyArray1<'_, f64>,
        guesses: Vec<Vec<f64>>,
        options: &Bound<'py, PyDict>,
        seed: u64,
        threads: usize,
        max_seconds: Option<f64>,
        on_progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut search = Search::new(
            &lower,
            &upper,
            guesses,
            options,
            seed,
            max_seconds,
            on_progress,
        )?;
        let outcome = guarded(py, || {
            let mut evaluator = ObjectiveEvaluator::new(&self.core, threads).map_err(to_python)?;
            search.run(|bounds, guesses, options, seed, hooks| {
                minimize_core(&mut evaluator, bounds, guesses, options, seed, hooks).map_err(
                    |failure| match failure {
                        Failure::Input(error) => to_python(error),
                        Failure::Evaluation(never) => match never {},
                    },
                )
            })
        })?;
        outcome_to_python(py, &outcome)
    }
}
