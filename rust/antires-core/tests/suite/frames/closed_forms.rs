//! Straight beams against the Euler-Bernoulli, bar and shaft formulas, and the order of convergence.
//!
//! ```text
//! bending   ω = (βL)² √(EI / ρA) / L²      cantilever  cosh βL cos βL = −1,  free-free  = 1,  supported  sin βL = 0
//! axial     ω = (2k − 1) π/2 √(E/ρ) / L    torsion     ω = (2k − 1) π/2 √(GJ / ρI_p) / L        (fixed-free)
//! ```
//!
//! With shear and rotary inertia: see `hinged_hz`.
//!
//! Source: Blevins, Formulas for Natural Frequency and Mode Shape (1979), tables 8-1, 8-16, 8-19; Timoshenko, Vibration Problems in
//! Engineering (1937), section 58.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use antires_core::fem::frame::elements::{Dimension, FrameDescription};
use antires_core::fem::section::{Section, Shape, Shear};
use antires_core::modal::modes::AllModes;

use super::build::{each, line, model, steel, tube};

const LENGTH_M: f64 = 1.7;
const MESHES: [usize; 4] = [4, 8, 16, 32];

/// Roots βL, to the last digit.
const CANTILEVER: [f64; 3] = [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613];
const FREE_FREE: [f64; 3] = [4.730_040_744_862_704, 7.853_204_624_095_838, 10.995_607_838_001_671];
const SUPPORTED: [f64; 3] = [PI, 2.0 * PI, 3.0 * PI];

fn bending_hz(root: f64, section: &Section) -> f64 {
    let r = section.rigidity();
    root * root * (r.bending_z.stiffness_nm2 / r.mass_kg_per_m).sqrt() / (LENGTH_M * LENGTH_M * TAU)
}

/// Relative errors [mesh][mode] of the lowest elastic frequencies.
fn errors(exact_hz: &[f64], build: impl Fn(usize) -> FrameDescription) -> Vec<Vec<f64>> {
    let mut table = Vec::new();
    for n in MESHES {
        let found = AllModes::of(&model(build(n))).unwrap().finite().freq_hz;
        let elastic: Vec<f64> = found.into_iter().filter(|f| *f > 1e-3 * exact_hz[0]).collect();
        let row: Vec<f64> = exact_hz.iter().zip(&elastic).map(|(e, f)| f / e - 1.0).collect();
        table.push(row);
    }
    table
}

/// The observed order between the two finest meshes of each mode, where the error is above rounding.
fn assert_order(table: &[Vec<f64>], order: f64) {
    let mut checked = 0;
    for (coarse, fine) in table[2].iter().zip(&table[3]) {
        assert!(*coarse > 0.0, "a conforming element is too stiff: {coarse:e}");
        if *fine > 2e-7 {
            let observed = (coarse / fine).log2();
            assert!((observed - order).abs() < 0.05, "order {observed}");
            checked += 1;
        }
    }
    assert!(checked >= 2, "nothing checked");
}

/// Straight beam along x of `n` elements; `held` says which dofs of node i are fixed.
fn held(
    dimension: Dimension,
    n: usize,
    section: Section,
    held: impl Fn(usize, usize) -> bool,
) -> FrameDescription {
    let mut frame = line(dimension, n, [LENGTH_M, 0.0, 0.0], section);
    for node in 0..=n {
        for direction in 0..dimension.per_node() {
            if held(node, direction) {
                frame.fixed.push((node, direction));
            }
        }
    }
    frame
}

#[test]
fn bending_converges_with_order_four() {
    let exact = |roots: [f64; 3]| roots.map(|root| bending_hz(root, &tube()));
    let plane = Dimension::Plane;
    // Axial motion is held, so that only bending is left.
    let cantilever =
        errors(&exact(CANTILEVER), |n| held(plane, n, tube(), |node, direction| node == 0 || direction == 0));
    let free = errors(&exact(FREE_FREE), |n| held(plane, n, tube(), |_, direction| direction == 0));
    let supported = errors(&exact(SUPPORTED), |n| {
        held(plane, n, tube(), |node, direction| {
            direction == 0 || (direction == 1 && (node == 0 || node == n))
        })
    });
    for table in [cantilever, free, supported] {
        assert_order(&table, 4.0);
        assert!(table[3].iter().all(|e| *e < 1e-5), "{:?}", table[3]);
    }
}

/// Lower root of ρA ρI / κGA ω⁴ − (ρA + q² (ρI + EI ρA / κGA)) ω² + EI q⁴ = 0 with q = nπ/L, in Hz: bending
/// of a Timoshenko beam on hinges.
fn hinged_hz(n: f64, section: &Section) -> f64 {
    let r = section.rigidity();
    let bending = r.bending_z;
    let q2 = (n * PI / LENGTH_M).powi(2);
    let a = r.mass_kg_per_m * bending.rotary_kgm / bending.shear_n;
    let b = r.mass_kg_per_m
        + q2 * (bending.rotary_kgm + bending.stiffness_nm2 * r.mass_kg_per_m / bending.shear_n);
    let c = bending.stiffness_nm2 * q2 * q2;
    (2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())).sqrt() / TAU
}

#[test]
fn hinged_beams_with_shear_converge_to_the_closed_form_with_order_two() {
    let mut section = steel(Shape::Rectangle { width_m: 0.05, height_m: 0.25 });
    section.shear = Shear::Cowper;
    let exact = [1.0, 2.0, 3.0].map(|n| hinged_hz(n, &section));
    let table = errors(&exact, |n| {
        held(Dimension::Plane, n, section, |node, direction| {
            direction == 0 || (direction == 1 && (node == 0 || node == n))
        })
    });
    assert_order(&table, 2.0);
    assert!(table[3].iter().all(|e| *e < 2e-3), "{:?}", table[3]);
    // Without shear they would be 2 to 15 % higher.
    section.shear = Shear::Rigid;
    let rigid = bending_hz(PI, &section);
    assert!(rigid > 1.02 * exact[0], "{rigid} {}", exact[0]);
}

#[test]
fn bars_and_shafts_converge_with_order_two() {
    let section = tube();
    let r = section.rigidity();
    let exact = |speed: f64| [1.0, 3.0, 5.0].map(|k| k * FRAC_PI_2 * speed / (LENGTH_M * TAU));
    for (direction, speed) in
        [(0, (r.axial_n / r.mass_kg_per_m).sqrt()), (3, (r.torsion_nm2 / r.polar_kgm).sqrt())]
    {
        let table = errors(&exact(speed), |n| {
            held(Dimension::Space, n, section, |node, d| node == 0 || d != direction)
        });
        assert_order(&table, 2.0);
        assert!(table[3][0] < 2e-4);
    }
}

#[test]
fn a_space_cantilever_has_both_bending_families_torsion_and_axial_motion() {
    let section = steel(Shape::Rectangle { width_m: 0.05, height_m: 0.08 });
    let r = section.rigidity();
    let bending =
        |ei: f64, root: f64| root * root * (ei / r.mass_kg_per_m).sqrt() / (LENGTH_M * LENGTH_M * TAU);
    let fourth = 10.995_540_734_875_467;
    let mut exact: Vec<f64> = CANTILEVER
        .iter()
        .chain([&fourth])
        .flat_map(|&root| {
            [bending(r.bending_y.stiffness_nm2, root), bending(r.bending_z.stiffness_nm2, root)]
        })
        .collect();
    exact.push((r.torsion_nm2 / r.polar_kgm).sqrt() * FRAC_PI_2 / (LENGTH_M * TAU));
    exact.push((r.axial_n / r.mass_kg_per_m).sqrt() * FRAC_PI_2 / (LENGTH_M * TAU));
    exact.sort_by(f64::total_cmp);
    // Any direction in space, the reference direction across it.
    let end = [1.0, 1.2, (LENGTH_M * LENGTH_M - 2.44_f64).sqrt()];
    let mut frame = line(Dimension::Space, 40, end, section);
    for beam in each!(frame.elements.iter_mut(), Beam) {
        beam.reference = Some([-0.3, 0.9, 0.2]);
    }
    frame.fixed = (0..6).map(|direction| (0, direction)).collect();
    let found = AllModes::of(&model(frame)).unwrap().finite().freq_hz;
    for (f, exact) in found.iter().zip(&exact) {
        let error = f / exact - 1.0;
        assert!(error > -1e-7 && error < 2e-4, "{f} {exact}");
    }
}
