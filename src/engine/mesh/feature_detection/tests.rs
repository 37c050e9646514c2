use glam::DVec3;

use super::*;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::ConditionOptions;
use crate::engine::mesh::condition::condition;
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
