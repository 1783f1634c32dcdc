use super::*;

fn of(stiffness: &[f64], mass: &[f64]) -> Option<Balance> {
    Balance::of(mass.len(), |j| (stiffness[j], mass[j]))
}

#[test]
fn what_is_alike_is_left_alone() {
    assert_eq!(of(&[1.0, 1e4, 0.0], &[1e-3, 2.0, 0.0]), None);
    assert_eq!(of(&[0.0], &[0.0]), None);
}

#[test]
fn units_of_dofs_and_of_matrices_are_taken_out() {
    let d = [1e-9, 1.0, 1e12];
    let diagonal = |by: f64| d.map(|d| by * d * d).to_vec();
    for (k, m) in [(3.0, 2.0), (3e250, 2e-250), (3e-270, 1.0)] {
        let (stiffness, mass) = (diagonal(k), diagonal(m));
        if stiffness.iter().any(|v| v.is_infinite() || *v < 1e-300) {
            continue;
        }
        let balance = of(&stiffness, &mass).unwrap();
        for j in 0..3 {
            let (k, m) = (
                balance.stiffness_entry(j, j, stiffness[j]),
                balance.mass_entry(j, j, mass[j]),
            );
            assert!(k > 0.1 && k < 10.0 && m > 0.01 && m < 10.0, "{k} {m}");
            let wanted = stiffness[j] / mass[j];
            if wanted.is_finite() {
                let back = balance.eigenvalue(k / m);
                assert!((back / wanted - 1.0).abs() < 1e-15);
            }
        }
        let one = balance.frequency(balance.scaled_frequency(3.7));
        assert_eq!(one, 3.7);
    }
}

#[test]
fn a_stiff_spring_leaves_the_others_their_digits() {
    let balance = of(&[2.0, 1e20, 2.0], &[1.0; 3]).unwrap();
    assert!((0.25..=4.0).contains(&balance.stiffness_entry(0, 0, 2.0)));
    assert!(balance.stiffness_entry(1, 1, 1e20) < 4.0);
    assert!(balance.mass_entry(1, 1, 1.0) < 1e-19);
}
