//! Structural models: K(p) and M(p) as sums of element terms.
//!
//! ```text
//! K(p) = K + Σ_i (s_i(p) − 1) K_i        M(p) = M + Σ_i (s_i(p) − 1) M_i
//! ```
//!
//! K, M [n x n] are the nominal matrices, K_i and M_i the contribution of element i (a *term*), s_i
//! the product of the factors that the parameters give to it. Damage: s_i = 1 − β_i. The nominal
//! matrices come back bit for bit at s = 1.
//!
//! A model made of a [`frame`] also knows how its terms follow from sections, masses and coordinates,
//! and forms them again when parameters change those.
//!
//! SI units throughout: kg, N/m, m, rad/s; degrees of freedom are zero-based.
//!
//! | module | what it knows |
//! |---|---|
//! | [`term`], [`elements`], [`section`] | one contribution to K or M, and the formulas behind it |
//! | [`model`], [`frame`] | K, M and their terms; from masses in a row, from beams |
//! | [`parameters`], [`checks`] | what may change, whether it does, and how far |
//! | [`assembly`] | K(p), M(p); dK/dp, dM/dp |
//!
//! May use: `error`, `linalg`.

pub mod assembly;
pub mod checks;
pub(crate) mod elements;
pub mod frame;
pub mod model;
pub mod parameters;
pub mod section;
pub mod term;
