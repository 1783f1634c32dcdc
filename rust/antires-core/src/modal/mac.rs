//! Modal assurance criterion of a measured shape, complex and known at few dofs, with a computed one.
//!
//! ```text
//! MAC = |φ_Eᴴ φ_A|² / (φ_Eᴴφ_E φ_Aᵀφ_A)            sums over the measured dofs
//! dMAC/dφ_A = 2 (a (aᵀφ_A) + b (bᵀφ_A) − MAC φ_A) / φ_Aᵀφ_A,        φ_E = a + jb, φ_Eᴴφ_E = 1
//! ```
//!
//! One for the same shape up to a factor, which may be complex; zero for orthogonal ones.
//!
//! Source: R. J. Allemang & D. L. Brown, A correlation coefficient for modal vector analysis, Proc. IMAC 1
//! (1982) 110-116.
//!
//! # mode_sensitivities
//!
//! How a mode moves with the model: its eigenvalue, and the MAC of its shape with a measured one.
//!
//! ```text
//! dλ/dp   = φᵀ (dK/dp − λ dM/dp) φ
//! dMAC/dp = −zᵀ (dK/dp − λ dM/dp) φ,      (K − λM) z = dMAC/dφ,  zᵀMφ = 0
//! ```
//!
//! The second is [`LowModes::adjoint`]. MAC does not see the size of φ, so its normalisation does not matter.
//!
//! Source: R. L. Fox & M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA J. 6 (1968)
//! 2426-2429; R. B. Nelson, AIAA J. 14 (1976) 1201-1205.

use super::modes::LowModes;
use super::solved::Solved;
use crate::error::{Error, Result};
use crate::fem::assembly::MatrixSlopes;

/// A computed shape whose part at the measured dofs is below this, relative to its largest entry, is at rest
/// there: what is left is rounding.
const AT_REST: f64 = 1e-12;

/// A measured shape, of unit length.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    dofs: Vec<usize>,
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl Shape {
    /// The shape with entries (real, imaginary) at the dofs of a model.
    pub fn new(argument: &str, dofs: Vec<usize>, entries: &[(f64, f64)]) -> Result<Self> {
        if entries.len() != dofs.len() {
            return Err(Error::input(
                argument,
                format!("{} entries at {} dofs", entries.len(), dofs.len()),
                "one entry for each dof",
            )
            .remedy("Give the shape where it was measured, and name those dofs."));
        }
        if let Some(i) = (1..dofs.len()).find(|&i| dofs[..i].contains(&dofs[i])) {
            let twice = format!("dof {} twice", dofs[i]);
            return Err(
                Error::input(argument, twice, "each dof once").remedy("Keep one of the two, or their mean.")
            );
        }
        // NaN is lost in a maximum.
        let finite = entries.iter().all(|(a, b)| a.is_finite() && b.is_finite());
        let largest = entries.iter().fold(0.0_f64, |m, (a, b)| m.max(a.abs()).max(b.abs()));
        if !finite || largest == 0.0 {
            return Err(Error::input(
                argument,
                if finite { "zero at every dof" } else { "an entry that is not finite" },
                "a shape that moves, with finite entries",
            )
            .remedy("Leave that mode out."));
        }
        // Scaled first: squares of very small or large entries would be lost.
        let squares = entries.iter().map(|(a, b)| (a / largest).powi(2) + (b / largest).powi(2));
        let size = squares.sum::<f64>().sqrt();
        let (real, imaginary) = entries.iter().map(|(a, b)| (a / largest / size, b / largest / size)).unzip();
        Ok(Self { dofs, real, imaginary })
    }

    /// The measured dofs.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// The MAC with real shapes of `n` dofs each, given one after the other: with one, or with that
    /// combination of several which is most alike, as every combination of the shapes of a repeated mode is one
    /// of its shapes. Zero where they are at rest at the measured dofs.
    pub fn mac(&self, phi: &[f64], n: usize) -> f64 {
        if phi.len() == n {
            let (along, square) = self.products(phi);
            return if at_rest(phi, square) {
                0.0
            } else {
                ((along.0 * along.0 + along.1 * along.1) / square).min(1.0)
            };
        }
        // An orthonormal basis q at the measured dofs: Σ |φ_Eᴴ q|².
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for shape in phi.chunks_exact(n) {
            let mut q: Vec<f64> = self.dofs.iter().map(|&dof| shape[dof]).collect();
            for earlier in &basis {
                let part = dot(earlier, &q);
                q.iter_mut().zip(earlier).for_each(|(q, e)| *q -= part * e);
            }
            let size = dot(&q, &q).sqrt();
            let largest = shape.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
            if size > AT_REST * largest {
                for q in &mut q {
                    *q /= size;
                }
                basis.push(q);
            }
        }
        let squares = basis.iter().map(|q| dot(q, &self.real).powi(2) + dot(q, &self.imaginary).powi(2));
        squares.sum::<f64>().min(1.0)
    }

    /// dMAC/dφ_A at all dofs, into `slope`.
    pub fn slope(&self, phi: &[f64], slope: &mut Vec<f64>) {
        slope.clear();
        slope.resize(phi.len(), 0.0);
        let (along, square) = self.products(phi);
        if at_rest(phi, square) {
            return;
        }
        let mac = (along.0 * along.0 + along.1 * along.1) / square;
        for ((&dof, a), b) in self.dofs.iter().zip(&self.real).zip(&self.imaginary) {
            slope[dof] = 2.0 * (a * along.0 + b * along.1 - mac * phi[dof]) / square;
        }
    }

    /// aᵀφ and bᵀφ, and φᵀφ over the measured dofs.
    fn products(&self, phi: &[f64]) -> ((f64, f64), f64) {
        let (mut along, mut square) = ((0.0, 0.0), 0.0);
        for ((&dof, a), b) in self.dofs.iter().zip(&self.real).zip(&self.imaginary) {
            along.0 += a * phi[dof];
            along.1 += b * phi[dof];
            square += phi[dof] * phi[dof];
        }
        (along, square)
    }
}

/// Whether a shape of that square sum at the measured dofs is at rest there.
fn at_rest(phi: &[f64], square: f64) -> bool {
    let largest = phi.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    square.sqrt() <= AT_REST * largest
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

// ---- mode_sensitivities

/// The vectors of one mode, ready to be joined with any change of the model.
#[derive(Debug, Clone, Default)]
pub struct ModeSensitivity {
    lambda: f64,
    phi: Vec<f64>,
    slope: Vec<f64>,
    z: Vec<f64>,
}

impl ModeSensitivity {
    /// Takes up mode `r` of `modes`, which are those of `solved`, and the measured `shape`.
    pub fn set(&mut self, modes: &LowModes, solved: &mut Solved<'_>, r: usize, shape: &Shape) -> Result<()> {
        self.lambda = modes.lambda[r];
        self.phi.clear();
        self.phi.extend_from_slice(modes.shape(r));
        if modes.space(r).len() > self.phi.len() {
            self.z.clear();
            self.z.resize(self.phi.len(), 0.0);
            return Ok(());
        }
        shape.slope(&self.phi, &mut self.slope);
        modes.adjoint(solved, r, &self.slope, &mut self.z)
    }

    /// dλ/dp in (rad/s)² and dMAC/dp, per unit of p. A repeated mode has no derivatives: the first is then that
    /// of one of its shapes, right where p splits it not, the second zero.
    pub fn along(&self, slopes: &MatrixSlopes) -> (f64, f64) {
        let join = |left: &[f64], entries: &[(u32, u32, f64)]| -> f64 {
            entries.iter().map(|&(row, col, value)| left[row as usize] * value * self.phi[col as usize]).sum()
        };
        let of = |left: &[f64]| join(left, &slopes.stiffness) - self.lambda * join(left, &slopes.mass);
        (of(&self.phi), -of(&self.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_changes_nothing_and_orthogonal_shapes_have_none() {
        // (1, −2) times 3 e^{0.7 j}, at dofs 3 and 1.
        let turn = (0.7_f64.cos(), 0.7_f64.sin());
        let entries = [1.0, -2.0].map(|v| (3.0 * v * turn.0, 3.0 * v * turn.1));
        let shape = Shape::new("shape", vec![3, 1], &entries).unwrap();
        assert!((shape.mac(&[9.0, -4.0, 7.0, 2.0], 4) - 1.0).abs() < 1e-15);
        assert!(shape.mac(&[9.0, 1.0, 7.0, 2.0], 4).abs() < 1e-15);
        assert_eq!(shape.mac(&[9.0, 0.0, 7.0, 0.0], 4), 0.0);
        assert_eq!(shape.mac(&[9.0, 1e-14, 7.0, 1e-13], 4), 0.0);
    }

    #[test]
    fn a_truly_complex_shape_by_hand() {
        // φ_E = (1, j), φ_A = (1, 2): |1 − 2j|² / (2 · 5).
        let shape = Shape::new("shape", vec![0, 1], &[(1.0, 0.0), (0.0, 1.0)]).unwrap();
        assert!((shape.mac(&[1.0, 2.0], 2) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_slope_is_the_limit_of_differences_and_blind_to_the_size() {
        let entries = [(0.3, 0.1), (-0.8, 0.4), (0.5, -0.2)];
        let shape = Shape::new("shape", vec![0, 2, 3], &entries).unwrap();
        let phi = [0.7, 5.0, -0.4, 0.9];
        let mut slope = Vec::new();
        shape.slope(&phi, &mut slope);
        for (i, g) in slope.iter().enumerate() {
            let moved = |h: f64| {
                let mut at = phi;
                at[i] += h;
                shape.mac(&at, 4)
            };
            let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((g - difference).abs() < 1e-9, "{i}: {g} {difference}");
        }
        let along: f64 = slope.iter().zip(&phi).map(|(g, p)| g * p).sum();
        assert!(along.abs() < 1e-15, "{along}");
    }

    #[test]
    fn of_a_repeated_mode_every_combination_is_alike() {
        // (1, 2, 0) and (0, 1, 1), unlike in size and not orthogonal; at dof 3 nothing is measured.
        let space = [1.0, 2.0, 0.0, 5.0, 0.0, 300.0, 300.0, 0.0];
        let of = |entries: &[(f64, f64)]| {
            let shape = Shape::new("shape", vec![0, 1, 2], entries).unwrap();
            shape.mac(&space, 4)
        };
        // 3 (1, 2, 0) − 2j (0, 1, 1), and the normal of the plane, (2, −1, 1).
        assert!((of(&[(3.0, 0.0), (6.0, -2.0), (0.0, -2.0)]) - 1.0).abs() < 1e-14);
        assert!(of(&[(2.0, 0.0), (-1.0, 0.0), (1.0, 0.0)]).abs() < 1e-14);
        // Half of the square in the plane.
        let half = [(2.0 / 6.0_f64.sqrt(), 0.0), (-1.0 / 6.0_f64.sqrt() + 0.5_f64.sqrt(), 0.0)];
        let last = (1.0 / 6.0_f64.sqrt() + 0.5_f64.sqrt(), 0.0);
        assert!((of(&[half[0], half[1], last]) - 0.5).abs() < 1e-14);
        // The same shape twice is one.
        let shape = Shape::new("shape", vec![0, 1], &[(1.0, 0.0), (0.0, 1.0)]).unwrap();
        assert!((shape.mac(&[1.0, 2.0, 1.0, 2.0], 2) - 0.5).abs() < 1e-14);
    }

    #[test]
    fn tiny_and_huge_shapes_keep_their_digits() {
        for size in [1e-200, 1e200] {
            let shape = Shape::new("shape", vec![0, 1], &[(size, 0.0), (size, 0.0)]).unwrap();
            assert!((shape.mac(&[1.0, 1.0], 2) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let build = |dofs: &[usize], entries: &[(f64, f64)]| {
            Shape::new("shape", dofs.to_vec(), entries).unwrap_err().to_string()
        };
        assert!(build(&[0], &[]).contains("one entry for each dof"));
        assert!(build(&[2, 2], &[(1.0, 0.0); 2]).contains("dof 2 twice"));
        assert!(build(&[0, 1], &[(0.0, 0.0); 2]).contains("zero at every dof"));
        assert!(build(&[0], &[(f64::NAN, 0.0)]).contains("not finite"));
    }
}
