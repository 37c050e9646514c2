//! Discrete harmonic forms behind the door of all methods.

use crate::engine::field::{BranchSearch, Frames};
use crate::engine::mesh::Surface;
use crate::engine::methods::harmonic::conformal::conformal_extents;
use crate::engine::methods::harmonic::cut_graph::{OnCutGraph, on_cut_graph};
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::given::{SHAPE, read};
use crate::engine::methods::harmonic::report::{data_of, lies_on};
use crate::engine::methods::harmonic::solve::BoundaryValues;
use crate::engine::methods::harmonic::source::{Sourced, from_given, from_map};
use crate::engine::methods::harmonic::working::Working;
use crate::engine::methods::{
    BoundaryLines, Data, Level, MapProduct, Method, MethodError, Parameter, Parameters, Product, Range, Value,
};
use crate::engine::parameterize::{GridMap, measure_map, untangle};
use crate::engine::problem::{Problem, WorkingMesh};
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

const GRAPH: Parameter = Parameter {
    name: "graph",
    help: "The singularity graph; without one it is made from a smooth field. The report has the graph of every map in this form. \
           Of a model of several components, those without a meta-vertex get their own.",
    range: Range::Data(&SHAPE),
};
const NATURAL: &str = "natural";
const BOUNDARY: Parameter = Parameter {
    name: "boundary_values",
    help: "What the map does along the boundary, which lies on coordinate lines.",
    range: Range::Choice(&[
        (NATURAL, "Vertices move along the line as the harmonic map has them."),
        ("linear", "Values between the corners of meta-faces by length along the boundary."),
    ]),
};

const AIM: Parameter = Parameter {
    name: "aim",
    help: "What the integers of the graph are near to, where they are not given.",
    range: Range::Choice(&[
        ("lengths", "The lengths of the meta-edges."),
        (CONFORMAL, "The real numbers that make the map as conformal as the graph allows."),
    ]),
};
const CONFORMAL: &str = "conformal";
const MOST_SINGULARITIES: Parameter = Parameter {
    name: "most_singularities",
    help: "The field is made smoother until it has at most this many singularities, as far as that helps; 0 leaves it as it is.",
    range: Range::Whole { least: 0, most: 100_000, default: 0 },
};

/// Discrete harmonic forms on a singularity graph `[tong_2006]`.
#[derive(Clone, Copy, Debug)]
pub struct Harmonic;

impl Method for Harmonic {
    fn name(&self) -> &'static str {
        "harmonic"
    }

    fn summary(&self) -> &'static str {
        "Two harmonic functions that are continuous up to quarter turns across a singularity graph, whose integer contours \
         are the quads."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &[
            "a map on the triangles of the input (working_mesh): the graph is cut into them",
            "a free boundary (boundary)",
            "a given graph together with symmetry (symmetry)",
            "grow meta-edges along lines of curvature: those of its own graphs are separatrices of a smooth field",
            "put the saddles of a surface of genus 2 or more on the meta-vertex of homology generators alone",
            "poles, metrics other than the surface's, and the conformal continuity of the paper's appendix C",
            "promise a locally injective map: what stays folded is counted in the report and repaired around",
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[GRAPH, AIM, BOUNDARY, MOST_SINGULARITIES]
    }

    fn follows_strokes(&self) -> bool {
        true
    }

    fn level(&self) -> Level {
        Level::L0
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Refine, Stage::Field, Stage::Map, Stage::Round, Stage::Extract]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let map = propose(ctx, problem, parameters).map_err(|error| match error {
            HarmonicError::Cancelled(stop) => MethodError::Cancelled(stop),
            cause @ (HarmonicError::Given { .. } | HarmonicError::NoIntegers) if is_given(parameters) => {
                MethodError::Refused { cause: format!("params.graph: {cause}") }
            }
            other => MethodError::Nothing { cause: other.to_string(), map: None },
        })?;
        Ok(Product::Map(Box::new(map)))
    }
}

fn is_given(parameters: &Parameters) -> bool {
    *parameters.data(&GRAPH) != Data::None
}

/// A harmonic map before it is untangled.
struct Made {
    surface: Surface,
    grid: GridMap,
    is_held: Vec<bool>,
    singularities: Vec<Singularity>,
    /// Grid units per model unit.
    scale: f64,
    n_integers: usize,
    details: Data,
}

fn propose(ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<MapProduct, HarmonicError> {
    if problem.wishes.working_mesh == WorkingMesh::Input {
        return Err(HarmonicError::OnInput);
    }
    let working = ctx.stage(Stage::Refine, |ctx| Working::new(ctx, problem))?;
    let most = match parameters.get(&MOST_SINGULARITIES) {
        Value::Whole(n) if n > 0 => Some(n as usize),
        _ => None,
    };
    let made = match read(&parameters.data(&GRAPH)) {
        Ok(given) if lies_on(&given, problem) => {
            on_graph(ctx, problem, parameters, from_given(ctx, &working, problem, &given)?)?
        }
        _ => {
            let sourced = from_map(ctx, &working, problem, most);
            match sourced.and_then(|sourced| on_graph(ctx, problem, parameters, sourced)) {
                Err(HarmonicError::Cancelled(stop)) => return Err(stop.into()),
                Err(cause) => {
                    tracing::debug!(%cause, "no graph of separatrices");
                    let OnCutGraph { grid, is_held, singularities, scale, n_integers } =
                        on_cut_graph(ctx, &working, problem)?;
                    let surface = working.surface.clone();
                    Made { surface, grid, is_held, singularities, scale, n_integers, details: Data::None }
                }
                Ok(made) => made,
            }
        }
    };
    ctx.check()?;
    let Made { surface, mut grid, is_held, singularities, scale, n_integers, details } = made;
    let mesh = &surface.mesh;
    let frames = Frames::new(mesh);
    let before = measure_map(mesh, &frames, &grid, scale);
    let left = ctx.stage(Stage::Map, |ctx| untangle(ctx, mesh, &frames, &mut grid, &is_held, scale))?;
    let mut measures = measure_map(mesh, &frames, &grid, scale);
    measures.flipped = measures.flipped.max(left);
    tracing::debug!(flipped_before = before.flipped, flipped = measures.flipped, "harmonic map");
    Ok(MapProduct {
        surface,
        corner_of: working.corner_of,
        grid,
        boundary: BoundaryLines::OnGrid,
        scale,
        singularities,
        n_integers,
        measures,
        branch_search: BranchSearch::default(),
        curl_energy: None,
        rounding_energy: None,
        search_left_out: None,
        details,
    })
}

/// Integers for a graph, and its harmonic map.
fn on_graph(
    ctx: &RunContext,
    problem: &Problem,
    parameters: &Parameters,
    mut sourced: Sourced,
) -> Result<Made, HarmonicError> {
    let boundary = match parameters.get(&BOUNDARY) {
        Value::Choice(NATURAL) => BoundaryValues::Natural,
        _ => BoundaryValues::Linear,
    };
    let frames = Frames::new(&sourced.surface.mesh);
    if parameters.get(&AIM) == Value::Choice(CONFORMAL)
        && let Some(real) = conformal_extents(ctx, &sourced.on_mesh(&frames, boundary))?
    {
        sourced.graph.edges.iter_mut().zip(real).for_each(|(edge, real)| edge.real = real);
    }
    ctx.stage(Stage::Round, |ctx| sourced.find_integers(ctx, problem))?;
    let scale = (sourced.graph.quads()? / sourced.surface.mesh.total_area()).sqrt();
    let grid = ctx.stage(Stage::Map, |_| sourced.on_mesh(&frames, boundary).map())?;
    let Sourced { surface, graph, is_held, singularities, .. } = sourced;
    let details = data_of(&graph, &surface.mesh, &is_held, problem.edge_length);
    Ok(Made { surface, grid, is_held, singularities, scale, n_integers: graph.edges.len(), details })
}
