//! Values that a file gives to corners of polygons, at the corners of the conditioned faces.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::attributes::origin::Origin;
use crate::engine::mesh::Influences;
use crate::engine::mesh::closest_on_triangle;
use crate::engine::run::{Cancelled, RunContext};

/// Faces between two looks at the context, and corners of a polygon from which every face looks.
const STRIDE: usize = 256;

impl Origin<'_> {
    /// Per face and corner the value there; `value` gives it per corner of the soup.
    ///
    /// Faces that repairs flipped or moved have corners that are none of their polygon's. Those take the value of a
    /// neighbour's polygon at the same place, of several the one most like what their own polygon says nearest to it.
    pub(super) fn corner_values<T: CornerValue>(
        &self,
        ctx: &RunContext,
        value: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<[T; 3]>, Cancelled> {
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
                    beside.min_by(|a, b| a.difference(&guess).total_cmp(&b.difference(&guess))).unwrap_or(guess)
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
    fn nearest_in<T: CornerValue>(&self, polygon: u32, p: DVec3, value: impl Fn(usize) -> T) -> T {
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
        T::blend(best.1, best.0.map(value))
    }
}

/// What a corner may say.
pub(super) trait CornerValue: Copy + Send + Sync {
    /// The weighted mean of three values.
    fn blend(weights: [f64; 3], values: [Self; 3]) -> Self;

    /// How unlike two values are, 0 for equals.
    fn difference(&self, other: &Self) -> f32;
}

impl<const N: usize> CornerValue for [f32; N] {
    fn blend(weights: [f64; 3], values: [Self; 3]) -> Self {
        std::array::from_fn(|i| (0..3).map(|k| weights[k] * f64::from(values[k][i])).sum::<f64>() as f32)
    }

    fn difference(&self, other: &Self) -> f32 {
        self.iter().zip(other).map(|(a, b)| (a - b).abs()).sum()
    }
}

impl CornerValue for Influences {
    fn blend(weights: [f64; 3], values: [Self; 3]) -> Self {
        Self::blend(weights, values)
    }

    fn difference(&self, other: &Self) -> f32 {
        self.difference(other) as f32
    }
}
