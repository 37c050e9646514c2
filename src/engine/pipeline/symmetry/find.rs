//! Mirror planes that a model has: candidates through its centre, refined until the image of the model lies on the model as
//! well as it can (iterated closest points, `[besl_1992]`).

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::engine::mesh::{PrincipalAxes, SurfaceIndex, TriMesh, eigenvectors, principal_axes};
use crate::engine::pipeline::symmetry::planes::MirrorPlane;
use crate::engine::run::{Cancelled, RunContext};

/// Points of the surface, evenly by area, whose images are compared with it.
const SAMPLES: usize = 400;
/// Candidates whose images of samples are further away than this part of the diagonal in the mean are not refined: a turn
/// by ten degrees moves points at half the diagonal by about as much.
const MOST_AT_FIRST: f64 = 0.06;
/// Steps of the refinement with whole rotations, which come near from far away, and of those by Gauss and Newton, which
/// double their digits.
const FAR_STEPS: usize = 6;
const NEAR_STEPS: usize = 8;
/// Planes this near (radians) to one across a coordinate axis are that, unless it fits worse by `BETTER` diagonals.
const NEARLY_AXIS: f64 = 0.01;
const BETTER: f64 = 0.001;
/// Moments of area that differ by less than this share leave the axes between them open.
const SAME_MOMENT: f64 = 0.05;
/// Orders of rotational symmetry in whose mirror planes is looked then.
const ORDERS: [usize; 4] = [3, 4, 5, 6];
/// Normals with a larger cosine are of the same plane,
const SAME_PLANE: f64 = 0.999;
/// and of planes at right angles with a smaller one.
const RIGHT_ANGLE: f64 = 0.02;
/// Most vertices whose images are looked at in the end.
const MOST_VERTICES: usize = 4096;

/// A plane that a model is nearly symmetric to.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine::pipeline) struct FoundPlane {
    /// The plane.
    pub(in crate::engine::pipeline) plane: MirrorPlane,
    /// How far the images of vertices are from the model at most, as a share of its diagonal.
    pub(in crate::engine::pipeline) away: f64,
}

/// Mirror planes at right angles to each other, at which the image of the model is nowhere further from it than the share
/// `most` of its diagonal; the best first, of equals those across coordinate axes. At most 4,096 vertices are looked at.
///
/// # Errors
/// [`Cancelled`] only.
pub(in crate::engine::pipeline) fn find_planes(
    ctx: &RunContext,
    mesh: &TriMesh,
    most: f64,
) -> Result<Vec<FoundPlane>, Cancelled> {
    let index = SurfaceIndex::new(mesh);
    let PrincipalAxes { centre, .. } = principal_axes(mesh);
    let model = Model { mesh, index: &index, samples: samples(mesh), centre, diagonal: mesh.diagonal() };
    let mut found: Vec<FoundPlane> = Vec::new();
    for normal in candidates(mesh, &model.samples) {
        ctx.check()?;
        let plane = MirrorPlane { normal, offset: normal.dot(centre) };
        let Some(plane) = model.refined(plane) else { continue };
        let plane = model.tidied(plane);
        let is_known = |known: &FoundPlane| known.plane.normal.dot(plane.normal).abs() > SAME_PLANE;
        if !found.iter().any(is_known) {
            let away = model.away(&plane, most);
            found.extend((away <= most).then_some(FoundPlane { plane, away }));
        }
    }
    // Those across coordinate axes count as better by what rounding and triangulation leave.
    let rank = |found: &FoundPlane| found.away - if found.plane.axis().is_some() { BETTER } else { 0.0 };
    found.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    let mut chosen: Vec<FoundPlane> = Vec::new();
    for FoundPlane { plane, .. } in found {
        if chosen.len() == 3 || chosen.iter().any(|c| c.plane.normal.dot(plane.normal).abs() > RIGHT_ANGLE) {
            continue;
        }
        let mut normal = plane.normal;
        for c in &chosen {
            normal = normal.reject_from_normalized(c.plane.normal).normalize();
        }
        let plane = if normal.distance(plane.normal) > 1e-12 { MirrorPlane { normal, ..plane } } else { plane };
        let away = model.away(&plane, most);
        chosen.extend((away <= most).then_some(FoundPlane { plane, away }));
    }
    Ok(chosen)
}

/// A model whose images are compared with it.
struct Model<'a> {
    mesh: &'a TriMesh,
    index: &'a SurfaceIndex,
    samples: Vec<DVec3>,
    centre: DVec3,
    diagonal: f64,
}

impl Model<'_> {
    /// The images of the samples and the points of the surface next to them, with its normals there.
    fn pairs(&self, plane: &MirrorPlane) -> Vec<(DVec3, DVec3, DVec3)> {
        let pair = |&p: &DVec3| {
            let at = self.index.closest(plane.image(p));
            (p, at.position, self.index.normal(at.face))
        };
        self.samples.par_iter().map(pair).collect()
    }

    /// The plane at which the images of the samples lie best on the surface, near a candidate.
    fn refined(&self, mut plane: MirrorPlane) -> Option<MirrorPlane> {
        let pairs = self.pairs(&plane);
        let mean = pairs.iter().map(|(p, c, _)| plane.image(*p).distance(*c)).sum::<f64>() / pairs.len().max(1) as f64;
        if pairs.is_empty() || mean > MOST_AT_FIRST * self.diagonal {
            return None;
        }
        for step in 0..FAR_STEPS + NEAR_STEPS {
            let pairs = self.pairs(&plane);
            plane = if step < FAR_STEPS { self.to_points(&pairs)? } else { self.to_planes(&plane, &pairs)? };
        }
        Some(plane)
    }

    /// The plane whose images of points are nearest to their partners in sum of squares. With both sets about their means,
    /// that sum is a constant and four times the quadratic form `Σ (n·p)(n·c)`.
    fn to_points(&self, pairs: &[(DVec3, DVec3, DVec3)]) -> Option<MirrorPlane> {
        let n = pairs.len() as f64;
        let p_mean = pairs.iter().map(|pair| pair.0).sum::<DVec3>() / n;
        let c_mean = pairs.iter().map(|pair| pair.1).sum::<DVec3>() / n;
        let mut form = [[0.0; 3]; 3];
        for (p, c, _) in pairs {
            let (p, c) = ((*p - p_mean).to_array(), (*c - c_mean).to_array());
            for i in 0..3 {
                for j in 0..3 {
                    form[i][j] += 0.5 * (p[i] * c[j] + p[j] * c[i]);
                }
            }
        }
        let (values, axes) = eigenvectors(form);
        let least = (0..3).min_by(|&i, &j| values[i].total_cmp(&values[j]))?;
        let normal = axes.col(least).try_normalize()?;
        Some(MirrorPlane { normal, offset: 0.5 * normal.dot(p_mean + c_mean) })
    }

    /// A step of Gauss and Newton for the distances of the images from the tangent planes of their partners.
    fn to_planes(&self, plane: &MirrorPlane, pairs: &[(DVec3, DVec3, DVec3)]) -> Option<MirrorPlane> {
        let normal = plane.normal;
        let (s, t) = normal.any_orthonormal_pair();
        let offset = plane.offset - normal.dot(self.centre);
        let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (p, c, up) in pairs {
            // About the centre, so that turns and shifts are of one size.
            let (p, c) = (*p - self.centre, *c - self.centre);
            let height = p.dot(normal) - offset;
            let residual = up.dot(p - 2.0 * height * normal - c);
            let lean = |along: DVec3| -2.0 * (p.dot(along) * up.dot(normal) + height * up.dot(along)) / self.diagonal;
            let row = DVec3::new(lean(s), lean(t), 2.0 * up.dot(normal));
            matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            right -= residual * row;
        }
        // Bodies of revolution leave a turn open.
        let damping = 1e-9 * (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) + f64::MIN_POSITIVE;
        let step = (matrix + DMat3::from_diagonal(DVec3::splat(damping))).inverse() * right;
        if !step.is_finite() {
            return None;
        }
        let turned = (normal + (step.x * s + step.y * t) / self.diagonal).try_normalize()?;
        Some(MirrorPlane { normal: turned, offset: offset + step.z + turned.dot(self.centre) })
    }

    /// The plane with its normal towards the side of larger coordinates, and across a coordinate axis or through the origin
    /// where that fits nearly as well.
    fn tidied(&self, plane: MirrorPlane) -> MirrorPlane {
        let longest = (0..3).max_by(|&i, &j| plane.normal[i].abs().total_cmp(&plane.normal[j].abs())).unwrap_or(0);
        let sign = plane.normal[longest].signum();
        let mut plane = MirrorPlane { normal: sign * plane.normal, offset: sign * plane.offset };
        let axis = DVec3::AXES[longest];
        if plane.normal.angle_between(axis) < NEARLY_AXIS {
            let foot = self.centre + (plane.offset - plane.normal.dot(self.centre)) * plane.normal;
            let across = MirrorPlane { normal: axis, offset: axis.dot(foot) };
            plane = if self.fits_as_well(&across, &plane) { across } else { plane };
        }
        let through = MirrorPlane { offset: 0.0, ..plane };
        if self.fits_as_well(&through, &plane) { through } else { plane }
    }

    fn fits_as_well(&self, plane: &MirrorPlane, other: &MirrorPlane) -> bool {
        let [own, others] = [plane, other].map(|plane| {
            let distances = self.pairs(plane).into_iter().map(|(p, c, _)| plane.image(p).distance(c));
            distances.fold(0.0, f64::max)
        });
        own <= others + BETTER * self.diagonal
    }

    /// How far the images of vertices are from the surface at most, as a share of the diagonal; some more than `most` if
    /// more.
    fn away(&self, plane: &MirrorPlane, most: f64) -> f64 {
        let n = self.mesh.n_vertices();
        let step = n.div_ceil(MOST_VERTICES).max(1);
        let vertices: Vec<u32> = (0..n as u32).step_by(step).collect();
        let mut away: f64 = 0.0;
        for some in vertices.chunks(SAMPLES) {
            let far = |&v: &u32| self.index.closest(plane.image(self.mesh.position(v))).distance;
            away = some.par_iter().map(far).collect::<Vec<_>>().into_iter().fold(away, f64::max);
            if away > most * self.diagonal {
                break;
            }
        }
        away / self.diagonal
    }
}

/// Points of the surface, evenly by area: centroids of triangles.
fn samples(mesh: &TriMesh) -> Vec<DVec3> {
    let share = mesh.total_area() / SAMPLES as f64;
    let (mut sum, mut samples) = (0.0, Vec::with_capacity(SAMPLES));
    for f in 0..mesh.n_faces() {
        sum += mesh.area(f);
        let due = ((sum / share + 0.5) as usize).min(SAMPLES);
        if due > samples.len() {
            // Where a triangle is larger than a share, several points of it.
            let [a, b, c] = mesh.triangle(f);
            let many = due - samples.len();
            samples.extend((0..many).map(|i| {
                // The additive sequence of the plastic number fills a triangle evenly.
                let (x, y) = ((0.5 + 0.754_877_666 * i as f64).fract(), (0.5 + 0.569_840_291 * i as f64).fract());
                let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
                if many == 1 { (a + b + c) / 3.0 } else { a + x * (b - a) + y * (c - a) }
            }));
        }
    }
    samples
}

/// Normals of planes that are worth a look: coordinate axes, principal axes, and where two of their moments are alike, the
/// mirror planes that rotational symmetries of the samples would have.
fn candidates(mesh: &TriMesh, samples: &[DVec3]) -> Vec<DVec3> {
    let PrincipalAxes { centre, axes, moments } = principal_axes(mesh);
    let mut normals: Vec<DVec3> = DVec3::AXES.to_vec();
    normals.extend((0..3).map(|k| axes.col(k)));
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        if (moments[i] - moments[j]).abs() > SAME_MOMENT * moments.max_element() {
            continue;
        }
        let (x, y) = (axes.col(i), axes.col(j));
        for order in ORDERS {
            // The phase of the moment of this order is that of a mirror line.
            let (mut re, mut im) = (0.0, 0.0);
            for p in samples {
                let (u, v) = ((*p - centre).dot(x), (*p - centre).dot(y));
                let (radius, angle) = (u.hypot(v).powi(order as i32), order as f64 * v.atan2(u));
                (re, im) = (re + radius * angle.cos(), im + radius * angle.sin());
            }
            let line = im.atan2(re) / order as f64;
            normals.extend([line, line + PI / order as f64].map(|angle| {
                let (sine, cosine) = (angle + 0.5 * PI).sin_cos();
                cosine * x + sine * y
            }));
        }
    }
    normals
}
