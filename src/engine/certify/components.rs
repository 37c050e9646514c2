//! Components of the quads against components of the surface.

use crate::engine::certify::{Check, ComponentTopology, QuadTopology, Violation};
use crate::engine::mesh::{SurfaceIndex, SurfacePoint, TriMesh};
use crate::engine::quad::QuadMesh;

/// The components of a surface: per face its component, and their numbers.
pub(super) struct SurfaceComponents {
    of_face: Vec<u32>,
    of_vertex: Vec<u32>,
    pub(super) topology: Vec<ComponentTopology>,
}

impl SurfaceComponents {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let (of_face, n) = mesh.components();
        let mut euler = vec![0i64; n];
        let mut of_vertex = vec![0; mesh.n_vertices()];
        for (f, face) in mesh.faces().iter().enumerate() {
            let c = of_face[f];
            euler[c as usize] += 1;
            for (k, &v) in face.iter().enumerate() {
                of_vertex[v as usize] = c;
                euler[c as usize] -= i64::from(mesh.is_edge_owner(3 * f + k));
            }
        }
        for &c in &of_vertex {
            euler[c as usize] += 1;
        }
        let mut boundaries = vec![0; n];
        for boundary in mesh.boundary_loops() {
            boundaries[of_face[boundary[0] / 3] as usize] += 1;
        }
        let topology = euler.iter().zip(&boundaries).map(|(&e, &b)| ComponentTopology::new(e, b)).collect();
        Self { of_face, of_vertex, topology }
    }
}

/// Totals, and component by component. A component of the quads belongs to the component of the surface that most of
/// its vertices are nearest to. Where components of the surface touch or lie in the same place, that is undecided:
/// the components left over on both sides must then have the same topologies in some order, and each left-over one of
/// the surface must have quads over it, on average nearer than a quad's mean edge.
pub(super) fn check(
    mesh: &TriMesh,
    quads: &QuadMesh,
    topology: &QuadTopology,
    feet: &[SurfacePoint],
    quad_index: &SurfaceIndex,
    mean_edge: f64,
) -> Vec<Violation> {
    let surface = SurfaceComponents::new(mesh);
    let sum = |list: &[ComponentTopology]| -> (usize, usize) {
        (list.iter().map(|c| c.boundaries).sum(), list.iter().map(|c| c.genus).sum())
    };
    let ((b, g), (b0, g0)) = (sum(&topology.components), sum(&surface.topology));
    let mut found: Vec<Violation> = [
        Violation::unequal(Check::Components, topology.components.len(), surface.topology.len()),
        Violation::unequal(Check::Boundaries, b, b0),
        Violation::unequal(Check::Genus, g, g0),
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut votes: Vec<(u32, u32)> = quads
        .quads
        .iter()
        .zip(&topology.component)
        .flat_map(|(quad, &c)| quad.map(|v| (c, surface.of_face[feet[v as usize].face as usize])))
        .collect();
    votes.sort_unstable();
    let mut winner: Vec<(usize, u32)> = vec![(0, u32::MAX); topology.components.len()];
    for run in votes.chunk_by(|x, y| x == y) {
        let best = &mut winner[run[0].0 as usize];
        if run.len() > best.0 {
            *best = (run.len(), run[0].1);
        }
    }
    let mut owners: Vec<Vec<u32>> = vec![Vec::new(); surface.topology.len()];
    for (c, &(_, s)) in (0u32..).zip(&winner) {
        if let Some(list) = owners.get_mut(s as usize) {
            list.push(c);
        }
    }
    let settled =
        |s: usize| matches!(owners[s].as_slice(), [c] if topology.components[*c as usize] == surface.topology[s]);
    let open: Vec<usize> = (0..owners.len()).filter(|&s| !settled(s)).collect();
    let key = |c: &ComponentTopology| (c.boundaries, c.genus);
    let mut wanted: Vec<_> = open.iter().map(|&s| key(&surface.topology[s])).collect();
    let is_left = |c: u32| !matches!(winner[c as usize].1, s if s != u32::MAX && settled(s as usize));
    let mut left: Vec<_> =
        (0u32..).zip(&topology.components).filter(|(c, _)| is_left(*c)).map(|(_, t)| key(t)).collect();
    wanted.sort_unstable();
    left.sort_unstable();
    let mut vertices: Vec<u32> = if open.is_empty() { Vec::new() } else { (0..mesh.n_vertices() as u32).collect() };
    vertices.sort_by_key(|&v| surface.of_vertex[v as usize]);
    let is_covered = |s: usize| {
        let from = |c: usize| vertices.partition_point(|&v| (surface.of_vertex[v as usize] as usize) < c);
        let of_s = &vertices[from(s)..from(s + 1)];
        let some = of_s.iter().step_by(of_s.len().div_ceil(200).max(1));
        let distances: Vec<f64> = some.map(|&v| quad_index.closest(mesh.position(v)).distance).collect();
        distances.iter().sum::<f64>() <= mean_edge * distances.len() as f64
    };
    let lost = open.iter().copied().filter(|&s| wanted != left || !is_covered(s)).map(|s| s as u32);
    found.extend(Violation::at(Check::ComponentMatch, lost));
    found
}
