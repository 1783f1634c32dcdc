//! The one owner of faer's solvers.
//!
//! | module | problem | used by |
//! |---|---|---|
//! | [`symmetric`] | K φ = λ M φ and A q = μ q, all symmetric | the modal route |
//! | [`banded`], [`sparse`], [`factors`] | matrices in band or in sparse form, A = L D Lᵀ of them | the modal route |
//! | [`krylov`] | low modes and responses from these factors | the modal route |
//! | [`balance`] | powers of two that bring dofs to one unit | [`symmetric`], both routes |
//! | [`hermitian`] | eigenvalues of small Hermitian matrices, and the first eigenpair | `antires-py`, for spectra |
//! | [`pencil`] | A v = x B v, general real, and how far a root may be off | the pencil route |
//! | [`wide`] | loops in the widest instructions of the machine | all |
//!
//! Everything runs with `Par::Seq`: parallelism belongs one level up, to the optimizer.
//!
//! May use: `error`.

pub(crate) mod balance;
pub(crate) mod banded;
pub(crate) mod factors;
pub mod hermitian;
pub(crate) mod krylov;
pub(crate) mod pencil;
pub mod sparse;
pub(crate) mod symmetric;
pub(crate) mod wide;
