use glam::DVec3;

use super::network::Network;
use super::*;
use crate::engine::mesh::Features;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::ConditionOptions;
use crate::engine::mesh::condition::condition;
use crate::engine::mesh::shapes::sample;
use crate::engine::run::RunContext;

fn cube() -> TriangleSoup {
    let positions =
        (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
    let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
    for q in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        soup.push_polygon(&q);
    }
    soup
}

#[test]
fn a_cube_has_twelve_feature_edges_and_eight_corners() {
    let soup = cube();
    let surface = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
    let features = detect_features(&surface, &soup, &FeatureOptions::default());
    assert_eq!((features.edges.len(), features.corners.len()), (12, 8));
    let none = FeatureOptions { angle_degrees: 180.0, ..FeatureOptions::default() };
    assert_eq!(detect_features(&surface, &soup, &none), Default::default());
}

/// What `normal` says of the corner of a polygon (its number, its centre) at a place, and only that, as features.
fn by_normals(mut soup: TriangleSoup, normal: impl Fn(usize, DVec3, DVec3) -> DVec3) -> Features {
    for p in 0..soup.n_polygons() {
        let corners: Vec<DVec3> = soup.polygon(p).iter().map(|&v| soup.positions[v as usize]).collect();
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        soup.normals.extend(corners.iter().map(|&at| normal(p, centre, at).as_vec3().to_array()));
    }
    let surface = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
    let options = FeatureOptions { angle_degrees: 180.0, normals: true, ..FeatureOptions::default() };
    assert_eq!(
        detect_features(&surface, &soup, &FeatureOptions { normals: false, ..options.clone() }),
        Features::default()
    );
    detect_features(&surface, &soup, &options)
}

#[test]
fn split_normals_are_features_unless_every_facet_has_its_own() {
    let middle = DVec3::splat(0.5);
    let flat = by_normals(cube(), |_, centre, _| centre - middle);
    assert_eq!((flat.edges.len(), flat.corners.len()), (12, 8));
    assert_eq!(by_normals(cube(), |_, _, at| at - middle), Features::default());
    // Corners of which the file says nothing are no split.
    assert_eq!(by_normals(cube(), |p, centre, _| if p == 0 { DVec3::ZERO } else { centre - middle }).edges.len(), 8);

    let sphere = || sample("sphere", 700, 0.0, 0).unwrap();
    assert_eq!(by_normals(sphere(), |_, centre, _| centre), Features::default());
    let halves = by_normals(sphere(), |_, centre, at| at + if centre.z > 0.0 { DVec3::X } else { DVec3::ZERO });
    // The ring where the halves meet.
    let mut ends: Vec<u32> = halves.edges.iter().flatten().copied().collect();
    ends.sort_unstable();
    assert!(ends.len() > 20 && ends.chunks(2).all(|pair| pair[0] == pair[1]), "{ends:?}");
}

#[test]
fn small_cycles_are_opened_and_large_ones_kept() {
    // A box with a small square post on its lid has a cycle of its own at the foot of the post, and one at its top.
    let post = |half: f64| {
        let mut soup = TriangleSoup::default();
        let ring = |soup: &mut TriangleSoup, half: f64, z: f64| {
            let start = soup.positions.len() as u32;
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                soup.positions.push(DVec3::new(half * x, half * y, z));
            }
            start
        };
        let rings = [
            ring(&mut soup, 1.0, 0.0),
            ring(&mut soup, 1.0, 1.0),
            ring(&mut soup, half, 1.0),
            ring(&mut soup, half, 1.5),
        ];
        soup.push_polygon(&[3, 2, 1, 0]);
        for pair in rings.windows(2) {
            for k in 0..4 {
                let next = (k + 1) % 4;
                soup.push_polygon(&[pair[0] + k, pair[0] + next, pair[1] + next, pair[1] + k]);
            }
        }
        soup.push_polygon(&[12, 13, 14, 15]);
        soup
    };
    let edges = |half: f64| {
        let soup = post(half);
        let surface = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
        let options = FeatureOptions { min_length: 0.4, ..FeatureOptions::default() };
        detect_features(&surface, &soup, &options).edges.len()
    };
    assert_eq!(edges(0.3), 24);
    // Perimeters of 0.32: one edge of each must go, and what then is loose or small with it.
    assert!((12..24).contains(&edges(0.04)), "{}", edges(0.04));
}

/// Cubes of these sides in a row as one soup.
fn cubes(sides: &[f64]) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    let mut at = 0.0;
    for &side in sides {
        let one = cube();
        let first = soup.positions.len() as u32;
        soup.positions.extend(one.positions.iter().map(|&p| p * side + DVec3::X * at));
        for polygon in one.polygons() {
            soup.push_polygon(&polygon.iter().map(|&v| v + first).collect::<Vec<_>>());
        }
        at += 2.0 * side;
    }
    soup
}

/// Sides too short for a quad are kept where the rest of the model says that they are meant, and smaller quads are asked
/// for there.
#[test]
fn detail_of_constructed_shapes_is_kept_and_named() {
    let options = FeatureOptions { min_length: 4.0, ..FeatureOptions::default() };
    let detected = |sides: &[f64]| {
        let soup = cubes(sides);
        let surface = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
        let plain = detect_features(&surface, &soup, &options);
        let Detected { features, detail, .. } = detect_features_and_detail(&surface, &soup, &options);
        (plain.edges.len(), features.edges.len(), detail.iter().map(|&v| surface.mesh.position(v)).collect::<Vec<_>>())
    };
    let (plain, all, detail) = detected(&[10.0, 0.9]);
    assert!(plain < 24 && all == 24, "{plain} {all}");
    assert!(!detail.is_empty() && detail.iter().all(|p| p.x > 15.0), "{detail:?}");
    // Where most of what is sharp is as small, it is left as it was.
    let (plain, all, detail) = detected(&[2.0, 0.9, 0.9, 0.9, 0.9, 0.9]);
    assert_eq!((plain, detail), (all, Vec::new()));
}

/// Two rectangles of 10 × 5 that meet in a ridge of the given angle; along it lies a cap of hardly any height whose
/// normal stands at 60 degrees.
fn roof(degrees: f64) -> TriangleSoup {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let half = 10.0 / 2.0;
    let positions = vec![
        DVec3::new(-half, 0.0, 0.0),
        DVec3::new(half, 0.0, 0.0),
        DVec3::new(half, -5.0, 0.0),
        DVec3::new(-half, -5.0, 0.0),
        DVec3::new(half, 5.0 * cos, 5.0 * sin),
        DVec3::new(-half, 5.0 * cos, 5.0 * sin),
        DVec3::new(0.0, 5e-5, 5e-5 * 3f64.sqrt()),
    ];
    let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
    for polygon in [&[0, 3, 2][..], &[0, 2, 1], &[0, 1, 6], &[1, 4, 6], &[6, 4, 5], &[0, 6, 5]] {
        soup.push_polygon(polygon);
    }
    soup
}

#[test]
fn the_normals_of_needles_are_not_believed() {
    let edges = |degrees| {
        let soup = roof(degrees);
        let surface = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
        assert_eq!(surface.mesh.n_faces(), 6, "the cap is still there");
        let bent = (0..18).map(|h| Network::new(&surface.mesh).dihedral(h)).fold(0.0, f64::max).to_degrees();
        assert!(bent < degrees + 0.1, "{bent}");
        detect_features(&surface, &soup, &FeatureOptions { min_length: 1.0, ..FeatureOptions::default() }).edges
    };
    assert_eq!(edges(0.0), Vec::<[u32; 2]>::new());
    assert_eq!(edges(20.0), Vec::<[u32; 2]>::new());
    // One line along a ridge that is one.
    let ridge = edges(90.0);
    assert!(ridge == [[0, 1]] || ridge == [[0, 6], [1, 6]], "{ridge:?}");
}
