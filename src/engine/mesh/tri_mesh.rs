//! An oriented 2-manifold triangle mesh, immutable once built.
//!
//! Halfedges are implicit: halfedge `3 f + k` runs along the side of face `f` from its corner `k` to its corner
//! `k + 1`; corner `3 f + k` is the corner at the origin of that halfedge. So `next`, `face` and `corner` are
//! arithmetic, and the only table is `twin`. (Why no pointers or linked lists: nothing is ever changed in place.)

use glam::DVec3;

/// No twin: the halfedge lies on the boundary.
pub const NONE: u32 = u32::MAX;

/// A list of triangles is not an oriented 2-manifold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A face names a vertex twice or out of range.
    #[error("face {face} does not have three different vertices in range")]
    BadFace {
        /// The face.
        face: u32,
    },
    /// An edge has more than two faces, or two faces that run along it in the same direction.
    #[error("the edge {a}-{b} has too many or inconsistently oriented faces")]
    BadEdge {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
    /// A vertex has more than one fan of faces.
    #[error("vertex {vertex} has more than one fan of faces")]
    BadVertex {
        /// The vertex.
        vertex: u32,
    },
}

/// Numbers of a surface: components, boundary loops, and genus summed over the components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus, summed over the components.
    pub genus: usize,
    /// Euler characteristic V − E + F.
    pub euler: i64,
}

/// An oriented 2-manifold triangle mesh, possibly with boundary and several components; no unreferenced vertices.
#[derive(Clone, Debug)]
pub struct TriMesh {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    twin: Vec<u32>,
    /// One outgoing halfedge per vertex; at a boundary vertex the one whose predecessor side is open, i.e. the first
    /// of the fan in counter-clockwise order (it is itself a boundary halfedge).
    outgoing: Vec<u32>,
}

impl TriMesh {
    /// Proves that the triangles form an oriented 2-manifold without unreferenced vertices.
    ///
    /// ```
    /// use glam::DVec3;
    /// use quadrille::engine::mesh::{MeshError, TriMesh};
    ///
    /// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let tetrahedron = TriMesh::try_new(corners.clone(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// assert_eq!((tetrahedron.topology().euler, tetrahedron.topology().boundaries), (2, 0));
    /// let turned = TriMesh::try_new(corners, vec![[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    /// assert!(matches!(turned, Err(MeshError::BadEdge { .. })));
    /// # Ok::<(), MeshError>(())
    /// ```
    ///
    /// # Errors
    /// The first [`MeshError`] in index order. O(F log F).
    pub fn try_new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let n = positions.len() as u32;
        for (f, &[a, b, c]) in faces.iter().enumerate() {
            if a >= n || b >= n || c >= n || a == b || b == c || c == a {
                return Err(MeshError::BadFace { face: f as u32 });
            }
        }
        let twin = match_twins(&faces)?;
        let mut mesh = Self { positions, faces, twin, outgoing: Vec::new() };
        mesh.outgoing = mesh.find_outgoing()?;
        Ok(mesh)
    }

    fn find_outgoing(&self) -> Result<Vec<u32>, MeshError> {
        let mut outgoing = vec![NONE; self.positions.len()];
        let mut degree = vec![0u32; self.positions.len()];
        for h in 0..self.n_halfedges() {
            let v = self.origin(h) as usize;
            degree[v] += 1;
            if outgoing[v] == NONE || self.is_boundary(h) {
                outgoing[v] = h as u32;
            }
        }
        for v in 0..self.positions.len() {
            if outgoing[v] == NONE {
                return Err(MeshError::BadVertex { vertex: v as u32 });
            }
            // Walk counter-clockwise from the start; a single fan meets every face at v.
            let (start, mut h, mut met) = (outgoing[v], outgoing[v], 0);
            loop {
                met += 1;
                h = self.twin[prev(h as usize)];
                if h == NONE || h == start || met > degree[v] {
                    break;
                }
            }
            if met != degree[v] {
                return Err(MeshError::BadVertex { vertex: v as u32 });
            }
        }
        Ok(outgoing)
    }

    /// Vertex positions.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Faces, counter-clockwise seen from outside.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }
    /// Number of vertices.
    #[inline]
    pub fn n_vertices(&self) -> usize {
        self.positions.len()
    }
    /// Number of faces.
    #[inline]
    pub fn n_faces(&self) -> usize {
        self.faces.len()
    }
    /// Number of halfedges, 3 per face.
    #[inline]
    pub fn n_halfedges(&self) -> usize {
        3 * self.faces.len()
    }
    /// Number of edges.
    pub fn n_edges(&self) -> usize {
        (0..self.n_halfedges()).filter(|&h| self.is_edge_owner(h)).count()
    }
    /// Whether `h` is the halfedge that stands for its edge (the lower of the two, or the only one).
    #[inline]
    pub fn is_edge_owner(&self, h: usize) -> bool {
        self.twin[h] == NONE || h < self.twin[h] as usize
    }
    /// Position of vertex `v`.
    #[inline]
    pub fn position(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }
    /// Corners of face `f`.
    #[inline]
    pub fn face(&self, f: usize) -> [u32; 3] {
        self.faces[f]
    }
    /// Corner positions of face `f`.
    #[inline]
    pub fn triangle(&self, f: usize) -> [DVec3; 3] {
        self.faces[f].map(|v| self.position(v))
    }
    /// First vertex of halfedge `h`.
    #[inline]
    pub fn origin(&self, h: usize) -> u32 {
        self.faces[h / 3][h % 3]
    }
    /// Second vertex of halfedge `h`.
    #[inline]
    pub fn target(&self, h: usize) -> u32 {
        self.faces[h / 3][(h % 3 + 1) % 3]
    }
    /// The opposite halfedge, or `None` on the boundary.
    #[inline]
    pub fn twin(&self, h: usize) -> Option<usize> {
        let t = self.twin[h];
        (t != NONE).then_some(t as usize)
    }
    /// Whether halfedge `h` lies on the boundary.
    #[inline]
    pub fn is_boundary(&self, h: usize) -> bool {
        self.twin[h] == NONE
    }
    /// One halfedge leaving `v`; on the boundary the first of its fan, itself a boundary halfedge.
    #[inline]
    pub fn outgoing(&self, v: u32) -> usize {
        self.outgoing[v as usize] as usize
    }
    /// Whether `v` lies on the boundary.
    #[inline]
    pub fn is_boundary_vertex(&self, v: u32) -> bool {
        self.is_boundary(self.outgoing(v))
    }
    /// The halfedges leaving `v`, counter-clockwise, one per face of its fan.
    #[inline]
    pub fn fan(&self, v: u32) -> impl Iterator<Item = usize> + '_ {
        let start = self.outgoing(v);
        let mut h = Some(start);
        std::iter::from_fn(move || {
            let now = h?;
            h = self.twin(prev(now)).filter(|&n| n != start);
            Some(now)
        })
    }
    /// Vector of twice the area of face `f`, along its normal.
    #[inline]
    pub fn area_vector(&self, f: usize) -> DVec3 {
        let [a, b, c] = self.triangle(f);
        (b - a).cross(c - a)
    }
    /// Unit normal of face `f`; zero if the face has no area.
    #[inline]
    pub fn normal(&self, f: usize) -> DVec3 {
        self.area_vector(f).normalize_or_zero()
    }
    /// Area of face `f`.
    #[inline]
    pub fn area(&self, f: usize) -> f64 {
        0.5 * self.area_vector(f).length()
    }
    /// Total area, summed in index order.
    pub fn total_area(&self) -> f64 {
        (0..self.n_faces()).map(|f| self.area(f)).sum()
    }
    /// Diagonal of the bounding box.
    pub fn diagonal(&self) -> f64 {
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in &self.positions {
            lo = lo.min(p);
            hi = hi.max(p);
        }
        if self.positions.is_empty() { 0.0 } else { (hi - lo).length() }
    }

    /// Component of each face, numbered in order of the first face, and their number.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut component = vec![NONE; self.n_faces()];
        let mut n = 0;
        let mut stack = Vec::new();
        for seed in 0..self.n_faces() {
            if component[seed] != NONE {
                continue;
            }
            component[seed] = n;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for t in (3 * f..3 * f + 3).filter_map(|h| self.twin(h)) {
                    if component[t / 3] == NONE {
                        component[t / 3] = n;
                        stack.push(t / 3);
                    }
                }
            }
            n += 1;
        }
        (component, n as usize)
    }

    /// The boundary loops as lists of boundary halfedges, each starting at its lowest halfedge.
    pub fn boundary_loops(&self) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.n_halfedges()];
        let mut loops = Vec::new();
        for start in 0..self.n_halfedges() {
            if !self.is_boundary(start) || seen[start] {
                continue;
            }
            let (mut h, mut boundary) = (start, Vec::new());
            while !seen[h] {
                seen[h] = true;
                boundary.push(h);
                h = self.outgoing(self.target(h));
            }
            loops.push(boundary);
        }
        loops
    }

    /// Components, boundary loops, genus, Euler characteristic.
    pub fn topology(&self) -> Topology {
        let (_, components) = self.components();
        let boundaries = self.boundary_loops().len();
        let euler = self.n_vertices() as i64 - self.n_edges() as i64 + self.n_faces() as i64;
        let genus = (2 * components as i64 - boundaries as i64 - euler) / 2;
        Topology { components, boundaries, genus: genus.max(0) as usize, euler }
    }
}

/// The halfedge after `h` in its face.
pub fn next(h: usize) -> usize {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The halfedge before `h` in its face.
pub fn prev(h: usize) -> usize {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

fn match_twins(faces: &[[u32; 3]]) -> Result<Vec<u32>, MeshError> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), (3 * f + k) as u32));
        }
    }
    sides.sort_unstable();
    let mut twin = vec![NONE; 3 * faces.len()];
    let mut i = 0;
    while i < sides.len() {
        let (a, b, h) = sides[i];
        let run = sides[i..].iter().take_while(|s| (s.0, s.1) == (a, b)).count();
        if run == 2 {
            let t = sides[i + 1].2;
            if faces[h as usize / 3][h as usize % 3] == faces[t as usize / 3][t as usize % 3] {
                return Err(MeshError::BadEdge { a, b });
            }
            twin[h as usize] = t;
            twin[t as usize] = h;
        } else if run > 2 {
            return Err(MeshError::BadEdge { a, b });
        }
        i += run;
    }
    Ok(twin)
}

#[cfg(test)]
mod tests;
