//! No root beyond the last pole: a certificate in O(n²).
//!
//! For x > λ_n, the identity 1/(x − λ) = 1/(x − μ) · (1 + (λ − μ)/(x − λ)), applied with
//! μ = λ_1, λ_2, ... in turn, turns the partial fractions into
//!
//! ```text
//! −f(x) = Σ_r c_r / (x − λ_r) = Σ_j D_j / Π_{i<=j} (x − λ_i),    D_j = Σ_{r>=j} c_r Π_{i<j} (λ_r − λ_i)
//! ```
//!
//! in which every product is positive. If the D_j that exceed their rounding have one sign, f has no
//! root there that survives rounding. (D_1 = Σ c = (M⁻¹)_ik and the next moments vanish when i and k
//! are far apart in a lumped chain: the small sums are left out of the vote.)

use crate::modal::receptance::Receptance;

/// True when `h` is proved to have no root above its last pole. False means "not proved".
pub fn is_rootless(h: &Receptance, scratch: &mut Vec<f64>) -> bool {
    if h.constant != 0.0 {
        return false;
    }
    let n = h.poles.len();
    // The first n entries hold c_r Π (λ_r − λ_i), the others their error, both up to a common scale.
    scratch.clear();
    scratch.extend_from_slice(&h.residues);
    scratch.resize(2 * n, h.residue_error);
    let (terms, errors) = scratch.split_at_mut(n);
    let span = h.poles[n - 1] - h.poles[0];
    let mut vote = 0.0_f64;
    for j in 0..n {
        let (mut sum, mut error) = (0.0, 0.0);
        for r in j..n {
            sum += terms[r];
            error += errors[r];
            // Relative to the span, the products stay in the range of doubles.
            let factor = (h.poles[r] - h.poles[j]) / span;
            terms[r] *= factor;
            errors[r] *= factor;
        }
        if sum.abs() > error {
            if sum * vote < 0.0 {
                return false;
            }
            vote = sum;
        }
    }
    vote != 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receptance(poles: &[f64], residues: &[f64]) -> Receptance {
        Receptance {
            poles: poles.to_vec(),
            residues: residues.to_vec(),
            residue_error: 1e-16,
            ..Receptance::default()
        }
    }

    #[test]
    fn proves_what_is_rootless_and_nothing_else() {
        let mut scratch = Vec::new();
        assert!(is_rootless(
            &receptance(&[1.0, 2.0], &[0.5, 0.5]),
            &mut scratch
        ));
        assert!(is_rootless(
            &receptance(&[1.0, 2.0], &[-1.0, 1.0]),
            &mut scratch
        ));
        // −1.5/(1−x) + 1/(2−x) vanishes at x = 4.
        let crossing = receptance(&[1.0, 2.0], &[-1.5, 1.0]);
        assert_eq!(crossing.value(4.0), 0.0);
        assert!(!is_rootless(&crossing, &mut scratch));
    }
}
