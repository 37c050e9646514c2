//! A numbering that depends on the shape alone, so that what is made of a surface does not depend on how its file
//! happened to number it, nor on how the model is turned and scaled.

use glam::DVec3;

use crate::engine::mesh::{Features, NONE, Surface, TriMesh, next, prev};

/// Vertices whose squared distances from the centroid differ by less than this share are equally far away: rounding
/// must not choose among them.
const EQUALLY_FAR: f64 = 1e-9;

impl Surface {
    /// The same surface, a single component, with vertices and faces in breadth-first order from its vertex farthest
    /// from its centroid along the longest edge there; equal ones are told apart by their coordinates. Each face begins
    /// with the vertex from which it was reached. O(n log n).
    pub fn in_canonical_order(&self) -> Self {
        let mesh = &self.mesh;
        let halfedges = breadth_first(mesh, start(mesh));
        let mut rank = vec![NONE; mesh.n_vertices()];
        let mut order = Vec::with_capacity(mesh.n_vertices());
        let faces = halfedges.iter().map(|&h| {
            [h, next(h), prev(h)].map(|h| {
                let v = mesh.origin(h);
                if rank[v as usize] == NONE {
                    rank[v as usize] = order.len() as u32;
                    order.push(v);
                }
                rank[v as usize]
            })
        });
        let faces = faces.collect();
        let positions = order.iter().map(|&v| mesh.position(v)).collect();
        let renamed = TriMesh::try_new(positions, faces).expect("a renumbered manifold is a manifold");
        let mut edges: Vec<[u32; 2]> = self.features.edges.iter().map(|e| e.map(|v| rank[v as usize])).collect();
        edges.iter_mut().for_each(|e| e.sort_unstable());
        edges.sort_unstable();
        let mut corners: Vec<u32> = self.features.corners.iter().map(|&v| rank[v as usize]).collect();
        corners.sort_unstable();
        Self { mesh: renamed, features: Features { edges, corners } }
    }
}

/// The halfedge with which the numbering begins.
fn start(mesh: &TriMesh) -> usize {
    let (mut centroid, mut area) = (DVec3::ZERO, 0.0);
    for f in 0..mesh.n_faces() {
        centroid += mesh.area(f) * mesh.triangle(f).iter().sum::<DVec3>() / 3.0;
        area += mesh.area(f);
    }
    centroid /= area.max(f64::MIN_POSITIVE);
    let vertices = 0..mesh.n_vertices() as u32;
    let farthest = first_of_most(mesh, vertices, |&v| v, |&v| mesh.position(v).distance_squared(centroid));
    let here = mesh.position(farthest);
    let across = |h: &usize| mesh.target(*h);
    first_of_most(mesh, mesh.fan(farthest), across, |h| mesh.position(across(h)).distance_squared(here))
}

/// The item of most value; of those with nearly as much, the one at the lowest coordinates.
fn first_of_most<T: Copy>(
    mesh: &TriMesh,
    items: impl Iterator<Item = T>,
    vertex: impl Fn(&T) -> u32,
    value: impl Fn(&T) -> f64,
) -> T {
    let items: Vec<(T, f64)> = items.map(|item| (item, value(&item))).collect();
    let most = items.iter().map(|i| i.1).fold(0.0, f64::max);
    let among = items.iter().filter(|i| i.1 >= most * (1.0 - EQUALLY_FAR)).map(|i| i.0);
    let at = |item: &T| mesh.position(vertex(item)).to_array();
    let before = |a: &T, b: &T| at(a).iter().zip(at(b)).map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
    among.min_by(|a, b| before(a, b).unwrap_or(std::cmp::Ordering::Equal)).expect("there are items")
}

/// Per face in breadth-first order, the halfedge with which it begins.
fn breadth_first(mesh: &TriMesh, start: usize) -> Vec<usize> {
    let mut seen = vec![false; mesh.n_faces()];
    seen[start / 3] = true;
    let mut queue = vec![start];
    let mut done = 0;
    while let Some(&h) = queue.get(done) {
        done += 1;
        for t in [h, next(h), prev(h)].into_iter().filter_map(|h| mesh.twin(h)) {
            if !seen[t / 3] {
                seen[t / 3] = true;
                queue.push(t);
            }
        }
    }
    queue
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    /// The surface with faces and vertices in another order, and faces that begin elsewhere.
    fn shuffled(surface: &Surface) -> Surface {
        let (n, m) = (surface.mesh.n_vertices() as u32, surface.mesh.n_faces());
        // Steps that share no divisor with the number visit everything.
        let step = (3..).find(|s| n % s != 0 && (2..*s).all(|d| s % d != 0)).unwrap();
        let name = |v: u32| (v * step + 7) % n;
        let mut positions = vec![DVec3::ZERO; n as usize];
        (0..n).for_each(|v| positions[name(v) as usize] = surface.mesh.position(v));
        let mut faces: Vec<[u32; 3]> = (0..m).rev().map(|f| surface.mesh.face(f).map(name)).collect();
        faces.iter_mut().enumerate().for_each(|(f, face)| face.rotate_left(f % 3));
        let mut edges: Vec<[u32; 2]> = surface.features.edges.iter().map(|e| e.map(name)).collect();
        edges.iter_mut().for_each(|e| e.sort_unstable());
        edges.sort_unstable();
        let mut corners: Vec<u32> = surface.features.corners.iter().map(|&v| name(v)).collect();
        corners.sort_unstable();
        Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features { edges, corners } }
    }

    #[test]
    fn every_numbering_of_a_surface_becomes_the_same() {
        for name in ["cube", "half_pipe", "genus2", "noisy_blob", "torus"] {
            let surface = sample_surface(name, 900).unwrap();
            let other = shuffled(&surface);
            assert_ne!(other.mesh.faces(), surface.mesh.faces());
            let [a, b] = [&surface, &other].map(Surface::in_canonical_order);
            assert_eq!(a.mesh.positions(), b.mesh.positions(), "{name}");
            assert_eq!(a.mesh.faces(), b.mesh.faces(), "{name}");
            assert_eq!(a.features, b.features, "{name}");
            assert_eq!(a.mesh.topology(), surface.mesh.topology(), "{name}");
            let (now, before) = (a.mesh.total_area(), surface.mesh.total_area());
            assert!((now - before).abs() < 1e-12 * before, "{name}: {now} {before}");
        }
    }
}
