use glam::DVec3;

use crate::engine::mesh::remesh::edit::EditMesh;
use crate::engine::mesh::remesh::samples::{self, feature_length, flags_per_face};
use crate::engine::mesh::remesh::{IsotropicOptions, remesh_isotropic, remesh_with_middles};
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::numerics::Random;
use crate::engine::run::{Cancelled, RunContext, StopReason};

/// Largest distance from samples of one surface to the other.
fn one_sided(from: &Surface, to: &SurfaceIndex) -> f64 {
    let mesh = &from.mesh;
    let samples = (0..mesh.n_faces()).flat_map(|f| {
        let [a, b, c] = mesh.triangle(f);
        [a, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0]
    });
    samples.map(|p| to.closest(p).distance).fold(0.0, f64::max)
}

/// Number of curve edges (boundary included) at each corner, with its position.
fn corners(surface: &Surface) -> Vec<(DVec3, usize)> {
    let flags = surface.features.halfedge_flags(&surface.mesh);
    let mut degree = vec![0; surface.mesh.n_vertices()];
    for h in (0..surface.mesh.n_halfedges()).filter(|&h| flags[h] && surface.mesh.is_edge_owner(h)) {
        degree[surface.mesh.origin(h) as usize] += 1;
        degree[surface.mesh.target(h) as usize] += 1;
    }
    surface.features.corners.iter().map(|&v| (surface.mesh.position(v), degree[v as usize])).collect()
}

fn check(name: &str, before: &Surface, after: &Surface, options: &IsotropicOptions) {
    assert_eq!(after.mesh.topology(), before.mesh.topology(), "{name}");
    assert_eq!(corners(after), corners(before), "{name}");
    let (old, new) = (SurfaceIndex::new(&before.mesh), SurfaceIndex::new(&after.mesh));
    let error = one_sided(after, &old).max(one_sided(before, &new));
    assert!(error < 2.0 * options.tolerance, "{name}: {error} of {}", options.tolerance);
    for (a, b) in [(feature_length(before), feature_length(after))].map(|(a, b)| [(a.0, b.0), (a.1, b.1)]).concat() {
        assert!((a == 0.0) == (b == 0.0) && b <= a * (1.0 + 1e-9) && b >= 0.97 * a, "{name}: {a} became {b}");
    }
    for f in 0..after.mesh.n_faces() {
        let [a, b, c] = after.mesh.triangle(f);
        let near = old.closest_where((a + b + c) / 3.0, 2.0 * options.tolerance, |face| {
            old.normal(face).dot(after.mesh.normal(f)) > 0.0
        });
        assert!(near.is_some(), "{name}: face {f} is turned");
    }
}

/// Median shape, 1 for equilateral.
fn typical_shape(surface: &Surface) -> f64 {
    let mesh = &surface.mesh;
    let mut shapes: Vec<f64> = (0..mesh.n_faces())
        .map(|f| {
            let p = mesh.triangle(f);
            let sides: f64 = (0..3).map(|k| p[k].distance_squared(p[(k + 1) % 3])).sum();
            4.0 * 3f64.sqrt() * mesh.area(f) / sides
        })
        .collect();
    shapes.sort_unstable_by(f64::total_cmp);
    shapes[shapes.len() / 2]
}

#[test]
fn finer_and_coarser_meshes_keep_topology_curves_and_shape() {
    for (name, surface) in samples::all() {
        let index = SurfaceIndex::new(&surface.mesh);
        let size = surface.mesh.total_area().sqrt();
        for n in [12.0, 40.0] {
            let options = IsotropicOptions::dense(size / n);
            let result = remesh_isotropic(&RunContext::silent(), &surface, &index, &options).unwrap();
            check(name, &surface, &result, &options);
            assert!(flags_per_face(&result).iter().all(|&n| n <= 1), "{name}");
            let ideal = 4.0 / 3f64.sqrt() * n * n;
            let count = result.mesh.n_faces() as f64;
            assert!(count > 0.6 * ideal, "{name}: {count} for {ideal}");
            if n == 40.0 {
                assert!(count < 2.0 * ideal, "{name}: {count} for {ideal}");
                assert!(typical_shape(&result) > 0.9, "{name}: {}", typical_shape(&result));
            }
        }
    }
}

#[test]
fn a_fine_ball_becomes_a_coarse_one() {
    let surface = samples::ball(5, |_| 1.0);
    let index = SurfaceIndex::new(&surface.mesh);
    let options = IsotropicOptions::coarse(0.4);
    let result = remesh_isotropic(&RunContext::silent(), &surface, &index, &options).unwrap();
    check("ball", &surface, &result, &options);
    assert!(result.mesh.n_faces() < 400 && result.mesh.n_faces() > 100, "{}", result.mesh.n_faces());
}

#[test]
fn two_close_sheets_are_not_joined() {
    // The upper and the lower side are much closer than the edges are long.
    let surface = samples::cuboid(DVec3::new(1.0, 1.0, 0.01));
    let index = SurfaceIndex::new(&surface.mesh);
    let options = IsotropicOptions::dense(0.1);
    let result = remesh_isotropic(&RunContext::silent(), &surface, &index, &options).unwrap();
    check("sheet", &surface, &result, &options);
    let sides = result.mesh.positions().iter().filter(|p| p.z != 0.0 && (p.z - 0.01).abs() > 1e-12);
    assert!(sides.filter(|p| p.min_element() > 0.001 && p.truncate().max_element() < 0.999).count() == 0);
}

#[test]
fn a_stopped_run_stops() {
    let surface = samples::torus(24, 12);
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    let index = SurfaceIndex::new(&surface.mesh);
    let result = remesh_isotropic(&ctx, &surface, &index, &IsotropicOptions::dense(0.1));
    assert_eq!(result.unwrap_err(), Cancelled(StopReason::Client));
}

#[test]
fn any_sequence_of_operations_keeps_the_tables_and_the_topology() {
    for (name, surface) in samples::all() {
        let mut mesh = EditMesh::new(&surface);
        let (mut fan_a, mut fan_b) = (Vec::new(), Vec::new());
        let (mut random, mut done) = (Random::new(1), [0; 3]);
        for round in 0..3000 {
            let h = random.below(3 * mesh.faces.len());
            if !mesh.is_alive(h / 3) {
                continue;
            }
            let (a, b) = (mesh.origin(h), mesh.target(h));
            mesh.fan(a, &mut fan_a);
            mesh.fan(b, &mut fan_b);
            if round % 3 == 0 {
                let arc = mesh.segment(h).map_or(0.0, |s| 0.5 * mesh.curves.segment(s).t.iter().sum::<f64>());
                mesh.split(h, 0.5 * (mesh.position(a) + mesh.position(b)), arc);
                done[0] += 1;
            } else if round % 3 == 1 {
                if mesh.may_collapse(h, &fan_a, &fan_b) {
                    mesh.collapse(h, &fan_a);
                    done[1] += 1;
                }
            } else if let Some(t) = mesh.twin(h).filter(|_| mesh.segment(h).is_none()) {
                let (c, d) = (mesh.apex(h), mesh.apex(t));
                let enough = |fan: &[usize]| fan.len() > 3;
                mesh.fan(c, &mut fan_b);
                let joined = mesh.neighbours(&fan_b).any(|n| n == d);
                mesh.fan(b, &mut fan_b);
                if c != d && !joined && enough(&fan_a) && enough(&fan_b) {
                    mesh.flip(h);
                    done[2] += 1;
                }
            }
            if round % 100 == 0 {
                assert_eq!(mesh.fault(), None, "{name}");
            }
        }
        assert_eq!(mesh.fault(), None, "{name}");
        assert!(done.iter().all(|&n| n > 100), "{name}: {done:?}");
        let after = mesh.finish().unwrap().surface;
        assert_eq!(after.mesh.topology(), surface.mesh.topology(), "{name}");
        assert_eq!(corners(&after), corners(&surface), "{name}");
    }
}

#[test]
fn edges_follow_the_size_around_them() {
    let sphere = samples::ball(5, |_| 1.0);
    let index = SurfaceIndex::new(&sphere.mesh);
    let top = DVec3::Z * sphere.mesh.positions().iter().map(|p| p.z).fold(0.0, f64::max);
    let size = |p: DVec3| (0.25 + 0.5 * (p.distance(top) - 0.3).max(0.0)).min(1.0);
    let options = IsotropicOptions::coarse(0.3);
    let graded = remesh_with_middles(&RunContext::silent(), &sphere, &index, &options, Some(&size)).unwrap().surface;
    assert_eq!(graded.mesh.topology(), sphere.mesh.topology());
    let mesh = &graded.mesh;
    let ratio = |h: usize| {
        let (p, q) = (mesh.position(mesh.origin(h)), mesh.position(mesh.target(h)));
        (p.z, p.distance(q) / (0.3 * size(0.5 * (p + q))))
    };
    let ratios: Vec<(f64, f64)> = (0..mesh.n_halfedges()).map(ratio).collect();
    assert!(ratios.iter().all(|r| r.1 < 1.7), "none is much too long");
    for above in [true, false] {
        let mut part: Vec<f64> = ratios.iter().filter(|r| (r.0 > 0.5 * top.z) == above).map(|r| r.1).collect();
        part.sort_unstable_by(f64::total_cmp);
        assert!((0.75..1.2).contains(&part[part.len() / 2]), "the typical one is right: {}", part[part.len() / 2]);
    }
}
