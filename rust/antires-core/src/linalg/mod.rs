//! The one owner of faer's solvers.
//!
//! | module | problem | used by |
//! |---|---|---|
//! | [`symmetric`] | K φ = λ M φ, both symmetric | the modal route |
//! | [`pencil`] | A v = x B v, general real | the pencil route |
//!
//! Everything runs with `Par::Seq`: parallelism belongs one level up, to the optimizer.

pub mod pencil;
pub mod symmetric;
pub mod tolerances;
