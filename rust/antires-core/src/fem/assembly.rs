//! K(p) and M(p) of a model at a parameter vector.
//!
//! ```text
//! K(p) = K + Σ_t (s_t(p) − 1) K_t        M(p) = M + Σ_t (s_t(p) − 1) M_t
//! ```
//!
//! s_t is the product of the factors of all parameters on term t. The terms of a frame are formed again where
//! their sections or coordinates change.

use std::sync::Arc;

use super::frame::reform::{Nominal, Reform};
use super::model::Model;
use super::parameters::{Parameter, Quantity};
use super::places::Places;
use super::term::Term;
use crate::error::Result;
use crate::linalg::sparse::SparseMatrix;

/// K and M at a parameter vector, with the memory to form them again.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// K(p) (N/m).
    pub stiffness: SparseMatrix,
    /// M(p) (kg).
    pub mass: SparseMatrix,
    stiffness_factors: Vec<f64>,
    mass_factors: Vec<f64>,
    places: Arc<[Places; 2]>,
    reform: Option<Reform>,
}

impl Assembly {
    /// Assembly of the nominal state.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self {
            stiffness: model.stiffness().clone(),
            mass: model.mass().clone(),
            stiffness_factors: vec![1.0; model.stiffness_terms().len()],
            mass_factors: vec![1.0; model.mass_terms().len()],
            places: model.places(),
            reform: model.frame().map(Reform::new),
        }
    }

    /// Forms K(x) and M(x).
    pub fn form(&mut self, model: &Model, parameters: &[Parameter], x: &[f64]) {
        self.stiffness_factors.fill(1.0);
        self.mass_factors.fill(1.0);
        for (parameter, &value) in parameters.iter().zip(x) {
            let (factors, factor) = match &parameter.quantity {
                Quantity::StiffnessReduction => (&mut self.stiffness_factors, 1.0 - value),
                Quantity::StiffnessFactor => (&mut self.stiffness_factors, value),
                Quantity::MassFactor => (&mut self.mass_factors, value),
                _ => continue,
            };
            for &term in &parameter.terms {
                factors[term] *= factor;
            }
        }
        let [stiffness_places, mass_places] = &*self.places;
        let sides = [
            (
                Nominal {
                    matrix: model.stiffness(),
                    terms: model.stiffness_terms(),
                    places: stiffness_places,
                },
                &self.stiffness_factors,
                &mut self.stiffness,
            ),
            (
                Nominal {
                    matrix: model.mass(),
                    terms: model.mass_terms(),
                    places: mass_places,
                },
                &self.mass_factors,
                &mut self.mass,
            ),
        ];
        if let (Some(reform), Some(frame)) = (&mut self.reform, model.frame()) {
            reform.form(frame, parameters, x, sides);
            return;
        }
        for (nominal, factors, target) in sides {
            target.values.copy_from_slice(&nominal.matrix.values);
            for (t, (term, &s)) in nominal.terms.iter().zip(factors).enumerate() {
                if s != 1.0 {
                    term.add_to(&mut target.values, nominal.places.of(t), s - 1.0);
                }
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

impl Model {
    /// The model whose nominal state is this model at parameter values `x`.
    ///
    /// # Errors
    /// Those of [`Model::new`], for example when a factor makes a mass negative, and of
    /// [`Frame::at`](super::frame::Frame::at).
    pub fn at(&self, parameters: &[Parameter], x: &[f64]) -> Result<Self> {
        if let Some(frame) = self.frame() {
            return Self::from_frame(frame.at(parameters, x)?);
        }
        let mut assembly = Assembly::new(self);
        assembly.form(self, parameters, x);
        let scaled = |terms: &[Term], factors: &[f64]| {
            terms
                .iter()
                .zip(factors)
                .map(|(term, f)| {
                    Term::from_entries(
                        term.entries()
                            .iter()
                            .map(|&(i, j, v)| (i, j, v * f))
                            .collect(),
                    )
                })
                .collect()
        };
        let (stiffness_terms, mass_terms) = (
            scaled(self.stiffness_terms(), assembly.stiffness_factors()),
            scaled(self.mass_terms(), assembly.mass_factors()),
        );
        Self::checked(
            assembly.stiffness,
            assembly.mass,
            stiffness_terms,
            mass_terms,
        )
    }
}
