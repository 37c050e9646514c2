//! What is left of a surface between curves, cut into pairs of pants.

use std::collections::VecDeque;

use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::error::HolomorphicError;
use crate::engine::methods::holomorphic::shortest_loop::shortest_loop;
use crate::engine::methods::holomorphic::strip::{Bank, Strip};
use crate::engine::run::RunContext;

/// Searches per curve, each through another root.
const ROOTS: usize = 6;

/// A piece of the surface between the curves.
struct Piece {
    /// A face of it.
    face: usize,
    /// The halfedges of its faces whose other side is a strip, per bank of a strip that it ends at.
    holes: Vec<Vec<usize>>,
}

/// Adds shortest loops that part the holes of a piece without handles, at least two on each side, until all pieces have at
/// most three, or there is no room for a loop between the triangles of those that have more: strips may touch at vertices, and
/// leave pieces that are no wider than a triangle.
///
/// # Errors
/// A stop.
pub(super) fn cut_to_pants(
    ctx: &RunContext,
    mesh: &TriMesh,
    is_taken: &mut [bool],
    strips: &mut Vec<Strip>,
) -> Result<(), HolomorphicError> {
    // First faces of pieces without room.
    let mut full: Vec<usize> = Vec::new();
    loop {
        let pieces = pieces(mesh, is_taken, strips).into_iter();
        let mut wide = pieces.filter(|piece| piece.holes.len() > 3 && !full.contains(&piece.face));
        let Some(piece) = wide.next() else { return Ok(()) };
        let n = piece.holes.len();
        let bits = chains(mesh, is_taken, &piece);
        let accepts = |class: u128| (2..=n as u32 - 2).contains(&class.count_ones());
        let mut best: Option<(f64, Strip)> = None;
        for k in 0..ROOTS {
            let hole = &piece.holes[k * n / ROOTS % n];
            let root = hole[(k * hole.len() / ROOTS) % hole.len()] / 3;
            if let Some((length, strip, _)) = shortest_loop(ctx, mesh, is_taken, &bits, root, &accepts)?
                && best.as_ref().is_none_or(|b| length < b.0)
            {
                best = Some((length, strip));
            }
        }
        let Some((_, strip)) = best else {
            full.push(piece.face);
            continue;
        };
        strip.faces().for_each(|f| is_taken[f] = true);
        strips.push(strip);
    }
}

/// The pieces, in order of their first faces.
fn pieces(mesh: &TriMesh, is_taken: &[bool], strips: &[Strip]) -> Vec<Piece> {
    // Halfedges of free faces towards a strip, with the number of the bank.
    let mut bank_of: Vec<Option<usize>> = vec![None; mesh.n_halfedges()];
    for (i, strip) in strips.iter().enumerate() {
        for (h, bank) in strip.banks(mesh) {
            if let Some(t) = mesh.twin(h).filter(|t| !is_taken[t / 3]) {
                bank_of[t] = Some(2 * i + usize::from(bank == Bank::Right));
            }
        }
    }
    let mut is_seen = vec![false; mesh.n_faces()];
    let mut pieces = Vec::new();
    for seed in 0..mesh.n_faces() {
        if is_taken[seed] || is_seen[seed] {
            continue;
        }
        is_seen[seed] = true;
        let mut holes: Vec<Vec<usize>> = vec![Vec::new(); 2 * strips.len()];
        let mut stack = vec![seed];
        while let Some(f) = stack.pop() {
            for h in 3 * f..3 * f + 3 {
                if let Some(bank) = bank_of[h] {
                    holes[bank].push(h);
                } else if let Some(t) = mesh.twin(h).filter(|t| !is_seen[t / 3] && !is_taken[t / 3]) {
                    is_seen[t / 3] = true;
                    stack.push(t / 3);
                }
            }
        }
        holes.retain(|hole| !hole.is_empty());
        pieces.push(Piece { face: seed, holes });
    }
    pieces
}

/// Per halfedge of a piece, bit j if a chain of edges from hole 0 to hole j runs along it: a loop separates the holes whose
/// chains it crosses an odd number of times from hole 0 and the others.
fn chains(mesh: &TriMesh, is_taken: &[bool], piece: &Piece) -> Vec<u128> {
    let mut bits = vec![0u128; mesh.n_halfedges()];
    let mut is_inside = vec![false; mesh.n_faces()];
    is_inside[piece.face] = true;
    let mut stack = vec![piece.face];
    while let Some(f) = stack.pop() {
        for t in (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)).filter(|t| !is_taken[t / 3]) {
            if !std::mem::replace(&mut is_inside[t / 3], true) {
                stack.push(t / 3);
            }
        }
    }
    // Halfedge of a face of the piece by which a vertex was reached, and whether against it.
    let mut by: Vec<Option<(usize, bool)>> = vec![None; mesh.n_vertices()];
    let mut is_reached = vec![false; mesh.n_vertices()];
    let mut queue = VecDeque::new();
    for v in piece.holes[0].iter().flat_map(|&h| [mesh.origin(h), mesh.target(h)]) {
        if !std::mem::replace(&mut is_reached[v as usize], true) {
            queue.push_back(v);
        }
    }
    while let Some(v) = queue.pop_front() {
        for h in mesh.fan(v) {
            for (h, is_against) in [(h, false), (crate::engine::mesh::prev(h), true)] {
                if !is_inside[h / 3] {
                    continue;
                }
                let w = if is_against { mesh.origin(h) } else { mesh.target(h) };
                if !std::mem::replace(&mut is_reached[w as usize], true) {
                    by[w as usize] = Some((h, is_against));
                    queue.push_back(w);
                }
            }
        }
    }
    for (j, hole) in piece.holes.iter().enumerate().skip(1) {
        let mut v = mesh.origin(hole[0]);
        while let Some((h, is_against)) = by[v as usize] {
            bits[h] ^= 1 << j;
            mesh.twin(h).into_iter().for_each(|t| bits[t] ^= 1 << j);
            v = if is_against { mesh.target(h) } else { mesh.origin(h) };
        }
    }
    bits
}
