//! Block-triangular form of a pencil: its eigenvalues are those of the irreducible diagonal blocks.
//!
//! A perfect matching pairs every row with a column of non-zero entry; the strong components of the
//! directed graph row → column then give the blocks (Dulmage & Mendelsohn, Can. J. Math. 10 (1958)
//! 517-534; Pothen & Fan, ACM Trans. Math. Softw. 16 (1990) 303-324). Nothing is rounded. Where
//! response and excitation are far apart the deleted pencil is so far from normal that QZ on the whole
//! of it may move its roots by per cents, while its blocks, the parts of the structure that the path
//! between the two leaves over, are as benign as the structure itself.

use faer::MatRef;

/// One diagonal block: its rows and its columns, both ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Rows of the pencil.
    pub rows: Vec<usize>,
    /// Columns of the pencil.
    pub cols: Vec<usize>,
}

/// Irreducible blocks of A − xB; none when the pattern admits no non-zero determinant.
#[must_use]
pub fn irreducible_blocks(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Option<Vec<Block>> {
    let n = a.nrows();
    let present = |r: usize, c: usize| a[(r, c)] != 0.0 || b[(r, c)] != 0.0;
    let columns: Vec<Vec<usize>> = (0..n)
        .map(|r| (0..n).filter(|&c| present(r, c)).collect())
        .collect();
    let row_of = perfect_matching(&columns)?;
    // Edge r → s: row r has an entry in the column that is matched to row s.
    let ahead: Vec<Vec<usize>> = columns
        .iter()
        .map(|cs| cs.iter().map(|&c| row_of[c]).collect())
        .collect();
    let mut behind = vec![Vec::new(); n];
    for (r, edges) in ahead.iter().enumerate() {
        for &s in edges {
            behind[s].push(r);
        }
    }
    let mut column_of = vec![0; n];
    for (c, &r) in row_of.iter().enumerate() {
        column_of[r] = c;
    }
    let mut placed = vec![false; n];
    let mut blocks = Vec::new();
    for start in 0..n {
        if placed[start] {
            continue;
        }
        let (forward, backward) = (reach(&ahead, start), reach(&behind, start));
        let rows: Vec<usize> = (0..n).filter(|&r| forward[r] && backward[r]).collect();
        let mut cols: Vec<usize> = rows.iter().map(|&r| column_of[r]).collect();
        cols.sort_unstable();
        for &r in &rows {
            placed[r] = true;
        }
        blocks.push(Block { rows, cols });
    }
    Some(blocks)
}

/// Row matched to each column, by augmenting paths.
fn perfect_matching(columns: &[Vec<usize>]) -> Option<Vec<usize>> {
    let n = columns.len();
    let mut row_of: Vec<Option<usize>> = vec![None; n];
    for root in 0..n {
        // Breadth first over rows; `via[c]` is the row from which column c was reached.
        let mut via: Vec<Option<usize>> = vec![None; n];
        let mut queue = std::collections::VecDeque::from([root]);
        let mut free = None;
        while let Some(row) = queue.pop_front() {
            for &c in &columns[row] {
                if via[c].is_some() {
                    continue;
                }
                via[c] = Some(row);
                match row_of[c] {
                    Some(next) => queue.push_back(next),
                    None => free = Some(c),
                }
                if free.is_some() {
                    break;
                }
            }
            if free.is_some() {
                break;
            }
        }
        // Walk the path back, giving each column to the row that reached it.
        let mut column = free?;
        loop {
            let row = via[column]?;
            let given_up = (0..n).find(|&c| row_of[c] == Some(row));
            row_of[column] = Some(row);
            match given_up {
                Some(c) => column = c,
                None => break,
            }
        }
    }
    row_of.into_iter().collect()
}

fn reach(edges: &[Vec<usize>], start: usize) -> Vec<bool> {
    let mut seen = vec![false; edges.len()];
    let mut pending = vec![start];
    seen[start] = true;
    while let Some(node) = pending.pop() {
        for &next in &edges[node] {
            if !seen[next] {
                seen[next] = true;
                pending.push(next);
            }
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn a_triangular_pencil_falls_into_single_entries() {
        let a = Mat::from_fn(4, 4, |r, c| f64::from(u8::from(r >= c)));
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(4, 4).as_ref()).unwrap();
        assert_eq!(blocks.len(), 4);
        assert!(blocks.iter().all(|b| b.rows == b.cols && b.rows.len() == 1));
    }

    #[test]
    fn a_cycle_is_irreducible_and_an_empty_row_is_singular() {
        let a = Mat::from_fn(5, 5, |r, c| f64::from(u8::from(c == (r + 1) % 5 || c == r)));
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(5, 5).as_ref()).unwrap();
        assert_eq!(blocks.len(), 1);
        let singular = Mat::from_fn(3, 3, |r, _| if r == 1 { 0.0 } else { 1.0 });
        assert_eq!(
            irreducible_blocks(singular.as_ref(), singular.as_ref()),
            None
        );
    }

    #[test]
    fn an_antidiagonal_is_matched() {
        let a = Mat::from_fn(4, 4, |r, c| {
            f64::from(u8::from(r + c == 3 || (r == 0 && c == 0)))
        });
        let blocks = irreducible_blocks(a.as_ref(), Mat::zeros(4, 4).as_ref()).unwrap();
        let entries: usize = blocks.iter().map(|b| b.rows.len()).sum();
        assert_eq!(entries, 4);
    }
}
