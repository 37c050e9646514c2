//! Quad layouts: patches with four sides each, whose nodes lie on the surface, and the quads that they are cut into.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::{Anchor, QuadDraft, QuadMesh};
use crate::engine::run::{Cancelled, RunContext};

/// Most segments of one side: counts beyond are a mistake of the layout's lengths.
const MAX_SEGMENTS: f64 = 65_536.0;
/// Halvings of the interval of scales in which the count is looked for.
const HALVINGS: usize = 40;

/// A corner of patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutNode {
    /// Place in model units.
    pub position: DVec3,
    /// What it must stay on.
    pub anchor: Anchor,
}

/// What an arc lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcCourse {
    /// The surface.
    Surface,
    /// A feature curve.
    Feature,
    /// The boundary.
    Boundary,
}

/// A side of patches, from node to node.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutArc {
    /// Nodes at its ends.
    pub ends: [u32; 2],
    /// The polyline from end to end, both nodes among its points; at least two points, model units.
    pub points: Vec<DVec3>,
    /// What it lies on.
    pub course: ArcCourse,
}

/// An arc as the side of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// The arc.
    pub arc: u32,
    /// Whether the patch has it from its second end to its first.
    pub is_reversed: bool,
}

/// A conforming layout of a surface by patches with four sides.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadLayout {
    /// Corners of patches.
    pub nodes: Vec<LayoutNode>,
    /// Sides of patches; each belongs to two patches, or to one at the boundary.
    pub arcs: Vec<LayoutArc>,
    /// The four sides of each patch, counter-clockwise seen from outside: each begins where the one before it ends.
    pub patches: Vec<[Side; 4]>,
}

/// A layout that quads cannot be made of.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LayoutError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A number is out of range, or an arc has fewer than two points.
    #[error("arc {arc} of the layout does not exist or has no course")]
    Arc {
        /// Its number.
        arc: u32,
    },
    /// The sides of a patch do not form a cycle.
    #[error("the sides of patch {patch} of the layout do not meet")]
    OpenPatch {
        /// Its number.
        patch: usize,
    },
}

impl LayoutArc {
    fn length(&self) -> f64 {
        self.points.windows(2).map(|p| p[0].distance(p[1])).sum()
    }

    /// `n + 1` points at equal distances along it.
    fn divided(&self, n: usize) -> Vec<DVec3> {
        let whole = self.length();
        let (mut at, mut before) = (0, 0.0);
        let point = |i: usize| {
            let wanted = whole * i as f64 / n as f64;
            let mut step = self.points[at].distance(self.points[at + 1]);
            while before + step < wanted && at + 2 < self.points.len() {
                before += step;
                at += 1;
                step = self.points[at].distance(self.points[at + 1]);
            }
            let share = if step > 0.0 { ((wanted - before) / step).clamp(0.0, 1.0) } else { 0.0 };
            self.points[at].lerp(self.points[at + 1], share)
        };
        (0..=n).map(point).collect()
    }
}

impl QuadLayout {
    fn check(&self) -> Result<(), LayoutError> {
        let nodes = self.nodes.len() as u32;
        for (i, arc) in (0..).zip(&self.arcs) {
            if arc.points.len() < 2 || arc.ends.iter().any(|&n| n >= nodes) {
                return Err(LayoutError::Arc { arc: i });
            }
        }
        for (patch, sides) in self.patches.iter().enumerate() {
            if let Some(side) = sides.iter().find(|side| side.arc as usize >= self.arcs.len()) {
                return Err(LayoutError::Arc { arc: side.arc });
            }
            if (0..4).any(|k| self.ends(sides[k])[1] != self.ends(sides[(k + 1) % 4])[0]) {
                return Err(LayoutError::OpenPatch { patch });
            }
        }
        Ok(())
    }

    fn ends(&self, side: Side) -> [u32; 2] {
        let [a, b] = self.arcs[side.arc as usize].ends;
        if side.is_reversed { [b, a] } else { [a, b] }
    }

    /// Per arc, the first arc of those that must have as many segments: opposite sides have.
    fn strips(&self) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..self.arcs.len()).collect();
        let root = |parent: &[usize], mut a: usize| {
            while parent[a] != a {
                a = parent[a];
            }
            a
        };
        for sides in &self.patches {
            for k in 0..2 {
                let [a, b] = [sides[k], sides[k + 2]].map(|side| root(&parent, side.arc as usize));
                parent[a.max(b)] = a.min(b);
            }
        }
        (0..parent.len()).map(|a| root(&parent, a)).collect()
    }

    /// Segments per arc for this edge length.
    fn segments(&self, strips: &[usize], lengths: &[f64], edge_length: f64) -> Vec<usize> {
        let mut sums = vec![(0.0, 0.0); self.arcs.len()];
        for (&strip, length) in strips.iter().zip(lengths) {
            sums[strip].0 += length;
            sums[strip].1 += 1.0;
        }
        let of = |&strip: &usize| (sums[strip].0 / sums[strip].1 / edge_length).round().clamp(1.0, MAX_SEGMENTS);
        strips.iter().map(|strip| of(strip) as usize).collect()
    }

    fn count(&self, segments: &[usize]) -> f64 {
        let of =
            |sides: &[Side; 4]| [sides[0], sides[1]].map(|s| segments[s.arc as usize] as f64).iter().product::<f64>();
        self.patches.iter().map(of).sum()
    }

    /// Segments per arc: for this edge length, or for about this number of quads.
    fn chosen_segments(&self, edge_length: f64, quads: Option<f64>) -> Vec<usize> {
        let (strips, lengths) = (self.strips(), self.arcs.iter().map(LayoutArc::length).collect::<Vec<_>>());
        let at = |log: f64| self.segments(&strips, &lengths, edge_length * log.exp());
        let Some(wanted) = quads else { return at(0.0) };
        // The count falls with the edge length; between the last too many and the first too few lies the best.
        let (mut many, mut few) = (-2.0, 2.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (many + few);
            if self.count(&at(middle)) > wanted { many = middle } else { few = middle }
        }
        let off = |segments: &[usize]| (self.count(segments) / wanted).ln().abs();
        let (many, few) = (at(many), at(few));
        if off(&many) < off(&few) { many } else { few }
    }
}

/// Cuts the patches of a layout into quads of about `edge_length`, or into about `quads` quads. Points inside patches are
/// blended from the four sides and drawn to the nearest point of the surface that `index` is of.
///
/// # Errors
/// [`LayoutError`].
pub fn quads_of_layout(
    ctx: &RunContext,
    index: &SurfaceIndex,
    layout: &QuadLayout,
    edge_length: f64,
    quads: Option<f64>,
) -> Result<QuadDraft, LayoutError> {
    layout.check()?;
    let segments = layout.chosen_segments(edge_length, quads);
    let mut draft = QuadDraft {
        mesh: QuadMesh { positions: layout.nodes.iter().map(|n| n.position).collect(), quads: Vec::new() },
        anchors: layout.nodes.iter().map(|n| n.anchor).collect(),
        feature_edges: Vec::new(),
    };
    // Vertices along arcs, both nodes among them.
    let mut along: Vec<Vec<u32>> = Vec::with_capacity(layout.arcs.len());
    for (arc, &n) in layout.arcs.iter().zip(&segments) {
        ctx.check()?;
        let first = draft.mesh.positions.len() as u32;
        let anchor = if arc.course == ArcCourse::Surface { Anchor::Surface } else { Anchor::Curve };
        draft.mesh.positions.extend_from_slice(&arc.divided(n)[1..n]);
        draft.anchors.resize(draft.mesh.positions.len(), anchor);
        let vertices: Vec<u32> =
            std::iter::once(arc.ends[0]).chain(first..first + n as u32 - 1).chain([arc.ends[1]]).collect();
        if arc.course == ArcCourse::Feature {
            draft.feature_edges.extend(vertices.windows(2).map(|e| [e[0].min(e[1]), e[0].max(e[1])]));
        }
        along.push(vertices);
    }
    draft.feature_edges.sort_unstable();
    for sides in &layout.patches {
        ctx.check()?;
        let side = |k: usize| -> Vec<u32> {
            let vertices = along[sides[k].arc as usize].iter().copied();
            if sides[k].is_reversed { vertices.rev().collect() } else { vertices.collect() }
        };
        // The last two sides run against the first two.
        let [bottom, right, top, left] = [side(0), side(1), side(2), side(3)];
        let (a, b) = (bottom.len() - 1, right.len() - 1);
        let first = draft.mesh.positions.len() as u32;
        let id = |x: usize, y: usize| match (x, y) {
            (x, 0) => bottom[x],
            (x, y) if x == a => right[y],
            (x, y) if y == b => top[a - x],
            (0, y) => left[b - y],
            (x, y) => first + ((x - 1) + (y - 1) * (a - 1)) as u32,
        };
        let p = |v: u32| draft.mesh.positions[v as usize];
        let blended = |i: usize| {
            let (x, y) = (i % (a - 1) + 1, i / (a - 1) + 1);
            let (s, t) = (x as f64 / a as f64, y as f64 / b as f64);
            let rows = p(id(x, 0)) * (1.0 - t) + p(id(x, b)) * t + p(id(0, y)) * (1.0 - s) + p(id(a, y)) * s;
            let low = p(id(0, 0)).lerp(p(id(a, 0)), s);
            let high = p(id(0, b)).lerp(p(id(a, b)), s);
            index.closest(rows - low.lerp(high, t)).position
        };
        let inner: Vec<DVec3> = (0..(a - 1) * (b - 1)).into_par_iter().map(blended).collect();
        let quads: Vec<[u32; 4]> = (0..a * b)
            .map(|i| (i % a, i / a))
            .map(|(x, y)| [id(x, y), id(x + 1, y), id(x + 1, y + 1), id(x, y + 1)])
            .collect();
        draft.mesh.quads.extend(quads);
        draft.mesh.positions.extend(inner);
        draft.anchors.resize(draft.mesh.positions.len(), Anchor::Surface);
    }
    Ok(draft)
}

#[cfg(test)]
mod tests;
