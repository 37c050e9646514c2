//! Generators of homology by a tree and a cotree `[erickson_2005]`, each with the closed form that counts crossings.

use std::collections::VecDeque;

use crate::engine::calculus::chain::Step;
use crate::engine::calculus::forms::OneForm;
use crate::engine::calculus::signs::Signs;
use crate::engine::mesh::{ShortestPaths, TriMesh};
use crate::engine::numerics::DisjointSets;
use crate::engine::run::{Cancelled, RunContext};

/// How a form meets the boundary. On closed surfaces both are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Its vectors are tangential to the boundary: nothing flows across it.
    #[default]
    Tangential,
    /// Its vectors are normal to the boundary: it vanishes along boundary edges.
    Normal,
}

/// A generator of homology.
#[derive(Clone, Debug)]
pub struct Generator {
    /// A closed chain of edges without what its two ends share; with [`Side::Normal`] it may lead from boundary to boundary.
    pub chain: Vec<Step>,
    /// Its length, model units.
    pub length: f64,
    /// A closed form of integers: integral 1 along this generator, 0 along all others.
    pub closed: OneForm,
}

/// Generators of the homology of a connected surface, shortest first: 2g on closed ones, 2g + b − 1 with b boundary loops. For
/// [`Side::Normal`] they are relative to the boundary. Shortest paths begin at vertex `root`, there at the boundary.
/// O(F log F + g F).
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn generators(ctx: &RunContext, mesh: &TriMesh, side: Side, root: u32) -> Result<Vec<Generator>, Cancelled> {
    let n_vertices = mesh.n_vertices() as u32;
    let on_boundary: Vec<u32> = match side {
        Side::Normal => (0..n_vertices).filter(|&v| mesh.is_boundary_vertex(v)).collect(),
        Side::Tangential => Vec::new(),
    };
    let sources = if on_boundary.is_empty() { vec![root.min(n_vertices.saturating_sub(1))] } else { on_boundary };
    let paths = ShortestPaths::new(mesh, sources.into_iter());
    ctx.check()?;
    let mut is_tree = vec![false; mesh.n_halfedges()];
    for h in paths.by.iter().copied().flatten() {
        is_tree[h] = true;
        mesh.twin(h).into_iter().for_each(|t| is_tree[t] = true);
    }
    let is_dual = |h: &usize| match side {
        Side::Normal => !mesh.is_boundary(*h),
        Side::Tangential => true,
    };
    let mut edges: Vec<usize> =
        (0..mesh.n_halfedges()).filter(|h| mesh.is_edge_owner(*h) && !is_tree[*h] && is_dual(h)).collect();
    let across: Vec<f64> = (0..mesh.n_halfedges()).map(|h| paths.across(mesh, h)).collect();
    edges.sort_by(|&a, &b| across[b].total_cmp(&across[a]).then(a.cmp(&b)));
    // All that lies beyond the boundary is one face.
    let outside = mesh.n_faces();
    let mut faces = DisjointSets::new(mesh.n_faces() + 1);
    let mut is_cotree = vec![false; mesh.n_halfedges()];
    let mut left = Vec::new();
    for h in edges {
        let beyond = mesh.twin(h).map_or(outside, |t| t / 3);
        if faces.join(h as u32 / 3, beyond as u32) {
            is_cotree[h] = true;
            mesh.twin(h).into_iter().for_each(|t| is_cotree[t] = true);
        } else {
            left.push(h);
        }
    }
    ctx.check()?;
    left.reverse();
    let up = towards_root(mesh, &is_cotree);
    let signs = Signs::trivial(mesh);
    let generator = |&h: &usize| {
        let mut closed = OneForm::zero(mesh);
        closed.add_along(mesh, &signs, h, 1.0);
        let mut follow = |mut f: usize, value: f64| {
            while let Some(x) = up.get(f).copied().flatten() {
                closed.add_along(mesh, &signs, x, value);
                f = mesh.twin(x).map_or(outside, |t| t / 3);
            }
        };
        follow(h / 3, -1.0);
        follow(mesh.twin(h).map_or(outside, |t| t / 3), 1.0);
        let chain = chain(&paths, mesh, h);
        let length = chain.iter().map(|s| mesh.position(s.from(mesh)).distance(mesh.position(s.to(mesh)))).sum();
        Generator { chain, length, closed }
    };
    Ok(left.iter().map(generator).collect())
}

/// Per face the halfedge across which the cotree leads to its root: the outside if it is a part of it, else the first face.
fn towards_root(mesh: &TriMesh, is_cotree: &[bool]) -> Vec<Option<usize>> {
    let mut up: Vec<Option<usize>> = vec![None; mesh.n_faces()];
    let mut is_reached = vec![false; mesh.n_faces()];
    let mut queue = VecDeque::new();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h) && is_cotree[h]) {
        if !is_reached[h / 3] {
            is_reached[h / 3] = true;
            up[h / 3] = Some(h);
            queue.push_back(h / 3);
        }
    }
    if queue.is_empty() && mesh.n_faces() > 0 {
        is_reached[0] = true;
        queue.push_back(0);
    }
    while let Some(f) = queue.pop_front() {
        for t in (3 * f..3 * f + 3).filter(|&h| is_cotree[h]).filter_map(|h| mesh.twin(h)) {
            if !is_reached[t / 3] {
                is_reached[t / 3] = true;
                up[t / 3] = Some(t);
                queue.push_back(t / 3);
            }
        }
    }
    up
}

/// The paths to both ends of `h` and the edge itself, without what the paths share.
fn chain(paths: &ShortestPaths, mesh: &TriMesh, h: usize) -> Vec<Step> {
    // Steps from the source of a vertex to it.
    let path = |mut v: u32| {
        let mut steps = Vec::new();
        while let Some(by) = paths.by[v as usize] {
            let step = Step { halfedge: by, is_reversed: mesh.target(by) != v };
            v = step.from(mesh);
            steps.push(step);
        }
        steps.reverse();
        steps
    };
    let (there, back) = (path(mesh.origin(h)), path(mesh.target(h)));
    let shared = there.iter().zip(&back).take_while(|(a, b)| a == b).count();
    let reversed = |s: &Step| Step { halfedge: s.halfedge, is_reversed: !s.is_reversed };
    let mut chain = there[shared..].to_vec();
    chain.push(Step { halfedge: h, is_reversed: false });
    chain.extend(back[shared..].iter().rev().map(reversed));
    chain
}
