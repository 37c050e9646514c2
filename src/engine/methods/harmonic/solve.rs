//! From a singularity graph with integers to the map.

use glam::DVec2;

use crate::engine::field::Frames;
use crate::engine::mesh::{NONE, TriMesh, next};
use crate::engine::methods::harmonic::continuity::{Charts, Hold, ModifiedLaplacian};
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::SingularityGraph;
use crate::engine::parameterize::{GridMap, Iso, rotate};

/// What is held of a boundary, besides that it lies on a coordinate line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundaryValues {
    /// Values between two corners by length (`[tong_2006]` section 4).
    Linear,
    /// Nothing: the map moves along the line as it likes.
    Natural,
}

/// Where the meta-edges lie in the plane: linear in their extents, which need not be integers here.
#[derive(Clone, Debug)]
struct Laid {
    /// Per meta-edge and half, where it begins and ends in the chart of its meta-face.
    ends: Vec<[[DVec2; 2]; 2]>,
}

impl Laid {
    /// Each meta-face from its first side on. If the extents close it, it ends where it began.
    fn new(graph: &SingularityGraph, extents: &[f64]) -> Self {
        let mut ends = vec![[[DVec2::ZERO; 2]; 2]; graph.edges.len()];
        for sides in &graph.faces {
            let mut at = DVec2::ZERO;
            for (k, side) in sides.iter().enumerate() {
                let start = at;
                at += rotate(DVec2::new(extents[side.edge as usize], 0.0), graph.tag(*side));
                let end = if k + 1 == sides.len() { DVec2::ZERO } else { at };
                ends[side.edge as usize][side.half] = [start, end];
            }
        }
        Self { ends }
    }

    /// Transitions per halfedge; the identity off the graph.
    fn transitions(&self, mesh: &TriMesh, graph: &SingularityGraph) -> (Vec<u8>, Vec<DVec2>) {
        let mut rotation = vec![0u8; mesh.n_halfedges()];
        let mut translation = vec![DVec2::ZERO; mesh.n_halfedges()];
        for (edge, at) in graph.edges.iter().zip(&self.ends).filter(|(edge, _)| edge.faces[1] != NONE) {
            let m = edge.quarters();
            let back = (4 - m) & 3;
            // The path begins where its right half ends.
            let tau = at[0][0] - rotate(at[1][1], m);
            for &h in &edge.path {
                (rotation[h], translation[h]) = (m, tau);
                if let Some(t) = mesh.twin(h) {
                    (rotation[t], translation[t]) = (back, -rotate(tau, back));
                }
            }
        }
        (rotation, translation)
    }
}

/// A graph on its mesh, for whose extents harmonic maps are sought.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnMesh<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) frames: &'a Frames,
    pub(super) graph: &'a SingularityGraph,
    /// Per vertex of the mesh, whether it is held where the meta-system puts it.
    pub(super) is_held: &'a [bool],
    /// Per halfedge, the coordinate line of a feature or boundary that it is on.
    pub(super) iso: &'a [Iso],
    pub(super) boundary: BoundaryValues,
}

impl OnMesh<'_> {
    /// The harmonic map with the integers of the graph.
    ///
    /// # Errors
    /// [`HarmonicError`] if a meta-face is open or nothing holds the map.
    pub(super) fn map(&self) -> Result<GridMap, HarmonicError> {
        for face in 0..self.graph.faces.len() as u32 {
            self.graph.corners(face)?;
        }
        let extents: Vec<f64> = self.graph.edges.iter().map(|edge| edge.extent as f64).collect();
        let laid = Laid::new(self.graph, &extents);
        let (rotation, translation) = laid.transitions(self.mesh, self.graph);
        let uv = self.maps(&[extents])?.swap_remove(0);
        let translation = translation.iter().map(|t| t.as_i64vec2()).collect();
        Ok(GridMap { uv, rotation, translation, iso: self.iso.to_vec() })
    }

    /// Corner values of the harmonic maps with these extents, which close all meta-faces; one factorisation for all.
    ///
    /// # Errors
    /// [`HarmonicError::Solve`] if nothing holds the map.
    pub(super) fn maps(&self, extents: &[Vec<f64>]) -> Result<Vec<Vec<DVec2>>, HarmonicError> {
        let mut factored = None;
        let mut maps = Vec::with_capacity(extents.len());
        for extents in extents {
            let laid = Laid::new(self.graph, extents);
            let (rotation, translation) = laid.transitions(self.mesh, self.graph);
            let charts = Charts { rotation: &rotation, translation: &translation };
            let laplacian = ModifiedLaplacian::new(self.mesh, self.frames, &charts);
            let holds = self.holds(&laid);
            if factored.is_none() {
                factored = Some(laplacian.factor(&holds)?);
            }
            maps.extend(factored.as_ref().map(|factored| laplacian.solve_with(factored, &holds)));
        }
        Ok(maps)
    }

    /// What the meta-system says of vertices.
    fn holds(&self, laid: &Laid) -> Vec<Hold> {
        let Self { mesh, graph, is_held, iso, boundary, .. } = *self;
        let mut holds = Vec::new();
        for (edge, at) in graph.edges.iter().zip(&laid.ends) {
            let [from, to] = at[0];
            let first = edge.path[0];
            let last = edge.path[edge.path.len() - 1];
            for (corner, value) in [(first, from), (next(last), to)] {
                if is_held[mesh.origin(corner) as usize] {
                    holds.push(Hold { corner, value: [Some(value.x), Some(value.y)] });
                }
            }
            if iso[first] == Iso::None {
                continue;
            }
            let fixed = usize::from(edge.tags[0] % 2 == 0);
            let is_linear = edge.faces[1] == NONE && boundary == BoundaryValues::Linear;
            let mut along = 0.0;
            for (k, &h) in edge.path.iter().enumerate() {
                let mut value = [None; 2];
                value[fixed] = Some(from[fixed]);
                if is_linear && k > 0 {
                    let z = from.lerp(to, along / edge.length);
                    value = [Some(z.x), Some(z.y)];
                }
                holds.push(Hold { corner: h, value });
                along += mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)));
            }
            let mut value = [None; 2];
            value[fixed] = Some(from[fixed]);
            holds.push(Hold { corner: next(last), value });
        }
        holds
    }
}
