//! Branch points that are near each other, and where the form around them says that its zeros are.
//!
//! With k branch points at the roots of a polynomial P, in a plane coordinate z, `du = Re(N(z) / √P(z) dz)` with N holomorphic.
//! It has no pole if P divides N. Seen from farther away it looks like the form with the branch points at the roots of P′, the
//! polynomial part of `N² / P`; so these are the next guess (for one branch point, Newton's step for the coefficient of
//! the pole: a design of this program; `u ≈ Re(2 a z^½ + B z^(3/2))` has its zero at `−(4/3) a / B`).

use std::collections::{BTreeSet, VecDeque};

use faer::c64;
use glam::{DVec2, DVec3};

use crate::engine::calculus::{OneForm, Signs};
use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::polynomial::{fitted, product, quotient, roots};

/// Radius around the branch points in edges at most, and as a share of the distance to the next one that does not belong.
const REACH: f64 = 6.0;
const SHARE: f64 = 0.75;
/// Faces nearer to a branch point than this many edges are left out: the discrete form is not smooth there.
const NEAREST: f64 = 1.0;
/// Faces turned away from the tangent plane further than this cosine are not looked at.
const LEAST_FACING: f64 = 0.3;
/// N has this many terms more than P, against the curvature of the form.
const MORE_TERMS: usize = 1;
/// Faces per term at least.
const FACES_PER_TERM: usize = 4;

/// What is seen around some branch points.
pub(super) struct Surroundings {
    /// The vertices around with their places in the tangent plane, model units.
    pub(super) vertices: Vec<(u32, DVec2)>,
    /// Places of the branch points.
    pub(super) now: Vec<DVec2>,
    /// Where they are to go.
    pub(super) aims: Vec<DVec2>,
}

/// A plane in which places have the direction of their projection and their distance in space.
struct Plane {
    at: DVec3,
    x: DVec3,
    y: DVec3,
    normal: DVec3,
}

impl Plane {
    fn new(mesh: &TriMesh, points: &[u32]) -> Self {
        let at = points.iter().map(|&p| mesh.position(p)).sum::<DVec3>() / points.len() as f64;
        let fans = points.iter().flat_map(|&p| mesh.fan(p));
        let normal = fans.map(|h| mesh.area_vector(h / 3)).sum::<DVec3>().try_normalize().unwrap_or(DVec3::Z);
        let x = normal.any_orthonormal_vector();
        Self { at, x, y: normal.cross(x), normal }
    }

    fn place(&self, q: DVec3) -> DVec2 {
        let d = q - self.at;
        let flat = DVec2::new(d.dot(self.x), d.dot(self.y));
        flat.try_normalize().map_or(flat, |direction| direction * d.length())
    }
}

/// A face around: the middle of its places, `∂u/∂x − i ∂u/∂y` on its sheet, √P there, and its area in the plane.
struct Sample {
    z: c64,
    slope: c64,
    root: c64,
    area: f64,
}

/// Looks at the form around the branch points `points`; `next` is the distance to the nearest other one and `edge` the length
/// of edges there, model units. `None` where too little is seen.
pub(super) fn surroundings(
    mesh: &TriMesh,
    signs: &Signs,
    form: &OneForm,
    points: &[u32],
    (next, edge): (f64, f64),
) -> Option<Surroundings> {
    let plane = Plane::new(mesh, points);
    let now: Vec<DVec2> = points.iter().map(|&p| plane.place(mesh.position(p))).collect();
    let extent = now.iter().map(|p| p.length()).fold(0.0, f64::max);
    let radius = extent + (REACH * edge).min(SHARE * next);
    let (samples, vertices) = seen(mesh, signs, form, &plane, (points, &now), radius);
    // In units of the radius, so that the powers are of one size.
    let scaled: Vec<c64> = now.iter().map(|p| c64::new(p.x, p.y) / radius).collect();
    let is_far = |s: &&Sample| scaled.iter().all(|p| (s.z / radius - p).norm() > NEAREST * edge / radius);
    let rows: Vec<(c64, c64, f64)> = samples
        .iter()
        .filter(is_far)
        .map(|s| (s.z / radius, s.slope * s.root, s.area / s.root.norm_sqr().max(f64::MIN_POSITIVE)))
        .collect();
    let degree = points.len();
    if rows.len() < FACES_PER_TERM * (degree + 1 + MORE_TERMS) {
        return None;
    }
    let mut n = fitted(&rows, degree + 1 + MORE_TERMS)?;
    n.truncate(degree + 1);
    let leading = n[degree];
    if leading.norm() <= f64::MIN_POSITIVE {
        return None;
    }
    n.iter_mut().for_each(|c| *c /= leading);
    let p = scaled.iter().fold(vec![c64::new(1.0, 0.0)], |p, &root| product(&p, &[-root, c64::new(1.0, 0.0)]));
    let found = roots(&quotient(&product(&n, &n), &p), &scaled);
    let mut left: Vec<DVec2> = found.iter().map(|z| radius * DVec2::new(z.re, z.im)).collect();
    if left.iter().any(|aim| !aim.is_finite()) {
        return None;
    }
    // Each takes the nearest that is left.
    let mut aims = Vec::with_capacity(degree);
    for place in &now {
        let nearest = (0..left.len()).min_by(|&a, &b| left[a].distance(*place).total_cmp(&left[b].distance(*place)))?;
        aims.push(left.swap_remove(nearest));
    }
    Some(Surroundings { vertices, now, aims })
}

fn seen(
    mesh: &TriMesh,
    signs: &Signs,
    form: &OneForm,
    plane: &Plane,
    (points, now): (&[u32], &[DVec2]),
    radius: f64,
) -> (Vec<Sample>, Vec<(u32, DVec2)>) {
    let places = |f: usize| mesh.face(f).map(|v| plane.place(mesh.position(v)));
    let middle = |f: usize| {
        let m = places(f).iter().sum::<DVec2>() / 3.0;
        c64::new(m.x, m.y)
    };
    let branch: Vec<c64> = now.iter().map(|p| c64::new(p.x, p.y)).collect();
    let start = mesh.outgoing(points[0]) / 3;
    let at = middle(start);
    let first = branch.iter().map(|p| (at - p).sqrt()).fold(c64::new(1.0, 0.0), |a, b| a * b);
    let mut is_seen = BTreeSet::from([start]);
    let mut queue = VecDeque::from([(start, at, first)]);
    let mut vertices: Vec<(u32, DVec2)> = Vec::new();
    let mut known = BTreeSet::new();
    let mut samples = Vec::new();
    while let Some((f, z, root)) = queue.pop_front() {
        let corner = places(f);
        for (v, place) in mesh.face(f).into_iter().zip(corner) {
            if known.insert(v) {
                vertices.push((v, place));
            }
        }
        let (a, b) = (corner[1] - corner[0], corner[2] - corner[0]);
        let twice = a.perp_dot(b);
        if twice > 0.0 {
            let (along_a, along_b) = (form.along[3 * f], -form.along[3 * f + 2]);
            let gradient = (along_a * DVec2::new(b.y, -b.x) + along_b * DVec2::new(-a.y, a.x)) / twice;
            samples.push(Sample { z, slope: c64::new(gradient.x, -gradient.y), root, area: 0.5 * twice });
        }
        for h in 3 * f..3 * f + 3 {
            let Some(g) = mesh.twin(h).map(|t| t / 3) else { continue };
            let z_g = middle(g);
            if z_g.norm() > radius || mesh.normal(g).dot(plane.normal) < LEAST_FACING || !is_seen.insert(g) {
                continue;
            }
            // Each factor of the root goes on along the straight way.
            let ratio = branch.iter().map(|p| ((z_g - p) / (z - p)).sqrt()).fold(c64::new(1.0, 0.0), |a, b| a * b);
            queue.push_back((g, z_g, root * ratio * signs.across(h)));
        }
    }
    (samples, vertices)
}
