//! Where the picture is taken from.

use crate::engine::render::raster::Layer;
use crate::engine::render::scene::Scene;
use glam::{DVec2, DVec3, dvec2, dvec3};
use rayon::prelude::*;

/// The side from which the model is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// The three-quarter view, out of a fixed set, that shows most quads.
    #[default]
    Auto,
    /// From this direction of the model, with this direction upwards; both need not be of unit length.
    From {
        /// From the model to the viewer.
        towards: DVec3,
        /// What shall point upwards in the picture.
        up: DVec3,
    },
}

/// Half the opening angle as a tangent: a long lens.
const LENS: f64 = 0.24;
/// Empty margin on every side, relative to the picture.
const MARGIN: f64 = 0.05;

/// A pinhole camera that frames a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    eye: DVec3,
    pub(super) right: DVec3,
    pub(super) up: DVec3,
    pub(super) back: DVec3,
    scale: f64,
    shift: DVec2,
}

impl Camera {
    /// A camera on the side `towards`, framing the scene in a picture of `width` × `height`.
    pub(super) fn new(scene: &Scene, towards: DVec3, up: DVec3, width: f64, height: f64) -> Self {
        let back = towards.try_normalize().unwrap_or(DVec3::Z);
        let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
        let up = back.cross(right);
        let eye = scene.centre + back * (scene.radius / LENS);
        let mut camera = Self { eye, right, up, back, scale: 1.0, shift: DVec2::ZERO };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &p in scene.positions.iter().filter(|p| p.is_finite()) {
            let at = camera.project(p).truncate();
            low = low.min(at);
            high = high.max(at);
        }
        let room = dvec2(width, height) * (1.0 - 2.0 * MARGIN);
        let size = (high - low).max(DVec2::splat(1e-12));
        camera.scale = (room.x / size.x).min(room.y / size.y);
        let middle = 0.5 * (low + high);
        camera.shift = dvec2(0.5 * width, 0.5 * height) - camera.scale * middle;
        camera
    }

    /// Pixel coordinates with y downwards, and the nearness, which is linear over the picture of a plane.
    pub(super) fn project(&self, p: DVec3) -> DVec3 {
        let q = p - self.eye;
        let nearness = -1.0 / q.dot(self.back);
        let (x, y) = (q.dot(self.right) * nearness, -q.dot(self.up) * nearness);
        dvec3(self.scale * x + self.shift.x, self.scale * y + self.shift.y, nearness)
    }

    /// All vertices of the scene, with coordinates times `samples`; far away where they are not finite.
    pub(super) fn project_all(&self, scene: &Scene, samples: f64) -> Vec<DVec3> {
        scene.positions.par_iter().map(|&p| self.project(p) * dvec3(samples, samples, 1.0)).collect()
    }

    /// Unit vector from a point to the viewer.
    pub(super) fn towards(&self, p: DVec3) -> DVec3 {
        (self.eye - p).normalize_or_zero()
    }

    /// Pixels per model unit at nearness `nearness`.
    pub(super) fn pixels_per_unit(&self, nearness: f64) -> f64 {
        self.scale * nearness
    }
}

/// The camera of a view.
pub(super) fn frame(scene: &Scene, view: View, width: f64, height: f64) -> Camera {
    let View::Auto = view else {
        let View::From { towards, up } = view else { unreachable!("a view is automatic or given") };
        return Camera::new(scene, towards, up, width, height);
    };
    let mut candidates = Vec::new();
    // The second number says how well such a view is liked, all else equal.
    for (elevation, liked) in [(22.0f64, 1.0), (38.0, 0.97), (55.0, 0.9)] {
        for (azimuth, side) in
            [(35.0f64, 1.0), (-35.0, 0.99), (60.0, 0.95), (-60.0, 0.94), (145.0, 0.88), (-145.0, 0.87)]
        {
            let (e, a) = (elevation.to_radians(), azimuth.to_radians());
            candidates.push((dvec3(e.cos() * a.sin(), e.sin(), e.cos() * a.cos()), liked * side));
        }
    }
    let small = 180usize;
    let score = |&(towards, liked): &(DVec3, f64)| {
        let camera = Camera::new(scene, towards, DVec3::Y, small as f64, small as f64);
        let mut layer = Layer::new(0, small, small);
        layer.draw(&scene.triangles, &camera.project_all(scene, 1.0), 0..scene.triangles.len());
        let mut seen: Vec<u32> = layer.ids().iter().filter(|&&id| id != Layer::NOTHING).map(|id| id / 2).collect();
        let filled = seen.len() as f64 / (small * small) as f64;
        seen.sort_unstable();
        seen.dedup();
        liked * (seen.len() as f64 / scene.quads.len().max(1) as f64 + 0.5 * filled)
    };
    let scores: Vec<f64> = candidates.par_iter().map(score).collect();
    let best = (0..scores.len()).fold(0, |best, i| if scores[i] > scores[best] { i } else { best });
    Camera::new(scene, candidates[best].0, DVec3::Y, width, height)
}
