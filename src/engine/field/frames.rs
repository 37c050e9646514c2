//! An orthonormal frame per face, the angles between the frames of neighbours, and lengths as the field measures them.
//!
//! Where quads are to vary in size, the field and the map live in the metric in which all of them are equal: lengths
//! are divided by the local size, per edge by the geometric mean of its ends' sizes `[springborn_2008]`. Such a metric
//! is given by edge lengths alone, and its curvature puts the branch points where the grading needs them.

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
    /// The metric, if it is not that of the mesh.
    scaled: Option<Scaled>,
}

/// A metric other than that of the mesh.
#[derive(Clone, Debug)]
struct Scaled {
    /// Per halfedge its vector in the frame of its face.
    edge: Vec<DVec2>,
    /// Per vertex the length that is one unit here.
    size: Vec<f64>,
}

/// A scaled triangle keeps at least this share of its shape (area over squared sides), or it is scaled as a whole.
const MIN_SHAPE: f64 = 0.4;

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
        Self { x, y, angle, scaled: None }
    }

    /// Frames in the metric in which quads of varying size are equal. `log_size` is the logarithm of the wanted size
    /// per vertex, relative to that of the whole; empty if all are to be alike.
    pub fn scaled(mesh: &TriMesh, log_size: &[f64]) -> Self {
        let mut frames = Self::new(mesh);
        if log_size.is_empty() {
            return frames;
        }
        let mut edge = Vec::with_capacity(mesh.n_halfedges());
        for f in 0..mesh.n_faces() {
            let sides = scaled_sides(mesh, &frames, f, log_size);
            for (k, side) in sides.iter().enumerate() {
                frames.angle[3 * f + k] = if k == 0 { 0.0 } else { side.y.atan2(side.x) };
            }
            edge.extend(sides);
        }
        frames.scaled = Some(Scaled { edge, size: log_size.iter().map(|l| l.exp()).collect() });
        frames
    }

    /// The same charts with the sides of each face as a map sees them whose gradients are given there: what the face is to
    /// look like in the map. Sides of neighbours need not fit together.
    pub fn seen_by(&self, mesh: &TriMesh, gradients: &[[DVec2; 2]]) -> Self {
        let seen = |h: usize| {
            let ([u, v], side) = (gradients[h / 3], self.edge(mesh, h));
            DVec2::new(u.dot(side), v.dot(side))
        };
        let edge = (0..mesh.n_halfedges()).map(seen).collect();
        Self { scaled: Some(Scaled { edge, size: vec![1.0; mesh.n_vertices()] }), ..self.clone() }
    }

    /// Coordinates of a vector in the frame of face `f`.
    #[inline]
    pub fn coordinates(&self, f: usize, vector: DVec3) -> DVec2 {
        DVec2::new(vector.dot(self.x[f]), vector.dot(self.y[f]))
    }

    /// The vector with these coordinates in the frame of face `f`.
    #[inline]
    pub fn vector(&self, f: usize, coordinates: DVec2) -> DVec3 {
        self.x[f] * coordinates.x + self.y[f] * coordinates.y
    }

    /// Halfedge `h` in the frame of its face, as long as the metric has it.
    #[inline]
    pub fn edge(&self, mesh: &TriMesh, h: usize) -> DVec2 {
        match &self.scaled {
            Some(scaled) => scaled.edge[h],
            None => self.coordinates(h / 3, mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h))),
        }
    }

    /// Length of halfedge `h` in the metric.
    #[inline]
    pub fn length(&self, mesh: &TriMesh, h: usize) -> f64 {
        match &self.scaled {
            Some(scaled) => scaled.edge[h].length(),
            None => mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))),
        }
    }

    /// Area of face `f` in the metric.
    #[inline]
    pub fn area(&self, mesh: &TriMesh, f: usize) -> f64 {
        match &self.scaled {
            Some(scaled) => 0.5 * scaled.edge[3 * f].perp_dot(scaled.edge[3 * f + 1]),
            None => mesh.area(f),
        }
    }

    /// Area of all faces in the metric.
    pub fn total_area(&self, mesh: &TriMesh) -> f64 {
        match &self.scaled {
            Some(_) => (0..mesh.n_faces()).map(|f| self.area(mesh, f)).sum(),
            None => mesh.total_area(),
        }
    }

    /// Scalar products of the sides of face `f` in the metric, for the pairs (0, 0), (1, 1), (2, 2), (0, 1), (1, 2),
    /// (2, 0).
    pub fn side_products(&self, mesh: &TriMesh, f: usize) -> [f64; 6] {
        const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        match &self.scaled {
            Some(scaled) => PAIRS.map(|(i, j)| scaled.edge[3 * f + i].dot(scaled.edge[3 * f + j])),
            None => {
                let [a, b, c] = mesh.triangle(f);
                let e = [b - a, c - b, a - c];
                PAIRS.map(|(i, j)| e[i].dot(e[j]))
            }
        }
    }

    /// Model units per unit of the metric at vertex `v`.
    #[inline]
    pub fn size(&self, v: u32) -> f64 {
        self.scaled.as_ref().map_or(1.0, |scaled| scaled.size[v as usize])
    }

    /// The angle to add to a direction's angle when it is transported across `h` to the frame of the twin's face; 0 on
    /// the boundary.
    #[inline]
    pub fn transport(&self, mesh: &TriMesh, h: usize) -> f64 {
        mesh.twin(h).map_or(0.0, |t| self.angle[t] + PI - self.angle[h])
    }
}

/// The sides of face `f` in the scaled metric, the first along the first axis.
fn scaled_sides(mesh: &TriMesh, frames: &Frames, f: usize, log_size: &[f64]) -> [DVec2; 3] {
    let own = [0, 1, 2].map(|k| frames.edge(mesh, 3 * f + k));
    let log = mesh.face(f).map(|v| log_size[v as usize]);
    let length = [0, 1, 2].map(|k| own[k].length() * (-0.5 * (log[k] + log[(k + 1) % 3])).exp());
    // The third side by the law of cosines.
    let [a, b, c] = length;
    let along = (a * a + c * c - b * b) / (2.0 * a);
    let up = (c * c - along * along).max(0.0).sqrt();
    let sides = [DVec2::new(a, 0.0), DVec2::new(along - a, up), DVec2::new(-along, -up)];
    let shape = |s: &[DVec2; 3]| s[0].perp_dot(s[1]) / s.iter().map(|e| e.length_squared()).sum::<f64>();
    if shape(&sides) >= MIN_SHAPE * shape(&own) {
        return sides;
    }
    // Thin triangles may have no such lengths, or hardly.
    let scale = (-(log[0] + log[1] + log[2]) / 3.0).exp();
    own.map(|e| e * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::prev;
    use crate::engine::mesh::shapes::sample_surface;
    use std::f64::consts::TAU;

    /// 2π less the angles around an interior vertex.
    fn defect(mesh: &TriMesh, frames: &Frames, v: u32) -> f64 {
        let corner = |h: usize| PI - (frames.angle[h] - frames.angle[prev(h)]).rem_euclid(TAU);
        TAU - mesh.fan(v).map(corner).sum::<f64>()
    }

    #[test]
    fn one_size_for_all_only_scales() {
        let mesh = sample_surface("genus2", 2000).unwrap().mesh;
        let (plain, scaled) = (Frames::new(&mesh), Frames::scaled(&mesh, &vec![2f64.ln(); mesh.n_vertices()]));
        assert!((4.0 * scaled.total_area(&mesh) / mesh.total_area() - 1.0).abs() < 1e-12);
        for h in 0..mesh.n_halfedges() {
            assert!((plain.angle[h] - scaled.angle[h]).abs() < 1e-9);
            assert!((2.0 * scaled.edge(&mesh, h)).distance(plain.edge(&mesh, h)) < 1e-9);
        }
    }

    #[test]
    fn curvature_comes_where_the_sizes_are_not_harmonic() {
        // K' dA' = K dA + Δ(log size) dA, on a half cylinder, which is flat.
        let mesh = sample_surface("half_pipe", 6000).unwrap().mesh;
        let curved = |size: &dyn Fn(f64) -> f64| {
            let log_size: Vec<f64> = mesh.positions().iter().map(|p| size(p.y)).collect();
            let frames = Frames::scaled(&mesh, &log_size);
            let inner = (0..mesh.n_vertices() as u32).filter(|&v| !mesh.is_boundary_vertex(v));
            let (mut sum, mut area) = (0.0, 0.0);
            for v in inner {
                sum += defect(&mesh, &frames, v);
                area += mesh.fan(v).map(|h| mesh.area(h / 3)).sum::<f64>() / 3.0;
            }
            sum / area
        };
        assert!(curved(&|y| 0.2 * y).abs() < 2e-3, "{}", curved(&|y| 0.2 * y));
        assert!((curved(&|y| 0.1 * y * y) / 0.2 - 1.0).abs() < 0.02, "{}", curved(&|y| 0.1 * y * y));
    }
}
