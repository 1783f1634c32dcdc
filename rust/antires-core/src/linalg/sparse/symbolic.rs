//! The ordering that keeps L sparse (approximate minimum degree: Amestoy, Davis & Duff, SIAM J. Matrix Anal.
//! Appl. 17 (1996) 886-905), and the blocks of columns of one structure (supernodes) of L; both are faer's.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SymbolicSparseColMat, SymbolicSparseColMatRef};

use super::pattern::Pattern;

/// What is known of the factors of every matrix of one pattern.
#[derive(Debug)]
pub struct Symbolic {
    /// `order[new] = old`.
    order: Vec<usize>,
    pattern: Arc<Pattern>,
    origin: Vec<usize>,
    /// The pattern as faer takes it.
    matrix: SymbolicSparseColMat<u32>,
    supernodes: SymbolicSupernodalCholesky<u32>,
    flops: f64,
}

impl Symbolic {
    /// Analysis of a pattern; none for one that is too large.
    #[must_use]
    pub fn new(pattern: &Pattern) -> Option<Self> {
        let n = pattern.n();
        if u32::try_from(pattern.len()).is_err() {
            return None;
        }
        let order = minimum_degree(pattern)?;
        let (permuted, origin) = pattern.permuted(&order);
        let starts: Vec<u32> = permuted.starts().iter().map(|&s| s as u32).collect();
        let own = SymbolicSparseColMat::new_checked(n, n, starts, None, permuted.rows().to_vec());
        let matrix = own.as_ref();
        let mut parents = vec![0_i32; n];
        let mut counts = vec![0_u32; n];
        let memory = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, pattern.len())
            .or(factorize_supernodal_symbolic_cholesky_scratch::<u32>(n));
        let mut memory = MemBuffer::try_new(memory).ok()?;
        let stack = MemStack::new(&mut memory);
        let tree =
            simplicial::prefactorize_symbolic_cholesky(&mut parents, &mut counts, matrix, stack);
        let supernodes = factorize_supernodal_symbolic_cholesky(
            matrix,
            tree,
            &counts,
            stack,
            Default::default(),
        )
        .ok()?;
        let flops = counts.iter().map(|&c| f64::from(c).powi(2)).sum();
        Some(Self {
            order,
            pattern: Arc::new(permuted),
            origin,
            matrix: own,
            supernodes,
            flops,
        })
    }

    /// `order[new] = old`.
    #[must_use]
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The pattern in the new order.
    #[must_use]
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// For each place of [`pattern`](Self::pattern) its number in the one analysed.
    #[must_use]
    pub fn origin(&self) -> &[usize] {
        &self.origin
    }

    /// Multiplications and additions of a factorization.
    #[must_use]
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Number of values of L.
    #[must_use]
    pub fn n_values(&self) -> usize {
        self.supernodes.len_val()
    }

    pub(super) fn supernodes(&self) -> &SymbolicSupernodalCholesky<u32> {
        &self.supernodes
    }

    /// The pattern in the new order, as faer takes it.
    pub(super) fn matrix(&self) -> SymbolicSparseColMatRef<'_, u32> {
        self.matrix.as_ref()
    }
}

fn minimum_degree(pattern: &Pattern) -> Option<Vec<usize>> {
    let n = pattern.n();
    let starts: Vec<u32> = pattern.starts().iter().map(|&s| s as u32).collect();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, pattern.rows());
    let (mut order, mut place) = (vec![0_u32; n], vec![0_u32; n]);
    let memory = amd::order_maybe_unsorted_scratch::<u32>(n, pattern.len());
    let mut memory = MemBuffer::try_new(memory).ok()?;
    let stack = MemStack::new(&mut memory);
    amd::order_maybe_unsorted(&mut order, &mut place, matrix, Default::default(), stack).ok()?;
    Some(order.into_iter().map(|old| old as usize).collect())
}
