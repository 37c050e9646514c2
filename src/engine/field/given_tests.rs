//! Given fields put on surfaces, carried and matched.

use glam::DVec3;

use super::*;
use crate::engine::field::{GivenBranchPoints, GivenMatching};
use crate::engine::mesh::refine;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::run::RunContext;

fn soup_of(mesh: &TriMesh) -> TriangleSoup {
    TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces())
}

fn given(vectors: GivenVectors, matchings: Vec<GivenMatching>) -> GivenField {
    GivenField { vectors, matchings, branch_points: GivenBranchPoints::Keep }
}

fn own_polygons(mesh: &TriMesh) -> Vec<u32> {
    (0..mesh.n_faces() as u32).collect()
}

/// Frames that are neither unit nor orthogonal, alike everywhere but for the plane of the face.
fn skew(mesh: &TriMesh) -> GivenVectors {
    let frame = |f: usize| {
        let x = mesh.normal(f).any_orthonormal_vector();
        [2.0 * x, 0.5 * x + 0.8 * mesh.normal(f).cross(x)]
    };
    GivenVectors::Frames((0..mesh.n_faces()).map(frame).collect())
}

#[test]
fn what_spans_no_frame_is_refused_with_its_polygons() {
    let mesh = sample_surface("cube", 48).unwrap().mesh;
    let soup = soup_of(&mesh);
    let put =
        |vectors: GivenVectors| FrameField::on_surface(&given(vectors, vec![]), &soup, &mesh, &own_polygons(&mesh));
    let n = mesh.n_faces();
    let counted = put(GivenVectors::Crosses(vec![DVec3::X; n - 1])).unwrap_err();
    assert_eq!(counted, GivenFieldError::Count { given: n - 1, polygons: n });
    let tangential: Vec<DVec3> = (0..n).map(|f| mesh.normal(f).any_orthonormal_vector()).collect();
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::splat(f64::INFINITY), mesh.normal(5)] {
        let mut crosses = tangential.clone();
        crosses[5] = bad;
        let refused = put(GivenVectors::Crosses(crosses.clone())).unwrap_err();
        assert_eq!(refused, GivenFieldError::Degenerate { polygons: vec![5] }, "{bad}");
        let frames = crosses.iter().zip(&tangential).map(|(&x, t)| [x, t.cross(DVec3::ONE)]).collect();
        assert!(matches!(put(GivenVectors::Frames(frames)), Err(GivenFieldError::Degenerate { .. })), "{bad}");
    }
    let parallel = tangential.iter().map(|&x| [x, -3.0 * x]).collect();
    assert!(
        matches!(put(GivenVectors::Frames(parallel)), Err(GivenFieldError::Degenerate { polygons }) if polygons.len() == n)
    );
    // Whatever the length.
    let long = put(GivenVectors::Crosses(tangential.iter().map(|x| 1e200 * x).collect())).unwrap();
    let short = put(GivenVectors::Crosses(tangential.iter().map(|x| 1e-200 * x).collect())).unwrap();
    let apart = long.vectors.iter().zip(&short.vectors).map(|(a, b)| a[0].distance(b[0])).fold(0.0, f64::max);
    assert!(apart < 1e-12, "{apart}");
}

#[test]
fn matchings_are_between_neighbours_and_have_both_directions() {
    let mesh = sample_surface("torus", 500).unwrap().mesh;
    let (soup, polygon) = (soup_of(&mesh), own_polygons(&mesh));
    let put = |from: u32, to: u32, quarters: u8| {
        let field = given(skew(&mesh), vec![GivenMatching { from, to, quarters }]);
        FrameField::on_surface(&field, &soup, &mesh, &polygon)
    };
    let h = 7;
    let t = mesh.twin(h).unwrap();
    let field = put(h as u32 / 3, t as u32 / 3, 1).unwrap();
    let frames = Frames::new(&mesh);
    let matching = field.crosses(&mesh, &frames, &vec![false; mesh.n_halfedges()]).matching;
    // Direction 0 of the near face is direction 1 of the far one: the far chart is a quarter turn behind.
    assert_eq!((matching.across(h), matching.across(t)), (3, 1));
    let far = (0..mesh.n_faces())
        .find(|&f| (0..3).all(|k| mesh.twin(3 * f + k).is_none_or(|t| t / 3 != 2)) && f != 2)
        .unwrap();
    for (from, to, quarters) in [(2, far as u32, 0), (2, 2, 0), (0, 100_000, 0), (h as u32 / 3, t as u32 / 3, 4)] {
        assert_eq!(put(from, to, quarters), Err(GivenFieldError::Matching { polygons: vec![from] }), "{from} {to}");
    }
}

/// A frame is {x, y, −x, −y}: it does not matter which direction is called the first, nor from which side the polygons are
/// seen, as long as the matchings say so.
#[test]
fn names_of_directions_do_not_matter() {
    let mesh = sample_surface("ellipsoid", 800).unwrap().mesh;
    let (soup, polygon) = (soup_of(&mesh), own_polygons(&mesh));
    let frames = Frames::new(&mesh);
    let flags = vec![false; mesh.n_halfedges()];
    let GivenVectors::Frames(plain) = skew(&mesh) else { unreachable!() };
    let smallest = FrameField::on_surface(&given(skew(&mesh), vec![]), &soup, &mesh, &polygon).unwrap();
    let field = smallest.crosses(&mesh, &frames, &flags);
    let name = |f: usize| (f * 7 % 4) as u8;
    let renamed: Vec<[DVec3; 2]> = plain
        .iter()
        .enumerate()
        .map(|(f, &[x, y])| {
            let all = [x, y, -x, -y];
            [all[name(f) as usize], all[(name(f) as usize + 1) % 4]]
        })
        .collect();
    let mut matchings = Vec::new();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        let (f, g) = (h / 3, mesh.twin(h).unwrap() / 3);
        // Direction d of f is direction d + name(f) of the plain frame.
        let quarters = (8 + name(f) - name(g) - field.matching.across(h)) % 4;
        matchings.push(GivenMatching { from: f as u32, to: g as u32, quarters });
    }
    let put = |vectors: Vec<[DVec3; 2]>, matchings: &[GivenMatching], soup: &TriangleSoup| {
        let field = given(GivenVectors::Frames(vectors), matchings.to_vec());
        FrameField::on_surface(&field, soup, &mesh, &polygon).unwrap().crosses(&mesh, &frames, &flags)
    };
    let other = put(renamed.clone(), &matchings, &soup);
    assert_eq!(other.quarter_index, field.quarter_index);
    // Second vectors reversed: directions are counted the other way round.
    let reversed = renamed.iter().map(|&[x, y]| [x, -y]).collect();
    let backwards: Vec<_> = matchings.iter().map(|m| GivenMatching { quarters: (4 - m.quarters) % 4, ..*m }).collect();
    assert_eq!(put(reversed, &backwards, &soup).quarter_index, field.quarter_index);
}

#[test]
fn a_field_goes_unchanged_to_parts_and_to_finer_triangles() {
    let surface = sample_surface("genus2", 1500).unwrap();
    let mesh = &surface.mesh;
    let whole = FrameField::on_surface(&given(skew(mesh), vec![]), &soup_of(mesh), mesh, &own_polygons(mesh)).unwrap();
    assert_eq!(whole.carried(mesh, mesh), whole);
    let all: Vec<u32> = (0..mesh.n_halfedges() as u32).collect();
    assert_eq!(whole.of_part(&all), whole);
    let half = 0.5 * (mesh.total_area() / mesh.n_faces() as f64).sqrt();
    let fine = refine(&RunContext::silent(), &surface, |_| half, 100_000).unwrap().surface.mesh;
    assert!(fine.n_faces() > 2 * mesh.n_faces());
    let carried = whole.carried(mesh, &fine);
    let index = SurfaceIndex::new(mesh);
    for f in 0..fine.n_faces() {
        let centre = fine.triangle(f).iter().sum::<DVec3>() / 3.0;
        let own = whole.vectors[index.closest(centre).face as usize];
        let away = (0..2).map(|k| carried.vectors[f][k].distance(own[k])).fold(0.0, f64::max);
        assert!(away < 1e-9, "{f}: {away}");
    }
    let [coarse, fine] = [(mesh, &whole), (&fine, &carried)].map(|(mesh, field)| {
        let flags = vec![false; mesh.n_halfedges()];
        field.crosses(mesh, &Frames::new(mesh), &flags).quarter_index.iter().filter(|q| **q != 0).count()
    });
    assert_eq!(coarse, fine);
}

#[test]
fn the_nearest_cross_of_a_turned_cross_is_itself_and_of_a_shear_its_rotation() {
    for angle in [-3.0, -1.0, 0.0, 0.4, 2.9] {
        let x = DVec2::from_angle(angle);
        assert!((nearest_cross(&[2.0 * x, 0.3 * x.perp()]) - angle).abs() < 1e-12);
        // The two lean towards each other alike.
        let [a, b] = [angle + 0.3, angle + std::f64::consts::FRAC_PI_2 - 0.3].map(DVec2::from_angle);
        assert!((nearest_cross(&[a, b]) - angle).abs() < 1e-12);
    }
}
