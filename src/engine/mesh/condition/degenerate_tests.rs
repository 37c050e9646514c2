//! Faces without area, needles, and corners that are no points.

use glam::DVec3;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::tests::{BOX, add_box, count, good, unit_box};

#[test]
fn triangles_without_area_go_and_leave_no_crack() {
    // A box of which one top edge is subdivided; flat triangles join the pieces to the undivided side.
    let mut soup = unit_box();
    let n = 9;
    soup.positions.extend((1..n).map(|i| DVec3::new(f64::from(i) / f64::from(n), 1.0, 1.0)));
    let mut top = vec![4, 5, 7];
    top.extend((8..16).rev());
    top.push(6);
    soup.indices.clear();
    soup.polygon_ends.clear();
    for q in BOX.iter().filter(|q| **q != [4, 5, 7, 6]) {
        soup.push_polygon(q);
    }
    soup.push_polygon(&top);
    let mut chain = vec![6];
    chain.extend(8..16);
    for i in 1..chain.len() {
        soup.push_polygon(&[7, chain[i - 1], chain[i]]);
    }
    let c = good(&soup);
    let t = c.mesh.topology();
    assert_eq!((t.components, t.boundaries, t.euler), (1, 0, 2), "{:?}", c.repairs);
    assert!((c.mesh.total_area() - 6.0).abs() < 1e-12);
    assert!(count(&c, "edges_flipped") > 0);
}

#[test]
fn needles_collapse() {
    // Each corner of a box blown up to a tiny triangle: needles along all edges.
    for size in [1e-12, 1e-9] {
        let base = good(&unit_box()).mesh;
        let mut soup = TriangleSoup::default();
        let centre = DVec3::splat(0.5);
        for f in 0..12 {
            let middle = base.triangle(f).iter().sum::<DVec3>() / 3.0;
            soup.positions.extend(base.triangle(f).map(|p| p + size * (middle - p)));
            soup.push_polygon(&[3 * f as u32, 3 * f as u32 + 1, 3 * f as u32 + 2]);
        }
        for h in 0..36 {
            let t = base.twin(h).unwrap();
            if h < t {
                let next = |h: usize| crate::engine::mesh::next(h) as u32;
                soup.push_polygon(&[next(h), h as u32, next(t), t as u32]);
            }
        }
        for v in 0..8 {
            let ring: Vec<u32> = base.fan(v).map(|h| h as u32).collect();
            soup.push_polygon(&ring);
        }
        let c = good(&soup);
        assert_eq!(c.mesh.topology().euler, 2, "{size}: {:?}", c.repairs);
        assert!(c.mesh.n_faces() <= 12 + 40 && (c.mesh.total_area() - 6.0).abs() < 1e-6);
        assert!(c.mesh.positions().iter().all(|p| (p - centre).length() < 0.9));
    }
}

#[test]
fn bad_corners_and_islands_are_told_apart() {
    let mut soup = unit_box();
    soup.positions.extend([DVec3::NAN, DVec3::splat(f64::INFINITY), DVec3::splat(9.0)]);
    soup.push_polygon(&[0, 1, 8]);
    soup.push_polygon(&[0, 9, 2]);
    soup.push_polygon(&[3, 3, 3]);
    add_box(&mut soup, DVec3::splat(3.0), 1e-4);
    let c = good(&soup);
    assert_eq!(c.mesh.topology().components, 2);
    assert_eq!(count(&c, "not_finite_faces_dropped"), 2);
    assert_eq!(count(&c, "degenerate_faces_dropped"), 1);
    assert_eq!(count(&c, "unreferenced_vertices_dropped"), 1);
}
