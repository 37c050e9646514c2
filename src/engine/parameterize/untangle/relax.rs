//! The moves: damped Newton steps of single vertices on the regularised energy of their fan.

use glam::{DMat2, DVec2};

use crate::engine::field::Frames;
use crate::engine::mesh::{TriMesh, next};
use crate::engine::parameterize::grid_map::{GridMap, rotate};
use crate::engine::parameterize::untangle::freedom::{Corner, Freedom, fan_corners, freedom};
use crate::engine::run::{Cancelled, RunContext};

/// Weight of the area term against the shape term.
const AREA_WEIGHT: f64 = 0.3;
/// Sweeps over the region per round.
const SWEEPS: usize = 60;
/// Vertex moves per round at most: beyond that the flips come from detail below the grid, and more work does not help.
const WORK: usize = 200_000;

/// A triangle of the map relative to the frame that it should have.
pub(super) struct Target {
    /// Inverse of the (edge 1, edge 2) matrix of the triangle in units of the grid.
    inverse: DMat2,
    area: f64,
}

impl Target {
    /// Of face f at a scale in grid units per model unit.
    pub(super) fn new(mesh: &TriMesh, frames: &Frames, f: usize, scale: f64) -> Self {
        let (p, q) = (frames.edge(mesh, 3 * f) * scale, -frames.edge(mesh, 3 * f + 2) * scale);
        let edges = DMat2::from_cols(p, q);
        let determinant = edges.determinant();
        let inverse = if determinant.abs() > 1e-300 { edges.inverse() } else { DMat2::ZERO };
        Self { inverse, area: 0.5 * determinant }
    }
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

/// Faces whose relative determinant is below that.
pub(super) fn flipped_faces(map: &GridMap, targets: &[Target]) -> Vec<usize> {
    (0..targets.len())
        .filter(|&f| targets[f].area > 0.0 && jacobian(&corners(map, f), &targets[f]).determinant() < MIN_DETERMINANT)
        .collect()
}

/// Sweeps over the vertices until no triangle at them is flipped or the work is used up.
pub(super) fn relax_region(
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

/// A triangle of a fan as a function of where the vertex is: its gradient is affine in the vertex's move.
struct FanTriangle {
    /// The gradient as it is, turned into the chart of the first corner: the energy does not see rotations.
    gradient: DMat2,
    /// The gradient changes by the move times this row.
    row: DVec2,
    area: f64,
}

impl FanTriangle {
    fn new(map: &GridMap, targets: &[Target], (h, quarters): Corner) -> Self {
        let (target, uv) = (&targets[h / 3], corners(map, h / 3));
        let to_first = |z: DVec2| rotate(z, (4 - quarters) & 3);
        let edges = DMat2::from_cols(to_first(uv[1] - uv[0]), to_first(uv[2] - uv[0]));
        let rows = target.inverse.transpose();
        let row = match h % 3 {
            0 => -(rows.x_axis + rows.y_axis),
            1 => rows.x_axis,
            _ => rows.y_axis,
        };
        Self { gradient: edges * target.inverse, row, area: target.area }
    }

    /// Its energy if the vertex moved by `delta`.
    #[inline]
    fn energy(&self, delta: DVec2, epsilon_squared: f64) -> f64 {
        let x = self.gradient.x_axis + delta * self.row.x;
        let y = self.gradient.y_axis + delta * self.row.y;
        let d = x.perp_dot(y);
        let chi = 0.5 * (d + (epsilon_squared + d * d).sqrt());
        self.area * (x.length_squared() + y.length_squared() + AREA_WEIGHT * (d * d + 1.0)) / chi.max(1e-300)
    }
}

/// One damped Newton step with derivatives by central differences, halved until the energy falls.
fn move_vertex(map: &mut GridMap, targets: &[Target], freedom: Freedom, corners_of: &[Corner], epsilon: f64) {
    let size = corners_of.iter().map(|&(h, _)| (map.uv[next(h)] - map.uv[h]).length()).fold(0.0, f64::max).max(1e-6);
    let fan: Vec<FanTriangle> = corners_of.iter().map(|&corner| FanTriangle::new(map, targets, corner)).collect();
    let energy = |delta: DVec2| fan.iter().map(|triangle| triangle.energy(delta, epsilon * epsilon)).sum::<f64>();
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
