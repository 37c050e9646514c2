//! Principal curvature directions, averaged over about a quad, as guidance of the cross field.
//!
//! The curvature tensor of an edge is its signed dihedral angle times `e eᵀ/|e|` [cohen-steiner_2003]; tensors are
//! gathered at vertices and averaged over neighbours until they stand for a disk of about the radius of a quad edge, so
//! that noise below the density asked for does not steer the field.

use glam::{DMat3, DVec2, DVec3};

use crate::engine::field::frames::Frames;
use crate::engine::mesh::TriMesh;

/// Guidance of the cross field per face.
#[derive(Clone, Debug)]
pub struct Guidance {
    /// Angle of one principal direction in the frame of the face, radians.
    pub angle: Vec<f64>,
    /// Difference of the principal curvatures, in 1 / model units, not negative.
    pub anisotropy: Vec<f64>,
}

/// Principal directions averaged over a radius of about `radius` (in the frames' metric). Feature edges (`is_feature` per
/// halfedge) do not contribute: a crease is a constraint, not curvature. O(F · (radius / edge length)²).
pub fn curvature_guidance(mesh: &TriMesh, frames: &Frames, is_feature: &[bool], radius: f64) -> Guidance {
    let (tensor, area) = averaged_tensors(mesh, is_feature, radius / mean_edge_length(mesh, frames));
    let (mut angle, mut anisotropy) = (vec![0.0; mesh.n_faces()], vec![0.0; mesh.n_faces()]);
    for f in 0..mesh.n_faces() {
        let face = mesh.face(f);
        let total: f64 = face.iter().map(|&v| area[v as usize]).sum();
        if total <= 0.0 {
            continue;
        }
        let sum = face.iter().fold(DMat3::ZERO, |sum, &v| sum + tensor[v as usize]) * (1.0 / total);
        let (x, y) = (frames.x[f], frames.y[f]);
        let (a, b, c) = (x.dot(sum * x), x.dot(sum * y), y.dot(sum * y));
        let spread = DVec2::new(a - c, 2.0 * b);
        angle[f] = 0.5 * spread.y.atan2(spread.x);
        anisotropy[f] = spread.length();
    }
    Guidance { angle, anisotropy }
}

/// Per vertex the larger absolute principal curvature, averaged over a radius of about `radius` (model units).
pub(super) fn largest_curvature(mesh: &TriMesh, is_feature: &[bool], radius: f64) -> Vec<f64> {
    let lengths =
        (0..mesh.n_halfedges()).map(|h| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))));
    let edge = lengths.sum::<f64>() / mesh.n_halfedges().max(1) as f64;
    let (tensor, area) = averaged_tensors(mesh, is_feature, radius / edge);
    let curvature = |v: usize| {
        let normal: DVec3 = mesh.fan(v as u32).map(|h| mesh.area_vector(h / 3)).sum();
        let (x, y) = normal.try_normalize()?.any_orthonormal_pair();
        let sum = tensor[v] * (1.0 / area[v]);
        let (a, b, c) = (x.dot(sum * x), x.dot(sum * y), y.dot(sum * y));
        let largest = 0.5 * ((a + c).abs() + DVec2::new(a - c, 2.0 * b).length());
        largest.is_finite().then_some(largest)
    };
    (0..mesh.n_vertices()).map(|v| curvature(v).unwrap_or(0.0)).collect()
}

/// Curvature tensors at the vertices with their areas, averaged over a radius of so many edges.
fn averaged_tensors(mesh: &TriMesh, is_feature: &[bool], radius: f64) -> (Vec<DMat3>, Vec<f64>) {
    let (mut tensor, mut area) = vertex_tensors(mesh, is_feature);
    // Each averaging step over neighbours widens the kernel by about 0.7 edges (root mean square).
    let steps = (radius.powi(2) * 2.0).ceil().clamp(1.0, 40.0) as usize;
    for _ in 0..steps {
        (tensor, area) = average(mesh, &tensor, &area);
    }
    (tensor, area)
}

fn vertex_tensors(mesh: &TriMesh, is_feature: &[bool]) -> (Vec<DMat3>, Vec<f64>) {
    let mut tensor = vec![DMat3::ZERO; mesh.n_vertices()];
    let mut area = vec![0.0; mesh.n_vertices()];
    let normals: Vec<DVec3> = (0..mesh.n_faces()).map(|f| mesh.normal(f)).collect();
    for f in 0..mesh.n_faces() {
        let third = mesh.area(f) / 3.0;
        for v in mesh.face(f) {
            area[v as usize] += third;
        }
    }
    for h in 0..mesh.n_halfedges() {
        let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h) && !is_feature[h]) else { continue };
        let e = mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
        let length = e.length();
        if length <= 0.0 {
            continue;
        }
        let (n, m) = (normals[h / 3], normals[t / 3]);
        let dihedral = n.cross(m).dot(e / length).atan2(n.dot(m));
        let contribution = outer(e) * (0.5 * dihedral / length);
        for v in [mesh.origin(h), mesh.target(h)] {
            tensor[v as usize] += contribution;
        }
    }
    (tensor, area)
}

fn average(mesh: &TriMesh, tensor: &[DMat3], area: &[f64]) -> (Vec<DMat3>, Vec<f64>) {
    let (mut sum, mut weight) = (tensor.to_vec(), area.to_vec());
    for h in 0..mesh.n_halfedges() {
        let (a, b) = (mesh.origin(h) as usize, mesh.target(h) as usize);
        sum[a] += tensor[b];
        weight[a] += area[b];
        if mesh.is_boundary(h) {
            sum[b] += tensor[a];
            weight[b] += area[a];
        }
    }
    (sum, weight)
}

fn outer(e: DVec3) -> DMat3 {
    DMat3::from_cols(e * e.x, e * e.y, e * e.z)
}

/// Mean edge length in the frames' metric.
fn mean_edge_length(mesh: &TriMesh, frames: &Frames) -> f64 {
    let mut sum = 0.0;
    for h in 0..mesh.n_halfedges() {
        sum += frames.length(mesh, h);
    }
    sum / mesh.n_halfedges().max(1) as f64
}
