//! Every tolerance of the linear algebra, with its reason.

/// A Cholesky pivot ratio of M below this sends the symmetric problem down the shifted path:
/// reduction by a worse-conditioned M would cost more than half of the digits.
pub const MASS_PIVOT_RATIO: f64 = 1e-8;

/// An eigenvalue of (M, K + σM) below `n` times this, relative to the largest, is an infinite mode.
pub const INFINITE_MODE: f64 = 4.0 * f64::EPSILON;

/// Backward error above which an eigenvalue of the QZ algorithm is refused. Backward stability
/// promises a small multiple of `n` ulp; a solver that silently stopped early is far off it.
pub const QZ_BACKWARD_ERROR: f64 = 1e-10;

/// An eigenvalue whose first-order relative uncertainty exceeds this is infinite (or zero) at working precision.
/// Defective infinite eigenvalues of multiplicity m scatter over x ~ eps^(-1/m) with an uncertainty of order
/// 1/m. For QZ the measure is n ulp of the norms, which real finite roots exceed too where K spans many decades:
/// frames of some hundred dofs on soft springs. Such roots are asked again on the matrices, where the measure is
/// an ulp of each entry.
pub const ROOT_UNCERTAINTY: f64 = 1e-3;

/// A root counts as real when its imaginary part is below this fraction of its modulus, or below ten
/// times its uncertainty: repeated real roots come back from QZ as conjugate pairs apart by rounding.
pub const REAL_ROOT: f64 = 1e-9;

/// A double root with one vector comes back from QZ split by the root of rounding, some 1e-8 times the
/// root of its condition; closer than this the two halves, real or complex, are one root.
pub const SPLIT_ROOT: f64 = 3e-7;

/// Roots this close, relatively, count as repeated.
pub const REPEATED_ROOT: f64 = 1e-6;

/// A repeated real root nearer than this to zero or infinity, in the scaled pencil, is dropped: it
/// cannot be told from a cluster of infinite ones.
pub const REPEATED_ROOT_DISTANCE: f64 = 1e-8;

/// λ = 0 in floating point: rigid-body eigenvalues scatter over a few `n` ulp of the largest.
#[must_use]
pub fn zero_eigenvalue(n: usize, largest: f64) -> f64 {
    16.0 * n as f64 * f64::EPSILON * largest
}
