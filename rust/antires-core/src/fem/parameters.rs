//! Updating parameters: how a value p scales the terms it governs.
//!
//! ```text
//! stiffness reduction   s = 1 − β      0 <= β <= 1   (damage)
//! stiffness factor      s = p          p > 0
//! mass factor           s = p          p > 0
//! ```
//!
//! Several parameters on one term multiply.

use faer::Mat;

use super::model::Model;

/// What a parameter value means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Stiffness loss β of the terms: s = 1 − β.
    StiffnessReduction,
    /// Factor on the stiffness of the terms.
    StiffnessFactor,
    /// Factor on the mass of the terms.
    MassFactor,
}

impl Quantity {
    /// The value at which a parameter leaves the model as it is.
    #[must_use]
    pub fn nominal(self) -> f64 {
        match self {
            Self::StiffnessReduction => 0.0,
            Self::StiffnessFactor | Self::MassFactor => 1.0,
        }
    }
}

/// One scalar unknown and the terms it governs.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// What the value means.
    pub quantity: Quantity,
    /// Indices of the stiffness (or mass) terms.
    pub terms: Vec<usize>,
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
            };
            for &term in &parameter.terms {
                factors[term] *= factor;
            }
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
