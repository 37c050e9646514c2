//! Strokes: lines drawn on the surface that the cross field is to follow.

use faer::c64;
use glam::DVec3;

use crate::engine::field::frames::Frames;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriMesh;

/// Length between samples of a stroke, in quad edges.
const SAMPLE: f64 = 0.1;
/// A stroke acts on a surface within this many quad edges of it …
const REACH: f64 = 0.5;
/// … and there on faces within so many.
const BREADTH: f64 = 0.75;
/// Most samples of one segment: strokes far longer than the surface have nothing to say.
const MAX_SAMPLES: f64 = 1e5;

/// Directions along strokes per face.
#[derive(Clone, Debug)]
pub struct StrokeGuidance {
    /// Per face `e^{4iθ}` of the strokes near it, in the frame of the face; 0 where there is none.
    pub(super) cross: Vec<c64>,
}

impl StrokeGuidance {
    /// Whether the field follows a stroke on face `f`.
    pub fn is_near(&self, f: usize) -> bool {
        self.cross[f] != c64::new(0.0, 0.0)
    }
}

/// Points along strokes (polylines in model units) with the directions there, `SAMPLE` quad edges apart.
fn samples(strokes: &[Vec<DVec3>], edge_length: f64) -> impl Iterator<Item = (usize, DVec3, DVec3)> + '_ {
    let segments = strokes.iter().enumerate().flat_map(|(s, line)| line.windows(2).map(move |w| (s, w[0], w[1])));
    segments.flat_map(move |(s, a, b)| {
        let n = (a.distance(b) / (SAMPLE * edge_length)).ceil().min(MAX_SAMPLES) as usize;
        let at = move |k: usize| (s, a.lerp(b, (k as f64 + 0.5) / n as f64), b - a);
        (0..n).map(at)
    })
}

/// Directions of the faces beneath strokes and next to them. A face that several strokes pass gets their mean as crosses.
pub fn stroke_guidance(
    mesh: &TriMesh,
    frames: &Frames,
    strokes: &[Vec<DVec3>],
    edge_length: f64,
) -> Option<StrokeGuidance> {
    if strokes.is_empty() {
        return None;
    }
    let index = SurfaceIndex::new(mesh);
    let mut cross = vec![c64::new(0.0, 0.0); mesh.n_faces()];
    for (_, p, along) in samples(strokes, edge_length) {
        let Some(at) = index.closest_where(p, REACH * edge_length, |_| true) else { continue };
        for (f, distance) in faces_around(mesh, at.face, at.position, BREADTH * edge_length) {
            let direction = frames.coordinates(f, along);
            // Not around sharp bends, where the stroke's direction says nothing.
            if direction.length_squared() > 0.25 * along.length_squared() {
                let angle = 4.0 * direction.to_angle();
                cross[f] += c64::new(angle.cos(), angle.sin()) * (1.01 - distance / (BREADTH * edge_length));
            }
        }
    }
    Some(StrokeGuidance { cross })
}

/// Faces connected to `start` whose centres are within `radius` of `p`, with their distances; `start` in any case.
fn faces_around(mesh: &TriMesh, start: u32, p: DVec3, radius: f64) -> Vec<(usize, f64)> {
    let distance = |f: usize| {
        let [a, b, c] = mesh.triangle(f);
        p.distance((a + b + c) / 3.0)
    };
    let mut found = vec![(start as usize, distance(start as usize).min(radius))];
    let mut k = 0;
    while k < found.len() {
        let f = found[k].0;
        for t in (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)).map(|t| t / 3) {
            let d = distance(t);
            if d < radius && found.iter().all(|g| g.0 != t) {
                found.push((t, d));
            }
        }
        k += 1;
    }
    found
}

/// The strokes that no part of the surface is near to, in order.
pub fn strokes_off_surface(mesh: &TriMesh, strokes: &[Vec<DVec3>], edge_length: f64) -> Vec<usize> {
    if strokes.is_empty() {
        return Vec::new();
    }
    let index = SurfaceIndex::new(mesh);
    let mut is_off = vec![true; strokes.len()];
    for (s, p, _) in samples(strokes, edge_length) {
        is_off[s] = is_off[s] && index.closest_where(p, REACH * edge_length, |_| true).is_none();
    }
    (0..strokes.len()).filter(|&s| is_off[s]).collect()
}
