//! Polynomials on Forsythe's basis, for fits of measured curves.
//!
//! With x the frequency over the highest one and s = i x, the basis obeys
//! s φ_k = b_{k+1} φ_{k+1} − b_k φ_{k−1} and φ_0 = 1 / b_0, the b real: a polynomial Σ c_k φ_k with real c
//! has real coefficients in s.
//!
//! All roots of Σ c_k φ_k are found at once, by the method of Ehrlich and Aberth.
//! Every approximation takes a Newton step that the others, each taken for a root, repel:
//!
//! ```text
//! z_i ← z_i − w_i / (1 − w_i Σ_{j≠i} 1 / (z_i − z_j)),      w_i = p(z_i) / p'(z_i)
//! ```
//!
//! which converges with the third order to simple roots. p and p' come from the recurrence, so that no power
//! coefficient is formed. A root stands when |p| is within the rounding of its own terms. In a sweep over
//! orders, where most roots hardly move from one order to the next, a step or two a root are enough, each
//! O(m); the eigenvalues of the comrade matrix cost O(m³).
//!
//! References: O. Aberth, Math. Comp. 27 (1973) 339-344; D. A. Bini, Numer. Algorithms 13 (1996) 179-200.

use faer::c64;

use crate::linalg::wide::{LANES, total, widest};

// ---- forsythe

/// φ_0 … φ_m at every point, point by point; m is `b.len() - 1`.
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

// ---- roots

/// Iterations after which the eigenvalues are the surer way.
const MOST_ITERATIONS: usize = 60;
/// |p| that is rounding, over the sum of the magnitudes of its terms.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Imaginary parts of real roots, and what the sum of the roots may be off by, over their size.
const REAL: f64 = 1e-12;
const SUM: f64 = 1e-8;

/// Roots of Σ c_k φ_k from approximations, or None where they do not all stand in the end.
///
/// `coefficients` are c_0 … c_m with c_m ≠ 0, `b` b_0 … b_m; `start` may have fewer or more points than
/// there are roots. The roots come in no order.
pub fn refined(coefficients: &[f64], b: &[f64], start: &[c64]) -> Option<Vec<c64>> {
    let order = coefficients.len().checked_sub(1)?;
    let mut z: Vec<c64> = start.iter().copied().take(order).collect();
    // Further ones on an arc, none of them the conjugate of another.
    for i in z.len()..order {
        let angle = 0.7 + 2.4 * i as f64;
        z.push(c64::new(0.8 * angle.cos(), 0.8 * angle.sin()));
    }
    let polynomial = Polynomial { c: coefficients, b, over: b.iter().map(|b| 1.0 / b).collect() };
    let mut active: Vec<usize> = (0..order).collect();
    for _ in 0..MOST_ITERATIONS {
        let steps = newton(&polynomial, &z, &active);
        let mut left = Vec::with_capacity(active.len());
        for (&i, step) in active.iter().zip(steps) {
            if !(step.newton.re.is_finite() && step.newton.im.is_finite()) {
                return None;
            }
            let push = repulsion(&z, i);
            let below = c64::new(1.0, 0.0) - step.newton * push;
            let moved = z[i] - step.newton / below;
            if moved.re.is_finite() && moved.im.is_finite() {
                z[i] = moved;
            } else {
                return None;
            }
            if !step.stands {
                left.push(i);
            }
        }
        active = left;
        if active.is_empty() {
            return sums_up(&z, coefficients, b).then(|| z.iter().map(|&z| on_axis(z)).collect());
        }
    }
    None
}

/// The sum of the roots is the trace of the comrade matrix: none came twice.
fn sums_up(z: &[c64], c: &[f64], b: &[f64]) -> bool {
    let m = z.len();
    let (mut sum, mut size) = (c64::new(0.0, 0.0), 0.0);
    for &z in z {
        sum += z;
        size += z.re.abs() + z.im.abs();
    }
    let trace = if m == 0 { 0.0 } else { -b[m] * c[m - 1] / c[m] };
    (sum - c64::new(trace, 0.0)).l1_norm() <= SUM * (size + trace.abs())
}

/// A root that is real but for rounding.
fn on_axis(z: c64) -> c64 {
    if z.im.abs() <= REAL * z.re.abs() { c64::new(z.re, 0.0) } else { z }
}

struct Polynomial<'a> {
    c: &'a [f64],
    b: &'a [f64],
    /// 1 / b.
    over: Vec<f64>,
}

/// p / p' at one approximation, and whether p is rounding there.
struct Step {
    newton: c64,
    stands: bool,
}

widest!(
    /// Newton steps of the approximations `active`.
    fn newton(polynomial: &Polynomial<'_>, z: &[c64], active: &[usize]) -> Vec<Step> {
        let mut out = Vec::with_capacity(active.len());
        for some in active.chunks(LANES) {
            let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
            for (l, &i) in some.iter().enumerate() {
                (re[l], im[l]) = (z[i].re, z[i].im);
            }
            let (value, slope, terms) = polynomial.at(re, im);
            for l in 0..some.len() {
                let (p, d) = (c64::new(value.0[l], value.1[l]), c64::new(slope.0[l], slope.1[l]));
                out.push(Step { newton: p / d, stands: p.l1_norm() <= ROUNDING * terms[l] });
            }
        }
        out
    }
);

type Lanes = [f64; LANES];

impl Polynomial<'_> {
    /// Values, slopes, and sums of the magnitudes of the terms at points side by side.
    #[inline(always)]
    fn at(&self, re: Lanes, im: Lanes) -> ((Lanes, Lanes), (Lanes, Lanes), Lanes) {
        let zero = [0.0; LANES];
        // φ_{k-1}, φ_k and their slopes.
        let (mut before, mut before_slope) = ((zero, zero), (zero, zero));
        let (mut phi, mut phi_slope) = (([self.over[0]; LANES], zero), (zero, zero));
        let mut value = ([self.c[0] * self.over[0]; LANES], zero);
        let mut slope = (zero, zero);
        let mut terms = [(self.c[0] * self.over[0]).abs(); LANES];
        for k in 0..self.c.len() - 1 {
            let (c, over) = (self.c[k + 1], self.over[k + 1]);
            let b = if k == 0 { 0.0 } else { self.b[k] };
            let (mut next, mut next_slope) = ((zero, zero), (zero, zero));
            for l in 0..LANES {
                next.0[l] = (re[l] * phi.0[l] - im[l] * phi.1[l] + b * before.0[l]) * over;
                next.1[l] = (re[l] * phi.1[l] + im[l] * phi.0[l] + b * before.1[l]) * over;
                next_slope.0[l] = (phi.0[l] + re[l] * phi_slope.0[l] - im[l] * phi_slope.1[l]
                    + b * before_slope.0[l])
                    * over;
                next_slope.1[l] =
                    (phi.1[l] + re[l] * phi_slope.1[l] + im[l] * phi_slope.0[l] + b * before_slope.1[l])
                        * over;
                value.0[l] += c * next.0[l];
                value.1[l] += c * next.1[l];
                slope.0[l] += c * next_slope.0[l];
                slope.1[l] += c * next_slope.1[l];
                terms[l] += c.abs() * (next.0[l].abs() + next.1[l].abs());
            }
            (before, phi) = (phi, next);
            (before_slope, phi_slope) = (phi_slope, next_slope);
        }
        (value, slope, terms)
    }
}

widest!(
    /// Σ_{j≠i} 1 / (z_i − z_j).
    fn repulsion(z: &[c64], i: usize) -> c64 {
        let at = z[i];
        let (low, high) = (inverse_sum(at, &z[..i]), inverse_sum(at, &z[i + 1..]));
        c64::new(low.0 + high.0, low.1 + high.1)
    }
);

#[inline(always)]
fn inverse_sum(at: c64, others: &[c64]) -> (f64, f64) {
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    let (whole, rest) = others.as_chunks::<LANES>();
    for some in whole {
        for l in 0..LANES {
            let (x, y) = (at.re - some[l].re, at.im - some[l].im);
            let over = 1.0 / (x * x + y * y);
            re[l] += x * over;
            im[l] -= y * over;
        }
    }
    let (mut sum_re, mut sum_im) = (total(re), total(im));
    for z in rest {
        let (x, y) = (at.re - z.re, at.im - z.im);
        let over = 1.0 / (x * x + y * y);
        sum_re += x * over;
        sum_im -= y * over;
    }
    (sum_re, sum_im)
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
        assert_eq!(basis_at(&[c64::new(7.0, 1.0)], &[4.0]), [c64::new(0.25, 0.0)]);
        assert!(basis_at(&[], &[4.0, 1.0]).is_empty());
    }

    fn sorted(mut z: Vec<c64>) -> Vec<c64> {
        z.sort_by(|a, b| a.im.total_cmp(&b.im).then(a.re.total_cmp(&b.re)));
        z
    }

    /// With b_k = 1 the basis is φ_2 = s² + 1, φ_3 = s³ + 2 s.
    const B: [f64; 4] = [1.0; 4];

    #[test]
    fn a_pair_and_a_real_root() {
        // (s + 2)(s² + 2 s + 5) = s³ + 4 s² + 9 s + 10 = φ_3 + 4 φ_2 + 7 φ_1 + 6 φ_0.
        let roots = sorted(refined(&[6.0, 7.0, 4.0, 1.0], &B, &[]).unwrap());
        let wanted = [(-1.0, -2.0), (-2.0, 0.0), (-1.0, 2.0)];
        for (root, (re, im)) in roots.iter().zip(wanted) {
            assert!((root - c64::new(re, im)).l1_norm() < 1e-13, "{root}");
        }
        assert_eq!(roots[1].im, 0.0);
    }

    #[test]
    fn approximations_are_kept_in_step() {
        let start = [c64::new(-1.01, 2.0), c64::new(-1.0, -2.02)];
        let from = sorted(refined(&[6.0, 7.0, 4.0, 1.0], &B, &start).unwrap());
        let alone = sorted(refined(&[6.0, 7.0, 4.0, 1.0], &B, &[]).unwrap());
        for (a, b) in from.iter().zip(&alone) {
            assert!((a - b).l1_norm() < 1e-13);
        }
    }

    #[test]
    fn orders_zero_and_one() {
        assert_eq!(refined(&[3.0], &B[..1], &[]), Some(vec![]));
        let root = refined(&[3.0, 2.0], &B[..2], &[]).unwrap();
        assert!((root[0] - c64::new(-1.5, 0.0)).l1_norm() < 1e-15);
        assert_eq!(refined(&[], &[], &[]), None);
    }

    #[test]
    fn what_does_not_stand_is_given_up() {
        assert_eq!(refined(&[f64::NAN, 1.0], &B[..2], &[]), None);
        // Two approximations in one place repel each other without end.
        let twice = [c64::new(1.0, 1.0); 2];
        assert_eq!(refined(&[6.0, 7.0, 4.0, 1.0], &B, &twice), None);
    }
}
