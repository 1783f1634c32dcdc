//! The objectives of updating, evaluated and minimized in the core.

use antires_core::antiresonances::Ends;
use antires_core::error::Error;
use antires_core::modal::mac::Shape;
use antires_core::modal::modes::hertz;
use antires_core::optimize::{Objective as CoreObjective, ObjectiveEvaluator};
use antires_core::update::modal_objective::{MeasuredMode, ModalObjective};
use antires_core::update::objective::{AntiresonanceObjective, Sees, Target};
use antires_core::update::pairing::Partner;
use antires_core::update::unknowns::{Misfit, Penalty};
use numpy::ndarray::Array2;
use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::doorway::{guarded, run, to_python};
use crate::model::Model;
use crate::optimizer::{Search, outcome_to_python};
use crate::parameters::{ParameterParts, core_parameters};
use crate::states::{
    PyModalState, PyNullVectors, PyState, evaluated, mode_states, null_vectors_to_python, root_states,
};

/// Frequencies (m,), dofs (k,) and shapes (m, k) of modes measured together.
type ModeParts<'py> = (PyReadonlyArray1<'py, f64>, Vec<usize>, PyReadonlyArray2<'py, Complex64>);

/// Responses, as many forces, frequencies (m,), "frf", "transmissibility" or none, and the number of those measured together.
type TargetParts<'py> = (Vec<usize>, Vec<usize>, PyReadonlyArray1<'py, f64>, Option<String>, usize);

/// Partners' frequencies (m,), and MAC (m,) and shapes (m, n_dof) of modes.
type PyPairs<'py> =
    (Bound<'py, PyArray1<f64>>, Option<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)>);

/// J, residuals (m,) and their slopes (m, n).
type PyLinearized<'py> = (f64, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

enum Core {
    Antiresonance(AntiresonanceObjective),
    Modal(ModalObjective),
}

/// Evaluates an expression for whichever objective there is.
macro_rules! with {
    ($core:expr, $objective:ident => $value:expr) => {
        match $core {
            Core::Antiresonance($objective) => $value,
            Core::Modal($objective) => $value,
        }
    };
}

/// J(x) of one model, parameter set and measurement.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct Objective {
    core: Core,
}

#[pymethods]
impl Objective {
    /// Parameters as in `parameters.rs`, targets (responses, forces, frequencies, what they see, the number of those
    /// measured together), the penalty (gamma1, gamma2), weights one for each measured value.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn antiresonance(
        py: Python<'_>,
        model: &Model,
        parameters: Vec<ParameterParts>,
        targets: Vec<TargetParts<'_>>,
        misfit: &str,
        penalty: Option<(f64, f64)>,
        snap: f64,
        weights: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Self> {
        let targets = targets.into_iter().map(target_of).collect::<Result<_, _>>().map_err(to_python)?;
        let weights = weights.map(|weights| weights.as_array().to_vec());
        let core = run(py, || {
            let parameters = core_parameters(&model.core, parameters)?;
            let (misfit, penalty) = (misfit_of(misfit)?, penalty_of(penalty));
            let model = model.core.clone();
            AntiresonanceObjective::new(model, parameters, targets, misfit, penalty, snap)?
                .with_weights(weights)
        })?;
        Ok(Self { core: Core::Antiresonance(core) })
    }

    /// The same with modes, one tuple for those measured together, and weights one for each mode.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn modal(
        model: &Model,
        parameters: Vec<ParameterParts>,
        modes: Vec<ModeParts<'_>>,
        misfit: &str,
        penalty: Option<(f64, f64)>,
        snap: f64,
        weights: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Self> {
        let made = (|| {
            let mut measured = Vec::new();
            for (freq_hz, dofs, shapes) in modes {
                for (&freq_hz, row) in freq_hz.as_array().iter().zip(shapes.as_array().rows()) {
                    let entries: Vec<(f64, f64)> = row.iter().map(|z| (z.re, z.im)).collect();
                    let shape = Shape::new("measured", dofs.clone(), &entries)?;
                    measured.push(MeasuredMode { freq_hz, shape });
                }
            }
            let parameters = core_parameters(&model.core, parameters)?;
            let (misfit, penalty) = (misfit_of(misfit)?, penalty_of(penalty));
            let model = model.core.clone();
            let weights = weights.map(|weights| weights.as_array().to_vec());
            ModalObjective::new(model, parameters, measured, misfit, penalty, snap)?.with_weights(weights)
        })();
        Ok(Self { core: Core::Modal(made.map_err(to_python)?) })
    }

    /// J at x (n,).
    fn cost(&self, py: Python<'_>, x: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        let x = x.as_array().to_vec();
        run(py, || Ok(with!(&self.core, o => o.cost(&x, &mut o.workspace()))))
    }

    /// x (n,) with negligible severities at zero: the point that is evaluated.
    fn repaired<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> Bound<'py, PyArray1<f64>> {
        let mut x = x.as_array().to_vec();
        with!(&self.core, o => o.repair(&mut x));
        x.into_pyarray(py)
    }

    /// Analytic partner in Hz of each measured value at x (n,), and of modes its MAC and its shape; NaN where
    /// there is none.
    fn pairs<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> PyResult<PyPairs<'py>> {
        let x = x.as_array().to_vec();
        let objective = match &self.core {
            Core::Modal(objective) => objective,
            Core::Antiresonance(o) => {
                let pairs = run(py, || o.pairs(&x, &mut o.workspace()))?;
                let hz = pairs.into_iter().map(|p| p.partner_hz.unwrap_or(f64::NAN));
                return Ok((hz.collect::<Vec<_>>().into_pyarray(py), None));
            }
        };
        let mut ws = objective.workspace();
        let pairs = run(py, || objective.pairs(&x, &mut ws))?;
        let of = |what: fn(Partner) -> f64| -> Vec<f64> {
            pairs.iter().map(|p| p.map_or(f64::NAN, what)).collect()
        };
        let shape = (pairs.len(), objective.unknowns.model.n_dof());
        let shapes = Array2::from_shape_fn(shape, |(m, dof)| pairs[m].map_or(f64::NAN, |p| ws.shape(p)[dof]));
        let (hz, mac) = (of(|p| hertz(p.lambda)), of(|p| p.mac));
        let mac_and_shapes = (mac.into_pyarray(py), shapes.into_pyarray(py));
        Ok((hz.into_pyarray(py), Some(mac_and_shapes)))
    }

    /// J and the pairs of antiresonances at x (n,), of one solution.
    fn cost_and_pairs<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<(f64, Bound<'py, PyArray1<f64>>)> {
        let mut x = x.as_array().to_vec();
        let o = self.of_antiresonances()?;
        o.repair(&mut x);
        let pairs = run(py, || o.pairs(&x, &mut o.workspace()))?;
        let hz = pairs.iter().map(|p| p.partner_hz.unwrap_or(f64::NAN));
        let hz: Vec<f64> = hz.collect();
        Ok((o.cost_of(&x, &pairs), hz.into_pyarray(py)))
    }

    /// Residuals e of measured antiresonances at x (n,), (m,); none of modes, whose pairs tell them.
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let x = x.as_array().to_vec();
        let Core::Antiresonance(o) = &self.core else {
            return Ok(None);
        };
        let pairs = run(py, || o.pairs(&x, &mut o.workspace()))?;
        let e: Vec<f64> = pairs.into_iter().map(|p| p.residual).collect();
        Ok(Some(e.into_pyarray(py)))
    }

    /// J, residuals (m,) and their slopes (m, n) at x (n,), weighted; none where they cannot be had.
    fn linearized<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Option<PyLinearized<'py>>> {
        let x = x.as_array().to_vec();
        let found = run(py, || Ok::<_, Error>(with!(&self.core, o => o.linearize(&x, &mut o.workspace()))))?;
        found
            .map(|at| {
                let shape = [at.residuals.len(), x.len()];
                let slopes = at.jacobian.into_pyarray(py).reshape(shape)?;
                Ok((at.cost, at.residuals.into_pyarray(py), slopes))
            })
            .transpose()
    }

    /// See [`root_states`].
    #[pyo3(signature = (candidates, with_slopes, threads, from_hz=0.0, to_hz=f64::INFINITY))]
    fn states<'py>(
        &self,
        py: Python<'py>,
        candidates: PyReadonlyArray2<'_, f64>,
        with_slopes: bool,
        threads: usize,
        from_hz: f64,
        to_hz: f64,
    ) -> PyResult<Vec<PyState<'py>>> {
        let objective = self.of_antiresonances()?;
        let band = with_slopes.then_some(from_hz..=to_hz);
        root_states(py, objective, &candidates, band.as_ref(), threads)
    }

    /// Roots at x (n,) as of `states`, with the null vectors of those between two limits.
    fn null_vectors<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'_, f64>,
        from_hz: f64,
        to_hz: f64,
    ) -> PyResult<PyNullVectors<'py>> {
        let objective = self.of_antiresonances()?;
        let (x, n) = (x.as_array().to_vec(), objective.unknowns.model.n_dof());
        let found = run(py, || {
            let band = from_hz..=to_hz;
            Ok::<_, Error>(objective.null_vectors(&x, &mut objective.workspace(), &band))
        })?;
        null_vectors_to_python(py, found, n)
    }

    /// See [`mode_states`].
    fn modal_states<'py>(
        &self,
        py: Python<'py>,
        candidates: PyReadonlyArray2<'_, f64>,
        with_slopes: bool,
        threads: usize,
    ) -> PyResult<Vec<PyModalState<'py>>> {
        let Core::Modal(objective) = &self.core else {
            return Err(to_python(
                Error::input("objective", "one of antiresonances", "one of modes")
                    .remedy("Ask for its states."),
            ));
        };
        mode_states(py, objective, &candidates, with_slopes, threads)
    }

    /// J of each row of (m, n), (m,).
    fn evaluate_many<'py>(
        &self,
        py: Python<'py>,
        candidates: PyReadonlyArray2<'_, f64>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let cost = with!(&self.core, o => evaluated(py, o, &candidates, threads, CoreObjective::cost))?;
        Ok(cost.into_pyarray(py))
    }

    /// Searches the box for the least J; a polish begins at `start`, else at the nominal values.
    #[pyo3(signature = (lower, upper, guesses, options, seed, threads, max_seconds, on_progress, checkpoint, start=None))]
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
        checkpoint: Option<Bound<'py, PyAny>>,
        start: Option<Vec<f64>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut search = Search::new(&lower, &upper, guesses, options, seed, max_seconds, on_progress)?
            .kept_in(checkpoint)?;
        let outcome = guarded(py, || {
            with!(&self.core, o => {
                let evaluator = ObjectiveEvaluator::new(o, threads).map_err(to_python)?;
                search.run(&mut evaluator.starting_at(start))
            })
        })?;
        outcome_to_python(py, &outcome)
    }
}

impl Objective {
    fn of_antiresonances(&self) -> PyResult<&AntiresonanceObjective> {
        match &self.core {
            Core::Antiresonance(objective) => Ok(objective),
            Core::Modal(_) => Err(to_python(
                Error::input("objective", "one of modes", "one of antiresonances")
                    .remedy("Modes have no antiresonances."),
            )),
        }
    }
}

fn target_of(parts: TargetParts<'_>) -> Result<Target, Error> {
    let (responses, forces, freq, sees, together) = parts;
    let sees = match sees.as_deref() {
        None => Sees::Unknown,
        Some("frf") => Sees::Frf,
        Some("transmissibility") => Sees::Transmissibility,
        Some(name) => {
            let wanted = "'frf', 'transmissibility' or None";
            return Err(Error::input("sees", format!("'{name}'"), wanted)
                .remedy("Leave it out where it is not known."));
        }
    };
    let ends = Ends::new(&responses, &forces)?;
    Ok(Target { ends, freq_hz: freq.as_array().to_vec(), sees, together })
}

fn misfit_of(name: &str) -> Result<Misfit, Error> {
    match name {
        "absolute" => Ok(Misfit::Absolute),
        "squared" => Ok(Misfit::Squared),
        "largest" => Ok(Misfit::Largest),
        _ => {
            let wanted = "'absolute', 'squared' or 'largest'";
            Err(Error::input("misfit", format!("'{name}'"), wanted).remedy("Leave it out for 'absolute'."))
        }
    }
}

fn penalty_of(weights: Option<(f64, f64)>) -> Option<Penalty> {
    weights.map(|(gamma1, gamma2)| Penalty { gamma1, gamma2 })
}
