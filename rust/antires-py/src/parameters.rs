//! Parameters as Python gives them.

use antires_core::error::{Argument, Error, Result};
use antires_core::fem::checks::{check_bounds as check_core_bounds, needs_frame};
use antires_core::fem::frame::{Angle, Property, Scale};
use antires_core::fem::model::Model as CoreModel;
use antires_core::fem::parameters::{Parameter, Quantity};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::doorway::{run, to_python};
use crate::model::Model;

/// Quantity, terms, relative, and what more it has.
pub type ParameterParts = (String, Vec<usize>, bool, Option<More>);

/// What moves nodes or has powers.
#[derive(FromPyObject)]
pub enum More {
    /// Pivot and axis of an angle; pivot of a length, and no vector; no node (0), and direction of a position.
    Moves(usize, [f64; 3]),
    /// Nominal value of a group; whether each term is of the mass, and its power.
    Powers(f64, Vec<(bool, i32)>),
}

/// Core parameters, checked against the model.
pub fn core_parameters(model: &CoreModel, parts: Vec<ParameterParts>) -> Result<Vec<Parameter>> {
    parts
        .into_iter()
        .enumerate()
        .map(|(i, parts)| {
            let name = Argument::from("parameters").item(i);
            let parameter = parameter(&name, model, parts)?;
            parameter.check(&name, model)?;
            Ok(parameter)
        })
        .collect()
}

fn parameter(name: &Argument, model: &CoreModel, parts: ParameterParts) -> Result<Parameter> {
    let (quantity, terms, relative, more) = parts;
    let scale = if relative { Scale::Factor } else { Scale::Value };
    let quantity = match (quantity.as_str(), more) {
        ("stiffness_reduction", None) => Quantity::StiffnessReduction,
        ("stiffness_factor", None) => Quantity::StiffnessFactor,
        ("mass_factor", None) => Quantity::MassFactor,
        ("group_value", Some(More::Powers(nominal, of))) if of.len() == terms.len() => {
            Quantity::GroupValue(nominal, of)
        }
        ("youngs_modulus", None) => Quantity::Property(Property::YoungsModulus, scale),
        ("density", None) => Quantity::Property(Property::Density, scale),
        ("thickness", None) => Quantity::Property(Property::Thickness, scale),
        ("diameter", None) => Quantity::Property(Property::Diameter, scale),
        ("point_mass", None) => Quantity::Property(Property::Mass, scale),
        ("inertia", None) => Quantity::Property(Property::Inertia, scale),
        ("support_stiffness", None) => Quantity::Property(Property::SupportStiffness, scale),
        ("angle", Some(More::Moves(pivot, axis))) => {
            return Ok(Parameter {
                quantity: Quantity::Angle(Angle { pivot, axis }),
                terms: needs_frame(name, model)?.downstream(&terms, pivot)?,
            });
        }
        ("length", Some(More::Moves(pivot, _))) => {
            let way = needs_frame(name, model)?.reach(&terms, pivot)?;
            return Ok(Parameter {
                terms: way.iter().map(|step| step.node).collect(),
                quantity: Quantity::Length(way),
            });
        }
        ("position", Some(More::Moves(_, direction))) => Quantity::Position(direction),
        (quantity, _) => {
            let got = format!("'{quantity}'");
            return Err(Error::input("quantity", got, "a known parameter quantity")
                .remedy("Make parameters by stiffness_factor, thickness and the like."));
        }
    };
    Ok(Parameter { quantity, terms })
}

/// Nominal value of each parameter (n,), NaN where one value stands for different ones.
#[pyfunction]
pub fn nominal_values<'py>(
    py: Python<'py>,
    model: &Model,
    parameters: Vec<ParameterParts>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let parameters = core_parameters(&model.core, parameters).map_err(to_python)?;
    let nominal: Vec<f64> = parameters.iter().map(|p| p.nominal(&model.core).unwrap_or(f64::NAN)).collect();
    Ok(nominal.into_pyarray(py))
}

/// Refuses bounds (n,) within which the model is no structure.
#[pyfunction]
pub fn check_bounds(
    py: Python<'_>,
    model: &Model,
    parameters: Vec<ParameterParts>,
    lower: PyReadonlyArray1<'_, f64>,
    upper: PyReadonlyArray1<'_, f64>,
) -> PyResult<()> {
    let (lower, upper) = (lower.as_array().to_vec(), upper.as_array().to_vec());
    run(py, || {
        let parameters = core_parameters(&model.core, parameters)?;
        check_core_bounds(&model.core, &parameters, &lower, &upper)
    })
}
