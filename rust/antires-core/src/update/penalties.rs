//! The damage penalties of Eqs. 15-17: `γ₁ Σ β + γ₂ count(β > 0)`.
//!
//! They prefer few damaged elements. With γ₁ = γ₂ = 0.1 a small damage costs more than it explains:
//! see the detectable severities that the damage result reports.

/// Weights of the two penalties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalty {
    /// γ₁, on the sum of the severities.
    pub gamma1: f64,
    /// γ₂, on the number of damaged elements.
    pub gamma2: f64,
}

impl Penalty {
    /// Penalty of the severities `beta`.
    #[must_use]
    pub fn of(&self, beta: impl Iterator<Item = f64>) -> f64 {
        let (sum, count) = beta.fold((0.0, 0_usize), |(sum, count), b| {
            (sum + b, count + usize::from(b > 0.0))
        });
        self.gamma1 * sum + self.gamma2 * count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::Penalty;

    #[test]
    fn counts_only_damaged_elements() {
        let penalty = Penalty {
            gamma1: 0.1,
            gamma2: 0.2,
        };
        assert_eq!(penalty.of([0.0, 0.0].into_iter()), 0.0);
        assert!((penalty.of([0.0, 0.5, 0.25].into_iter()) - (0.075 + 0.4)).abs() < 1e-15);
    }
}
