//! Pairing: which analytic value stands for a measured one, anew at every evaluation.
//!
//! One analytic value may serve several measured ones.
//!
//! An antiresonance takes the nearest in Hz of those that the measurement can show ([`crate::update::objective`]), ties to the
//! lower, and fades out at the edge of the band in which the model is asked for antiresonances. A mode takes the one least apart,
//!
//! ```text
//! |ln(ω_A² / ω_E²)| + (1 − MAC)²,        ties to the lower
//! ```
//!
//! The shapes decide among modes of like frequency: where two have changed places each keeps its own. As the
//! second term is at most one, no shape makes up for a frequency that is off by more than a factor √e = 1.65
//! beyond another's; so a mode far away takes no partner from a nearer one however alike the two look at a
//! few sensors, and a rigid-body mode, at ω = 0, takes none at all. With a single sensor, where every MAC is
//! one, this is the nearest frequency. Near a match the measure is what the pair adds to J, of which this
//! pairing is the lower envelope, so that J hardly jumps where a partner changes.

/// Residual given to a measured value when the model has no antiresonance to offer.
pub const UNPAIRED: f64 = 1.0;

/// The last part of the band of the analytic values in which a partner fades out: from 1.49 to 1.5 times the
/// highest measured frequency, so that all but this hundredth is e as defined. No partner there explains anything.
const FADING: f64 = 0.01 / 1.5;

/// So many roots may stand in for one that is not shown in full.
const STAND_INS: usize = 3;

/// A measured antiresonance and what the model has for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pairing {
    /// The nearest antiresonance of the model (Hz).
    pub partner_hz: Option<f64>,
    /// The residual e; [`UNPAIRED`] without a partner.
    pub residual: f64,
    /// The antiresonances (Hz) that e moves with, and ∂e/∂x_A times x_E for each, x = ω².
    pub moves_with: [Option<(f64, f64)>; STAND_INS],
}

/// One that may be the partner: e with it, how much of it is shown, and how that share moves with x_A / x_E.
#[derive(Clone, Copy, Default)]
struct Candidate {
    hz: f64,
    e: f64,
    share: f64,
    slope: f64,
}

impl Pairing {
    /// Pairs `measured_hz` with the nearest of ascending `analytic_hz`, which are all up to `limit_hz`, or none;
    /// `shown` tells how much the measurement shows of each, 0 to 1.
    ///
    /// What e would be without a partner that is not shown in full, `e'`, comes in by degrees, so that J does not
    /// jump where an antiresonance leaves the band, or where all responses come to share it:
    ///
    /// ```text
    /// e = (1 − t) (f_A² / f_E² − 1) + t |e'|,   1 − t = shown · min(1, (f_limit − f_A) / (f_limit − f_0))
    /// ```
    ///
    /// with f_0 = 1.49/1.5 f_limit. Where `shown` is below one it counts as fixed in the derivatives.
    pub fn of(analytic_hz: &[f64], shown: impl Fn(usize) -> f64, measured_hz: f64, limit_hz: f64) -> Self {
        let width = FADING * limit_hz;
        let mut partner_hz = None;
        let mut chosen = [Candidate::default(); STAND_INS];
        let mut n = 0;
        for nth in outward(analytic_hz, measured_hz) {
            let seen = shown(nth);
            if seen <= 0.0 {
                continue;
            }
            let hz = analytic_hz[nth];
            if seen >= 0.5 && partner_hz.is_none() {
                partner_hz = Some(hz);
            }
            let faded = (hz - (limit_hz - width)) / width;
            let (share, slope) = if faded <= 0.0 {
                (seen, 0.0)
            } else {
                let slope = -seen * measured_hz.powi(2) / (2.0 * hz * width);
                (seen * (1.0 - faded), slope)
            };
            let e = residual(Some(hz), measured_hz);
            chosen[n] = Candidate { hz, e, share, slope };
            n += 1;
            if share >= 1.0 || n == STAND_INS {
                break;
            }
        }
        Self::composed(partner_hz, &chosen[..n])
    }

    /// e of the nearest, with the others standing in for what is not shown of it.
    fn composed(partner_hz: Option<f64>, chosen: &[Candidate]) -> Self {
        // From the last to the first: e, and its derivatives by each.
        let (mut e, mut moves_with) = (UNPAIRED, [None; STAND_INS]);
        for (nth, one) in chosen.iter().enumerate().rev() {
            let without = e.abs();
            let rest = 1.0 - one.share;
            for (_, along) in moves_with.iter_mut().flatten() {
                *along *= rest * e.signum();
            }
            let along = one.share + one.slope * (one.e - without);
            moves_with[nth] = Some((one.hz, along));
            e = one.share * one.e + rest * without;
        }
        Self { partner_hz, residual: e, moves_with }
    }
}

/// Indices of ascending `analytic_hz` from the nearest to `measured_hz` outward, ties to the lower.
fn outward(analytic_hz: &[f64], measured_hz: f64) -> impl Iterator<Item = usize> {
    let mut above = analytic_hz.partition_point(|&a| a < measured_hz);
    let mut below = above;
    std::iter::from_fn(move || {
        let low = below.checked_sub(1);
        let lower_first = match (low, analytic_hz.get(above)) {
            (None, None) => return None,
            (Some(i), Some(&high)) => high - measured_hz >= measured_hz - analytic_hz[i],
            (low, None) => low.is_some(),
            (None, Some(_)) => false,
        };
        if lower_first {
            below -= 1;
            return Some(below);
        }
        above += 1;
        Some(above - 1)
    })
}

/// A mode of the model that stands for a measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// Number of the mode, ascending in frequency.
    pub mode: usize,
    /// λ = ω_A² in (rad/s)².
    pub lambda: f64,
    /// MAC of the two shapes.
    pub mac: f64,
}

/// The mode of ascending `lambda` least apart from one measured at `measured`, in (rad/s)²; those up to `zero` are
/// rigid-body modes and left out. None where no other is there.
pub fn least_apart(lambda: &[f64], zero: f64, measured: f64, mac: impl Fn(usize) -> f64) -> Option<Partner> {
    let mut best: Option<(f64, Partner)> = None;
    for (mode, &lambda) in lambda.iter().enumerate().filter(|(_, l)| **l > zero) {
        let apart = (lambda / measured).ln().abs();
        let least = best.map_or(f64::INFINITY, |(least, _)| least);
        if apart >= least {
            continue;
        }
        let mac = mac(mode);
        let apart = apart + (1.0 - mac).powi(2);
        if apart < least {
            best = Some((apart, Partner { mode, lambda, mac }));
        }
    }
    best.map(|(_, partner)| partner)
}

/// e = ω_A² / ω_E² − 1 of a pair, [`UNPAIRED`] without a partner.
pub fn residual(paired_hz: Option<f64>, measured_hz: f64) -> f64 {
    paired_hz.map_or(UNPAIRED, |a| (a / measured_hz).powi(2) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closer_neighbour_comes_first_and_the_lower_on_a_tie() {
        let analytic = [1.0, 2.0, 4.0];
        let order = |measured| outward(&analytic, measured).collect::<Vec<_>>();
        assert_eq!(order(0.1), [0, 1, 2]);
        assert_eq!(order(1.4), [0, 1, 2]);
        assert_eq!(order(3.0), [1, 2, 0]);
        assert_eq!(order(3.1), [2, 1, 0]);
        assert_eq!(order(9.0), [2, 1, 0]);
        assert_eq!(outward(&[], 9.0).next(), None);
    }

    /// e of 1 Hz (the highest measured, so that the limit is 1.5 Hz) when one antiresonance is at `hz` and the
    /// others at `low`; those beyond the limit are not seen.
    fn leaving(hz: f64, low: &[f64], measured_hz: f64) -> Pairing {
        let mut analytic = low.to_vec();
        analytic.extend((hz <= 1.5).then_some(hz));
        Pairing::of(&analytic, |_| 1.0, measured_hz, 1.5)
    }

    #[test]
    fn nothing_jumps_where_an_antiresonance_leaves_the_band() {
        // Alone; with another below; and for a lower measured value, for which it is far off.
        for (low, measured_hz) in [(&[][..], 1.0), (&[0.4], 1.0), (&[], 0.3)] {
            let step = 1e-6;
            let sizes: Vec<f64> = (0..30_000)
                .map(|i| leaving(1.48 + step * f64::from(i), low, measured_hz).residual.abs())
                .collect();
            let steepest = sizes.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            // Within the last 0.01 Hz it falls from what it was to what is left.
            assert!(steepest < step * (110.0 * sizes[0] + 50.0), "{steepest:e}");
            assert!((sizes[0] - residual(Some(1.48), measured_hz)).abs() < 1e-12);
            let left = residual(low.last().copied(), measured_hz).abs();
            assert!((sizes[29_999] - left).abs() < 1e-12);
        }
    }

    #[test]
    fn a_fading_residual_moves_with_both_antiresonances() {
        let (h, e) = (1e-7, 0.9);
        let at = |hz: f64, low: f64| Pairing::of(&[low, hz], |_| 1.0, e, 1.5).residual;
        let moves = Pairing::of(&[0.2, 1.496], |_| 1.0, e, 1.5).moves_with;
        for (moved, numeric) in [
            (moves[0], (at(1.496 + h, 0.2) - at(1.496 - h, 0.2)) / (2.0 * h)),
            (moves[1], (at(1.496, 0.2 + h) - at(1.496, 0.2 - h)) / (2.0 * h)),
        ] {
            // ∂e/∂f = ∂e/∂x · 2 f / E², with x = f² here.
            let (hz, along) = moved.unwrap();
            assert!((along * 2.0 * hz / e.powi(2) - numeric).abs() < 1e-6 * numeric.abs());
        }
        assert_eq!(Pairing::of(&[0.95], |_| 1.0, e, 1.5).moves_with, [Some((0.95, 1.0)), None, None]);
    }

    #[test]
    fn what_is_not_shown_is_no_partner_and_comes_in_by_degrees() {
        let roots = [0.8, 0.98, 1.1];
        let at = |share: f64| Pairing::of(&roots, |nth| if nth == 1 { share } else { 1.0 }, 1.0, 1.5);
        assert_eq!(at(0.0), Pairing::of(&[0.8, 1.1], |_| 1.0, 1.0, 1.5));
        assert_eq!(at(1.0), Pairing::of(&roots, |_| 1.0, 1.0, 1.5));
        assert_eq!((at(0.4).partner_hz, at(0.6).partner_hz), (Some(1.1), Some(0.98)));
        let (with, without) = (residual(Some(0.98), 1.0), residual(Some(1.1), 1.0));
        assert!((at(0.3).residual - (0.3 * with + 0.7 * without)).abs() < 1e-15);
        assert_eq!(at(0.3).moves_with, [Some((0.98, 0.3)), Some((1.1, 0.7)), None]);
        assert_eq!(Pairing::of(&roots, |_| 0.0, 1.0, 1.5).residual, UNPAIRED);
    }

    #[test]
    fn modes_keep_their_partners_where_they_cross_and_lose_none_to_far_ones() {
        let pair = |lambda: &[f64], mac: &[f64], measured: f64| {
            least_apart(lambda, 1e-6, measured, |mode| mac[mode]).map(|p| p.mode)
        };
        // Crossed: the nearer frequency has the other shape.
        assert_eq!(pair(&[1.0, 1.3], &[0.05, 0.97], 1.02), Some(1));
        // A mode far above, or a rigid-body mode, with exactly the shape.
        assert_eq!(pair(&[1.0, 3.0], &[0.0, 1.0], 1.02), Some(0));
        assert_eq!(pair(&[0.0, 1e-7, 1.0], &[1.0, 1.0, 0.2], 1.3), Some(2));
        // One sensor: the nearest frequency. Nothing to tell the two apart: the lower.
        assert_eq!(pair(&[0.8, 1.1], &[1.0, 1.0], 1.0), Some(1));
        assert_eq!(pair(&[1.0, 1.0], &[0.5, 0.5], 1.2), Some(0));
        // None but rigid-body modes; the only other one, however far.
        assert_eq!(pair(&[0.0], &[1.0], 1.0), None);
        assert_eq!(pair(&[0.0, 80.0], &[1.0, 0.0], 1.0), Some(1));
    }
}
