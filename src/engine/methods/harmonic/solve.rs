//! From a singularity graph with integers to the map.

use glam::{DVec2, I64Vec2};

use crate::engine::field::Frames;
use crate::engine::mesh::{NONE, TriMesh, next, prev};
use crate::engine::methods::harmonic::continuity::{Charts, Hold, ModifiedLaplacian};
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::SingularityGraph;
use crate::engine::parameterize::{GridMap, Iso, rotate_integer};

/// What is held of a boundary, besides that it lies on a coordinate line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundaryValues {
    /// Values between two corners by length (`[tong_2006]` section 4).
    Linear,
    /// Nothing: the map moves along the line as it likes.
    Natural,
}

/// The transitions of a graph with its integers, per halfedge; the identity off the graph.
pub(super) fn transitions(mesh: &TriMesh, graph: &SingularityGraph) -> Result<(Vec<u8>, Vec<I64Vec2>), HarmonicError> {
    let mut rotation = vec![0u8; mesh.n_halfedges()];
    let mut translation = vec![I64Vec2::ZERO; mesh.n_halfedges()];
    let at = corner_values(graph)?;
    for (edge, at) in graph.edges.iter().zip(&at).filter(|(edge, _)| edge.faces[1] != NONE) {
        let m = edge.quarters();
        let back = (4 - m) & 3;
        // The path begins where its right half ends.
        let tau = at[0][0] - rotate_integer(at[1][1], m);
        for &h in &edge.path {
            (rotation[h], translation[h]) = (m, tau);
            if let Some(t) = mesh.twin(h) {
                (rotation[t], translation[t]) = (back, -rotate_integer(tau, back));
            }
        }
    }
    Ok((rotation, translation))
}

/// Per meta-edge and half, where it begins and ends in the chart of its meta-face.
fn corner_values(graph: &SingularityGraph) -> Result<Vec<[[I64Vec2; 2]; 2]>, HarmonicError> {
    let mut values = vec![[[I64Vec2::ZERO; 2]; 2]; graph.edges.len()];
    for face in 0..graph.faces.len() as u32 {
        let corners = graph.corners(face)?;
        let sides = &graph.faces[face as usize];
        for (k, side) in sides.iter().enumerate() {
            values[side.edge as usize][side.half] = [corners[k], corners[(k + 1) % sides.len()]];
        }
    }
    Ok(values)
}

/// The harmonic map of a graph. `iso` are the curves on coordinate lines besides the graph's own; `is_held` per vertex of the
/// mesh whether it is held where the meta-system puts it.
pub(super) fn harmonic_map(
    mesh: &TriMesh,
    frames: &Frames,
    graph: &SingularityGraph,
    is_held: &[bool],
    iso: &[Iso],
    boundary: BoundaryValues,
) -> Result<GridMap, HarmonicError> {
    let (rotation, translation) = transitions(mesh, graph)?;
    let laplacian = ModifiedLaplacian::new(mesh, frames, &Charts { rotation: &rotation, translation: &translation });
    let holds = holds(mesh, graph, is_held, iso, boundary)?;
    let uv = laplacian.solve(&holds)?;
    Ok(GridMap { uv, rotation, translation, iso: iso.to_vec() })
}

/// What the meta-system says of vertices.
fn holds(
    mesh: &TriMesh,
    graph: &SingularityGraph,
    is_held: &[bool],
    iso: &[Iso],
    boundary: BoundaryValues,
) -> Result<Vec<Hold>, HarmonicError> {
    let mut holds = Vec::new();
    for (edge, at) in graph.edges.iter().zip(corner_values(graph)?) {
        let [from, to] = at[0];
        let first = edge.path[0];
        let last = edge.path[edge.path.len() - 1];
        for (corner, value) in [(first, from), (next(last), to)] {
            if is_held[mesh.origin(corner) as usize] {
                let value = value.as_dvec2();
                holds.push(Hold { corner, value: [Some(value.x), Some(value.y)] });
            }
        }
        let is_iso = |h: usize| iso[h] != Iso::None;
        if !is_iso(first) {
            continue;
        }
        let fixed = usize::from(edge.tags[0] % 2 == 0);
        let is_linear = edge.faces[1] == NONE && boundary == BoundaryValues::Linear;
        let mut along = 0.0;
        for (k, &h) in edge.path.iter().enumerate() {
            let mut value = [None; 2];
            value[fixed] = Some(from[fixed] as f64);
            let is_end = k == 0;
            if is_linear && !is_end {
                let z: DVec2 = from.as_dvec2().lerp(to.as_dvec2(), along / edge.length);
                value = [Some(z.x), Some(z.y)];
            }
            holds.push(Hold { corner: h, value });
            along += mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)));
        }
        let mut value = [None; 2];
        value[fixed] = Some(from[fixed] as f64);
        holds.push(Hold { corner: next(last), value });
        debug_assert_eq!(prev(next(last)), last);
    }
    Ok(holds)
}
