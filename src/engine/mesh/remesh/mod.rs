//! New triangles for a surface: the same topology, the same feature curves and corners, other edges.

mod collapse;
mod curves;
mod edit;
mod flip;
mod isotropic;
mod relax;
#[cfg(test)]
pub(in crate::engine) mod samples;
#[cfg(test)]
mod tests;

pub(in crate::engine::mesh) use edit::EditMesh;
pub use isotropic::{IsotropicOptions, remesh_isotropic};
