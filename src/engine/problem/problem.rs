//! One connected component and what is asked for it.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::field::FrameField;
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::problem::{RefinementPoint, Wishes, size_at};

/// One connected component of a surface and what its quads are to be like. Copies share the large parts.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The component, with the features that its quads must have on edges.
    pub surface: Arc<Surface>,
    /// The index of its mesh.
    pub index: Arc<SurfaceIndex>,
    /// Per vertex, its vertex in the whole surface.
    pub vertices: Arc<[u32]>,
    /// Per vertex, the vertex of the input that it comes from; empty where that is not known.
    pub inputs: Arc<[u32]>,
    /// Per halfedge, its halfedge in the whole surface.
    pub halfedges: Arc<[u32]>,
    /// Length of a quad edge in model units.
    pub edge_length: f64,
    /// Edge length by which distances are judged, in model units: the component's own as it was asked for, or that of the
    /// whole where it is shorter.
    pub judged_edge: f64,
    /// Area over squared edge length.
    pub quads: f64,
    /// Per vertex the logarithm of the size relative to the edge length; empty if all quads are to be alike.
    pub log_size: Vec<f64>,
    /// Places with detail below the size of the quads, around which they are to be smaller.
    pub refined: Arc<[RefinementPoint]>,
    /// Lines to follow, of the whole model.
    pub strokes: Arc<[Vec<DVec3>]>,
    /// The field to follow on the faces of the surface, where one was given.
    pub field: Option<Arc<FrameField>>,
    /// What is asked of every component alike.
    pub wishes: Wishes,
}

impl Problem {
    /// The same problem with smaller quads around more places; `None` if there are no others than so far.
    pub fn refined_at(&self, places: impl Iterator<Item = RefinementPoint>) -> Option<Self> {
        let refined = RefinementPoint::apart(self.refined.iter().copied().chain(places), self.edge_length);
        (refined.len() > self.refined.len()).then(|| Self { refined: refined.into(), ..self.clone() })
    }

    /// The same problem with quads half as large as so far around some places, but not below the size `least` (relative to
    /// the edge length); `None` if that changes nothing.
    pub fn halved_at(&self, places: &[DVec3], least: f64) -> Option<Self> {
        let halved = |&at: &DVec3| RefinementPoint { at, size: 0.5 * self.refined_to(at) };
        self.refined_at(places.iter().map(halved).filter(|place| place.size >= least))
    }

    /// The same problem with quads of `factor` times the edge length.
    pub fn with_edges_times(&self, factor: f64) -> Self {
        let (edge_length, quads) = (self.edge_length * factor, self.quads / (factor * factor));
        Self { edge_length, quads, ..self.clone() }
    }

    /// Whether all quads are to be alike.
    pub fn is_even(&self) -> bool {
        self.log_size.is_empty() && self.refined.is_empty()
    }

    /// Logarithm of the size of quads at a point near the surface, relative to the edge length.
    pub fn log_size_at(&self, p: DVec3) -> f64 {
        size_at(&self.surface.mesh, &self.index, &self.log_size, p) + self.refined_to(p).ln()
    }

    /// The size that refinement leaves at a point, relative to the edge length, at most 1.
    fn refined_to(&self, p: DVec3) -> f64 {
        let around = |place: &RefinementPoint| place.size_at(place.at.distance(p) / self.edge_length);
        self.refined.iter().map(around).fold(1.0, f64::min)
    }
}
