//! How sharp an edge is when it is not looked at too closely.

use std::collections::VecDeque;

use glam::DVec3;

use crate::engine::mesh::TriMesh;

/// Walks over the faces at one side of an edge; keeps its memory from one edge to the next.
pub(super) struct Relief<'a> {
    mesh: &'a TriMesh,
    /// Per face, the last walk that met it.
    met: Vec<u32>,
    walk: u32,
    queue: VecDeque<usize>,
}

/// Faces that a walk takes at most, the nearest by steps: a mean of so many is no better with more.
const MOST_FACES: usize = 4000;

impl<'a> Relief<'a> {
    pub(super) fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, met: vec![0; mesh.n_faces()], walk: 0, queue: VecDeque::new() }
    }

    /// Angle in radians between the mean normals of the two sides of the edge of `h`, each taken over the faces that
    /// are joined to the edge's face across unmarked edges within `reach` (at least two edge lengths) of the edge's
    /// midpoint. Ripples of a noisy surface are flat in this view, creases are not. π where a side has no mean.
    pub(super) fn angle(&mut self, h: usize, reach: f64, marked: &[bool]) -> f64 {
        let Some(t) = self.mesh.twin(h) else {
            return 0.0;
        };
        let [a, b] = [self.mesh.origin(h), self.mesh.target(h)].map(|v| self.mesh.position(v));
        let side = |h: usize| {
            let [a, b, c] = self.mesh.triangle(h / 3);
            (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0
        };
        let reach = reach.max(side(h) + side(t));
        let middle = 0.5 * (a + b);
        let (n, m) = (self.mean_normal(h / 3, middle, reach, marked), self.mean_normal(t / 3, middle, reach, marked));
        if n == DVec3::ZERO || m == DVec3::ZERO {
            return std::f64::consts::PI;
        }
        n.cross(m).length().atan2(n.dot(m))
    }

    fn mean_normal(&mut self, face: usize, middle: DVec3, reach: f64, marked: &[bool]) -> DVec3 {
        self.walk += 1;
        self.met[face] = self.walk;
        self.queue.push_back(face);
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        let mut left = MOST_FACES;
        while let Some(f) = self.queue.pop_front() {
            if left == 0 {
                self.queue.clear();
                break;
            }
            left -= 1;
            let vector = self.mesh.area_vector(f);
            sum += vector;
            area += vector.length();
            for h in (3 * f..3 * f + 3).filter(|&h| !marked[h]) {
                if let Some(g) = self.mesh.twin(h).map(|t| t / 3)
                    && self.met[g] != self.walk
                    && (self.mesh.triangle(g).iter().sum::<DVec3>() / 3.0).distance_squared(middle) < reach * reach
                {
                    self.met[g] = self.walk;
                    self.queue.push_back(g);
                }
            }
        }
        // Normals that cancel, as around a thin rod, have no mean worth speaking of.
        if sum.length() > 0.1 * area { sum.normalize() } else { DVec3::ZERO }
    }
}
