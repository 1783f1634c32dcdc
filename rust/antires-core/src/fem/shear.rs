//! Shear of beams: the coefficient κ of κ G A.
//!
//! ```text
//! rectangle                    κ = 10 (1 + ν) / (12 + 11 ν)
//! tube, m = inner / outer      κ = 6 (1 + ν) (1 + m²)² / [(7 + 6 ν) (1 + m²)² + (20 + 12 ν) m²]
//! ```
//!
//! A beam with shear has the rotary inertia of its section too (Timoshenko); one without has neither
//! (Euler-Bernoulli).
//!
//! Source: G. R. Cowper, J. Appl. Mech. 33 (1966) 335-340.

use super::shape::Shape;
use crate::error::{Argument, Error, Result};

/// Whether and how beams of a section deform by shear.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Shear {
    /// Not at all: Euler-Bernoulli.
    #[default]
    Rigid,
    /// By Cowper's coefficient of the shape, for tubes and rectangles.
    Cowper,
    /// By coefficients of one's own.
    Coefficients {
        /// For forces along the local y.
        y: f64,
        /// For forces along the local z.
        z: f64,
    },
}

impl Shear {
    /// κ for forces along y and along z; none where shear is rigid.
    #[must_use]
    pub fn coefficients(self, shape: &Shape, poisson: f64) -> Option<(f64, f64)> {
        match self {
            Self::Rigid => None,
            Self::Cowper => cowper(shape, poisson).map(|kappa| (kappa, kappa)),
            Self::Coefficients { y, z } => Some((y, z)),
        }
    }

    /// Checks the coefficients for a section of `shape`, called `name`.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a coefficient that is not positive, or Cowper's of a general shape.
    pub fn check(self, shape: &Shape, name: &Argument) -> Result<()> {
        let remedy =
            "It is the shear area over the area: 5/6 for a rectangle, about 1/2 for a thin tube.";
        let refuse = |got: String, wanted: &str| {
            Err(Error::input(name.field("shear_coefficient"), got, wanted).remedy(remedy))
        };
        match self {
            Self::Cowper if matches!(shape, Shape::General { .. }) => refuse(
                "'cowper' for a section given by its constants".into(),
                "a number",
            ),
            Self::Coefficients { y, z } => {
                match [y, z].into_iter().find(|k| !(*k > 0.0 && k.is_finite())) {
                    Some(bad) => refuse(bad.to_string(), "a positive, finite value"),
                    None => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }
}

fn cowper(shape: &Shape, nu: f64) -> Option<f64> {
    match *shape {
        Shape::Tube {
            outer_diameter_m: outer,
            thickness_m: t,
        } => {
            let m2 = (1.0 - 2.0 * t / outer).powi(2);
            let whole = (1.0 + m2).powi(2);
            Some(6.0 * (1.0 + nu) * whole / ((7.0 + 6.0 * nu) * whole + (20.0 + 12.0 * nu) * m2))
        }
        Shape::Rectangle { .. } => Some(10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)),
        Shape::General { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cowpers_coefficients_as_tabled() {
        let tube = |thickness_m| Shape::Tube {
            outer_diameter_m: 0.1,
            thickness_m,
        };
        let rectangle = Shape::Rectangle {
            width_m: 0.01,
            height_m: 0.02,
        };
        // Cowper's limits: circle 6 (1 + ν) / (7 + 6 ν), thin ring 2 (1 + ν) / (4 + 3 ν), and ν = 0.
        for (shape, nu, kappa) in [
            (tube(0.05), 0.3, 0.886_363_636),
            (tube(1e-9), 0.3, 0.530_612_245),
            (rectangle, 0.3, 0.849_673_203),
            (rectangle, 0.0, 5.0 / 6.0),
        ] {
            let (y, z) = Shear::Cowper.coefficients(&shape, nu).unwrap();
            assert!((y - kappa).abs() < 1e-8, "{y} {kappa}");
            assert_eq!(y, z);
        }
    }
}
