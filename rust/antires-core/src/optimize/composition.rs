//! What an objective may tell beyond its value: how it is composed, and its first derivatives.
//!
//! ```text
//! J(x) = ρ(e(x)) + Σ_i price_i x_i + (a toll on each sparse gene that is above its lower bound)
//! e(x + d) ≈ e(x) + A d
//! ```
//!
//! With this a local [polish](super::polish) can solve for all continuous genes at once and treat the
//! toll, which no derivative knows, by moves from gene to gene.

/// The norm ρ of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Norm {
    /// Σ |e|.
    Absolute,
    /// Σ e².
    Squared,
}

/// The parts of J.
#[derive(Debug, Clone, PartialEq)]
pub struct Composition {
    /// The norm of the residuals, where the objective can also be linearized.
    pub norm: Option<Norm>,
    /// Where a search begins that knows nothing: nothing damaged, everything nominal. Its sparse genes
    /// are put to their lower bounds.
    pub start: Option<Vec<f64>>,
    /// The slope that J has by itself, apart from the residuals; one a gene.
    pub price: Vec<f64>,
    /// Which genes rest at their lower bound unless they earn their toll.
    pub sparse: Vec<bool>,
}

impl Composition {
    /// What can be said of any function: genes with lower bound 0 may be sparse.
    pub(super) fn unknown(lower: &[f64]) -> Self {
        Self {
            norm: None,
            start: None,
            price: vec![0.0; lower.len()],
            sparse: lower.iter().map(|&low| low == 0.0).collect(),
        }
    }
}

/// J and its residuals near one candidate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Linearization {
    /// J, exactly the objective's cost there.
    pub cost: f64,
    /// e, m of them.
    pub residuals: Vec<f64>,
    /// A = de/dx, m x n, row by row.
    pub jacobian: Vec<f64>,
}
