use super::*;

fn bounds_of(a: &Mat<f64>, b: &Mat<f64>, roots: &[f64]) -> Vec<Bounded> {
    RootBounds::of(a, b).places(roots)
}

#[test]
fn a_simple_root_is_placed_and_bounded() {
    let a = Mat::from_fn(3, 3, |i, j| {
        [[2.0, 1.0, 0.0], [0.0, 5.0, 1.0], [0.0, 0.0, 9.0]][i][j]
    });
    let identity = Mat::<f64>::identity(3, 3);
    for (given, want) in [(2.0 + 1e-9, 2.0), (5.0, 5.0), (9.0 - 1e-5, 9.0)] {
        let placed = bounds_of(&a, &identity, &[given])[0];
        assert!((placed.x - want).abs() <= placed.bound);
        assert!(placed.bound < 1e-12, "{placed:?}");
    }
}

#[test]
fn where_there_is_no_root_there_is_no_bound() {
    // Roots 1 and a complex pair.
    let a = Mat::from_fn(3, 3, |i, j| {
        [[1.0, 0.0, 0.0], [0.0, 4.0, 1.0], [0.0, -1.0, 4.0]][i][j]
    });
    let identity = Mat::<f64>::identity(3, 3);
    for x in [4.0, 2.5, 30.0] {
        assert!(bounds_of(&a, &identity, &[x])[0].bound.is_infinite());
    }
}

#[test]
fn a_double_root_is_bounded_by_its_vectors() {
    let identity = Mat::<f64>::identity(3, 3);
    for (coupling, least, most) in [(0.0, 0.0, 1e-13), (1.0, 1e-9, 1e-6)] {
        let rows = [[4.0, coupling, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 7.0]];
        let a = Mat::from_fn(3, 3, |i, j| rows[i][j]);
        let both = bounds_of(&a, &identity, &[4.0, 4.0]);
        for placed in both {
            assert!((placed.x - 4.0).abs() <= placed.bound);
            assert!(least < placed.bound && placed.bound < most, "{placed:?}");
        }
    }
}
