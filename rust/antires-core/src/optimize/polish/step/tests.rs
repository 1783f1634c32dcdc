use super::*;

fn solve(norm: Norm, e: &[f64], a: &[f64], price: &[f64], reach: f64) -> Vec<f64> {
    let (low, high) = (vec![-reach; price.len()], vec![reach; price.len()]);
    let problem = Subproblem {
        norm,
        residuals: e,
        jacobian: a,
        price,
        low: &low,
        high: &high,
    };
    problem.solve()
}

#[test]
fn one_unknown_goes_to_the_median_the_mean_or_the_end_of_the_box() {
    let (e, ones) = ([3.0, -1.0, 10.0, 2.0, 4.0], [1.0; 5]);
    let at = |norm, price, reach| solve(norm, &e, &ones, &[price], reach)[0];
    assert!((at(Norm::Absolute, 0.0, 20.0) + 3.0).abs() < 1e-8);
    // Σ (e + d)² + c d: d = −mean − c / 10.
    assert!((at(Norm::Squared, 5.0, 20.0) + 3.6 + 0.5).abs() < 1e-8);
    // Σ |e + d| + 2 d turns where one is above and three are below.
    assert!((at(Norm::Absolute, 2.0, 20.0) + 4.0).abs() < 1e-8);
    for norm in [Norm::Absolute, Norm::Squared] {
        assert_eq!(at(norm, 0.0, 1.0), -1.0);
    }
}

#[test]
fn a_consistent_system_is_solved_whatever_the_flat_directions() {
    // Twelve residuals of four unknowns, the last two of which act as one.
    let a: Vec<f64> = (0..12)
        .flat_map(|i| {
            let at = |k: f64| (k * f64::from(i) + 0.3 * k).sin();
            [at(0.7), at(1.9), at(0.4), at(0.4)]
        })
        .collect();
    let truth = [0.3, -0.2, 0.15, 0.1];
    let e: Vec<f64> = a
        .chunks_exact(4)
        .map(|row| -row.iter().zip(truth).map(|(a, x)| a * x).sum::<f64>())
        .collect();
    for norm in [Norm::Absolute, Norm::Squared] {
        let d = solve(norm, &e, &a, &[0.0; 4], 1.0);
        assert!(
            (d[0] - 0.3).abs() < 1e-6 && (d[1] + 0.2).abs() < 1e-6,
            "{d:?}"
        );
        assert!((d[2] + d[3] - 0.25).abs() < 1e-6, "{d:?}");
    }
}

#[test]
fn no_neighbour_of_a_step_is_better() {
    let a: Vec<f64> = (0..40).map(|i| (1.7 * f64::from(i * i)).cos()).collect();
    let e: Vec<f64> = (0..10).map(|i| (2.9 * f64::from(i)).sin()).collect();
    let price = [0.1, 0.3, 0.0, -0.2];
    for (norm, reach) in [
        (Norm::Absolute, 0.2),
        (Norm::Absolute, 5.0),
        (Norm::Squared, 5.0),
    ] {
        let (low, high) = ([-reach; 4], [reach; 4]);
        let problem = Subproblem {
            norm,
            residuals: &e,
            jacobian: &a,
            price: &price,
            low: &low,
            high: &high,
        };
        let d = problem.solve();
        let best = problem.value(&d);
        for k in 0..200 {
            let mut near = d.clone();
            for (j, x) in near.iter_mut().enumerate() {
                let shift = 1e-3 * (f64::from(k) * 1.3 + 2.1 * j as f64).sin();
                *x = (*x + shift).clamp(-reach, reach);
            }
            assert!(problem.value(&near) >= best - 1e-9, "{norm:?} {reach}");
        }
    }
}
