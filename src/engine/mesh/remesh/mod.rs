//! New triangles for a surface: the same topology, the same feature curves and corners, other edges.

mod curves;
mod edit;
#[cfg(test)]
pub(in crate::engine) mod samples;

pub(in crate::engine::mesh) use edit::EditMesh;
