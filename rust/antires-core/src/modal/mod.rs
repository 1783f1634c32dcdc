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
//! | [`space`](reduced), [`poles`](reduced), [`reduced`] | the Krylov space of one load, its poles up to a limit, and the proof that none is missing |
//! | [`settled`](reduced) | whether two poles that nearly coincide are those of two modes |
//! | [`solved`] | K and M of one evaluation with the solutions made of them |
//! | [`receptance`] | H_ik as partial fractions |
//! | [`columns`], [`modal_columns`], [`on_pole`] | columns of (K − xM)⁻¹, and what stands for them on a pole |
//! | [`modes`], [`low_modes`] | all modes, or those up to a limit |
//! | [`frf`] | frequency responses |
//! | [`mac`], [`nelson`], [`mode_sensitivities`] | comparison with a measured shape, and its derivatives |
//!
//! May use: `fem`, `linalg`.

pub mod columns;
pub mod frf;
mod hidden_modes;
pub mod low_modes;
pub mod mac;
pub mod modal_columns;
pub mod mode_sensitivities;
pub mod modes;
pub mod nelson;
pub mod on_pole;
mod poles;
pub mod receptance;
pub mod reduced;
pub mod scaled;
mod settled;
pub mod solved;
mod space;
pub mod structure;
