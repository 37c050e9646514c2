//! A closed surface of genus 0 as a box: six patches between the eight points that reach furthest towards the corners of its
//! bounding box. What a part gets whose quads can show no more of it.

use glam::{DMat3, DVec3};

use crate::engine::mesh::{PrincipalAxes, TriMesh, principal_axes};
use crate::engine::methods::{Level, Method, MethodError, Parameters, Product};
use crate::engine::problem::Problem;
use crate::engine::quad::{Anchor, ArcCourse, LayoutArc, LayoutNode, QuadLayout, Side};
use crate::engine::run::{RunContext, Stage};

/// The sides of a box, counter-clockwise seen from outside; bit k of a corner's number is its side of axis k.
const FACES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// Points of an arc besides its first one.
const STEPS: u32 = 16;
/// Sweeps of turns towards the normals: quadratic convergence needs about five for three axes.
const SWEEPS: usize = 12;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid;

impl Method for Cuboid {
    fn name(&self) -> &'static str {
        "cuboid"
    }

    fn summary(&self) -> &'static str {
        "Six patches between the corners of a box, for closed surfaces of genus 0 that are little more than one."
    }

    fn cannot(&self) -> &'static [&'static str] {
        &["surfaces with a boundary or handles", "follow sharp edges that are not its own", "give a parameterisation"]
    }

    fn level(&self) -> Level {
        Level::L2
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Fallback]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, _: &Parameters) -> Result<Product, MethodError> {
        ctx.check()?;
        let mesh = &problem.surface.mesh;
        let topology = mesh.topology();
        let nothing = |cause: &str| MethodError::Nothing { cause: cause.to_owned(), map: None };
        if topology.boundaries > 0 || topology.genus > 0 {
            return Err(nothing("a box has neither boundary nor handles"));
        }
        let corners = corners(mesh);
        let mut distinct = corners.to_vec();
        distinct.sort_unstable();
        distinct.dedup();
        if distinct.len() < corners.len() {
            return Err(nothing("the surface has fewer than eight corners"));
        }
        let anchor = |v: u32| if problem.surface.features.is_corner(v) { Anchor::Corner(v) } else { Anchor::Surface };
        let node = |v: u32| LayoutNode { position: mesh.position(v), anchor: anchor(v) };
        let mut layout = QuadLayout { nodes: corners.map(node).to_vec(), ..QuadLayout::default() };
        for face in FACES {
            let sides = [0, 1, 2, 3].map(|k| side(problem, &mut layout, face[k], face[(k + 1) % 4]));
            layout.patches.push(sides);
        }
        Ok(Product::Layout(layout))
    }
}

/// The side from one corner to another; its arc is made where it is not there yet.
fn side(problem: &Problem, layout: &mut QuadLayout, a: u32, b: u32) -> Side {
    let ends = [a.min(b), a.max(b)];
    let known = layout.arcs.iter().position(|arc| arc.ends == ends);
    let arc = known.unwrap_or_else(|| {
        let [p, q] = ends.map(|v| layout.nodes[v as usize].position);
        let inner = (1..STEPS).map(|i| problem.index.closest(p.lerp(q, f64::from(i) / f64::from(STEPS))).position);
        let points = std::iter::once(p).chain(inner).chain([q]).collect();
        layout.arcs.push(LayoutArc { ends, points, course: ArcCourse::Surface });
        layout.arcs.len() - 1
    });
    Side { arc: arc as u32, is_reversed: a > b }
}

/// The vertices that reach furthest towards the eight corners of the box along the axes of the surface.
fn corners(mesh: &TriMesh) -> [u32; 8] {
    let PrincipalAxes { centre, mut axes, .. } = principal_axes(mesh);
    for _ in 0..SWEEPS {
        turn_to_normals(mesh, &mut axes);
    }
    let place = |p: DVec3| axes.transpose() * (p - centre);
    let extent = mesh.positions().iter().map(|&p| place(p).abs()).fold(DVec3::splat(f64::MIN_POSITIVE), DVec3::max);
    [0u32, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
        let signs = DVec3::from([0, 1, 2].map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 }));
        let reach = |v: &u32| (place(mesh.position(*v)) / extent).dot(signs);
        (0..mesh.n_vertices() as u32).max_by(|a, b| reach(a).total_cmp(&reach(b)).then(b.cmp(a))).unwrap_or(0)
    })
}

/// Turns the axes, two at a time, to where the sum of `area · (normal · axis)⁴` is largest: the directions that a box's
/// sides face. In a plane that sum is a constant and a multiple of cos 4(α − φ), so the best angle is known (the quartimax
/// rotation of factor analysis). The principal axes of a cube would be any.
fn turn_to_normals(mesh: &TriMesh, axes: &mut DMat3) {
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for f in 0..mesh.n_faces() {
            let (u, v) = (mesh.normal(f).dot(axes.col(i)), mesh.normal(f).dot(axes.col(j)));
            // The fourth power of u + iv.
            let (re, im) = (u * u - v * v, 2.0 * u * v);
            cosine += mesh.area(f) * (re * re - im * im);
            sine += mesh.area(f) * 2.0 * re * im;
        }
        let (s, c) = (0.25 * sine.atan2(cosine)).sin_cos();
        let (a, b) = (axes.col(i), axes.col(j));
        *axes.col_mut(i) = c * a + s * b;
        *axes.col_mut(j) = c * b - s * a;
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn the_corners_of_a_turned_box_are_found() {
        let surface = sample_surface("cube", 600).unwrap();
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7));
        for size in [DVec3::new(1.0, 2.0, 0.5), DVec3::ONE] {
            let positions: Vec<DVec3> = surface.mesh.positions().iter().map(|&p| turn * (size * p)).collect();
            let mesh = TriMesh::try_new(positions, surface.mesh.faces().to_vec()).unwrap();
            let axes = principal_axes(&mesh).axes;
            assert!(
                (axes.determinant() - 1.0).abs() < 1e-9
                    && (axes * axes.transpose() - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-9)
            );
            let mut found = corners(&mesh).to_vec();
            found.sort_unstable();
            assert_eq!(found, surface.features.corners);
        }
    }
}
