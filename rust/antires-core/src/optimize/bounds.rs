//! The box of admissible candidates: `lower_i <= x_i <= upper_i`.

use crate::error::{Argument, Error, Result};
use crate::rng::Rng;

/// The largest magnitude of a bound: beyond it, extended intervals could overflow.
const MAX_MAGNITUDE: f64 = 1e100;

/// Finite lower and upper bounds of every gene; equal ones fix the gene.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Bounds {
    /// Checks and takes the bounds.
    ///
    /// # Errors
    /// If there is no gene, the lengths differ, a bound is not finite or above 1e100
    /// in size, or a lower bound is above the upper one; the gene is named by its index.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self> {
        if lower.len() != upper.len() {
            let got = format!("{} lower and {} upper bounds", lower.len(), upper.len());
            return Err(Error::input("bounds", got, "as many lower as upper bounds")
                .remedy("Give a pair (lower, upper) for each gene."));
        }
        if lower.is_empty() {
            return Err(Error::input("bounds", "no gene", "at least one gene")
                .remedy("Give a pair (lower, upper) for each gene."));
        }
        for (i, (&lo, &hi)) in lower.iter().zip(&upper).enumerate() {
            let pair = format!("lower {lo}, upper {hi}");
            let argument = Argument::from("bounds").item(i);
            // Written so that NaN fails too.
            if !(lo.abs() <= MAX_MAGNITUDE && hi.abs() <= MAX_MAGNITUDE) {
                return Err(Error::input(argument, pair, "finite bounds, below 1e100 in size")
                    .remedy("The search draws uniformly between them, so it needs both."));
            }
            if lo > hi {
                return Err(
                    Error::input(argument, pair, "lower <= upper").remedy("Equal bounds fix the gene.")
                );
            }
        }
        Ok(Self { lower, upper })
    }

    /// The same bounds for `n` genes.
    pub fn uniform(n: usize, lower: f64, upper: f64) -> Result<Self> {
        Self::new(vec![lower; n], vec![upper; n])
    }

    /// The number of genes.
    pub fn n_genes(&self) -> usize {
        self.lower.len()
    }

    /// The lower bounds.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// The upper bounds.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Whether gene `i` may have the value `x`.
    #[inline]
    pub fn admits(&self, i: usize, x: f64) -> bool {
        self.lower[i] <= x && x <= self.upper[i]
    }

    /// Whether `x` has the right number of genes and all are inside.
    pub fn contain(&self, x: &[f64]) -> bool {
        x.len() == self.n_genes() && x.iter().enumerate().all(|(i, &v)| self.admits(i, v))
    }

    /// Moves every gene outside to the nearer bound.
    pub fn clip(&self, x: &mut [f64]) {
        for ((x, &lo), &hi) in x.iter_mut().zip(&self.lower).zip(&self.upper) {
            *x = x.clamp(lo, hi);
        }
    }

    /// Draws every gene uniformly between its bounds.
    pub(super) fn draw(&self, rng: &mut Rng, x: &mut [f64]) {
        for ((x, &lo), &hi) in x.iter_mut().zip(&self.lower).zip(&self.upper) {
            *x = rng.uniform(lo, hi);
        }
    }

    /// Checks that the guesses have the right length and lie inside.
    ///
    /// # Errors
    /// For the first that does not, named by its index and its gene's.
    pub(super) fn check_guesses(&self, guesses: &[Vec<f64>]) -> Result<()> {
        for (g, x) in guesses.iter().enumerate() {
            if x.len() != self.n_genes() {
                let wanted = format!("{} genes, one per bound", self.n_genes());
                return Err(Error::input(Argument::from("x0").item(g), format!("{} genes", x.len()), wanted)
                    .remedy("A guess holds a value for each gene, in the order of the bounds."));
            }
            if let Some(i) = (0..x.len()).find(|&i| !self.admits(i, x[i])) {
                let wanted = format!("a value in [{}, {}]", self.lower[i], self.upper[i]);
                return Err(Error::input(Argument::from("x0").item(g).item(i), x[i], wanted)
                    .remedy("Move the guess inside, or widen the bounds."));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(lower: &[f64], upper: &[f64]) -> String {
        Bounds::new(lower.to_vec(), upper.to_vec()).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert_eq!(
            refusal(&[0.0, 2.0], &[1.0, 1.0]),
            "bounds[1]: got lower 2, upper 1; wanted lower <= upper. Equal bounds fix the gene."
        );
        assert!(refusal(&[0.0], &[f64::NAN]).starts_with("bounds[0]: got lower 0, upper NaN"));
        assert!(refusal(&[f64::NEG_INFINITY], &[0.0]).contains("wanted finite bounds"));
        assert!(refusal(&[-f64::MAX], &[f64::MAX]).contains("wanted finite bounds"));
        assert_eq!(
            refusal(&[], &[]),
            "bounds: got no gene; wanted at least one gene. Give a pair (lower, upper) for each gene."
        );
        assert!(refusal(&[0.0], &[]).contains("1 lower and 0 upper"));
    }

    #[test]
    fn guesses_are_checked_gene_by_gene() {
        let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
        assert!(bounds.check_guesses(&[vec![0.0, 1.0]]).is_ok());
        let refusal = |x: Vec<f64>| {
            let error = bounds.check_guesses(&[vec![0.5, 0.5], x]).unwrap_err();
            error.to_string()
        };
        assert_eq!(
            refusal(vec![0.0, 1.5]),
            "x0[1][1]: got 1.5; wanted a value in [0, 1]. Move the guess inside, or widen the bounds."
        );
        assert!(refusal(vec![f64::NAN, 0.0]).starts_with("x0[1][0]: got NaN"));
        assert!(refusal(vec![0.5]).contains("got 1 genes; wanted 2 genes"));
    }
}
