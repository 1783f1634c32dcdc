//! Modes, frequency responses, and antiresonances.
//!
//! With x = ω² and mass-normalised modes φ_r of K φ = λ M φ,
//!
//! ```text
//! H_ik(x) = Σ_r φ_ir φ_kr / (λ_r − x) + d_ik
//! ```
//!
//! is the receptance between response dof i and excitation dof k; d is zero unless some dofs carry no
//! mass. Its positive real zeros are the antiresonances, and equally the roots of
//! det(K_ik − x M_ik) = 0 with row i and column k deleted, since that determinant is
//! ± det(K − x M) H_ik(x). Hence two routes that must agree: [`antiresonances`].

pub mod antiresonances;
pub mod bracket;
mod columns;
pub mod enclosure;
pub mod frf;
pub mod glance;
mod isolate;
mod join;
pub mod low_modes;
pub mod mac;
pub mod mode_sensitivities;
pub mod modes;
mod polish;
pub mod receptance;
pub mod reduced;
pub mod rest;
pub mod secular;
pub mod sensitivities;
pub mod structure;
pub mod tail;
