//! Powers of two that bring the dofs of K and M to one unit, where those given are far apart.
//!
//! ```text
//! K̃ = 2^a D K D,   M̃ = 2^b D M D,   x = 2^(b−a) x̃,   φ = 2^(b/2) D φ̃        a, b even
//! ```
//!
//! D brings each diagonal entry of K + σM near one, which is the scaling that a Cholesky factor of it likes best
//! (A. van der Sluis, Numer. Math. 14 (1969) 14-23), with σ the lower quartile of K_jj / M_jj: that of the
//! dofs whose modes are low, where half of them may have next to no mass. Springs of 1e20 N/m, masses of
//! nearly nothing and dofs in units of their own then leave the others alone. Nothing is rounded.

use super::sparse::SparseMatrix;

/// Ratio of the diagonal entries of K + σM up to which the dofs are left as they are.
const FAR_APART: f64 = 1e10;

/// Binary exponent up to which a matrix is left as it is: products of four entries stay in range.
const FAR_FROM_ONE: i32 = 200;

/// The scale of each dof, and those of the matrices.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    dofs: Vec<f64>,
    stiffness: i32,
    mass: i32,
}

impl Balance {
    /// The scales of matrices of `n` rows with these diagonals, stiffness and mass; none where they may stay as they
    /// are.
    pub fn of(n: usize, diagonals: impl Fn(usize) -> (f64, f64)) -> Option<Self> {
        let (mut least, mut most) = ([f64::INFINITY; 2], [0.0_f64; 2]);
        for j in 0..n {
            let (k, m) = diagonals(j);
            for (side, value) in [k, m].into_iter().enumerate() {
                least[side] = least[side].min(value);
                most[side] = most[side].max(value);
            }
        }
        let alike =
            |side: usize| most[side] <= FAR_APART * least[side] && least[side] > 1e-60 && most[side] < 1e60;
        if alike(0) && alike(1) {
            return None;
        }
        let (stiffness, mass): (Vec<f64>, Vec<f64>) = (0..n).map(diagonals).unzip();
        Self::far_apart(&stiffness, &mass)
    }

    fn far_apart(stiffness: &[f64], mass: &[f64]) -> Option<Self> {
        let exponents = [stiffness, mass].map(to_one);
        let far = exponents.iter().any(|e| e.abs() > FAR_FROM_ONE);
        let [a, b] = exponents.map(|e| if far { e } else { 0 });
        let own =
            |values: &[f64], by: i32| -> Vec<f64> { values.iter().map(|v| times(v.abs(), by)).collect() };
        let (k, m) = (own(stiffness, a), own(mass, b));
        let mut ratios: Vec<f64> = k.iter().zip(&m).map(|(k, m)| k / m).collect();
        ratios.retain(|r| *r > 0.0 && r.is_finite());
        ratios.sort_by(f64::total_cmp);
        let sigma = ratios.get(ratios.len() / 4).copied().unwrap_or(1.0);
        let sizes: Vec<f64> = k.iter().zip(&m).map(|(k, m)| k + sigma * m).collect();
        let present = || sizes.iter().copied().filter(|s| *s > 0.0);
        let least = present().fold(f64::INFINITY, f64::min);
        let most = present().fold(0.0, f64::max);
        let apart = most > FAR_APART * least;
        if !(far || apart) {
            return None;
        }
        let scale = |s: &f64| {
            if apart && *s > 0.0 { (-0.5 * s.log2()).round().exp2() } else { 1.0 }
        };
        Some(Self { dofs: sizes.iter().map(scale).collect(), stiffness: a, mass: b })
    }

    /// The scales of sparse matrices.
    pub fn of_sparse(stiffness: &SparseMatrix, mass: &SparseMatrix) -> Option<Self> {
        Self::of(mass.n(), |j| (stiffness.diagonal(j), mass.diagonal(j)))
    }

    /// K̃.
    pub fn stiffness(&self, k: &SparseMatrix) -> SparseMatrix {
        self.scaled(k, self.stiffness)
    }

    /// M̃.
    pub fn mass(&self, m: &SparseMatrix) -> SparseMatrix {
        self.scaled(m, self.mass)
    }

    /// Entry (i, j) of K̃ from that of K.
    pub fn stiffness_entry(&self, i: usize, j: usize, value: f64) -> f64 {
        times(value, self.stiffness) * self.dofs[i] * self.dofs[j]
    }

    /// Entry (i, j) of M̃ from that of M.
    pub fn mass_entry(&self, i: usize, j: usize, value: f64) -> f64 {
        times(value, self.mass) * self.dofs[i] * self.dofs[j]
    }

    fn scaled(&self, matrix: &SparseMatrix, by: i32) -> SparseMatrix {
        let mut out = matrix.clone();
        for ((i, j, value), scaled) in matrix.entries().zip(&mut out.values) {
            *scaled = times(value, by) * self.dofs[i] * self.dofs[j];
        }
        out
    }

    /// x of x̃.
    pub fn eigenvalue(&self, scaled: f64) -> f64 {
        times(scaled, self.mass - self.stiffness)
    }

    /// A frequency of that of the scaled matrices.
    pub fn frequency(&self, scaled: f64) -> f64 {
        times(scaled, (self.mass - self.stiffness) / 2)
    }

    /// A frequency of the scaled matrices.
    pub fn scaled_frequency(&self, frequency: f64) -> f64 {
        times(frequency, (self.stiffness - self.mass) / 2)
    }

    /// ψ of ψ̃, a direction without mass that ψᵀKψ = 1 normalises: entry `dof`.
    pub fn massless_shape(&self, dof: usize, scaled: f64) -> f64 {
        times(scaled * self.dofs[dof], self.stiffness / 2)
    }

    /// φ of φ̃: entry `dof`.
    pub fn shape(&self, dof: usize, scaled: f64) -> f64 {
        times(scaled * self.dofs[dof], self.mass / 2)
    }
}

/// The even power of two that brings the largest of `values` near one.
fn to_one(values: &[f64]) -> i32 {
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest > 0.0 && largest.is_finite() { -2 * (0.5 * largest.log2()).round() as i32 } else { 0 }
}

/// `value` 2^`by`, in steps that stay in the range of doubles.
fn times(value: f64, by: i32) -> f64 {
    let half = by / 2;
    value * f64::exp2(f64::from(half)) * f64::exp2(f64::from(by - half))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(stiffness: &[f64], mass: &[f64]) -> Option<Balance> {
        Balance::of(mass.len(), |j| (stiffness[j], mass[j]))
    }

    #[test]
    fn what_is_alike_is_left_alone() {
        assert_eq!(of(&[1.0, 1e4, 0.0], &[1e-3, 2.0, 0.0]), None);
        assert_eq!(of(&[0.0], &[0.0]), None);
    }

    #[test]
    fn units_of_dofs_and_of_matrices_are_taken_out() {
        let d = [1e-9, 1.0, 1e12];
        let diagonal = |by: f64| d.map(|d| by * d * d).to_vec();
        for (k, m) in [(3.0, 2.0), (3e250, 2e-250), (3e-270, 1.0)] {
            let (stiffness, mass) = (diagonal(k), diagonal(m));
            if stiffness.iter().any(|v| v.is_infinite() || *v < 1e-300) {
                continue;
            }
            let balance = of(&stiffness, &mass).unwrap();
            for j in 0..3 {
                let (k, m) = (balance.stiffness_entry(j, j, stiffness[j]), balance.mass_entry(j, j, mass[j]));
                assert!(k > 0.1 && k < 10.0 && m > 0.01 && m < 10.0, "{k} {m}");
                let wanted = stiffness[j] / mass[j];
                if wanted.is_finite() {
                    let back = balance.eigenvalue(k / m);
                    assert!((back / wanted - 1.0).abs() < 1e-15);
                }
            }
            let one = balance.frequency(balance.scaled_frequency(3.7));
            assert_eq!(one, 3.7);
        }
    }

    #[test]
    fn a_stiff_spring_leaves_the_others_their_digits() {
        let balance = of(&[2.0, 1e20, 2.0], &[1.0; 3]).unwrap();
        assert!((0.25..=4.0).contains(&balance.stiffness_entry(0, 0, 2.0)));
        assert!(balance.stiffness_entry(1, 1, 1e20) < 4.0);
        assert!(balance.mass_entry(1, 1, 1.0) < 1e-19);
    }
}
