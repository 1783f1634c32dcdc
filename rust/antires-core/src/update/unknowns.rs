//! What all objectives share: the model, its unknowns, the misfit, and what is charged for damage.
//!
//! ```text
//! J(x) = misfit(x) + γ₁ Σ β + γ₂ count(β > 0)
//! ```
//!
//! The penalties apply to the stiffness reductions β among the unknowns; severities below the snap count as
//! exactly zero.
//! The penalties of Eqs. 15-17 prefer few damaged elements. With γ₁ = γ₂ = 0.1 a small damage costs more than it explains:
//! see the detectable severities that the damage result reports.
//!
//! The misfit makes one number of the residuals e:
//!
//! ```text
//! absolute   Σ |e|      Eq. 12 of the paper: indifferent to a few wrong values
//! squared    Σ e²       least squares: shares a contradiction out among those who contradict
//! largest    max |e|    the largest difference itself
//! ```

use crate::error::{Argument, Error, Result};
use crate::fem::assembly::{MatrixSlopes, Slopes};
use crate::fem::model::Model;
use crate::fem::parameters::{Parameter, Quantity};
use crate::optimize::{Composition, Norm};

/// Largest threshold below which a severity may be snapped to zero.
pub const LARGEST_SNAP: f64 = 1e-3;

/// A model, its parameters and their price.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// The model.
    pub model: Model,
    /// At least one.
    pub parameters: Vec<Parameter>,
    penalty: Option<Penalty>,
    snap: f64,
}

impl Unknowns {
    /// Joins a model and its parameters; `penalty` applies to the stiffness reductions among them, of which
    /// those below `snap` count as exactly zero.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is no parameter, one governs nothing of the model, or `snap` is
    /// outside [0, 1e-3].
    pub fn new(
        model: Model,
        parameters: Vec<Parameter>,
        penalty: Option<Penalty>,
        snap: f64,
    ) -> Result<Self> {
        if !(0.0..=LARGEST_SNAP).contains(&snap) {
            return Err(Error::input("snap", snap, format!("a threshold in [0, {LARGEST_SNAP}]"))
                .remedy("0 snaps nothing; more than that would hide damage."));
        }
        if parameters.is_empty() {
            return Err(Error::input("parameters", "none", "at least one parameter")
                .remedy("Say what may change, by stiffness_factor, mass_factor and the like."));
        }
        for (i, parameter) in parameters.iter().enumerate() {
            parameter.check(&Argument::from("parameters").item(i), &model)?;
        }
        Ok(Self { model, parameters, penalty, snap })
    }

    /// Negligible severities become exactly zero.
    pub(super) fn snap(&self, x: &mut [f64]) {
        if self.snap > 0.0 {
            for (i, value) in x.iter_mut().enumerate() {
                if self.is_reduction(i) && value.abs() < self.snap {
                    *value = 0.0;
                }
            }
        }
    }

    /// `x` with negligible severities at zero: the point that is evaluated.
    pub(super) fn snapped(&self, x: &[f64]) -> Vec<f64> {
        let mut snapped = x.to_vec();
        self.snap(&mut snapped);
        snapped
    }

    /// The penalty of parameter values that are already snapped.
    pub(super) fn penalty_at(&self, snapped: &[f64]) -> f64 {
        let beta = snapped.iter().enumerate().filter(|(i, _)| self.is_reduction(*i)).map(|(_, &b)| b);
        self.penalty.map_or(0.0, |p| p.of(beta))
    }

    /// How J is composed, for residuals of that norm.
    pub(super) fn composition(&self, norm: Option<Norm>) -> Composition {
        let sparse: Vec<bool> =
            (0..self.parameters.len()).map(|i| self.penalty.is_some() && self.is_reduction(i)).collect();
        let gamma1 = self.penalty.map_or(0.0, |penalty| penalty.gamma1);
        let nominal = self.parameters.iter().map(|p| p.nominal(&self.model));
        Composition {
            norm,
            start: nominal.collect(),
            price: sparse.iter().map(|&s| if s { gamma1 } else { 0.0 }).collect(),
            sparse,
        }
    }

    /// dK/dp and dM/dp of every parameter at `x`.
    pub(super) fn slopes(&self, x: &[f64]) -> Vec<MatrixSlopes> {
        let along = Slopes::new(&self.model, &self.parameters, x);
        (0..self.parameters.len()).map(|index| along.along(index)).collect()
    }

    fn is_reduction(&self, index: usize) -> bool {
        self.parameters[index].quantity == Quantity::StiffnessReduction
    }
}

/// Weights that may multiply `count` residuals.
///
/// # Errors
/// [`Error::InvalidInput`] when there is not one finite, not negative weight for each measured value, or all
/// are zero.
pub(super) fn checked_weights(weights: Vec<f64>, count: usize) -> Result<Vec<f64>> {
    let usable = weights.iter().all(|w| w.is_finite() && *w >= 0.0) && weights.iter().any(|w| *w > 0.0);
    if weights.len() == count && usable {
        return Ok(weights);
    }
    Err(Error::input(
        "weights",
        format!("{} values", weights.len()),
        format!("{count} finite weights of at least 0, one for each measured value, not all 0"),
    )
    .remedy("Leave them out to count all values alike."))
}

// ---- penalties

/// Weights of the two penalties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalty {
    /// γ₁, on the sum of the severities.
    pub gamma1: f64,
    /// γ₂, on the number of damaged elements.
    pub gamma2: f64,
}

impl Penalty {
    /// Penalty of the severities `beta`.
    pub fn of(&self, beta: impl Iterator<Item = f64>) -> f64 {
        let (sum, count) =
            beta.fold((0.0, 0_usize), |(sum, count), b| (sum + b, count + usize::from(b > 0.0)));
        self.gamma1 * sum + self.gamma2 * count as f64
    }
}

// ---- misfit

/// The norm of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Misfit {
    /// Sum of absolute residuals, the paper's.
    #[default]
    Absolute,
    /// Sum of squared residuals.
    Squared,
    /// Largest absolute residual.
    Largest,
}

impl Misfit {
    /// `total` with one more residual taken in.
    pub fn add(self, total: f64, residual: f64) -> f64 {
        match self {
            Self::Absolute => total + residual.abs(),
            Self::Squared => total + residual * residual,
            Self::Largest => total.max(residual.abs()),
        }
    }

    /// The norm as the optimizer's polish knows it; it has none for the largest residual.
    pub fn norm(self) -> Option<Norm> {
        match self {
            Self::Absolute => Some(Norm::Absolute),
            Self::Squared => Some(Norm::Squared),
            Self::Largest => None,
        }
    }
}
