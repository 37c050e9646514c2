//! The report as JSON (docs/contract.md, section 4).

use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use crate::engine::pipeline::{FeatureReport, InputReport, MapReport, MirrorPlane, QuadReport, Report, RunFindings};
use crate::service::wire::data::json_of;
use crate::service::wire::level::LevelName;
use crate::service::wire::{Axis, Named, SymmetryAxis, WarningBody};

/// The report of one run. Angles in degrees, distances relative to the bounding-box diagonal, RSD = standard
/// deviation / mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ReportBody {
    /// Version of the program.
    pub version: String,
    /// Method that ran.
    pub method: String,
    /// Whether the certificate passed on the re-read file.
    pub certified: bool,
    /// The worst level of the components.
    pub level: LevelName,
    /// Level of each component.
    pub component_levels: Vec<LevelName>,
    /// The conditioned input.
    pub input: InputReportBody,
    /// Length of the quad edges asked for, in model units.
    pub edge_length: f64,
    /// What became of its sharp edges.
    pub features: FeaturesReportBody,
    /// Axes across which the quads are their own mirror image.
    pub symmetry: Vec<SymmetryAxis>,
    /// Planes at which the quads are their own mirror image, also those that are across no axis.
    #[serde(default)]
    pub mirror_planes: Vec<MirrorPlaneBody>,
    /// The quads.
    pub quads: QuadsBody,
    /// The parameterisation, where one was made.
    pub map: Option<MapBody>,
    /// Milliseconds per stage, in order, and `total`.
    #[schema(value_type = std::collections::BTreeMap<String, f64>)]
    pub timings_ms: Map<String, Value>,
    /// Largest resident size of the process so far; 0 where the system does not say.
    pub peak_memory_bytes: u64,
    /// Whether the deadline cut the run short: an equal request may then end otherwise.
    pub cut_by_deadline: bool,
    /// Soft troubles.
    pub warnings: Vec<WarningBody>,
}

/// The input after conditioning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InputReportBody {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus, summed over components.
    pub genus: usize,
    /// Interior feature edges.
    pub feature_edges: usize,
    /// Counter per kind of repair; only what happened.
    #[schema(value_type = std::collections::BTreeMap<String, u64>)]
    pub repairs: Map<String, Value>,
}

/// Sharp edges of the input: above the feature angle, between materials, or asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FeaturesReportBody {
    /// Edges found.
    pub detected: usize,
    /// Edges that are chains of quad edges.
    pub kept: usize,
    /// Edges that are not: noise, or detail below the size of the quads.
    pub dropped: usize,
    /// Middles, in model units, of the dropped edges that the certificate would ask for if the run had not given them
    /// up: `quadrille check --report` reads them.
    pub given_up: Vec<[f64; 3]>,
}

impl From<&FeatureReport> for FeaturesReportBody {
    fn from(features: &FeatureReport) -> Self {
        let FeatureReport { detected, kept, dropped, .. } = *features;
        Self { detected, kept, dropped, given_up: features.given_up.iter().map(|p| p.to_array()).collect() }
    }
}

/// Minimum and mean over quads of the minimum scaled Jacobian of the corners.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ScaledJacobian {
    /// Minimum.
    pub min: f64,
    /// Mean.
    pub mean: f64,
}

/// Maximum and mean of a distance, relative to the bounding-box diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Spread {
    /// Maximum.
    pub max: f64,
    /// Mean.
    pub mean: f64,
}

/// Measures of the quads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct QuadsBody {
    /// Quads.
    pub count: usize,
    /// Vertices.
    pub vertices: usize,
    /// Interior vertices whose valence is not 4.
    pub irregular_interior: usize,
    /// Irregular boundary vertices, corners of the surface left out.
    pub irregular_boundary: usize,
    /// Interior valence and how many vertices have it, ascending.
    #[schema(value_type = std::collections::BTreeMap<String, u64>)]
    pub valences: Map<String, Value>,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus, summed over components.
    pub genus: usize,
    /// RSD of edge lengths.
    pub rsd_edge: f64,
    /// RSD of corner angles.
    pub rsd_angle: f64,
    /// Scaled Jacobian.
    pub scaled_jacobian: ScaledJacobian,
    /// Two-sided distance to the surface.
    pub hausdorff: Spread,
    /// Distance of feature curves to the nearest quad edges.
    pub feature_error: Spread,
    /// Quads whose normal opposes the surface's.
    pub flipped: usize,
}

/// A singularity of the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SingularityBody {
    /// Vertex of the working mesh, from 0.
    pub vertex: u32,
    /// Index in quarters; +1 is valence 3.
    pub index_quarters: i32,
    /// Position in grid units, in the chart of the vertex's first corner.
    pub uv: [f64; 2],
}

/// Measures of the parameterisation; energies relative to ½‖X‖².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MapBody {
    /// Triangles of the working mesh.
    pub triangles: usize,
    /// Triangles of negative orientation.
    pub flipped: usize,
    /// Largest deviation of a transition from a quarter turn and an integer translation, in grid units.
    pub seam_residual: f64,
    /// Singularities.
    pub singularities: Vec<SingularityBody>,
    /// Area-weighted mean ARAP energy.
    pub arap_mean: f64,
    /// Area-weighted mean of σ1/σ2 + σ2/σ1; 2 is conformal.
    pub conformal_mean: f64,
    /// Energy of the seamless map before rounding; absent where no map follows a field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curl_energy: Option<f64>,
    /// Energy added by rounding; absent where no map follows a field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounding_energy: Option<f64>,
    /// What the search for branch points did; absent if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch_search: Option<BranchSearchBody>,
    /// What the method says of the map of each component, as its own `params` say it: sent back, they give this map. Absent
    /// where it says nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(value_type = Vec<std::collections::BTreeMap<String, Value>>)]
    pub details: Vec<Value>,
}

/// The search for branch points: numbers before and after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BranchSearchBody {
    /// Branch points before.
    pub points_before: usize,
    /// Branch points after.
    pub points_after: usize,
    /// Energy of the field's curl before, on the mesh where the search began, relative to ½‖X‖².
    pub curl_energy_before: f64,
    /// The same after, on the working mesh.
    pub curl_energy_after: f64,
    /// Energies computed.
    pub evaluations: usize,
    /// Batches of moves kept.
    pub accepted: usize,
}

/// A plane at which quads are their own mirror image: the points p with p · normal = offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MirrorPlaneBody {
    /// A unit vector, towards the side that was solved.
    pub normal: [f64; 3],
    /// Distance of the plane from the origin along the normal, model units.
    pub offset: f64,
}

impl From<&MirrorPlane> for MirrorPlaneBody {
    fn from(plane: &MirrorPlane) -> Self {
        Self { normal: plane.normal.to_array(), offset: plane.offset }
    }
}

impl From<&MirrorPlaneBody> for MirrorPlane {
    fn from(plane: &MirrorPlaneBody) -> Self {
        Self { normal: DVec3::from_array(plane.normal), offset: plane.offset }
    }
}

impl ReportBody {
    /// What the certificate has to know of the run to judge its quads once more.
    pub fn findings(&self) -> RunFindings {
        RunFindings {
            edge_length: self.edge_length,
            symmetry: self.mirror_planes.iter().map(MirrorPlane::from).collect(),
            given_up: self.features.given_up.iter().copied().map(DVec3::from_array).collect(),
        }
    }

    /// The report of the engine; timings and memory are not known yet.
    pub fn of(report: &Report) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            method: report.method.to_owned(),
            certified: report.certified,
            level: report.level.into(),
            component_levels: report.component_levels.iter().map(|&level| level.into()).collect(),
            input: (&report.input).into(),
            edge_length: report.edge_length,
            features: (&report.features).into(),
            symmetry: report.symmetry.iter().filter_map(|p| Axis::of_index(p.axis()?)).map(Named).collect(),
            mirror_planes: report.symmetry.iter().map(MirrorPlaneBody::from).collect(),
            quads: (&report.quads).into(),
            map: report.map.as_ref().map(MapBody::from),
            timings_ms: Map::new(),
            peak_memory_bytes: 0,
            cut_by_deadline: report.cut_by_deadline,
            warnings: report.warnings.iter().map(WarningBody::from).collect(),
        }
    }

    /// Notes the milliseconds per stage, in order, the total and the peak of the resident memory.
    pub fn set_timings(&mut self, stages: &[(&str, f64)], total_ms: f64, peak_memory_bytes: u64) {
        self.timings_ms = stages.iter().map(|&(stage, ms)| (stage.to_owned(), rounded(ms))).collect();
        self.timings_ms.insert("total".to_owned(), rounded(total_ms));
        self.peak_memory_bytes = peak_memory_bytes;
    }
}

/// Thousandths of a millisecond are noise.
fn rounded(ms: f64) -> Value {
    Value::from((ms * 1000.0).round() / 1000.0)
}

impl From<&InputReport> for InputReportBody {
    fn from(input: &InputReport) -> Self {
        Self {
            vertices: input.vertices,
            triangles: input.triangles,
            components: input.components,
            boundaries: input.boundaries,
            genus: input.genus,
            feature_edges: input.feature_edges,
            repairs: input.repairs.counts.iter().map(|&(name, n)| (name.to_owned(), Value::from(n))).collect(),
        }
    }
}

impl From<&QuadReport> for QuadsBody {
    fn from(quads: &QuadReport) -> Self {
        Self {
            count: quads.count,
            vertices: quads.vertices,
            irregular_interior: quads.irregular_interior,
            irregular_boundary: quads.irregular_boundary,
            valences: quads.valences.iter().map(|&(valence, n)| (valence.to_string(), Value::from(n))).collect(),
            components: quads.components,
            boundaries: quads.boundaries,
            genus: quads.genus,
            rsd_edge: quads.rsd_edge,
            rsd_angle: quads.rsd_angle,
            scaled_jacobian: ScaledJacobian { min: quads.scaled_jacobian_min, mean: quads.scaled_jacobian_mean },
            hausdorff: Spread { max: quads.hausdorff_max, mean: quads.hausdorff_mean },
            feature_error: Spread { max: quads.feature_error_max, mean: quads.feature_error_mean },
            flipped: quads.flipped,
        }
    }
}

impl From<&MapReport> for MapBody {
    fn from(map: &MapReport) -> Self {
        let singularity = |s: &crate::engine::pipeline::Singularity| SingularityBody {
            vertex: s.vertex,
            index_quarters: s.index_quarters,
            uv: s.uv,
        };
        Self {
            triangles: map.triangles,
            flipped: map.flipped,
            seam_residual: map.seam_residual,
            singularities: map.singularities.iter().map(singularity).collect(),
            arap_mean: map.arap_mean,
            conformal_mean: map.conformal_mean,
            curl_energy: map.curl_energy,
            rounding_energy: map.rounding_energy,
            branch_search: map.branch_search.map(|search| BranchSearchBody {
                points_before: search.points[0],
                points_after: search.points[1],
                curl_energy_before: search.curl_energy[0],
                curl_energy_after: search.curl_energy[1],
                evaluations: search.evaluations,
                accepted: search.accepted,
            }),
            details: map.details.iter().map(json_of).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
