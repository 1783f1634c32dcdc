//! Arithmetic crossover: two points of the segment between the parents, symmetric to its middle.
//!
//! ```text
//! c = r a + (1 - r) b,    d = (1 - r) a + r b,    r ~ U(0, 1), one r for all genes
//! ```
//!
//! Z. Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs, 3rd ed., Springer
//! (1996): whole arithmetical crossover.

use super::super::bounds::Bounds;
use crate::rng::Rng;

pub(super) fn cross(
    a: &[f64],
    b: &[f64],
    bounds: &Bounds,
    rng: &mut Rng,
    c: &mut [f64],
    d: &mut [f64],
) {
    let r = rng.unit();
    for i in 0..a.len() {
        // Written so that equal parents give their own bits back.
        let step = r * (a[i] - b[i]);
        c[i] = b[i] + step;
        d[i] = a[i] - step;
    }
    // The segment is inside, its rounded points may miss by one unit in the last place.
    bounds.clip(c);
    bounds.clip(d);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_lie_on_the_segment_at_complementary_fractions() {
        let bounds = Bounds::uniform(2, -10.0, 10.0).unwrap();
        let (a, b) = ([0.0, 4.0], [2.0, -4.0]);
        let (mut c, mut d) = ([0.0; 2], [0.0; 2]);
        let mut rng = Rng::new(4, 0);
        let mut fractions = Vec::new();
        for _ in 0..200 {
            cross(&a, &b, &bounds, &mut rng, &mut c, &mut d);
            let r = (c[0] - b[0]) / (a[0] - b[0]);
            assert!((0.0..=1.0).contains(&r));
            assert!((c[1] - (r * a[1] + (1.0 - r) * b[1])).abs() < 1e-12);
            assert!((c[0] + d[0] - 2.0).abs() < 1e-12 && (c[1] + d[1]).abs() < 1e-12);
            fractions.push(r);
        }
        assert!(fractions.iter().any(|&r| r < 0.1) && fractions.iter().any(|&r| r > 0.9));
    }
}
