//! Short edges go, one end of each staying where it is: no vertex ever leaves the surface here.

use crate::engine::mesh::closest_on_triangle;
use crate::engine::mesh::remesh::isotropic::{Remesher, Worst};
use crate::engine::run::Cancelled;

impl Remesher<'_> {
    /// Collapses edges shorter than `limit` where nothing forbids it.
    pub(super) fn collapse_short_edges(&mut self, limit: f64) -> Result<(), Cancelled> {
        let (mut fan_a, mut fan_b) = (Vec::new(), Vec::new());
        for h in 0..3 * self.mesh.faces.len() {
            if h % 8192 == 0 {
                self.ctx.check()?;
            }
            if !self.mesh.is_edge_owner(h) || self.mesh.length_squared(h) >= limit * limit {
                continue;
            }
            let local = limit * self.size_of(self.mesh.origin(h));
            if self.mesh.length_squared(h) >= local * local {
                continue;
            }
            // Halfedges against the boundary do not exist: there the edge can collapse one way only.
            for h in [Some(h), self.mesh.twin(h)].into_iter().flatten() {
                let (a, b) = (self.mesh.origin(h), self.mesh.target(h));
                self.mesh.fan(a, &mut fan_a);
                self.mesh.fan(b, &mut fan_b);
                if self.mesh.may_collapse(h, &fan_a, &fan_b) && self.collapse_is_admissible(h, &fan_a) {
                    self.mesh.collapse(h, &fan_a);
                    break;
                }
            }
        }
        Ok(())
    }

    fn collapse_is_admissible(&self, h: usize, fan_a: &[usize]) -> bool {
        let mesh = &self.mesh;
        let (a, b) = (mesh.origin(h), mesh.target(h));
        let (pa, pb) = (mesh.position(a), mesh.position(b));
        let longest = 4.0 / 3.0 * self.options.target_edge * self.size_of(b);
        let too_long = |n: u32| {
            let p = mesh.position(n);
            p.distance_squared(pb) > p.distance_squared(pa).max(longest * longest)
        };
        if mesh.neighbours(fan_a).any(|n| n != b && too_long(n)) {
            return false;
        }
        if let Some(s) = mesh.segment(h) {
            let Some((other, _)) = mesh.other_segment(fan_a, s) else { return false };
            let mut t = [mesh.curves.segment(s).t, mesh.curves.segment(other).t].concat();
            t.sort_unstable_by(f64::total_cmp);
            if !self.follows_curve(s, t[0], t[3]) {
                return false;
            }
        }
        let before = Worst::of(fan_a.iter().map(|&x| self.rate_as_is(x / 3)));
        let mut distance = f64::INFINITY;
        for &x in fan_a {
            let corners = mesh.faces[x / 3];
            if corners.contains(&b) {
                continue;
            }
            // The removed vertex takes its target's place and expects what is expected there.
            let new = self.rate(corners, a, pb, self.normals[b as usize]);
            let old = mesh.area_vector(x / 3);
            if old.dot(new.unit) < 0.2 * old.length() || !self.is_admissible(&new, &before) {
                return false;
            }
            distance = distance.min(closest_on_triangle(pa, &new.points).1.distance_squared(pa));
        }
        // A boundary ear has no other faces; its curve was asked above.
        let tolerance = self.options.tolerance * self.size_of(a);
        distance <= tolerance * tolerance || distance == f64::INFINITY
    }
}
