//! An orthonormal frame per face and the angles between the frames of neighbours.

use std::f64::consts::PI;

use crate::engine::mesh::TriMesh;
use glam::{DVec2, DVec3};

/// Per face the frame (unit edge 0, normal × unit edge 0); per halfedge its angle in the frame of its face.
#[derive(Clone, Debug)]
pub struct Frames {
    /// First axis per face, a unit vector.
    pub x: Vec<DVec3>,
    /// Second axis per face, a unit vector.
    pub y: Vec<DVec3>,
    /// Angle of each halfedge in the frame of its face, radians.
    pub angle: Vec<f64>,
}

impl Frames {
    /// Frames of all faces. Faces need not have area: a face without a normal gets an arbitrary frame.
    pub fn new(mesh: &TriMesh) -> Self {
        let n = mesh.n_faces();
        let (mut x, mut y, mut angle) = (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(3 * n));
        for f in 0..n {
            let [a, b, c] = mesh.triangle(f);
            let first = (b - a).try_normalize().unwrap_or(DVec3::X);
            let normal = mesh.area_vector(f).try_normalize().unwrap_or_else(|| first.any_orthonormal_vector());
            let second = normal.cross(first);
            x.push(first);
            y.push(second);
            angle.push(0.0);
            for e in [c - b, a - c] {
                angle.push(e.dot(second).atan2(e.dot(first)));
            }
        }
        Self { x, y, angle }
    }

    /// Coordinates of a vector in the frame of face `f`.
    pub fn coordinates(&self, f: usize, vector: DVec3) -> DVec2 {
        DVec2::new(vector.dot(self.x[f]), vector.dot(self.y[f]))
    }

    /// The vector with these coordinates in the frame of face `f`.
    pub fn vector(&self, f: usize, coordinates: DVec2) -> DVec3 {
        self.x[f] * coordinates.x + self.y[f] * coordinates.y
    }

    /// The angle to add to a direction's angle when it is transported across `h` to the frame of the twin's face; 0 on
    /// the boundary.
    pub fn transport(&self, mesh: &TriMesh, h: usize) -> f64 {
        mesh.twin(h).map_or(0.0, |t| self.angle[t] + PI - self.angle[h])
    }
}
