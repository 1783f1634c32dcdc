//! Whether the poles of a Krylov space are those of the modes, also where two of them nearly coincide.
//!
//! The load is answered for before that: of two modes of nearly one frequency, as structures that are nearly square
//! or symmetric have them, the space holds a mixture, and the second enters by rounding, and late. With residuals
//! r of two poles whose θ differ by d the mixture is r / d, and what the two together have for θ is off by r² over
//! the distance of the next.
//!
//! Reference: Parlett, The Symmetric Eigenvalue Problem, SIAM 1998, sections 11.5 and 11.7.

use crate::linalg::krylov::{BlockKrylov, Krylov};

/// Residual, relative to θ, of a pole that counts as found. The eigenvalue is good to its square.
pub(super) const FOUND: f64 = 1e-6;

/// Part of a mode in the load, relative to the largest, below which a pole that is not found is rounding.
pub(super) const UNSEEN: f64 = 1e-11;

/// Relative distance of two poles from which on it is asked whether they are one.
pub(super) const CLOSE: f64 = 1e-6;

/// Largest mixture of two modes: a part of the one in the other's residue is the square of it.
const MIXTURE: f64 = 1e-8;

/// The poles of a space, θ descending.
pub(super) trait Pairs {
    fn theta(&self) -> &[f64];
    fn first(&self, j: usize) -> f64;
    fn residual(&self, j: usize) -> f64;
}

impl Pairs for Krylov {
    fn theta(&self) -> &[f64] {
        self.theta()
    }
    fn first(&self, j: usize) -> f64 {
        self.first(j).abs()
    }
    fn residual(&self, j: usize) -> f64 {
        self.residual(j)
    }
}

impl Pairs for BlockKrylov {
    fn theta(&self) -> &[f64] {
        self.theta()
    }
    fn first(&self, j: usize) -> f64 {
        self.first(j)
    }
    fn residual(&self, j: usize) -> f64 {
        self.residual(j)
    }
}

/// Whether each pole with θ of at least `least` is a mode or rounding, and no two of them are mixed.
pub(super) fn settled(space: &dyn Pairs, least: f64) -> bool {
    let theta = space.theta();
    let strongest = (0..theta.len()).fold(0.0, |m, j| f64::max(m, space.first(j)));
    let found = |j: usize| space.residual(j) <= FOUND * theta[j];
    let rounding = f64::EPSILON * theta[0];
    let unmixed = |j: usize| {
        let mixed = MIXTURE * (theta[j - 1] - theta[j]);
        !found(j - 1) || space.residual(j - 1).max(space.residual(j)) <= mixed.max(rounding)
    };
    let mut up_to_limit = theta.iter().take_while(|t| **t >= least).enumerate();
    up_to_limit.all(|(j, _)| {
        if found(j) {
            !is_close(theta, j) || unmixed(j)
        } else {
            space.first(j) <= UNSEEN * strongest
        }
    })
}

/// Whether pole `j` may be the one before it, repeated.
pub(super) fn is_close(theta: &[f64], j: usize) -> bool {
    j > 0 && theta[j - 1] - theta[j] <= CLOSE * theta[j - 1]
}

/// How far θ of pole `j` and of the one before may be from those of the modes that the two stand for.
pub(super) fn uncertainty(space: &dyn Pairs, j: usize) -> f64 {
    let theta = space.theta();
    let apart = |other: &&f64| (**other - theta[j]).abs() > CLOSE * theta[j];
    let (before, after) = theta.split_at(j);
    let others = [before.iter().rev().find(apart), after.iter().find(apart)];
    let distances = others
        .into_iter()
        .flatten()
        .map(|other| (other - theta[j]).abs());
    let gap = distances.fold(theta[j], f64::min);
    (space.residual(j).powi(2) + space.residual(j - 1).powi(2)) / gap
}
