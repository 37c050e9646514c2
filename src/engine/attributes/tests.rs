use std::f64::consts::TAU;

use glam::DVec3;

use super::*;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::mesh::{Conditioned, Influences, SurfaceIndex, TriangleSoup};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext, StopReason};

/// Which corners of polygons are one vertex.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Vertices {
    /// All those at one place, as files mostly have it.
    Shared,
    /// None.
    OfTheirOwn,
}

/// Polygons as lists of corners with positions and texture coordinates.
pub(super) fn soup(polygons: &[Vec<(DVec3, [f32; 2])>], vertices: Vertices) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    for polygon in polygons {
        let corners: Vec<u32> = polygon
            .iter()
            .map(|&(p, _)| {
                let known = soup.positions.iter().position(|&q| vertices == Vertices::Shared && p == q);
                known.unwrap_or_else(|| {
                    soup.positions.push(p);
                    soup.positions.len() - 1
                }) as u32
            })
            .collect();
        soup.push_polygon(&corners);
        soup.uv.extend(polygon.iter().map(|&(_, uv)| uv));
    }
    soup
}

/// A map of the integer grid from (0, 0) to (n, m) as quads; the second value are texture coordinates as seen from the
/// cell whose lower corner is given.
pub(super) fn grid(
    n: u32,
    m: u32,
    at: impl Fn(u32, u32) -> DVec3,
    uv: impl Fn(u32, u32) -> [f32; 2],
) -> Vec<Vec<(DVec3, [f32; 2])>> {
    let cell = |(i, j): (u32, u32)| {
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| (at(i + a, j + b), uv(i + a, j + b))).to_vec()
    };
    (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).map(cell).collect()
}

pub(super) fn quads(cells: &[Vec<(DVec3, [f32; 2])>]) -> QuadMesh {
    let soup = soup(cells, Vertices::Shared);
    let quads = soup.polygons().map(|corners| corners.try_into().unwrap()).collect();
    QuadMesh { positions: soup.positions, quads }
}

pub(super) fn carried(soup: &TriangleSoup, quads: &QuadMesh) -> QuadAttributes {
    let Conditioned { mesh, polygon, .. } =
        condition(&RunContext::silent(), soup, &ConditionOptions::default()).unwrap();
    let index = SurfaceIndex::new(&mesh);
    let origin = Origin::new(soup, &mesh, &polygon, &index);
    carry(&RunContext::silent(), &origin, quads, &vec![0; quads.quads.len()], Preserve::default()).unwrap()
}

fn linear(p: DVec3) -> [f32; 4] {
    [0.1 + 0.5 * p.x + 0.2 * p.y, 0.9 - 0.6 * p.x, 0.4 * p.y + 0.3 * p.z, 1.0 - 0.5 * p.z].map(|c| c as f32)
}

fn assert_linear(soup: &mut TriangleSoup, quads: &QuadMesh) {
    soup.colours = soup.positions.iter().map(|&p| linear(p)).collect();
    let colours = carried(soup, quads).colours;
    assert_eq!(colours.len(), quads.positions.len());
    for (&p, colour) in quads.positions.iter().zip(&colours) {
        for (a, b) in colour.iter().zip(linear(p)) {
            assert!((a - b).abs() < 1e-6, "{p}: {colour:?} instead of {:?}", linear(p));
        }
    }
}

fn flat(n: u32, m: u32) -> impl Fn(u32, u32) -> DVec3 {
    move |i, j| DVec3::new(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m), 0.0)
}

/// The six sides of the unit cube, n by n cells each.
fn cube(n: u32) -> Vec<Vec<(DVec3, [f32; 2])>> {
    let mut cells = Vec::new();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let at = |i: u32, j: u32| {
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                DVec3::from_array(p)
            };
            let mut own = grid(n, n, at, |i, j| [i as f32, j as f32]);
            own.iter_mut().filter(|_| side == 0.0).for_each(|cell| cell.reverse());
            cells.extend(own);
        }
    }
    cells
}

#[test]
fn linear_colours_stay_linear() {
    let plane = grid(9, 6, flat(9, 6), |_, _| [0.0; 2]);
    for vertices in [Vertices::Shared, Vertices::OfTheirOwn] {
        assert_linear(&mut soup(&plane, vertices), &quads(&grid(7, 11, flat(7, 11), |_, _| [0.0; 2])));
        assert_linear(&mut soup(&cube(4), vertices), &quads(&cube(7)));
    }
    // One polygon that is not convex.
    let corner = |x: f64, y: f64| (DVec3::new(x, y, 0.0), [0.0; 2]);
    let l = vec![
        corner(0.0, 0.0),
        corner(2.0, 0.0),
        corner(2.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, 2.0),
        corner(0.0, 2.0),
    ];
    assert_linear(&mut soup(&[l], Vertices::Shared), &quads(&grid(5, 5, flat(5, 5), |_, _| [0.0; 2])));
}

#[test]
fn faces_that_repairs_flipped_keep_their_colours() {
    // Triangles without area between the two halves of a square, which conditioning has to flip away.
    let at = |x: f64| (DVec3::new(x, 0.5, 0.0), [0.0; 2]);
    let corner = |x: f64, y: f64| (DVec3::new(x, y, 0.0), [0.0; 2]);
    let mut polygons = vec![
        vec![corner(0.0, 0.0), corner(1.0, 0.0), at(1.0)],
        vec![corner(0.0, 0.0), at(1.0), at(0.0)],
        vec![at(0.0), at(1.0), at(0.5)],
        vec![at(0.0), at(0.5), at(0.25)],
    ];
    for (a, b) in [(0.0, 0.25), (0.25, 0.5), (0.5, 1.0)] {
        polygons.push(vec![at(a), at(b), corner(b, 1.0)]);
        polygons.push(vec![at(a), corner(b, 1.0), corner(a, 1.0)]);
    }
    let mut soup = soup(&polygons, Vertices::Shared);
    let repaired = condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
    let is_own = |f: usize| {
        let own = soup.polygon(repaired.polygon[f] as usize);
        repaired.mesh.face(f).iter().all(|&v| own.contains(&repaired.origin[v as usize]))
    };
    assert!(!(0..repaired.mesh.n_faces()).all(is_own), "no face was flipped");
    assert_linear(&mut soup, &quads(&grid(10, 10, flat(10, 10), |_, _| [0.0; 2])));
}

#[test]
fn every_side_of_a_cube_keeps_its_material() {
    let mut soup = soup(&cube(4), Vertices::OfTheirOwn);
    soup.materials = (0..6 * 16).map(|p| 7 - p / 16).collect();
    soup.material_names = (0..8).map(|m| format!("m{m}")).collect();
    let made = carried(&soup, &quads(&cube(5)));
    assert_eq!(made.material_names, ["m2", "m3", "m4", "m5", "m6", "m7"], "names without quads are left out");
    let expected: Vec<u32> = (0..6 * 25).map(|q| 5 - q / 25).collect();
    assert_eq!(made.materials, expected);
    // The name of no material alone is none.
    soup.material_names = vec![String::new(); 8];
    assert!(carried(&soup, &quads(&cube(5))).materials.is_empty());
}

#[test]
fn quads_of_a_thin_wall_look_at_their_own_side() {
    let side = |z: f64| grid(5, 5, move |i, j| flat(5, 5)(i, j) + z * DVec3::Z, |_, _| [0.0; 2]);
    let mut walls = side(0.01);
    walls.extend(side(0.0).into_iter().map(|mut cell| {
        cell.reverse();
        cell
    }));
    for (a, b) in [(DVec3::ZERO, DVec3::X), (DVec3::X, DVec3::ONE), (DVec3::ONE, DVec3::Y), (DVec3::Y, DVec3::ZERO)] {
        for k in 0..5 {
            let at = |k: i32| (a + f64::from(k) / 5.0 * (b - a)).with_z(0.0);
            walls.push(
                [at(k), at(k + 1), at(k + 1) + 0.01 * DVec3::Z, at(k) + 0.01 * DVec3::Z]
                    .map(|p| (p, [0.0; 2]))
                    .to_vec(),
            );
        }
    }
    let mut soup = soup(&walls, Vertices::Shared);
    soup.materials = (0..walls.len()).map(|p| (p / 25).min(2) as u32).collect();
    soup.material_names = ["top", "bottom", "rim"].map(str::to_owned).to_vec();
    // Nearer to the other side than to their own.
    for (z, name) in [(0.003, "top"), (0.007, "bottom")] {
        let mut mesh = quads(&grid(4, 4, |i, j| flat(4, 4)(i, j) + z * DVec3::Z, |_, _| [0.0; 2]));
        if name == "bottom" {
            mesh.quads.iter_mut().for_each(|quad| quad.reverse());
        }
        assert_eq!(carried(&soup, &mesh).material_names, [name]);
    }
}

/// A tube along z whose texture goes around it once, with a seam at angle 0.
pub(super) fn tube(columns: u32, rows: u32, turned: f64) -> Vec<Vec<(DVec3, [f32; 2])>> {
    let at = move |i: u32, j: u32| {
        // The last column is the first one to the last digit.
        let angle = TAU * (f64::from(i % columns) + turned) / f64::from(columns);
        DVec3::new(angle.cos(), angle.sin(), f64::from(j) / f64::from(rows))
    };
    grid(columns, rows, at, move |i, j| [i as f32 / columns as f32, j as f32 / rows as f32])
}

/// Six joints along z, of which every place hangs on the two beside it.
fn chain(z: f64) -> Influences {
    let (below, share) = ((5.0 * z).floor(), (5.0 * z).fract());
    Influences::of([(below as u16, 1.0 - share), (below as u16 + 1, share)]).unwrap()
}

#[test]
fn weights_of_joints_stay_what_they_are_at_their_place() {
    for vertices in [Vertices::Shared, Vertices::OfTheirOwn] {
        let mut soup = soup(&tube(36, 10, 0.0), vertices);
        soup.skin = soup.positions.iter().map(|p| chain(p.z)).collect();
        let mesh = quads(&tube(12, 7, 0.3));
        let made = carried(&soup, &mesh);
        assert_eq!(made.skin.len(), mesh.positions.len());
        for (p, made) in mesh.positions.iter().zip(&made.skin) {
            assert!(made.difference(&chain(p.z)) < 1e-6, "{p}: {made:?} instead of {:?}", chain(p.z));
        }
        // More joints at a place than a vertex may have: what is left are four whose sum is 1.
        soup.skin = (0..soup.positions.len() as u16)
            .map(|v| Influences::of([(2 * v, 0.6), (2 * v + 1, 0.4)]).unwrap())
            .collect();
        for made in carried(&soup, &mesh).skin {
            let sum: f32 = made.weights().iter().sum();
            assert!((sum - 1.0).abs() < 1e-6 && made.weights().is_sorted_by(|a, b| a >= b), "{made:?}");
        }
    }
}

#[test]
fn quads_belong_to_the_object_below_them() {
    let mut soup = soup(&cube(4), Vertices::Shared);
    soup.objects = (0..6 * 16).map(|p| p / 16).collect();
    let made = carried(&soup, &quads(&cube(5)));
    assert_eq!(made.objects, (0..6 * 25).map(|q| q / 25).collect::<Vec<_>>());
}

#[test]
fn what_is_not_there_or_not_wanted_is_not_carried() {
    let mut soup = soup(&cube(2), Vertices::Shared);
    let mesh = quads(&cube(2));
    soup.uv.clear();
    assert!(carried(&soup, &mesh).is_empty());
    soup.colours = vec![[1.0; 4]; soup.positions.len()];
    let Conditioned { mesh: surface, polygon, .. } =
        condition(&RunContext::silent(), &soup, &ConditionOptions::default()).unwrap();
    let index = SurfaceIndex::new(&surface);
    let origin = Origin::new(&soup, &surface, &polygon, &index);
    let with = |ctx: &RunContext, vertex_colours| {
        carry(ctx, &origin, &mesh, &[0; 24], Preserve { vertex_colours, ..Preserve::default() })
    };
    assert!(with(&RunContext::silent(), false).unwrap().is_empty());
    assert_eq!(with(&RunContext::silent(), true).unwrap().colours, vec![[1.0; 4]; 26]);
    let stopped = RunContext::silent();
    stopped.stop(StopReason::Client);
    assert_eq!(with(&stopped, true), Err(Cancelled(StopReason::Client)));
}
