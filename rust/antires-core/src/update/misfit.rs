//! How the residuals e become one number.
//!
//! ```text
//! absolute   Σ |e|      Eq. 12 of the paper: indifferent to a few wrong values
//! squared    Σ e²       least squares: shares a contradiction out among those who contradict
//! largest    max |e|    the largest difference itself
//! ```

use crate::optimize::Norm;

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
    #[must_use]
    pub fn add(self, total: f64, residual: f64) -> f64 {
        match self {
            Self::Absolute => total + residual.abs(),
            Self::Squared => total + residual * residual,
            Self::Largest => total.max(residual.abs()),
        }
    }

    /// The norm as the optimizer's polish knows it; it has none for the largest residual.
    #[must_use]
    pub fn norm(self) -> Option<Norm> {
        match self {
            Self::Absolute => Some(Norm::Absolute),
            Self::Squared => Some(Norm::Squared),
            Self::Largest => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Misfit;

    #[test]
    fn the_three_norms_of_one_set() {
        let of = |misfit: Misfit| [0.5, -2.0, 1.0].iter().fold(0.0, |t, &e| misfit.add(t, e));
        assert_eq!(of(Misfit::Absolute), 3.5);
        assert_eq!(of(Misfit::Squared), 5.25);
        assert_eq!(of(Misfit::Largest), 2.0);
    }
}
