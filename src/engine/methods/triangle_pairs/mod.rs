//! Pairs of triangles: a coarse isotropic remesh, its triangles joined in pairs, and one subdivision. Even in size, without
//! a field: irregular, but sure.

mod matching;
mod pair;
#[cfg(test)]
mod tests;

use crate::engine::methods::coarse::{FIDELITY, coarse_quads};
use crate::engine::methods::{Level, Method, MethodError, Parameter, Parameters, Product};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};

/// Two triangles make a polygon, a polygon makes four quads.
const QUADS_PER_TRIANGLE: f64 = 2.0;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePairs;

impl Method for TrianglePairs {
    fn name(&self) -> &'static str {
        "triangle-pairs"
    }

    fn summary(&self) -> &'static str {
        "An isotropic remesh whose triangles are joined in pairs and subdivided once: fast and sure, but irregular."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &["follow curvature, strokes, or sizes above the edge length", "give a parameterisation"]
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[FIDELITY]
    }

    fn level(&self) -> Level {
        Level::L3
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Fallback]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let quads = ctx.stage(Stage::Fallback, |ctx| {
            coarse_quads(ctx, problem, parameters, QUADS_PER_TRIANGLE, pair::pair_triangles)
        })?;
        Ok(Product::Quads(quads))
    }
}
