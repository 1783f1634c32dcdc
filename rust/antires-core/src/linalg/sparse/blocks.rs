//! The blocks of columns of L that have one structure: each a dense matrix, column after column.

use super::symbolic::Symbolic;

/// A block of columns of one structure.
pub(super) struct Block<'a> {
    /// First column.
    pub first: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of rows, those of the diagonal block counted.
    pub height: usize,
    /// Where its values begin.
    pub values: usize,
    /// Rows below the diagonal block.
    pub rows: &'a [u32],
}

fn block(symbolic: &Symbolic, s: usize) -> Block<'_> {
    let nodes = symbolic.supernodes();
    let (first, end) = (nodes.supernode_begin()[s], nodes.supernode_end()[s]);
    let rows = nodes.supernode(s).pattern();
    let width = (end - first) as usize;
    Block {
        first: first as usize,
        width,
        height: width + rows.len(),
        values: nodes.col_ptr_for_val()[s] as usize,
        rows,
    }
}

/// The blocks of L, from the first column on.
pub(super) fn blocks(symbolic: &Symbolic) -> impl DoubleEndedIterator<Item = Block<'_>> {
    (0..symbolic.supernodes().n_supernodes()).map(|s| block(symbolic, s))
}

impl Block<'_> {
    /// Column `c` of L.
    #[inline(always)]
    pub fn column<'v>(&self, values: &'v [f64], c: usize) -> &'v [f64] {
        &values[self.values + c * self.height..][..self.height]
    }
}
