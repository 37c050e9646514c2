//! The singularity graph `[tong_2006]` section 3.1: meta-vertices, meta-edges as paths of mesh edges with tags on their two
//! sides, and meta-faces, discs with a chart each.

use glam::I64Vec2;

use crate::engine::mesh::TriMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::tag::Tag;
use crate::engine::parameterize::rotate_integer;
use crate::engine::topology::Singularity;

/// A meta-edge: a path between two meta-vertices.
#[derive(Clone, Debug)]
pub(super) struct MetaEdge {
    /// Numbers of the meta-vertices at its ends.
    pub(super) ends: [u32; 2],
    /// Halfedges of the mesh along the path, each beginning where the last one ended, with the left face on their left.
    pub(super) path: Vec<usize>,
    /// The meta-faces on the left and on the right; `NONE` beyond a boundary.
    pub(super) faces: [u32; 2],
    /// Tags of the half meta-edges: along the path in the chart of the left face, against it in that of the right.
    pub(super) tags: [Tag; 2],
    /// Length in grid units: Du or Dv, positive.
    pub(super) extent: i64,
    /// The same in the map that the graph comes from, before it was made an integer.
    pub(super) real: f64,
    /// Length of the path, model units.
    pub(super) length: f64,
}

/// A half meta-edge as a side of a meta-face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    /// The meta-edge.
    pub(super) edge: u32,
    /// 0 along its path, 1 against it.
    pub(super) half: usize,
}

/// A singularity graph on a cut mesh.
#[derive(Clone, Debug)]
pub(super) struct SingularityGraph {
    /// Per meta-vertex its vertex in the mesh.
    pub(super) vertices: Vec<u32>,
    pub(super) edges: Vec<MetaEdge>,
    /// The sides of each meta-face, counter-clockwise.
    pub(super) faces: Vec<Vec<Side>>,
}

impl MetaEdge {
    /// Quarter turns across: `z_left = i^m z_right + τ`.
    pub(super) fn quarters(&self) -> u8 {
        (self.tags[0] + 4 - self.tags[1] + 2) & 3
    }
}

/// The step of `extent` grid units along a tag.
pub(super) fn step(tag: Tag, extent: i64) -> I64Vec2 {
    rotate_integer(I64Vec2::new(extent, 0), tag)
}

impl SingularityGraph {
    pub(super) fn edge(&self, side: Side) -> &MetaEdge {
        &self.edges[side.edge as usize]
    }

    pub(super) fn tag(&self, side: Side) -> Tag {
        self.edge(side).tags[side.half]
    }

    /// The meta-vertex where a side begins.
    pub(super) fn start(&self, side: Side) -> u32 {
        self.edge(side).ends[side.half]
    }

    /// Where the sides of a meta-face begin in its chart; the first one at 0.
    ///
    /// # Errors
    /// [`HarmonicError::Open`] if the last side does not end at the first one.
    pub(super) fn corners(&self, face: u32) -> Result<Vec<I64Vec2>, HarmonicError> {
        let mut at = I64Vec2::ZERO;
        let mut corners = Vec::with_capacity(self.faces[face as usize].len());
        for &side in &self.faces[face as usize] {
            corners.push(at);
            at += step(self.tag(side), self.edge(side).extent);
        }
        match at {
            I64Vec2::ZERO => Ok(corners),
            I64Vec2 { x: 0, y } => Err(HarmonicError::Open { face, coordinate: 'v', sum: y }),
            I64Vec2 { x, .. } => Err(HarmonicError::Open { face, coordinate: 'u', sum: x }),
        }
    }

    /// Whether every meta-face turns once: its corners turn by four quarter turns to the left in all.
    ///
    /// # Errors
    /// [`HarmonicError::Turning`] of the first face that does not.
    pub(super) fn check_turning(&self) -> Result<(), HarmonicError> {
        for (face, sides) in (0..).zip(&self.faces) {
            let quarters = (0..sides.len()).map(|k| self.turn(sides, k)).sum();
            if quarters != 4 {
                return Err(HarmonicError::Turning { face, quarters });
            }
        }
        Ok(())
    }

    /// The tags of the same graph as seen from the other side of the surface, in charts whose u runs the other way.
    pub(super) fn mirror(&mut self) {
        let mirrored = |tag: Tag| if tag.is_multiple_of(2) { tag ^ 2 } else { tag };
        for edge in &mut self.edges {
            edge.tags = [mirrored(edge.tags[1]), mirrored(edge.tags[0])];
        }
    }

    /// Turn of the corner between a side and the next one, quarter turns to the left. Between opposite tags the full turn to the
    /// right is taken: the corner then has a whole turn of angle, instead of none.
    fn turn(&self, sides: &[Side], k: usize) -> i32 {
        match (self.tag(sides[(k + 1) % sides.len()]) + 4 - self.tag(sides[k])) & 3 {
            3 => -1,
            2 => -2,
            turn => i32::from(turn),
        }
    }

    /// The meta-vertices in the interior around which the angles of the corners are not four quarter turns.
    pub(super) fn singularities(&self, mesh: &TriMesh) -> Vec<Singularity> {
        let mut quarters = vec![4i32; self.vertices.len()];
        for sides in &self.faces {
            for (k, &side) in (0..sides.len()).zip(sides) {
                let end = self.edge(side).ends[1 - side.half];
                quarters[end as usize] -= 2 - self.turn(sides, k);
            }
        }
        let all = self.vertices.iter().zip(quarters).map(|(&vertex, quarters)| Singularity { vertex, quarters });
        all.filter(|s| s.quarters != 0 && !mesh.is_boundary_vertex(s.vertex)).collect()
    }

    /// Area of all meta-faces in grid units: how many quads there will be.
    pub(super) fn quads(&self) -> Result<f64, HarmonicError> {
        let mut twice = 0;
        for face in 0..self.faces.len() as u32 {
            let corners = self.corners(face)?;
            let n = corners.len();
            twice += (0..n).map(|k| corners[k].perp_dot(corners[(k + 1) % n])).sum::<i64>();
        }
        Ok(0.5 * twice as f64)
    }
}
