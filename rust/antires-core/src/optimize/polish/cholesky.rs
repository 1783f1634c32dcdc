//! Cholesky factor of a small dense matrix, A = L Lᵀ: a step has as many unknowns as there are genes.

/// L of a positive definite matrix L Lᵀ, row by row.
pub(super) struct Factor {
    n: usize,
    l: Vec<f64>,
}

impl Factor {
    /// Factor of the n x n matrix whose lower triangle is given, row by row; `None` where it is not
    /// positive definite at working precision.
    pub(super) fn of(mut a: Vec<f64>, n: usize) -> Option<Self> {
        for j in 0..n {
            for i in j..n {
                let done: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
                let rest = a[i * n + j] - done;
                a[i * n + j] = if i > j {
                    rest / a[j * n + j]
                } else if rest > 0.0 && rest.is_finite() {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Self { n, l: a })
    }

    /// A⁻¹ b in place of b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let (n, l) = (self.n, &self.l);
        for i in 0..n {
            let done: f64 = (0..i).map(|k| l[i * n + k] * b[k]).sum();
            b[i] = (b[i] - done) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
            b[i] = (b[i] - done) / l[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_solves_and_refuses_what_is_not_positive_definite() {
        // Rows of a 3 x 3 matrix, its upper triangle ignored.
        let a = vec![4.0, 9.0, 9.0, 2.0, 5.0, 9.0, -2.0, 1.0, 6.0];
        let mut b = [4.0 + 4.0 - 6.0, 2.0 + 10.0 + 3.0, -2.0 + 2.0 + 18.0];
        Factor::of(a, 3).unwrap().solve(&mut b);
        for (x, expected) in b.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - expected).abs() < 1e-14, "{b:?}");
        }
        assert!(Factor::of(vec![1.0, 0.0, 2.0, 1.0], 2).is_none());
        assert!(Factor::of(vec![f64::NAN], 1).is_none());
    }
}
