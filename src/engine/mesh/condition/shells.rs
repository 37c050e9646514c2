//! Shells that lie upon another one.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;

use crate::engine::mesh::condition::patches::components;

/// Shells that lie in the same place as a face are compared with this many of them, the largest ones.
const COMPARED: usize = 8;

/// The faces of every component that lies upon faces of one other component, corner by corner at exactly the same places:
/// of equal shells the first one stays, of others the larger one. Per face whether it is to be dropped, and the number of
/// such components. O(F log F).
pub(super) fn shells_upon_others(corners: &[[u32; 3]], partner: &[u32], positions: &[DVec3]) -> (Vec<bool>, usize) {
    let (component, n) = components(partner);
    if n < 2 {
        return (vec![false; corners.len()], 0);
    }
    let mut size = vec![0usize; n];
    component.iter().for_each(|&c| size[c as usize] += 1);
    // Large ones first, and of equal ones the first.
    let mut order: Vec<u32> = (0..n as u32).collect();
    order.sort_by_key(|&c| (std::cmp::Reverse(size[c as usize]), c));
    let mut rank = vec![0u32; n];
    (0..).zip(&order).for_each(|(r, &c)| rank[c as usize] = r);

    let name = places(positions);
    let mut faces: Vec<([u32; 3], u32)> = corners
        .iter()
        .zip(&component)
        .map(|(face, &c)| {
            let mut set = face.map(|v| name[v as usize]);
            set.sort_unstable();
            (set, rank[c as usize])
        })
        .collect();
    faces.par_sort_unstable();
    faces.dedup();
    let mut upon: Vec<(u32, u32)> = Vec::new();
    for same in faces.chunk_by(|a, b| a.0 == b.0) {
        for (i, &(_, smaller)) in same.iter().enumerate() {
            upon.extend(same[..i.min(COMPARED)].iter().map(|&(_, larger)| (smaller, larger)));
        }
    }
    upon.par_sort_unstable();
    let mut is_dropped = vec![false; n];
    for pair in upon.chunk_by(|a, b| a == b) {
        let (smaller, larger) = pair[0];
        is_dropped[smaller as usize] |=
            !is_dropped[larger as usize] && pair.len() == size[order[smaller as usize] as usize];
    }
    let dropped = component.iter().map(|&c| is_dropped[rank[c as usize] as usize]).collect();
    (dropped, is_dropped.iter().filter(|&&dropped| dropped).count())
}

/// A number per position that is the same exactly for those at the same place.
fn places(positions: &[DVec3]) -> Vec<u32> {
    // Adding 0 makes -0 and 0 one place.
    let place = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sorted: Vec<([u64; 3], u32)> = (0..).zip(positions).map(|(v, &p)| (place(p), v)).collect();
    sorted.par_sort_unstable();
    let mut name = vec![0; positions.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        for &(_, v) in same {
            name[v as usize] = same[0].1;
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::TriangleSoup;
    use crate::engine::mesh::condition::{ConditionOptions, condition};
    use crate::engine::mesh::shapes::sample_surface;
    use crate::engine::run::{RunContext, WarningKind};

    fn components(soup: &TriangleSoup) -> (usize, usize) {
        let made = condition(&RunContext::silent(), soup, &ConditionOptions::default()).unwrap();
        let warned = made.warnings.iter().find_map(|w| match w.kind {
            WarningKind::DuplicateShell { shells } => Some(shells),
            _ => None,
        });
        (made.mesh.components().1, warned.unwrap_or(0))
    }

    /// Adds some faces of a mesh with vertices of their own, moved and perhaps turned over.
    fn add(soup: &mut TriangleSoup, positions: &[DVec3], faces: &[[u32; 3]], by: DVec3, turned: bool) {
        let start = soup.positions.len() as u32;
        soup.positions.extend(positions.iter().map(|&p| p + by));
        for &[a, b, c] in faces {
            let [a, b, c] = if turned { [a, c, b] } else { [a, b, c] };
            soup.push_polygon(&[start + a, start + b, start + c]);
        }
    }

    #[test]
    fn equal_shells_and_pieces_of_shells_are_one() {
        let mesh = sample_surface("cube", 300).unwrap().mesh;
        let mut soup = TriangleSoup::default();
        let mut with = |n: usize, by: f64, turned| {
            add(&mut soup, mesh.positions(), &mesh.faces()[..n], by * DVec3::X, turned);
            components(&soup)
        };
        let all = mesh.n_faces();
        assert_eq!(with(all, 0.0, false), (1, 0));
        assert_eq!(with(all, 0.0, false), (1, 1));
        assert_eq!(with(all, 0.0, true), (1, 2));
        assert_eq!(with(10, 0.0, false), (1, 3));
        // The same shell elsewhere is another one.
        assert_eq!(with(all, 5.0, false), (2, 3));
    }
}
