//! From a graph embedded in a surface to a pure quad mesh of the same topology.
//!
//! A graph that cuts a surface into disks is known up to homeomorphism by the cyclic order of its arcs around each
//! node (`EmbeddedGraph`). Every step here (contract an arc, delete an arc between two different faces, split an arc,
//! draw arcs inside a face) keeps the surface, so the result has the right topology by construction, whatever the
//! graph looked like. Steps: undo folds, remove what bounds nothing, make all faces even by chains of split arcs
//! between odd faces, fill even faces with patterns of quads, split arcs across closed curves until no two arcs join the
//! same two nodes.

mod boundary_strip;
mod boundary_strip_places;
mod chains;
mod complete;
mod dual_curve;
mod embedded_graph;
mod faces;
mod parity;
mod patterns;
mod polygons;
mod simplify;

#[cfg(test)]
pub(crate) mod manifold;
#[cfg(test)]
mod tests;

pub(crate) use boundary_strip::{Exit, add_boundary_strips};
pub(crate) use boundary_strip_places::BoundaryLoop;
pub use complete::FillReport;
pub(crate) use complete::{FillError, complete};
pub(crate) use embedded_graph::{EmbeddedGraph, GraphArc, GraphNode, Tag};
pub(crate) use patterns::Pattern;
