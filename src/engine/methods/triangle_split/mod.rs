//! Every triangle of a coarse remesh split into three quads. Needs nothing but a valid surface.

use crate::engine::mesh::{NONE, Surface};
use crate::engine::methods::coarse::{FIDELITY, coarse_quads};
use crate::engine::methods::subdivide::Polygon;
use crate::engine::methods::{Level, Method, MethodError, Parameter, Parameters, Product};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};

/// Quads of a triangle.
const QUADS_PER_TRIANGLE: f64 = 3.0;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct TriangleSplit;

/// The triangles as they are.
fn triangles(surface: &Surface) -> Vec<Polygon> {
    surface.mesh.faces().iter().map(|&[a, b, c]| [a, b, c, NONE]).collect()
}

impl Method for TriangleSplit {
    fn name(&self) -> &'static str {
        "triangle-split"
    }

    fn summary(&self) -> &'static str {
        "An isotropic remesh of which every triangle is split into three quads: the surest, and the least regular."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &[
            "follow curvature, strokes, or sizes above the edge length",
            "give a parameterisation",
            "give vertices of valence 4 but by chance",
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[FIDELITY]
    }

    fn level(&self) -> Level {
        Level::L4
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Fallback]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let quads = ctx.stage(Stage::Fallback, |ctx| {
            coarse_quads(ctx, problem, parameters, QUADS_PER_TRIANGLE, |_, surface| Ok(triangles(surface)))
        })?;
        Ok(Product::Quads(quads))
    }
}
