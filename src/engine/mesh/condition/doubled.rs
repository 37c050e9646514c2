//! Faces that are there more than once.

use rayon::slice::ParallelSliceMut;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::patches::components;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::triangulate::Triangles;

/// Drops every triangle that has the corners and the sense of a triangle before it; returns per remaining triangle
/// the one with the same corners and the opposite sense, or [`NONE`].
pub(super) fn drop_duplicates(triangles: &mut Triangles, tally: &mut Tally) -> Vec<u32> {
    let mut sets: Vec<([u32; 3], bool, u32)> = (0..triangles.corners.len() as u32)
        .map(|f| {
            let face = triangles.corners[f as usize];
            let mut set = face;
            set.sort_unstable();
            let [a, b, c] = face;
            (set, u8::from(a > b) + u8::from(b > c) + u8::from(c > a) == 1, f)
        })
        .collect();
    sets.par_sort_unstable();
    let mut keep = vec![true; triangles.corners.len()];
    let mut opposite = vec![NONE; triangles.corners.len()];
    for same in sets.chunk_by(|a, b| a.0 == b.0) {
        let (first, last) = (same[0], same[same.iter().take_while(|s| s.1 == same[0].1).count() % same.len()]);
        for s in same {
            keep[s.2 as usize] = s.2 == first.2 || s.2 == last.2;
        }
        if first.2 != last.2 {
            opposite[first.2 as usize] = last.2;
            opposite[last.2 as usize] = first.2;
        }
    }
    let mut renamed = vec![NONE; keep.len()];
    let mut n = 0;
    for f in (0..keep.len()).filter(|&f| keep[f]) {
        renamed[f] = n;
        n += 1;
    }
    let dropped = keep.len() - n as usize;
    if dropped > 0 {
        triangles.retain(|f| keep[f]);
        let kept = (0..keep.len()).filter(|&f| keep[f]);
        opposite = kept.map(|f| if opposite[f] == NONE { NONE } else { renamed[opposite[f] as usize] }).collect();
    }
    tally.add("duplicate_faces_dropped", dropped);
    opposite
}

/// The faces that only give a sheet a second side: in every component of which each face lies on an opposite one,
/// those whose opposite stays. Walls between two solids stay, because the solids have other faces too.
pub(super) fn second_sides(partner: &[u32], opposite: &[u32]) -> Vec<bool> {
    let mut dropped = vec![false; opposite.len()];
    if opposite.iter().all(|&o| o == NONE) {
        return dropped;
    }
    let (component, n) = components(partner);
    let mut doubled = vec![true; n];
    for f in 0..opposite.len() {
        doubled[component[f] as usize] &= opposite[f] != NONE;
    }
    for f in (0..opposite.len()).rev().filter(|&f| doubled[component[f] as usize]) {
        dropped[f] = !dropped[opposite[f] as usize];
    }
    dropped
}

/// Pairs of coincident opposite faces that are connected along two sides: a fold without thickness.
pub(super) fn folds(partner: &[u32], opposite: &[u32]) -> Vec<bool> {
    let mut dropped = vec![false; opposite.len()];
    for (f, &o) in opposite.iter().enumerate().filter(|&(_, &o)| o != NONE) {
        let shared = (3 * f..3 * f + 3).filter(|&h| partner[h] != NONE && partner[h] / 3 == o).count();
        dropped[f] = shared == 2;
    }
    dropped
}
