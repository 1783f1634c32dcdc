//! The one owner of faer's solvers.
//!
//! | module | problem | used by |
//! |---|---|---|
//! | [`symmetric`] | K φ = λ M φ, both symmetric | the modal route |
//! | [`standard`] | A q = μ q, A symmetric | [`symmetric`] |
//! | [`small`], [`tridiagonal`] | the same, few rows | [`standard`], [`krylov`] |
//! | [`banded`], [`ordering`], [`krylov`] | low modes and responses from band matrices | the modal route |
//! | [`block_krylov`] on [`panel`] | the same from large sparse ones, four vectors at a time | the modal route |
//! | [`sparse`], [`form`], [`factored`] | the same from sparse matrices; either of the two | the modal route |
//! | [`balance`] | powers of two that bring dofs to one unit | [`symmetric`], both routes |
//! | [`blocks`] | block-triangular form of a pencil | [`pencil`] |
//! | [`definite`] | are all eigenvalues at or above zero | `fem::bounds` |
//! | [`dominant`] | the first eigenpair of small Hermitian matrices | `antires-py`, for spectra |
//! | [`hermitian`] | eigenvalues of small Hermitian matrices | `antires-py`, for spectra |
//! | [`root_bounds`] on [`equilibrated`] | how far a root of a pencil may be off | `antiresonances` |
//! | [`pencil`] | A v = x B v, general real | the pencil route |
//!
//! Everything runs with `Par::Seq`: parallelism belongs one level up, to the optimizer.
//!
//! May use: `error`.

pub mod balance;
pub mod banded;
pub mod block_krylov;
pub mod blocks;
pub mod definite;
pub mod dominant;
pub mod equilibrated;
pub mod factored;
pub mod form;
pub mod hermitian;
pub mod krylov;
pub mod ordering;
pub mod panel;
pub mod pencil;
pub mod root_bounds;
pub mod small;
pub mod sparse;
pub mod standard;
pub mod symmetric;
pub mod tolerances;
pub mod tridiagonal;
pub mod wide;
