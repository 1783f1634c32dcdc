//! Model updating: what was measured against what the model has.
//!
//! ```text
//! e = ω_A² / ω_E² − 1                                       Eq. 11 (printed with a wrong exponent)
//! J = Σ |e| + γ₁ Σ β + γ₂ count(β > 0)                      Eqs. 12, 15-17, or another [`Misfit`](unknowns::Misfit)
//! J = Σ |e| + Σ (1 − MAC)² + γ₁ Σ β + γ₂ count(β > 0)       Eq. 18
//! ```
//!
//! ω are antiresonances in the first J ([`objective`]), resonances in the second ([`modal_objective`]).
//! A analytic, of those that the measurement can show ([`shown`](objective::shown)), E experimental; the penalties apply to stiffness reductions only. This is the one
//! place where the models meet the optimizer.
//!
//! May use: `error`, `fem`, `modal`, `antiresonances`, `optimize`.
//!
//! Source: Meruane, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.

pub mod alignment;
pub mod modal_objective;
pub mod objective;
pub mod pairing;
pub mod unknowns;
