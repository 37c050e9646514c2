//! Holomorphic quadratic differentials behind the door of all methods.

use std::collections::BTreeMap;

use crate::engine::field::BranchSearch;
use crate::engine::mesh::{Features, Surface, working_mesh};
use crate::engine::methods::holomorphic::curves::CurveSystem;
use crate::engine::methods::holomorphic::error::HolomorphicError;
use crate::engine::methods::holomorphic::{Options, quadratic_differential_map};
use crate::engine::methods::{
    BoundaryLines, Data, Level, MapProduct, Method, MethodError, Parameter, Parameters, Product, Range, Value,
};
use crate::engine::problem::{Problem, WorkingMesh};
use crate::engine::run::{RunContext, Stage};

const CURVES: Parameter = Parameter {
    name: "curves",
    help: "The curves that the closed leaves of the foliation run along, all with the same height: as many as there can be, one \
           per handle, or one alone.",
    range: Range::Choice(&[
        ("pants", "3 g − 3 disjoint loops that cut the surface into pairs of pants; one on a torus."),
        ("handles", "One shortest loop per handle, disjoint, that together cut the surface to genus 0."),
        ("single", "The shortest of these loops alone: handles that it does not go through get few quads or none."),
    ]),
};

const SEED: Parameter = Parameter {
    name: "seed",
    help: "Where the search for curves begins: other numbers may give other curves.",
    range: Range::Whole { least: 0, most: 1000, default: 0 },
};

/// Longest triangle edge relative to a quad edge, as for quadcover.
const LONGEST_EDGE: f64 = 0.75;
/// Most triangles of a working mesh.
const MAX_FACES: usize = 1_000_000;

/// Conformal maps from holomorphic quadratic differentials `[zhao_2020]`.
#[derive(Clone, Copy, Debug)]
pub struct Holomorphic;

impl Method for Holomorphic {
    fn name(&self) -> &'static str {
        "holomorphic"
    }

    fn summary(&self) -> &'static str {
        "The holomorphic quadratic differential of a system of closed curves, for closed surfaces with handles: a conformal \
         map with 4 g − 4 irregular vertices of valence 6, whose grid lines are the quads."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &[
            "surfaces of genus 0, which have no such differential, and surfaces with a boundary",
            "curves and heights of the user: systems are found automatically, and all heights are the same",
            "tell handle loops from tunnel loops",
            "follow sharp edges, strokes or sizes: the map is conformal, and quads are as large as that makes them",
            "keep zeros apart that are less than half a quad from each other: they become one vertex of valence 8",
            "the paper's diffusion by Whitehead moves, intrinsic triangulations, and a map without quads",
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[CURVES, SEED]
    }

    fn level(&self) -> Level {
        Level::L0
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Refine, Stage::Field, Stage::Map, Stage::Round, Stage::Extract]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let nothing = |error: HolomorphicError| match error {
            HolomorphicError::Cancelled(stop) => MethodError::Cancelled(stop),
            other => MethodError::Nothing { cause: other.to_string(), map: None },
        };
        let topology = problem.surface.mesh.topology();
        if topology.boundaries > 0 {
            return Err(nothing(HolomorphicError::Boundary));
        }
        if topology.genus == 0 {
            return Err(nothing(HolomorphicError::GenusZero));
        }
        let plain = |mesh| Surface { mesh, features: Features::default() };
        let surface = ctx.stage(Stage::Refine, |ctx| match problem.wishes.working_mesh {
            WorkingMesh::Input => Ok(plain(problem.surface.mesh.clone())),
            WorkingMesh::Auto => {
                let surface = Surface { features: Features::default(), ..problem.surface.in_canonical_order() };
                working_mesh(ctx, &surface, LONGEST_EDGE * problem.edge_length, None, MAX_FACES)
            }
        })?;
        let system = match parameters.get(&CURVES) {
            Value::Choice("single") => CurveSystem::Single,
            Value::Choice("handles") => CurveSystem::Handles,
            _ => CurveSystem::Pants,
        };
        let seed = parameters.number(&SEED) as usize;
        let options = Options { system, seed, edge_length: problem.edge_length, quads: problem.quads };
        let map = quadratic_differential_map(ctx, &surface.mesh, &options).map_err(nothing)?;
        Ok(Product::Map(Box::new(MapProduct {
            surface,
            corner_of: BTreeMap::new(),
            grid: map.grid,
            boundary: BoundaryLines::OnGrid,
            scale: map.scale,
            singularities: map.singularities,
            n_integers: map.n_integers,
            measures: map.measures,
            branch_search: BranchSearch::default(),
            curl_energy: Some(map.curl_energy),
            rounding_energy: Some(map.rounding_energy),
            search_left_out: None,
            details: Data::None,
        })))
    }
}
