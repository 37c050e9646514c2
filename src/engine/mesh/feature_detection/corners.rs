//! Which vertices must become quad vertices.

use std::f64::consts::FRAC_PI_4;
use std::f64::consts::PI;

use glam::DVec3;

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::feature_detection::network::Network;
use crate::engine::mesh::prev;

/// Turn of a curve, in radians, from which a vertex is a corner.
const SHARP_TURN: f64 = FRAC_PI_4 - 1e-9;
/// Half the window, in mean edge lengths of the curve, over which a turn must persist.
const WINDOW: f64 = 2.5;
/// Median turn, in radians, from which a boundary is ragged.
const RAGGED: f64 = 10.0 / 180.0 * PI;
/// Half the window, in mean edge lengths, for ragged boundaries.
const RAGGED_WINDOW: f64 = 6.0;

/// Ends, junctions and sharp turns of feature curves; on the boundary also sharp turns of the boundary itself.
pub(super) fn find_corners(mesh: &TriMesh, network: &Network, min_length: f64) -> Vec<u32> {
    let mut is_corner = vec![false; mesh.n_vertices()];
    for v in 0..mesh.n_vertices() as u32 {
        is_corner[v as usize] = match (network.degree(v), mesh.is_boundary_vertex(v)) {
            (0, _) => false,
            (_, true) => true,
            (2, false) => turns_sharply(mesh, network, v, min_length),
            _ => true,
        };
    }
    for boundary in mesh.boundary_loops() {
        for v in boundary_corners(mesh, &boundary, min_length) {
            is_corner[v as usize] = true;
        }
    }
    (0..mesh.n_vertices() as u32).filter(|&v| is_corner[v as usize]).collect()
}

/// Whether the feature curve turns by 45 degrees at `v`, at once as well as seen from a few edges away.
fn turns_sharply(mesh: &TriMesh, network: &Network, v: u32, min_length: f64) -> bool {
    let arms: Vec<usize> = mesh.fan(v).filter(|&h| network.is_marked(h)).collect();
    let [g, h] = arms[..] else {
        return true;
    };
    let at = mesh.position(v);
    let turn = |a: DVec3, b: DVec3| (at - a).angle_between(b - at);
    if turn(mesh.position(mesh.target(g)), mesh.position(mesh.target(h))) < SHARP_TURN {
        return false;
    }
    let arm_length = |h: usize| mesh.position(mesh.target(h)).distance(at);
    let reach = (WINDOW * 0.5 * (arm_length(g) + arm_length(h))).max(0.5 * min_length);
    turn(ahead(mesh, network, g, reach), ahead(mesh, network, h, reach)) >= SHARP_TURN
}

/// The point at arc length `reach` along the chain that starts with `h`, or its end.
fn ahead(mesh: &TriMesh, network: &Network, mut h: usize, reach: f64) -> DVec3 {
    let mut left = reach;
    loop {
        let (a, b) = (mesh.position(mesh.origin(h)), mesh.position(mesh.target(h)));
        let length = a.distance(b);
        if length >= left {
            return a + (b - a) * (left / length);
        }
        left -= length;
        match network.next_marked(h) {
            Some(onward) => h = onward,
            None => return b,
        }
    }
}

/// Vertices of a boundary loop where it turns by 45 degrees: at once, together with half of what its neighbours turn,
/// in the mean over a window with weights falling from 1 to 0 (zigzag cancels), and most in the window.
fn boundary_corners(mesh: &TriMesh, boundary: &[usize], min_length: f64) -> Vec<u32> {
    let n = boundary.len();
    // Turning to the left of the walk: π minus the angle of the surface.
    let turn: Vec<f64> = boundary.iter().map(|&h| PI - surface_angle(mesh, mesh.origin(h))).collect();
    let length: Vec<f64> =
        boundary.iter().map(|&h| mesh.position(mesh.target(h)).distance(mesh.position(mesh.origin(h)))).collect();
    let perimeter = length.iter().sum::<f64>();
    // Where the median vertex turns, but not by a corner, the boundary is cut raggedly: look at it from farther away.
    let mut sorted: Vec<f64> = turn.iter().map(|t| t.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let is_ragged = (RAGGED..SHARP_TURN).contains(&sorted[n / 2]);
    let wanted = if is_ragged { RAGGED_WINDOW * perimeter / n as f64 } else { 0.0 };
    // Windows of a small hole must not reach around it: four corners of a square stay four.
    let reach = (0.5 * min_length).max(wanted).min(perimeter / 8.0);
    let persists = |sum: f64, i: usize| sum * turn[i] > 0.0 && sum.abs() >= SHARP_TURN;
    let mut corners = Vec::new();
    for i in (0..n).filter(|&i| turn[i].abs() >= SHARP_TURN) {
        let mut sum = turn[i];
        let mut is_strongest = true;
        for step in [1, n - 1] {
            let (mut j, mut way) = (i, 0.0);
            loop {
                way += if step == 1 { length[j] } else { length[(j + n - 1) % n] };
                j = (j + step) % n;
                if way >= reach || j == i {
                    break;
                }
                sum += turn[j] * (1.0 - way / reach);
                let beats = turn[j].abs() > turn[i].abs() || (turn[j].abs() == turn[i].abs() && j < i);
                is_strongest &= !(beats && turn[j] * turn[i] > 0.0);
            }
        }
        let nearby = turn[i] + 0.5 * (turn[(i + 1) % n] + turn[(i + n - 1) % n]);
        if is_strongest && persists(nearby, i) && persists(sum, i) {
            corners.push(mesh.origin(boundary[i]));
        }
    }
    corners
}

/// Sum of the face angles at `v`.
fn surface_angle(mesh: &TriMesh, v: u32) -> f64 {
    let at = mesh.position(v);
    mesh.fan(v)
        .map(|h| (mesh.position(mesh.target(h)) - at).angle_between(mesh.position(mesh.origin(prev(h))) - at))
        .sum()
}
