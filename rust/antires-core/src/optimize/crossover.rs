//! Crossover: two parents, two children; one kind per island.
//!
//! Each island searches with an operator of its own, in turn over the list of the options, so the
//! islands differ in how they explore and profit from what the others found. All operators keep
//! the children inside the bounds.
//!
//! ```text
//! arithmetic   c = r a + (1 - r) b,  d = (1 - r) a + r b      r ~ U(0, 1), one r for all genes
//! heuristic    c = a + r (a - b),    d = a                    the same; a the better parent
//! blend        c_i ~ U(min(a_i, b_i) - alpha d_i, max(a_i, b_i) + alpha d_i),    d_i = |a_i - b_i|
//! uniform      (c_i, d_i) = (a_i, b_i) or (b_i, a_i), equally likely, independently per gene
//! ```
//!
//! Where the heuristic's `c` leaves the bounds, `r` is drawn again, `tries` times in all; then the children are
//! copies of the parents. Three tries are GAOT's; Meruane (2013) does not print a number. Of the blend (BLX-alpha),
//! independent per gene and child, `alpha = 0.5` favours neither contraction nor expansion; a gene that falls outside
//! its bounds is set to the bound it passed.
//!
//! V. Meruane, J. Sound Vib. 332 (2013) 807-820, doi 10.1016/j.jsv.2012.10.021. Arithmetic and heuristic:
//! Z. Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs, 3rd ed., Springer (1996); J. A. Joines,
//! C. R. Houck, Proc. 1st IEEE Conf. Evolutionary Computation (1994) 579-584. Blend: L. J. Eshelman, J. D. Schaffer,
//! Foundations of Genetic Algorithms 2 (1993) 187-202. Uniform: G. Syswerda, Proc. 3rd Int. Conf. Genetic Algorithms
//! (1989) 2-9.

use super::bounds::Bounds;
use crate::error::{Error, Result};
use crate::rng::Rng;

/// A crossover operator and its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crossover {
    /// Complementary weighted means of the parents.
    Arithmetic,
    /// A step from the worse parent through the better one, else copies.
    Heuristic {
        /// How often a step is drawn in search of one inside the bounds; at least 1, default 3.
        tries: usize,
    },
    /// BLX-alpha: every gene uniform over the parents' interval, extended.
    Blend {
        /// The extension at either end, in interval lengths; in [0, 10], default 0.5.
        alpha: f64,
    },
    /// Every gene from either parent.
    Uniform,
}

impl Crossover {
    /// The paper's four, in the order its islands use them.
    pub const PAPER: [Self; 4] =
        [Self::Arithmetic, Self::Heuristic { tries: 3 }, Self::Blend { alpha: 0.5 }, Self::Uniform];

    /// The operator of that name, with default settings.
    ///
    /// # Errors
    /// If there is none; the message lists the names.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::PAPER.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = Self::PAPER.map(|kind| format!("'{}'", kind.name())).join(", ");
            Error::input("crossovers", format!("'{name}'"), format!("one of {names}"))
                .remedy("Leave it out for one of each.")
        })
    }

    /// The operator's name: `arithmetic`, `heuristic`, `blend` or `uniform`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Arithmetic => "arithmetic",
            Self::Heuristic { .. } => "heuristic",
            Self::Blend { .. } => "blend",
            Self::Uniform => "uniform",
        }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// If one is out of its range.
    pub fn validate(&self) -> Result<()> {
        match *self {
            Self::Heuristic { tries: 0 } => {
                Err(Error::input("crossovers", "'heuristic' with 0 tries", "at least 1 try")
                    .remedy("The original takes 3."))
            }
            Self::Blend { alpha } if !(0.0..=10.0).contains(&alpha) => {
                Err(Error::input("crossovers", format!("'blend' with alpha {alpha}"), "alpha in [0, 10]")
                    .remedy("BLX-0.5 has 0.5."))
            }
            _ => Ok(()),
        }
    }

    /// Writes the children of two parents, of which `better` has the lower cost.
    pub(super) fn cross(
        &self,
        better: &[f64],
        worse: &[f64],
        bounds: &Bounds,
        rng: &mut Rng,
        first: &mut [f64],
        second: &mut [f64],
    ) {
        match *self {
            Self::Arithmetic => arithmetic(better, worse, bounds, rng, first, second),
            Self::Heuristic { tries } => {
                heuristic(better, worse, tries, bounds, rng, first, second);
            }
            Self::Blend { alpha } => {
                blend(better, worse, alpha, bounds, rng, first);
                blend(better, worse, alpha, bounds, rng, second);
            }
            Self::Uniform => uniform(better, worse, rng, first, second),
        }
    }
}

fn arithmetic(a: &[f64], b: &[f64], bounds: &Bounds, rng: &mut Rng, c: &mut [f64], d: &mut [f64]) {
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

fn heuristic(
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

fn blend(a: &[f64], b: &[f64], alpha: f64, bounds: &Bounds, rng: &mut Rng, c: &mut [f64]) {
    for i in 0..a.len() {
        let reach = alpha * (a[i] - b[i]).abs();
        c[i] = rng.uniform(a[i].min(b[i]) - reach, a[i].max(b[i]) + reach);
    }
    bounds.clip(c);
}

fn uniform(a: &[f64], b: &[f64], rng: &mut Rng, c: &mut [f64], d: &mut [f64]) {
    let mut bits = 0;
    for i in 0..a.len() {
        if i % 64 == 0 {
            bits = rng.bits();
        }
        (c[i], d[i]) = if bits & 1 == 0 { (a[i], b[i]) } else { (b[i], a[i]) };
        bits >>= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{prop, prop_assert, prop_assert_eq, proptest};

    #[test]
    fn names_lead_back_to_their_operators() {
        for kind in Crossover::PAPER {
            assert_eq!(Crossover::from_name(kind.name()), Ok(kind));
        }
        assert_eq!(
            Crossover::from_name("twopoint").unwrap_err().to_string(),
            "crossovers: got 'twopoint'; wanted one of 'arithmetic', 'heuristic', 'blend', 'uniform'. \
             Leave it out for one of each."
        );
    }

    proptest! {
        #[test]
        fn children_stay_inside_the_bounds(
            genes in prop::collection::vec((-1e3..1e3_f64, 0.0..1e3_f64, 0.0..=1.0_f64, 0.0..=1.0_f64), 1..12),
            kind in 0..4_usize,
            seed: u64,
        ) {
            let lower: Vec<f64> = genes.iter().map(|g| g.0).collect();
            let upper: Vec<f64> = genes.iter().map(|g| g.0 + g.1).collect();
            let bounds = Bounds::new(lower, upper).unwrap();
            let mut a: Vec<f64> = genes.iter().map(|g| g.0 + g.1 * g.2).collect();
            let mut b: Vec<f64> = genes.iter().map(|g| g.0 + g.1 * g.3).collect();
            bounds.clip(&mut a);
            bounds.clip(&mut b);
            let (mut c, mut d) = (vec![0.0; a.len()], vec![0.0; a.len()]);
            let mut rng = Rng::new(seed, 0);
            for _ in 0..20 {
                Crossover::PAPER[kind].cross(&a, &b, &bounds, &mut rng, &mut c, &mut d);
                prop_assert!(bounds.contain(&c) && bounds.contain(&d), "{c:?} {d:?}");
            }
        }

        #[test]
        fn equal_parents_have_equal_children(
            x in prop::collection::vec(-5.0..5.0_f64, 1..12),
            kind in 0..4_usize,
            seed: u64,
        ) {
            let bounds = Bounds::uniform(x.len(), -5.0, 5.0).unwrap();
            let (mut c, mut d) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            let mut rng = Rng::new(seed, 0);
            Crossover::PAPER[kind].cross(&x, &x, &bounds, &mut rng, &mut c, &mut d);
            prop_assert_eq!(&c, &x);
            prop_assert_eq!(&d, &x);
        }
    }

    #[test]
    fn children_lie_on_the_segment_at_complementary_fractions() {
        let bounds = Bounds::uniform(2, -10.0, 10.0).unwrap();
        let (a, b) = ([0.0, 4.0], [2.0, -4.0]);
        let (mut c, mut d) = ([0.0; 2], [0.0; 2]);
        let mut rng = Rng::new(4, 0);
        let mut fractions = Vec::new();
        for _ in 0..200 {
            arithmetic(&a, &b, &bounds, &mut rng, &mut c, &mut d);
            let r = (c[0] - b[0]) / (a[0] - b[0]);
            assert!((0.0..=1.0).contains(&r));
            assert!((c[1] - (r * a[1] + (1.0 - r) * b[1])).abs() < 1e-12);
            assert!((c[0] + d[0] - 2.0).abs() < 1e-12 && (c[1] + d[1]).abs() < 1e-12);
            fractions.push(r);
        }
        assert!(fractions.iter().any(|&r| r < 0.1) && fractions.iter().any(|&r| r > 0.9));
    }

    #[test]
    fn the_child_lies_beyond_the_better_parent() {
        let bounds = Bounds::uniform(2, -10.0, 10.0).unwrap();
        let (better, worse) = ([1.0, 2.0], [0.0, 4.0]);
        let (mut c, mut d) = ([0.0; 2], [0.0; 2]);
        let mut rng = Rng::new(9, 0);
        let mut farthest = 0.0_f64;
        for _ in 0..200 {
            heuristic(&better, &worse, 3, &bounds, &mut rng, &mut c, &mut d);
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
        heuristic(&better, &worse, 3, &bounds, &mut rng, &mut c, &mut d);
        assert_eq!((c, d), (worse, better));
        let mut counted = Rng::new(9, 0);
        for _ in 0..3 {
            counted.unit();
        }
        assert_eq!(rng.state(), counted.state());
    }

    #[test]
    fn children_fill_the_extended_interval_evenly() {
        let bounds = Bounds::uniform(1, -100.0, 100.0).unwrap();
        let mut rng = Rng::new(8, 0);
        let mut counts = [0_u32; 8];
        let draws = 80_000;
        let mut c = [0.0];
        for _ in 0..draws {
            // Parents 1 and 3: the interval is [0, 4], in eight cells of a half.
            blend(&[3.0], &[1.0], 0.5, &bounds, &mut rng, &mut c);
            assert!((0.0..=4.0).contains(&c[0]));
            counts[((2.0 * c[0]) as usize).min(7)] += 1;
        }
        let expected = f64::from(draws) / 8.0;
        let chi2: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
        // Chi-square with 7 degrees of freedom: 24.3 has probability 0.001.
        assert!(chi2 < 24.3, "chi-square {chi2}, counts {counts:?}");
    }

    #[test]
    fn each_gene_swaps_half_the_time_and_no_value_is_lost() {
        // More genes than one word has bits.
        let a: Vec<f64> = (0..70).map(f64::from).collect();
        let b: Vec<f64> = (0..70).map(|i| f64::from(i) + 100.0).collect();
        let (mut c, mut d) = (vec![0.0; 70], vec![0.0; 70]);
        let mut rng = Rng::new(12, 0);
        let mut swaps = [0; 70];
        for _ in 0..1000 {
            uniform(&a, &b, &mut rng, &mut c, &mut d);
            for i in 0..70 {
                let swapped = c[i] == b[i];
                let pair = if swapped { (b[i], a[i]) } else { (a[i], b[i]) };
                assert_eq!((c[i], d[i]), pair);
                swaps[i] += usize::from(swapped);
            }
        }
        // 500 expected of 1000; five standard deviations, for seventy genes.
        assert!(swaps.iter().all(|n| (421..=579).contains(n)), "{swaps:?}");
    }
}
