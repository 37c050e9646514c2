//! What a run says about its result (docs/contract.md, section 4). Plain data; the service turns it into JSON.

use glam::DVec3;

use crate::engine::certify::QuadReport;
use crate::engine::mesh::TriMesh;
use crate::engine::methods::{Data, Level};
use crate::engine::pipeline::symmetry::MirrorPlane;
use crate::engine::run::Warning;

/// How the conditioned surface differs from the input; one counter per kind of repair.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Repair name (`snake_case`, stable) and how often it was made; only what happened is listed, in a fixed order.
    pub counts: Vec<(&'static str, usize)>,
}

impl Repairs {
    /// Adds `n` to the counter `name`; nothing is listed for 0.
    pub fn add(&mut self, name: &'static str, n: usize) {
        if n == 0 {
            return;
        }
        match self.counts.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += n,
            None => self.counts.push((name, n)),
        }
    }

    /// The counter `name`.
    pub fn count(&self, name: &str) -> usize {
        self.counts.iter().find(|(known, _)| *known == name).map_or(0, |&(_, n)| n)
    }
}

/// Numbers of the input after conditioning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputReport {
    /// Vertices of the conditioned mesh.
    pub vertices: usize,
    /// Triangles of the conditioned mesh.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus, summed over components.
    pub genus: usize,
    /// Interior feature edges.
    pub feature_edges: usize,
    /// What was repaired.
    pub repairs: Repairs,
}

/// Sharp edges of the input: those above the feature angle, material borders and edges that were asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeatureReport {
    /// Edges found.
    pub detected: usize,
    /// Edges that are chains of quad edges.
    pub kept: usize,
    /// Edges that are not: noise, or detail below the size of the quads.
    pub dropped: usize,
    /// Middles of the dropped edges that a component gave up during the run. The certificate does not ask for them.
    pub given_up: Vec<DVec3>,
    /// Middles of all dropped edges.
    pub dropped_at: Vec<DVec3>,
}

impl FeatureReport {
    /// What became of the features of `mesh`: `dropped` are edges that were left out at once, `given_up` middles of those
    /// that were left out later, and `kept` is the number that is left.
    pub(super) fn of(mesh: &TriMesh, dropped: &[[u32; 2]], given_up: &[DVec3], kept: usize) -> Self {
        let early = dropped.iter().map(|e| 0.5 * (mesh.position(e[0]) + mesh.position(e[1])));
        let dropped_at: Vec<DVec3> = early.chain(given_up.iter().copied()).collect();
        let dropped = dropped_at.len();
        Self { detected: kept + dropped, kept, dropped, given_up: given_up.to_vec(), dropped_at }
    }
}

/// A singularity of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// Vertex of the working mesh.
    pub vertex: u32,
    /// Index in quarters: +1 is valence 3.
    pub index_quarters: i32,
    /// Position in grid units, in the chart of the vertex's first corner.
    pub uv: [f64; 2],
}

/// Measures of the parameterisation; energies relative to ½‖X‖².
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapReport {
    /// Triangles of the working mesh.
    pub triangles: usize,
    /// Triangles with negative orientation in the map.
    pub flipped: usize,
    /// Largest deviation of a transition from a quarter turn plus an integer translation, in grid units.
    pub seam_residual: f64,
    /// Singularities.
    pub singularities: Vec<Singularity>,
    /// Area-weighted mean ARAP energy.
    pub arap_mean: f64,
    /// Area-weighted mean of σ1/σ2 + σ2/σ1 over triangles that are not flipped; 2 is conformal.
    pub conformal_mean: f64,
    /// Energy of the seamless map before rounding, of the components whose map follows a field.
    pub curl_energy: Option<f64>,
    /// Energy added by rounding, of the same components.
    pub rounding_energy: Option<f64>,
    /// What the search for branch points did, if there was one.
    pub branch_search: Option<BranchReport>,
    /// What the method says of the map of each component, as its own parameters say it; only of components of which it says
    /// something.
    pub details: Vec<Data>,
}

/// The search for branch points on all components. Before: on the mesh where it began, which may be coarser.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BranchReport {
    /// Branch points before and after.
    pub points: [usize; 2],
    /// Curl energy before and after, relative to ½‖X‖², the area-weighted mean over the components.
    pub curl_energy: [f64; 2],
    /// Energies computed.
    pub evaluations: usize,
    /// Batches of moves that were kept.
    pub accepted: usize,
}

/// The report of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Name of the method.
    pub method: &'static str,
    /// Whether the certificate passed.
    pub certified: bool,
    /// The worst level of the components.
    pub level: Level,
    /// Level per component, in order of the components' first faces.
    pub component_levels: Vec<Level>,
    /// Whether the deadline cut the run short: another run with the same input and spec may end otherwise.
    pub cut_by_deadline: bool,
    /// The conditioned input.
    pub input: InputReport,
    /// Length of the quad edges asked for, in model units.
    pub edge_length: f64,
    /// What became of its features.
    pub features: FeatureReport,
    /// Planes at which the quads are their own mirror image; at right angles to each other.
    pub symmetry: Vec<MirrorPlane>,
    /// The quads.
    pub quads: QuadReport,
    /// The map, where one was made.
    pub map: Option<MapReport>,
    /// What there is to say besides.
    pub warnings: Vec<Warning>,
}
