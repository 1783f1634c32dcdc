use super::*;

fn sample() -> SparseMatrix {
    let pattern = Arc::new(Pattern::new(4, [(1, 0), (3, 1), (3, 2)].into_iter()));
    let mut a = SparseMatrix::new(pattern);
    for (i, j, v) in [(1, 0, -2.0), (3, 1, 0.5), (3, 2, 4.0)] {
        a.add(i, j, v);
        a.add(j, i, v);
    }
    for j in 0..4 {
        a.add(j, j, 1.0 + j as f64);
    }
    a
}

#[test]
fn products_and_forms_are_those_of_the_dense_matrix() {
    let (a, dense) = (sample(), sample().to_dense());
    let (w, u) = ([1.0, -2.0, 0.5, 3.0], [0.3, 1.0, -1.0, 2.0]);
    let mut y = [0.0; 4];
    a.multiply(&u, &mut y);
    let (mut absolute, mut squared) = (0.0, 0.0);
    for i in 0..4 {
        let want: f64 = (0..4).map(|j| dense[(i, j)] * u[j]).sum();
        assert!((y[i] - want).abs() < 1e-15);
        for j in 0..4 {
            absolute += (u[i] * dense[(i, j)] * u[j]).abs();
            squared += (w[i] * dense[(i, j)] * u[j]).powi(2);
        }
    }
    assert!((a.absolute_form(&u) - absolute).abs() < 1e-13);
    assert!((a.squared_form(&w, &u) - squared).abs() < 1e-12);
}

#[test]
fn a_row_and_a_column_can_be_left_out() {
    let (a, dense) = (sample(), sample().to_dense());
    let left = a.deleted(1, 3);
    for (r, i) in [0, 2, 3].into_iter().enumerate() {
        for (c, j) in [0, 1, 2].into_iter().enumerate() {
            assert_eq!(left[(r, c)], dense[(i, j)]);
        }
    }
}
