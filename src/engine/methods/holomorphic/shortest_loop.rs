//! Shortest loops of the dual graph that cross chains of edges in a certain way.

use std::collections::VecDeque;

use glam::DVec3;

use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::strip::Strip;
use crate::engine::numerics::PathSearch;
use crate::engine::run::{Cancelled, RunContext};

/// The shortest loop through `root` (more exactly: the loop made of two shortest paths from it and an edge) over faces that are
/// not taken, among those whose crossings `accepts` likes: its length, model units, the strip without what the paths share, and
/// the parities of its crossings. O(F log F).
pub(super) fn shortest_loop(
    ctx: &RunContext,
    mesh: &TriMesh,
    is_taken: &[bool],
    bits: &[u128],
    root: usize,
    accepts: &dyn Fn(u128) -> bool,
) -> Result<Option<(f64, Strip, u128)>, Cancelled> {
    ctx.check()?;
    let centre = |f: usize| mesh.triangle(f).iter().sum::<DVec3>() / 3.0;
    let Some(root) = nearest_free(mesh, is_taken, root) else { return Ok(None) };
    let mut search = PathSearch::new(mesh.n_faces());
    let mut parity = vec![0u128; mesh.n_faces()];
    search.start(root as u32, 0.0);
    let mut is_done = vec![false; mesh.n_faces()];
    let mut best: Option<(f64, usize, u128)> = None;
    while let Some((here, f)) = search.nearest() {
        // Both paths of a loop that closes from here on are as long as this one, at least.
        if best.is_some_and(|b| 2.0 * here > b.0) {
            break;
        }
        let f = f as usize;
        is_done[f] = true;
        if let Some(h) = search.via(f as u32) {
            parity[f] = parity[h as usize / 3] ^ bits[h as usize];
        }
        for h in 3 * f..3 * f + 3 {
            let Some(t) = mesh.twin(h).filter(|t| !is_taken[t / 3]) else { continue };
            let step = centre(f).distance(centre(t / 3));
            if !is_done[t / 3] {
                search.reach((t / 3) as u32, here + step, h as u32, f as u32);
                continue;
            }
            let class = parity[f] ^ parity[t / 3] ^ bits[h];
            let length = here + search.distance((t / 3) as u32) + step;
            if class != 0 && best.is_none_or(|b| length < b.0) && accepts(class) {
                best = Some((length, h, class));
            }
        }
    }
    let Some((length, h, class)) = best else { return Ok(None) };
    // Halfedges crossed from the root to a face.
    let path = |f: usize| {
        let mut crossed = Vec::new();
        let mut at = f;
        while let Some(h) = search.via(at as u32) {
            crossed.push(h as usize);
            at = h as usize / 3;
        }
        crossed.reverse();
        crossed
    };
    let (there, back) = (path(h / 3), mesh.twin(h).map_or_else(Vec::new, |t| path(t / 3)));
    let shared = there.iter().zip(&back).take_while(|(a, b)| a == b).count();
    let mut crossed = there[shared..].to_vec();
    crossed.push(h);
    crossed.extend(back[shared..].iter().rev().filter_map(|&h| mesh.twin(h)));
    Ok(Some((length, Strip { crossed }, class)))
}

/// The face itself, or one near it that is not taken.
fn nearest_free(mesh: &TriMesh, is_taken: &[bool], face: usize) -> Option<usize> {
    let mut is_seen = vec![false; mesh.n_faces()];
    let mut queue = VecDeque::from([face]);
    is_seen[face] = true;
    while let Some(f) = queue.pop_front() {
        if !is_taken[f] {
            return Some(f);
        }
        for t in (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)) {
            if !std::mem::replace(&mut is_seen[t / 3], true) {
                queue.push_back(t / 3);
            }
        }
    }
    None
}
