//! Texture coordinates of corners as those of vertices, of which there are more where quads disagree.

use std::collections::BTreeMap;

use crate::engine::quad::QuadMesh;

/// The vertices of a quad mesh, followed by copies of those whose quads disagree about their texture coordinates.
#[derive(Debug)]
pub(super) struct CornerUv {
    /// Coordinates per vertex and copy; of vertices without quads the origin.
    pub(super) values: Vec<[f32; 2]>,
    /// The vertex itself, or the one that it is a copy of.
    pub(super) vertex: Vec<u32>,
    /// Vertex or copy per corner of each quad.
    pub(super) corners: Vec<[u32; 4]>,
}

impl CornerUv {
    /// `uv` per corner of each quad.
    pub(super) fn of(mesh: &QuadMesh, uv: &[[[f32; 2]; 4]]) -> Self {
        let n = mesh.positions.len();
        let mut first: Vec<Option<[f32; 2]>> = vec![None; n];
        let mut copies: BTreeMap<(u32, [u32; 2]), u32> = BTreeMap::new();
        let (mut values, mut vertex) = (vec![[0.0; 2]; n], (0..n as u32).collect::<Vec<_>>());
        let mut corner = |v: u32, uv: [f32; 2]| {
            if *first[v as usize].get_or_insert(uv) == uv {
                values[v as usize] = uv;
                return v;
            }
            *copies.entry((v, uv.map(f32::to_bits))).or_insert_with(|| {
                values.push(uv);
                vertex.push(v);
                vertex.len() as u32 - 1
            })
        };
        let quads = mesh.quads.iter().zip(uv);
        // Adding zero makes −0 the same as 0.
        let corners =
            quads.map(|(quad, uv)| std::array::from_fn(|k| corner(quad[k], uv[k].map(|c| c + 0.0)))).collect();
        Self { values, vertex, corners }
    }

    /// The copies.
    pub(super) fn copies(&self, mesh: &QuadMesh) -> &[u32] {
        &self.vertex[mesh.positions.len()..]
    }
}
