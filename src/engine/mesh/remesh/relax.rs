//! Vertices move to the middle of their neighbours, along the surface or along their curve.

use glam::DVec3;

use crate::engine::mesh::closest_on_triangle;
use crate::engine::mesh::remesh::isotropic::{Remesher, Worst};
use crate::engine::run::Cancelled;

impl Remesher<'_> {
    /// Moves each vertex once, in order, each seeing the moves before it.
    pub(super) fn relax(&mut self) -> Result<(), Cancelled> {
        let mut fan = Vec::new();
        for v in 0..self.mesh.positions.len() as u32 {
            if v % 2048 == 0 {
                self.ctx.check()?;
            }
            if !self.mesh.is_living_vertex(v) || self.mesh.fixed[v as usize] {
                continue;
            }
            self.mesh.fan(v, &mut fan);
            if self.mesh.on_curve[v as usize] {
                self.slide(v, &fan);
            } else {
                self.drift(v, &fan);
            }
        }
        Ok(())
    }

    /// A vertex inside the surface.
    fn drift(&mut self, v: u32, fan: &[usize]) {
        let p = self.mesh.position(v);
        let (mut weight, mut centre) = (0.0, DVec3::ZERO);
        for &h in fan {
            let area = self.mesh.area_vector(h / 3).length();
            let [a, b, c] = self.mesh.faces[h / 3].map(|v| self.mesh.position(v));
            weight += area;
            centre += area * (a + b + c) / 3.0;
        }
        if weight <= 0.0 {
            return;
        }
        let normal = self.fan_normal(fan);
        let step = centre / weight - p;
        let step = step - normal * step.dot(normal);
        let before = self.worst_of(fan);
        // The last try is the mere projection.
        for fraction in [1.0, 0.5, 0.2, 0.0] {
            let Some(found) = self.project(p + fraction * step, normal) else { continue };
            let expected = self.original.smooth_normal(&found);
            if self.leaves_no_bump(v, fan, found.position)
                && self.move_is_admissible(v, fan, found.position, expected, &before)
            {
                self.mesh.positions[v as usize] = found.position;
                self.normals[v as usize] = expected;
                return;
            }
        }
    }

    /// A vertex inside a curve.
    fn slide(&mut self, v: u32, fan: &[usize]) {
        let Some((s, _)) = self.mesh.other_segment(fan, crate::engine::mesh::NONE) else { return };
        let Some((r, _)) = self.mesh.other_segment(fan, s) else { return };
        let curves = &self.mesh.curves;
        let ends = [s, r].map(|id| {
            let segment = curves.segment(id);
            let at = usize::from(segment.v[1] == v);
            (segment.t[1 - at], segment.t[at])
        });
        let (t0, t1, t) = (ends[0].0, ends[1].0, ends[0].1);
        let before = self.worst_of(fan);
        for fraction in [1.0, 0.5, 0.2, 0.0] {
            let to = t + fraction * (0.5 * (t0 + t1) - t);
            let p = self.mesh.curves.point(s, to);
            if fraction > 0.0 && !(self.follows_curve(s, to, t0) && self.follows_curve(s, to, t1)) {
                continue;
            }
            if self.move_is_admissible(v, fan, p, DVec3::ZERO, &before) {
                self.mesh.positions[v as usize] = p;
                self.mesh.curves.slide([s, r], v, to);
                return;
            }
        }
    }

    /// Whether the place that `v` leaves for `p` stays near its triangles: relaxing must not wear down what sticks out.
    fn leaves_no_bump(&self, v: u32, fan: &[usize], p: DVec3) -> bool {
        let left = self.mesh.position(v);
        // Steps add up over the sweeps.
        let reach = 0.5 * self.options.tolerance;
        let near = |f: usize| {
            let corners = self.mesh.faces[f].map(|w| if w == v { p } else { self.mesh.position(w) });
            closest_on_triangle(left, &corners).1.distance_squared(left) <= reach * reach
        };
        left.distance_squared(p) <= reach * reach || fan.iter().any(|&h| near(h / 3))
    }

    fn worst_of(&self, fan: &[usize]) -> Worst {
        Worst::of(fan.iter().map(|&h| self.rate_as_is(h / 3)))
    }

    fn move_is_admissible(&self, v: u32, fan: &[usize], p: DVec3, normal: DVec3, before: &Worst) -> bool {
        fan.iter().all(|&h| {
            let new = self.rate(self.mesh.faces[h / 3], v, p, normal);
            let old = self.mesh.area_vector(h / 3);
            old.dot(new.unit) >= 0.2 * old.length() && self.is_admissible(&new, before)
        })
    }
}
