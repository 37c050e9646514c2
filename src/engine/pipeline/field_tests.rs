//! Whole runs with a given field.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

use glam::DVec3;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::shapes::sample;
use crate::engine::pipeline::{
    GivenBranchPoints, GivenField, GivenVectors, Level, Outcome, RemeshSpec, Symmetry, Target, WorkingMesh, remesh,
};
use crate::engine::run::{Blame, Fault, RunContext};

/// The directions around a body of revolution and along its meridians, at a point with a normal.
fn around(p: DVec3, normal: DVec3) -> [DVec3; 2] {
    let around = DVec3::Z.cross(p).reject_from_normalized(normal).normalize();
    [around, normal.cross(around)]
}

/// Vectors per triangle from those around and along.
fn field_of(soup: &TriangleSoup, vectors: impl Fn([DVec3; 2]) -> [DVec3; 2]) -> Vec<[DVec3; 2]> {
    let corners = |p: usize| soup.polygon(p).iter().map(|&v| soup.positions[v as usize]).collect::<Vec<_>>();
    let frame = |c: Vec<DVec3>| {
        let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalize();
        vectors(around((c[0] + c[1] + c[2]) / 3.0, normal))
    };
    (0..soup.n_polygons()).map(|p| frame(corners(p))).collect()
}

fn remeshed(soup: &TriangleSoup, vectors: GivenVectors, spec: RemeshSpec) -> Outcome {
    let field = GivenField { vectors, matchings: Vec::new(), branch_points: GivenBranchPoints::Keep };
    let spec = RemeshSpec { field: Some(Arc::new(field)), ..spec };
    let outcome = remesh(&RunContext::silent(), soup, &spec).unwrap();
    assert!(outcome.report.certified && outcome.report.level == Level::L0);
    outcome
}

/// Per quad the angle of its sides from the direction around, modulo a quarter turn, and the length of its sides along that
/// direction over the other ones.
fn sides(outcome: &Outcome) -> Vec<(f64, f64)> {
    let quad = |q: &[u32; 4]| {
        let [a, b, c, d] = q.map(|v| outcome.quads.positions[v as usize]);
        let (mut e, mut f) = (0.5 * (b - a + c - d), 0.5 * (d - a + c - b));
        let [x, y] = around(0.25 * (a + b + c + d), e.cross(f).normalize());
        if e.dot(x).abs() < f.dot(x).abs() {
            (e, f) = (f, e);
        }
        (e.dot(y).atan2(e.dot(x)).rem_euclid(FRAC_PI_2), e.length() / f.length())
    };
    outcome.quads.quads.iter().map(quad).collect()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn quads_follow_crosses_whatever_the_working_mesh() {
    let soup = sample("torus", 3000, 0.0, 0).unwrap();
    for working_mesh in [WorkingMesh::Auto, WorkingMesh::Input] {
        for angle in [0.0, 0.5] {
            let turned = |[x, y]: [DVec3; 2]| [3.0 * (f64::cos(angle) * x + f64::sin(angle) * y), y];
            let crosses = field_of(&soup, turned).iter().map(|frame| frame[0]).collect();
            let spec = RemeshSpec { working_mesh, target: Target::Quads(1200), ..RemeshSpec::default() };
            let outcome = remeshed(&soup, GivenVectors::Crosses(crosses), spec);
            let off = |(a, _): (f64, f64)| {
                let off = (a - angle).rem_euclid(FRAC_PI_2);
                off.min(FRAC_PI_2 - off)
            };
            let off = median(sides(&outcome).into_iter().map(off));
            assert!(off < 0.1, "{working_mesh:?} {angle}: {off}");
            assert!(outcome.map.unwrap().singularities.is_empty());
        }
    }
}

#[test]
fn quads_of_frames_are_as_long_as_these_say() {
    let soup = sample("torus", 3000, 0.0, 0).unwrap();
    let ratio = |factor: f64| {
        let frames = field_of(&soup, |[x, y]| [x, factor * y]);
        // Enough that rounding changes numbers of rows by little.
        let spec = RemeshSpec { target: Target::Quads(4000), ..RemeshSpec::default() };
        median(sides(&remeshed(&soup, GivenVectors::Frames(frames), spec)).into_iter().map(|s| s.1))
    };
    // Gradients twice as long are grid lines twice as close.
    let (even, long) = (ratio(1.0), ratio(2.0));
    assert!((even - 1.0).abs() < 0.2 && (long / even - 2.0).abs() < 0.2, "{even} {long}");
}

#[test]
fn a_given_field_is_mirrored_and_searched_from_where_that_is_asked_for() {
    let soup = sample("torus", 3000, 0.0, 0).unwrap();
    let crosses: Vec<DVec3> = field_of(&soup, |frame| frame).iter().map(|frame| frame[0]).collect();
    let spec = RemeshSpec { symmetry: Symmetry::Across(vec![2]), target: Target::Quads(1200), ..RemeshSpec::default() };
    let mirrored = remeshed(&soup, GivenVectors::Crosses(crosses.clone()), spec);
    assert_eq!(mirrored.report.symmetry.len(), 1);
    let off = |a: f64| a.min(FRAC_PI_2 - a);
    assert!(median(sides(&mirrored).into_iter().map(|s| off(s.0))) < 0.05);
    // A branch point and its opposite in a field without need of them.
    let mut turned = crosses.clone();
    let n = turned.len();
    let normal = |p: usize| {
        let c: Vec<DVec3> = soup.polygon(p).iter().map(|&v| soup.positions[v as usize]).collect();
        (c[1] - c[0]).cross(c[2] - c[0]).normalize()
    };
    turned[n / 2] = glam::DQuat::from_axis_angle(normal(n / 2), FRAC_PI_4 - 0.01) * turned[n / 2];
    let field = GivenField {
        vectors: GivenVectors::Crosses(turned),
        matchings: Vec::new(),
        branch_points: GivenBranchPoints::Optimise,
    };
    let spec = RemeshSpec { field: Some(Arc::new(field)), target: Target::Quads(1200), ..RemeshSpec::default() };
    let outcome = remesh(&RunContext::silent(), &soup, &spec).unwrap();
    assert!(outcome.report.certified && outcome.map.unwrap().singularities.is_empty());
}

#[test]
fn a_field_that_does_not_fit_is_the_requests_fault() {
    let soup = sample("torus", 3000, 0.0, 0).unwrap();
    let field =
        |vectors| Arc::new(GivenField { vectors, matchings: Vec::new(), branch_points: GivenBranchPoints::Keep });
    let n = soup.n_polygons();
    for vectors in [GivenVectors::Crosses(vec![DVec3::X; n + 1]), GivenVectors::Frames(vec![[DVec3::X, DVec3::X]; n])] {
        let spec = RemeshSpec { field: Some(field(vectors)), ..RemeshSpec::default() };
        let error = remesh(&RunContext::silent(), &soup, &spec).unwrap_err();
        assert_eq!((error.fault(), error.spec_field()), (Fault::Request, "field"));
    }
}
