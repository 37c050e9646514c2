//! What all discs share: the surface, the judge, the curves.

use crate::engine::certify::{QuadJudge, corner_reach};
use crate::engine::mesh::{FaceTree, Surface, SurfaceIndex};
use crate::engine::quad::Anchor;
use crate::engine::quad::optimise::{Curve, trace_curves};
use glam::DVec3;

/// A vertex further off its curve than this part of an edge has left it.
const OFF_CURVE: f64 = 0.1;
/// A face may hold a vertex if its normal is within 78 degrees (cosine) of that of the surface around it.
const SAME_SIDE: f64 = 0.2;

/// The surface beneath a draft.
#[derive(Debug)]
pub(super) struct Ground<'a> {
    pub(super) surface: &'a Surface,
    pub(super) index: &'a SurfaceIndex,
    pub(super) judge: QuadJudge<'a>,
    /// Mean edge of the draft in model units.
    pub(super) edge: f64,
    /// Diagonal of the surface's bounding box in model units.
    diagonal: f64,
    pub(super) curves: Vec<Curve>,
    /// The segments of the curves, named by their curve.
    rails: FaceTree,
}

impl<'a> Ground<'a> {
    /// `edge` is the mean edge of the draft, `asked` the one that was asked for.
    pub(super) fn new(surface: &'a Surface, index: &'a SurfaceIndex, edge: f64, asked: f64) -> Self {
        let curves = trace_curves(surface);
        let (mut segments, mut names) = (Vec::new(), Vec::new());
        for (name, curve) in (0u32..).zip(&curves) {
            segments.extend(curve.segments().map(|[a, b]| [a, b, b]));
            names.resize(segments.len(), name);
        }
        let rails = FaceTree::of_triangles(segments, &names);
        let (judge, diagonal) = (QuadJudge::new(surface, index, edge).reaching(asked), surface.mesh.diagonal());
        Self { surface, index, judge, edge, diagonal, curves, rails }
    }

    /// The curve nearest to a point, and how far it is.
    pub(super) fn nearest_curve(&self, p: DVec3) -> Option<(u32, f64)> {
        self.rails.closest_where(p, f64::INFINITY, |_| true).map(|found| (found.face, found.distance))
    }

    /// Whether a vertex is not on what it is anchored to.
    pub(super) fn is_off(&self, anchor: Anchor, p: DVec3) -> bool {
        match anchor {
            Anchor::Corner(c) => self.surface.mesh.position(c).distance(p) > corner_reach(self.diagonal, p),
            Anchor::Curve => self.nearest_curve(p).is_some_and(|(_, distance)| distance > OFF_CURVE * self.edge),
            Anchor::Surface => false,
        }
    }

    /// The point of the surface nearest to `p` whose normal agrees with `up`, if there is one within `reach`.
    pub(super) fn drawn(&self, p: DVec3, up: DVec3, reach: f64) -> Option<DVec3> {
        let agrees = |face: u32| up == DVec3::ZERO || self.index.normal(face).dot(up) > SAME_SIDE;
        self.index.closest_where(p, reach, agrees).map(|found| found.position)
    }
}
