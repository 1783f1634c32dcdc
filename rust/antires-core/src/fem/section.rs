//! Cross-sections with their material: what a beam needs to know of them.
//!
//! Local axes: x along the beam; y points to the reference direction of the beam (in the plane frame it
//! lies in the plane), so that I_z resists bending in the plane x-y.
//!
//! # shape
//!
//! Shapes of cross-sections: A, I_y, I_z and J.
//!
//! ```text
//! tube, outer diameter D, wall t, d = D − 2t    A = π t (D − t)    I = A (D² + d²) / 16    J = 2 I
//! rectangle, width b along z, height h along y  A = b h    I_z = b h³ / 12    I_y = h b³ / 12
//!     J = s³ l / 3 · [1 − (192 / π⁵) (s / l) Σ_{n odd} tanh(n π l / 2s) / n⁵],  s <= l the two sides
//! ```
//!
//! Source: Timoshenko & Goodier, Theory of Elasticity, 3rd ed. (1970), section 109 (torsion of a
//! rectangle).
//!
//! # shear
//!
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

use std::f64::consts::PI;

use crate::error::{Argument, Error, Result};

/// A cross-section of one material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Its shape.
    pub shape: Shape,
    /// Young's modulus (Pa).
    pub youngs_modulus_pa: f64,
    /// Density (kg/m³).
    pub density_kg_per_m3: f64,
    /// Poisson's ratio; the shear modulus is E / (2 (1 + ν)).
    pub poisson: f64,
    /// Whether its beams deform by shear.
    pub shear: Shear,
}

/// What a beam needs to know of its section for bending in one plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bending {
    /// E I (N·m²).
    pub stiffness_nm2: f64,
    /// κ G A (N); infinite where shear is rigid.
    pub shear_n: f64,
    /// ρ I (kg·m), the rotary inertia per length; zero where shear is rigid.
    pub rotary_kgm: f64,
}

/// What a beam needs to know of its section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigidity {
    /// EA (N).
    pub axial_n: f64,
    /// Bending in the plane x-z, by I_y.
    pub bending_y: Bending,
    /// Bending in the plane x-y, by I_z.
    pub bending_z: Bending,
    /// G J (N·m²).
    pub torsion_nm2: f64,
    /// ρ A (kg/m).
    pub mass_kg_per_m: f64,
    /// ρ (I_y + I_z) (kg·m), the inertia about the axis of the beam per length.
    pub polar_kgm: f64,
}

impl Section {
    /// Stiffness and mass per length.
    pub fn rigidity(&self) -> Rigidity {
        let (area, inertia_y, inertia_z, torsion) = self.shape.constants();
        let e = self.youngs_modulus_pa;
        let g = e / (2.0 * (1.0 + self.poisson));
        let (shear_y, shear_z) = self.shear.coefficients(&self.shape, self.poisson).unzip();
        let bending = |inertia: f64, coefficient: Option<f64>| Bending {
            stiffness_nm2: e * inertia,
            shear_n: coefficient.map_or(f64::INFINITY, |kappa| kappa * g * area),
            rotary_kgm: coefficient.map_or(0.0, |_| self.density_kg_per_m3 * inertia),
        };
        Rigidity {
            axial_n: e * area,
            // Forces along z shear the plane x-z.
            bending_y: bending(inertia_y, shear_z),
            bending_z: bending(inertia_z, shear_y),
            torsion_nm2: g * torsion,
            mass_kg_per_m: self.density_kg_per_m3 * area,
            polar_kgm: self.density_kg_per_m3 * (inertia_y + inertia_z),
        }
    }

    /// Checks shape and material; `name` is how the caller calls this section.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a dimension or modulus that is not positive, a wall thicker than the
    /// radius, a negative density, or a Poisson's ratio outside (−1, 0.5].
    pub fn check(&self, name: &Argument) -> Result<()> {
        let positive = |what: &str, unit: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(Error::input(name.field(what), format!("{value} {unit}"), "a positive, finite value")
                .remedy("Dimensions and moduli are in SI units: m, Pa."))
        };
        positive("youngs_modulus_pa", "Pa", self.youngs_modulus_pa)?;
        if !(self.density_kg_per_m3.is_finite() && self.density_kg_per_m3 >= 0.0) {
            return Err(Error::input(
                name.field("density_kg_per_m3"),
                format!("{} kg/m³", self.density_kg_per_m3),
                "a finite value of at least 0",
            )
            .remedy("It is in kg/m³; 0 makes the beam massless."));
        }
        if !(self.poisson > -1.0 && self.poisson <= 0.5) {
            return Err(Error::input(name.field("poisson"), self.poisson, "a ratio in (-1, 0.5]")
                .remedy("Metals have about 0.3."));
        }
        self.shear.check(&self.shape, name)?;
        match self.shape {
            Shape::Tube { outer_diameter_m: outer, thickness_m: t } => {
                positive("outer_diameter_m", "m", outer)?;
                positive("thickness_m", "m", t)?;
                // A rod, t = D/2, may miss it by a rounding.
                if t > 0.5 * outer * (1.0 + 4.0 * f64::EPSILON) {
                    return Err(Error::input(
                        name.field("thickness_m"),
                        format!("a wall of {t} m in a tube of {outer} m"),
                        "a wall of at most half the outer diameter",
                    )
                    .remedy(
                        "At half the diameter the tube is a solid rod; check which of the two is wrong.",
                    ));
                }
                Ok(())
            }
            Shape::Rectangle { width_m, height_m } => {
                positive("width_m", "m", width_m)?;
                positive("height_m", "m", height_m)
            }
            Shape::General { area_m2, inertia_y_m4, inertia_z_m4, torsion_m4 } => {
                positive("area_m2", "m²", area_m2)?;
                positive("inertia_y_m4", "m⁴", inertia_y_m4)?;
                positive("inertia_z_m4", "m⁴", inertia_z_m4)?;
                positive("torsion_m4", "m⁴", torsion_m4)
            }
        }
    }
}

// ---- shape

/// Σ 1/n⁵ over odd n: 31/32 ζ(5).
const ODD_FIFTH_POWERS: f64 = 1.004_523_762_795_139_6;

/// The shape of a cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A round tube; a wall of half the diameter makes it a rod.
    Tube {
        /// Outer diameter (m).
        outer_diameter_m: f64,
        /// Thickness of the wall (m).
        thickness_m: f64,
    },
    /// A solid rectangle.
    Rectangle {
        /// Side along the local z (m).
        width_m: f64,
        /// Side along the local y (m).
        height_m: f64,
    },
    /// Anything else, by its constants.
    General {
        /// Area (m²).
        area_m2: f64,
        /// Second moment for bending in the plane x-z (m⁴).
        inertia_y_m4: f64,
        /// Second moment for bending in the plane x-y (m⁴).
        inertia_z_m4: f64,
        /// St. Venant torsion constant (m⁴).
        torsion_m4: f64,
    },
}

impl Shape {
    /// Outer diameter and thickness (m) of a tube, to be changed; none for other shapes.
    pub fn tube_mut(&mut self) -> Option<(&mut f64, &mut f64)> {
        match self {
            Self::Tube { outer_diameter_m, thickness_m } => Some((outer_diameter_m, thickness_m)),
            _ => None,
        }
    }

    /// (A, I_y, I_z, J).
    pub fn constants(&self) -> (f64, f64, f64, f64) {
        match *self {
            Self::Tube { outer_diameter_m: outer, thickness_m: t } => {
                let inner = outer - 2.0 * t;
                let area = PI * t * (outer - t);
                let inertia = area * (outer * outer + inner * inner) / 16.0;
                (area, inertia, inertia, 2.0 * inertia)
            }
            Self::Rectangle { width_m: b, height_m: h } => {
                (b * h, h * b.powi(3) / 12.0, b * h.powi(3) / 12.0, rectangle_torsion(b, h))
            }
            Self::General { area_m2, inertia_y_m4, inertia_z_m4, torsion_m4 } => {
                (area_m2, inertia_y_m4, inertia_z_m4, torsion_m4)
            }
        }
    }
}

/// Torsion constant of a rectangle. The series converges like 1/n⁵; what remains of it after
/// subtracting that sum, tanh − 1, like e^(−nπ).
fn rectangle_torsion(b: f64, h: f64) -> f64 {
    let (short, long) = if b < h { (b, h) } else { (h, b) };
    let rest: f64 = (0..8)
        .map(|i| f64::from(2 * i + 1))
        .map(|n| ((n * PI * long / (2.0 * short)).tanh() - 1.0) / n.powi(5))
        .sum();
    let series = ODD_FIFTH_POWERS + rest;
    short.powi(3) * long / 3.0 * (1.0 - 192.0 / PI.powi(5) * short / long * series)
}

// ---- shear

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
        let remedy = "It is the shear area over the area: 5/6 for a rectangle, about 1/2 for a thin tube.";
        let refuse = |got: String, wanted: &str| {
            Err(Error::input(name.field("shear_coefficient"), got, wanted).remedy(remedy))
        };
        match self {
            Self::Cowper if matches!(shape, Shape::General { .. }) => {
                refuse("'cowper' for a section given by its constants".into(), "a number")
            }
            Self::Coefficients { y, z } => match [y, z].into_iter().find(|k| !(*k > 0.0 && k.is_finite())) {
                Some(bad) => refuse(bad.to_string(), "a positive, finite value"),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }
}

fn cowper(shape: &Shape, nu: f64) -> Option<f64> {
    match *shape {
        Shape::Tube { outer_diameter_m: outer, thickness_m: t } => {
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
    fn a_wall_thicker_than_the_radius_is_refused() {
        let section = |thickness_m| Section {
            shape: Shape::Tube { outer_diameter_m: 0.03, thickness_m },
            youngs_modulus_pa: 2e11,
            density_kg_per_m3: 7800.0,
            poisson: 0.3,
            shear: Shear::Rigid,
        };
        assert!(section(0.015).check(&Argument::from("sections").item(0)).is_ok());
        let error = section(0.016).check(&Argument::from("sections").item(0)).unwrap_err().to_string();
        assert!(error.starts_with("sections[0].thickness_m: got"), "{error}");
        let mut bad = section(0.002);
        bad.poisson = 0.6;
        assert!(bad.check(&Argument::from("sections").item(0)).is_err());
        bad.poisson = 0.3;
        bad.density_kg_per_m3 = f64::NAN;
        assert!(bad.check(&Argument::from("sections").item(0)).is_err());
    }

    #[test]
    fn a_rod_is_a_tube_without_a_hole_and_a_thin_tube_is_a_ring() {
        let tube = |outer_diameter_m, thickness_m| Shape::Tube { outer_diameter_m, thickness_m }.constants();
        let (area, inertia, _, torsion) = tube(0.2, 0.1);
        assert!((area - PI * 0.01).abs() < 1e-16);
        assert!((inertia / (PI * 0.2_f64.powi(4) / 64.0) - 1.0).abs() < 1e-15);
        assert!((torsion / (2.0 * inertia) - 1.0).abs() < 1e-15);
        // Thin wall: A = 2πrt, I = π r³ t with r the mean radius, to (t/r)².
        let (r, t) = (0.1, 1e-5);
        let (area, inertia, _, _) = tube(2.0 * r + t, t);
        assert!((area / (2.0 * PI * r * t) - 1.0).abs() < 1e-11);
        assert!((inertia / (PI * r.powi(3) * t) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn torsion_of_rectangles_as_tabled() {
        // Timoshenko & Goodier, table of section 109: J / (short³ long).
        for (ratio, tabled) in [(1.0, 0.1406), (1.5, 0.196), (2.0, 0.229), (4.0, 0.281), (10.0, 0.312)] {
            let j = rectangle_torsion(ratio * 0.1, 0.1);
            let coefficient = j / (0.1_f64.powi(3) * ratio * 0.1);
            assert!((coefficient - tabled).abs() < 6e-4, "{ratio}: {coefficient}");
            assert_eq!(j, rectangle_torsion(0.1, ratio * 0.1));
        }
        // Both triangles of the square's symmetry meet without a jump.
        let wide = rectangle_torsion(0.1, 0.1 * (1.0 + 1e-9));
        assert!((wide / rectangle_torsion(0.1, 0.1) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn cowpers_coefficients_as_tabled() {
        let tube = |thickness_m| Shape::Tube { outer_diameter_m: 0.1, thickness_m };
        let rectangle = Shape::Rectangle { width_m: 0.01, height_m: 0.02 };
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
