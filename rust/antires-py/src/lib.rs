//! `antires_rs._core`: the doorway between Python and antires-core.
//!
//! Every function here extracts its arguments, detaches from the interpreter, calls the core and
//! converts the result. The Python package above it owns names, defaults and documentation.

// PyO3 extracts arguments by value: that is its calling convention.
#![allow(clippy::needless_pass_by_value)]

use pyo3::prelude::*;

mod alignment;
mod checkpoint;
mod convert;
mod doorway;
mod frame;
mod model;
mod objective;
mod optimizer;
mod options;
mod parameters;
mod prepared;
mod rational;
mod states;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<frame::Frame>()?;
    module.add_class::<objective::Objective>()?;
    module.add_class::<prepared::PreparedTables>()?;
    module.add_class::<prepared::PreparedTest>()?;
    module.add_function(wrap_pyfunction!(alignment::align, module)?)?;
    module.add_function(wrap_pyfunction!(alignment::associate, module)?)?;
    module.add_function(wrap_pyfunction!(alignment::follow, module)?)?;
    module.add_function(wrap_pyfunction!(parameters::nominal_values, module)?)?;
    module.add_function(wrap_pyfunction!(parameters::check_bounds, module)?)?;
    module.add_function(wrap_pyfunction!(optimizer::minimize, module)?)?;
    module.add_function(wrap_pyfunction!(options::island_options, module)?)?;
    module.add_function(wrap_pyfunction!(rational::forsythe_basis_at, module)?)?;
    module.add_function(wrap_pyfunction!(rational::refined_roots, module)?)?;
    module.add_function(wrap_pyfunction!(rational::dominant_pairs, module)?)?;
    module.add_function(wrap_pyfunction!(rational::hermitian_values, module)?)?;
    Ok(())
}
