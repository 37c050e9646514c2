//! Writing quads as binary PLY.

use super::super::precision::Precision;
use super::super::text_writer::push;
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// Positions in the precision that they need, colours as bytes, and lists of four `int` indices, which every reader knows.
pub(in super::super) fn write(mesh: &QuadMesh, attributes: &QuadAttributes) -> Vec<u8> {
    let (n, m) = (mesh.positions.len(), mesh.quads.len());
    let colours = match attributes.colours.is_empty() {
        true => "",
        false => "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n",
    };
    let precision = Precision::of(&mesh.positions);
    let kind = match precision {
        Precision::Single => "float",
        Precision::Double => "double",
    };
    let mut out = Vec::with_capacity(256 + 24 * n + 17 * m);
    push(
        &mut out,
        format_args!(
            "ply\nformat binary_little_endian 1.0\ncomment quads by Quadrille\n\
             element vertex {n}\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n{colours}\
             element face {m}\nproperty list uchar int vertex_indices\nend_header\n"
        ),
    );
    for (v, p) in mesh.positions.iter().enumerate() {
        match precision {
            Precision::Single => out.extend(p.to_array().iter().flat_map(|&x| (x as f32).to_le_bytes())),
            Precision::Double => out.extend(p.to_array().iter().flat_map(|x| x.to_le_bytes())),
        }
        if let Some(colour) = attributes.colours.get(v) {
            out.extend(colour.map(|c| (255.0 * c).round() as u8));
        }
    }
    for quad in &mesh.quads {
        out.push(4);
        quad.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
    }
    out
}
