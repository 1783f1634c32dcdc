//! Whether a parameter governs something of a model, and the value at which it changes nothing.

use super::frame::Frame;
use super::frame::dofs::Dimension;
use super::frame::property::Scale;
use super::model::Model;
use super::parameters::{Parameter, Quantity};
use crate::error::{Argument, Error, Result};

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
            Quantity::Property(property, scale) => {
                return needs_frame(name, model)?.check_property(
                    name,
                    *property,
                    *scale,
                    &self.terms,
                );
            }
            Quantity::Angle(angle) => {
                let parts = needs_frame(name, model)?.description();
                if parts.dimension == Dimension::Plane && angle.axis[..2] != [0.0; 2] {
                    let got = format!("a turn about the axis {:?}", angle.axis);
                    let wanted = "the axis (0, 0, 1): a plane frame turns in its plane";
                    return Err(Error::input(name, got, wanted)
                        .remedy("Leave the axis out for a plane frame."));
                }
                return self.check_nodes(name, parts.nodes_m.len());
            }
            Quantity::Position(direction) => {
                let parts = needs_frame(name, model)?.description();
                if parts.dimension == Dimension::Plane && direction[2] != 0.0 {
                    let got = format!("a shift along {direction:?}");
                    return Err(Error::input(name, got, "a direction in the plane x-y")
                        .remedy("The nodes of a plane frame stay in its plane."));
                }
                return self.check_nodes(name, parts.nodes_m.len());
            }
            Quantity::Length(_) => {
                let parts = needs_frame(name, model)?.description();
                return self.check_nodes(name, parts.nodes_m.len());
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
                format!(
                    "{kind} term(s) {:?}, which are zero in this model",
                    self.terms
                ),
                "a parameter that changes the model",
            )
            .remedy("Give the spring or mass a nominal value, or leave the parameter out."));
        }
        Ok(())
    }

    fn check_nodes(&self, name: &Argument, n_nodes: usize) -> Result<()> {
        let Some(node) = self.terms.iter().find(|&&node| node >= n_nodes) else {
            return Ok(());
        };
        let wanted = format!("nodes below {n_nodes}");
        Err(Error::input(name, format!("node {node}"), wanted)
            .remedy("Nodes are counted from 0, in the order of nodes_m."))
    }

    /// Value at which the model is as it was given; none where one value stands for different ones.
    #[must_use]
    pub fn nominal(&self, model: &Model) -> Option<f64> {
        match self.quantity {
            Quantity::StiffnessReduction | Quantity::Angle(_) | Quantity::Position(_) => Some(0.0),
            Quantity::StiffnessFactor
            | Quantity::MassFactor
            | Quantity::Length(_)
            | Quantity::Property(_, Scale::Factor) => Some(1.0),
            Quantity::Property(property, Scale::Value) => {
                model.frame()?.nominal(property, &self.terms)
            }
        }
    }
}

fn needs_frame<'a>(name: &Argument, model: &'a Model) -> Result<&'a Frame> {
    model.frame().ok_or_else(|| {
        Error::input(
            name,
            "a parameter of a frame for a model that is none",
            "stiffness reductions, stiffness factors or mass factors",
        )
        .remedy("Build a FrameModel to change sections, masses, supports, angles, positions or lengths.")
    })
}
