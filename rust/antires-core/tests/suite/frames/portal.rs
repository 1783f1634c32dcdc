//! A square table in space against the slope-deflection formula of the portal frame.
//!
//! Four clamped columns (height h, I_c), four beams (span l, I_b), all massless and stiff along their
//! axes, a mass m on each corner. When the table sways by Δ along x, each corner turns by θ about y;
//! the beams along y only roll. Joint and sway equilibrium:
//!
//! ```text
//! (4 E I_c/h + 6 E I_b/l) θ = 6 E I_c/h² Δ        k = 4 (12 E I_c/h³ − 6 E I_c/h² · θ/Δ)
//! ω = √(k / 4m)
//! ```

use std::f64::consts::TAU;

use antires_core::fem::frame::elements::Dimension;
use antires_core::fem::section::{Section, Shape, Shear};
use antires_core::modal::modes::AllModes;
use nalgebra::{Rotation3, Vector3};

use super::build::{beam, lump, model, plain};

const HEIGHT_M: f64 = 0.9;
const SPAN_M: f64 = 1.4;
const MASS_KG: f64 = 12.0;
const COLUMN_M4: f64 = 2.0e-8;
const BEAM_M4: f64 = 1.3e-8;

/// Axially almost rigid: the sway then differs from the formula by I / (A h²), 1e-9.
fn massless(inertia: f64) -> Section {
    Section {
        shape: Shape::General {
            area_m2: inertia * 1e9,
            inertia_y_m4: inertia,
            inertia_z_m4: inertia,
            torsion_m4: inertia,
        },
        youngs_modulus_pa: 2.1e11,
        density_kg_per_m3: 0.0,
        poisson: 0.3,
        shear: Shear::Rigid,
    }
}

#[test]
fn a_space_portal_sways_as_the_formula_says_however_it_is_turned() {
    let (ec, eb) = (2.1e11 * COLUMN_M4, 2.1e11 * BEAM_M4);
    let turn = 6.0 * ec / HEIGHT_M.powi(2) / (4.0 * ec / HEIGHT_M + 6.0 * eb / SPAN_M);
    let sway = 4.0 * (12.0 * ec / HEIGHT_M.powi(3) - 6.0 * ec / HEIGHT_M.powi(2) * turn);
    let exact = (sway / (4.0 * MASS_KG)).sqrt() / TAU;

    let corners = [[0.0, 0.0], [SPAN_M, 0.0], [SPAN_M, SPAN_M], [0.0, SPAN_M]];
    for rotation in [Rotation3::identity(), Rotation3::from_euler_angles(0.4, -1.1, 2.3)] {
        let nodes = [0.0, HEIGHT_M]
            .iter()
            .flat_map(|&z| corners.map(|[x, y]| (rotation * Vector3::new(x, y, z)).into()))
            .collect();
        let beams = (0..4).flat_map(|i| [beam(i, i + 4, 0), beam(4 + i, 4 + (i + 1) % 4, 1)]).collect();
        let mut frame = plain(Dimension::Space, nodes, beams);
        frame.sections = vec![massless(COLUMN_M4), massless(BEAM_M4)];
        frame.fixed = (0..24).map(|i| (i / 6, i % 6)).collect();
        frame.elements.extend((4..8).map(|node| lump(node, MASS_KG, [0.0; 3])));
        let found = AllModes::of(&model(frame)).unwrap().finite().freq_hz;
        // Four corners that move in three directions each; the rest carries no mass.
        assert_eq!(found.len(), 12);
        for f in &found[..2] {
            assert!((f / exact - 1.0).abs() < 1e-6, "{f} {exact}");
        }
        assert!(found[2] > 1.01 * exact);
    }
}
