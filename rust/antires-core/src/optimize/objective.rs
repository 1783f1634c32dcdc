//! What is minimized: `J(x)`. Nothing more need be known about it; what can be told besides serves the
//! [polish](super::polish).
//!
//! `x` holds `n` genes inside box [bounds](super::Bounds). Two layers meet here:
//!
//! - [`Objective`]: a native cost of one candidate, called from many threads at once;
//! - [`Evaluator`]: the costs of a whole batch of candidates. The search calls only this one, once
//!   per generation. [`ObjectiveEvaluator`](super::ObjectiveEvaluator) makes an evaluator of any
//!   objective; a binding writes its own, so that a foreign function is entered once per
//!   generation and its exception travels through as [`Evaluator::Fault`].
//!
//! A cost that is not finite (`+inf`, `-inf`, `NaN`) counts as the worst possible: it becomes
//! `+inf` as the search takes it in.

use std::ops::ControlFlow;

use super::composition::{Composition, Linearization};
use super::outcome::Interrupt;

/// A cost function of one candidate, callable from several threads at once.
///
/// Any `Fn(&[f64]) -> f64` that is `Sync` is an objective without workspace and without repair.
pub trait Objective: Sync {
    /// Buffers that one thread reuses from candidate to candidate.
    type Workspace: Send;

    /// New buffers; called once per thread and run.
    fn workspace(&self) -> Self::Workspace;

    /// The cost of `x`.
    ///
    /// Must depend on `x` alone, never on what an earlier candidate left in `workspace`: which
    /// thread evaluates which candidate is not determined.
    fn cost(&self, x: &[f64], workspace: &mut Self::Workspace) -> f64;

    /// Moves a proposed `x` to the point that shall stand for it, for example by snapping
    /// negligible genes to zero. The result, clipped to the bounds, is what is evaluated and kept.
    fn repair(&self, _x: &mut [f64]) {}

    /// How the cost is composed, where the objective tells.
    fn composition(&self) -> Option<Composition> {
        None
    }

    /// The cost and its residuals' first derivatives at `x`, where the objective can tell; under the same
    /// rule as [`cost`](Self::cost), and with the same cost.
    fn linearize(&self, _x: &[f64], _workspace: &mut Self::Workspace) -> Option<Linearization> {
        None
    }
}

impl<F: Fn(&[f64]) -> f64 + Sync> Objective for F {
    type Workspace = ();

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        self(x)
    }
}

/// Candidates to be evaluated together: an `m x n` matrix, one candidate per row.
#[derive(Debug, Clone, Copy)]
pub struct Candidates<'a> {
    genes: &'a [f64],
    n_genes: usize,
}

impl<'a> Candidates<'a> {
    /// The rows of `genes`, each `n_genes` long, in row-major order.
    ///
    /// # Panics
    /// If `genes` does not divide into rows of `n_genes`.
    #[must_use]
    pub fn new(genes: &'a [f64], n_genes: usize) -> Self {
        assert!(
            n_genes > 0 && genes.len().is_multiple_of(n_genes),
            "{} values do not divide into rows of {n_genes}",
            genes.len()
        );
        Self { genes, n_genes }
    }

    /// The number of candidates, `m`.
    pub fn len(&self) -> usize {
        self.genes.len() / self.n_genes
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.genes.is_empty()
    }

    /// The number of genes of each candidate, `n`.
    pub fn n_genes(&self) -> usize {
        self.n_genes
    }

    /// Candidate `i`.
    pub fn row(&self, i: usize) -> &'a [f64] {
        &self.genes[i * self.n_genes..][..self.n_genes]
    }

    /// All values in row-major order.
    pub fn as_slice(&self) -> &'a [f64] {
        self.genes
    }
}

/// The costs of a batch of candidates.
pub trait Evaluator {
    /// What can go wrong in an evaluation, handed through the search untouched.
    type Fault;

    /// As [`Objective::repair`].
    fn repair(&self, _x: &mut [f64]) {}

    /// Writes the cost of candidate `i` to `costs[i]`.
    ///
    /// `costs` arrives filled with `NaN` and has one entry per candidate; there is at least one.
    /// A long evaluation calls `poll` every now and then (some 20 ms apart, on the calling
    /// thread), and when that returns an interrupt gives up and breaks with it; costs written
    /// until then are still compared with the best so far.
    ///
    /// # Errors
    /// Whatever the evaluation failed with; the search stops and returns it.
    fn evaluate(
        &mut self,
        candidates: Candidates<'_>,
        costs: &mut [f64],
        poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Self::Fault>;

    /// As [`Objective::composition`].
    fn composition(&self) -> Option<Composition> {
        None
    }

    /// Writes the linearization of candidate `i` to `found[i]`, under the rules of
    /// [`evaluate`](Self::evaluate); `found` arrives filled with `None`.
    ///
    /// # Errors
    /// Whatever the evaluation failed with.
    fn linearize(
        &mut self,
        _candidates: Candidates<'_>,
        _found: &mut [Option<Linearization>],
        _poll: &mut dyn FnMut() -> Option<Interrupt>,
    ) -> Result<ControlFlow<Interrupt>, Self::Fault> {
        Ok(ControlFlow::Continue(()))
    }
}
