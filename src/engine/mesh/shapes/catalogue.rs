//! The list of sample surfaces and the door to them.

use crate::engine::mesh::shapes::patches::vertex_normals;
use crate::engine::mesh::shapes::{cad, implicit, parametric};
use crate::engine::mesh::{Features, Surface, TriMesh, TriangleSoup};
use crate::engine::numerics::Random;
use glam::DVec3;

/// What is known of a sample surface; every one is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapeInfo {
    /// Its name.
    pub name: &'static str,
    /// One sentence for people.
    pub about: &'static str,
    /// Genus.
    pub genus: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Whether it has sharp edges (dihedral angle above 40 degrees).
    pub sharp: bool,
}

const fn shape(name: &'static str, about: &'static str, genus: usize, boundaries: usize, sharp: bool) -> ShapeInfo {
    ShapeInfo { name, about, genus, boundaries, sharp }
}

/// All sample surfaces.
pub const SHAPES: &[ShapeInfo] = &[
    shape("sphere", "The unit sphere.", 0, 0, false),
    shape("ellipsoid", "An ellipsoid with three different axes.", 0, 0, false),
    shape("torus", "A torus of radii 1 and 0.4.", 1, 0, false),
    shape("genus2", "Two tilted tori grown together.", 2, 0, false),
    shape("genus5", "The rounded frame of a cube.", 5, 0, false),
    shape("cube", "A cube with sharp edges; 12 triangles at the least.", 0, 0, true),
    shape("rounded_box", "A box with quarter-round edges.", 0, 0, false),
    shape("gear", "A gear wheel with teeth, bore and a thinner web with six holes.", 7, 0, true),
    shape("half_pipe", "An open half cylinder.", 0, 1, false),
    shape("plate_with_holes", "A plate with six round through holes.", 6, 0, true),
    shape("dumbbell", "Two balls joined by a thin neck.", 0, 0, false),
    shape("trefoil", "A tube along a trefoil knot.", 1, 0, false),
    shape("noisy_blob", "A ball with smooth bumps of three sizes.", 0, 0, false),
];

/// The sample that shows most at a glance.
pub const DEFAULT_SHAPE: &str = "genus2";

/// Positions and triangles of the sample `name`: within a quarter of `triangles` (clamped to 12 to 4 million) where
/// so few can show it. Least numbers: gear and genus5 about 1200, genus2 and dumbbell 700, others 450, cube 12.
fn triangulate(name: &str, triangles: usize) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    let triangles = triangles.clamp(12, 4_000_000);
    let patches = match name {
        "sphere" => parametric::sphere(),
        "ellipsoid" => parametric::ellipsoid(),
        "torus" => parametric::torus(),
        "cube" => parametric::cube(),
        "rounded_box" => parametric::rounded_box(),
        "half_pipe" => parametric::half_pipe(),
        "trefoil" => parametric::trefoil(),
        "noisy_blob" => parametric::noisy_blob(),
        "gear" => cad::gear(),
        "plate_with_holes" => cad::plate_with_holes(),
        "genus2" => return Some(implicit::genus2().triangulate(triangles)),
        "genus5" => return Some(implicit::genus5().triangulate(triangles)),
        "dumbbell" => return Some(implicit::dumbbell().triangulate(triangles)),
        _ => return None,
    };
    Some(patches.triangulate(triangles))
}

/// The sample `name` with about this many triangles; every vertex is moved along its normal by up to `noise` mean edge
/// lengths, at random by `seed`. `None` if there is no such sample.
///
/// ```
/// use quadrille::engine::mesh::shapes::{SHAPES, sample};
///
/// for shape in SHAPES {
///     let soup = sample(shape.name, 1500, 0.1, 7).expect("each shape has its sample");
///     assert!(soup.n_polygons() > 1000);
/// }
/// assert!(sample("teapot", 1500, 0.0, 0).is_none());
/// ```
pub fn sample(name: &str, triangles: usize, noise: f64, seed: u64) -> Option<TriangleSoup> {
    let (mut positions, faces) = triangulate(name, triangles)?;
    if noise != 0.0
        && noise.is_finite()
        && let Ok(mesh) = TriMesh::try_new(positions.clone(), faces.clone())
    {
        let length: f64 = (0..mesh.n_halfedges())
            .map(|h| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))))
            .sum::<f64>()
            / mesh.n_halfedges() as f64;
        for (v, (p, normal)) in positions.iter_mut().zip(vertex_normals(&mesh)).enumerate() {
            *p += normal * (noise * length * signed_unit(seed, v as u64));
        }
    }
    Some(TriangleSoup::from_triangles(positions, &faces))
}

/// The sample `name` without noise as a mesh: samples need no conditioning.
pub fn sample_mesh(name: &str, triangles: usize) -> Option<TriMesh> {
    let (positions, faces) = triangulate(name, triangles)?;
    TriMesh::try_new(positions, faces).ok()
}

/// The sample `name` without noise, with its sharp edges (above 40 degrees) as features, and as corners their ends,
/// junctions and turns above 60 degrees, and turns of the boundary.
///
/// ```
/// use quadrille::engine::mesh::shapes::sample_surface;
///
/// let cube = sample_surface("cube", 12).expect("one of the samples");
/// assert_eq!(cube.mesh.n_faces(), 12);
/// assert_eq!((cube.features.edges.len(), cube.features.corners.len()), (12, 8));
/// ```
pub fn sample_surface(name: &str, triangles: usize) -> Option<Surface> {
    let mesh = sample_mesh(name, triangles)?;
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut directions: Vec<Vec<DVec3>> = vec![Vec::new(); mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        let sharp = mesh.twin(h).map(|t| mesh.normal(h / 3).dot(mesh.normal(t / 3)) < 40f64.to_radians().cos());
        if sharp == Some(false) {
            continue;
        }
        let (a, b) = (mesh.origin(h), mesh.target(h));
        if sharp == Some(true) {
            edges.push([a.min(b), a.max(b)]);
        }
        let way = (mesh.position(b) - mesh.position(a)).normalize_or_zero();
        directions[a as usize].push(way);
        directions[b as usize].push(-way);
    }
    edges.sort_unstable();
    let is_corner = |ways: &Vec<DVec3>| match ways.as_slice() {
        [] => false,
        [a, b] => a.dot(*b) > -0.5,
        _ => true,
    };
    let corners = (0..mesh.n_vertices() as u32).filter(|&v| is_corner(&directions[v as usize])).collect();
    Some(Surface { mesh, features: Features { edges, corners } })
}

/// A number in [-1, 1) that depends on nothing but its arguments.
fn signed_unit(seed: u64, index: u64) -> f64 {
    Random::at(seed, index).signed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_its_topology_and_about_its_count() {
        for info in SHAPES {
            for wanted in [1500, 8000] {
                let mesh = sample_mesh(info.name, wanted).unwrap();
                let topology = mesh.topology();
                assert_eq!(
                    (topology.components, topology.genus, topology.boundaries),
                    (1, info.genus, info.boundaries),
                    "{} at {wanted}",
                    info.name
                );
                let ratio = mesh.n_faces() as f64 / wanted as f64;
                assert!((0.75..=1.25).contains(&ratio), "{}: {} of {wanted}", info.name, mesh.n_faces());
            }
        }
        assert!(sample("teapot", 500, 0.0, 0).is_none());
    }

    #[test]
    fn samples_face_outwards_and_have_no_slivers() {
        for info in SHAPES {
            let mesh = sample_mesh(info.name, 6000).unwrap();
            let volume: f64 =
                mesh.faces().iter().map(|f| f.map(|v| mesh.position(v))).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
            assert!(info.boundaries > 0 || volume > 0.0, "{} is inside out", info.name);
            for f in 0..mesh.n_faces() {
                let [a, b, c] = mesh.triangle(f);
                let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
                assert!(mesh.area(f) > 0.02 * longest * longest, "{}: face {f} is a sliver", info.name);
            }
        }
    }

    #[test]
    fn sharp_samples_have_their_features_on_mesh_edges() {
        let cube = sample_surface("cube", 12).unwrap();
        assert_eq!((cube.mesh.n_faces(), cube.features.edges.len(), cube.features.corners.len()), (12, 12, 8));
        for info in SHAPES {
            let surface = sample_surface(info.name, 8000).unwrap();
            assert_eq!(!surface.features.edges.is_empty(), info.sharp, "{}", info.name);
        }
        // Six holes: twelve circles without corners; the outline: two rectangles and four posts.
        let plate = sample_surface("plate_with_holes", 8000).unwrap();
        assert_eq!(plate.features.corners.len(), 8);
        assert_eq!(sample_surface("half_pipe", 2000).unwrap().features.corners.len(), 4);
    }

    #[test]
    fn noise_is_bounded_and_repeatable() {
        let plain = sample("sphere", 3000, 0.0, 7).unwrap();
        let noisy = sample("sphere", 3000, 0.3, 7).unwrap();
        assert_eq!(noisy, sample("sphere", 3000, 0.3, 7).unwrap());
        assert_ne!(noisy, sample("sphere", 3000, 0.3, 8).unwrap());
        let moved: Vec<f64> = plain.positions.iter().zip(&noisy.positions).map(|(p, q)| p.distance(*q)).collect();
        let largest = moved.iter().copied().fold(0.0, f64::max);
        assert!(largest > 0.0 && largest < 0.05, "{largest}");
    }
}
