//! The nearest point of a surface: a bounding volume hierarchy over its triangles.

use glam::DVec3;

use crate::engine::mesh::{TriMesh, closest_on_triangle};

/// Triangles per leaf of the hierarchy.
const LEAF: usize = 4;
/// Halving always splits in the middle, so this is deeper than any hierarchy over 2³² faces.
const DEPTH: usize = 64;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The face it lies in.
    pub face: u32,
    /// Weights of the face's three corners, none negative, sum 1.
    pub barycentric: [f64; 3],
    /// Its position in model units.
    pub position: DVec3,
    /// Distance from the query point in model units.
    pub distance: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    lo: DVec3,
    hi: DVec3,
    /// First triangle of a leaf, or second child of an inner node (the first one follows the node itself).
    start: u32,
    /// Triangles of a leaf, 0 for an inner node.
    count: u32,
}

impl Node {
    fn distance_squared(&self, p: DVec3) -> f64 {
        (self.lo - p).max(p - self.hi).max(DVec3::ZERO).length_squared()
    }
}

/// Nearest-point queries on some faces of a fixed triangle mesh. Owns what it needs.
#[derive(Clone, Debug)]
pub struct FaceTree {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
    /// Face of each of `triangles`.
    faces: Vec<u32>,
}

impl FaceTree {
    /// Builds the hierarchy over `faces` of `mesh`, which are in ascending order. O(n log n).
    pub fn new(mesh: &TriMesh, faces: &[u32]) -> Self {
        Self::of_triangles(faces.iter().map(|&f| mesh.triangle(f as usize)).collect(), faces)
    }

    /// Builds the hierarchy over triangles, or segments that have an end twice, with their names in ascending order.
    pub fn of_triangles(corners: Vec<[DVec3; 3]>, faces: &[u32]) -> Self {
        let centres: Vec<DVec3> = corners.iter().map(|&[a, b, c]| a.min(b).min(c) + a.max(b).max(c)).collect();
        let mut order: Vec<u32> = (0..faces.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * faces.len() / LEAF + 2);
        if !faces.is_empty() {
            build(&mut nodes, &mut order, 0, &corners, &centres);
        }
        let triangles = order.iter().map(|&i| corners[i as usize]).collect();
        Self { nodes, triangles, faces: order.iter().map(|&i| faces[i as usize]).collect() }
    }
}

/// Nearest-point queries on all of a fixed triangle mesh, with its normals.
#[derive(Clone, Debug)]
pub struct SurfaceIndex {
    tree: FaceTree,
    /// Unit normal per face.
    normals: Vec<DVec3>,
    /// Vertices per face.
    corners: Vec<[u32; 3]>,
    /// Unit normal per vertex, the mean of its faces weighted by area.
    vertex_normals: Vec<DVec3>,
}

impl SurfaceIndex {
    /// Builds the hierarchy, O(F log F).
    pub fn new(mesh: &TriMesh) -> Self {
        let tree = FaceTree::new(mesh, &(0..mesh.n_faces() as u32).collect::<Vec<_>>());
        let normals = (0..mesh.n_faces()).map(|f| mesh.normal(f)).collect();
        let mut vertex_normals = vec![DVec3::ZERO; mesh.n_vertices()];
        for (f, face) in mesh.faces().iter().enumerate() {
            for &v in face {
                vertex_normals[v as usize] += mesh.area_vector(f);
            }
        }
        let vertex_normals = vertex_normals.into_iter().map(DVec3::normalize_or_zero).collect();
        Self { tree, normals, corners: mesh.faces().to_vec(), vertex_normals }
    }

    /// Unit normal at a point of the surface, interpolated between its face's vertices: what the eye would call the
    /// direction of a noisy surface. Never zero unless all of them are.
    pub fn smooth_normal(&self, at: &SurfacePoint) -> DVec3 {
        let corners = self.corners[at.face as usize];
        let mean: DVec3 = (0..3).map(|k| at.barycentric[k] * self.vertex_normals[corners[k] as usize]).sum();
        mean.try_normalize().unwrap_or_else(|| self.normal(at.face))
    }

    /// Unit normal of a face; zero if it has no area.
    pub fn normal(&self, face: u32) -> DVec3 {
        self.normals[face as usize]
    }

    /// The point of the surface nearest to `p`; of several in the same distance the one in the lowest face.
    ///
    /// A mesh without faces has no such point: the answer then is `p` itself at infinite distance in face 0.
    ///
    /// ```
    /// use glam::dvec3;
    /// use quadrille::engine::mesh::{SurfaceIndex, TriMesh};
    ///
    /// let corners = vec![dvec3(0.0, 0.0, 0.0), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0)];
    /// let index = SurfaceIndex::new(&TriMesh::try_new(corners, vec![[0, 1, 2]])?);
    /// let nearest = index.closest(dvec3(1.0, 2.0, 3.0));
    /// assert_eq!((nearest.face, nearest.position, nearest.distance), (0, dvec3(1.0, 2.0, 0.0), 3.0));
    /// assert_eq!(nearest.barycentric, [0.25, 0.25, 0.5]);
    /// # Ok::<(), quadrille::engine::mesh::MeshError>(())
    /// ```
    pub fn closest(&self, p: DVec3) -> SurfacePoint {
        let nothing = SurfacePoint { face: 0, barycentric: [1.0, 0.0, 0.0], position: p, distance: f64::INFINITY };
        self.closest_where(p, f64::INFINITY, |_| true).unwrap_or(nothing)
    }

    /// The hierarchy of its faces.
    pub fn tree(&self) -> &FaceTree {
        &self.tree
    }

    /// As [`FaceTree::closest_where`].
    pub fn closest_where(&self, p: DVec3, max_distance: f64, accept: impl Fn(u32) -> bool) -> Option<SurfacePoint> {
        self.tree.closest_where(p, max_distance, accept)
    }
}

impl FaceTree {
    /// The point nearest to `p` at most `max_distance` away in a face that `accept` accepts, if there is one; of several
    /// in the same distance the one in the lowest face. Faces that are not accepted are walked through: leave out of the
    /// tree what never is.
    pub fn closest_where(
        &self,
        p: DVec3,
        max_distance: f64,
        mut accept: impl FnMut(u32) -> bool,
    ) -> Option<SurfacePoint> {
        let root = self.nodes.first()?;
        let mut bound = max_distance * max_distance;
        let mut best: Option<(u32, [f64; 3], DVec3)> = None;
        let mut stack = [(0u32, 0f64); DEPTH];
        let mut height = 1;
        stack[0] = (0, root.distance_squared(p));
        while height > 0 {
            height -= 1;
            let (at, near) = stack[height];
            if near > bound {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let (first, second) = (at + 1, node.start);
                let d_first = self.nodes[first as usize].distance_squared(p);
                let d_second = self.nodes[second as usize].distance_squared(p);
                let ((near, d_near), (far, d_far)) = if d_second < d_first {
                    ((second, d_second), (first, d_first))
                } else {
                    ((first, d_first), (second, d_second))
                };
                if d_far <= bound {
                    stack[height] = (far, d_far);
                    height += 1;
                }
                if d_near <= bound {
                    stack[height] = (near, d_near);
                    height += 1;
                }
                continue;
            }
            for i in node.start as usize..(node.start + node.count) as usize {
                let (barycentric, position) = closest_on_triangle(p, &self.triangles[i]);
                let (d, face) = (p.distance_squared(position), self.faces[i]);
                let better = d < bound || d == bound && best.is_none_or(|(known, ..)| face < known);
                if better && accept(face) {
                    bound = d;
                    best = Some((face, barycentric, position));
                }
            }
        }
        best.map(|(face, barycentric, position)| SurfacePoint { face, barycentric, position, distance: bound.sqrt() })
    }
}

impl FaceTree {
    /// Calls `visit` with the name and the corners of every triangle whose bounding box meets that of these points, each
    /// once, in an order that depends on nothing but the tree.
    pub fn meeting(&self, points: &[DVec3; 3], mut visit: impl FnMut(u32, &[DVec3; 3])) {
        let [a, b, c] = *points;
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        let mut stack: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            if !(node.lo.cmple(hi).all() && node.hi.cmpge(lo).all()) {
                continue;
            }
            if node.count == 0 {
                stack.extend([at + 1, node.start]);
                continue;
            }
            for i in node.start as usize..(node.start + node.count) as usize {
                let [a, b, c] = self.triangles[i];
                if a.min(b).min(c).cmple(hi).all() && a.max(b).max(c).cmpge(lo).all() {
                    visit(self.faces[i], &self.triangles[i]);
                }
            }
        }
    }
}

/// Appends the subtree over `faces`, which stand at `offset` of the whole order.
fn build(nodes: &mut Vec<Node>, faces: &mut [u32], offset: usize, corners: &[[DVec3; 3]], centres: &[DVec3]) {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut centre_lo, mut centre_hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &f in faces.iter() {
        for &p in &corners[f as usize] {
            lo = lo.min(p);
            hi = hi.max(p);
        }
        centre_lo = centre_lo.min(centres[f as usize]);
        centre_hi = centre_hi.max(centres[f as usize]);
    }
    let at = nodes.len();
    nodes.push(Node { lo, hi, start: offset as u32, count: faces.len() as u32 });
    if faces.len() <= LEAF {
        return;
    }
    let axis = (centre_hi - centre_lo).max_position();
    let middle = faces.len() / 2;
    // The face number breaks ties, so the order is the same whatever the selection algorithm does.
    faces.select_nth_unstable_by(middle, |&f, &g| {
        centres[f as usize][axis].total_cmp(&centres[g as usize][axis]).then(f.cmp(&g))
    });
    let (left, right) = faces.split_at_mut(middle);
    build(nodes, left, offset, corners, centres);
    nodes[at].start = nodes.len() as u32;
    nodes[at].count = 0;
    build(nodes, right, offset + middle, corners, centres);
}

#[cfg(test)]
mod tests;
