use faer::Side;

use super::super::pattern::Pattern;
use super::*;

/// A grid of `m` by `m` points, each joined to its neighbours, `shift` taken from the diagonal.
fn grid(m: usize, shift: f64) -> SparseMatrix {
    let at = |x: usize, y: usize| (x * m + y) as u32;
    let mut places = Vec::new();
    for x in 0..m {
        for y in 0..m {
            if x + 1 < m {
                places.push((at(x, y), at(x + 1, y)));
            }
            if y + 1 < m {
                places.push((at(x, y), at(x, y + 1)));
            }
        }
    }
    let mut a = SparseMatrix::new(Arc::new(Pattern::new(m * m, places.iter().copied())));
    for &(i, j) in &places {
        let value = -1.0 - 0.1 * (f64::from(i) + 2.0 * f64::from(j)).sin();
        for (i, j) in [(i, j), (j, i)] {
            a.add(i as usize, j as usize, value);
            a.add(i as usize, i as usize, -value);
        }
    }
    for j in 0..m * m {
        a.add(j, j, 0.1 - shift);
    }
    a
}

fn factors(a: &SparseMatrix) -> (SparseFactors, SparseMatrix) {
    let symbolic = Arc::new(Symbolic::new(a.pattern()).unwrap());
    let mut moved = SparseMatrix::new(Arc::clone(symbolic.pattern()));
    for (value, &at) in moved.values.iter_mut().zip(symbolic.origin()) {
        *value = a.values[at];
    }
    (SparseFactors::new(symbolic), moved)
}

#[test]
fn solutions_of_definite_and_indefinite_matrices_meet_the_load() {
    for (shift, m) in [(0.0, 1), (0.0, 2), (0.0, 17), (0.73, 17), (3.1, 12)] {
        let (mut factors, a) = factors(&grid(m, shift));
        let (_, growth) = factors.factorize(&a);
        assert!(growth < 1e4, "{growth}");
        let load: Vec<f64> = (0..m * m).map(|j| (1.7 * j as f64).cos()).collect();
        let (mut x, mut back) = (load.clone(), load.clone());
        factors.solve(&mut x);
        a.multiply(&x, &mut back);
        let size = x.iter().fold(1.0_f64, |s, x| s.max(x.abs()));
        for (b, l) in back.iter().zip(&load) {
            assert!((b - l).abs() < 1e-13 * growth * size, "{b} {l}");
        }
    }
}

#[test]
fn negative_pivots_count_the_eigenvalues_below_the_shift() {
    let whole = grid(13, 0.0).to_dense();
    let values = whole.self_adjoint_eigenvalues(Side::Lower).unwrap();
    for shift in [0.05, 0.5, 1.234, 3.3, 9.0] {
        let (mut factors, a) = factors(&grid(13, shift));
        let (negative, growth) = factors.factorize(&a);
        assert!(growth < 1e6);
        assert_eq!(negative, values.iter().filter(|&&v| v < shift).count());
    }
}

#[test]
fn a_pivot_of_zero_is_told() {
    let mut a = SparseMatrix::new(Arc::new(Pattern::new(2, [(1, 0)].into_iter())));
    a.add(0, 1, 1.0);
    a.add(1, 0, 1.0);
    let (mut factors, a) = factors(&a);
    assert_eq!(factors.factorize(&a), (0, f64::INFINITY));
}
