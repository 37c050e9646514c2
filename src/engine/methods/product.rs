//! What methods propose. All products end in the same extractor, the same polish and the same certificate.

use std::collections::BTreeMap;

use crate::engine::field::BranchSearch;
use crate::engine::mesh::Surface;
use crate::engine::methods::Data;
use crate::engine::parameterize::{GridMap, MapMeasures};
use crate::engine::quad::{QuadDraft, QuadLayout};
use crate::engine::topology::Singularity;

/// Whether the boundary of a map lies on grid lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryLines {
    /// It does.
    OnGrid,
    /// It lies anywhere.
    Free,
}

/// An integer-grid map, up to flipped triangles.
#[derive(Clone, Debug)]
pub struct MapProduct {
    /// The surface that it lives on: the one of the problem with other triangles.
    pub surface: Surface,
    /// Per corner of that surface, the vertex of the problem's surface at the same place.
    pub corner_of: BTreeMap<u32, u32>,
    /// The map.
    pub grid: GridMap,
    /// Its boundary.
    pub boundary: BoundaryLines,
    /// Grid units per model unit.
    pub scale: f64,
    /// Its singularities.
    pub singularities: Vec<Singularity>,
    /// Number of integers that were rounded.
    pub n_integers: usize,
    /// Its measures.
    pub measures: MapMeasures,
    /// What the search for branch points did; no evaluations where there was none.
    pub branch_search: BranchSearch,
    /// Energy of the seamless map relative to ½‖X‖², where the map follows a field X.
    pub curl_energy: Option<f64>,
    /// Energy added by rounding relative to ½‖X‖².
    pub rounding_energy: Option<f64>,
    /// Triangles of the working mesh where branch points were not searched for because there are too many.
    pub search_left_out: Option<usize>,
    /// What the method says of the map besides, as its own parameters say it: asked for again, it gives this map. Nothing
    /// where there is no such thing.
    pub details: Data,
}

/// What a method proposes.
#[derive(Clone, Debug)]
pub enum Product {
    /// A map, whose grid lines are the quads.
    Map(Box<MapProduct>),
    /// Quadrilateral patches with nodes on the surface, which are subdivided by the edge length.
    Layout(QuadLayout),
    /// Quads. They need not be regular: those without a field behind them have their connectivity improved.
    Quads(QuadDraft),
}
