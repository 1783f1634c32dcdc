//! Polynomials on Forsythe's basis, for fits of measured curves.
//!
//! With x the frequency over the highest one and s = i x, the basis obeys
//! s φ_k = b_{k+1} φ_{k+1} − b_k φ_{k−1} and φ_0 = 1 / b_0, the b real: a polynomial Σ c_k φ_k with real c
//! has real coefficients in s.
//!
//! | module | problem |
//! |---|---|
//! | [`forsythe`] | φ_0 … φ_m at complex points |
//! | [`roots`] | all roots of Σ c_k φ_k, from approximations |

pub mod forsythe;
pub mod roots;
