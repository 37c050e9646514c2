//! The numbers of a multifrontal factorisation `[duff_1983]`.
//!
//! The factor is the same to the last bit whatever the number of threads: what is added to a front comes from its
//! children in their order, and the tree is cut into tasks by its work alone.

use std::mem::take;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};
use rayon::prelude::*;

use crate::engine::numerics::fronts::{Fronts, Node};
use crate::engine::numerics::scalar::Scalar;

/// Columns up to which plain loops eliminate a node, and rows below them up to which plain loops update what is left:
/// calls of the dense kernels cost more there. Edge unknowns (complex) of a lattice of 13,778 triangles take 10.9 ms of
/// processor time; with 4 and 32 11.9 ms, with 16 and 64 13.3 ms, with 1 and 8 13.5 ms; the library's own factorisation,
/// column group by column group, takes 18.4 ms.
const FEW_COLUMNS: usize = 8;
const FEW_ROWS: usize = 64;

/// The lower triangle of what a node leaves to its parent, column after column.
type Update<T> = Vec<T>;

/// A pivot is not positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct NotPositive;

/// Factors the matrix with these entries. `values` are the panels of the factor, filled with zeros.
pub(super) fn factor<T: Scalar>(fronts: &Fronts, entries: &[T], values: &mut [T]) -> Result<(), NotPositive> {
    let mut panels = split(fronts, values);
    let mut updates: Vec<Update<T>> = vec![Vec::new(); fronts.nodes.len()];
    let subtrees: Vec<(&[u32], Vec<&mut [T]>)> = fronts
        .subtrees
        .iter()
        .map(|nodes| (nodes.as_slice(), nodes.iter().map(|&k| take(&mut panels[k as usize])).collect()))
        .collect();
    let left: Vec<(u32, Update<T>)> = subtrees
        .into_par_iter()
        .with_max_len(1)
        .map(|(nodes, panels)| subtree(fronts, entries, nodes, panels))
        .collect::<Result<_, _>>()?;
    left.into_iter().for_each(|(k, update)| updates[k as usize] = update);
    for level in &fronts.levels {
        let fronts_of_level: Vec<(u32, &mut [T], Vec<Update<T>>)> = level
            .iter()
            .map(|&k| {
                let children = &fronts.nodes[k as usize].children;
                let below = children.iter().map(|&c| take(&mut updates[c as usize])).collect();
                (k, take(&mut panels[k as usize]), below)
            })
            .collect();
        let left: Vec<(u32, Update<T>)> = fronts_of_level
            .into_par_iter()
            .with_max_len(1)
            .map(|(k, panel, below)| Ok((k, eliminate(fronts, entries, k, panel, &below)?)))
            .collect::<Result<_, _>>()?;
        left.into_iter().for_each(|(k, update)| updates[k as usize] = update);
    }
    Ok(())
}

/// The panels of all nodes.
fn split<'a, T>(fronts: &Fronts, values: &'a mut [T]) -> Vec<&'a mut [T]> {
    let mut rest = values;
    let mut panels = Vec::with_capacity(fronts.nodes.len());
    for node in &fronts.nodes {
        let (panel, after) = rest.split_at_mut(node.height() * node.columns.len());
        panels.push(panel);
        rest = after;
    }
    panels
}

/// Factors a subtree; returns its root and what is left of it.
fn subtree<T: Scalar>(
    fronts: &Fronts,
    entries: &[T],
    nodes: &[u32],
    panels: Vec<&mut [T]>,
) -> Result<(u32, Update<T>), NotPositive> {
    // What waits for its parent, last the nearest: the children of a node are found from the end.
    let mut waiting: Vec<(u32, Update<T>)> = Vec::new();
    for (&k, panel) in nodes.iter().zip(panels) {
        let below: Vec<Update<T>> = fronts.nodes[k as usize]
            .children
            .iter()
            .filter_map(|&c| waiting.iter().rposition(|w| w.0 == c).map(|at| waiting.remove(at).1))
            .collect();
        waiting.push((k, eliminate(fronts, entries, k, panel, &below)?));
    }
    Ok(waiting.pop().unwrap_or_default())
}

/// Assembles the front of a node and eliminates its columns.
fn eliminate<T: Scalar>(
    fronts: &Fronts,
    entries: &[T],
    k: u32,
    panel: &mut [T],
    below: &[Update<T>],
) -> Result<Update<T>, NotPositive> {
    let node = &fronts.nodes[k as usize];
    for source in &fronts.sources[node.entries.clone()] {
        let value = entries[source.entry as usize];
        panel[source.at as usize] += if source.is_conjugate { value.conjugate() } else { value };
    }
    let (n_columns, n_rows) = (node.columns.len(), node.rows.len());
    let mut update = vec![T::from_real(0.0); n_rows * n_rows];
    for (&child, left) in node.children.iter().zip(below) {
        extend_add(node, &fronts.nodes[child as usize].in_parent, left, panel, &mut update);
    }
    let is_plain = n_columns <= FEW_COLUMNS;
    if is_plain {
        eliminate_columns(panel, n_columns)?;
    } else {
        eliminate_block(panel, n_columns)?;
    }
    if is_plain && n_rows <= FEW_ROWS {
        for column in panel.chunks_exact(node.height()) {
            rank_one(&column[n_columns..], &mut update);
        }
    } else if n_rows > 0 {
        let (_, rows) =
            MatMut::from_column_major_slice_mut(panel, node.height(), n_columns).split_at_row_mut(n_columns);
        let rows = rows.rb();
        matmul(
            MatMut::from_column_major_slice_mut(&mut update, n_rows, n_rows),
            BlockStructure::TriangularLower,
            Accum::Add,
            rows,
            BlockStructure::Rectangular,
            rows.adjoint(),
            BlockStructure::Rectangular,
            T::from_real(-1.0),
            Par::Seq,
        );
    }
    Ok(update)
}

/// Adds what is left of a child to the front of its parent.
fn extend_add<T: Scalar>(node: &Node, in_parent: &[u32], left: &[T], panel: &mut [T], update: &mut [T]) {
    let (height, n_columns, n_rows) = (node.height(), node.columns.len(), node.rows.len());
    for (j, column) in left.chunks_exact(in_parent.len()).enumerate() {
        let to = in_parent[j] as usize;
        let (target, first) = match to.checked_sub(n_columns) {
            None => (&mut panel[to * height..][..height], 0),
            Some(to) => (&mut update[to * n_rows..][..n_rows], n_columns),
        };
        for (&row, &value) in in_parent[j..].iter().zip(&column[j..]) {
            target[row as usize - first] += value;
        }
    }
}

/// Eliminates the columns of a panel one after the other.
fn eliminate_columns<T: Scalar>(panel: &mut [T], n_columns: usize) -> Result<(), NotPositive> {
    let height = panel.len() / n_columns;
    for j in 0..n_columns {
        let (column, right) = panel[j * height..].split_at_mut(height);
        let root = column[j].real_part().sqrt();
        if root.is_nan() || root <= 0.0 {
            return Err(NotPositive);
        }
        column[j] = T::from_real(root);
        column[j + 1..].iter_mut().for_each(|x| *x = x.scaled(1.0 / root));
        for (k, other) in (j + 1..n_columns).zip(right.chunks_exact_mut(height)) {
            let factor = column[k].conjugate();
            other[k..].iter_mut().zip(&column[k..]).for_each(|(y, &x)| *y -= x * factor);
        }
    }
    Ok(())
}

/// Eliminates the columns of a panel by dense kernels.
fn eliminate_block<T: Scalar>(panel: &mut [T], n_columns: usize) -> Result<(), NotPositive> {
    let height = panel.len() / n_columns;
    let (mut top, mut rows) = MatMut::from_column_major_slice_mut(panel, height, n_columns).split_at_row_mut(n_columns);
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<T>(n_columns, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    cholesky_in_place(top.rb_mut(), Default::default(), Par::Seq, stack, Default::default())
        .map_err(|_| NotPositive)?;
    solve_lower_triangular_in_place(top.rb().conjugate(), rows.rb_mut().transpose_mut(), Par::Seq);
    Ok(())
}

/// Subtracts `x xᴴ` from the lower triangle of a square matrix.
fn rank_one<T: Scalar>(x: &[T], matrix: &mut [T]) {
    for (j, column) in matrix.chunks_exact_mut(x.len().max(1)).enumerate() {
        let factor = x[j].conjugate();
        column[j..].iter_mut().zip(&x[j..]).for_each(|(y, &x)| *y -= x * factor);
    }
}
