//! What a file holds and what is wrong with it, without remeshing.

use glam::DVec3;
use serde::Serialize;

use crate::engine::mesh::TriangleSoup;
use crate::engine::pipeline::{RemeshSpec, inspect};
use crate::engine::run::{RunContext, Stage};
use crate::service::formats::{Format, Image, Model, ReadError, read_model};
use crate::service::run::Input;
use crate::service::wire::{InputReportBody, Problem, ProblemBody, WarningBody, problem_of_fault};

/// A file, and the surface that a run would begin with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InspectionBody {
    /// Name of the format.
    pub format: &'static str,
    /// Size of the file.
    pub bytes: usize,
    /// What the file says.
    pub holds: ContentsBody,
    /// The surface after conditioning; none if it is refused.
    pub surface: Option<SurfaceBody>,
    /// Why the surface is refused.
    pub problem: Option<ProblemBody>,
    /// Troubles with what is there, as in reports.
    pub warnings: Vec<WarningBody>,
}

/// What a file says, before anything is repaired.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContentsBody {
    /// Names of the objects; empty for one without a name.
    pub objects: Vec<String>,
    /// Vertices, with the copies that a file makes for normals and texture coordinates.
    pub vertices: usize,
    /// Polygons.
    pub polygons: usize,
    /// Those with three corners.
    pub triangles: usize,
    /// Those with four.
    pub quads: usize,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Images of the materials.
    pub images: Vec<ImageBody>,
    /// Whether there are texture coordinates.
    pub uv: bool,
    /// Whether there are normals.
    pub normals: bool,
    /// Whether vertices have colours.
    pub vertex_colours: bool,
    /// Joints that move the vertices.
    pub joints: usize,
    /// Least and greatest coordinates, in model units; none if no vertex of a polygon is finite.
    pub bounding_box: Option<[[f64; 3]; 2]>,
}

/// An image of a material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageBody {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// How it is encoded.
    pub media_type: &'static str,
    /// Its size as it is stored.
    pub bytes: usize,
}

/// A surface after conditioning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceBody {
    /// Its numbers and what was repaired, as in reports.
    #[serde(flatten)]
    pub input: InputReportBody,
    /// Its area in model units.
    pub area: f64,
}

/// Reads a file and conditions its surface as a run with this spec would.
///
/// # Errors
/// The problem why the file cannot be read, or that the run was stopped.
pub fn inspect_file(ctx: &RunContext, input: &Input<'_>, spec: &RemeshSpec) -> Result<InspectionBody, Problem> {
    let format = input.format.or_else(|| Format::sniff(input.bytes));
    let format = format.ok_or_else(|| Problem::from(&ReadError::UnknownFormat))?;
    let model = ctx.stage(Stage::Read, |_| {
        read_model(input.bytes, Some(format), input.beside, &input.limits).map_err(|error| Problem::from(&error))
    })?;
    let holds = contents(&model);
    let Model { soup, mut warnings, .. } = model;
    let outcome =
        inspect(ctx, &soup, spec).map_err(|error| problem_of_fault(&error, Some(error.stage()), ctx.stopped()));
    if let (Err(problem), Some(_)) = (&outcome, ctx.stopped()) {
        return Err(problem.clone());
    }
    let (surface, problem) = match outcome {
        Ok(found) => {
            warnings.extend(found.warnings);
            (Some(SurfaceBody { input: (&found.input).into(), area: found.area }), None)
        }
        Err(problem) => (None, Some(problem.body(None))),
    };
    let warnings = warnings.iter().map(WarningBody::from).collect();
    Ok(InspectionBody { format: format.name(), bytes: input.bytes.len(), holds, surface, problem, warnings })
}

fn contents(model: &Model) -> ContentsBody {
    let Model { soup, scene, .. } = model;
    let of_degree = |degree: usize| soup.polygons().filter(|polygon| polygon.len() == degree).count();
    ContentsBody {
        objects: scene.objects.iter().map(|name| name.node.clone()).collect(),
        vertices: soup.positions.len(),
        polygons: soup.n_polygons(),
        triangles: of_degree(3),
        quads: of_degree(4),
        materials: soup.material_names.iter().filter(|name| !name.is_empty()).cloned().collect(),
        images: scene.looks.images.iter().map(described).collect(),
        uv: !soup.uv.is_empty(),
        normals: !soup.normals.is_empty(),
        vertex_colours: !soup.colours.is_empty(),
        joints: scene.skeleton.joints.len(),
        bounding_box: bounding_box(soup),
    }
}

fn described(image: &Image) -> ImageBody {
    ImageBody { name: image.name.clone(), media_type: image.encoding.media_type(), bytes: image.bytes.len() }
}

fn bounding_box(soup: &TriangleSoup) -> Option<[[f64; 3]; 2]> {
    let corners = soup.indices.iter().map(|&v| soup.positions[v as usize]).filter(|p| p.is_finite());
    let unset = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.fold(unset, |(low, high), p| (low.min(p), high.max(p)));
    low.is_finite().then(|| [low.to_array(), high.to_array()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::formats::{Alone, ReadLimits};

    fn inspected(text: &str) -> Result<InspectionBody, Problem> {
        let input = Input { bytes: text.as_bytes(), format: None, beside: &Alone, limits: ReadLimits::default() };
        inspect_file(&RunContext::silent(), &input, &RemeshSpec::default())
    }

    #[test]
    fn contents_and_repairs_are_told() {
        // A square that is folded over twice, with a vertex that nobody uses.
        let text =
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nusemtl paint\no sheet\nf 1/1 2/1 3/1 4/1\nf 1 2 3\n";
        let found = inspected(text).unwrap();
        let holds = &found.holds;
        assert_eq!((found.format, holds.vertices, holds.polygons, holds.triangles, holds.quads), ("OBJ", 5, 2, 1, 1));
        assert_eq!(
            (holds.objects.as_slice(), holds.materials.as_slice()),
            (&["sheet".to_owned()][..], &["paint".to_owned()][..])
        );
        assert!(holds.uv && !holds.normals && !holds.vertex_colours && holds.joints == 0);
        assert_eq!(holds.bounding_box, Some([[0.0; 3], [1.0, 1.0, 0.0]]));
        let surface = found.surface.unwrap();
        assert_eq!((surface.input.components, surface.input.boundaries, surface.input.genus), (1, 1, 0));
        assert!(surface.input.repairs.contains_key("unreferenced_vertices_dropped"));
        assert!((surface.area - 1.0).abs() < 1e-12 && found.problem.is_none());
    }

    #[test]
    fn what_is_refused_is_still_described() {
        let found = inspected("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
        assert_eq!((found.holds.triangles, found.surface), (1, None));
        assert!(found.problem.is_some_and(|problem| problem.type_.ends_with("mesh-rejected")));
        assert!(inspected("no mesh at all").is_err());
    }
}
