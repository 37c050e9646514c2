//! A picture of a quad mesh, drawn on the CPU: shaded quads, crisp edges, irregular vertices as discs by valence.
//!
//! Deterministic, and good-natured: whatever cannot be drawn (indices out of range, positions that are not finite) is
//! left out, because a picture of a bad mesh is wanted most.

mod camera;
mod compose;
mod light;
mod raster;
mod scene;
#[cfg(test)]
mod tests;

pub use camera::View;
pub use compose::{Image, RenderOptions, render_quads};
