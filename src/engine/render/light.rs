//! How bright a point of the surface is: a warm key light, a cool fill, a rim, and the open sky that it sees.

use crate::engine::render::camera::Camera;
use crate::engine::render::raster::Layer;
use crate::engine::render::scene::Scene;
use glam::{DVec3, Vec3, dvec3, vec3};
use rayon::prelude::*;

/// Directions from which the openness of vertices is measured.
const DIRECTIONS: usize = 48;
/// Width of the depth maps.
const MAP: usize = 256;

/// The front and the back of the surface, linear.
const FRONT: Vec3 = vec3(0.84, 0.815, 0.755);
const BACK: Vec3 = vec3(0.56, 0.60, 0.68);

/// Per vertex how much of the space before it is open, 0 to 1: the share of directions, weighted by the cosine, from
/// which depth maps see it.
pub(super) fn openness(scene: &Scene) -> Vec<f32> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let seen: Vec<(DVec3, Vec<bool>)> = (0..DIRECTIONS)
        .into_par_iter()
        .map(|i| {
            let y = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
            let (r, turn) = ((1.0 - y * y).sqrt(), golden * i as f64);
            let towards = dvec3(r * turn.cos(), y, r * turn.sin());
            (towards, visible_from(scene, towards))
        })
        .collect();
    (0..scene.positions.len())
        .into_par_iter()
        .map(|v| {
            let (mut open, mut all) = (0.0, 0.0);
            for (towards, visible) in &seen {
                let weight = scene.vertex_normals[v].dot(*towards).max(0.0);
                all += weight;
                open += if visible[v] { weight } else { 0.0 };
            }
            if all > 0.0 { (open / all) as f32 } else { 1.0 }
        })
        .collect()
}

fn visible_from(scene: &Scene, towards: DVec3) -> Vec<bool> {
    let camera = Camera::new(scene, towards, towards.any_orthonormal_vector(), MAP as f64, MAP as f64);
    let projected = camera.project_all(scene, 1.0);
    let mut layer = Layer::new(0, MAP, MAP);
    layer.draw(&scene.triangles, &projected, 0..scene.triangles.len());
    let lift = 0.02 * scene.radius;
    let sees = |v: usize| {
        let p = scene.positions[v] + lift * (scene.vertex_normals[v] + towards);
        let at = camera.project(p);
        if !at.is_finite() || at.x < 0.0 || at.y < 0.0 || at.x >= MAP as f64 || at.y >= MAP as f64 {
            return true;
        }
        layer.nearness(at.x as usize, at.y as usize) <= at.z as f32
    };
    (0..scene.positions.len()).map(sees).collect()
}

/// The colour of a surface point, linear: `normal` is the outside's, `towards` points to the viewer.
pub(super) fn shade(camera: &Camera, normal: DVec3, is_front: bool, towards: DVec3, openness: f32) -> Vec3 {
    let n = if is_front { normal } else { -normal };
    let key = (camera.back * 0.62 + camera.up * 0.62 - camera.right * 0.48).normalize();
    let fill = (camera.back * 0.55 - camera.up * 0.1 + camera.right * 0.83).normalize();
    let wrap = |l: DVec3, w: f64| ((n.dot(l) + w) / (1.0 + w)).max(0.0) as f32;
    let sky = 0.5 + 0.5 * n.dot(camera.up) as f32;
    let open = openness * openness.sqrt();
    let half = (key + towards).normalize_or_zero();
    let gloss = 0.10 * n.dot(half).max(0.0).powi(40) as f32;
    let rim = (1.0 - n.dot(towards).max(0.0)).powi(4) as f32;
    let light = vec3(1.0, 0.965, 0.91) * (0.81 * wrap(key, 0.12)) * (0.45 + 0.55 * open)
        + vec3(0.75, 0.85, 1.0) * (0.24 * wrap(fill, 0.3)) * open
        + (vec3(0.86, 0.92, 1.0) * sky + vec3(0.80, 0.76, 0.72) * (1.0 - sky)) * (0.31 * open);
    let albedo = if is_front { FRONT } else { BACK };
    albedo * light + Vec3::splat(gloss * open + 0.06 * rim * open)
}
