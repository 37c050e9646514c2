//! Planes across an axis, and what is the image of what.

use glam::DVec3;

/// The plane on which one coordinate has one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::engine::pipeline) struct Mirror {
    /// 0, 1 or 2.
    pub(in crate::engine::pipeline) axis: usize,
    /// The value: a multiple of `quantum`.
    pub(in crate::engine::pipeline) at: f64,
    /// A power of two. Of all its multiples near the model, images are exact, in files of single precision too where
    /// the model is not far from the origin.
    pub(in crate::engine::pipeline) quantum: f64,
}

/// Models further from the origin than this, in diagonals, would suffer from single precision.
const FARTHEST: f64 = 60.0;
/// Room for quads that bulge out of the model.
const ROOM: f64 = 1.1;

impl Mirror {
    /// The plane near `at` for a model with these bounds.
    pub(super) fn new(axis: usize, at: f64, [lo, hi]: [DVec3; 2]) -> Self {
        let (lo, hi, diagonal) = (lo[axis], hi[axis], (hi - lo).length());
        let most = [lo, hi, 2.0 * at - lo, 2.0 * at - hi].map(f64::abs).into_iter().fold(0.0, f64::max);
        let bits = if most < FARTHEST * diagonal { 24 } else { 53 };
        let quantum = (ROOM * most.max(f64::MIN_POSITIVE)).log2().ceil().exp2() / f64::from(bits).exp2();
        Self { axis, at: (at / quantum).round() * quantum, quantum }
    }

    /// How far `p` is on the side that is kept.
    pub(super) fn side(self, p: DVec3) -> f64 {
        p[self.axis] - self.at
    }

    /// The mirror image of a point.
    pub(super) fn image(self, mut p: DVec3) -> DVec3 {
        p[self.axis] = 2.0 * self.at - p[self.axis];
        p
    }

    /// The point of the plane next to `p`.
    pub(super) fn foot(self, mut p: DVec3) -> DVec3 {
        p[self.axis] = self.at;
        p
    }

    /// The next point whose image is exact.
    pub(super) fn exact(self, mut p: DVec3) -> DVec3 {
        p[self.axis] = (p[self.axis] / self.quantum).round() * self.quantum;
        p
    }
}

/// Positions followed by the images of those that are not on the plane, and per position its image.
pub(super) fn doubled(mirror: Mirror, positions: &[DVec3], is_on_plane: &[bool]) -> (Vec<DVec3>, Vec<u32>) {
    let mut both = positions.to_vec();
    let mut image = Vec::with_capacity(positions.len());
    for ((v, &p), &on_plane) in (0u32..).zip(positions).zip(is_on_plane) {
        if on_plane {
            image.push(v);
        } else {
            image.push(both.len() as u32);
            both.push(mirror.image(p));
        }
    }
    (both, image)
}
