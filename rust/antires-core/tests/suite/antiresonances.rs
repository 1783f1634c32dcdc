//! Both routes against closed forms and against each other.

use antires_core::antiresonances::{Ends, Query, Route, antiresonances};
use antires_core::fem::model::{Model, mass_spring_chain};
use antires_core::modal::modes::{AllModes, hertz};
use faer::Mat;
use proptest::prelude::*;

use crate::common::config;

const SPRING: f64 = 56.7e3;
const MASS: f64 = 0.4194;

fn all(route: Route, include_cancelled: bool) -> Query {
    Query { route, f_max_hz: f64::INFINITY, include_cancelled }
}

fn chain8() -> Model {
    let mut masses = vec![MASS; 8];
    masses[0] = 0.5593;
    mass_spring_chain(&masses, &[SPRING; 7], 0.0, 0.0).unwrap()
}

/// Fixed-free uniform chain of `n` masses: ω_j = 2 √(k/m) sin((2j − 1) π / (2 (2n + 1))).
fn fixed_free_hz(n: usize) -> Vec<f64> {
    (1..=n)
        .map(|j| {
            let angle = (2 * j - 1) as f64 * std::f64::consts::PI / (2.0 * (2 * n + 1) as f64);
            2.0 * (SPRING / MASS).sqrt() * angle.sin() / std::f64::consts::TAU
        })
        .collect()
}

fn assert_close(got: &[f64], want: &[f64], tolerance: f64) {
    assert_eq!(got.len(), want.len(), "{got:?} against {want:?}");
    for (g, w) in got.iter().zip(want) {
        assert!((g / w - 1.0).abs() <= tolerance, "{g} against {w}");
    }
}

#[test]
fn chain8_has_7_6_5_4_3_2_1_0_and_they_are_those_of_the_sub_chains() {
    let model = chain8();
    for route in [Route::Modal, Route::Pencil] {
        let found =
            antiresonances(&model, &(0..8).map(|i| (i, 0).into()).collect::<Vec<_>>(), &all(route, false))
                .unwrap();
        for (i, zeros) in found.iter().enumerate() {
            assert_close(&zeros.freq_hz, &fixed_free_hz(7 - i), 1e-12);
        }
    }
}

#[test]
fn a_symmetric_chain_driven_at_its_middle_hides_its_odd_modes() {
    let model = mass_spring_chain(&[1.0; 5], &[1e4; 4], 0.0, 0.0).unwrap();
    let resonances = AllModes::of(&model).unwrap().finite().freq_hz;
    // Modes 1 and 3 (after the rigid-body mode 0) have their node at the middle mass. Clamping it
    // leaves two equal halves: each of their frequencies is a true zero once, and cancels once.
    let odd = [resonances[1], resonances[3]];
    for route in [Route::Modal, Route::Pencil] {
        let visible = antiresonances(&model, &[(2, 2).into()], &all(route, false)).unwrap();
        assert_close(&visible[0].freq_hz, &odd, 1e-9);
        let with = antiresonances(&model, &[(2, 2).into()], &all(route, true)).unwrap();
        assert_close(&with[0].freq_hz, &[odd[0], odd[0], odd[1], odd[1]], 1e-9);
        // Driven at the middle, the mass beside it does not move in the odd modes either.
        let aside = antiresonances(&model, &[(1, 2).into()], &all(route, true)).unwrap();
        let plain = antiresonances(&model, &[(1, 2).into()], &all(route, false)).unwrap();
        assert_eq!(aside[0].freq_hz.len(), plain[0].freq_hz.len() + 2);
        for f in odd {
            let on = |g: &f64| (g / f - 1.0).abs() < 1e-9;
            assert!(aside[0].freq_hz.iter().any(on) && !plain[0].freq_hz.iter().any(on));
        }
    }
}

#[test]
fn repeated_eigenvalues_hide_one_root_each() {
    // Three equal oscillators on one mass: two of the three equal modes do not move the mass.
    let n = 4;
    let mut k = Mat::zeros(n, n);
    for j in 1..n {
        k[(0, 0)] += 1e4;
        k[(j, j)] += 1e4;
        k[(0, j)] -= 1e4;
        k[(j, 0)] -= 1e4;
    }
    k[(0, 0)] += 5e3;
    let model = Model::new(k, Mat::identity(n, n), vec![], vec![]).unwrap();
    let absorber = (1e4_f64).sqrt() / std::f64::consts::TAU;
    for route in [Route::Modal, Route::Pencil] {
        let visible = antiresonances(&model, &[(0, 0).into()], &all(route, false)).unwrap();
        assert_close(&visible[0].freq_hz, &[absorber], 1e-12);
        let with = antiresonances(&model, &[(0, 0).into()], &all(route, true)).unwrap();
        assert_close(&with[0].freq_hz, &[absorber; 3], 1e-9);
    }
}

#[test]
fn an_unconnected_pair_is_identically_zero() {
    let k = Mat::from_fn(3, 3, |i, j| if i == j { 1e4 } else { 0.0 });
    let model = Model::new(k, Mat::identity(3, 3), vec![], vec![]).unwrap();
    for route in [Route::Modal, Route::Pencil] {
        let found = antiresonances(&model, &[(1, 0).into(), (0, 0).into()], &all(route, false)).unwrap();
        assert!(found[0].identically_zero && found[0].freq_hz.is_empty());
        assert!(!found[1].identically_zero);
    }
}

#[test]
fn massless_dofs_are_served_by_both_routes_and_equal_the_condensed_chain() {
    // A massless joint in the middle of each spring halves nothing: two springs 2k in series are k.
    let (n, k) = (4, 1e4);
    let springs = vec![2.0 * k; 2 * (n - 1)];
    let size = 2 * n - 1;
    let mut stiffness = Mat::<f64>::zeros(size, size);
    for (j, s) in springs.iter().enumerate() {
        for (a, b, sign) in [(j, j, 1.0), (j + 1, j + 1, 1.0), (j, j + 1, -1.0), (j + 1, j, -1.0)] {
            stiffness[(a, b)] += sign * s;
        }
    }
    let mass = Mat::from_fn(size, size, |i, j| if i == j && i % 2 == 0 { 1.0 } else { 0.0 });
    let massless = Model::new(stiffness, mass, vec![], vec![]).unwrap();
    let chain = mass_spring_chain(&[1.0; 4], &[k; 3], 0.0, 0.0).unwrap();
    let want: Vec<_> = antiresonances(
        &chain,
        &[(0, 0).into(), (1, 0).into(), (2, 0).into(), (3, 0).into()],
        &all(Route::Modal, false),
    )
    .unwrap();
    for route in [Route::Modal, Route::Pencil] {
        let got = antiresonances(
            &massless,
            &[(0, 0).into(), (2, 0).into(), (4, 0).into(), (6, 0).into()],
            &all(route, false),
        )
        .unwrap();
        for (g, w) in got.iter().zip(&want) {
            assert_close(&g.freq_hz, &w.freq_hz, 1e-9);
        }
    }
    // The massless joint beside the force: both routes again, whatever their number.
    let joint = |route| antiresonances(&massless, &[(1, 0).into()], &all(route, false)).unwrap();
    assert_close(&joint(Route::Modal)[0].freq_hz, &joint(Route::Pencil)[0].freq_hz, 1e-9);
    assert!(!joint(Route::Modal)[0].freq_hz.is_empty());
}

#[test]
fn a_double_zero_of_a_mirrored_pair_counts_twice() {
    // Masses 3 of 9 driven, 5 measured: the ends beyond them are equal, so the numerator is a square
    // and H only touches zero.
    let masses = [1.0, 1.3, 0.9, 1.1, 1.0, 1.1, 0.9, 1.3, 1.0];
    let springs = [1.2e4, 0.8e4, 1.1e4, 0.9e4, 0.9e4, 1.1e4, 0.8e4, 1.2e4];
    let model = mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap();
    let end = mass_spring_chain(&masses[..3], &springs[..2], 0.0, springs[2]).unwrap();
    let want: Vec<f64> = AllModes::of(&end).unwrap().finite().freq_hz.iter().flat_map(|&f| [f, f]).collect();
    for route in [Route::Modal, Route::Pencil] {
        let found = antiresonances(&model, &[(5, 3).into()], &all(route, false)).unwrap();
        assert_close(&found[0].freq_hz, &want, 1e-9);
    }
}

#[test]
fn far_apart_dofs_of_a_disordered_chain_have_the_zeros_of_its_ends_only() {
    // The receptance between them lies below the rounding of its own modal series.
    let (n, i, k) = (50, 42, 5);
    let spread = |j: usize, step: f64| 1.0 + 0.6 * (step * j as f64).sin();
    let masses: Vec<f64> = (0..n).map(|j| spread(j, 1.7)).collect();
    let springs: Vec<f64> = (0..n - 1).map(|j| 1e4 * spread(j, 2.9)).collect();
    let model = mass_spring_chain(&masses, &springs, 0.0, 0.0).unwrap();
    let left = mass_spring_chain(&masses[..k], &springs[..k - 1], 0.0, springs[k - 1]).unwrap();
    let right = mass_spring_chain(&masses[i + 1..], &springs[i + 1..], springs[i], 0.0).unwrap();
    let mut want =
        [AllModes::of(&left).unwrap().finite().freq_hz, AllModes::of(&right).unwrap().finite().freq_hz]
            .concat();
    want.sort_by(f64::total_cmp);
    for route in [Route::Modal, Route::Pencil] {
        let found = antiresonances(&model, &[(i, k).into()], &all(route, true)).unwrap();
        assert_close(&found[0].freq_hz, &want, 1e-9);
    }
}

/// A sparse stiffness of random springs between dofs and to ground, with lumped masses.
fn random_model() -> impl Strategy<Value = (Model, usize, usize)> {
    (2usize..14, any::<bool>()).prop_flat_map(|(n, grounded)| {
        let masses = prop::collection::vec(0.2..2.0_f64, n);
        let springs = prop::collection::vec((0..n, 0..n, 1e3..1e5_f64), n);
        (masses, springs, 0..n, 0..n).prop_map(move |(masses, springs, i, k)| {
            let mut stiffness = Mat::<f64>::zeros(n, n);
            let chain = (0..n - 1).map(|j| (j, j + 1, 2e4));
            for (a, b, s) in springs.into_iter().chain(chain) {
                if a != b {
                    stiffness[(a, a)] += s;
                    stiffness[(b, b)] += s;
                    stiffness[(a, b)] -= s;
                    stiffness[(b, a)] -= s;
                } else if grounded {
                    stiffness[(a, a)] += s;
                }
            }
            let mass = Mat::from_fn(n, n, |r, c| if r == c { masses[r] } else { 0.0 });
            (Model::new(stiffness, mass, vec![], vec![]).unwrap(), i, k)
        })
    })
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn the_two_routes_agree_on_random_models((model, i, k) in random_model()) {
        let top = 1.5 * AllModes::of(&model).unwrap().finite().freq_hz.last().unwrap();
        for include_cancelled in [false, true] {
            let query = |route| Query { route, f_max_hz: top, include_cancelled };
            let modal = antiresonances(&model, &[(i, k).into()], &query(Route::Modal)).unwrap();
            let pencil = antiresonances(&model, &[(i, k).into()], &query(Route::Pencil)).unwrap();
            let (modal, pencil) = (&modal[0].freq_hz, &pencil[0].freq_hz);
            prop_assert_eq!(modal.len(), pencil.len(), "{:?} {:?}", modal, pencil);
            for (a, b) in modal.iter().zip(pencil) {
                prop_assert!((a / b - 1.0).abs() < 1e-7, "{} {}", a, b);
            }
        }
    }

    #[test]
    fn antiresonances_are_reciprocal((model, i, k) in random_model()) {
        let query = all(Route::Modal, false);
        let there = antiresonances(&model, &[(i, k).into()], &query).unwrap();
        let back = antiresonances(&model, &[(k, i).into()], &query).unwrap();
        prop_assert_eq!(there[0].freq_hz.len(), back[0].freq_hz.len());
    }
}

#[test]
fn a_minor_of_a_chain_has_the_roots_of_its_parts() {
    // Fixed at masses 0 and 4 of 8, the rest are masses 1 to 3 between fixed ends and 5 to 7 fixed at one.
    let model = mass_spring_chain(&[1.0; 8], &[100.0; 7], 0.0, 0.0).unwrap();
    let ends = [Ends::new(&[4, 0], &[0, 4]).unwrap()];
    let parts = (1..4).flat_map(|j| [f64::from(j) / 8.0, f64::from(2 * j - 1) / 14.0]);
    let mut want: Vec<f64> =
        parts.map(|angle| hertz(400.0 * (std::f64::consts::PI * angle).sin().powi(2))).collect();
    want.sort_by(f64::total_cmp);
    for route in [Route::Modal, Route::Pencil] {
        let found = &antiresonances(&model, &ends, &all(route, true)).unwrap()[0];
        assert_eq!(found.freq_hz.len(), want.len(), "{found:?}");
        assert!(found.freq_hz.iter().zip(&want).all(|(f, w)| (f / w - 1.0).abs() < 1e-12), "{found:?}");
    }
}

#[test]
fn a_minor_whose_forces_share_one_way_is_identically_zero() {
    // What goes from masses 0 and 1 to 6 and 7 goes through one spring after the other.
    let model = mass_spring_chain(&[1.0; 8], &[100.0; 7], 0.0, 0.0).unwrap();
    let ends = [Ends::new(&[6, 7], &[0, 1]).unwrap()];
    let found = &antiresonances(&model, &ends, &all(Route::Modal, true)).unwrap()[0];
    assert!(found.identically_zero && found.freq_hz.is_empty(), "{found:?}");
}

#[test]
fn ends_have_as_many_responses_as_forces() {
    let refused = |i: &[usize], k: &[usize]| Ends::new(i, k).unwrap_err().to_string();
    assert!(refused(&[1], &[0, 4]).starts_with("response: got 1 dofs for 2 forces"));
    assert!(refused(&[1, 1], &[0, 4]).starts_with("response: got dof 1 twice"));
    assert!(refused(&[], &[]).starts_with("excitation: got 0 dofs"));
}
