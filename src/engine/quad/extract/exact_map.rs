//! A grid map in fixed point, with transitions that hold exactly in integers.

use glam::I64Vec2;

use crate::engine::mesh::Features;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::parameterize::GridMap;
use crate::engine::parameterize::Iso;
use crate::engine::parameterize::rotate;
use crate::engine::parameterize::rotate_integer;
use crate::engine::quad::extract::error::ExtractError;

/// How near to an integer counts as one, in grid units, where a curve vertex may be taken as a grid point.
const NEAR: f64 = 1e-6;
/// A map whose seams gape by more than this, in grid units, is not a map.
const GAPING: f64 = 0.25;

/// A change of chart: `z ↦ i^quarters z + shift`, in fixed point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Transition {
    pub(super) quarters: u8,
    pub(super) shift: I64Vec2,
}

impl Transition {
    pub(super) fn apply(self, z: I64Vec2) -> I64Vec2 {
        rotate_integer(z, self.quarters) + self.shift
    }
    pub(super) fn inverse(self) -> Self {
        let quarters = (4 - self.quarters) & 3;
        Self { quarters, shift: -rotate_integer(self.shift, quarters) }
    }
    /// First `other`, then `self`.
    pub(super) fn after(self, other: Self) -> Self {
        Self { quarters: (self.quarters + other.quarters) & 3, shift: self.apply(other.shift) }
    }
}

/// Twice the signed area of a, b, c, exactly (coordinates stay below 2^52).
pub(super) fn orient(a: I64Vec2, b: I64Vec2, c: I64Vec2) -> i128 {
    let (p, q) = (b - a, c - a);
    i128::from(p.x) * i128::from(q.y) - i128::from(p.y) * i128::from(q.x)
}

/// Where the boundary of the surface lies in the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundaryInGrid {
    /// On grid lines.
    OnLines,
    /// Anywhere: grid lines may leave through it.
    Anywhere,
}

/// The map in fixed point. All vertices that need not lie on grid lines are off them by at least one unit, so grid
/// lines meet vertices only where features, the boundary or singularities are; edges lie on grid lines likewise.
pub(super) struct ExactMap<'a> {
    pub(super) mesh: &'a TriMesh,
    /// One grid unit, a power of two.
    pub(super) one: i64,
    /// Per corner, its value in the chart of its face.
    pub(super) corner: Vec<I64Vec2>,
    /// Per halfedge with a twin: from the chart of its face to the chart of the twin's face.
    pub(super) across: Vec<Transition>,
    /// Per corner: from the chart of its face to the chart of the first face around its vertex.
    to_root: Vec<Transition>,
    /// Per vertex: it is a grid point.
    pub(super) is_node: Vec<bool>,
    /// Per halfedge: it or its twin is asked to lie on a grid line.
    pub(super) guided: Vec<bool>,
    /// Largest gap at a seam in the input, grid units.
    pub(super) seam_residual: f64,
    /// Largest move of a value that had to become an integer, grid units.
    pub(super) snap_residual: f64,
}

impl<'a> ExactMap<'a> {
    /// Fixed point values of `map`.
    pub(super) fn new(
        mesh: &'a TriMesh,
        features: &Features,
        map: &GridMap,
        boundary: BoundaryInGrid,
    ) -> Result<Self, ExtractError> {
        let n = mesh.n_halfedges();
        if map.uv.len() != n || map.rotation.len() != n || map.translation.len() != n || map.iso.len() != n {
            return Err(ExtractError::WrongLength);
        }
        if let Some(corner) = map.uv.iter().position(|z| !z.is_finite()) {
            return Err(ExtractError::NotFinite { corner: corner as u32 });
        }
        let extent = map.uv.iter().fold(1.0f64, |m, z| m.max(z.abs().max_element()));
        let extent = map.translation.iter().fold(extent, |m, t| m.max(t.x.abs().max(t.y.abs()) as f64));
        let bits = 48 - (extent + 2.0).log2().ceil() as i64;
        if bits < 8 {
            return Err(ExtractError::TooLarge { extent });
        }
        let one = 1i64 << bits.min(30);
        let mut across = vec![Transition::default(); n];
        for h in 0..n {
            if let Some(t) = mesh.twin(h).filter(|&t| h < t) {
                let from_twin = Transition { quarters: map.rotation[h] & 3, shift: map.translation[h] * one };
                across[h] = from_twin.inverse();
                across[t] = from_twin;
            }
        }
        let guided = (0..n).map(|h| map.iso[h] != Iso::None || mesh.twin(h).is_some_and(|t| map.iso[t] != Iso::None));
        let guided = guided.collect();
        let mut exact = Self {
            mesh,
            one,
            corner: vec![I64Vec2::ZERO; n],
            across,
            to_root: vec![Transition::default(); n],
            is_node: vec![false; mesh.n_vertices()],
            guided,
            seam_residual: 0.0,
            snap_residual: 0.0,
        };
        exact.measure_seams(map)?;
        for v in 0..mesh.n_vertices() as u32 {
            let is_end = boundary == BoundaryInGrid::Anywhere && mesh.is_boundary_vertex(v);
            exact.place(v, features.is_corner(v) && !is_end, is_end, map)?;
        }
        exact.separate_degenerate_faces();
        if boundary == BoundaryInGrid::OnLines {
            exact.check_boundary()?;
        }
        Ok(exact)
    }

    fn measure_seams(&mut self, map: &GridMap) -> Result<(), ExtractError> {
        let unit = 1.0 / self.one as f64;
        for h in 0..self.mesh.n_halfedges() {
            let Some(t) = self.mesh.twin(h) else { continue };
            let to = self.across[h];
            for (mine, other) in [(h, next(t)), (next(h), t)] {
                let moved = rotate(map.uv[mine], to.quarters) + to.shift.as_dvec2() * unit;
                self.seam_residual = self.seam_residual.max((moved - map.uv[other]).abs().max_element());
            }
            if self.seam_residual > GAPING {
                let (a, b) = (self.mesh.origin(h), self.mesh.target(h));
                return Err(ExtractError::GapingSeam { a, b, gap: self.seam_residual });
            }
        }
        Ok(())
    }

    /// Decides the value of vertex `v` at its first corner and carries it to the others. Lines may end anywhere at an
    /// `is_end`.
    fn place(&mut self, v: u32, is_corner: bool, is_end: bool, map: &GridMap) -> Result<(), ExtractError> {
        let mesh = self.mesh;
        let (mut to_root, mut fixed, mut guided) = (Transition::default(), [is_corner; 2], 0);
        let mut closes = true;
        for h in mesh.fan(v) {
            self.to_root[h] = to_root;
            let p = prev(h);
            for side in [h, p] {
                let axis = match map.iso[side] {
                    Iso::None => continue,
                    Iso::U => 0,
                    Iso::V => 1,
                };
                fixed[(axis + to_root.quarters as usize) & 1] = true;
            }
            guided += usize::from(self.guided[h]);
            if let Some(t) = mesh.twin(p) {
                to_root = to_root.after(self.across[t]);
            } else {
                guided += usize::from(self.guided[p]);
                closes = false;
            }
        }
        if guided != 0 && guided != 2 && !is_end {
            fixed = [true; 2];
        }
        let root = map.uv[mesh.outgoing(v)];
        let mut value = I64Vec2::ZERO;
        if closes && to_root.quarters != 0 {
            value = self.fixed_point(to_root).ok_or(ExtractError::SingularityOffGrid { vertex: v })?;
            fixed = [true; 2];
            let moved = value.as_dvec2() / self.one as f64 - root;
            self.snap_residual = self.snap_residual.max(moved.abs().max_element());
        } else {
            if closes && to_root.shift != I64Vec2::ZERO {
                return Err(ExtractError::OpenVertex { vertex: v });
            }
            let near = (root - root.round()).abs().max_element() < NEAR;
            if near && !is_end && (fixed[0] || fixed[1] || (closes && winding(mesh, map, v) != 1)) {
                fixed = [true; 2];
            }
            for axis in 0..2 {
                let integer = root[axis].round();
                if fixed[axis] {
                    value[axis] = integer as i64 * self.one;
                    self.snap_residual = self.snap_residual.max((root[axis] - integer).abs());
                } else {
                    value[axis] = self.off_grid((root[axis] * self.one as f64).round() as i64);
                }
            }
        }
        self.is_node[v as usize] = fixed[0] && fixed[1];
        self.carry(v, value);
        Ok(())
    }

    fn off_grid(&self, x: i64) -> i64 {
        if x.rem_euclid(self.one) == 0 { x + 1 } else { x }
    }

    fn carry(&mut self, v: u32, root: I64Vec2) {
        let mesh = self.mesh;
        for h in mesh.fan(v) {
            self.corner[h] = self.to_root[h].inverse().apply(root);
        }
    }

    /// The point that `around` keeps, if it is a grid point.
    fn fixed_point(&self, around: Transition) -> Option<I64Vec2> {
        let t = around.shift;
        let double = match around.quarters {
            1 => I64Vec2::new(t.x - t.y, t.x + t.y),
            2 => t,
            _ => I64Vec2::new(t.x + t.y, t.y - t.x),
        };
        let whole = double.x.rem_euclid(2 * self.one) == 0 && double.y.rem_euclid(2 * self.one) == 0;
        whole.then_some(double / 2)
    }

    /// Moves free vertices of faces without area by a few units, so that no three corners are on a line by accident.
    fn separate_degenerate_faces(&mut self) {
        for round in 0..3u64 {
            let flat: Vec<usize> = (0..self.mesh.n_faces()).filter(|&f| self.orientation(f) == 0).collect();
            for f in flat {
                for k in 0..3 {
                    let v = self.mesh.face(f)[k];
                    let h = self.mesh.outgoing(v);
                    let root = self.corner[h];
                    if self.on_grid(root.x) || self.on_grid(root.y) {
                        continue;
                    }
                    let hash = (u64::from(v) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(round) >> 32;
                    let by = I64Vec2::new((hash & 15) as i64 - 7, (hash >> 4 & 15) as i64 - 7);
                    self.carry(v, I64Vec2::new(self.off_grid(root.x + by.x), self.off_grid(root.y + by.y)));
                }
            }
        }
    }

    fn check_boundary(&self) -> Result<(), ExtractError> {
        let off = |h: &usize| self.mesh.is_boundary(*h) && self.line_axis(*h).is_none();
        match (0..self.mesh.n_halfedges()).find(off) {
            Some(h) => Err(ExtractError::BoundaryOffGrid { a: self.mesh.origin(h), b: self.mesh.target(h) }),
            None => Ok(()),
        }
    }

    /// Whether the coordinate `x` is an integer.
    pub(super) fn on_grid(&self, x: i64) -> bool {
        x & (self.one - 1) == 0
    }

    /// The axis that is constant and integer along halfedge `h` in the chart of its face, if there is one.
    pub(super) fn line_axis(&self, h: usize) -> Option<usize> {
        let (a, b) = (self.corner[h], self.corner[next(h)]);
        (0..2).find(|&axis| a[axis] == b[axis] && self.on_grid(a[axis]))
    }

    /// Twice the signed area of face `f` in the map.
    pub(super) fn orientation(&self, f: usize) -> i128 {
        orient(self.corner[3 * f], self.corner[3 * f + 1], self.corner[3 * f + 2])
    }

    /// Quarter turns from the chart of a corner to that of the first corner of its vertex.
    pub(super) fn quarters_to_root(&self, corner: usize) -> u8 {
        self.to_root[corner].quarters
    }

    /// Quarter turns of the transition once around interior vertex `v`; 0 on the boundary.
    pub(super) fn turn_around(&self, v: u32) -> u8 {
        let Some(last) = self.mesh.fan(v).last() else { return 0 };
        let back = self.mesh.twin(prev(last)).map_or(Transition::default(), |t| self.across[t]);
        if self.mesh.is_boundary_vertex(v) { 0 } else { self.to_root[last].after(back).quarters }
    }

    /// From the chart of corner `from` to the chart of corner `to` of the same regular vertex.
    pub(super) fn around(&self, from: usize, to: usize) -> Transition {
        self.to_root[to].inverse().after(self.to_root[from])
    }
}

/// How often the map goes round vertex `v`.
fn winding(mesh: &TriMesh, map: &GridMap, v: u32) -> i64 {
    let angle = |h: usize| (map.uv[next(h)] - map.uv[h]).angle_to(map.uv[prev(h)] - map.uv[h]);
    (mesh.fan(v).map(angle).sum::<f64>() / std::f64::consts::TAU).round() as i64
}
