//! What a measurement can show of the model's roots.
//!
//! Where a mode has a node at sensor i, the root of det(K_ik − x M_ik) on its pole cancels in H_ik: the FRF shows
//! nothing. But H_jk of another sensor has the pole, so T_ji = H_jk / H_ik has a peak there. Transmissibilities lose
//! only those roots that all measured responses have: of a mode on whose node the force sits, or of a part of the
//! structure that lies on the other side of the force.
//!
//! | source | roots of response i that it shows |
//! |---|---|
//! | FRFs | the zeros of H_ik |
//! | transmissibilities | all of the deleted pencil, less those that every response measured with it has |
//! | not known | all may be partners of what was measured |
//!
//! A model that is nearly symmetric has them all, hardly apart. So that J does not jump where a symmetry breaks, a
//! root that all responses share comes in by degrees, as they part.

/// What a set of antiresonances was identified from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sees {
    /// Frequency response functions.
    Frf,
    /// Quotients of responses.
    Transmissibility,
    /// Not known.
    #[default]
    Unknown,
}

/// Relative distance in Hz up to which roots of two responses are one, and from which on both are seen in full.
/// Identification reports none that come so near in all responses.
const ONE: f64 = 1e-6;
const APART: f64 = 1e-3;

/// How much transmissibilities show of `own[nth]`, a root of one response: 0 if all `others` share it, 1 if one of
/// them does not. All lists ascending, in Hz.
#[must_use]
pub fn shown<'a>(own: &[f64], nth: usize, others: impl Iterator<Item = &'a [f64]>) -> f64 {
    let mut largest: Option<f64> = None;
    for other in others {
        let share = ((apart(own, nth, other) - ONE) / (APART - ONE)).clamp(0.0, 1.0);
        if share >= 1.0 {
            return 1.0;
        }
        largest = Some(largest.map_or(share, |most| most.max(share)));
    }
    // Alone, there is nothing to share with.
    largest.unwrap_or(1.0)
}

/// Relative distance of `own[nth]` from its counterpart in `other`, each root having one counterpart at most;
/// infinity without any in reach.
fn apart(own: &[f64], nth: usize, other: &[f64]) -> f64 {
    let x = own[nth];
    let near = |list: &[f64], reach: f64| {
        let first = list.partition_point(|&f| f < x - reach);
        first..list.partition_point(|&f| f <= x + reach)
    };
    let theirs = near(other, APART * x);
    if theirs.is_empty() {
        return f64::INFINITY;
    }
    // Others of this response may claim the same counterpart. The nearest pairs go first.
    let mut pairs: Vec<(f64, usize, usize)> = near(own, 2.0 * APART * x)
        .flat_map(|a| near(other, 3.0 * APART * x).map(move |b| ((own[a] - other[b]).abs(), a, b)))
        .collect();
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (distance, a, b) in pairs {
        if taken.iter().any(|&(c, d)| c == a || d == b) {
            continue;
        }
        if a == nth {
            return distance / x;
        }
        taken.push((a, b));
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::shown;

    fn of(own: &[f64], nth: usize, others: &[&[f64]]) -> f64 {
        shown(own, nth, others.iter().copied())
    }

    #[test]
    fn only_what_all_share_is_lost() {
        let own = [10.0, 20.0, 30.0];
        assert_eq!(of(&own, 1, &[&[20.0], &[15.0, 20.0]]), 0.0);
        assert_eq!(of(&own, 1, &[&[20.0], &[15.0]]), 1.0);
        assert_eq!(of(&own, 1, &[&[20.0], &[]]), 1.0);
        assert_eq!(of(&own, 1, &[]), 1.0);
    }

    #[test]
    fn one_of_two_on_a_pole_is_lost_to_one_of_the_others() {
        let own = [20.0, 20.0];
        let shares = [0, 1].map(|nth| of(&own, nth, &[&[20.0], &[20.0]]));
        assert_eq!(shares, [0.0, 1.0]);
        // However far the second has moved.
        for step in [1e-9, 1e-5, 1e-3, 1e-2] {
            let own = [20.0, 20.0 * (1.0 + step)];
            assert_eq!(of(&own, 1, &[&[20.0], &[20.0]]), 1.0, "{step}");
            assert_eq!(of(&own, 0, &[&[20.0], &[20.0]]), 0.0, "{step}");
        }
    }

    #[test]
    fn it_comes_in_by_degrees() {
        let at = |gap: f64| of(&[20.0], 0, &[&[20.0], &[20.0 * (1.0 + gap)]]);
        let steps: Vec<f64> = (0..2_000).map(|i| at(1e-6 * f64::from(i))).collect();
        let steepest = steps.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(steepest < 1.1e-3, "{steepest}");
        assert_eq!((steps[0], steps[1_999]), (0.0, 1.0));
    }
}
