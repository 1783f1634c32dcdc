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

use std::f64::consts::PI;

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
            Self::Tube {
                outer_diameter_m,
                thickness_m,
            } => Some((outer_diameter_m, thickness_m)),
            _ => None,
        }
    }

    /// (A, I_y, I_z, J).
    #[must_use]
    pub fn constants(&self) -> (f64, f64, f64, f64) {
        match *self {
            Self::Tube {
                outer_diameter_m: outer,
                thickness_m: t,
            } => {
                let inner = outer - 2.0 * t;
                let area = PI * t * (outer - t);
                let inertia = area * (outer * outer + inner * inner) / 16.0;
                (area, inertia, inertia, 2.0 * inertia)
            }
            Self::Rectangle {
                width_m: b,
                height_m: h,
            } => (
                b * h,
                h * b.powi(3) / 12.0,
                b * h.powi(3) / 12.0,
                rectangle_torsion(b, h),
            ),
            Self::General {
                area_m2,
                inertia_y_m4,
                inertia_z_m4,
                torsion_m4,
            } => (area_m2, inertia_y_m4, inertia_z_m4, torsion_m4),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rod_is_a_tube_without_a_hole_and_a_thin_tube_is_a_ring() {
        let tube = |outer_diameter_m, thickness_m| {
            Shape::Tube {
                outer_diameter_m,
                thickness_m,
            }
            .constants()
        };
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
        for (ratio, tabled) in [
            (1.0, 0.1406),
            (1.5, 0.196),
            (2.0, 0.229),
            (4.0, 0.281),
            (10.0, 0.312),
        ] {
            let j = rectangle_torsion(ratio * 0.1, 0.1);
            let coefficient = j / (0.1_f64.powi(3) * ratio * 0.1);
            assert!(
                (coefficient - tabled).abs() < 6e-4,
                "{ratio}: {coefficient}"
            );
            assert_eq!(j, rectangle_torsion(0.1, ratio * 0.1));
        }
        // Both triangles of the square's symmetry meet without a jump.
        let wide = rectangle_torsion(0.1, 0.1 * (1.0 + 1e-9));
        assert!((wide / rectangle_torsion(0.1, 0.1) - 1.0).abs() < 1e-8);
    }
}
