//! Symmetric sparse matrices on a fixed pattern, and A = L D Lᵀ of them.
//!
//! | module | what it knows |
//! |---|---|
//! | [`pattern`] | where entries are |
//! | [`matrix`] | their values: product, forms, dense copies |
//! | [`symbolic`] | the ordering that keeps L sparse, and its blocks: once a pattern |
//! | [`factors`] | the values of L and D by `blocks`; count of negative `pivots`, `solution` |
//! | [`several`] | product and solution for several columns at once |
//!
//! K and M of one model share a pattern, so that K − xM is a sum of values.

mod blocks;
pub mod factors;
pub mod matrix;
pub mod pattern;
mod pivots;
pub mod several;
mod solution;
pub mod symbolic;

pub use factors::SparseFactors;
pub use matrix::SparseMatrix;
pub use pattern::Pattern;
pub use symbolic::Symbolic;
