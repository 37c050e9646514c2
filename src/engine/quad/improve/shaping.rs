//! Whether quads can be given a decent shape after a change.

use glam::DVec3;

use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::optimise::SurfaceWalker;
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::quality;

/// Rounds of averaging before the shape is judged.
const ROUNDS: usize = 4;
/// Quality that is good enough after a change, even if it was better before.
const DECENT: f64 = 0.25;

/// Positions on the surface while the quads change.
#[derive(Debug)]
pub(crate) struct Shaping<'a> {
    walker: &'a SurfaceWalker<'a>,
    pub(crate) positions: Vec<DVec3>,
    /// Face beneath each vertex.
    faces: Vec<u32>,
}

impl<'a> Shaping<'a> {
    pub(crate) fn new(walker: &'a SurfaceWalker<'a>, draft: &QuadDraft, reach: f64) -> Self {
        let mut normals = vec![DVec3::ZERO; draft.mesh.positions.len()];
        for quad in &draft.mesh.quads {
            let n = area_vector(&quad.map(|v| draft.mesh.positions[v as usize]));
            quad.iter().for_each(|&v| normals[v as usize] += n);
        }
        let land = |(&p, n): (&DVec3, DVec3)| walker.land(p, n.normalize_or_zero(), reach).0;
        let faces = draft.mesh.positions.iter().zip(normals).map(land).collect();
        Self { walker, positions: draft.mesh.positions.clone(), faces }
    }

    /// Quality of the quad in `slot` against the surface beneath its free vertices.
    pub(crate) fn quality(&self, net: &QuadNet, slot: u32) -> f64 {
        let quad = net.quads[slot as usize];
        let p = quad.map(|v| self.positions[v as usize]);
        let free = quad.iter().filter(|&&v| net.is_free(v));
        let up: DVec3 = free.map(|&v| self.walker.normal(self.faces[v as usize])).sum();
        quality(&p, up.try_normalize().unwrap_or_else(|| area_vector(&p).normalize_or_zero()))
    }

    /// Least quality of the quads at `vertices`.
    pub(crate) fn least(&self, net: &QuadNet, vertices: &[u32]) -> f64 {
        let slots = vertices.iter().flat_map(|&v| &net.at[v as usize]);
        slots.map(|&slot| self.quality(net, slot)).fold(f64::INFINITY, f64::min)
    }

    /// Evens the free vertices among `vertices` out, and keeps that if their quads are then decent or at least no
    /// worse than `before`; tells whether it did.
    pub(crate) fn settle(&mut self, net: &QuadNet, vertices: &[u32], before: f64) -> bool {
        let moving: Vec<u32> =
            vertices.iter().copied().filter(|&v| net.is_free(v) && !net.at[v as usize].is_empty()).collect();
        let old = self.places(&moving);
        self.even_out(net, &moving);
        self.draw(&moving);
        let good = self.least(net, vertices) >= before.min(DECENT);
        if !good {
            self.put_back(&moving, &old);
        }
        good
    }

    /// Positions of vertices and the faces beneath them.
    pub(crate) fn places(&self, vertices: &[u32]) -> Vec<(DVec3, u32)> {
        vertices.iter().map(|&v| (self.positions[v as usize], self.faces[v as usize])).collect()
    }

    /// Returns vertices to places that they had.
    pub(crate) fn put_back(&mut self, vertices: &[u32], places: &[(DVec3, u32)]) {
        for (&v, &(position, face)) in vertices.iter().zip(places) {
            self.positions[v as usize] = position;
            self.faces[v as usize] = face;
        }
    }

    /// Moves vertices to the middle of their neighbours, off the surface.
    pub(crate) fn even_out(&mut self, net: &QuadNet, vertices: &[u32]) {
        for _ in 0..ROUNDS {
            for &v in vertices {
                self.positions[v as usize] = self.middle(net, v);
            }
        }
    }

    /// Draws vertices back to the surface, near the faces beneath them.
    pub(crate) fn draw(&mut self, vertices: &[u32]) {
        for &v in vertices {
            let (face, position) = self.walker.follow(self.faces[v as usize], self.positions[v as usize]);
            self.faces[v as usize] = face;
            self.positions[v as usize] = position;
        }
    }

    /// Mean of the edge neighbours, with the opposite corners at half weight to resist shear.
    fn middle(&self, net: &QuadNet, v: u32) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for &slot in &net.at[v as usize] {
            let (quad, k) = (&net.quads[slot as usize], net.corner(slot, v));
            for (offset, w) in [(1, 1.0), (2, 0.5), (3, 1.0)] {
                sum += w * self.positions[quad[(k + offset) % 4] as usize];
                weight += w;
            }
        }
        if weight > 0.0 { sum / weight } else { self.positions[v as usize] }
    }
}
