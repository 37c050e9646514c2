//! Untangling a map: moves vertices in the plane until no triangle is flipped, transitions and grid lines kept.
//!
//! The energy is the regularised one of `[garanzha_2021]`: with J the gradient relative to the frame the field asks
//! for, `D = det J` and `χ(D) = (D + √(ε² + D²)) / 2`, each triangle costs `(|J|² + λ (D² + 1)) / χ(D)` times its area.
//! As ε falls, flipped triangles cost more and more, others never become flipped for long. Vertices move one at a time
//! (Gauss–Seidel) by a damped Newton step within a few rings around the flips: everything else stays where the Poisson
//! solve put it. Singular vertices, corners and crossings of grid lines never move; vertices on a grid line move along it.

mod freedom;
mod relax;

use std::collections::VecDeque;
use std::f64::consts::PI;

use glam::DVec2;

use crate::engine::field::Frames;
use crate::engine::mesh::{TriMesh, next, prev};
use crate::engine::parameterize::grid_map::{GridMap, rotate};
use crate::engine::parameterize::untangle::freedom::{Corner, Freedom, fan_corners, freedom};
use crate::engine::parameterize::untangle::relax::{Target, flipped_faces, relax_region};
use crate::engine::run::{Cancelled, RunContext};

/// Rings of faces around a flipped one whose vertices may move; doubled in each round.
const RINGS: usize = 5;
/// Rounds, each with a wider region.
const ROUNDS: usize = 3;
/// Laplacian sweeps around vertices around which the map winds twice.
const EVENING: usize = 20;

/// When more flips than this stay and hardly any went, a wider region does not help either.
const HOPELESS: usize = 100;

/// Moves vertices of `map` until no triangle is flipped and no regular vertex is wound around twice, or gives up; the map
/// never gets more such triangles than it had. `scale` is in grid units per model unit. Returns the number of triangles
/// that stay flipped or around vertices that are wound around twice.
///
/// # Errors
/// [`Cancelled`] if the run was stopped.
pub fn untangle(
    ctx: &RunContext,
    mesh: &TriMesh,
    frames: &Frames,
    map: &mut GridMap,
    pinned: &[bool],
    scale: f64,
) -> Result<usize, Cancelled> {
    let targets: Vec<Target> = (0..mesh.n_faces()).map(|f| Target::new(mesh, frames, f, scale)).collect();
    let mut flipped = flipped_faces(map, &targets);
    let mut rings = RINGS;
    for round in 0..ROUNDS {
        if flipped.is_empty() {
            break;
        }
        let before = map.uv.clone();
        let vertices = region(mesh, &flipped, rings);
        relax_region(&ctx.part(round, 2 * ROUNDS), mesh, map, pinned, &targets, &vertices)?;
        let now = flipped_faces(map, &targets);
        let is_stuck = now.len() > HOPELESS && 4 * now.len() > 3 * flipped.len();
        if now.len() > flipped.len() {
            map.uv = before;
        } else {
            flipped = now;
        }
        if is_stuck {
            break;
        }
        rings *= 2;
    }
    if !flipped.is_empty() {
        return Ok(flipped.len());
    }
    let faces_around = |vertices: &[u32]| {
        let mut faces: Vec<usize> = vertices.iter().flat_map(|&v| mesh.fan(v)).map(|h| h / 3).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let mut wound = faces_around(&overwound(mesh, map, pinned));
    for round in 0..ROUNDS {
        if wound.is_empty() {
            break;
        }
        // Flips can be undone, windings cannot: everything near is evened out first, whatever is flipped by that.
        let before = map.uv.clone();
        for _ in 0..EVENING {
            for &v in &region(mesh, &wound, round) {
                even_out(mesh, map, pinned, v);
            }
        }
        let part = ctx.part(ROUNDS + round, 2 * ROUNDS);
        relax_region(&part, mesh, map, pinned, &targets, &region(mesh, &wound, RINGS << round))?;
        let now = faces_around(&overwound(mesh, map, pinned));
        if flipped_faces(map, &targets).is_empty() && now.len() < wound.len() {
            wound = now;
        } else {
            map.uv = before;
        }
    }
    Ok(wound.len())
}

/// Interior vertices that are not pinned and nevertheless have an angle of more than three half turns: no triangle needs
/// to be flipped for that, if a singular vertex nearby has too little of it.
fn overwound(mesh: &TriMesh, map: &GridMap, pinned: &[bool]) -> Vec<u32> {
    let angle = |v: u32| {
        let at = |h: usize| (map.uv[next(h)] - map.uv[h]).angle_to(map.uv[prev(h)] - map.uv[h]);
        mesh.fan(v).map(at).sum::<f64>()
    };
    let is_free = |v: &u32| !pinned[*v as usize] && !mesh.is_boundary_vertex(*v);
    (0..mesh.n_vertices() as u32).filter(is_free).filter(|&v| angle(v) > 3.0 * PI).collect()
}

/// Puts a vertex amid its neighbours, as far as it is free.
fn even_out(mesh: &TriMesh, map: &mut GridMap, pinned: &[bool], v: u32) {
    let corners = fan_corners(mesh, map, v);
    let away = |&(h, quarters): &Corner| {
        let (to, from) = (map.uv[next(h)] - map.uv[h], map.uv[prev(h)] - map.uv[h]);
        rotate(0.5 * (to + from), (4 - quarters) & 3)
    };
    let mean = corners.iter().map(away).sum::<DVec2>() / corners.len() as f64;
    let delta = match freedom(map, pinned, v, &corners) {
        Freedom::Fixed => return,
        Freedom::Line(along) => along * mean.dot(along),
        Freedom::Plane => mean,
    };
    for (h, quarters) in corners {
        map.uv[h] += rotate(delta, quarters);
    }
}

/// Vertices within `rings` of the given faces, in breadth-first order.
fn region(mesh: &TriMesh, faces: &[usize], rings: usize) -> Vec<u32> {
    let mut ring = vec![usize::MAX; mesh.n_vertices()];
    let mut queue = VecDeque::new();
    for v in faces.iter().flat_map(|&f| mesh.face(f)) {
        if ring[v as usize] == usize::MAX {
            ring[v as usize] = 0;
            queue.push_back(v);
        }
    }
    let mut vertices = Vec::new();
    while let Some(v) = queue.pop_front() {
        vertices.push(v);
        if ring[v as usize] == rings {
            continue;
        }
        for h in mesh.fan(v) {
            for w in [mesh.target(h), mesh.origin(prev(h))] {
                if ring[w as usize] == usize::MAX {
                    ring[w as usize] = ring[v as usize] + 1;
                    queue.push_back(w);
                }
            }
        }
    }
    vertices
}
