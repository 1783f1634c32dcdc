use super::*;

#[test]
fn a_weak_link_on_which_the_determinant_hangs_becomes_one() {
    // Two rows share the first two columns but for 1e-18: no scale of rows by their largest entries finds it.
    let weak = 2.0_f64.powi(-60);
    let rows = [[1.0, 2.0, 0.0], [1.0, 2.0, weak], [weak, 3.0, 1.0]];
    let a = Mat::from_fn(3, 3, |i, j| if (i, j) == (1, 1) { 0.0 } else { rows[i][j] });
    let scaled = Equilibrated::of(&a, &Mat::zeros(3, 3));
    assert!(scaled.a.norm_max() <= 2.0);
    let at_least = |v: f64| v.abs() > 0.2;
    for i in 0..3 {
        assert!((0..3).any(|j| at_least(scaled.a[(i, j)])));
        assert!((0..3).any(|j| at_least(scaled.a[(j, i)])));
    }
}

#[test]
fn units_are_taken_out() {
    let d = [1e-9, 1.0, 1e12];
    let a = Mat::from_fn(3, 3, |i, j| d[i] * d[j] * (1.0 + (i + 2 * j) as f64 % 3.0));
    let scaled = Equilibrated::of(&a, &a);
    assert!(scaled.is_graded);
    for i in 0..3 {
        for j in 0..3 {
            assert!(
                (0.05..=4.0).contains(&scaled.a[(i, j)]),
                "{}",
                scaled.a[(i, j)]
            );
        }
    }
}

#[test]
fn zeros_that_leave_no_permutation_leave_all_as_it_is() {
    let a = Mat::from_fn(3, 3, |i, _| if i == 1 { 0.0 } else { 1e12 });
    let scaled = Equilibrated::of(&a, &a);
    assert!(!scaled.is_graded && scaled.a == a);
    let empty = Mat::<f64>::zeros(0, 0);
    assert!(!Equilibrated::of(&empty, &empty).is_graded);
}
