//! Quads as triangles in the manner of the glTF extension `FB_ngon_encoding`: a polygon is a run of triangles that
//! share their first vertex, so two polygons in a row must not start at the same vertex.

use glam::DVec3;

use crate::engine::quad::QuadMesh;

/// The corner at which each quad starts. Quads in a row never start at the same vertex; quads that share an edge only
/// where all else fails; among what is left the shorter diagonal wins.
pub(super) fn first_corners(mesh: &QuadMesh) -> Vec<u8> {
    let neighbours = neighbours(mesh);
    let mut first = vec![u8::MAX; mesh.quads.len()];
    // The second round mends what the first could not foresee.
    for _ in 0..2 {
        for q in 0..mesh.quads.len() {
            let choice = (0..4u8).min_by(|&i, &j| {
                let cost = |k: u8| cost(mesh, &first, &neighbours[q], q, k);
                let ((a, s), (b, t)) = (cost(i), cost(j));
                a.cmp(&b).then(s.total_cmp(&t))
            });
            first[q] = choice.unwrap_or(0);
        }
    }
    first
}

/// Quads that start where quad q would start at its corner k (those before and after it in the file count most), and
/// the squared length of the diagonal.
fn cost(mesh: &QuadMesh, first: &[u8], neighbours: &[u32; 4], q: usize, k: u8) -> (usize, f64) {
    let anchor = |q: usize| first.get(q).filter(|&&k| k < 4).map(|&k| mesh.quads[q][k as usize]);
    let (a, c) = (mesh.quads[q][k as usize], mesh.quads[q][(k as usize + 2) % 4]);
    let in_a_row = [q.checked_sub(1), Some(q + 1)].into_iter().flatten().filter(|&r| anchor(r) == Some(a)).count();
    let beside = neighbours.iter().filter(|&&r| anchor(r as usize) == Some(a)).count();
    let position = |v: u32| mesh.positions.get(v as usize).copied().unwrap_or(DVec3::ZERO);
    (8 * in_a_row + beside, position(a).distance_squared(position(c)))
}

/// Per quad, the quads behind its edges, `u32::MAX` where there is none.
fn neighbours(mesh: &QuadMesh) -> Vec<[u32; 4]> {
    let mut sides: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(4 * mesh.quads.len());
    for (q, quad) in mesh.quads.iter().enumerate() {
        for k in 0..4 {
            let (a, b) = (quad[k], quad[(k + 1) % 4]);
            sides.push((a.min(b), a.max(b), q as u32, k as u8));
        }
    }
    sides.sort_unstable();
    let mut neighbours = vec![[u32::MAX; 4]; mesh.quads.len()];
    for pair in sides.windows(2) {
        let [(a, b, q, k), (c, d, r, l)] = [pair[0], pair[1]];
        if (a, b) == (c, d) && q != r {
            neighbours[q as usize][k as usize] = r;
            neighbours[r as usize][l as usize] = q;
        }
    }
    neighbours
}

/// Joins triangles that follow each other and share their first vertex to polygons, each given to `polygon`.
pub(super) fn join<E>(
    triangles: impl Iterator<Item = [u32; 3]>,
    mut polygon: impl FnMut(&[u32]) -> Result<(), E>,
) -> Result<(), E> {
    let mut corners: Vec<u32> = Vec::new();
    for [a, b, c] in triangles {
        if corners.first() == Some(&a) && corners.last() == Some(&b) {
            corners.push(c);
        } else {
            if !corners.is_empty() {
                polygon(&corners)?;
            }
            corners.clear();
            corners.extend([a, b, c]);
        }
    }
    if corners.is_empty() { Ok(()) } else { polygon(&corners) }
}

#[cfg(test)]
mod tests {
    use super::super::quads::tests::cube;
    use super::*;

    #[test]
    fn neighbours_start_at_different_vertices() {
        for n in [1, 2, 5, 16] {
            let mesh = cube(n);
            let first = first_corners(&mesh);
            let anchor = |q: usize| mesh.quads[q][first[q] as usize];
            for q in 1..mesh.quads.len() {
                assert_ne!(anchor(q - 1), anchor(q));
            }
            for (q, neighbours) in neighbours(&mesh).iter().enumerate() {
                assert!(neighbours.iter().all(|&r| anchor(r as usize) != anchor(q)), "{n}: {q}");
            }
        }
    }

    #[test]
    fn a_fan_around_one_vertex_never_joins() {
        // Every quad holds vertex 0, and several orders of the corners.
        let quads: Vec<[u32; 4]> = (0..50u32)
            .map(|i| {
                let mut quad = [0, 2 * i + 1, 2 * i + 2, 2 * i + 3];
                quad.rotate_left(i as usize % 4);
                quad
            })
            .collect();
        let mesh = QuadMesh { positions: vec![DVec3::ZERO; 102], quads };
        let first = first_corners(&mesh);
        let anchors: Vec<u32> = (0..50).map(|q| mesh.quads[q][first[q] as usize]).collect();
        assert!(anchors.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn runs_of_triangles_are_polygons() {
        let mut polygons = Vec::new();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 3, 2], [5, 6, 7], [5, 7, 8], [5, 8, 9], [5, 1, 2]];
        join(triangles.into_iter(), |p| {
            polygons.push(p.to_vec());
            Ok::<_, ()>(())
        })
        .unwrap();
        assert_eq!(polygons, [vec![0, 1, 2, 3], vec![4, 3, 2], vec![5, 6, 7, 8, 9], vec![5, 1, 2]]);
    }
}
