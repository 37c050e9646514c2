//! A foliation of the class that a system of curves and heights determines, as a closed form with signs.
//!
//! The curves' strips grow to annuli that meet in a graph, the spine. Along a strip's own sheet u rises by the height from
//! its right bank to its left one, and is constant elsewhere. Towards the spine u rises on the left bank and falls on the
//! right one, so across the spine the sheets go on into each other where left meets right and are exchanged where equal
//! banks meet (the "toward" and "away" of the design). Where three edges of the spine meet, equal banks meet an odd number of
//! times or the count of edges is odd: branch points, the first guess of the zeros.

use std::collections::VecDeque;

use crate::engine::calculus::{OneForm, Signs};
use crate::engine::mesh::{TriMesh, next, prev};
use crate::engine::methods::holomorphic::strip::{Bank, Strip};

/// Signs of a covering and a closed form on it.
#[derive(Clone, Debug)]
pub(super) struct Foliation {
    pub(super) signs: Signs,
    /// u along halfedges: sums of heights, so that its integrals are exact.
    pub(super) form: OneForm,
}

/// Annuli around the strips.
struct Annuli {
    /// Per face of the annuli the bank that it lies on; faces of strips on that of their outer edge.
    bank: Vec<Bank>,
    is_strip: Vec<bool>,
    /// Per halfedge whether it is a part of the spine.
    is_spine: Vec<bool>,
    /// Per vertex the edges of the spine that end there.
    degree: Vec<u32>,
}

impl Foliation {
    /// The foliation of disjoint strips and their heights. O(F).
    pub(super) fn new(mesh: &TriMesh, strips: &[Strip], heights: &[f64]) -> Self {
        let mut annuli = Annuli::grow(mesh, strips);
        annuli.split_nodes(mesh);
        let mut signs = Signs::trivial(mesh);
        for h in (0..mesh.n_halfedges()).filter(|&h| annuli.is_spine[h]) {
            let Some(t) = mesh.twin(h).filter(|&t| h < t) else { continue };
            if annuli.bank[h / 3] == annuli.bank[t / 3] {
                signs.turn(mesh, h);
            }
        }
        let mut form = OneForm::zero(mesh);
        for (strip, &height) in strips.iter().zip(heights) {
            // A halfedge that is crossed outwards leads from the right bank to the left one.
            strip.crossed.iter().for_each(|&h| form.set(mesh, &signs, h, height));
        }
        Self { signs, form }
    }

    /// Moves a branch point along halfedge `h`, from its origin to its target, where none is yet: leaves are dragged along, so
    /// that the class stays the same.
    pub(super) fn drag(&mut self, mesh: &TriMesh, h: usize) {
        self.level(mesh, h);
        self.signs.turn(mesh, h);
    }

    /// Adds a differential that makes u constant along `h` by changing it at the target alone, which must be no branch point.
    fn level(&mut self, mesh: &TriMesh, h: usize) {
        let rise = self.form.along[h];
        if rise == 0.0 {
            return;
        }
        // The change at the target, on the sheet of the face of h, then of each face of its fan.
        let fan: Vec<usize> = mesh.fan(mesh.target(h)).collect();
        let at = fan.iter().position(|&c| c == next(h)).unwrap_or(0);
        let mut change = -rise;
        for k in 0..fan.len() {
            let c = fan[(at + k) % fan.len()];
            self.form.along[c] -= change;
            self.form.along[prev(c)] += change;
            change *= self.signs.across(prev(c));
        }
    }
}

impl Annuli {
    fn grow(mesh: &TriMesh, strips: &[Strip]) -> Self {
        let mut annuli = Self {
            bank: vec![Bank::Left; mesh.n_faces()],
            is_strip: vec![false; mesh.n_faces()],
            is_spine: (0..mesh.n_halfedges()).map(|h| !mesh.is_boundary(h)).collect(),
            degree: vec![0; mesh.n_vertices()],
        };
        let mut queue = VecDeque::new();
        let mut is_reached = vec![false; mesh.n_faces()];
        for strip in strips {
            for &h in &strip.crossed {
                annuli.cross(mesh, h);
            }
            for (h, bank) in strip.banks(mesh) {
                let f = h / 3;
                (annuli.bank[f], annuli.is_strip[f], is_reached[f]) = (bank, true, true);
                queue.push_back(f);
            }
        }
        while let Some(f) = queue.pop_front() {
            for h in 3 * f..3 * f + 3 {
                let Some(t) = mesh.twin(h).filter(|&t| !is_reached[t / 3]) else { continue };
                (is_reached[t / 3], annuli.bank[t / 3]) = (true, annuli.bank[f]);
                annuli.cross(mesh, h);
                queue.push_back(t / 3);
            }
        }
        (0..mesh.n_halfedges())
            .filter(|&h| annuli.is_spine[h])
            .for_each(|h| annuli.degree[mesh.origin(h) as usize] += 1);
        let mut loose: Vec<u32> = (0..mesh.n_vertices() as u32).filter(|&v| annuli.degree[v as usize] == 1).collect();
        while let Some(v) = loose.pop() {
            let Some(h) = mesh.fan(v).find(|&h| annuli.is_spine[h]) else { continue };
            annuli.cross(mesh, h);
            for w in [v, mesh.target(h)] {
                annuli.degree[w as usize] -= 1;
                if annuli.degree[w as usize] == 1 {
                    loose.push(w);
                }
            }
        }
        annuli
    }

    /// Takes an edge out of the spine.
    fn cross(&mut self, mesh: &TriMesh, h: usize) {
        self.is_spine[h] = false;
        mesh.twin(h).into_iter().for_each(|t| self.is_spine[t] = false);
    }

    fn add(&mut self, mesh: &TriMesh, h: usize) {
        self.is_spine[h] = true;
        mesh.twin(h).into_iter().for_each(|t| self.is_spine[t] = true);
    }

    /// Splits nodes of more than three edges where there is room: the faces between two neighbouring edges go over to the
    /// annulus beyond the second one, whose end thus moves to the other end of the first one.
    fn split_nodes(&mut self, mesh: &TriMesh) {
        let mut nodes: Vec<u32> = (0..mesh.n_vertices() as u32).filter(|&v| self.degree[v as usize] > 3).collect();
        while let Some(v) = nodes.pop() {
            let fan: Vec<usize> = mesh.fan(v).collect();
            let spine: Vec<usize> = (0..fan.len()).filter(|&i| self.is_spine[fan[i]]).collect();
            let sectors = spine.iter().enumerate().map(|(k, &i)| (i, spine[(k + 1) % spine.len()]));
            // The halfedges of a sector from one edge of the spine (counter-clockwise) up to but without the next one.
            let of = |(i, j): (usize, usize)| -> Vec<usize> {
                (0..(j + fan.len() - i) % fan.len()).map(|k| fan[(i + k) % fan.len()]).collect()
            };
            let can = |sector: &Vec<usize>| {
                let ends = [mesh.target(sector[0]), mesh.origin(prev(sector[sector.len() - 1]))];
                sector.iter().all(|&h| !self.is_strip[h / 3] && !self.is_spine[next(h)])
                    && sector.iter().skip(1).all(|&h| self.degree[mesh.target(h) as usize] == 0)
                    && ends.iter().all(|&w| self.degree[w as usize] == 2)
                    && ends[0] != ends[1]
            };
            let Some(sector) = sectors.map(of).filter(can).min_by_key(Vec::len) else { continue };
            let last = prev(sector[sector.len() - 1]);
            let Some(beyond) = mesh.twin(last) else { continue };
            // Edge `last` leads from its other end to v; it goes, and the rim of the sector comes.
            self.cross(mesh, last);
            for &h in &sector {
                self.bank[h / 3] = self.bank[beyond / 3];
                self.add(mesh, next(h));
            }
            self.degree[v as usize] -= 1;
            self.degree[mesh.target(sector[0]) as usize] += 1;
            sector.iter().skip(1).for_each(|&h| self.degree[mesh.target(h) as usize] = 2);
            if self.degree[v as usize] > 3 {
                nodes.push(v);
            }
        }
    }
}
