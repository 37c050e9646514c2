//! The spec of a request (contract.md, section 3): JSON in, a validated [`RemeshSpec`] or all violations out.

use std::collections::BTreeSet;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::engine::pipeline::{
    Align, Boundary, FeatureSpec, Method, Optimise, Preserve, RemeshSpec, Target, WorkingMesh,
};
use crate::service::wire::fields::Fields;
use crate::service::wire::spec_types::{
    AlignName, AttributeName, BoundaryName, FeaturesBody, MethodName, NonOrientable, OptimiseName, OutputName,
    SymmetryAxis, TargetBody, WorkingMeshName,
};
use crate::service::wire::{Problem, ProblemKind, Violation};

/// Most quads that may be asked for.
const MAX_QUADS: u64 = 10_000_000;
/// Longest deadline in seconds.
const MAX_DEADLINE_S: f64 = 86_400.0;
const MAX_FEATURE_EDGES: usize = 1_000_000;
const MAX_STROKE_POINTS: usize = 100_000;
const MAX_TAGS: usize = 16;
const MAX_TAG_LENGTH: usize = 64;

/// What a client may ask for. Every field may be left out; the defaults are filled in, and the job shows the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RemeshRequest {
    /// Which system runs.
    pub method: MethodName,
    /// The density: `{"quads": N}` or `{"edge_length": L}`.
    pub target: TargetBody,
    /// Iterate the scale until the count is within 5 % of the target (10 % below 500 quads).
    pub adapt_count: bool,
    /// Curvature-adaptive quad size, 0 to 100: edges from a quarter to four times as long; 0 is uniform.
    pub adaptive_size: f64,
    /// Whether vertex colours scale the density: 0.25× at black, 1× at middle grey, 4× at white, by the mean of red, green
    /// and blue. The count stays the one asked for.
    pub density_from_vertex_colour: bool,
    /// What must come out as quad edges.
    pub features: FeaturesBody,
    /// What becomes of boundary loops.
    pub boundary: BoundaryName,
    /// Guidance of the cross field.
    pub align: AlignName,
    /// λ between curvature alignment (0) and smoothness (1).
    pub smoothing: f64,
    /// Directions to follow, polylines in model units, on the surface or near it.
    pub strokes: Vec<Vec<[f64; 3]>>,
    /// What is done about branch points: as found; moved to where the field has least curl; also created and cancelled
    /// where that saves more than it costs in rounding.
    pub optimise: OptimiseName,
    /// Exact mirror symmetry of the result: the side of larger coordinates is solved and mirrored. Models that are further
    /// from their mirror image than 5 % of their diagonal are refused.
    pub symmetry: Vec<SymmetryAxis>,
    /// Pure or quad-dominant; this version makes pure quads only.
    pub output: OutputName,
    /// May the parameterisation live on a remeshed copy of the input?
    pub working_mesh: WorkingMeshName,
    /// Attributes carried to the quads where the input has them. Names of objects are always carried.
    pub preserve: Vec<AttributeName>,
    /// What is done with surfaces that have no consistent orientation (an extension of the contract).
    pub non_orientable: NonOrientable,
    /// Seed of every random choice.
    pub seed: u64,
    /// Seconds of run time, then the best certified result so far, or failure.
    pub deadline_s: f64,
    /// At most 16 labels of 1 to 64 characters, for listing.
    pub tags: Vec<String>,
    /// −100 to 100; higher runs earlier.
    pub priority: i32,
    /// Not available in this version.
    pub webhook: Option<String>,
}

impl Default for RemeshRequest {
    fn default() -> Self {
        Self {
            method: MethodName::default(),
            target: TargetBody::default(),
            adapt_count: true,
            adaptive_size: 0.0,
            density_from_vertex_colour: false,
            features: FeaturesBody::default(),
            boundary: BoundaryName::default(),
            align: AlignName::default(),
            smoothing: 0.5,
            strokes: Vec::new(),
            optimise: OptimiseName::default(),
            symmetry: Vec::new(),
            output: OutputName::default(),
            working_mesh: WorkingMeshName::default(),
            preserve: [AttributeName::Materials, AttributeName::VertexColours, AttributeName::Uv, AttributeName::Skin]
                .to_vec(),
            non_orientable: NonOrientable::default(),
            seed: 0,
            deadline_s: 300.0,
            tags: Vec::new(),
            priority: 0,
            webhook: None,
        }
    }
}

/// How the job is handled, apart from the geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct JobOptions {
    /// Seconds of run time, positive.
    pub deadline_s: f64,
    /// Labels for listing.
    pub tags: Vec<String>,
    /// −100 to 100; higher runs earlier.
    pub priority: i32,
}

/// A request that was found valid.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedSpec {
    /// The request with all defaults filled in: serialise this into the job object.
    pub request: RemeshRequest,
    /// What the engine is asked for.
    pub spec: RemeshSpec,
    /// How the job is handled.
    pub options: JobOptions,
}

impl Default for ResolvedSpec {
    fn default() -> Self {
        let request = RemeshRequest::default();
        Self { spec: request.engine_spec(), options: request.job_options(), request }
    }
}

impl ResolvedSpec {
    /// Reads and judges a spec; on failure all violations, with JSON pointers into `value`.
    pub fn from_value(value: Value) -> Result<Self, Vec<Violation>> {
        let mut violations = Vec::new();
        let request = RemeshRequest::read(value, &mut violations);
        request.judge(&mut violations);
        if violations.is_empty() {
            Ok(Self { spec: request.engine_spec(), options: request.job_options(), request })
        } else {
            Err(violations)
        }
    }

    /// The same from the bytes of a JSON document; the problem is `invalid-spec`. Empty bytes mean all defaults.
    pub fn from_json(bytes: &[u8]) -> Result<Self, Problem> {
        let value = if bytes.iter().all(u8::is_ascii_whitespace) {
            Value::Null
        } else {
            serde_json::from_slice(bytes)
                .map_err(|error| Problem::invalid_spec(vec![Violation::new("", format!("not JSON: {error}"))]))?
        };
        Self::from_value(value).map_err(Problem::invalid_spec)
    }
}

impl RemeshRequest {
    /// Reads every field that can be read, and notes the others.
    fn read(value: Value, violations: &mut Vec<Violation>) -> Self {
        let mut request = Self::default();
        let mut fields = Fields::of(value, "", violations);
        fields.read("method", &mut request.method);
        fields.read("target", &mut request.target);
        fields.read("adapt_count", &mut request.adapt_count);
        fields.read("adaptive_size", &mut request.adaptive_size);
        fields.read("density_from_vertex_colour", &mut request.density_from_vertex_colour);
        let features = fields.raw("features");
        fields.read("boundary", &mut request.boundary);
        fields.read("align", &mut request.align);
        fields.read("smoothing", &mut request.smoothing);
        fields.read("strokes", &mut request.strokes);
        fields.read("optimise", &mut request.optimise);
        fields.read("symmetry", &mut request.symmetry);
        fields.read("output", &mut request.output);
        fields.read("working_mesh", &mut request.working_mesh);
        fields.read("preserve", &mut request.preserve);
        fields.read("non_orientable", &mut request.non_orientable);
        fields.read("seed", &mut request.seed);
        fields.read("deadline_s", &mut request.deadline_s);
        fields.read("tags", &mut request.tags);
        fields.read("priority", &mut request.priority);
        fields.read("webhook", &mut request.webhook);
        fields.finish();

        let mut fields = Fields::of(features.unwrap_or(Value::Null), "/features", violations);
        fields.read("angle", &mut request.features.angle);
        fields.read("normals", &mut request.features.normals);
        fields.read("materials", &mut request.features.materials);
        fields.read("edges", &mut request.features.edges);
        fields.finish();
        request
    }

    /// Ranges, and everything that this version cannot do: refused, never silently ignored.
    fn judge(&self, violations: &mut Vec<Violation>) {
        let mut refuse = |wrong: bool, pointer: &str, message: String| {
            if wrong {
                violations.push(Violation::new(pointer, message));
            }
        };
        let unavailable = |what: &str| format!("{what} not available in this version");
        let method = format!("{} is not available in this version; use quadcover", self.method.name());
        refuse(self.method != MethodName::Quadcover, "/method", method);
        match self.target {
            TargetBody::Quads(n) => {
                let message = format!("must be from 1 to {MAX_QUADS}, not {n}");
                refuse(n == 0 || n > MAX_QUADS, "/target/quads", message);
            }
            TargetBody::EdgeLength(length) => {
                let message = format!("must be a positive length in model units, not {length}");
                refuse(!(length.is_finite() && length > 0.0), "/target/edge_length", message);
            }
        }
        let message = format!("must be from 0 to 100, not {}", self.adaptive_size);
        refuse(!(0.0..=100.0).contains(&self.adaptive_size), "/adaptive_size", message);

        let angle = self.features.angle;
        let message = format!("must be from 0 to 180 degrees, not {angle}");
        refuse(!(0.0..=180.0).contains(&angle), "/features/angle", message);
        let n_edges = self.features.edges.len();
        let message = format!("at most {MAX_FEATURE_EDGES} edges, not {n_edges}");
        refuse(n_edges > MAX_FEATURE_EDGES, "/features/edges", message);

        let message = format!("must be from 0 to 1, not {}", self.smoothing);
        refuse(!(0.0..=1.0).contains(&self.smoothing), "/smoothing", message);
        let n_points: usize = self.strokes.iter().map(Vec::len).sum();
        refuse(n_points > MAX_STROKE_POINTS, "/strokes", format!("at most {MAX_STROKE_POINTS} points, not {n_points}"));
        for (i, stroke) in self.strokes.iter().enumerate() {
            let is_line = stroke.len() >= 2 && stroke.iter().flatten().all(|x| x.is_finite());
            refuse(
                !is_line,
                &format!("/strokes/{i}"),
                "a stroke has at least two points with finite coordinates".into(),
            );
        }
        // The half of a symmetric surface is cut open along the plane, and must follow the cut.
        let both = "cannot be free together with symmetry; leave one of them out".to_owned();
        refuse(self.boundary == BoundaryName::Free && !self.symmetry.is_empty(), "/boundary", both);
        let dominant = unavailable("quad-dominant output is");
        refuse(self.output != OutputName::Pure, "/output", dominant);
        let message = format!("must be above 0 and at most {MAX_DEADLINE_S} seconds, not {}", self.deadline_s);
        refuse(!(self.deadline_s > 0.0 && self.deadline_s <= MAX_DEADLINE_S), "/deadline_s", message);
        refuse(self.tags.len() > MAX_TAGS, "/tags", format!("at most {MAX_TAGS} tags, not {}", self.tags.len()));
        for (i, tag) in self.tags.iter().enumerate() {
            let length = tag.chars().count();
            let message = format!("a tag has 1 to {MAX_TAG_LENGTH} characters, not {length}");
            refuse(length == 0 || length > MAX_TAG_LENGTH, &format!("/tags/{i}"), message);
        }
        let message = format!("must be from -100 to 100, not {}", self.priority);
        refuse(!(-100..=100).contains(&self.priority), "/priority", message);
        let webhook = format!("{}; follow /v1/jobs/{{id}}/events instead", unavailable("webhooks are"));
        refuse(self.webhook.is_some(), "/webhook", webhook);
    }

    /// The engine's view; only meaningful for a request that was judged.
    fn engine_spec(&self) -> RemeshSpec {
        RemeshSpec {
            method: Method::QuadCover,
            target: match self.target {
                TargetBody::Quads(n) => Target::Quads(n),
                TargetBody::EdgeLength(length) => Target::EdgeLength(length),
            },
            adapt_count: self.adapt_count,
            adaptive_size: self.adaptive_size,
            density_from_vertex_colour: self.density_from_vertex_colour,
            features: FeatureSpec {
                angle_degrees: self.features.angle,
                materials: self.features.materials,
                normals: self.features.normals,
                edges: self.features.edges.clone(),
            },
            boundary: match self.boundary {
                BoundaryName::Align => Boundary::Align,
                BoundaryName::Free => Boundary::Free,
            },
            align: match self.align {
                AlignName::Curvature => Align::Curvature,
                AlignName::Smooth => Align::Smooth,
            },
            smoothing: self.smoothing,
            strokes: self.strokes.iter().map(|line| line.iter().copied().map(DVec3::from_array).collect()).collect(),
            optimise: match self.optimise {
                OptimiseName::None => Optimise::None,
                OptimiseName::Relocate => Optimise::Relocate,
                OptimiseName::Balance => Optimise::Balance,
            },
            symmetry: self.symmetry.iter().map(|&axis| axis as usize).collect::<BTreeSet<_>>().into_iter().collect(),
            working_mesh: match self.working_mesh {
                WorkingMeshName::Auto => WorkingMesh::Auto,
                WorkingMeshName::Input => WorkingMesh::Input,
            },
            preserve: Preserve {
                materials: self.preserve.contains(&AttributeName::Materials),
                vertex_colours: self.preserve.contains(&AttributeName::VertexColours),
                uv: self.preserve.contains(&AttributeName::Uv),
                skin: self.preserve.contains(&AttributeName::Skin),
            },
            cut_non_orientable: self.non_orientable == NonOrientable::Cut,
            seed: self.seed,
        }
    }

    fn job_options(&self) -> JobOptions {
        JobOptions { deadline_s: self.deadline_s, tags: self.tags.clone(), priority: self.priority }
    }
}

impl Problem {
    /// The problem that a spec with these violations gets.
    pub fn invalid_spec(violations: Vec<Violation>) -> Self {
        let detail = match violations.as_slice() {
            [only] => format!("{}: {}", if only.pointer.is_empty() { "spec" } else { &only.pointer }, only.message),
            many => format!("{} fields of the spec cannot be used; see errors", many.len()),
        };
        Problem { errors: violations, ..Problem::new(ProblemKind::InvalidSpec, detail) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn pointers(value: Value) -> Vec<String> {
        ResolvedSpec::from_value(value).expect_err("must be refused").into_iter().map(|v| v.pointer).collect()
    }

    #[test]
    fn an_empty_spec_is_the_engines_default() {
        for bytes in ["", "{}", "null"] {
            let resolved = ResolvedSpec::from_json(bytes.as_bytes()).unwrap();
            assert_eq!(resolved.spec, RemeshSpec::default());
            assert_eq!(resolved, ResolvedSpec::default());
        }
    }

    #[test]
    fn all_violations_are_reported_at_once() {
        let spec = json!({
            "target": {"quads": 0}, "smoothing": 2, "colour": 1, "features": {"angle": -1, "corner": true},
            "seed": "x", "tags": [""], "method": "harmonic", "symmetry": ["w"], "strokes": [[[0, 0, 0]]]
        });
        let mut found = pointers(spec);
        found.sort();
        let expected = [
            "/colour",
            "/features/angle",
            "/features/corner",
            "/method",
            "/seed",
            "/smoothing",
            "/strokes/0",
            "/symmetry",
            "/tags/0",
            "/target/quads",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn what_this_version_cannot_do_is_refused_by_name() {
        let cases =
            [("output", json!("dominant")), ("webhook", json!("http://127.0.0.1/")), ("method", json!("layout"))];
        for (field, value) in cases {
            let violations = ResolvedSpec::from_value(json!({ field: value })).unwrap_err();
            assert_eq!(violations.len(), 1);
            assert_eq!(violations[0].pointer, format!("/{field}"));
            assert!(violations[0].message.contains("not available in this version"), "{}", violations[0].message);
        }
    }

    #[test]
    fn sizes_strokes_and_symmetry_reach_the_engine() {
        let strokes = json!([[[0, 0, 0], [1, 0, 0.5]]]);
        let spec = json!({"adaptive_size": 40, "density_from_vertex_colour": true, "strokes": strokes});
        let spec = ResolvedSpec::from_value(spec).unwrap().spec;
        assert_eq!((spec.adaptive_size, spec.density_from_vertex_colour), (40.0, true));
        assert_eq!(spec.strokes, [[DVec3::ZERO, DVec3::new(1.0, 0.0, 0.5)]]);
        let spec = ResolvedSpec::from_value(json!({"symmetry": ["z", "x", "z"]})).unwrap().spec;
        assert_eq!(spec.symmetry, [0, 2]);
        for size in [-1.0, 100.5] {
            assert_eq!(pointers(json!({ "adaptive_size": size })), ["/adaptive_size"]);
        }
    }

    #[test]
    fn a_free_boundary_cannot_be_a_cut_of_symmetry() {
        let spec = ResolvedSpec::from_value(json!({"boundary": "free"})).unwrap().spec;
        assert_eq!(spec.boundary, Boundary::Free);
        assert_eq!(pointers(json!({"boundary": "free", "symmetry": ["x"]})), ["/boundary"]);
    }

    #[test]
    fn every_attribute_is_carried_unless_some_are_named() {
        let preserve = |spec: Value| ResolvedSpec::from_value(spec).unwrap().spec.preserve;
        let (none, all) =
            (Preserve { materials: false, vertex_colours: false, uv: false, skin: false }, Preserve::default());
        assert_eq!(preserve(json!({})), all);
        assert_eq!(preserve(json!({"preserve": ["uv", "skin", "materials", "vertex_colours", "uv"]})), all);
        assert_eq!(preserve(json!({"preserve": []})), none);
        assert_eq!(preserve(json!({"preserve": ["vertex_colours"]})), Preserve { vertex_colours: true, ..none });
    }

    #[test]
    fn absurd_targets_are_refused() {
        for target in [json!({"quads": 0}), json!({"quads": 1_000_000_000}), json!({"quads": -1}), json!(7)] {
            assert_eq!(pointers(json!({ "target": target })).len(), 1, "{target}");
        }
        for length in [0.0, -1.0] {
            assert_eq!(pointers(json!({"target": {"edge_length": length}})), ["/target/edge_length"]);
        }
    }

    #[test]
    fn the_filled_in_spec_resolves_to_itself() {
        let spec = json!({"target": {"edge_length": 0.5}, "features": {"edges": [[0, 1]]}, "tags": ["a"], "seed": 7});
        let first = ResolvedSpec::from_value(spec).unwrap();
        let written = serde_json::to_value(&first.request).unwrap();
        assert_eq!(ResolvedSpec::from_value(written).unwrap(), first);
        assert_eq!(first.spec.target, Target::EdgeLength(0.5));
    }
}
