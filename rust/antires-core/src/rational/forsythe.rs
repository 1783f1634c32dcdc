//! The basis at complex points.

use faer::c64;

/// φ_0 … φ_m at every point, point by point; m is `b.len() - 1`.
#[must_use]
pub fn basis_at(points: &[c64], b: &[f64]) -> Vec<c64> {
    let terms = b.len();
    let mut out = vec![c64::new(0.0, 0.0); points.len() * terms];
    for (s, phi) in points.iter().zip(out.chunks_exact_mut(terms)) {
        phi[0] = c64::new(1.0 / b[0], 0.0);
        if terms > 1 {
            phi[1] = c64::new(s.re * phi[0].re / b[1], s.im * phi[0].re / b[1]);
        }
        for k in 1..terms - 1 {
            let (one, before) = (phi[k], phi[k - 1]);
            phi[k + 1] = c64::new(
                (s.re * one.re - s.im * one.im + b[k] * before.re) / b[k + 1],
                (s.re * one.im + s.im * one.re + b[k] * before.im) / b[k + 1],
            );
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recurrence_by_hand() {
        let b = [0.5, 2.0, 4.0];
        let s = c64::new(1.0, 3.0);
        let phi = basis_at(&[s], &b);
        // φ_1 = s φ_0 / b_1 and φ_2 = (s φ_1 + b_1 φ_0) / b_2.
        assert_eq!(phi[0], c64::new(2.0, 0.0));
        assert_eq!(phi[1], c64::new(1.0, 3.0));
        assert_eq!(phi[2], c64::new(-1.0, 1.5));
    }

    #[test]
    fn a_constant_alone() {
        assert_eq!(
            basis_at(&[c64::new(7.0, 1.0)], &[4.0]),
            [c64::new(0.25, 0.0)]
        );
        assert!(basis_at(&[], &[4.0, 1.0]).is_empty());
    }
}
