//! QuadCover behind the door of all methods.

use crate::engine::field::BranchOptions;
use crate::engine::methods::quad_cover::{QuadCoverError, QuadCoverMap, QuadCoverOptions, quad_cover};
use crate::engine::methods::{
    BoundaryLines, Data, Level, MapProduct, Method, MethodError, Parameter, Parameters, Product, Range, working_surface,
};
use crate::engine::problem::{Optimise, Problem};
use crate::engine::run::{RunContext, Stage};

/// Most triangles of a working mesh.
pub const MAX_FACES: usize = 1_000_000;
/// Most triangles of a working mesh on which branch points are searched for: a search of few evaluations finds little,
/// and every evaluation is a factorisation.
const MOST_FACES_SEARCHED: usize = 500_000;

const BRANCH_PRICE: Parameter = Parameter {
    name: "branch_price",
    help: "What a pair of branch points must save to be created (`optimise: balance`): the energy that a quarter of index \
           adds to the rounded map, per quad and relative to that of the field. 0.15 to 0.5 were measured; larger values \
           give fewer irregular vertices.",
    range: Range::Number { least: 0.0, most: 100.0, default: BranchOptions::PRICE },
};

/// Frame fields on a branched covering, integrated and rounded `[kaelberer_2007]`.
#[derive(Clone, Copy, Debug)]
pub struct QuadCover;

impl Method for QuadCover {
    fn name(&self) -> &'static str {
        "quadcover"
    }

    fn summary(&self) -> &'static str {
        "A smooth cross field along principal curvatures, integrated on a branched covering and rounded to an integer-grid \
         map, whose grid lines are the quads."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &[
            "move branch points onto features or the boundary, or off them (optimise)",
            "follow given matchings where the working mesh is a remesh (field, working_mesh)",
            "a free boundary together with symmetry (boundary, symmetry)",
            "promise a locally injective map: where the map folds, quads come from another method, and the level says so",
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[BRANCH_PRICE]
    }

    fn follows_strokes(&self) -> bool {
        true
    }

    fn follows_fields(&self) -> bool {
        true
    }

    fn level(&self) -> Level {
        Level::L0
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Refine, Stage::Field, Stage::Map, Stage::Round, Stage::Extract]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let working = ctx.stage(Stage::Refine, |ctx| working_surface(ctx, problem, MAX_FACES))?;
        let triangles = working.surface.mesh.n_faces();
        let price = parameters.number(&BRANCH_PRICE);
        let wanted = match problem.wishes.optimise {
            Optimise::None => None,
            Optimise::Relocate => Some(BranchOptions { create: false, price }),
            Optimise::Balance => Some(BranchOptions { create: true, price }),
        };
        let search_left_out = (wanted.is_some() && triangles >= MOST_FACES_SEARCHED).then_some(triangles);
        let options = QuadCoverOptions::of(problem, &working, wanted.filter(|_| search_left_out.is_none()));
        let map = quad_cover(ctx, &working.surface, &options).map_err(|error| match error {
            QuadCoverError::Cancelled(stop) => MethodError::Cancelled(stop),
            other => MethodError::Nothing { cause: other.to_string(), map: None },
        })?;
        let QuadCoverMap { grid, scale, field, n_integers, measures, branch_search, curl_energy, rounding_energy } =
            map;
        Ok(Product::Map(Box::new(MapProduct {
            surface: working.surface,
            corner_of: working.corner_of,
            grid,
            boundary: if options.boundary_free { BoundaryLines::Free } else { BoundaryLines::OnGrid },
            scale,
            singularities: field.singularities(),
            n_integers,
            measures,
            branch_search,
            curl_energy: Some(curl_energy),
            rounding_energy: Some(rounding_energy),
            search_left_out,
            details: Data::None,
        })))
    }
}
