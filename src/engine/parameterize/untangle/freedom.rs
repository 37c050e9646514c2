//! How far the vertices of a map may move without leaving integer points and grid lines.

use glam::DVec2;

use crate::engine::mesh::{TriMesh, prev};
use crate::engine::parameterize::grid_map::{GridMap, Iso};

/// How one vertex may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    Fixed,
    /// Along this direction, in the chart of the vertex's first corner.
    Line(DVec2),
    Plane,
}

/// One corner of a movable vertex: its halfedge and the rotation of its chart against the first corner's.
pub(super) type Corner = (usize, u8);

/// The corners of a vertex, counter-clockwise.
pub(super) fn fan_corners(mesh: &TriMesh, map: &GridMap, v: u32) -> Vec<Corner> {
    let mut quarters = 0u8;
    let mut corners = Vec::with_capacity(8);
    for h in mesh.fan(v) {
        corners.push((h, quarters));
        // z_t = i^{-m} (z_s − τ) when crossing to the next face counter-clockwise.
        quarters = (quarters + 4 - map.rotation[prev(h)]) & 3;
    }
    corners
}

/// How the vertex with these corners may move: along the grid lines of the curves through it.
pub(super) fn freedom(map: &GridMap, pinned: &[bool], v: u32, corners: &[Corner]) -> Freedom {
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
