//! Discrete harmonic forms on a singularity graph `[tong_2006]`: a graph of meta-vertices and meta-edges cuts the surface into
//! discs, tags say how its edges run in the plane, integers how long they are, and two harmonic functions, continuous
//! across the graph up to quarter turns and integers, are the map.

mod charts;
mod conformal;
#[cfg(test)]
mod conformal_tests;
mod continuity;
#[cfg(test)]
mod continuity_tests;
mod cut_graph;
mod cut_mesh;
#[cfg(test)]
mod cut_mesh_tests;
mod error;
mod given;
#[cfg(test)]
mod given_tests;
mod graph;
mod meta_system;
mod method;
mod outline;
mod regions;
mod report;
mod routes;
mod separatrices;
mod solve;
mod source;
mod tag;
#[cfg(test)]
mod tests;
mod working;

pub use method::Harmonic;
