//! Parameters as Python gives them.

use antires_core::error::{Argument, Error, Result};
use antires_core::fem::checks::check_bounds as check_core_bounds;
use antires_core::fem::frame::{Angle, Frame as CoreFrame, Property, Scale};
use antires_core::fem::model::Model as CoreModel;
use antires_core::fem::parameters::{Parameter, Quantity};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::doorway::{run, to_python};
use crate::model::Model;

/// (quantity, terms, relative, node and vector of what moves nodes). That is pivot and axis of an angle; the
/// pivot of a length, and no vector; no node (0), and the direction of a position.
pub type ParameterParts = (String, Vec<usize>, bool, Option<(usize, [f64; 3])>);

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
    let (quantity, terms, relative, moves) = parts;
    let scale = if relative { Scale::Factor } else { Scale::Value };
    let quantity = match (quantity.as_str(), moves) {
        ("stiffness_reduction", None) => Quantity::StiffnessReduction,
        ("stiffness_factor", None) => Quantity::StiffnessFactor,
        ("mass_factor", None) => Quantity::MassFactor,
        ("youngs_modulus", None) => Quantity::Property(Property::YoungsModulus, scale),
        ("density", None) => Quantity::Property(Property::Density, scale),
        ("thickness", None) => Quantity::Property(Property::Thickness, scale),
        ("diameter", None) => Quantity::Property(Property::Diameter, scale),
        ("point_mass", None) => Quantity::Property(Property::Mass, scale),
        ("inertia", None) => Quantity::Property(Property::Inertia, scale),
        ("support_stiffness", None) => Quantity::Property(Property::SupportStiffness, scale),
        ("angle", Some((pivot, axis))) => {
            return Ok(Parameter {
                quantity: Quantity::Angle(Angle { pivot, axis }),
                terms: frame_of(name, model)?.downstream(&terms, pivot)?,
            });
        }
        ("length", Some((pivot, _))) => {
            let way = frame_of(name, model)?.reach(&terms, pivot)?;
            return Ok(Parameter {
                terms: way.iter().map(|step| step.node).collect(),
                quantity: Quantity::Length(way),
            });
        }
        ("position", Some((_, direction))) => Quantity::Position(direction),
        (quantity, _) => {
            let got = format!("'{quantity}'");
            return Err(Error::input("quantity", got, "a known parameter quantity")
                .remedy("Make parameters by stiffness_factor, thickness and the like."));
        }
    };
    Ok(Parameter { quantity, terms })
}

fn frame_of<'a>(name: &Argument, model: &'a CoreModel) -> Result<&'a CoreFrame> {
    model.frame().ok_or_else(|| {
        let got = "an angle or a length for a model that is no frame";
        Error::input(name, got, "a FrameModel")
            .remedy("Only the elements of a FrameModel have angles and lengths.")
    })
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
