//! Triangles to samples: a depth buffer that remembers which triangle is in front.

use glam::DVec3;
use std::ops::Range;

/// Rows of a picture, sample by sample: which triangle is in front and how near it is.
pub(super) struct Layer {
    first_row: usize,
    width: usize,
    height: usize,
    nearness: Vec<f32>,
    id: Vec<u32>,
}

impl Layer {
    /// Nothing in front.
    pub(super) const NOTHING: u32 = u32::MAX;

    /// An empty layer of `height` rows from `first_row`.
    pub(super) fn new(first_row: usize, width: usize, height: usize) -> Self {
        let n = width * height;
        Self { first_row, width, height, nearness: vec![0.0; n], id: vec![Self::NOTHING; n] }
    }

    pub(super) fn ids(&self) -> &[u32] {
        &self.id
    }

    /// The triangle in front at a sample, `row` counted from the top of the picture.
    pub(super) fn id(&self, column: usize, row: usize) -> u32 {
        self.id[(row - self.first_row) * self.width + column]
    }

    pub(super) fn nearness(&self, column: usize, row: usize) -> f32 {
        self.nearness[(row - self.first_row) * self.width + column]
    }

    /// Draws the triangles `which`; `projected` has (column, row, nearness) per vertex.
    pub(super) fn draw(&mut self, triangles: &[[u32; 3]], projected: &[DVec3], which: impl Iterator<Item = usize>) {
        for t in which {
            let [a, b, c] = triangles[t].map(|v| projected[v as usize]);
            let doubled = (b - a).truncate().perp_dot((c - a).truncate());
            if doubled.abs() < 1e-12 || !doubled.is_finite() {
                continue;
            }
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let rows = span(low.y, high.y, self.first_row, self.height);
            let columns = span(low.x, high.x, 0, self.width);
            // Weights of b and c are linear in the picture.
            let slope = |p: DVec3, q: DVec3| ((p.y - q.y) / doubled, (q.x - p.x) / doubled);
            let (bx, by) = slope(c, a);
            let (cx, cy) = slope(a, b);
            for row in rows {
                let y = row as f64 + 0.5 - a.y;
                let line = (row - self.first_row) * self.width;
                for column in columns.clone() {
                    let x = column as f64 + 0.5 - a.x;
                    let (wb, wc) = (bx * x + by * y, cx * x + cy * y);
                    if wb < 0.0 || wc < 0.0 || wb + wc > 1.0 {
                        continue;
                    }
                    let near = (a.z + wb * (b.z - a.z) + wc * (c.z - a.z)) as f32;
                    if near > self.nearness[line + column] {
                        self.nearness[line + column] = near;
                        self.id[line + column] = t as u32;
                    }
                }
            }
        }
    }
}

/// The samples whose centres lie between two coordinates.
fn span(low: f64, high: f64, first: usize, count: usize) -> Range<usize> {
    let clamp = |x: f64| (x.clamp(first as f64, (first + count) as f64)) as usize;
    clamp((low - 0.5).ceil())..clamp((high + 0.5).floor())
}
