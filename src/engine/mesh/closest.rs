//! The nearest points of triangles and segments.

use glam::DVec3;

/// The point of a triangle nearest to `p`, as weights of its corners and as a position. Also right for triangles that
/// are a segment or a point.
#[inline]
pub fn closest_on_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> ([f64; 3], DVec3) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let size = ab.length_squared().max(ac.length_squared());
    if ab.cross(ac).length_squared() <= 1e-24 * size * size {
        return closest_on_sides(p, [a, b, c]);
    }
    // Voronoi regions of corners, sides and inside, in this order.
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ([1.0, 0.0, 0.0], a);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return ([0.0, 1.0, 0.0], b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return ([1.0 - t, t, 0.0], a + t * ab);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return ([0.0, 0.0, 1.0], c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return ([1.0 - t, 0.0, t], a + t * ac);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return ([0.0, 1.0 - t, t], b + t * (c - b));
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        return closest_on_sides(p, [a, b, c]);
    }
    let (v, w) = (vb / sum, vc / sum);
    ([(1.0 - v - w).max(0.0), v, w], a + v * ab + w * ac)
}

fn closest_on_sides(p: DVec3, corners: [DVec3; 3]) -> ([f64; 3], DVec3) {
    let mut best = ([1.0, 0.0, 0.0], corners[0]);
    for k in 0..3 {
        let (t, position) = closest_on_segment(p, corners[k], corners[(k + 1) % 3]);
        if p.distance_squared(position) < p.distance_squared(best.1) {
            best = ([0.0; 3], position);
            best.0[k] = 1.0 - t;
            best.0[(k + 1) % 3] = t;
        }
    }
    best
}

/// The point `a + t (b − a)`, 0 ≤ t ≤ 1, of a segment nearest to `p`, as t and as a position.
#[inline]
pub fn closest_on_segment(p: DVec3, a: DVec3, b: DVec3) -> (f64, DVec3) {
    let ab = b - a;
    let length_squared = ab.length_squared();
    if length_squared <= 0.0 {
        return (0.0, a);
    }
    let t = ((p - a).dot(ab) / length_squared).clamp(0.0, 1.0);
    (t, if t == 1.0 { b } else { a + t * ab })
}
