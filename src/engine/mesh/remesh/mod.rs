//! New triangles for a surface: the same topology, the same feature curves and corners, other edges.

mod collapse;
mod curves;
mod edit;
mod flip;
mod isotropic;
mod relax;
#[cfg(test)]
pub(in crate::engine) mod samples;
mod straighten;
#[cfg(test)]
mod tests;
mod working;

pub(in crate::engine::mesh) use edit::EditMesh;
pub use isotropic::{IsotropicOptions, remesh_isotropic};
pub(in crate::engine) use isotropic::{LocalSize, remesh_with_middles};
pub use straighten::straightened;
pub use working::{LogSize, remesh_graded, working_mesh};
