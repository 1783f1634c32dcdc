//! Whether a parameter governs something of a model, and the value at which it changes nothing.
//!
//! # bounds
//!
//! Whether a model stays a structure all over the box of its parameters.
//!
//! K(p) grows with every stiffness and falls with every reduction, M(p) with every mass. So the corner
//! where all are at their softest and lightest has the smallest eigenvalues of the box, as long as the
//! terms are positive semi-definite themselves: if K and M are semi-definite there, they are everywhere.

use super::frame::elements::{Dimension, check_node};
use super::frame::{Frame, Property};
use super::model::Model;
use super::parameters::{Parameter, Quantity, Scale};
use crate::error::{Argument, Error, Result};
use crate::linalg::factors::is_semidefinite;

impl Parameter {
    /// Checks that the parameter, called `name`, governs something of the model.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a term outside the model, a parameter that changes nothing, or a
    /// frame's parameter on a model that is not one.
    pub fn check(&self, name: &Argument, model: &Model) -> Result<()> {
        let (terms, kind) = match &self.quantity {
            Quantity::MassFactor => (model.mass_terms(), "mass"),
            Quantity::StiffnessReduction | Quantity::StiffnessFactor => {
                (model.stiffness_terms(), "stiffness")
            }
            Quantity::GroupValue(..) => return Ok(()), // Python makes it of groups, whose terms are there.
            Quantity::Property(property, scale) => {
                return needs_frame(name, model)?.check_property(name, *property, *scale, &self.terms);
            }
            Quantity::Angle(_) | Quantity::Position(_) | Quantity::Length(_) => {
                let parts = needs_frame(name, model)?.description();
                let out_of_plane = match &self.quantity {
                    _ if parts.dimension == Dimension::Space => None,
                    Quantity::Angle(angle) if angle.axis[..2] != [0.0; 2] => {
                        let got = format!("a turn about the axis {:?}", angle.axis);
                        let wanted = "the axis (0, 0, 1): a plane frame turns in its plane";
                        Some(Error::input(name, got, wanted).remedy("Leave the axis out for a plane frame."))
                    }
                    Quantity::Position(direction) if direction[2] != 0.0 => {
                        let got = format!("a shift along {direction:?}");
                        let wanted = "a direction in the plane x-y";
                        let remedy = "The nodes of a plane frame stay in its plane.";
                        Some(Error::input(name, got, wanted).remedy(remedy))
                    }
                    _ => None,
                };
                if let Some(error) = out_of_plane {
                    return Err(error);
                }
                let mut nodes = self.terms.iter();
                return nodes.try_for_each(|&node| check_node(name, node, parts.nodes_m.len()));
            }
        };
        for &term in &self.terms {
            if term >= terms.len() {
                return Err(Error::input(
                    name,
                    format!("{kind} term {term}"),
                    format!("a zero-based {kind} term below {}", terms.len()),
                )
                .remedy("Terms are counted from 0, in the order of the model."));
            }
        }
        if self.terms.iter().all(|&t| terms[t].is_zero()) {
            return Err(Error::input(
                name,
                format!("{kind} term(s) {:?}, which are zero in this model", self.terms),
                "a parameter that changes the model",
            )
            .remedy("Give the spring or mass a nominal value, or leave the parameter out."));
        }
        Ok(())
    }

    /// Value at which the model is as it was given; none where one value stands for different ones.
    pub fn nominal(&self, model: &Model) -> Option<f64> {
        match self.quantity {
            Quantity::StiffnessReduction | Quantity::Angle(_) | Quantity::Position(_) => Some(0.0),
            Quantity::StiffnessFactor
            | Quantity::MassFactor
            | Quantity::Length(_)
            | Quantity::Property(_, Scale::Factor) => Some(1.0),
            Quantity::GroupValue(nominal, _) => Some(nominal),
            Quantity::Property(property, Scale::Value) => model.frame()?.nominal(property, &self.terms),
        }
    }
}

/// The frame of a model, which parameter `name` needs.
pub fn needs_frame<'a>(name: &Argument, model: &'a Model) -> Result<&'a Frame> {
    model.frame().ok_or_else(|| {
        Error::input(
            name,
            "a parameter of a frame for a model that is none",
            "stiffness reductions, stiffness factors or mass factors",
        )
        .remedy("Build a FrameModel to change sections, masses, supports, angles, positions or lengths.")
    })
}

// ---- bounds

/// Checks `lower` and `upper` of `parameters`.
///
/// # Errors
/// [`Error::InvalidInput`] when the wall of a tube can become thicker than its radius, when a node can come onto
/// its neighbour, or when K or M becomes indefinite inside the bounds.
pub fn check_bounds(model: &Model, parameters: &[Parameter], lower: &[f64], upper: &[f64]) -> Result<()> {
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
            frame.check_way(*direction, &parameter.terms, lower[i], upper[i]).map_err(in_bounds)?;
        }
    }
    let soft = model.at(parameters, &softest).map_err(in_bounds)?;
    for (matrix, whole, name) in
        [(soft.stiffness(), model.stiffness(), "stiffness"), (soft.mass(), model.mass(), "mass")]
    {
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
        Error::InvalidInput { argument, got, wanted, .. } => {
            Error::input("bounds", format!("values that allow {argument}: {got}"), wanted)
                .remedy("Narrow the bounds.")
        }
        other => other,
    }
}
