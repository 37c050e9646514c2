//! How sharp an edge is when it is not looked at too closely.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use crate::engine::mesh::TriMesh;

/// Walks over the faces at one side of an edge; keeps its memory from one edge to the next.
pub(super) struct Relief<'a> {
    mesh: &'a TriMesh,
    /// Per face, the last walk that met it.
    met: Vec<u32>,
    walk: u32,
    /// Faces, with the area of their part within reach.
    queue: VecDeque<(usize, f64)>,
}

/// Least reach in heights of the smaller face: two edge lengths of equilateral triangles.
const ROWS: f64 = 2.309_401_076_758_503;
/// Faces that a walk takes at most, the nearest by steps: a mean of so many is no better with more.
const MOST_FACES: usize = 4000;

impl<'a> Relief<'a> {
    pub(super) fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, met: vec![0; mesh.n_faces()], walk: 0, queue: VecDeque::new() }
    }

    /// Angle in radians between the mean normals of the two sides of the edge of `h`, each taken over what lies within
    /// `reach` of the edge's midpoint and is joined to the edge's face across unmarked edges. Only the area within the
    /// ball counts, so that the angle does not depend on how flat sides are cut into triangles; where triangles are large,
    /// the ball has room for two of the smaller face in a row. Ripples of a noisy surface
    /// are flat in this view, creases are not. π where a side has no mean.
    pub(super) fn angle(&mut self, h: usize, reach: f64, marked: &[bool]) -> f64 {
        let Some(t) = self.mesh.twin(h) else {
            return 0.0;
        };
        let [a, b] = [self.mesh.origin(h), self.mesh.target(h)].map(|v| self.mesh.position(v));
        let height = |h: usize| 2.0 * self.mesh.area(h / 3) / a.distance(b).max(f64::MIN_POSITIVE);
        let reach = reach.max(ROWS * height(h).min(height(t)));
        let middle = 0.5 * (a + b);
        let (n, m) = (self.mean_normal(h / 3, middle, reach, marked), self.mean_normal(t / 3, middle, reach, marked));
        if n == DVec3::ZERO || m == DVec3::ZERO {
            return std::f64::consts::PI;
        }
        n.cross(m).length().atan2(n.dot(m))
    }

    fn mean_normal(&mut self, face: usize, middle: DVec3, reach: f64, marked: &[bool]) -> DVec3 {
        self.walk += 1;
        self.met[face] = self.walk;
        self.queue.push_back((face, area_within(self.mesh.triangle(face), middle, reach)));
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        let mut left = MOST_FACES;
        while let Some((f, within)) = self.queue.pop_front() {
            if left == 0 {
                self.queue.clear();
                break;
            }
            left -= 1;
            sum += within * self.mesh.normal(f);
            area += within;
            for h in (3 * f..3 * f + 3).filter(|&h| !marked[h]) {
                let Some(g) = self.mesh.twin(h).map(|t| t / 3).filter(|&g| self.met[g] != self.walk) else { continue };
                let within = area_within(self.mesh.triangle(g), middle, reach);
                if within > 0.0 {
                    self.met[g] = self.walk;
                    self.queue.push_back((g, within));
                }
            }
        }
        // Normals that cancel, as around a thin rod, have no mean worth speaking of.
        if sum.length() > 0.1 * area { sum.normalize() } else { DVec3::ZERO }
    }
}

/// Area of the part of a triangle that lies in a ball: the sum over its sides of what the ball's disc in its plane has in
/// common with the triangle between the side and the disc's centre.
fn area_within([a, b, c]: [DVec3; 3], centre: DVec3, radius: f64) -> f64 {
    let cross = (b - a).cross(c - a);
    if [a, b, c].iter().all(|p| p.distance_squared(centre) <= radius * radius) {
        return 0.5 * cross.length();
    }
    let normal = cross.normalize_or_zero();
    let away = (centre - a).dot(normal);
    let square = radius * radius - away * away;
    if square <= 0.0 || normal == DVec3::ZERO {
        return 0.0;
    }
    let x = (b - a).normalize_or_zero();
    let y = normal.cross(x);
    let flat = |p: DVec3| DVec2::new((p - centre).dot(x), (p - centre).dot(y));
    let corners = [a, b, c].map(flat);
    (0..3).map(|k| between(corners[k], corners[(k + 1) % 3], square)).sum::<f64>().max(0.0)
}

/// Signed area of what the triangle between the origin and a side has in common with a disc around the origin.
fn between(p: DVec2, q: DVec2, square: f64) -> f64 {
    let sector = |u: DVec2, v: DVec2| 0.5 * square * u.perp_dot(v).atan2(u.dot(v));
    let d = q - p;
    let (along, ends) = (d.length_squared(), p.dot(d));
    let root = ends * ends - along * (p.length_squared() - square);
    if root <= 0.0 || along == 0.0 {
        return sector(p, q);
    }
    let [from, to] = [-root.sqrt(), root.sqrt()].map(|root| (root - ends) / along);
    if from >= 1.0 || to <= 0.0 {
        return sector(p, q);
    }
    let (enter, leave) = (p + d * from.max(0.0), p + d * to.min(1.0));
    let before = if from > 0.0 { sector(p, enter) } else { 0.0 };
    let after = if to < 1.0 { sector(leave, q) } else { 0.0 };
    before + 0.5 * enter.perp_dot(leave) + after
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_within_a_ball_adds_up_and_has_its_limits() {
        let [a, b, c] = [DVec3::new(0.0, 0.0, 1.0), DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 3.0, 1.0)];
        let within = |centre: DVec3, radius: f64| area_within([a, b, c], centre, radius);
        let inside = DVec3::new(0.8, 0.8, 1.0);
        assert!((within(inside, 0.5) - std::f64::consts::PI * 0.25).abs() < 1e-12, "a whole disc");
        assert!((within(inside, 50.0) - 4.5).abs() < 1e-9, "the whole triangle");
        assert!((within(a, 1.0) - std::f64::consts::PI / 4.0).abs() < 1e-12, "a quarter at a right angle");
        let lifted = inside + DVec3::Z * 0.3;
        assert!((within(lifted, 0.5) - std::f64::consts::PI * 0.16).abs() < 1e-12, "a smaller disc from above");
        assert_eq!((within(inside + DVec3::Z, 0.5), within(DVec3::new(9.0, 9.0, 1.0), 1.0)), (0.0, 0.0));
        // However the triangle is cut in two, the parts have its share.
        for radius in [0.3, 1.0, 1.7, 2.5] {
            let middle = b.lerp(c, 0.37);
            let centre = DVec3::new(0.9, 0.4, 1.1);
            let parts = area_within([a, b, middle], centre, radius) + area_within([a, middle, c], centre, radius);
            assert!((parts - within(centre, radius)).abs() < 1e-12, "{radius}");
        }
    }
}
