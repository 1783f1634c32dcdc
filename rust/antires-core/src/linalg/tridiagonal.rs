//! Eigenvalues and eigenvectors of a small symmetric tridiagonal matrix, by the implicit QL iteration.
//!
//! Plane rotations chase the bulge of a Wilkinson-shifted QL step from the bottom of each unreduced block
//! to its top; they are applied to the columns of `vectors` as they come.
//!
//! Reference: Parlett, The Symmetric Eigenvalue Problem (1998), ch. 8.

use crate::linalg::wide::NullaryFnOnce;

use super::wide;

/// QL steps allowed for one eigenvalue; two or three are usual.
const MOST_STEPS: usize = 60;

/// Entries off the diagonal below this, relative to the largest, are zero: their squares would underflow.
const NOTHING: f64 = 1e-100;

/// Replaces `diagonal` by the eigenvalues (in no order), `off` (one shorter, or with a last entry that is
/// not read) by rubbish, and multiplies `vectors` from the right by the orthogonal matrix of eigenvectors;
/// its columns of `rows` entries follow one another. False when an eigenvalue does not converge.
#[must_use]
pub fn decompose(diagonal: &mut [f64], off: &mut [f64], vectors: &mut [f64], rows: usize) -> bool {
    let largest = diagonal
        .iter()
        .chain(off.iter())
        .fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest == 0.0;
    }
    // A power of two, which rounds nothing: squares then neither overflow nor underflow where it matters.
    let scale = largest.log2().round().exp2();
    diagonal
        .iter_mut()
        .chain(off.iter_mut())
        .for_each(|x| *x /= scale);
    let converged = wide::run(Iteration {
        diagonal: &mut *diagonal,
        off,
        vectors,
        rows,
    });
    for x in diagonal {
        *x *= scale;
    }
    converged
}

/// The QL steps of [`decompose`].
struct Iteration<'a> {
    diagonal: &'a mut [f64],
    off: &'a mut [f64],
    vectors: &'a mut [f64],
    rows: usize,
}

impl NullaryFnOnce for Iteration<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let Self {
            diagonal,
            off,
            vectors,
            rows,
        } = self;
        let n = diagonal.len();
        for top in 0..n {
            let mut steps = 0;
            loop {
                let bottom = (top..n - 1)
                    .find(|&j| {
                        let near = diagonal[j].abs() + diagonal[j + 1].abs();
                        off[j].abs() <= 0.5 * f64::EPSILON * near + NOTHING
                    })
                    .unwrap_or(n - 1);
                if bottom == top {
                    break;
                }
                if steps == MOST_STEPS {
                    return false;
                }
                steps += 1;
                step(diagonal, off, vectors, rows, top, bottom);
            }
        }
        true
    }
}

/// One shifted QL step on the unreduced block top..=bottom.
#[inline(always)]
fn step(d: &mut [f64], e: &mut [f64], vectors: &mut [f64], rows: usize, top: usize, bottom: usize) {
    let half_gap = 0.5 * (d[top + 1] - d[top]) / e[top];
    let radius = (half_gap * half_gap + 1.0).sqrt().copysign(half_gap);
    // Distance of the last diagonal entry from the eigenvalue of the leading pair that is nearer to d[top].
    let mut g = d[bottom] - d[top] + e[top] / (half_gap + radius);
    let (mut sine, mut cosine, mut moved) = (1.0, 1.0, 0.0);
    for j in (top..bottom).rev() {
        let f = sine * e[j];
        let b = cosine * e[j];
        let r = (f * f + g * g).sqrt();
        if bottom > j + 1 {
            e[j + 1] = r;
        }
        if r == 0.0 {
            // The block falls apart here: what was moved is taken back, and the parts are done in turn.
            d[j + 1] -= moved;
            return;
        }
        let inverse = r.recip();
        (sine, cosine) = (f * inverse, g * inverse);
        let lower = d[j + 1] - moved;
        let turn = (d[j] - lower) * sine + 2.0 * cosine * b;
        moved = sine * turn;
        d[j + 1] = lower + moved;
        g = cosine * turn - b;
        let (left, right) = vectors[j * rows..(j + 2) * rows].split_at_mut(rows);
        for (u, v) in left.iter_mut().zip(right) {
            let (x, y) = (*u, *v);
            *v = sine * x + cosine * y;
            *u = cosine * x - sine * y;
        }
    }
    d[top] -= moved;
    e[top] = g;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(diagonal: &[f64], off: &[f64]) -> Vec<f64> {
        let n = diagonal.len();
        let (mut d, mut e) = (diagonal.to_vec(), off.to_vec());
        let mut v = vec![0.0; n * n];
        for j in 0..n {
            v[j * n + j] = 1.0;
        }
        assert!(decompose(&mut d, &mut e, &mut v, n));
        let scale = diagonal
            .iter()
            .chain(off)
            .fold(1e-300_f64, |m, x| m.max(x.abs()));
        for j in 0..n {
            let y = &v[j * n..(j + 1) * n];
            for i in 0..n {
                let mut r = (diagonal[i] - d[j]) * y[i];
                if i > 0 {
                    r += off[i - 1] * y[i - 1];
                }
                if i + 1 < n {
                    r += off[i] * y[i + 1];
                }
                assert!(r.abs() <= 1e-14 * n as f64 * scale, "{r}");
            }
            for k in 0..=j {
                let dot: f64 = y.iter().zip(&v[k * n..]).map(|(a, b)| a * b).sum();
                assert!((dot - f64::from(u8::from(k == j))).abs() < 1e-14 * n as f64);
            }
        }
        d.sort_by(f64::total_cmp);
        d
    }

    #[test]
    fn the_chain_has_its_closed_form() {
        let n = 40;
        let got = check(&vec![2.0; n], &vec![-1.0; n - 1]);
        for (j, l) in got.iter().enumerate() {
            let want = 2.0 - 2.0 * ((j + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            assert!((l - want).abs() < 1e-14);
        }
    }

    #[test]
    fn split_graded_and_single_matrices_are_solved() {
        check(&[3.0], &[]);
        check(&[1.0, 1.0, 1.0], &[0.0, 0.0]);
        check(&[1.0, 2.0, 3.0, 4.0], &[0.5, 0.0, 0.5]);
        check(&[0.0, 0.0], &[1.0]);
        let graded: Vec<f64> = (0..20).map(|j| 10.0_f64.powi(-j)).collect();
        check(
            &graded,
            &graded[1..].iter().map(|x| 0.3 * x).collect::<Vec<_>>(),
        );
    }
}
