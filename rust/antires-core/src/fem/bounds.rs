//! Whether a model stays a structure all over the box of its parameters.
//!
//! K(p) grows with every stiffness and falls with every reduction, M(p) with every mass. So the corner
//! where all are at their softest and lightest has the smallest eigenvalues of the box, as long as the
//! terms are positive semi-definite themselves: if K and M are semi-definite there, they are everywhere.

use super::frame::Property;
use super::model::Model;
use super::parameters::{Parameter, Quantity};
use crate::error::{Error, Result};
use crate::linalg::factors::is_semidefinite;

/// Checks `lower` and `upper` of `parameters`.
///
/// # Errors
/// [`Error::InvalidInput`] when the wall of a tube can become thicker than its radius, when a
/// node can come onto its neighbour, or when K or M
/// becomes indefinite inside the bounds.
pub fn check_bounds(
    model: &Model,
    parameters: &[Parameter],
    lower: &[f64],
    upper: &[f64],
) -> Result<()> {
    let corner = |pick: &dyn Fn(&Parameter, f64, f64) -> f64| -> Vec<f64> {
        parameters
            .iter()
            .zip(lower.iter().zip(upper))
            .map(|(parameter, (&low, &high))| pick(parameter, low, high))
            .collect()
    };
    let softest = corner(&|parameter, low, high| match parameter.quantity {
        Quantity::StiffnessReduction => high,
        Quantity::Angle(_) | Quantity::Position(_) => 0.0_f64.clamp(low, high),
        Quantity::Length(_) => 1.0_f64.clamp(low, high),
        _ => low,
    });
    // The thickest wall in the narrowest tube.
    let thickest = corner(&|parameter, low, high| match parameter.quantity {
        Quantity::StiffnessReduction | Quantity::Property(Property::Diameter, _) => low,
        Quantity::Position(_) => 0.0_f64.clamp(low, high),
        _ => high,
    });
    model.at(parameters, &thickest).map_err(in_bounds)?;
    for (i, parameter) in parameters.iter().enumerate() {
        if let (Quantity::Position(direction), Some(frame)) = (&parameter.quantity, model.frame()) {
            frame
                .check_way(*direction, &parameter.terms, lower[i], upper[i])
                .map_err(in_bounds)?;
        }
    }
    let soft = model.at(parameters, &softest).map_err(in_bounds)?;
    for (matrix, whole, name) in [
        (soft.stiffness(), model.stiffness(), "stiffness"),
        (soft.mass(), model.mass(), "mass"),
    ] {
        if !is_semidefinite(matrix, whole) {
            return Err(Error::input(
                "bounds",
                format!("an indefinite {name} with all parameters at their softest and lightest"),
                format!("bounds within which the {name} keeps all eigenvalues at or above zero"),
            )
            .remedy("Narrow the bounds, or check that the terms are contained in the matrix."));
        }
    }
    Ok(())
}

/// The same error, said of the bounds.
fn in_bounds(error: Error) -> Error {
    match error {
        Error::InvalidInput {
            argument,
            got,
            wanted,
            ..
        } => Error::input(
            "bounds",
            format!("values that allow {argument}: {got}"),
            wanted,
        )
        .remedy("Narrow the bounds."),
        other => other,
    }
}
