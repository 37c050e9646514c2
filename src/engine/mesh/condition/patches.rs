//! Connected pieces of triangles whose sides are paired.

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::edges::origin;

/// Piece of each face, numbered in order of first faces, and their number. `partner` is per halfedge.
pub(super) fn components(partner: &[u32]) -> (Vec<u32>, usize) {
    let n_faces = partner.len() / 3;
    let (mut component, mut n, mut stack) = (vec![NONE; n_faces], 0, Vec::new());
    for seed in 0..n_faces {
        if component[seed] != NONE {
            continue;
        }
        component[seed] = n;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for &t in partner[3 * f..3 * f + 3].iter().filter(|&&t| t != NONE) {
                let g = t as usize / 3;
                if component[g] == NONE {
                    component[g] = n;
                    stack.push(g);
                }
            }
        }
        n += 1;
    }
    (component, n as usize)
}

/// A common sense of rotation for the faces of each piece.
pub(super) struct Senses {
    /// Piece of each face, in order of first faces.
    pub(super) patch: Vec<u32>,
    /// Number of pieces.
    pub(super) n_patches: usize,
    /// Whether the face must be turned over to agree with the majority of its piece.
    pub(super) flip: Vec<bool>,
    /// Lower halfedges of the edges across which no agreement is possible: a piece that has one is not orientable.
    pub(super) reversing: Vec<u32>,
}

/// Spreads the sense of the first face of each piece breadth first, so that in a piece that is not orientable the
/// contradictions lie where the fronts meet: along short cuts.
pub(super) fn senses(corners: &[[u32; 3]], partner: &[u32]) -> Senses {
    let n_faces = corners.len();
    let mut s = Senses { patch: vec![NONE; n_faces], n_patches: 0, flip: vec![false; n_faces], reversing: Vec::new() };
    let mut queue = Vec::with_capacity(n_faces);
    for seed in 0..n_faces {
        if s.patch[seed] != NONE {
            continue;
        }
        queue.clear();
        queue.push(seed);
        s.patch[seed] = s.n_patches as u32;
        let mut next = 0;
        while next < queue.len() {
            let f = queue[next];
            next += 1;
            for h in 3 * f..3 * f + 3 {
                if partner[h] == NONE {
                    continue;
                }
                let g = partner[h] as usize / 3;
                // Neighbours that agree run along their edge in opposite directions.
                let differ = origin(corners, h as u32) == origin(corners, partner[h]);
                if s.patch[g] == NONE {
                    s.patch[g] = s.n_patches as u32;
                    s.flip[g] = s.flip[f] ^ differ;
                    queue.push(g);
                } else if s.flip[g] != s.flip[f] ^ differ && h < partner[h] as usize {
                    s.reversing.push(h as u32);
                }
            }
        }
        if 2 * queue.iter().filter(|&&f| s.flip[f]).count() > queue.len() {
            for &f in &queue {
                s.flip[f] = !s.flip[f];
            }
        }
        s.n_patches += 1;
    }
    s.reversing.sort_unstable();
    s
}
