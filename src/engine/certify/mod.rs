//! The certificate: what a quad mesh must prove before anybody gets to see it, and its measures.
//!
//! Nothing here is shared with the code that makes quads but the search for nearest points and `numerics`: the certificate
//! starts from the bare quads, as re-read from the bytes that will be delivered, and from the conditioned surface. What is
//! checked:
//!
//! * every quad has four different vertices in range, no two quads have the same vertices, every vertex is used and
//!   has finite coordinates;
//! * every edge has one or two quads, oppositely oriented, and every vertex one fan of quads;
//! * components, boundary loops and genus equal those of the surface, in total and component by component;
//! * no quad is flipped against the surface, at the scale of the quads, or without area;
//! * no quad has a straight or reflex corner or lies folded on its neighbour, except at a kept feature, and quads and
//!   surface are nowhere further apart than two quad edges, as they were asked for or as they are;
//! * feature curves and boundary loops of the surface are chains of quad edges, corners are vertices, and the boundary
//!   loops correspond one to one.

mod boundary;
mod certificate;
mod check;
mod components;
mod crossings;
mod curves;
mod distance;
mod footprint;
mod judge;
mod orientation;
mod reach;
mod report;
mod samples;
mod segments;
mod shape;
mod topology;
mod trace;

#[cfg(test)]
mod curve_tests;
#[cfg(test)]
mod strict_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod topology_tests;

pub use certificate::{Certificate, certify};
pub use check::{Check, Violation};
pub use crossings::new_crossings;
pub use curves::corner_reach;
pub use judge::{Defect, QuadJudge, Stance};
pub use report::QuadReport;
pub use shape::scaled_jacobian;
pub use topology::{ComponentTopology, QuadTopology, measure_topology};
