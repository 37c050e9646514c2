//! The modified Laplace equation `[tong_2006]` section 2.3: u and v are harmonic in every meta-face, and across a meta-edge up
//! to its singular continuity, `z_left = i^m z_right + τ` with `z = u + iv`: regular (m = 0), reverse (m = 2) or switch (m = 1,
//! 3).
//!
//! There is one value per vertex, in the chart of the first face around it. The value at another corner is `i^q z + s`, with
//! q and s from the meta-edges between. Every edge of every triangle adds `w |z_i − z_j|²` as its triangle sees both ends,
//! w half the cotangent of the opposite angle. The row of a vertex is then the paper's equation for it, and the matrix is
//! symmetric; where a corner is a meta-vertex, it goes to the right-hand side.

use glam::DVec2;

use crate::engine::field::Frames;
use crate::engine::mesh::{TriMesh, next, prev};
use crate::engine::numerics::{Cholesky, HermitianMatrix, SolveError};
use crate::engine::parameterize::rotate;

/// Transitions across the halfedges of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Charts<'a> {
    /// Quarter turns m per halfedge: `z_own = i^m z_twin + τ`.
    pub(super) rotation: &'a [u8],
    /// τ per halfedge, grid units.
    pub(super) translation: &'a [DVec2],
}

/// What is known of a vertex, as one of its corners sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hold {
    pub(super) corner: usize,
    /// u and v, where they are known.
    pub(super) value: [Option<f64>; 2],
}

/// From the chart of the first face around a vertex to that of a corner: `z ↦ i^quarters z + shift`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct FromRoot {
    quarters: u8,
    shift: DVec2,
}

/// A factored equation.
#[derive(Clone, Debug)]
pub(super) struct Factored {
    /// Per real unknown its place in the equation; `u32::MAX` if it is held.
    place: Vec<u32>,
    n_free: usize,
    factor: Option<Cholesky<f64>>,
}

/// The harmonic u and v of a system of charts.
#[derive(Clone, Debug)]
pub(super) struct ModifiedLaplacian<'a> {
    mesh: &'a TriMesh,
    from_root: Vec<FromRoot>,
    /// Per halfedge, half the cotangent of the angle that is opposite to it in its face.
    weight: Vec<f64>,
}

impl<'a> ModifiedLaplacian<'a> {
    pub(super) fn new(mesh: &'a TriMesh, frames: &Frames, charts: &Charts<'_>) -> Self {
        Self { mesh, from_root: from_root(mesh, charts), weight: half_cotangents(mesh, frames) }
    }

    /// The equation of all vertices but those that are held, factored. Which unknowns are held follows from `holds`; their
    /// values do not matter here.
    ///
    /// # Errors
    /// [`SolveError`] if nothing holds the map.
    pub(super) fn factor(&self, holds: &[Hold]) -> Result<Factored, SolveError> {
        let n = 2 * self.mesh.n_vertices();
        let known = self.known(holds);
        let mut place = vec![u32::MAX; n];
        let mut n_free = 0;
        for (x, known) in known.iter().enumerate() {
            if known.is_none() {
                place[x] = n_free;
                n_free += 1;
            }
        }
        let (entries, _) = self.rows();
        let free = |x: u32| place[x as usize];
        let lower: Vec<(u32, u32, f64)> = entries
            .iter()
            .map(|&(i, j, value)| (free(i), free(j), value))
            .filter(|&(i, j, _)| i != u32::MAX && j != u32::MAX && i >= j)
            .collect();
        let factor = match n_free {
            0 => None,
            n => Some(Cholesky::new(&HermitianMatrix::from_lower(n as usize, &lower))?),
        };
        Ok(Factored { place, n_free: n_free as usize, factor })
    }

    /// Values at all corners, in grid units, with the given ones held.
    ///
    /// # Errors
    /// [`SolveError`] if nothing holds the map.
    #[cfg(test)]
    pub(super) fn solve(&self, holds: &[Hold]) -> Result<Vec<DVec2>, SolveError> {
        Ok(self.solve_with(&self.factor(holds)?, holds))
    }

    /// Values at all corners, in grid units. The factor may be that of another system with the same rotations and the same
    /// unknowns held.
    pub(super) fn solve_with(&self, factored: &Factored, holds: &[Hold]) -> Vec<DVec2> {
        let Factored { place, n_free, factor } = factored;
        let known = self.known(holds);
        let (entries, right) = self.rows();
        let mut x = vec![0.0; *n_free];
        for (&place, right) in place.iter().zip(&right).filter(|(place, _)| **place != u32::MAX) {
            x[place as usize] += right;
        }
        for (i, j, value) in entries {
            if let (true, Some(held)) = (place[i as usize] != u32::MAX, known[j as usize]) {
                x[place[i as usize] as usize] -= value * held;
            }
        }
        factor.iter().for_each(|factor| factor.solve(&mut x));
        let value = |i: usize| if place[i] == u32::MAX { known[i].unwrap_or(0.0) } else { x[place[i] as usize] };
        let root: Vec<DVec2> =
            (0..self.mesh.n_vertices()).map(|v| DVec2::new(value(2 * v), value(2 * v + 1))).collect();
        (0..self.mesh.n_halfedges()).map(|c| self.at_corner(c, root[self.mesh.origin(c) as usize])).collect()
    }

    pub(super) fn at_corner(&self, corner: usize, root: DVec2) -> DVec2 {
        let from = self.from_root[corner];
        rotate(root, from.quarters) + from.shift
    }

    /// Per real unknown its value, where it is held.
    fn known(&self, holds: &[Hold]) -> Vec<Option<f64>> {
        let mut known = vec![None; 2 * self.mesh.n_vertices()];
        for hold in holds {
            let from = self.from_root[hold.corner];
            let v = self.mesh.origin(hold.corner) as usize;
            for axis in 0..2 {
                let Some(value) = hold.value[axis] else { continue };
                let shifted = value - from.shift[axis];
                let unit = rotate(if axis == 0 { DVec2::X } else { DVec2::Y }, (4 - from.quarters) & 3);
                let to = usize::from(unit.y != 0.0);
                known[2 * v + to] = Some(shifted * unit[to]);
            }
        }
        known
    }

    /// All entries (row, column, value) of the matrix and its right-hand side; unknowns 2 v and 2 v + 1 are u and v of vertex v.
    pub(super) fn rows(&self) -> (Vec<(u32, u32, f64)>, Vec<f64>) {
        let n = 2 * self.mesh.n_vertices();
        let mut entries = Vec::with_capacity(4 * self.mesh.n_halfedges() + n);
        let mut diagonal = vec![0.0; n];
        let mut right = vec![0.0; n];
        for h in 0..self.mesh.n_halfedges() {
            let end = next(h);
            let w = self.weight[h];
            for (a, b) in [(h, end), (end, h)] {
                let (i, j) = (self.mesh.origin(a), self.mesh.origin(b));
                let (from, to) = (self.from_root[a], self.from_root[b]);
                diagonal[2 * i as usize] += w;
                diagonal[2 * i as usize + 1] += w;
                // z_a − z_b = i^q (x_i − i^(p − q) x_j + i^−q (s_a − s_b)).
                let quarters = (to.quarters + 4 - from.quarters) & 3;
                let block = match quarters {
                    0 => [(0, 0, -w), (1, 1, -w)],
                    1 => [(0, 1, w), (1, 0, -w)],
                    2 => [(0, 0, w), (1, 1, w)],
                    _ => [(0, 1, -w), (1, 0, w)],
                };
                entries.extend(block.map(|(r, c, value)| (2 * i + r, 2 * j + c, value)));
                let gap = rotate(to.shift - from.shift, (4 - from.quarters) & 3);
                right[2 * i as usize] += w * gap.x;
                right[2 * i as usize + 1] += w * gap.y;
            }
        }
        entries.extend((0..).zip(diagonal).map(|(x, value)| (x, x, value)));
        (entries, right)
    }
}

fn from_root(mesh: &TriMesh, charts: &Charts<'_>) -> Vec<FromRoot> {
    let mut corners = vec![FromRoot::default(); mesh.n_halfedges()];
    for v in 0..mesh.n_vertices() as u32 {
        let mut from = FromRoot::default();
        for h in mesh.fan(v) {
            corners[h] = from;
            // z_t = i^−m (z_s − τ) when crossing to the next face counter-clockwise.
            let p = prev(h);
            let back = (4 - charts.rotation[p]) & 3;
            from = FromRoot {
                quarters: (from.quarters + back) & 3,
                shift: rotate(from.shift - charts.translation[p], back),
            };
        }
    }
    corners
}

/// Triangles thinner than this, as twice their area over the squares of their sides, count as that thick: their cotangents would
/// drown the others' in rounding errors.
const THINNEST: f64 = 1e-6;

/// Half the cotangent of the angle opposite to each halfedge, in the metric of the frames.
pub(super) fn half_cotangents(mesh: &TriMesh, frames: &Frames) -> Vec<f64> {
    let mut weight = vec![0.0; mesh.n_halfedges()];
    for f in 0..mesh.n_faces() {
        // The angle between sides k and k + 1 is opposite to side k + 2.
        let products = frames.side_products(mesh, f);
        let squares = products[0] + products[1] + products[2];
        let twice_area = (2.0 * frames.area(mesh, f)).max(THINNEST * squares).max(f64::MIN_POSITIVE);
        for k in 0..3 {
            weight[3 * f + (k + 2) % 3] = -0.5 * products[3 + k] / twice_area;
        }
    }
    weight
}
