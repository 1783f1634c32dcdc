//! The options of the island search as a dictionary.

use antires_core::error::Error;
use antires_core::optimize::{Agreement, Crossover, IslandOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::doorway::to_python;

/// Hands the plain fields of [`IslandOptions`] to another macro: their list stands here once.
macro_rules! each_plain {
    ($each:ident) => {
        $each!(islands, population, crossover_probability, mutation_probability);
        $each!(selection_pressure, patience, improvement_tolerance, gene_tolerance, cost_tolerance);
        $each!(cost_floor, cost_migrations, polish, polish_interval, polish_evaluations);
        $each!(max_evaluations, max_generations);
    };
}

/// The options that a dictionary names, with defaults for the others.
pub fn read_options(dict: &Bound<'_, PyDict>) -> PyResult<IslandOptions> {
    let mut options = IslandOptions::default();
    macro_rules! read {
        ($($field:ident),+) => {
            $(if let Some(value) = dict.get_item(stringify!($field))? {
                options.$field = value.extract()?;
            })+
        };
    }
    each_plain!(read);
    if let Some(value) = dict.get_item("agreement")? {
        options.agreement = Agreement::from_name(&value.extract::<String>()?).map_err(to_python)?;
    }
    if let Some(value) = dict.get_item("crossovers")? {
        options.crossovers = value
            .extract::<Vec<String>>()?
            .iter()
            .map(|name| Crossover::from_name(name))
            .collect::<Result<_, Error>>()
            .map_err(to_python)?;
    }
    let known = write_options(dict.py(), &options)?;
    for key in dict.keys() {
        if !known.contains(&key)? {
            let names: Vec<String> = known.keys().extract()?;
            let error = Error::input("option", key.to_string(), format!("one of {}", names.join(", ")))
                .remedy("Correct the name, or leave the option out.");
            return Err(to_python(error));
        }
    }
    options.validate().map_err(to_python)?;
    Ok(options)
}

fn write_options<'py>(py: Python<'py>, options: &IslandOptions) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    macro_rules! write {
        ($($field:ident),+) => { $(dict.set_item(stringify!($field), options.$field)?;)+ };
    }
    each_plain!(write);
    dict.set_item("agreement", options.agreement.name())?;
    let names: Vec<&str> = options.crossovers.iter().map(Crossover::name).collect();
    dict.set_item("crossovers", names)?;
    Ok(dict)
}

/// The options with defaults filled in; refuses unknown names and values out of range.
#[pyfunction]
pub fn island_options<'py>(py: Python<'py>, options: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
    write_options(py, &read_options(options)?)
}
