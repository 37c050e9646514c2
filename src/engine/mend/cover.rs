//! Whether the quads of a disc still stand for the surface that they stood for: a filling that cuts a limb off is no
//! mending, however good its quads are.

use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::{Freedom, Patch};
use crate::engine::mend::settle::spread;
use crate::engine::mesh::{FaceTree, TriMesh};
use crate::engine::quad::improve::DEAD;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// Points of the surface per quad: a limb of one edge's width and length has some twenty.
const PER_QUAD: f64 = 6.0;
/// Points may lie this many edges from the quads, half of what the certificate allows, …
const REACH: f64 = 1.0;
/// … or this much further than before.
const SLACK: f64 = 1.05;
/// Vertices that are put onto points out of reach, one after the other.
const PINS: usize = 8;

/// Points spread evenly over the area of a surface, as many as quads with edges of this length need, in order of faces.
pub(super) fn points(mesh: &TriMesh, edge: f64) -> Vec<DVec3> {
    let cell = edge * edge / PER_QUAD;
    let mut points = Vec::new();
    let mut area = 0.5 * cell;
    for f in 0..mesh.n_faces() {
        area += mesh.area(f);
        while area > cell {
            area -= cell;
            // A sequence of low discrepancy in the unit square, folded to the triangle.
            let i = points.len() as f64 + 0.5;
            let (mut s, mut t) = ((i * 0.754_877_666_246_692_7).fract(), (i * 0.569_840_290_998_053_2).fract());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let [a, b, c] = mesh.triangle(f);
            points.push(a + s * (b - a) + t * (c - a));
        }
    }
    points
}

/// Per slot of quads, the points that are nearest to its quad.
pub(super) fn assigned(
    ctx: &RunContext,
    quads: &[[u32; 4]],
    positions: &[DVec3],
    points: &[DVec3],
) -> Result<Vec<Vec<DVec3>>, Cancelled> {
    let tree = tree(quads.iter(), positions);
    let nearest = |(i, &p): (usize, &DVec3)| {
        if i % 32 == 0 {
            ctx.check()?;
        }
        Ok(tree.closest_where(p, f64::INFINITY, |_| true).map(|found| found.face))
    };
    let slots: Vec<Option<u32>> = points.par_iter().enumerate().map(nearest).collect::<Result<_, Cancelled>>()?;
    let mut assigned = vec![Vec::new(); quads.len()];
    for (&p, slot) in points.iter().zip(slots) {
        if let Some(slot) = slot {
            assigned[slot as usize].push(p);
        }
    }
    Ok(assigned)
}

/// The quads that are there, each as two triangles, named by their place in the list.
fn tree<'a>(quads: impl Iterator<Item = &'a [u32; 4]>, positions: &[DVec3]) -> FaceTree {
    let (mut triangles, mut names) = (Vec::new(), Vec::new());
    for (name, quad) in (0u32..).zip(quads).filter(|(_, quad)| **quad != DEAD) {
        let [a, b, c, d] = quad.map(|v| positions[v as usize]);
        triangles.extend([[a, b, c], [a, c, d]]);
        names.extend([name; 2]);
    }
    FaceTree::of_triangles(triangles, &names)
}

impl Patch {
    /// The point furthest from the quads of the disc and around it, and how far it is in model units.
    pub(super) fn farthest(&self) -> (DVec3, f64) {
        let tree = tree(self.quads.iter().chain(&self.around), &self.positions);
        let mut farthest = (DVec3::ZERO, 0.0);
        for &p in &self.points {
            let distance = tree.closest_where(p, f64::INFINITY, |_| true).map_or(0.0, |found| found.distance);
            if distance > farthest.1 {
                farthest = (p, distance);
            }
        }
        farthest
    }

    /// How far points may be from the quads of a patch that is as it was.
    pub(super) fn allowed(&self, ground: &Ground<'_>) -> f64 {
        (SLACK * self.farthest().1).max(REACH * ground.edge)
    }

    /// Spreads vertices out, and moves the nearest ones to points that are out of reach then.
    pub(super) fn spread_over(&mut self, ground: &Ground<'_>, among: &[u32]) {
        spread(ground, self, among);
        let mut left = among.to_vec();
        for _ in 0..PINS {
            let (p, distance) = self.farthest();
            let free = left.iter().copied().filter(|&v| self.freedom[v as usize] == Freedom::Surface);
            let away = |v: u32| self.positions[v as usize].distance_squared(p);
            let Some(v) = free.min_by(|&v, &w| away(v).total_cmp(&away(w))).filter(|_| distance > self.reach) else {
                break;
            };
            self.positions[v as usize] = p;
            left.retain(|&w| w != v);
            spread(ground, self, &left);
        }
    }
}
