//! The order of a multifrontal factorisation: which columns are eliminated together, and what waits for what.
//!
//! Columns with the same pattern below them form a node (a supernode); the nodes form the elimination tree. A node's front
//! is the dense matrix of its columns and of the rows below them; what is left of it after the elimination is added to
//! the front of its parent `[duff_1983]`. Subtrees do not depend on each other.

use std::ops::Range;

use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// A subtree of at most this share of the whole work is factored as one task: about 30 tasks and 30 nodes above them for
/// 20,000 and for 75,000 unknowns of a lattice. Not tuned.
const TASK_SHARE: f64 = 1.0 / 32.0;
/// Multiplications below which a subtree is one task in any case: about a millisecond. Not tuned.
const MIN_TASK: f64 = 1e6;

/// Columns that are eliminated together.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The columns, in the order of elimination.
    pub(super) columns: Range<usize>,
    /// Rows below the columns, increasing.
    pub(super) rows: Vec<u32>,
    /// Per row, its row in the parent's front.
    pub(super) in_parent: Vec<u32>,
    /// Nodes whose parent this is, increasing.
    pub(super) children: Vec<u32>,
    /// Which entries of the matrix belong to the panel.
    pub(super) entries: Range<usize>,
}

/// An entry of the matrix and its place in the panel of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) entry: u32,
    pub(super) at: u32,
    /// Whether the place is in the lower triangle only after a reflection.
    pub(super) is_conjugate: bool,
}

/// The elimination tree, cut into tasks.
#[derive(Clone, Debug)]
pub(super) struct Fronts {
    pub(super) nodes: Vec<Node>,
    pub(super) sources: Vec<Source>,
    /// Subtrees that are factored one node after the other, increasing.
    pub(super) subtrees: Vec<Vec<u32>>,
    /// The nodes above them, each level after the last.
    pub(super) levels: Vec<Vec<u32>>,
}

impl Node {
    /// Number of rows of the panel.
    pub(super) fn height(&self) -> usize {
        self.columns.len() + self.rows.len()
    }

    /// About how many multiplications its elimination takes.
    fn work(&self) -> f64 {
        let height = self.height() as f64;
        self.columns.len() as f64 * height * height
    }
}

impl Fronts {
    /// The fronts of a matrix of this pattern; `place` is the position of each unknown in the order of elimination.
    pub(super) fn new(
        symbolic: &SymbolicSupernodalCholesky<u32>,
        place: &[u32],
        lower: SymbolicSparseColMatRef<'_, u32>,
    ) -> Self {
        let mut node_of = vec![0u32; symbolic.nrows()];
        let mut nodes: Vec<Node> = (0..symbolic.n_supernodes())
            .map(|k| {
                let columns = symbolic.supernode(k).start()..symbolic.supernode_end()[k] as usize;
                node_of[columns.clone()].fill(k as u32);
                Node {
                    columns,
                    rows: symbolic.supernode(k).pattern().to_vec(),
                    in_parent: Vec::new(),
                    children: Vec::new(),
                    entries: 0..0,
                }
            })
            .collect();
        let parents = link(&mut nodes, &node_of);
        let sources = sources(&mut nodes, &node_of, place, lower);
        let (subtrees, levels) = tasks(&nodes, &parents);
        Self { nodes, sources, subtrees, levels }
    }
}

/// Finds the parent of every node: the node of the first row below it.
fn link(nodes: &mut [Node], node_of: &[u32]) -> Vec<Option<u32>> {
    let mut parents = vec![None; nodes.len()];
    for k in 0..nodes.len() {
        let Some(&first) = nodes[k].rows.first() else { continue };
        let parent = &nodes[node_of[first as usize] as usize];
        let mut below = 0;
        nodes[k].in_parent = nodes[k]
            .rows
            .iter()
            .map(|&row| match (row as usize).checked_sub(parent.columns.start) {
                Some(column) if column < parent.columns.len() => column as u32,
                _ => {
                    below += parent.rows[below..].partition_point(|&r| r < row);
                    (parent.columns.len() + below) as u32
                }
            })
            .collect();
        parents[k] = Some(node_of[first as usize]);
        nodes[node_of[first as usize] as usize].children.push(k as u32);
    }
    parents
}

/// Where the entries of the matrix go, node by node.
fn sources(nodes: &mut [Node], node_of: &[u32], place: &[u32], lower: SymbolicSparseColMatRef<'_, u32>) -> Vec<Source> {
    let mut of_node: Vec<(u32, Source)> = Vec::with_capacity(lower.row_idx().len());
    for j in 0..lower.ncols() {
        let begin = lower.col_ptr()[j];
        for (&i, entry) in lower.row_idx_of_col_raw(j).iter().zip(begin..) {
            let (row, column) = (place[i as usize], place[j]);
            let (below, left) = (row.max(column), row.min(column) as usize);
            let node = &nodes[node_of[left] as usize];
            let local = match (below as usize) < node.columns.end {
                true => below as usize - node.columns.start,
                false => node.columns.len() + node.rows.partition_point(|&r| r < below),
            };
            let at = ((left - node.columns.start) * node.height() + local) as u32;
            of_node.push((node_of[left], Source { entry, at, is_conjugate: row < column }));
        }
    }
    of_node.sort_by_key(|s| s.0);
    for group in of_node.chunk_by(|a, b| a.0 == b.0) {
        let first = of_node.partition_point(|s| s.0 < group[0].0);
        nodes[group[0].0 as usize].entries = first..first + group.len();
    }
    of_node.into_iter().map(|s| s.1).collect()
}

/// Cuts the tree into subtrees of about equal work and the levels above them.
fn tasks(nodes: &[Node], parents: &[Option<u32>]) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
    let mut work: Vec<f64> = nodes.iter().map(Node::work).collect();
    for k in 0..nodes.len() {
        if let Some(p) = parents[k] {
            work[p as usize] += work[k];
        }
    }
    let total: f64 = (0..nodes.len()).filter(|&k| parents[k].is_none()).map(|k| work[k]).sum();
    let limit = (TASK_SHARE * total).max(MIN_TASK);
    // The root of the subtree that a node belongs to.
    let mut root: Vec<Option<usize>> = vec![None; nodes.len()];
    for k in (0..nodes.len()).rev() {
        let above = parents[k].and_then(|p| root[p as usize]);
        root[k] = above.or_else(|| (work[k] <= limit).then_some(k));
    }
    let mut subtrees: Vec<Vec<u32>> = vec![Vec::new(); nodes.len()];
    let (mut levels, mut level): (Vec<Vec<u32>>, Vec<usize>) = (Vec::new(), vec![0; nodes.len()]);
    for k in 0..nodes.len() {
        if let Some(root) = root[k] {
            subtrees[root].push(k as u32);
            continue;
        }
        levels.resize(levels.len().max(level[k] + 1), Vec::new());
        levels[level[k]].push(k as u32);
        if let Some(p) = parents[k] {
            level[p as usize] = level[p as usize].max(level[k] + 1);
        }
    }
    subtrees.retain(|s| !s.is_empty());
    (subtrees, levels)
}
