//! Models: matrices, modes, frequency responses, antiresonances.

use std::sync::OnceLock;

use antires_core::antiresonances::{
    Antiresonances, Ends, Query, Route, antiresonances, bounded_antiresonances,
};
use antires_core::error::Error;
use antires_core::fem::model::{Model as CoreModel, mass_spring_chain};
use antires_core::modal::modes::{AllModes, Motion, frequency_response, low_modes};
use numpy::ndarray::Array2;
use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::convert::{ColumnArrays, PyTerm, TermArrays, array, columns, entries, terms, terms_to_python};
use crate::doorway::{run, to_python};
use crate::frame::Frame;
use crate::parameters::{ParameterParts, core_parameters};

/// Most dofs of which dense matrices tell the modes that sparse factors leave open.
const MOST_DENSE_DOFS: usize = 8000;

/// Antiresonances (m,) in Hz, bounds of their errors, whether H is identically zero, and whether there is a doubt.
type PyRoots<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, bool, bool);
type PyModes<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// A structural model of the core.
#[pyclass(frozen, module = "antires_rs._core")]
pub struct Model {
    pub core: CoreModel,
    /// The dense solution, made when first asked for: the matrices never change.
    all: OnceLock<AllModes>,
}

impl From<CoreModel> for Model {
    fn from(core: CoreModel) -> Self {
        let all = OnceLock::new();
        Self { core, all }
    }
}

impl Model {
    fn all_modes(&self) -> Result<&AllModes, Error> {
        if let Some(all) = self.all.get() {
            return Ok(all);
        }
        let solved = AllModes::of(&self.core)?;
        Ok(self.all.get_or_init(|| solved))
    }
}

#[pymethods]
impl Model {
    /// Masses in a row with springs between them and to ground.
    #[staticmethod]
    fn chain(
        masses_kg: PyReadonlyArray1<'_, f64>,
        springs_n_per_m: PyReadonlyArray1<'_, f64>,
        ground_first_n_per_m: f64,
        ground_last_n_per_m: f64,
    ) -> PyResult<Self> {
        let core = mass_spring_chain(
            &masses_kg.as_array().to_vec(),
            &springs_n_per_m.as_array().to_vec(),
            ground_first_n_per_m,
            ground_last_n_per_m,
        )
        .map_err(to_python)?;
        Ok(core.into())
    }

    /// Entries of the nominal (n, n) matrices, both triangles, and the terms they contain.
    #[staticmethod]
    fn from_matrices(
        py: Python<'_>,
        n_dof: usize,
        stiffness: TermArrays<'_>,
        mass: TermArrays<'_>,
        stiffness_terms: Vec<TermArrays<'_>>,
        mass_terms: Vec<TermArrays<'_>>,
    ) -> PyResult<Self> {
        let (stiffness, mass) = (entries(&stiffness), entries(&mass));
        let (stiffness_terms, mass_terms) = (terms(&stiffness_terms), terms(&mass_terms));
        let core =
            run(py, || CoreModel::from_entries(n_dof, (&stiffness, &mass), stiffness_terms, mass_terms))?;
        Ok(core.into())
    }

    /// Beams, masses and springs.
    #[staticmethod]
    fn from_frame(py: Python<'_>, frame: &Frame) -> PyResult<Self> {
        let core = run(py, || CoreModel::from_frame(frame.core.clone()))?;
        Ok(core.into())
    }

    /// The model at parameter values x (n,), parameters as in `parameters.rs`.
    fn at(
        &self,
        py: Python<'_>,
        parameters: Vec<ParameterParts>,
        x: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Self> {
        let x = x.as_array().to_vec();
        let core = run(py, || {
            let parameters = core_parameters(&self.core, parameters)?;
            self.core.at(&parameters, &x)
        })?;
        Ok(core.into())
    }

    /// The frame it was made from, if it was.
    fn frame(&self) -> Option<Frame> {
        self.core.frame().map(|frame| Frame { core: frame.clone() })
    }

    #[getter]
    fn n_dof(&self) -> usize {
        self.core.n_dof()
    }

    #[getter]
    fn n_stiffness_terms(&self) -> usize {
        self.core.stiffness_terms().len()
    }

    #[getter]
    fn n_mass_terms(&self) -> usize {
        self.core.mass_terms().len()
    }

    /// Rows, columns and values of each stiffness term, both triangles.
    fn stiffness_terms<'py>(&self, py: Python<'py>) -> Vec<PyTerm<'py>> {
        terms_to_python(py, self.core.stiffness_terms())
    }

    /// The same of each mass term.
    fn mass_terms<'py>(&self, py: Python<'py>) -> Vec<PyTerm<'py>> {
        terms_to_python(py, self.core.mass_terms())
    }

    /// K (n, n) without its zeros, by columns: starts (n + 1,), rows and values.
    fn stiffness<'py>(&self, py: Python<'py>) -> ColumnArrays<'py> {
        columns(py, self.core.stiffness())
    }

    /// M (n, n) likewise.
    fn mass<'py>(&self, py: Python<'py>) -> ColumnArrays<'py> {
        columns(py, self.core.mass())
    }

    /// Frequencies (m,) and mass-normalised shapes (n, m) of all modes; up to a limit or a number they may come
    /// from the band, which then holds no more than those.
    #[pyo3(signature = (f_max_hz=None, n_modes=None))]
    fn modes<'py>(
        &self,
        py: Python<'py>,
        f_max_hz: Option<f64>,
        n_modes: Option<usize>,
    ) -> PyResult<PyModes<'py>> {
        let solved = run(py, || {
            let limited = f_max_hz.is_some() || n_modes.is_some();
            let low = if limited {
                low_modes(&self.core, f_max_hz.unwrap_or(f64::INFINITY), n_modes)?
            } else {
                None
            };
            match low {
                Some(low) if !low.freq_hz.is_empty() => Ok(low),
                None if limited && self.core.n_dof() > MOST_DENSE_DOFS => Err(Error::Numerical {
                    what: format!("modes of {} dofs up to a limit", self.core.n_dof()),
                    detail:
                        "the factors of K + sigma M leave open how many there are (an indefinite stiffness, \
                             or a motion that nothing holds), and dense matrices of so many dofs would take \
                             minutes and gigabytes. Check the signs of the stiffness, or change the limit."
                            .into(),
                }),
                _ => Ok(self.all_modes()?.finite()),
            }
        })?;
        Ok((solved.freq_hz.into_pyarray(py), array(py, solved.shapes.as_ref())))
    }

    /// Number of finite modes.
    fn n_modes(&self, py: Python<'_>) -> PyResult<usize> {
        run(py, || Ok(self.all_modes()?.lambda.len()))
    }

    /// Frequency responses (n_responses, n_freq).
    fn frf<'py>(
        &self,
        py: Python<'py>,
        responses: Vec<usize>,
        excitation: usize,
        freq_hz: PyReadonlyArray1<'_, f64>,
        damping_ratio: PyReadonlyArray1<'_, f64>,
        kind: &str,
    ) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let motion = match kind {
            "receptance" => Motion::Receptance,
            "mobility" => Motion::Mobility,
            "accelerance" => Motion::Accelerance,
            _ => {
                let wanted = "'receptance', 'mobility' or 'accelerance'";
                return Err(to_python(
                    Error::input("kind", format!("'{kind}'"), wanted)
                        .remedy("Leave it out for 'accelerance'."),
                ));
            }
        };
        let (freq, damping) = (freq_hz.as_array().to_vec(), damping_ratio.as_array().to_vec());
        let values = run(py, || {
            for &dof in &responses {
                self.core.check_dof("response", dof)?;
            }
            self.core.check_dof("excitation", excitation)?;
            let modes = self.all_modes()?;
            Ok(frequency_response(modes, &responses, excitation, &freq, &damping, motion))
        })?;
        let columns = freq.len();
        Ok(Array2::from_shape_fn((responses.len(), columns), |(i, j)| {
            let (re, im) = values[i * columns + j];
            Complex64::new(re, im)
        })
        .into_pyarray(py))
    }

    /// For each response, or set of as many responses as forces: antiresonances (m,) in Hz; bounds (m,) of their errors,
    /// infinite for one that is not certain, if those are asked for; whether H is identically zero, and whether their
    /// number is in doubt.
    #[allow(clippy::too_many_arguments)]
    fn antiresonances<'py>(
        &self,
        py: Python<'py>,
        responses: Vec<Vec<usize>>,
        excitation: Vec<usize>,
        f_max_hz: f64,
        method: &str,
        include_cancelled: bool,
        bounded: bool,
    ) -> PyResult<Vec<PyRoots<'py>>> {
        let query = query(f_max_hz, method, include_cancelled)?;
        let find = if bounded { bounded_antiresonances } else { antiresonances };
        let found = run(py, || {
            let ends =
                responses.iter().map(|dofs| Ends::new(dofs, &excitation)).collect::<Result<Vec<_>, _>>()?;
            find(&self.core, &ends, &query)
        })?;
        let roots = |a: Antiresonances| {
            (a.freq_hz.into_pyarray(py), a.error_hz.into_pyarray(py), a.identically_zero, a.doubtful)
        };
        Ok(found.into_iter().map(roots).collect())
    }
}

fn query(f_max_hz: f64, method: &str, include_cancelled: bool) -> PyResult<Query> {
    let route = match method {
        "modal" => Route::Modal,
        "pencil" => Route::Pencil,
        _ => {
            return Err(to_python(
                Error::input("method", format!("'{method}'"), "'modal' or 'pencil'")
                    .remedy("Leave it out for 'modal', the quicker of the two."),
            ));
        }
    };
    Ok(Query { route, f_max_hz, include_cancelled })
}
