//! Random numbers: ChaCha8, one master seed, one independent stream per island.
//!
//! The generator is named (ChaCha with 8 rounds, D. J. Bernstein, *ChaCha, a variant of Salsa20*,
//! 2008), so its bits do not change with a library's version. The 256-bit key is four outputs of
//! SplitMix64 (Steele, Lea & Flood, OOPSLA 2014) started from the master seed; the 64-bit stream
//! number is the cipher's nonce. Streams of one key never overlap, and a stream's position is one
//! number, so a generator can be stored and taken up again: see [`RngState`].
//!
//! The conversions to floats are written here, so that they too stay the same:
//!
//! | draw | formula |
//! |---|---|
//! | [`Rng::unit`] | `(u64 >> 11) * 2^-53`, in `[0, 1)` |
//! | [`Rng::uniform`] | `lo + (hi - lo) * unit`, never above `hi` |
//! | [`Rng::coin`] | `unit < p` |

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

/// The spacing of the 53-bit fractions: `2^-53`.
const FRACTION: f64 = 1.0 / (1_u64 << 53) as f64;

/// Where a generator stands: enough to continue it, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RngState {
    /// The master seed.
    pub seed: u64,
    /// The stream number.
    pub stream: u64,
    /// 32-bit words drawn so far.
    pub word: u128,
}

/// A random generator: one stream of a master seed.
#[derive(Debug, Clone)]
pub struct Rng {
    seed: u64,
    cipher: ChaCha8Rng,
}

impl Rng {
    /// The beginning of stream `stream` of the master seed `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut cipher = ChaCha8Rng::from_seed(key(seed));
        cipher.set_stream(stream);
        Self { seed, cipher }
    }

    /// The generator that continues from `state`.
    pub fn restore(state: RngState) -> Self {
        let mut rng = Self::new(state.seed, state.stream);
        rng.cipher.set_word_pos(state.word);
        rng
    }

    /// Where the generator stands now.
    pub fn state(&self) -> RngState {
        RngState { seed: self.seed, stream: self.cipher.get_stream(), word: self.cipher.get_word_pos() }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.cipher.next_u64()
    }

    /// Uniform in `[0, 1)`, on a grid of `2^-53`.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * FRACTION
    }

    /// Uniform in `[lo, hi)`, or exactly `lo` where the two are equal. Rounding may return `hi`.
    #[inline]
    pub fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        (lo + (hi - lo) * self.unit()).min(hi)
    }

    /// True with probability `p`: never for 0, always for 1.
    #[inline]
    pub fn coin(&mut self, p: f64) -> bool {
        self.unit() < p
    }
}

/// The cipher's key for a master seed: four SplitMix64 outputs, little endian.
fn key(seed: u64) -> [u8; 32] {
    let mut state = seed;
    let mut key = [0; 32];
    for word in key.chunks_exact_mut(8) {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        word.copy_from_slice(&(z ^ (z >> 31)).to_le_bytes());
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_starts_with_the_published_splitmix_outputs() {
        // First two outputs of SplitMix64 from state 0.
        let key = key(0);
        assert_eq!(key[..8], 0xE220_A839_7B1D_CDAF_u64.to_le_bytes());
        assert_eq!(key[8..16], 0x6E78_9E6A_A1B9_65F4_u64.to_le_bytes());
    }

    #[test]
    fn the_cipher_is_chacha8() {
        // Keystream of ChaCha8, 256-bit zero key, zero nonce (Strombergson's test vectors, TC1).
        let mut cipher = ChaCha8Rng::from_seed([0; 32]);
        let mut bytes = [0; 8];
        cipher.fill_bytes(&mut bytes);
        assert_eq!(bytes, [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]);
    }

    #[test]
    fn streams_and_seeds_differ_and_repeat() {
        let first = |seed, stream| {
            let mut rng = Rng::new(seed, stream);
            [rng.bits(), rng.bits(), rng.bits()]
        };
        assert_eq!(first(7, 3), first(7, 3));
        assert_ne!(first(7, 3), first(7, 4));
        assert_ne!(first(7, 3), first(8, 3));
    }

    #[test]
    fn unit_and_uniform_stay_in_range_with_the_right_mean() {
        let mut rng = Rng::new(1, 0);
        let n = 100_000;
        let mut sum = 0.0;
        for _ in 0..n {
            let u = rng.unit();
            assert!((0.0..1.0).contains(&u));
            sum += u;
            let v = rng.uniform(-3.0, 5.0);
            assert!((-3.0..=5.0).contains(&v));
        }
        // Four standard errors of the mean of n uniforms.
        let mean = sum / f64::from(n);
        assert!((mean - 0.5).abs() < 4.0 * (1.0_f64 / 12.0).sqrt() / f64::from(n).sqrt());
        assert_eq!(rng.uniform(2.5, 2.5), 2.5);
    }
}
