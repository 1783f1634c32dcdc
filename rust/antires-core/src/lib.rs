//! Antiresonances of vibrating structures: of a model, and models updated to those measured.
//!
//! # The problem
//!
//! A structure with n degrees of freedom (dofs) is shaken by one force at dof k. At a frequency ω it responds at
//! dof i with
//!
//! ```text
//! H_ik(x) = X_i / F_k = e_iᵀ (K − xM)⁻¹ e_k = Σ_r φ_ir φ_kr / (λ_r − x) + d_ik,      x = ω²
//! ```
//!
//! K φ = λ M φ gives its poles, the resonances. Its zeros are the *antiresonances*: the positive real x with
//!
//! ```text
//! det(K_ik − x M_ik) = 0,     K_ik, M_ik: K, M without row i and column k,
//! ```
//!
//! since that determinant is ± det(K − xM) H_ik(x). Of two responses to the same force the *transmissibility*
//!
//! ```text
//! T_ij = X_i / X_j = H_ik / H_jk
//! ```
//!
//! needs no measured force: the common denominator cancels, its zeros are the antiresonances of H_ik and its poles
//! those of H_jk. Updating seeks the parameters p of K(p) and M(p), within bounds, that minimize
//!
//! ```text
//! J(p) = Σ |e| + γ₁ Σ β + γ₂ count(β > 0),      e = ω_A² / ω_E² − 1
//! ```
//!
//! where each measured antiresonance ω_E is paired with the nearest one of the model, ω_A; the two penalties prefer
//! few damaged elements.
//!
//! | symbol | unit | what it is |
//! |---|---|---|
//! | K, M | N/m, kg | stiffness and mass [n x n], symmetric, M positive semi-definite; rotations in N·m/rad, kg·m² |
//! | x, ω | rad²/s², rad/s | x = ω²; frequencies cross the public functions in Hz, f = ω / 2π |
//! | λ_r | rad²/s² | eigenvalue r, ascending; 0 for a rigid-body mode |
//! | φ_r | kg^(−1/2) | its shape, φᵀMφ = 1 |
//! | i, k | – | dofs of response and force, zero-based |
//! | e_i | – | column i of the identity |
//! | X_i, F_k | m, N | amplitudes of response and force |
//! | H_ik | m/N | receptance |
//! | d_ik | m/N | its part of directions without mass; 0 if there are none |
//! | T_ij | – | transmissibility |
//! | p | various | updating parameters, see [`fem::parameters`] |
//! | β | – | stiffness reduction of an element, K_e ← (1 − β) K_e |
//! | e | – | residual of one measured antiresonance |
//! | γ₁, γ₂ | – | weights of the penalties |
//! | J | – | objective |
//!
//! # The modules, in the order of reading
//!
//! | module | what it knows | may use |
//! |---|---|---|
//! | [`error`] | what can go wrong, and how to mend it | – |
//! | [`linalg`] | eigenproblems, band matrices, pencils | `error` |
//! | [`rational`] | polynomials on Forsythe's basis, for fits of measured curves | `linalg` |
//! | [`fem`] | K(p), M(p) and their derivatives | `error`, `linalg` |
//! | [`modal`] | modes, receptances, frequency responses, MAC | `error`, `linalg`, `fem` |
//! | [`antiresonances`] | the zeros of H_ik by two routes, and their sensitivities | `error`, `linalg`, `fem`, `modal` |
//! | [`rng`] | random streams that are the same on every machine | – |
//! | [`optimize`] | the island genetic algorithm and its polish, for any f(x) | `error`, `rng` |
//! | [`update`] | J, where the models meet the optimizer | `error`, `fem`, `modal`, `antiresonances`, `optimize` |
//! | [`prepared`] | damage of a test, from tables of antiresonances over severities | `linalg`, `update` |
//!
//! `tests/suite/architecture.rs` holds the sources to this table, and forbids circles between files.
//!
//! # References
//!
//! - V. Meruane, Model updating using antiresonant frequencies identified from transmissibility functions, J. Sound
//!   Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021.
//! - R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA J. 14 (1976) 1201-1205,
//!   doi 10.2514/3.7211.
//! - W. D'Ambrogio & A. Fregolent, The use of antiresonances for robust model updating, J. Sound Vib. 236 (2000)
//!   227-243.
#![forbid(unsafe_code)]
#![allow(rustdoc::private_intra_doc_links)] // the sources are read too, and there they lead somewhere

pub mod antiresonances;
pub mod error;
pub mod fem;
pub mod linalg;
pub mod modal;
pub mod optimize;
pub mod prepared;
pub mod rational;
pub mod rng;
pub mod update;
