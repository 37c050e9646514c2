//! Built-in sample surfaces for the demo, for benchmarks and for tests: every one an oriented 2-manifold by
//! construction, at any resolution, deterministic.

mod cad;
mod catalogue;
mod implicit;
mod parametric;
mod patches;

pub use catalogue::{DEFAULT_SHAPE, SHAPES, ShapeInfo, sample, sample_mesh, sample_surface};
