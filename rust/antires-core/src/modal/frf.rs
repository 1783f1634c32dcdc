//! Frequency response functions by modal superposition.
//!
//! ```text
//! receptance    H(ω) = Σ_r φ_ir φ_kr / (ω_r² − ω² + 2 j ζ_r ω_r ω) + d_ik     [m/N]
//! mobility      j ω H(ω)                                                     [m/(N s)]
//! accelerance   −ω² H(ω)                                                     [m/(N s²)]
//! ```
//!
//! Source: Ewins, Modal Testing, 2nd ed. (2000), section 2.4.

use std::f64::consts::TAU;

use super::modes::AllModes;

/// The motion quantity of a frequency response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Displacement over force.
    Receptance,
    /// Velocity over force.
    Mobility,
    /// Acceleration over force.
    Accelerance,
}

/// H(ω) of each response, [n_responses x n_freq] row by row, as (real, imaginary) pairs.
///
/// `damping_ratio` holds one ζ for every mode, or one value for all.
#[must_use]
pub fn frequency_response(
    modes: &AllModes,
    responses: &[usize],
    excitation: usize,
    freq_hz: &[f64],
    damping_ratio: &[f64],
    motion: Motion,
) -> Vec<(f64, f64)> {
    let (lambda, phi) = (&modes.lambda, modes.vectors.as_ref());
    let n = phi.nrows();
    let mut out = vec![(0.0, 0.0); responses.len() * freq_hz.len()];
    for (row, &i) in out.chunks_exact_mut(freq_hz.len().max(1)).zip(responses) {
        let massless: f64 = (lambda.len()..n)
            .map(|r| phi[(i, r)] * phi[(excitation, r)])
            .sum();
        for (h, &f) in row.iter_mut().zip(freq_hz) {
            let omega = TAU * f;
            let (mut re, mut im) = scaled(massless, 0.0, omega, motion);
            for (r, &l) in lambda.iter().enumerate() {
                let residue = phi[(i, r)] * phi[(excitation, r)];
                let zeta = damping_ratio[if damping_ratio.len() == 1 { 0 } else { r }];
                let (dr, di) = (l - omega * omega, 2.0 * zeta * l.max(0.0).sqrt() * omega);
                if dr == 0.0 && di == 0.0 {
                    // A rigid-body mode at standstill: only the accelerance has a limit there.
                    re += if motion == Motion::Accelerance {
                        residue
                    } else {
                        f64::INFINITY * residue
                    };
                    continue;
                }
                let size = dr * dr + di * di;
                let (a, b) = scaled(residue * dr / size, -residue * di / size, omega, motion);
                re += a;
                im += b;
            }
            *h = (re, im);
        }
    }
    out
}

/// (re + j im) times 1, jω or −ω².
fn scaled(re: f64, im: f64, omega: f64, motion: Motion) -> (f64, f64) {
    match motion {
        Motion::Receptance => (re, im),
        Motion::Mobility => (-omega * im, omega * re),
        Motion::Accelerance => (-omega * omega * re, -omega * omega * im),
    }
}
