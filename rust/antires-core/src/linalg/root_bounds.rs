//! How far a root of a pencil A − xB may be from that of the matrices as given.
//!
//! ```text
//! δ = yᵀ(A − xB)v / yᵀBv        its place, by two-sided Rayleigh quotients
//! ε = c eps |y|ᵀ(|A| + x|B|)|v| / |yᵀBv|        how far rounding may have moved that
//! ```
//!
//! with right and left null vectors v, y from inverse iteration. The first-order bound is ε with c = 16 + n, and what
//! v leaves over of (A − xB)v: it covers the rounding of the products, and the change of the root by some ulp of each
//! entry of K and M. It says nothing where it is not small: then the root is not certain.
//!
//! Roots whose bounds overlap are taken together: with bases V, Y of their deflating subspaces all of them are
//! eigenvalues of G⁻¹E + Δ, E = Yᵀ(A − xB)V, G = YᵀBV, |Δ| <= |G⁻¹| c eps |Y|ᵀ(|A| + x|B|)|V|. For each p
//!
//! ```text
//! |λ|^p <= ‖(G⁻¹E)^p‖ + ‖(|G⁻¹E| + |Δ|)^p − |G⁻¹E|^p‖
//! ```
//!
//! so that a double root with one vector is known to the root of rounding, one with two as well as a simple one.
//!
//! Reference: G. W. Stewart & J. Sun, Matrix Perturbation Theory, 1990, VI.2.2.

use faer::prelude::Solve;
use faer::{Mat, Scale};

use super::equilibrated::Equilibrated;

/// Relative bound in x from which on a root is not certain.
pub const UNCERTAIN: f64 = 1e-3;

/// Most steps of an iteration, and solutions in each.
const STEPS: usize = 8;
const SOLUTIONS: usize = 2;
const MORE_SOLUTIONS: usize = 5;

/// Relative distances from a root at which the pencil is factorized, and from several.
const ON_ROOT: [f64; 3] = [0.0, 4.0 * f64::EPSILON, -16.0 * f64::EPSILON];
const BESIDE_ROOTS: [f64; 3] = [1e-6, -3e-6, 1e-5];

/// Relative distance within which roots are taken together of which one alone has no bound.
const TOGETHER: f64 = 1e-5;

/// Ulps of each product that count, beside one for each row.
const ULPS: f64 = 16.0;

/// Residual of a null vector, relative to the scaled pencil.
const NULL_VECTOR: f64 = 1e-9;

/// Farthest that the root of the matrices may be from the one given, relatively.
const FARTHEST: f64 = 1e-2;

/// Largest number of roots that are taken together.
const MOST_TOGETHER: usize = 60;

/// A pencil whose roots are known.
pub struct RootBounds {
    a: Mat<f64>,
    b: Mat<f64>,
}

/// A root on the matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// Where it is.
    pub x: f64,
    /// How far a root may be from there; infinite where that is not known.
    pub bound: f64,
}

impl RootBounds {
    /// Of the pencil A − xB.
    #[must_use]
    pub fn of(a: &Mat<f64>, b: &Mat<f64>) -> Self {
        let Equilibrated { a, b, .. } = Equilibrated::of(a, b);
        Self { a, b }
    }

    /// The place of each of `roots`, ascending in x, on the matrices, and how far a root of its own may be from there;
    /// infinite where that is not known.
    #[must_use]
    pub fn places(&self, roots: &[f64]) -> Vec<Bounded> {
        let places: Vec<Bounded> = roots.iter().map(|&x| self.place(x)).collect();
        let apart = |j: usize| {
            let (p, q) = (places[j], places[j + 1]);
            let apart = if p.bound.is_finite() && q.bound.is_finite() {
                2.0 * (p.bound + q.bound)
            } else {
                TOGETHER * q.x
            };
            q.x - p.x > apart
        };
        let mut out = Vec::with_capacity(roots.len());
        let mut first = 0;
        for last in 0..roots.len() {
            if last + 1 < roots.len() && !apart(last) {
                continue;
            }
            if first == last {
                out.push(places[last]);
            } else {
                out.extend(self.together(&roots[first..=last]));
            }
            first = last + 1;
        }
        out
    }

    /// The root next to `x`.
    fn place(&self, x: f64) -> Bounded {
        let mut at = x;
        for _ in 0..STEPS {
            let Some(block) = self.block(at, 1) else {
                break;
            };
            let slope = block.slope[(0, 0)];
            let (step, bound) = (
                block.force[(0, 0)] / slope,
                block.rounding[(0, 0)] / slope.abs(),
            );
            at += step;
            // NaN is no root.
            if !((at - x).abs() <= FARTHEST * x && bound <= UNCERTAIN * x) {
                break;
            }
            if step.abs() <= bound {
                if block.residual <= NULL_VECTOR {
                    return Bounded { x: at, bound };
                }
                break;
            }
        }
        Bounded {
            x,
            bound: f64::INFINITY,
        }
    }

    /// Roots that lie closer together than their own bounds.
    fn together(&self, roots: &[f64]) -> Vec<Bounded> {
        let m = roots.len();
        let middle = roots.iter().sum::<f64>() / m as f64;
        let radius = if m <= MOST_TOGETHER {
            self.block(middle, m).map(|block| block.radius())
        } else {
            None
        };
        let radius = radius
            .filter(|r| *r <= UNCERTAIN * middle)
            .unwrap_or(f64::INFINITY);
        let bounded = |&x: &f64| Bounded {
            x,
            bound: radius + (x - middle).abs(),
        };
        roots.iter().map(bounded).collect()
    }

    /// What the `m` vectors next to `x` tell on either side.
    fn block(&self, x: f64, m: usize) -> Option<Block> {
        let n = self.a.nrows();
        // Where x is a root to the last digit, a pivot vanishes; of several roots the farther ones need some distance.
        let nudges = if m == 1 { ON_ROOT } else { BESIDE_ROOTS };
        for nudge in nudges {
            let at = x * (1.0 + nudge);
            let lu = (&self.a - Scale(at) * &self.b).partial_piv_lu();
            let mut right = Mat::from_fn(n, m, |i, j| {
                1.0 + 0.3 * (1.7 * (i + 1) as f64 * (j + 1) as f64).sin()
            });
            let mut left = right.clone();
            for round in 0..(if m == 1 { SOLUTIONS } else { MORE_SOLUTIONS }) {
                if m > 1 && round > 0 {
                    right = &self.b * &right;
                    left = self.b.transpose() * &left;
                }
                right = lu.solve(&right);
                orthonormalize(&mut right);
                left = lu.solve_transpose(&left);
                orthonormalize(&mut left);
            }
            let finite = |a: &Mat<f64>| a.norm_l2().is_finite();
            if !(finite(&right) && finite(&left)) {
                continue;
            }
            let shifted = &self.a - Scale(x) * &self.b;
            let image = &shifted * &right;
            let inertia = &self.b * &right;
            let force = left.transpose() * &image;
            let slope = left.transpose() * &inertia;
            let known = slope.partial_piv_lu().solve(&force);
            let sizes = Mat::from_fn(n, n, |i, j| {
                self.a[(i, j)].abs() + x.abs() * self.b[(i, j)].abs()
            });
            let rounding = Scale((ULPS + n as f64) * f64::EPSILON) * (&sizes * modulus(&right));
            // Of two roots in one, the vectors are a mixture: what they leave over tells.
            let left_over = modulus(&(&image - &inertia * &known));
            return Some(Block {
                rounding: modulus(&left).transpose() * (rounding + left_over),
                residual: image.norm_l2() / sizes.norm_l2(),
                force,
                slope,
            });
        }
        None
    }
}

fn modulus(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs())
}

/// Projections of the pencil on its null vectors.
struct Block {
    /// Yᵀ(A − xB)V.
    force: Mat<f64>,
    /// YᵀBV.
    slope: Mat<f64>,
    /// c eps |Y|ᵀ(|A| + x|B|)|V| + |Y|ᵀ|(A − xB)V − BV G⁻¹E|.
    rounding: Mat<f64>,
    /// ‖(A − xB)V‖ relative to the pencil.
    residual: f64,
}

impl Block {
    /// How far from x all roots of the block are; NaN where their vectors do not tell.
    fn radius(&self) -> f64 {
        let m = self.slope.nrows();
        let inverse = self
            .slope
            .partial_piv_lu()
            .solve(Mat::<f64>::identity(m, m));
        let known = &inverse * &self.force;
        let error = modulus(&inverse) * &self.rounding;
        let sizes = modulus(&known);
        let widened = &sizes + &error;
        let (mut power, mut least, mut most) = (known.clone(), sizes.clone(), widened.clone());
        let mut radius = f64::NAN;
        for p in 1..=m {
            let whole = power.norm_l2() + (&most - &least).norm_l2();
            radius = radius.min(whole.powf(1.0 / p as f64));
            power = &power * &known;
            least = &least * &sizes;
            most = &most * &widened;
        }
        radius
    }
}

/// Gram-Schmidt, twice.
fn orthonormalize(vectors: &mut Mat<f64>) {
    for j in 0..vectors.ncols() {
        for _ in 0..2 {
            for p in 0..j {
                let part: f64 = vectors.col(p).transpose() * vectors.col(j);
                for i in 0..vectors.nrows() {
                    vectors[(i, j)] -= part * vectors[(i, p)];
                }
            }
            let size = vectors.col(j).norm_l2().recip();
            for i in 0..vectors.nrows() {
                vectors[(i, j)] *= size;
            }
        }
    }
}

#[cfg(test)]
mod tests;
