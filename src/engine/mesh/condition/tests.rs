use std::f64::consts::PI;

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::engine::mesh::Conditioned;
use crate::engine::mesh::TriangleSoup;
use crate::engine::run::Blame;
use crate::engine::run::Fault;
use crate::engine::run::RunContext;
use crate::engine::run::StopReason;

pub(super) fn run(soup: &TriangleSoup) -> Result<Conditioned, ConditionError> {
    condition(&RunContext::silent(), soup, &ConditionOptions::default())
}

pub(super) fn count(c: &Conditioned, name: &str) -> usize {
    c.repairs.iter().find(|r| r.0 == name).map_or(0, |r| r.1)
}

/// Everything that must hold of any result; that it is a manifold is held by its type.
pub(super) fn check(soup: &TriangleSoup, c: &Conditioned) {
    let mesh = &c.mesh;
    assert_eq!((c.polygon.len(), c.origin.len()), (mesh.n_faces(), mesh.n_vertices()));
    assert!(mesh.n_faces() > 0);
    assert!(c.polygon.iter().all(|&p| (p as usize) < soup.n_polygons()));
    // Of the soup: shards that go may have made most of it.
    let finite = || soup.positions.iter().filter(|p| p.is_finite());
    let (low, high) = finite().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let diagonal = low.distance(high);
    for f in 0..mesh.n_faces() {
        let [a, b, c] = mesh.triangle(f);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = 2.0 * mesh.area(f) / longest;
        assert!(height > 0.99e-6 * longest, "face {f} has shape {}", height / longest);
        assert!((mesh.normal(f).length() - 1.0).abs() < 1e-12);
    }
    for (v, &origin) in c.origin.iter().enumerate() {
        let d = mesh.position(v as u32).distance(soup.positions[origin as usize]);
        assert!(d <= 0.5 * diagonal, "vertex {v} is {d} from its origin");
    }
}

pub(super) fn good(soup: &TriangleSoup) -> Conditioned {
    let c = run(soup).unwrap();
    check(soup, &c);
    c
}

pub(super) const BOX: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

pub(super) fn add_box(soup: &mut TriangleSoup, corner: DVec3, size: f64) {
    let base = soup.positions.len() as u32;
    let bit = |i: u32, k: u32| f64::from(i >> k & 1);
    soup.positions.extend((0..8).map(|i| corner + size * DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))));
    for q in BOX {
        soup.push_polygon(&q.map(|i| base + i));
    }
}

pub(super) fn unit_box() -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    add_box(&mut soup, DVec3::ZERO, 1.0);
    soup
}

/// The same polygons, each corner a position of its own.
pub(super) fn exploded(soup: &TriangleSoup) -> TriangleSoup {
    let mut out = TriangleSoup::default();
    for polygon in soup.polygons() {
        let base = out.positions.len() as u32;
        out.positions.extend(polygon.iter().map(|&v| soup.positions[v as usize]));
        out.push_polygon(&(base..out.positions.len() as u32).collect::<Vec<u32>>());
    }
    out
}

/// Positions at the same place become one index, as in a soup that names shared corners.
pub(super) fn merged(soup: &TriangleSoup) -> TriangleSoup {
    let mut out = TriangleSoup::default();
    for polygon in soup.polygons() {
        let ring: Vec<u32> = polygon
            .iter()
            .map(|&v| {
                let p = soup.positions[v as usize];
                let known = out.positions.iter().position(|&q| q == p);
                known.unwrap_or_else(|| {
                    out.positions.push(p);
                    out.positions.len() - 1
                }) as u32
            })
            .collect();
        out.push_polygon(&ring);
    }
    out
}

/// How the ends of a strip meet.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ends {
    Straight,
    Mirrored,
}

/// Whether the sides of a strip meet.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sides {
    Open,
    Closed,
}

/// An n × m grid of quads whose ends meet: with closed sides a torus or a Klein bottle, with open ones an annulus or a
/// Möbius strip.
pub(super) fn strip(n: u32, m: u32, ends: Ends, sides: Sides) -> TriangleSoup {
    let (mirrored, open) = (ends == Ends::Mirrored, sides == Sides::Open);
    let rows = if open { m + 1 } else { m };
    let mut soup = TriangleSoup::default();
    for i in 0..n {
        for j in 0..rows {
            let (s, t) = (2.0 * PI * f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
            let (across, up) = if open {
                let half = if mirrored { 0.5 * s } else { 0.0 };
                ((t - 0.5) * half.cos(), (t - 0.5) * half.sin())
            } else {
                ((2.0 * PI * t).cos(), (2.0 * PI * t).sin())
            };
            let radius = 3.0 + across;
            soup.positions.push(DVec3::new(radius * s.cos(), radius * s.sin(), up));
        }
    }
    for i in 0..n {
        for j in 0..m {
            let at = |di: u32, dj: u32| {
                let (mut j, i) = ((j + dj) % rows, i + di);
                if i == n && mirrored {
                    j = if open { m - j } else { (m - j) % m };
                }
                (i % n) * rows + j
            };
            soup.push_polygon(&[at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
        }
    }
    soup
}

#[test]
fn a_cube_of_quads_is_a_sphere_without_repairs() {
    let c = good(&unit_box());
    assert_eq!(c.mesh.topology().euler, 2);
    assert_eq!(c.mesh.n_faces(), 12);
    assert!(c.repairs.is_empty(), "{:?}", c.repairs);
    assert_eq!(c.polygon, (0..12).map(|f| f / 2).collect::<Vec<u32>>());
}

#[test]
fn clean_input_comes_back_in_its_order() {
    let soup = good(&strip(12, 8, Ends::Straight, Sides::Closed)).mesh;
    let again = TriangleSoup::from_triangles(soup.positions().to_vec(), soup.faces());
    let c = good(&again);
    assert_eq!((c.mesh.positions(), c.mesh.faces()), (soup.positions(), soup.faces()));
    assert!(c.repairs.is_empty());
    assert_eq!(c.mesh.topology().genus, 1);
}

#[test]
fn results_do_not_depend_on_units() {
    let mut soup = exploded(&strip(9, 5, Ends::Straight, Sides::Open));
    soup.positions.iter_mut().enumerate().for_each(|(i, p)| p.x += 1e-8 * (i % 7) as f64);
    let c = good(&soup);
    assert!(count(&c, "vertices_welded_nearly") > 0);
    for scale in [1e-6, 1e6] {
        let mut scaled = soup.clone();
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        let s = good(&scaled);
        assert_eq!((s.mesh.faces(), s.repairs), (c.mesh.faces(), c.repairs.clone()));
    }
}

#[test]
fn triangles_without_shared_corners_are_welded() {
    let c = good(&exploded(&unit_box()));
    let t = c.mesh.topology();
    assert_eq!((c.mesh.n_vertices(), t.components, t.boundaries, t.euler), (8, 1, 0, 2));
    assert_eq!(count(&c, "vertices_welded"), 16);
}

#[test]
fn soups_without_a_surface_are_refused_with_the_reason() {
    assert_eq!(run(&TriangleSoup::default()).unwrap_err(), ConditionError::Empty);
    let triangle = |p: [DVec3; 3]| TriangleSoup::from_triangles(p.to_vec(), &[[0, 1, 2]]);
    let error = |p| run(&triangle(p)).unwrap_err();
    assert_eq!(error([DVec3::NAN; 3]), ConditionError::AllNotFinite { polygons: 1 });
    assert_eq!(error([DVec3::ONE; 3]), ConditionError::ZeroArea { polygons: 1 });
    assert_eq!(error([DVec3::ZERO, DVec3::X, 3.0 * DVec3::X]), ConditionError::ZeroArea { polygons: 1 });
    assert_eq!(error([DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-12, 0.0)]), ConditionError::ZeroArea { polygons: 1 });
    assert!(matches!(error([DVec3::ZERO, DVec3::X * 1e90, DVec3::Y * 1e90]), ConditionError::Extent { .. }));
    assert!(good(&triangle([DVec3::ZERO, DVec3::X, DVec3::Y])).mesh.n_faces() == 1);
}

#[test]
fn a_stopped_run_stops() {
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    let error = condition(&ctx, &unit_box(), &ConditionOptions::default()).unwrap_err();
    assert_eq!(error.fault(), Fault::Cancelled);
}

/// Polygons over few places of a coarse grid: every kind of degeneracy at once.
fn random_soup() -> impl Strategy<Value = TriangleSoup> {
    let position = (0..4i32, 0..4i32, 0..3i32, 0..6i32);
    let polygon = proptest::collection::vec(0..1000u32, 3..7);
    (proptest::collection::vec(position, 3..24), proptest::collection::vec(polygon, 1..60)).prop_map(
        |(places, polygons)| {
            let jitter = |k: i32| match k {
                0 => 1e-13,
                1 => 1e-8,
                _ => 0.0,
            };
            let place = |&(x, y, z, k): &(i32, i32, i32, i32)| {
                DVec3::new(f64::from(x) + jitter(k), f64::from(y), f64::from(z) - jitter(k))
            };
            let mut soup = TriangleSoup { positions: places.iter().map(place).collect(), ..TriangleSoup::default() };
            for polygon in polygons {
                soup.push_polygon(&polygon.iter().map(|i| i % places.len() as u32).collect::<Vec<u32>>());
            }
            soup
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_soup_becomes_a_manifold_or_is_refused(soup in random_soup()) {
        for soup in [soup.clone(), exploded(&soup)] {
            let options = ConditionOptions { cut_non_orientable: true };
            match condition(&RunContext::silent(), &soup, &options) {
                Ok(c) => {
                    check(&soup, &c);
                    let again = condition(&RunContext::silent(), &soup, &options).unwrap();
                    prop_assert_eq!(c.mesh.faces(), again.mesh.faces());
                    prop_assert_eq!(c.mesh.positions(), again.mesh.positions());
                }
                Err(error) => prop_assert!(error.fault() == Fault::Input, "{}", error),
            }
            if let Err(error) = run(&soup) {
                prop_assert!(error.fault() == Fault::Input, "{}", error);
            }
        }
    }
}
