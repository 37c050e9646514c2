//! How good a quad is: its smallest corner, measured against its own normal and against the surface.

use glam::DVec3;

/// Quads whose own normal leans further than this (cosine) from the surface count as turned over.
const UPRIGHT: f64 = 0.2;
/// Weight of the area of a corner against its shape in the regularised energy.
const AREA: f64 = 0.2;

/// Twice the area vector of a quad: the cross product of its diagonals.
pub(crate) fn area_vector([a, b, c, d]: &[DVec3; 4]) -> DVec3 {
    (*c - *a).cross(*d - *b)
}

/// Scaled Jacobians of the four corners against the unit normal `n`: 1 at a right angle, negative if reflex.
pub(crate) fn corner_jacobians(p: &[DVec3; 4], n: DVec3) -> [f64; 4] {
    std::array::from_fn(|k| {
        let (e, f) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        let scale = (e.length_squared() * f.length_squared()).sqrt();
        if scale > 0.0 { e.cross(f).dot(n) / scale } else { 0.0 }
    })
}

/// The smallest scaled Jacobian of a quad against its own normal; not positive if the quad has none or is turned over
/// against `up`, the unit normal of the surface beneath it. Larger is better, also below zero.
pub(crate) fn quality(p: &[DVec3; 4], up: DVec3) -> f64 {
    let own = area_vector(p).normalize_or_zero();
    let smallest = corner_jacobians(p, own).into_iter().fold(f64::INFINITY, f64::min);
    let lean = own.dot(up);
    if lean < UPRIGHT { smallest.min(0.0) + lean - UPRIGHT } else { smallest }
}

/// A corner of a quad in units of the wanted edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScaledCorner {
    /// Its area D against the surface: that of the parallelogram of its two edges.
    pub(crate) area: f64,
    /// The squared lengths of its two edges in sum.
    squared_edges: f64,
}

impl ScaledCorner {
    /// Corner `k` of a quad over a surface with unit normal `up`, where edges of length `size` are wanted.
    pub(crate) fn of(p: &[DVec3; 4], k: usize, up: DVec3, size: f64) -> Self {
        let (e, f) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        let unit = 1.0 / (size * size);
        Self { area: e.cross(f).dot(up) * unit, squared_edges: (e.length_squared() + f.length_squared()) * unit }
    }

    /// The regularised energy of `[garanzha_2021]`: shape and area over χ(D, ε), a positive stand-in for D.
    pub(crate) fn energy(self, epsilon: f64) -> f64 {
        let d = self.area;
        let chi = 0.5 * (d + (epsilon * epsilon + d * d).sqrt());
        (0.5 * (1.0 - AREA) * self.squared_edges + 0.5 * AREA * (d * d + 1.0)) / chi
    }
}

/// The mean of the corners.
pub(crate) fn centre(p: &[DVec3; 4]) -> DVec3 {
    0.25 * (p[0] + p[1] + p[2] + p[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

    #[test]
    fn a_square_is_perfect_and_turned_over_it_is_worse_than_worthless() {
        assert!((quality(&SQUARE, DVec3::Z) - 1.0).abs() < 1e-15);
        assert!(quality(&SQUARE, -DVec3::Z) < -1.0);
    }

    #[test]
    fn a_reflex_corner_is_negative_and_a_parallelogram_has_the_sine_of_its_angle() {
        let mut arrow = SQUARE;
        arrow[2] = DVec3::new(0.3, 0.3, 0.0);
        assert!(quality(&arrow, DVec3::Z) < 0.0);
        let (s, c) = 1f64.sin_cos();
        let lean = DVec3::new(c, s, 0.0);
        let slanted = [DVec3::ZERO, DVec3::X, DVec3::X + lean, lean];
        assert!((quality(&slanted, DVec3::Z) - s).abs() < 1e-15);
    }
}
