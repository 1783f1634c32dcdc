//! The Krylov space of a load: of it alone, or, where the factors are large, one that is grown four vectors at a time.

use super::scaled::ScaledMatrices;
use super::settled::Pairs;
use crate::linalg::factors::{Factors, Form};
use crate::linalg::krylov::{BlockKrylov, Krylov, Operator, Start};

/// Values of the factors from which on a block costs no more than the load alone. It also has up to four modes of
/// one frequency, as square structures do, which leave the count of modes open otherwise.
const LARGE: usize = 20_000;

/// The space that was grown last, with the memory of both kinds.
#[derive(Default)]
pub(super) struct Space {
    alone: Krylov,
    block: BlockKrylov,
    by_block: bool,
}

/// Calls a method of the space that was grown last.
macro_rules! last {
    ($space:expr, $method:ident ( $($argument:expr),* )) => {
        if $space.by_block {
            $space.block.$method($($argument),*)
        } else {
            $space.alone.$method($($argument),*)
        }
    };
}

impl Space {
    /// Grows the space of a load on row `k` until its error is negligible for all x + σ up to `highest`, and until
    /// `settled` says so. `matrices` hold the factors of K + σM.
    pub fn grow(
        &mut self,
        matrices: &ScaledMatrices,
        (k, start): (usize, Start),
        highest: f64,
        settled: impl Fn(&dyn Pairs) -> bool,
    ) -> bool {
        let n = matrices.n();
        if let (Factors::Sparse(_, factors), Form::Sparse(mass)) =
            (matrices.factors(), matrices.mass())
            && factors.symbolic().n_values() >= LARGE
        {
            let part = |row: usize| matrices.structure().part(row);
            let joined = |row: usize| part(row) == part(k);
            let at = (factors, mass);
            self.by_block = self
                .block
                .grow(at, (k, joined), highest, n, |space| settled(space));
            if self.by_block {
                return true;
            }
        }
        self.by_block = false;
        let mut load = vec![0.0; matrices.stride()];
        load[k] = 1.0;
        let op = Operator {
            shifted: matrices.factors(),
            mass: matrices.mass(),
            outside: (&[], &[]),
        };
        let settled = |space: &Krylov| settled(space);
        self.alone.grow(op, (&load, start), highest, n, settled)
    }

    /// The poles.
    pub fn pairs(&self) -> &dyn Pairs {
        if self.by_block {
            &self.block
        } else {
            &self.alone
        }
    }

    /// θ_j = 1 / (λ_j + σ), descending.
    pub fn theta(&self) -> &[f64] {
        last!(self, theta())
    }

    /// Part of pole `j` in the start.
    pub fn first(&self, j: usize) -> f64 {
        last!(self, first(j))
    }

    /// ‖A⁻¹M v − θ v‖ of v = Q y_j.
    pub fn residual(&self, j: usize) -> f64 {
        last!(self, residual(j))
    }

    /// Part of the load in y_j, over θ_j.
    pub fn strength(&self, j: usize) -> f64 {
        last!(self, strength(j))
    }

    /// Entry `i` of the response at x = −σ.
    pub fn response(&self, i: usize) -> f64 {
        last!(self, response(i))
    }

    /// Largest modulus of it.
    pub fn largest_response(&self) -> f64 {
        last!(self, largest_response())
    }

    /// Entry `i` of every Q y_j, into `out`.
    pub fn row(&self, i: usize, out: &mut Vec<f64>) {
        last!(self, row(i, out));
    }

    /// Appends v = Q y_j and M v.
    pub fn vector(&self, j: usize, mass: &Form, weighted: &mut Vec<f64>, vectors: &mut Vec<f64>) {
        if !self.by_block {
            return self.alone.vector(j, weighted, vectors);
        }
        let at = vectors.len();
        self.block.vector(j, vectors);
        weighted.resize(vectors.len(), 0.0);
        mass.multiply(&vectors[at..], &mut weighted[at..]);
    }
}
