//! Feature edges as a graph on the mesh.

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::feature_detection::thin::normal_beyond;
use crate::engine::mesh::feature_detection::thin::thin_faces;

/// Largest change of direction, in radians, along which a feature grows.
const STRAIGHT: f64 = 30.0 / 180.0 * std::f64::consts::PI;

/// A set of interior edges.
pub(super) struct Network<'a> {
    pub(super) mesh: &'a TriMesh,
    /// Per halfedge, the same on both sides.
    pub(super) marked: Vec<bool>,
    /// Marked and not to be dropped, per halfedge.
    pub(super) kept: Vec<bool>,
    /// Marked edges per vertex.
    degree: Vec<u32>,
    /// Per face, whether its normal says little.
    is_thin: Vec<bool>,
}

impl<'a> Network<'a> {
    /// No edges.
    pub(super) fn new(mesh: &'a TriMesh) -> Self {
        let n = mesh.n_halfedges();
        Self {
            mesh,
            marked: vec![false; n],
            kept: vec![false; n],
            degree: vec![0; mesh.n_vertices()],
            is_thin: thin_faces(mesh),
        }
    }

    /// Whether the edge of `h` is marked.
    pub(super) fn is_marked(&self, h: usize) -> bool {
        self.marked[h]
    }

    /// Number of marked edges.
    pub(super) fn n_marked(&self) -> usize {
        self.degree.iter().map(|&d| d as usize).sum::<usize>() / 2
    }

    /// Marked edges at `v`.
    pub(super) fn degree(&self, v: u32) -> u32 {
        self.degree[v as usize]
    }

    /// Marks or unmarks the edge of `h`.
    pub(super) fn set(&mut self, h: usize, marked: bool) {
        if self.marked[h] != marked {
            for s in [Some(h), self.mesh.twin(h)].into_iter().flatten() {
                self.marked[s] = marked;
            }
            for v in [self.mesh.origin(h), self.mesh.target(h)] {
                let d = &mut self.degree[v as usize];
                *d = if marked { *d + 1 } else { *d - 1 };
            }
        }
    }

    /// Marks an interior edge for good.
    pub(super) fn mark_kept(&mut self, h: usize) {
        self.set(h, true);
        for s in [Some(h), self.mesh.twin(h)].into_iter().flatten() {
            self.kept[s] = true;
        }
    }

    /// Angle between the normals of the two faces at `h`, in radians; 0 on the boundary. Where one of them is thin, at
    /// most the angle between what lies beyond it: a needle in a plane is not sharp, whatever its normal.
    pub(super) fn dihedral(&self, h: usize) -> f64 {
        let Some(t) = self.mesh.twin(h) else {
            return 0.0;
        };
        let angle = |n: glam::DVec3, m: glam::DVec3| n.cross(m).length().atan2(n.dot(m));
        let own = angle(self.mesh.normal(h / 3), self.mesh.normal(t / 3));
        if !self.is_thin[h / 3] && !self.is_thin[t / 3] {
            return own;
        }
        let [n, m] = [h, t].map(|side| normal_beyond(self.mesh, &self.is_thin, side));
        own.min(angle(n, m))
    }

    /// Marks the edges with a dihedral angle above `angle` radians.
    pub(super) fn mark_sharp(&mut self, angle: f64) {
        for h in 0..self.mesh.n_halfedges() {
            if self.mesh.is_edge_owner(h) && self.dihedral(h) > angle {
                self.set(h, true);
            }
        }
    }

    /// Halfedges of the marked edges at `v`, leaving `v` where there is such a halfedge.
    fn marked_at(&self, v: u32) -> impl Iterator<Item = usize> + '_ {
        // Marked edges are interior, so each has a halfedge that leaves v.
        self.mesh.fan(v).filter(|&h| self.marked[h])
    }

    /// Extends loose ends along edges with a dihedral angle above `angle` radians that go straight on.
    pub(super) fn grow(&mut self, angle: f64) {
        let mut ends: Vec<u32> = (0..self.mesh.n_vertices() as u32).filter(|&v| self.is_loose(v)).rev().collect();
        while let Some(v) = ends.pop() {
            if !self.is_loose(v) {
                continue;
            }
            let Some(back) = self.marked_at(v).next() else {
                continue;
            };
            let ahead = -self.direction(back);
            let candidates = self.mesh.fan(v).filter(|&h| !self.marked[h] && !self.mesh.is_boundary(h));
            let score = |h: usize| (self.dihedral(h), self.direction(h).dot(ahead));
            let best = candidates
                .map(|h| (score(h), h))
                .filter(|&((dihedral, along), _)| dihedral > angle && along > STRAIGHT.cos())
                .max_by(|p, q| (p.0.0 * p.0.1).total_cmp(&(q.0.0 * q.0.1)).then(q.1.cmp(&p.1)));
            if let Some((_, h)) = best {
                self.set(h, true);
                ends.push(self.mesh.target(h));
            }
        }
    }

    fn direction(&self, h: usize) -> glam::DVec3 {
        (self.mesh.position(self.mesh.target(h)) - self.mesh.position(self.mesh.origin(h))).normalize_or_zero()
    }

    /// Length of the edge of `h`.
    pub(super) fn length(&self, h: usize) -> f64 {
        self.mesh.position(self.mesh.target(h)).distance(self.mesh.position(self.mesh.origin(h)))
    }

    /// Whether a single marked edge ends at `v`, away from the boundary.
    pub(super) fn is_loose(&self, v: u32) -> bool {
        self.degree(v) == 1 && !self.mesh.is_boundary_vertex(v)
    }

    /// Whether chains end at `v`.
    fn is_node(&self, v: u32) -> bool {
        self.degree(v) != 2 || self.mesh.is_boundary_vertex(v)
    }

    /// The chain that starts with halfedge `h`, to the next node or back to the start.
    fn walk(&self, h: usize) -> Vec<usize> {
        let mut chain = vec![h];
        let mut at = h;
        loop {
            let v = self.mesh.target(at);
            if self.is_node(v) || v == self.mesh.origin(h) {
                return chain;
            }
            let twin = self.mesh.twin(at);
            let Some(onward) = self.marked_at(v).find(|&g| Some(g) != twin) else {
                return chain;
            };
            chain.push(onward);
            at = onward;
        }
    }

    /// The marked edges as chains between nodes and around loops, each once.
    pub(super) fn chains(&self) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.marked.len()];
        let mut chains = Vec::new();
        let starts_at_node = |h: &usize| self.is_node(self.mesh.origin(*h));
        let marked = || (0..self.marked.len()).filter(|&h| self.marked[h]);
        for h in marked().filter(starts_at_node).chain(marked()) {
            if seen[h] {
                continue;
            }
            let chain = self.walk(h);
            for &g in &chain {
                for s in [Some(g), self.mesh.twin(g)].into_iter().flatten() {
                    seen[s] = true;
                }
            }
            chains.push(chain);
        }
        chains
    }

    /// The marked edges, (lower, higher) vertex, sorted.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let ends = |h: usize| [self.mesh.origin(h), self.mesh.target(h)];
        let owners = (0..self.marked.len()).filter(|&h| self.marked[h] && self.mesh.is_edge_owner(h));
        let mut edges: Vec<[u32; 2]> = owners.map(ends).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges
    }

    /// The halfedge that goes on from `h` along its chain, or `None` where the chain ends.
    pub(super) fn next_marked(&self, h: usize) -> Option<usize> {
        let v = self.mesh.target(h);
        if self.is_node(v) {
            return None;
        }
        let twin = self.mesh.twin(h);
        self.marked_at(v).find(|&g| Some(g) != twin)
    }
}
