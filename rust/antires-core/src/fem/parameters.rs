//! Updating parameters: how a value p scales the terms it governs.
//!
//! ```text
//! stiffness reduction   s = 1 − β      0 <= β <= 1   (damage)
//! stiffness factor      s = p          p > 0
//! mass factor           s = p          p > 0
//! ```
//!
//! Several parameters on one term multiply. A [`Property`] or an [`Angle`] of a frame acts on what the
//! terms are formed from, see [`frame`](super::frame); all kinds mix.

use faer::Mat;

use super::frame::dofs::Dimension;
use super::frame::{Angle, Property, Reform, Scale};
use super::model::Model;
use crate::error::{Argument, Error, Result};

/// What a parameter value means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Stiffness loss β of the terms: s = 1 − β.
    StiffnessReduction,
    /// Factor on the stiffness of the terms.
    StiffnessFactor,
    /// Factor on the mass of the terms.
    MassFactor,
    /// A property of sections, lumped masses or supports of a frame.
    Property(Property, Scale),
    /// Angle (degrees) of what lies downstream of a node of a frame.
    Angle(Angle),
}

/// One scalar unknown and the terms it governs.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// What the value means.
    pub quantity: Quantity,
    /// Indices of the stiffness (or mass) terms; of the sections, lumped masses or springs of a
    /// [`Property`]; of the nodes that turn by an [`Angle`].
    pub terms: Vec<usize>,
}

impl Parameter {
    /// Checks that the parameter, called `name`, governs something of the model.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a term outside the model, a parameter that changes nothing, or a
    /// frame's parameter on a model that is not one.
    pub fn check(&self, name: &Argument, model: &Model) -> Result<()> {
        let (terms, kind) = match self.quantity {
            Quantity::MassFactor => (model.mass_terms(), "mass"),
            Quantity::StiffnessReduction | Quantity::StiffnessFactor => {
                (model.stiffness_terms(), "stiffness")
            }
            Quantity::Property(property, scale) => {
                return needs_frame(name, model)?.check_property(
                    name,
                    property,
                    scale,
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
                let nodes = parts.nodes_m.len();
                if let Some(node) = self.terms.iter().find(|&&node| node >= nodes) {
                    let wanted = format!("nodes below {nodes}");
                    return Err(Error::input(name, format!("node {node}"), wanted)
                        .remedy("Nodes are counted from 0, in the order of nodes_m."));
                }
                return Ok(());
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

    /// Value at which the model is as it was given; none where one value stands for different ones.
    #[must_use]
    pub fn nominal(&self, model: &Model) -> Option<f64> {
        match self.quantity {
            Quantity::StiffnessReduction | Quantity::Angle(_) => Some(0.0),
            Quantity::StiffnessFactor
            | Quantity::MassFactor
            | Quantity::Property(_, Scale::Factor) => Some(1.0),
            Quantity::Property(property, Scale::Value) => {
                model.frame()?.nominal(property, &self.terms)
            }
        }
    }
}

fn needs_frame<'a>(name: &Argument, model: &'a Model) -> Result<&'a super::frame::Frame> {
    model.frame().ok_or_else(|| {
        Error::input(
            name,
            "a parameter of a frame for a model that is none",
            "stiffness reductions, stiffness factors or mass factors",
        )
        .remedy("Build a FrameModel to change sections, masses, supports or angles.")
    })
}

/// K and M at a parameter vector, with the memory to form them again.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// K(p) (N/m).
    pub stiffness: Mat<f64>,
    /// M(p) (kg).
    pub mass: Mat<f64>,
    stiffness_factors: Vec<f64>,
    mass_factors: Vec<f64>,
    reform: Option<Reform>,
}

impl Assembly {
    /// Assembly of the nominal state.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self {
            stiffness: model.stiffness().to_owned(),
            mass: model.mass().to_owned(),
            stiffness_factors: vec![1.0; model.stiffness_terms().len()],
            mass_factors: vec![1.0; model.mass_terms().len()],
            reform: model
                .frame()
                .map(|frame| Reform::new(frame, model.stiffness_terms(), model.mass_terms())),
        }
    }

    /// Forms K(x) and M(x).
    pub fn form(&mut self, model: &Model, parameters: &[Parameter], x: &[f64]) {
        self.stiffness_factors.fill(1.0);
        self.mass_factors.fill(1.0);
        for (parameter, &value) in parameters.iter().zip(x) {
            let (factors, factor) = match parameter.quantity {
                Quantity::StiffnessReduction => (&mut self.stiffness_factors, 1.0 - value),
                Quantity::StiffnessFactor => (&mut self.stiffness_factors, value),
                Quantity::MassFactor => (&mut self.mass_factors, value),
                Quantity::Property(..) | Quantity::Angle(_) => continue,
            };
            for &term in &parameter.terms {
                factors[term] *= factor;
            }
        }
        if let (Some(reform), Some(frame)) = (&mut self.reform, model.frame()) {
            reform.form(
                frame,
                parameters,
                x,
                (
                    model.stiffness_terms(),
                    &self.stiffness_factors,
                    &mut self.stiffness,
                ),
                (model.mass_terms(), &self.mass_factors, &mut self.mass),
            );
            return;
        }
        self.stiffness.copy_from(model.stiffness());
        for (term, &s) in model.stiffness_terms().iter().zip(&self.stiffness_factors) {
            if s != 1.0 {
                term.add_to(&mut self.stiffness, s - 1.0);
            }
        }
        self.mass.copy_from(model.mass());
        for (term, &s) in model.mass_terms().iter().zip(&self.mass_factors) {
            if s != 1.0 {
                term.add_to(&mut self.mass, s - 1.0);
            }
        }
    }

    /// Factors s_i of the stiffness terms at the last [`form`](Self::form).
    #[must_use]
    pub fn stiffness_factors(&self) -> &[f64] {
        &self.stiffness_factors
    }

    /// Factors s_i of the mass terms at the last [`form`](Self::form).
    #[must_use]
    pub fn mass_factors(&self) -> &[f64] {
        &self.mass_factors
    }
}
