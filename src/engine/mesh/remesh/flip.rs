//! Edges are flipped towards valence 6 inside and 4 on the boundary, and out of slivers.

use crate::engine::mesh::remesh::isotropic::{Remesher, Worst};
use crate::engine::mesh::{NONE, closest_on_segment};
use crate::engine::run::Cancelled;

impl Remesher<'_> {
    /// One pass over all edges.
    pub(super) fn flip_edges(&mut self) -> Result<(), Cancelled> {
        let mut degree = vec![0i32; self.mesh.positions.len()];
        let mut open = vec![false; self.mesh.positions.len()];
        for h in 0..3 * self.mesh.faces.len() {
            if self.mesh.is_edge_owner(h) {
                let (a, b) = (self.mesh.origin(h) as usize, self.mesh.target(h) as usize);
                degree[a] += 1;
                degree[b] += 1;
                if self.mesh.twin(h).is_none() {
                    open[a] = true;
                    open[b] = true;
                }
            }
        }
        let mut fan = Vec::new();
        for h in 0..3 * self.mesh.faces.len() {
            if h % 8192 == 0 {
                self.ctx.check()?;
            }
            if !self.mesh.is_edge_owner(h) || self.mesh.segment(h).is_some() {
                continue;
            }
            let Some(t) = self.mesh.twin(h) else { continue };
            let ends = [self.mesh.origin(h), self.mesh.target(h)];
            let apices = [self.mesh.apex(h), self.mesh.apex(t)];
            let least = |v: u32| if open[v as usize] { 2 } else { 3 };
            if ends.iter().any(|&v| degree[v as usize] <= least(v)) || apices[0] == apices[1] {
                continue;
            }
            let excess = |v: u32, change: i32| {
                let ideal = if open[v as usize] { 4 } else { 6 };
                (degree[v as usize] + change - ideal).pow(2)
            };
            let now: i32 = ends.iter().chain(&apices).map(|&v| excess(v, 0)).sum();
            let then: i32 = ends.iter().map(|&v| excess(v, -1)).chain(apices.iter().map(|&v| excess(v, 1))).sum();
            if !self.flip_is_admissible(h, t, now - then) {
                continue;
            }
            self.mesh.fan(apices[0], &mut fan);
            if self.mesh.neighbours(&fan).any(|n| n == apices[1]) {
                continue;
            }
            self.mesh.flip(h);
            for v in ends {
                degree[v as usize] -= 1;
            }
            for v in apices {
                degree[v as usize] += 1;
            }
        }
        Ok(())
    }

    /// Whether a flip that improves the sum of squared valence errors by `gain` is worth its geometry.
    fn flip_is_admissible(&self, h: usize, t: usize, gain: i32) -> bool {
        let (a, b) = (self.mesh.origin(h), self.mesh.target(h));
        let (c, d) = (self.mesh.apex(h), self.mesh.apex(t));
        let old = [self.rate_as_is(h / 3), self.rate_as_is(t / 3)];
        let before = Worst::of(old.into_iter());
        if gain <= 0 && before.shape > 0.4 {
            return false;
        }
        let nowhere = glam::DVec3::ZERO;
        let new = [[a, d, c], [d, b, c]].map(|corners| self.rate(corners, NONE, nowhere, nowhere));
        let after = Worst::of(new.into_iter());
        let worth = if gain > 0 { after.shape > before.shape.min(0.4) } else { after.shape > 1.3 * before.shape };
        if !worth {
            return false;
        }
        // Both new triangles must face as both old ones do, else the four corners do not bound a convex piece.
        let sum = (self.mesh.area_vector(h / 3) + self.mesh.area_vector(t / 3)).normalize_or_zero();
        if new.iter().any(|triangle| triangle.unit.dot(sum) < 0.5) {
            return false;
        }
        let (pa, pb, pc, pd) =
            (self.mesh.position(a), self.mesh.position(b), self.mesh.position(c), self.mesh.position(d));
        let middle = 0.5 * (pc + pd);
        let bulge = closest_on_segment(middle, pa, pb).1.distance(middle);
        let flat = old[0].unit.dot(old[1].unit) > 0.999;
        if !flat && bulge > 0.0 {
            // The surface must be where the new edge is.
            let near = |f: u32| self.original.normal(f).dot(sum) > 0.0;
            let Some(found) = self.original.closest_where(middle, self.options.tolerance, near) else { return false };
            let now = 0.5 * (pa + pb);
            let error_now =
                self.original.closest_where(now, 2.0 * found.distance, near).map_or(f64::INFINITY, |p| p.distance);
            if found.distance > 0.3 * self.options.tolerance && found.distance > 2.0 * error_now {
                return false;
            }
        }
        new.iter().all(|triangle| self.is_admissible(triangle, &before))
    }
}
