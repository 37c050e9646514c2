//! Topological repairs of a cross field before it is integrated: sectors at features that would have no angle in the
//! map, and pairs of singularities too close for the grid.
//!
//! Both change matchings only; [`Turning`](super::turning::Turning) then turns the crosses to fit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::engine::field::cross_field::{CrossField, residual};
use crate::engine::field::frames::Frames;
use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;

/// How far (radians) the angle of a sector may be from a multiple of a quarter turn for that to be what it gets.
const CLEAR: f64 = 0.6;

/// Gives every sector between two feature or boundary edges of a vertex the quarter turns of its angle where that is
/// clear, and at least one. A sector of angle Θ whose edges the field turns through Σ r has `(Θ + Σ r) / (π/2)` of them;
/// along a straight curve any number but two would put a branch point on the curve, and a quad with a straight angle
/// beside it. Branch points move to neighbours inside the sector. Returns the number of sectors mended.
pub(super) fn mend_sectors(mesh: &TriMesh, frames: &Frames, field: &mut CrossField, is_feature: &[bool]) -> usize {
    let on_feature = on_features(mesh, is_feature);
    let mut mended = 0;
    for v in 0..mesh.n_vertices() as u32 {
        let fan: Vec<usize> = mesh.fan(v).collect();
        let Some(first) = fan.iter().position(|&h| is_feature[h]) else { continue };
        let mut sector: Vec<usize> = Vec::new();
        for k in 0..fan.len() {
            let h = fan[(first + k) % fan.len()];
            sector.push(h);
            // The sector ends where the edge behind this face's corner is a feature or the boundary.
            let is_between = is_feature[sector[0]] && is_feature[prev(h)];
            if is_between {
                mended += usize::from(mend_sector(mesh, frames, field, &sector, &on_feature));
            }
            // The boundary need not be followed: then nothing is known of the sectors at it.
            if is_between || mesh.is_boundary(prev(h)) {
                sector.clear();
            }
        }
    }
    mended
}

/// `sector` are the halfedges leaving the vertex, one per face of the sector, counter-clockwise.
fn mend_sector(mesh: &TriMesh, frames: &Frames, field: &mut CrossField, sector: &[usize], on_feature: &[bool]) -> bool {
    let inner = &sector[..sector.len() - 1];
    let angle: f64 = sector.iter().map(|&h| corner_angle(frames, h)).sum();
    let turn = |field: &CrossField, h: usize| residual(mesh, frames, &field.angle, &field.matching, prev(h));
    let total: f64 = inner.iter().map(|&h| turn(field, h)).sum();
    let quarters = ((angle + total) / FRAC_PI_2).round() as i32;
    let clear = (angle / FRAC_PI_2).round();
    let is_clear = clear >= 1.0 && (angle - clear * FRAC_PI_2).abs() < CLEAR;
    // An edge to another curve would only pass the turn on to it.
    let free: Vec<usize> = inner.iter().copied().filter(|&h| !on_feature[mesh.origin(prev(h)) as usize]).collect();
    let (wanted, candidates) = match (is_clear, free.is_empty()) {
        (_, true) => (quarters.max(1), inner),
        (true, false) => (clear as i32, free.as_slice()),
        (false, false) => (quarters.max(1), free.as_slice()),
    };
    let step = (wanted - quarters).signum();
    for _ in 0..(wanted - quarters) * step {
        let least = |h: &usize| f64::from(step) * turn(field, *h);
        let Some(&h) = candidates.iter().min_by(|a, b| least(a).total_cmp(&least(b))) else { return false };
        field.matching.turn(mesh, prev(h), step.rem_euclid(4) as u8);
    }
    wanted != quarters
}

/// Vertices at features and at the boundary.
fn on_features(mesh: &TriMesh, is_feature: &[bool]) -> Vec<bool> {
    let mut on = vec![false; mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| is_feature[h]) {
        on[mesh.origin(h) as usize] = true;
        on[mesh.target(h) as usize] = true;
    }
    on
}

fn corner_angle(frames: &Frames, h: usize) -> f64 {
    PI - (frames.angle[h] - frames.angle[prev(h)]).rem_euclid(TAU)
}

/// Cancels pairs of singularities of opposite index nearer than `max_distance` (in the frames' metric) by shifting the
/// matchings along the edges between them, nearest pairs first. Paths do not touch feature edges. Returns the number of
/// pairs.
pub(super) fn cancel_pairs(
    mesh: &TriMesh,
    frames: &Frames,
    field: &mut CrossField,
    is_feature: &[bool],
    max_distance: f64,
) -> usize {
    let on_feature = on_features(mesh, is_feature);
    let mut pairs: Vec<(u64, Vec<usize>)> = Vec::new();
    for s in field.singularities().iter().filter(|s| s.quarters > 0 && !on_feature[s.vertex as usize]) {
        pairs.extend(paths_to_opposites(mesh, frames, field, &on_feature, s.vertex, max_distance));
    }
    pairs.sort_unstable();
    let mut cancelled = 0;
    for (_, path) in pairs {
        let (a, b) = (mesh.origin(path[0]), mesh.target(path[path.len() - 1]));
        if field.quarter_index[a as usize] <= 0 || field.quarter_index[b as usize] >= 0 {
            continue;
        }
        for &h in &path {
            // Counter-clockwise around its origin, an edge is crossed from the face on its right: a turn there lowers
            // the index at the origin by one and raises the one at the target.
            if let Some(t) = mesh.twin(h) {
                field.matching.turn(mesh, t, 1);
            }
        }
        field.quarter_index[a as usize] -= 1;
        field.quarter_index[b as usize] += 1;
        cancelled += 1;
    }
    cancelled
}

/// Shortest paths from `start` to singularities of negative index, as chains of halfedges, with their lengths' bits.
fn paths_to_opposites(
    mesh: &TriMesh,
    frames: &Frames,
    field: &CrossField,
    blocked: &[bool],
    start: u32,
    max_distance: f64,
) -> Vec<(u64, Vec<usize>)> {
    let mut reached: Vec<(u32, f64, u32)> = vec![(start, 0.0, NONE)];
    let mut heap = BinaryHeap::from([Reverse((0u64, start))]);
    let mut paths = Vec::new();
    while let Some(Reverse((bits, v))) = heap.pop() {
        let Some(&(_, d, _)) = reached.iter().find(|r| r.0 == v) else { continue };
        if bits != d.to_bits() {
            continue;
        }
        if field.quarter_index[v as usize] < 0 {
            let mut path = Vec::new();
            let mut at = v;
            while let Some(&(_, _, h)) = reached.iter().find(|r| r.0 == at && r.2 != NONE) {
                path.push(h as usize);
                at = mesh.origin(h as usize);
            }
            path.reverse();
            paths.push((bits, path));
            continue;
        }
        for h in mesh.fan(v) {
            // Interior vertices only: every halfedge leaving them has its edge's twin.
            let w = mesh.target(h);
            if blocked[w as usize] || mesh.is_boundary_vertex(w) {
                continue;
            }
            let longer = d + frames.length(mesh, h);
            if longer > max_distance {
                continue;
            }
            match reached.iter_mut().find(|r| r.0 == w) {
                Some(r) if r.1 <= longer => continue,
                Some(r) => (r.1, r.2) = (longer, h as u32),
                None => reached.push((w, longer, h as u32)),
            }
            heap.push(Reverse((longer.to_bits(), w)));
        }
    }
    paths
}
