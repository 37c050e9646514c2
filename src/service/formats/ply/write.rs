//! Writing quads as binary PLY.

use super::super::text_writer::push;
use crate::engine::quad::QuadMesh;

/// Double precision positions and lists of four `int` indices, which every reader knows.
pub(in super::super) fn write(mesh: &QuadMesh) -> Vec<u8> {
    let (n, m) = (mesh.positions.len(), mesh.quads.len());
    let mut out = Vec::with_capacity(256 + 24 * n + 17 * m);
    push(
        &mut out,
        format_args!(
            "ply\nformat binary_little_endian 1.0\ncomment quads by Quadrille\n\
             element vertex {n}\nproperty double x\nproperty double y\nproperty double z\n\
             element face {m}\nproperty list uchar int vertex_indices\nend_header\n"
        ),
    );
    for x in mesh.positions.iter().flat_map(|p| p.to_array()) {
        out.extend_from_slice(&x.to_le_bytes());
    }
    for quad in &mesh.quads {
        out.push(4);
        quad.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
    }
    out
}
