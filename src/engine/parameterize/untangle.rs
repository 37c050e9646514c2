//! Untangling a map: moves vertices in the plane until no triangle is flipped, transitions and grid lines kept.
//!
//! The energy is the regularised one of [garanzha_2021]: with J the gradient relative to the frame that the field asks
//! for, `D = det J` and `χ(D) = (D + √(ε² + D²)) / 2`, each triangle costs `(|J|² + λ (D² + 1)) / χ(D)` times its area.
//! As ε falls, flipped triangles cost more and more, others never become flipped for long. Vertices move one at a time
//! (Gauss–Seidel) by a damped Newton step within a few rings around the flips: everything else stays where the Poisson
//! solve put it. Singular vertices, corners and crossings of grid lines never move; vertices on a grid line move along it.

use std::collections::VecDeque;
use std::f64::consts::PI;

use glam::{DMat2, DVec2};

use crate::engine::field::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::{next, prev};
use crate::engine::parameterize::grid_map::{GridMap, Iso, rotate};
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Weight of the area term against the shape term.
const AREA_WEIGHT: f64 = 0.3;
/// Rings of faces around a flipped one whose vertices may move; doubled in each round.
const RINGS: usize = 5;
/// Rounds, each with a wider region.
const ROUNDS: usize = 3;
/// Sweeps over the region per round.
const SWEEPS: usize = 60;

/// Sweeps in which the surroundings of a vertex that is wound around twice are evened out.
const EVENING: usize = 20;

/// Vertex moves per round at most: beyond that the flips come from detail below the grid, and more work does not help.
const WORK: usize = 200_000;

/// When more flips than this stay and hardly any went, a wider region does not help either.
const HOPELESS: usize = 100;

/// How one vertex may move.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Freedom {
    Fixed,
    /// Along this direction, in the chart of the vertex's first corner.
    Line(DVec2),
    Plane,
}

/// A triangle of the map relative to the frame that it should have.
struct Target {
    /// Inverse of the (edge 1, edge 2) matrix of the triangle in units of the grid.
    inverse: DMat2,
    area: f64,
}

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
    let targets: Vec<Target> = (0..mesh.n_faces()).map(|f| target(mesh, frames, f, scale)).collect();
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

fn target(mesh: &TriMesh, frames: &Frames, f: usize, scale: f64) -> Target {
    let (p, q) = (frames.edge(mesh, 3 * f) * scale, -frames.edge(mesh, 3 * f + 2) * scale);
    let edges = DMat2::from_cols(p, q);
    let determinant = edges.determinant();
    let inverse = if determinant.abs() > 1e-300 { edges.inverse() } else { DMat2::ZERO };
    Target { inverse, area: 0.5 * determinant }
}

/// Gradient of the map on a triangle. The frame of the field only turns it: the energy does not see rotations.
fn jacobian(uv: &[DVec2; 3], target: &Target) -> DMat2 {
    DMat2::from_cols(uv[1] - uv[0], uv[2] - uv[0]) * target.inverse
}

fn corners(map: &GridMap, f: usize) -> [DVec2; 3] {
    [map.uv[3 * f], map.uv[3 * f + 1], map.uv[3 * f + 2]]
}

/// Relative determinant below which a triangle counts as flipped.
const MIN_DETERMINANT: f64 = 1e-9;

fn flipped_faces(map: &GridMap, targets: &[Target]) -> Vec<usize> {
    (0..targets.len())
        .filter(|&f| targets[f].area > 0.0 && jacobian(&corners(map, f), &targets[f]).determinant() < MIN_DETERMINANT)
        .collect()
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

/// One corner of a movable vertex: its halfedge and the rotation of its chart against the first corner's.
type Corner = (usize, u8);

fn fan_corners(mesh: &TriMesh, map: &GridMap, v: u32) -> Vec<Corner> {
    let mut quarters = 0u8;
    let mut corners = Vec::with_capacity(8);
    for h in mesh.fan(v) {
        corners.push((h, quarters));
        // z_t = i^{-m} (z_s − τ) when crossing to the next face counter-clockwise.
        quarters = (quarters + 4 - map.rotation[prev(h)]) & 3;
    }
    corners
}

fn freedom(map: &GridMap, pinned: &[bool], v: u32, corners: &[Corner]) -> Freedom {
    if pinned[v as usize] {
        return Freedom::Fixed;
    }
    let (mut along_u, mut along_v) = (false, false);
    for &(h, quarters) in corners {
        for side in [h, prev(h)] {
            let iso = map.iso[side];
            // An odd rotation exchanges the coordinates of this chart and the first one.
            let swapped = quarters & 1 == 1;
            match (iso, swapped) {
                (Iso::None, _) => {}
                (Iso::V, false) | (Iso::U, true) => along_u = true,
                (Iso::U, false) | (Iso::V, true) => along_v = true,
            }
        }
    }
    match (along_u, along_v) {
        (false, false) => Freedom::Plane,
        (true, false) => Freedom::Line(DVec2::X),
        (false, true) => Freedom::Line(DVec2::Y),
        (true, true) => Freedom::Fixed,
    }
}

fn relax_region(
    ctx: &RunContext,
    mesh: &TriMesh,
    map: &mut GridMap,
    pinned: &[bool],
    targets: &[Target],
    vertices: &[u32],
) -> Result<(), Cancelled> {
    let movable: Vec<(Freedom, Vec<Corner>)> = vertices
        .iter()
        .map(|&v| {
            let corners = fan_corners(mesh, map, v);
            (freedom(map, pinned, v, &corners), corners)
        })
        .filter(|(freedom, _)| *freedom != Freedom::Fixed)
        .collect();
    let faces: Vec<usize> = {
        let mut faces: Vec<usize> = movable.iter().flat_map(|(_, c)| c.iter().map(|&(h, _)| h / 3)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let worst = |map: &GridMap| {
        faces.iter().map(|&f| jacobian(&corners(map, f), &targets[f]).determinant()).fold(f64::INFINITY, f64::min)
    };
    let sweeps = SWEEPS.min(WORK / movable.len().max(1)).max(2);
    for sweep in 0..sweeps {
        ctx.check()?;
        ctx.advance(sweep as f64 / sweeps as f64);
        let lowest = worst(map);
        if lowest > 0.02 && sweep > 4 {
            break;
        }
        // ε falls with the worst determinant: χ stays of the order of what is to be repaired.
        let epsilon = (1e-8 + 0.04 * lowest.min(0.0).powi(2)).sqrt();
        for (freedom, corners) in &movable {
            move_vertex(map, targets, *freedom, corners, epsilon);
        }
    }
    Ok(())
}

/// Energy of the fan if the vertex moved by `delta` (in the first corner's chart).
fn fan_energy(map: &GridMap, targets: &[Target], corners_of: &[Corner], delta: DVec2, epsilon: f64) -> f64 {
    corners_of
        .iter()
        .map(|&(h, quarters)| {
            let f = h / 3;
            let mut uv = corners(map, f);
            uv[h % 3] += rotate(delta, quarters);
            let j = jacobian(&uv, &targets[f]);
            let d = j.determinant();
            let chi = 0.5 * (d + (epsilon * epsilon + d * d).sqrt());
            let norm = j.x_axis.length_squared() + j.y_axis.length_squared();
            targets[f].area * (norm + AREA_WEIGHT * (d * d + 1.0)) / chi.max(1e-300)
        })
        .sum()
}

/// One damped Newton step with derivatives by central differences, halved until the energy falls.
fn move_vertex(map: &mut GridMap, targets: &[Target], freedom: Freedom, corners_of: &[Corner], epsilon: f64) {
    let size = corners_of.iter().map(|&(h, _)| (map.uv[next(h)] - map.uv[h]).length()).fold(0.0, f64::max).max(1e-6);
    let energy = |delta: DVec2| fan_energy(map, targets, corners_of, delta, epsilon);
    let e0 = energy(DVec2::ZERO);
    let t = 1e-4 * size;
    let directions: &[DVec2] = match freedom {
        Freedom::Plane => &[DVec2::X, DVec2::Y],
        Freedom::Line(d) if d.x != 0.0 => &[DVec2::X],
        _ => &[DVec2::Y],
    };
    let (mut ahead, mut gradient, mut curvature) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    for (k, &d) in directions.iter().enumerate() {
        let (plus, minus) = (energy(d * t), energy(-d * t));
        ahead[k] = plus;
        gradient[k] = (plus - minus) / (2.0 * t);
        curvature[k] = (plus + minus - 2.0 * e0) / (t * t);
    }
    let mut step = DVec2::ZERO;
    if directions.len() == 2 {
        let mixed = (energy(DVec2::new(t, t)) - ahead[0] - ahead[1] + e0) / (t * t);
        let hessian = DMat2::from_cols(DVec2::new(curvature[0], mixed), DVec2::new(mixed, curvature[1]));
        let g = DVec2::new(gradient[0], gradient[1]);
        if hessian.determinant() > 1e-12 * (curvature[0] * curvature[1]).abs() && curvature[0] > 0.0 {
            step = -(hessian.inverse() * g);
        }
        if !(step.is_finite() && step.dot(g) < 0.0) {
            step = -g.normalize_or_zero() * 0.5 * size;
        }
    } else {
        let s = if curvature[0] > 0.0 { -gradient[0] / curvature[0] } else { -gradient[0].signum() * 0.5 * size };
        step = directions[0] * s;
    }
    let longest = 2.0 * size;
    if step.length() > longest {
        step *= longest / step.length();
    }
    for _ in 0..12 {
        if energy(step) < e0 {
            for &(h, quarters) in corners_of {
                map.uv[h] += rotate(step, quarters);
            }
            return;
        }
        step *= 0.5;
    }
}
