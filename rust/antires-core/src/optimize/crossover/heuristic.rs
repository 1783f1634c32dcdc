//! Heuristic crossover: on from the worse parent through the better one.
//!
//! ```text
//! c = a + r (a - b),    d = a,    r ~ U(0, 1), one r for all genes;    a the better parent
//! ```
//!
//! Where `c` leaves the bounds, `r` is drawn again, `tries` times in all; then the children are
//! copies of the parents. Three tries are GAOT's; Meruane (2013) does not print a number.
//!
//! Z. Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs, 3rd ed., Springer
//! (1996); J. A. Joines, C. R. Houck, Proc. 1st IEEE Conf. Evolutionary Computation
//! (1994) 579-584.

use super::super::bounds::Bounds;
use crate::rng::Rng;

pub(super) fn cross(
    better: &[f64],
    worse: &[f64],
    tries: usize,
    bounds: &Bounds,
    rng: &mut Rng,
    c: &mut [f64],
    d: &mut [f64],
) {
    d.copy_from_slice(better);
    for _ in 0..tries {
        let r = rng.unit();
        for i in 0..better.len() {
            c[i] = better[i] + r * (better[i] - worse[i]);
        }
        if bounds.contain(c) {
            return;
        }
    }
    c.copy_from_slice(worse);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_child_lies_beyond_the_better_parent() {
        let bounds = Bounds::uniform(2, -10.0, 10.0).unwrap();
        let (better, worse) = ([1.0, 2.0], [0.0, 4.0]);
        let (mut c, mut d) = ([0.0; 2], [0.0; 2]);
        let mut rng = Rng::new(9, 0);
        let mut farthest = 0.0_f64;
        for _ in 0..200 {
            cross(&better, &worse, 3, &bounds, &mut rng, &mut c, &mut d);
            let r = c[0] - 1.0;
            assert!((0.0..1.0).contains(&r));
            assert!((c[1] - (2.0 - 2.0 * r)).abs() < 1e-12);
            assert_eq!(d, better);
            farthest = farthest.max(r);
        }
        assert!(farthest > 0.9);
    }

    #[test]
    fn without_room_the_parents_are_copied_after_the_tries() {
        let bounds = Bounds::uniform(2, 0.0, 1.0).unwrap();
        // The first gene sits on its bound: every step but r = 0 leaves.
        let (better, worse) = ([1.0, 0.5], [0.5, 0.5]);
        let (mut c, mut d) = ([0.0; 2], [0.0; 2]);
        let mut rng = Rng::new(9, 0);
        cross(&better, &worse, 3, &bounds, &mut rng, &mut c, &mut d);
        assert_eq!((c, d), (worse, better));
        let mut counted = Rng::new(9, 0);
        for _ in 0..3 {
            counted.unit();
        }
        assert_eq!(rng.state(), counted.state());
    }

    #[test]
    fn a_step_that_is_too_long_is_drawn_again() {
        // Half of all steps leave; with three tries one in eight pairs is copied.
        let bounds = Bounds::uniform(1, 0.0, 1.0).unwrap();
        let mut rng = Rng::new(6, 0);
        let (mut c, mut d) = ([0.0], [0.0]);
        let mut copied = 0;
        for _ in 0..8000 {
            cross(&[0.75], &[0.25], 3, &bounds, &mut rng, &mut c, &mut d);
            assert!(bounds.contain(&c));
            copied += usize::from(c == [0.25]);
        }
        // 1000 expected; four standard deviations around.
        assert!((880..=1120).contains(&copied), "{copied} copies");
    }
}
