//! Values that a file gives to corners of polygons, at the corners of the conditioned faces.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::attributes::origin::Origin;
use crate::engine::mesh::closest_on_triangle;
use crate::engine::run::{Cancelled, RunContext};

/// Faces between two looks at the context, and corners of a polygon from which every face looks.
const STRIDE: usize = 256;

impl Origin<'_> {
    /// Per face and corner the value there; `value` gives it per corner of the soup.
    ///
    /// Faces that repairs flipped or moved have corners that are none of their polygon's. Those take the value of a
    /// neighbour's polygon at the same place, of several the one most like what their own polygon says nearest to it.
    pub(super) fn corner_values<const N: usize>(
        &self,
        ctx: &RunContext,
        value: impl Fn(usize) -> [f32; N] + Sync,
    ) -> Result<Vec<[[f32; N]; 3]>, Cancelled> {
        let of_face = |f: usize| {
            let polygon = self.polygon[f];
            if f.is_multiple_of(STRIDE) || self.soup.corners_of(polygon as usize).len() > STRIDE {
                ctx.check()?;
            }
            Ok(self.mesh.face(f).map(|v| {
                let p = self.mesh.position(v);
                self.said_at(polygon, p, &value).unwrap_or_else(|| {
                    let guess = self.nearest_in(polygon, p, &value);
                    let beside = self.mesh.fan(v).filter_map(|h| self.said_at(self.polygon[h / 3], p, &value));
                    beside.min_by(|a, b| difference(a, &guess).total_cmp(&difference(b, &guess))).unwrap_or(guess)
                })
            }))
        };
        (0..self.mesh.n_faces()).into_par_iter().map(of_face).collect()
    }

    /// The value of the polygon's corner that is exactly at `p`.
    fn said_at<T>(&self, polygon: u32, p: DVec3, value: impl Fn(usize) -> T) -> Option<T> {
        let mut corners = self.soup.corners_of(polygon as usize);
        corners.find(|&c| self.soup.positions[self.soup.indices[c] as usize] == p).map(value)
    }

    /// The value at the polygon's point nearest to `p`; the polygon is taken as a fan.
    fn nearest_in<const N: usize>(&self, polygon: u32, p: DVec3, value: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        let corners = self.soup.corners_of(polygon as usize);
        let position = |c: usize| self.soup.positions[self.soup.indices[c] as usize];
        let first = corners.start;
        let mut best = ([first; 3], [1.0, 0.0, 0.0], f64::INFINITY);
        for second in first + 1..corners.end.saturating_sub(1) {
            let triangle = [first, second, second + 1];
            let (weights, at) = closest_on_triangle(p, &triangle.map(position));
            let distance = at.distance_squared(p);
            if distance < best.2 {
                best = (triangle, weights, distance);
            }
        }
        blend(best.1, best.0.map(value))
    }
}

/// The weighted mean of three values.
pub(super) fn blend<const N: usize>(weights: [f64; 3], values: [[f32; N]; 3]) -> [f32; N] {
    std::array::from_fn(|i| (0..3).map(|k| weights[k] * f64::from(values[k][i])).sum::<f64>() as f32)
}

fn difference<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum()
}
