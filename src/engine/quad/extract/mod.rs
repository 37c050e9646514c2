//! Quads from an integer-grid map: the grid lines of the map are traced on the surface with exact arithmetic, also
//! through flipped triangles, and the graph that they draw is completed to a pure quad mesh of the same topology.
//!
//! The preimage of the integer lines is a graph embedded in the surface whatever the map folds: in each triangle the
//! map is affine. So nothing has to be guessed where triangles are flipped. A fold covers a grid point several times;
//! the copies are joined by arcs of displacement zero, and contracting these arcs undoes the fold
//! ([`crate::engine::quad::fill`]). In a map without folds all faces of the graph are quads at once. After Ebke, Bommes,
//! Campen, Kobbelt, "QEx: robust quad mesh extraction", 2013, with the embedded graph in the place of their port rules.

mod error;
mod exact_map;
mod extraction;
mod gates;
mod grid_graph;
mod nodes;
mod ports;
mod trace;
mod turns;

#[cfg(test)]
mod tests;

pub use error::ExtractError;
pub use extraction::{Extraction, ExtractionReport, extract_inner_quads, extract_quads};
