//! Cross-sections with their material: what a beam needs to know of them.
//!
//! Local axes: x along the beam; y points to the reference direction of the beam (in the plane frame it
//! lies in the plane), so that I_z resists bending in the plane x-y.

use crate::error::{Argument, Error, Result};

pub use super::shape::Shape;
pub use super::shear::Shear;

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
    #[must_use]
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
            Err(Error::input(
                name.field(what),
                format!("{value} {unit}"),
                "a positive, finite value",
            )
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
            return Err(
                Error::input(name.field("poisson"), self.poisson, "a ratio in (-1, 0.5]")
                    .remedy("Metals have about 0.3."),
            );
        }
        self.shear.check(&self.shape, name)?;
        match self.shape {
            Shape::Tube {
                outer_diameter_m: outer,
                thickness_m: t,
            } => {
                positive("outer_diameter_m", "m", outer)?;
                positive("thickness_m", "m", t)?;
                // A rod, t = D/2, may miss it by a rounding.
                if t > 0.5 * outer * (1.0 + 4.0 * f64::EPSILON) {
                    return Err(Error::input(
                        name.field("thickness_m"),
                        format!("a wall of {t} m in a tube of {outer} m"),
                        "a wall of at most half the outer diameter",
                    ).remedy("At half the diameter the tube is a solid rod; check which of the two is wrong."));
                }
                Ok(())
            }
            Shape::Rectangle { width_m, height_m } => {
                positive("width_m", "m", width_m)?;
                positive("height_m", "m", height_m)
            }
            Shape::General {
                area_m2,
                inertia_y_m4,
                inertia_z_m4,
                torsion_m4,
            } => {
                positive("area_m2", "m²", area_m2)?;
                positive("inertia_y_m4", "m⁴", inertia_y_m4)?;
                positive("inertia_z_m4", "m⁴", inertia_z_m4)?;
                positive("torsion_m4", "m⁴", torsion_m4)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_thicker_than_the_radius_is_refused() {
        let section = |thickness_m| Section {
            shape: Shape::Tube {
                outer_diameter_m: 0.03,
                thickness_m,
            },
            youngs_modulus_pa: 2e11,
            density_kg_per_m3: 7800.0,
            poisson: 0.3,
            shear: Shear::Rigid,
        };
        assert!(
            section(0.015)
                .check(&Argument::from("sections").item(0))
                .is_ok()
        );
        let error = section(0.016)
            .check(&Argument::from("sections").item(0))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("sections[0].thickness_m: got"), "{error}");
        let mut bad = section(0.002);
        bad.poisson = 0.6;
        assert!(bad.check(&Argument::from("sections").item(0)).is_err());
        bad.poisson = 0.3;
        bad.density_kg_per_m3 = f64::NAN;
        assert!(bad.check(&Argument::from("sections").item(0)).is_err());
    }
}
