//! The certificate alone, for quads from anywhere.

use glam::DVec3;

use crate::engine::certify::{Certificate, certify};
use crate::engine::mesh::Detected;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::spec::{NonOrientable, RemeshSpec, Symmetry, Target};
use crate::engine::pipeline::surface::{SHORTEST_FEATURE, edge_length, features, middle};
use crate::engine::pipeline::symmetry::{MirrorPlane, Planes, fold, turned, unfold_surface};
use crate::engine::quad::QuadMesh;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;

/// Middles of edges that differ less than this, relative to the diagonal, are of the same edge: reports are decimal.
const SAME_PLACE: f64 = 1e-9;

/// What the report of the run that made the quads says about the surface that it made them for.
#[derive(Clone, Debug, Default)]
pub struct RunFindings {
    /// The edge length asked for, in model units.
    pub edge_length: f64,
    /// Planes at which the quads, and so their surface, are mirrored; at right angles to each other.
    pub symmetry: Vec<MirrorPlane>,
    /// Middles of feature edges that were given up.
    pub given_up: Vec<DVec3>,
}

/// Certifies `quads` against the surface of `soup`, conditioned and with features as a run with this spec has them, and
/// where its findings are known, with the features that it gave up left out.
///
/// ```
/// use glam::DVec3;
/// use quadrille::engine::mesh::TriangleSoup;
/// use quadrille::engine::pipeline::{RemeshSpec, check};
/// use quadrille::engine::quad::QuadMesh;
/// use quadrille::engine::run::RunContext;
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let soup = TriangleSoup::from_triangles(positions.clone(), &[[0, 1, 2], [0, 2, 3]]);
/// let upside_down = QuadMesh { positions, quads: vec![[3, 2, 1, 0]] };
/// let certificate = check(&RunContext::silent(), &soup, &upside_down, &RemeshSpec::default(), None)?;
/// assert!(!certificate.certified && certificate.measures.flipped == 1);
/// # Ok::<(), quadrille::engine::pipeline::RemeshError>(())
/// ```
///
/// # Errors
/// [`RemeshError`]: the input is refused, or the run was stopped.
pub fn check(
    ctx: &RunContext,
    soup: &TriangleSoup,
    quads: &QuadMesh,
    spec: &RemeshSpec,
    findings: Option<&RunFindings>,
) -> Result<Certificate, RemeshError> {
    let conditioned = ctx.stage(Stage::Condition, |ctx| {
        let options = ConditionOptions { cut_non_orientable: spec.non_orientable == NonOrientable::Cut };
        condition(ctx, soup, &options).map_err(RemeshError::from)
    })?;
    let mut spec = spec.clone();
    if let Some(findings) = findings {
        spec.target = Target::EdgeLength(findings.edge_length);
    }
    let edge_length = edge_length(&conditioned, &spec)?;
    let asked = findings.map_or(0.0, |findings| findings.edge_length);
    let Detected { features, .. } =
        ctx.stage(Stage::Features, |_| Ok::<_, Cancelled>(features(&conditioned, soup, &spec, edge_length)))?;
    let mut surface = Surface { mesh: conditioned.mesh, features };
    let planes = match (findings, &spec.symmetry) {
        (Some(findings), _) if findings.symmetry.is_empty() => None,
        (Some(findings), _) => Some(Planes::known(&findings.symmetry)),
        (None, Symmetry::Across(axes)) => (!axes.is_empty()).then(|| Planes::across(axes)),
        (None, Symmetry::Auto) => None,
    };
    if let Some(planes) = planes {
        let min_length = SHORTEST_FEATURE * edge_length;
        let in_frame = planes.turn().map_or_else(|| surface.clone(), |turn| turned(&surface, turn));
        let fold = fold(ctx, &in_frame, &[], &planes, min_length, &mut Vec::new())?;
        if let Some(whole) = unfold_surface(&fold.surface, &fold.unfoldings) {
            surface = planes.turn().map_or_else(|| whole.clone(), |turn| turned(&whole, turn.transpose()));
        }
    }
    if let Some(findings) = findings {
        surface = without(surface, &findings.given_up);
    }
    ctx.stage(Stage::Certify, |ctx| {
        certify(ctx, &surface, &SurfaceIndex::new(&surface.mesh), quads, asked).map_err(RemeshError::from)
    })
}

/// The surface without the feature edges whose middles are given.
fn without(surface: Surface, middles: &[DVec3]) -> Surface {
    let Surface { mesh, features } = surface;
    let same = SAME_PLACE * mesh.diagonal();
    let mut middles = middles.to_vec();
    middles.sort_by(|a, b| a.x.total_cmp(&b.x));
    let is_given_up = |p: DVec3| {
        let first = middles.partition_point(|m| m.x < p.x - same);
        middles[first..].iter().take_while(|m| m.x <= p.x + same).any(|m| m.distance(p) <= same)
    };
    let kept: Vec<[u32; 2]> = features.edges.iter().copied().filter(|&e| !is_given_up(middle(&mesh, e))).collect();
    if kept.len() == features.edges.len() {
        return Surface { mesh, features };
    }
    let features = features.restricted(&mesh, kept);
    Surface { mesh, features }
}
