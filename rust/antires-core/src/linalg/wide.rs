//! Loops in the widest instructions of the machine, chosen when the program runs.
//!
//! The order of the additions is written out in lanes, and no multiplication is fused with an addition: the
//! bits are the same on every machine.

use pulp::Arch;
pub use pulp::NullaryFnOnce;

/// Sums side by side.
pub const LANES: usize = 4;

/// Sum of the lanes.
#[inline(always)]
#[must_use]
pub fn total(sums: [f64; LANES]) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Runs a loop whose `call` is inlined.
pub fn run<F: NullaryFnOnce>(work: F) -> F::Output {
    Arch::new().dispatch(work)
}

/// a · b; what is left over after whole lanes comes last.
#[inline(always)]
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    total(sums) + rest
}

/// x −= c a.
#[inline(always)]
pub fn subtract(x: &mut [f64], c: f64, a: &[f64]) {
    for (x, a) in x.iter_mut().zip(a) {
        *x -= c * a;
    }
}
