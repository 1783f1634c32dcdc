//! Modes, and what follows from them: frequency responses, shapes and their sensitivities.
//!
//! With x = ω² (rad²/s²) and mass-normalised modes φ_r of K φ = λ M φ,
//!
//! ```text
//! H_ik(x) = Σ_r φ_ir φ_kr / (λ_r − x) + d_ik        [m/N]
//! ```
//!
//! is the receptance between response dof i and excitation dof k; d is zero unless some dofs carry no
//! mass.
//!
//! | module | what it knows |
//! |---|---|
//! | [`structure`] | what stays while parameters change: the ordering, band or sparse, the degrees of the determinants |
//! | [`scaled`] | K and M in band or sparse form, factors of K − xM |
//! | [`reduced`] | the poles of one load up to a limit, from a Krylov space, and the proof that none is missing |
//! | [`solved`] | K and M of one evaluation with the solutions made of them |
//! | [`receptance`] | H_ik as partial fractions |
//! | [`minor`] | det H[I, J] of several responses and forces as partial fractions, and its roots beside poles |
//! | [`several`] | the responses to several forces up to a limit, from one Krylov space |
//! | [`columns`] | columns of (K − xM)⁻¹, what stands for them on a pole, and adjoint solutions for a mode |
//! | [`modes`] | all modes, or those up to a limit; frequency responses |
//! | [`mac`] | comparison with a measured shape, and its derivatives |
//!
//! May use: `fem`, `linalg`.

pub(crate) mod columns;
pub mod mac;
pub mod minor;
pub mod modes;
pub(crate) mod receptance;
pub(crate) mod reduced;
pub(crate) mod scaled;
pub(crate) mod several;
pub(crate) mod solved;
pub mod structure;
