//! The parts into which curves cut a mesh.

use crate::engine::mesh::NONE;
use crate::engine::methods::harmonic::cut_mesh::CutMesh;

/// The connected parts of a mesh without its curves.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    /// Per face, its part.
    pub(super) of_face: Vec<u32>,
    /// Per part, its Euler characteristic, as cut open along the curves.
    euler: Vec<i64>,
}

impl Regions {
    pub(super) fn new(cut: &CutMesh) -> Self {
        let mut of_face = vec![NONE; cut.n_faces()];
        let mut n = 0u32;
        let mut stack = Vec::new();
        for seed in 0..cut.n_faces() {
            if of_face[seed] != NONE {
                continue;
            }
            of_face[seed] = n;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for t in (3 * f..3 * f + 3).filter(|&h| !cut.is_line(h)).filter_map(|h| cut.twin(h)) {
                    if of_face[t / 3] == NONE {
                        of_face[t / 3] = n;
                        stack.push(t / 3);
                    }
                }
            }
            n += 1;
        }
        let mut euler = vec![0i64; n as usize];
        for (f, &region) in of_face.iter().enumerate() {
            euler[region as usize] += 1;
            for h in 3 * f..3 * f + 3 {
                // An edge off the curves is one edge of two faces.
                let counts = cut.is_line(h) || cut.twin(h).is_none_or(|t| h < t);
                euler[region as usize] -= i64::from(counts);
            }
        }
        for v in 0..cut.n_vertices() as u32 {
            let fan = cut.fan(v);
            let borders = fan.iter().filter(|&&h| cut.is_line(h) || cut.twin(h).is_none());
            // Each border begins a sector, counter-clockwise; without one the whole fan is a sector.
            let sectors: Vec<usize> = borders.map(|&h| h / 3).collect();
            if sectors.is_empty() {
                euler[of_face[fan[0] / 3] as usize] += 1;
            }
            for f in sectors {
                euler[of_face[f] as usize] += 1;
            }
        }
        Self { of_face, euler }
    }

    pub(super) fn n(&self) -> usize {
        self.euler.len()
    }

    /// The first part that is no disc.
    pub(super) fn first_open(&self) -> Option<u32> {
        self.euler.iter().position(|&euler| euler != 1).map(|i| i as u32)
    }
}
