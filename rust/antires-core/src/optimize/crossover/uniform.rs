//! Uniform crossover: every gene from either parent.
//!
//! ```text
//! (c_i, d_i) = (a_i, b_i) or (b_i, a_i), equally likely, independently per gene
//! ```
//!
//! G. Syswerda, Uniform crossover in genetic algorithms, Proc. 3rd Int. Conf. Genetic Algorithms
//! (1989) 2-9.

use crate::rng::Rng;

pub(super) fn cross(a: &[f64], b: &[f64], rng: &mut Rng, c: &mut [f64], d: &mut [f64]) {
    let mut bits = 0;
    for i in 0..a.len() {
        if i % 64 == 0 {
            bits = rng.bits();
        }
        (c[i], d[i]) = if bits & 1 == 0 {
            (a[i], b[i])
        } else {
            (b[i], a[i])
        };
        bits >>= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gene_swaps_half_the_time_and_no_value_is_lost() {
        // More genes than one word has bits.
        let a: Vec<f64> = (0..70).map(f64::from).collect();
        let b: Vec<f64> = (0..70).map(|i| f64::from(i) + 100.0).collect();
        let (mut c, mut d) = (vec![0.0; 70], vec![0.0; 70]);
        let mut rng = Rng::new(12, 0);
        let mut swaps = [0; 70];
        for _ in 0..1000 {
            cross(&a, &b, &mut rng, &mut c, &mut d);
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
