//! Values of corners as those of vertices, of which there are more where quads disagree.

use std::collections::BTreeMap;

use crate::engine::quad::QuadMesh;

/// The vertices of a quad mesh, followed by copies of those whose quads disagree about their values.
#[derive(Debug)]
pub(super) struct CornerValues<const N: usize> {
    /// Values per vertex and copy; of vertices without quads zeros.
    pub(super) values: Vec<[f32; N]>,
    /// The vertex itself, or the one that it is a copy of.
    pub(super) vertex: Vec<u32>,
    /// Vertex or copy per corner of each quad.
    pub(super) corners: Vec<[u32; 4]>,
}

impl<const N: usize> CornerValues<N> {
    /// `values` per corner of each quad.
    pub(super) fn of(mesh: &QuadMesh, values: impl Iterator<Item = [[f32; N]; 4]>) -> Self {
        let n = mesh.positions.len();
        let mut first: Vec<Option<[f32; N]>> = vec![None; n];
        let mut copies: BTreeMap<(u32, [u32; N]), u32> = BTreeMap::new();
        let (mut of_vertices, mut vertex) = (vec![[0.0; N]; n], (0..n as u32).collect::<Vec<_>>());
        let mut corner = |v: u32, value: [f32; N]| {
            if *first[v as usize].get_or_insert(value) == value {
                of_vertices[v as usize] = value;
                return v;
            }
            *copies.entry((v, value.map(f32::to_bits))).or_insert_with(|| {
                of_vertices.push(value);
                vertex.push(v);
                vertex.len() as u32 - 1
            })
        };
        // Adding zero makes −0 the same as 0.
        let corners = mesh.quads.iter().zip(values);
        let corners = corners.map(|(quad, of)| std::array::from_fn(|k| corner(quad[k], of[k].map(|x| x + 0.0))));
        let corners = corners.collect();
        Self { values: of_vertices, vertex, corners }
    }

    /// The copies.
    pub(super) fn copies(&self, mesh: &QuadMesh) -> &[u32] {
        &self.vertex[mesh.positions.len()..]
    }
}
