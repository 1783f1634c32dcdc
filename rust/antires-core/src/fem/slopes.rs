//! dK/dp and dM/dp of one parameter, as sparse entries.
//!
//! ```text
//! K(p) = K + Σ_t (s_t(p) − 1) K_t      dK/dp_j = Σ_t (ds_t/dp_j) K_t
//! ```
//!
//! s_t is the product of the factors of all parameters on term t, so ds_t/dp_j is the slope of the
//! factor of p_j (−1 for a stiffness reduction, 1 for a factor) times the factors of the others.

use super::model::Model;
use super::parameters::{Parameter, Quantity};

/// Entries (row, column, value) of dK/dp and dM/dp; entries of one place add up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MatrixSlopes {
    /// dK/dp.
    pub stiffness: Vec<(u32, u32, f64)>,
    /// dM/dp.
    pub mass: Vec<(u32, u32, f64)>,
}

impl MatrixSlopes {
    /// Forms the slopes of `model` along parameter `index` at `x`.
    pub fn form(&mut self, model: &Model, parameters: &[Parameter], x: &[f64], index: usize) {
        self.stiffness.clear();
        self.mass.clear();
        let (own, _, own_slope) = factor(parameters[index].quantity, x[index]);
        let (terms, entries) = match own {
            Side::Stiffness => (model.stiffness_terms(), &mut self.stiffness),
            Side::Mass => (model.mass_terms(), &mut self.mass),
        };
        for &term in &parameters[index].terms {
            let mut slope = own_slope;
            for (other, parameter) in parameters.iter().enumerate() {
                let (side, value, _) = factor(parameter.quantity, x[other]);
                if side == own && other != index {
                    let times = parameter.terms.iter().filter(|&&t| t == term).count();
                    slope *= value.powi(times as i32);
                }
            }
            let scaled = terms[term].entries().iter();
            entries.extend(scaled.map(|&(row, col, value)| (row, col, slope * value)));
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Stiffness,
    Mass,
}

/// Which matrix a parameter scales, its factor there and the slope of that factor.
fn factor(quantity: Quantity, value: f64) -> (Side, f64, f64) {
    match quantity {
        Quantity::StiffnessReduction => (Side::Stiffness, 1.0 - value, -1.0),
        Quantity::StiffnessFactor => (Side::Stiffness, value, 1.0),
        Quantity::MassFactor => (Side::Mass, value, 1.0),
    }
}
