use super::*;

/// A height field over n × n squares, with a different height at each vertex.
fn bumpy(n: usize) -> TriMesh {
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
            positions.push(DVec3::new(x, y, 0.2 * (7.0 * x).sin() * (9.0 * y).cos()));
        }
    }
    for i in 0..n {
        for j in 0..n {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriMesh::try_new(positions, faces).unwrap()
}

fn scattered(n: usize) -> impl Iterator<Item = DVec3> {
    let fraction = |x: f64| x - x.floor();
    (0..n).map(move |i| {
        let t = i as f64 + 1.0;
        DVec3::new(fraction(t * 0.754877), fraction(t * 0.569840), fraction(t * 0.362115) - 0.5) * 1.4
    })
}

#[test]
fn the_hierarchy_finds_what_a_search_of_all_faces_finds() {
    let mesh = bumpy(12);
    let index = SurfaceIndex::new(&mesh);
    for p in scattered(300) {
        let found = index.closest(p);
        let all = (0..mesh.n_faces()).map(|f| p.distance(closest_on_triangle(p, &mesh.triangle(f)).1));
        let (face, least) = all.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((found.distance - least).abs() < 1e-14);
        assert!(found.face == face as u32 || (found.distance - least).abs() < 1e-15);
        let [a, b, c] = mesh.triangle(found.face as usize);
        let [u, v, w] = found.barycentric;
        assert!(u >= 0.0 && v >= 0.0 && w >= 0.0 && (u + v + w - 1.0).abs() < 1e-12);
        assert!((u * a + v * b + w * c).distance(found.position) < 1e-12);
    }
}

#[test]
fn a_vertex_belongs_to_its_lowest_face() {
    let mesh = bumpy(6);
    let index = SurfaceIndex::new(&mesh);
    for v in 0..mesh.n_vertices() as u32 {
        let lowest = mesh.fan(v).map(|h| h as u32 / 3).min().unwrap();
        let found = index.closest(mesh.position(v));
        assert_eq!((found.face, found.distance), (lowest, 0.0));
    }
}

#[test]
fn only_accepted_faces_within_reach_count() {
    let mesh = bumpy(6);
    let index = SurfaceIndex::new(&mesh);
    let p = DVec3::new(0.5, 0.5, 1.0);
    let odd = index.closest_where(p, 10.0, |f| f % 2 == 1).unwrap();
    assert_eq!(odd.face % 2, 1);
    assert!(odd.distance >= index.closest(p).distance);
    assert_eq!(index.closest_where(p, 0.1, |_| true), None);
    assert_eq!(index.closest_where(p, 10.0, |_| false), None);
}

#[test]
fn triangles_without_area_still_have_a_nearest_point() {
    let (a, b) = (DVec3::ZERO, DVec3::X);
    let p = DVec3::new(0.3, 1.0, 0.0);
    for corners in [[a, b, b], [a, a, b], [b, a, b], [a, b, 0.5 * (a + b)]] {
        let (weights, position) = closest_on_triangle(p, &corners);
        assert!(position.distance(DVec3::new(0.3, 0.0, 0.0)) < 1e-12, "{corners:?}");
        let rebuilt = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
        assert!(rebuilt.distance(position) < 1e-12);
    }
    assert_eq!(closest_on_triangle(p, &[b, b, b]).1, b);
}
