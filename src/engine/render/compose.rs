//! The picture: bands of rows, drawn in parallel, averaged from several samples per pixel.

use crate::engine::quad::QuadMesh;
use crate::engine::render::camera::{Camera, View, frame};
use crate::engine::render::light::{openness, shade};
use crate::engine::render::raster::Layer;
use crate::engine::render::scene::Scene;
use glam::{DVec2, DVec3, Vec3, dvec2, vec3};
use rayon::prelude::*;

/// Samples per pixel in each direction.
const SAMPLES: usize = 3;
/// Rows of pixels per band.
const BAND: usize = 32;

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Red, green, blue, alpha (always 255) per pixel, sRGB, row by row from the top.
    pub rgba: Vec<u8>,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Width in pixels, clamped to 16 to 4096.
    pub width: usize,
    /// Height in pixels, clamped to 16 to 4096.
    pub height: usize,
    /// The side it is taken from.
    pub view: View,
    /// Whether irregular interior vertices are marked: blue for valence 3, orange for 5, violet for 2, crimson above.
    pub mark_irregular: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { width: 1200, height: 1200, view: View::Auto, mark_irregular: true }
    }
}

/// All that a band needs.
struct Stage<'a> {
    scene: &'a Scene,
    camera: Camera,
    /// Vertices in samples.
    projected: Vec<DVec3>,
    openness: Vec<f32>,
    discs: Vec<Disc>,
    width: usize,
    height: usize,
    /// Half width of lines in pixels and how dark they are.
    line: (f64, f32),
}

struct Disc {
    centre: DVec2,
    radius: f64,
    /// It is hidden where something is nearer than this.
    nearness: f32,
    colour: Vec3,
}

/// Draws the quads.
///
/// ```
/// use glam::DVec3;
/// use quadrille::engine::{quad::QuadMesh, render::{RenderOptions, render_quads}};
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let quads = QuadMesh { positions, quads: vec![[0, 1, 2, 3]] };
/// let image = render_quads(&quads, &RenderOptions { width: 32, height: 16, ..RenderOptions::default() });
/// assert_eq!(image.rgba.len(), 4 * 32 * 16);
/// ```
pub fn render_quads(quads: &QuadMesh, options: &RenderOptions) -> Image {
    let (width, height) = (options.width.clamp(16, 4096), options.height.clamp(16, 4096));
    let scene = Scene::new(quads);
    let camera = frame(&scene, options.view, width as f64, height as f64);
    let middle = camera.project(scene.centre).z;
    let quad_size = scene.mean_edge * camera.pixels_per_unit(middle);
    let fine = (width.min(height) as f64 / 1200.0).max(0.35);
    let line =
        ((0.03 * quad_size).clamp(0.5, 1.15) * fine.max(0.6), ((quad_size - 1.0) / 7.0).clamp(0.12, 0.85) as f32);
    let discs = if options.mark_irregular { discs(&scene, &camera, quad_size, fine) } else { Vec::new() };
    let projected = camera.project_all(&scene, SAMPLES as f64);
    let stage = Stage { openness: openness(&scene), scene: &scene, camera, projected, discs, width, height, line };
    let bands = bucket(&stage);
    let rgba = bands.par_iter().enumerate().map(|(i, triangles)| stage.band(i, triangles)).flatten_iter().collect();
    Image { width, height, rgba }
}

/// Per band the triangles that meet it.
fn bucket(stage: &Stage) -> Vec<Vec<u32>> {
    let n = stage.height.div_ceil(BAND);
    let mut bands = vec![Vec::new(); n];
    let rows = (BAND * SAMPLES) as f64;
    for (t, triangle) in (0u32..).zip(&stage.scene.triangles) {
        let y = triangle.map(|v| stage.projected[v as usize].y / rows);
        let (low, high) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
        if high >= 0.0 && low < n as f64 {
            for band in &mut bands[low.max(0.0) as usize..=(high as usize).min(n - 1)] {
                band.push(t);
            }
        }
    }
    bands
}

/// Discs at the irregular vertices that face the viewer, the farthest first.
fn discs(scene: &Scene, camera: &Camera, quad_size: f64, fine: f64) -> Vec<Disc> {
    // Few discs may stand out beyond their quads; many must not hide them.
    let is_rare = 40 * scene.irregular.len() < scene.positions.len();
    let least = if is_rare { 4.5 } else { 1.5 } * fine;
    let radius = (0.24 * quad_size).clamp(least, 9.0 * fine);
    let facing = |&&(v, _): &&(u32, usize)| {
        let p = scene.positions[v as usize];
        scene.vertex_normals[v as usize].dot(camera.towards(p)) > -0.05
    };
    let disc = |&(v, valence): &(u32, usize)| {
        let p = scene.positions[v as usize];
        let at = camera.project(p);
        let lifted = camera.project(p + camera.towards(p) * (0.45 * scene.mean_edge));
        let colour = match valence {
            0..=2 => vec3(0.24, 0.10, 0.58),
            3 => vec3(0.02, 0.21, 0.76),
            5 => vec3(0.92, 0.17, 0.02),
            _ => vec3(0.56, 0.01, 0.22),
        };
        Disc { centre: at.truncate(), radius, nearness: lifted.z as f32, colour }
    };
    let mut discs: Vec<Disc> = scene.irregular.iter().filter(facing).map(disc).collect();
    discs.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
    discs
}

impl Stage<'_> {
    /// The bytes of one band.
    fn band(&self, band: usize, triangles: &[u32]) -> Vec<u8> {
        let (first, last) = (band * BAND, ((band + 1) * BAND).min(self.height));
        let mut layer = Layer::new(first * SAMPLES, self.width * SAMPLES, (last - first) * SAMPLES);
        layer.draw(&self.scene.triangles, &self.projected, triangles.iter().map(|&t| t as usize));
        let reach =
            |d: &&Disc| d.centre.y + d.radius + 2.0 >= first as f64 && d.centre.y - d.radius - 2.0 <= last as f64;
        let discs: Vec<&Disc> = self.discs.iter().filter(reach).collect();
        let mut pixels: Vec<Vec3> = Vec::with_capacity((last - first) * self.width);
        for row in first..last {
            for column in 0..self.width {
                pixels.push(self.pixel(&layer, column, row));
            }
        }
        for disc in discs {
            self.stamp(disc, &layer, first, last, &mut pixels);
        }
        pixels.into_iter().flat_map(encode).collect()
    }

    /// The mean of a pixel's samples. Where one quad fills it, one sample is enough: lines are smooth by themselves.
    fn pixel(&self, layer: &Layer, column: usize, row: usize) -> Vec3 {
        let (c, r) = (column * SAMPLES, row * SAMPLES);
        let id = |i: usize| layer.id(c + i % SAMPLES, r + i / SAMPLES);
        let centre = id(SAMPLES * SAMPLES / 2);
        let quad = |id: u32| if id == Layer::NOTHING { id } else { id / 2 };
        let at = |x: f64, y: f64, id: u32| {
            if id == Layer::NOTHING { self.background(row) } else { self.surface(id as usize, dvec2(x, y)) }
        };
        if (0..SAMPLES * SAMPLES).all(|i| quad(id(i)) == quad(centre)) {
            return at(column as f64 + 0.5, row as f64 + 0.5, centre);
        }
        let mut sum = Vec3::ZERO;
        for i in 0..SAMPLES * SAMPLES {
            let (x, y) = (c + i % SAMPLES, r + i / SAMPLES);
            sum += at((x as f64 + 0.5) / SAMPLES as f64, (y as f64 + 0.5) / SAMPLES as f64, id(i));
        }
        sum / (SAMPLES * SAMPLES) as f32
    }

    fn background(&self, row: usize) -> Vec3 {
        let t = row as f32 / self.height as f32;
        vec3(0.965, 0.970, 0.980).lerp(vec3(0.79, 0.815, 0.855), t * t)
    }

    /// The colour of triangle `t` at a point of the picture: light, then lines.
    fn surface(&self, t: usize, at: DVec2) -> Vec3 {
        let (scene, quad) = (self.scene, &self.scene.quads[t / 2]);
        let triangle = scene.triangles[t];
        let corner = |v: u32| quad.iter().position(|&w| w == v).unwrap_or(0);
        let [a, b, c] = triangle.map(|v| self.projected[v as usize].truncate() / SAMPLES as f64);
        let doubled = (b - a).perp_dot(c - a);
        let wb = (at - a).perp_dot(c - a) / doubled;
        let wc = (b - a).perp_dot(at - a) / doubled;
        let weights = [1.0 - wb - wc, wb, wc].map(|w| w.clamp(0.0, 1.0));
        let (mut normal, mut position, mut open) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (v, w) in triangle.into_iter().zip(weights) {
            normal += w * scene.normals[t / 2][corner(v)];
            position += w * scene.positions[v as usize];
            open += w as f32 * self.openness[v as usize];
        }
        // The picture's y axis points down: counter-clockwise outside looks clockwise.
        let is_front = doubled < 0.0;
        let base = shade(&self.camera, normal.normalize_or_zero(), is_front, self.camera.towards(position), open);
        base.lerp(vec3(0.012, 0.016, 0.030), self.ink(t / 2, at))
    }

    /// How much of a line covers a point of quad `q`.
    fn ink(&self, q: usize, at: DVec2) -> f32 {
        let corners = self.scene.quads[q].map(|v| self.projected[v as usize].truncate() / SAMPLES as f64);
        let (half, dark) = self.line;
        let mut ink = 0f32;
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let s = ((at - a).dot(b - a) / a.distance_squared(b).max(1e-12)).clamp(0.0, 1.0);
            let strong = self.scene.is_strong[q][k];
            let width = if strong { 1.7 * half } else { half };
            let cover = (width + 0.5 - at.distance(a.lerp(b, s))).clamp(0.0, 1.0) as f32;
            ink = ink.max(cover * if strong { dark.max(0.5) } else { dark });
        }
        ink
    }

    fn stamp(&self, disc: &Disc, layer: &Layer, first: usize, last: usize, pixels: &mut [Vec3]) {
        let outer = disc.radius + 1.0;
        let clamp = |x: f64, low: usize, high: usize| x.clamp(low as f64, high as f64) as usize;
        let rows = clamp(disc.centre.y - outer, first, last)..clamp(disc.centre.y + outer + 1.0, first, last);
        let columns = clamp(disc.centre.x - outer, 0, self.width)..clamp(disc.centre.x + outer + 1.0, 0, self.width);
        for row in rows {
            for column in columns.clone() {
                let offset = dvec2(column as f64 + 0.5, row as f64 + 0.5) - disc.centre;
                let cover = (disc.radius + 0.5 - offset.length()).clamp(0.0, 1.0) as f32;
                if cover == 0.0 {
                    continue;
                }
                let open = (0..SAMPLES * SAMPLES)
                    .filter(|i| {
                        let (x, y) = (column * SAMPLES + i % SAMPLES, row * SAMPLES + i / SAMPLES);
                        layer.nearness(x, y) <= disc.nearness
                    })
                    .count();
                let rim = (offset.length() - disc.radius * 0.78 + 0.5).clamp(0.0, 1.0) as f32;
                let shine = (1.0 - (offset + DVec2::splat(0.35 * disc.radius)).length() / disc.radius).max(0.0) as f32;
                let inner = disc.colour.lerp(Vec3::ONE, 0.35 * shine);
                let colour = inner.lerp(disc.colour * 0.12, rim * 0.9);
                let pixel = &mut pixels[(row - first) * self.width + column];
                *pixel = pixel.lerp(colour, cover * open as f32 / (SAMPLES * SAMPLES) as f32);
            }
        }
    }
}

/// Linear light to sRGB bytes.
fn encode(colour: Vec3) -> [u8; 4] {
    let byte = |x: f32| {
        let x = x.clamp(0.0, 1.0);
        let s = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * s + 0.5) as u8
    };
    [byte(colour.x), byte(colour.y), byte(colour.z), 255]
}
