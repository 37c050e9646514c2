//! THE table of the spec's fields. Reading, JSON Schema, `/v1/methods`, the flags of the command line and the README
//! follow from it: a new field is one row here, and its use in the engine.

use crate::engine::pipeline::{Align, Boundary, Effort, NonOrientable, Optimise, WorkingMesh};
use crate::service::wire::LevelName;
use crate::service::wire::spec::field::{Field, Flag, Group, Kind, field};
use crate::service::wire::spec::given_field::Given;
use crate::service::wire::spec::kinds::{Maybe, Number, Switch, Whole};
use crate::service::wire::spec::lists::{Edges, Labels, Strokes};
use crate::service::wire::spec::method::{OneMethod, PARAMETERS};
use crate::service::wire::spec::mirrors::Mirrors;
use crate::service::wire::spec::names::{Attribute, Output};
use crate::service::wire::spec::one_of::{one_of, some_of};
use crate::service::wire::spec::target::Density;

/// Objects of fields; the fields of one stand together in the table.
pub(super) static GROUPS: &[Group] = &[
    Group {
        name: "features",
        component: "FeaturesBody",
        summary_component: "FeaturesSummary",
        help: "What must come out as quad edges.",
    },
    Group {
        name: "accept",
        component: "AcceptBody",
        summary_component: "AcceptSummary",
        help: "What the result must reach; one that misses is the problem `not-acceptable`.",
    },
];

/// Names that are refused as not available in this version, with what to do instead.
pub(super) static LATER: &[(&str, &str)] = &[("webhook", "follow /v1/jobs/{id}/events instead")];

/// Every field of the spec.
pub(in crate::service) static FIELDS: &[Field] = &[
    // name, place, values, flags, help
    field!("method", spec.method, OneMethod, [Flag::new("method", "NAME")], "Which system runs."),
    PARAMETERS,
    field!(
        "target",
        spec.target,
        Density,
        [
            Flag::member("target-quads", "N", "quads", "Quads of the whole model, 1 to 10000000"),
            Flag::member("edge-length", "L", "edge_length", "Edge length of the quads in model units"),
        ],
        "The density: quads of the whole model, or their edge length in model units."
    ),
    field!(
        "adapt_count",
        spec.adapt_count,
        Switch,
        [Flag::new("adapt-count", "BOOL")],
        "Whether the scale is iterated until the count is within 5 % of the target, 10 % below 500 quads."
    ),
    field!(
        "adaptive_size",
        spec.adaptive_size,
        Number::within(0.0, 100.0),
        [Flag::new("adaptive-size", "PERCENT")],
        "How far the size of quads follows curvature: edges from a quarter to four times as long; 0 is uniform."
    ),
    field!(
        "density_from_vertex_colour",
        spec.density_from_vertex_colour,
        Switch,
        [Flag::new("density-from-vertex-colour", "BOOL")],
        "Whether vertex colours scale the density: × 1/4 at black, 1 at middle grey, 4 at white; the count stays."
    ),
    field!(
        "features.angle",
        spec.features.angle_degrees,
        Number::within(0.0, 180.0),
        [Flag::new("feature-angle", "DEGREES")],
        "Dihedral angle in degrees from which an edge is sharp; 180 is none."
    ),
    field!(
        "features.normals",
        spec.features.normals,
        Switch,
        [Flag::new("feature-normals", "BOOL")],
        "Whether edges are sharp where the normals of an OBJ or glTF are split, unless every facet has its own."
    ),
    field!(
        "features.materials",
        spec.features.materials,
        Switch,
        [Flag::new("feature-materials", "BOOL")],
        "Whether borders between materials are features."
    ),
    field!(
        "features.edges",
        spec.features.edges,
        Edges,
        [],
        "Explicit feature edges, pairs of vertices of the input, from 0."
    ),
    field!(
        "boundary",
        spec.boundary,
        one_of::<Boundary>(),
        [Flag::new("boundary", "HOW")],
        "What becomes of boundary loops."
    ),
    field!("align", spec.align, one_of::<Align>(), [Flag::new("align", "WHICH")], "Guidance of the cross field."),
    field!(
        "smoothing",
        spec.smoothing,
        Number::within(0.0, 1.0),
        [Flag::new("smoothing", "LAMBDA")],
        "λ between alignment with curvature (0) and smoothness (1)."
    ),
    field!("strokes", spec.strokes, Strokes, [], "Directions to follow, in model units, on the surface or near it."),
    field!(
        "field",
        spec.field,
        Given,
        [Flag::new("field", "FILE")],
        "A field to follow instead of one from curvature, per polygon of the input; see docs/fields.md."
    ),
    field!(
        "optimise",
        spec.optimise,
        one_of::<Optimise>(),
        [Flag::new("optimise", "HOW")],
        "What is done about branch points."
    ),
    field!(
        "symmetry",
        spec.symmetry,
        Mirrors,
        [Flag::new("symmetry", "AXES")],
        "The quads are their own mirror image, bit for bit: the side of larger coordinates is solved. Models further than \
         5 % of their diagonal from their image are refused."
    ),
    field!("output", output, one_of::<Output>(), [Flag::new("output", "KIND")], "Kind of the resulting mesh."),
    field!(
        "working_mesh",
        spec.working_mesh,
        one_of::<WorkingMesh>(),
        [Flag::new("working-mesh", "WHICH")],
        "What the parameterisation lives on."
    ),
    field!(
        "preserve",
        spec.preserve,
        some_of::<Attribute>(),
        [Flag::new("preserve", "NAMES")],
        "What the quads carry of the input, where it has it. Names of objects are always carried."
    ),
    field!(
        "non_orientable",
        spec.non_orientable,
        one_of::<NonOrientable>(),
        [Flag::new("non-orientable", "HOW")],
        "What is done with surfaces that have only one side."
    ),
    field!(
        "seed",
        spec.seed,
        Whole { low: 0, high: u64::MAX },
        [Flag::new("seed", "N")],
        "Seed of every random choice."
    ),
    field!(
        "effort",
        spec.effort,
        one_of::<Effort>(),
        [Flag::new("effort", "WHICH")],
        "How much work may be spent where a first attempt is not good enough."
    ),
    field!(
        "deadline_s",
        options.deadline_s,
        Number::above_to(0.0, 86_400.0),
        [Flag::new("deadline", "SECONDS")],
        "Seconds of run time, then the best certified result so far, or failure."
    ),
    field!(
        "accept.level",
        accept.level,
        Maybe(one_of::<LevelName>()),
        [Flag::new("accept-level", "LEVEL")],
        "The highest level that is accepted."
    ),
    field!(
        "accept.count",
        accept.count,
        Maybe(Number::from(0.0)),
        [Flag::new("accept-count", "SHARE")],
        "How far the number of quads may be from the target, as a share of it; 0.1 is 10 %."
    ),
    field!(
        "accept.distance",
        accept.distance,
        Maybe(Number::within(0.0, 1.0)),
        [Flag::new("accept-distance", "SHARE")],
        "How far quads and surface may be from each other, as a share of the diagonal of the bounding box."
    ),
    field!("tags", options.tags, Labels, [], "Labels for listing jobs."),
    field!("priority", options.priority, Whole { low: -100, high: 100 }, [], "Jobs of higher priority run earlier."),
];
