use super::*;

/// Matrix of the entries (row, column), row >= column, within the band.
fn filled(n: usize, band: usize, entry: impl Fn(usize, usize) -> f64) -> Banded {
    let mut a = Banded::new(n, band);
    for j in 0..n {
        for i in j..n.min(j + band + 1) {
            a.set(i, j, entry(i, j));
        }
    }
    a
}

fn laplacian(n: usize, half: usize) -> Banded {
    filled(n, half, |i, j| match i - j {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    })
}

#[test]
fn solve_undoes_multiply() {
    let (n, half) = (17, 8);
    let mut a = filled(n, 6, |i, j| {
        if i == j {
            9.0
        } else {
            ((3 * i + 5 * j) as f64).sin()
        }
    });
    assert_eq!(a.half(), half);
    let mut x = vec![0.0; n + half];
    for (i, v) in x[..n].iter_mut().enumerate() {
        *v = (i as f64).cos();
    }
    let mut y = vec![0.0; n + half];
    a.multiply(&x, &mut y);
    y[n..].fill(0.0);
    assert!(a.factorize_definite(1e-3));
    a.solve(&mut y);
    for (got, want) in y.iter().zip(&x) {
        assert!((got - want).abs() < 1e-14);
    }
}

#[test]
fn the_count_is_that_of_the_closed_form() {
    // 2 − 2 cos(j π / (n + 1)) for the fixed-fixed chain.
    let n = 30;
    let k = laplacian(n, 3);
    let m = filled(n, 3, |i, j| f64::from(u8::from(i == j)));
    let mut work = Banded::new(n, 3);
    for step in 1..60 {
        let x = 0.0671 * f64::from(step);
        let want = (1..=n)
            .filter(|&j| 2.0 - 2.0 * (j as f64 * std::f64::consts::PI / (n + 1) as f64).cos() < x)
            .count();
        work.combine(&k, -x, &m);
        let (got, growth) = work.factorize();
        assert!(got == want && growth < 1e5, "{x} {growth}");
    }
}

#[test]
fn an_indefinite_matrix_is_told() {
    let mut a = laplacian(6, 2);
    let b = laplacian(6, 2);
    a.combine(&b, -2.0, &b);
    assert!(!a.factorize_definite(0.0));
}
