//! Mirror planes that a model has: candidates through its centre, refined until the image of the model lies on the model as
//! well as it can (iterated closest points, `[besl_1992]`).

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::engine::mesh::{FaceTree, PrincipalAxes, TriMesh, eigenvectors, principal_axes};
use crate::engine::pipeline::symmetry::planes::MirrorPlane;
use crate::engine::run::{Cancelled, RunContext};

/// Points of the surface, evenly by area, whose images are compared with it, and every so many of them at first.
const SAMPLES: usize = 300;
const FEW: usize = 5;
/// Faces, chosen evenly by area, that stand for the surface until a plane is promising: most models have none, and that is
/// to cost little.
const COARSE_FACES: usize = 8000;
/// Distances from them are too large by up to about the side of their share of the area.
const HOLE: f64 = 1.0;
/// Candidates whose images of samples are further away than this part of the diagonal in the mean are not refined: a turn
/// by ten degrees moves points at half the diagonal by about as much.
const MOST_AT_FIRST: f64 = 0.05;
/// Steps of the refinement with whole rotations, which come near from far away, and of those by Gauss and Newton, which
/// double their digits.
const FAR_STEPS: usize = 4;
const NEAR_STEPS: usize = 5;
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
const MOST_VERTICES: usize = 2048;

/// A plane that a model is nearly symmetric to.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine::pipeline) struct FoundPlane {
    /// The plane.
    pub(in crate::engine::pipeline) plane: MirrorPlane,
    /// How far the images of vertices are from the model at most, as a share of its diagonal.
    pub(in crate::engine::pipeline) away: f64,
}

/// Mirror planes at right angles to each other, at which the image of the model is nowhere further from it than the share
/// `most` of its diagonal; the best first, of equals those across coordinate axes. At most 2,048 vertices are looked at.
///
/// # Errors
/// [`Cancelled`] only.
pub(in crate::engine::pipeline) fn find_planes(
    ctx: &RunContext,
    mesh: &TriMesh,
    most: f64,
) -> Result<Vec<FoundPlane>, Cancelled> {
    let axes = principal_axes(mesh);
    let coarse = Model::new(mesh, axes.centre, COARSE_FACES);
    let mut whole: Option<Model<'_>> = None;
    let mut found: Vec<FoundPlane> = Vec::new();
    let mut tried: Vec<DVec3> = Vec::new();
    for normal in candidates(&axes, &coarse.samples) {
        ctx.check()?;
        if tried.iter().any(|other| other.dot(normal).abs() > SAME_PLANE) {
            continue;
        }
        tried.push(normal);
        let plane = MirrorPlane { normal, offset: normal.dot(axes.centre) };
        let Some(plane) = coarse.refined(plane, most) else { continue };
        let is_known = |known: &FoundPlane| known.plane.normal.dot(plane.normal).abs() > SAME_PLANE;
        if coarse.farthest(&plane) > most * coarse.diagonal + coarse.hole || found.iter().any(is_known) {
            continue;
        }
        let whole = whole.get_or_insert_with(|| Model::new(mesh, axes.centre, usize::MAX));
        let Some(plane) = whole.settled(plane) else { continue };
        let plane = whole.tidied(plane);
        let away = whole.away(&plane, most);
        found.extend((away <= most).then_some(FoundPlane { plane, away }));
    }
    let Some(whole) = whole else { return Ok(Vec::new()) };
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
        let away = whole.away(&plane, most);
        chosen.extend((away <= most).then_some(FoundPlane { plane, away }));
    }
    Ok(chosen)
}

/// A model whose images are compared with it.
struct Model<'a> {
    mesh: &'a TriMesh,
    /// All or some of its faces.
    tree: FaceTree,
    samples: Vec<DVec3>,
    centre: DVec3,
    diagonal: f64,
    /// By how much distances are too large, model units.
    hole: f64,
}

/// A point, the point of the surface next to its image, and the normal there.
type Pair = (DVec3, DVec3, DVec3);

impl<'a> Model<'a> {
    fn new(mesh: &'a TriMesh, centre: DVec3, most_faces: usize) -> Self {
        let (faces, hole) = match mesh.n_faces() > most_faces {
            false => ((0..mesh.n_faces() as u32).collect(), 0.0),
            true => {
                let mut faces: Vec<u32> = evenly(mesh, most_faces).map(|(f, _)| f as u32).collect();
                faces.dedup();
                (faces, HOLE * (mesh.total_area() / most_faces as f64).sqrt())
            }
        };
        let tree = FaceTree::new(mesh, &faces);
        Self { mesh, tree, samples: samples(mesh), centre, diagonal: mesh.diagonal(), hole }
    }

    /// The images of points with their partners, which are there unless there is no surface.
    fn pairs<'p>(&self, plane: &MirrorPlane, points: impl ParallelIterator<Item = &'p DVec3>) -> Vec<Pair> {
        let pair = |&p: &DVec3| {
            let at = self.tree.closest_where(plane.image(p), f64::INFINITY, |_| true)?;
            Some((p, at.position, self.mesh.normal(at.face as usize)))
        };
        let pairs: Vec<Option<Pair>> = points.map(pair).collect();
        pairs.into_iter().flatten().collect()
    }

    fn all_pairs(&self, plane: &MirrorPlane) -> Vec<Pair> {
        self.pairs(plane, self.samples.par_iter())
    }

    /// The plane at which the images of the samples lie best on the surface, near a candidate; `None` if it is far off, or
    /// if they are further away in the mean then than the share `most` of the diagonal.
    fn refined(&self, mut plane: MirrorPlane, most: f64) -> Option<MirrorPlane> {
        let mean = |plane: &MirrorPlane, pairs: &[Pair]| {
            pairs.iter().map(|(p, c, _)| plane.image(*p).distance(*c)).sum::<f64>() / pairs.len().max(1) as f64
        };
        let few = self.pairs(&plane, self.samples.par_iter().step_by(FEW));
        if few.is_empty() || mean(&plane, &few) > MOST_AT_FIRST * self.diagonal {
            return None;
        }
        for _ in 0..FAR_STEPS {
            plane = self.to_points(&self.all_pairs(&plane))?;
        }
        let pairs = self.all_pairs(&plane);
        if mean(&plane, &pairs) > most * self.diagonal + self.hole {
            return None;
        }
        self.settled(plane)
    }

    /// The same from near by.
    fn settled(&self, mut plane: MirrorPlane) -> Option<MirrorPlane> {
        for _ in 0..NEAR_STEPS {
            plane = self.to_planes(&plane, &self.all_pairs(&plane))?;
        }
        Some(plane)
    }

    /// How far the images of the samples are from the surface at most, model units.
    fn farthest(&self, plane: &MirrorPlane) -> f64 {
        let distances = self.all_pairs(plane).into_iter().map(|(p, c, _)| plane.image(p).distance(c));
        distances.fold(0.0, f64::max)
    }

    /// The plane whose images of points are nearest to their partners in sum of squares. With both sets about their means,
    /// that sum is a constant and four times the quadratic form `Σ (n·p)(n·c)`.
    fn to_points(&self, pairs: &[Pair]) -> Option<MirrorPlane> {
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
    fn to_planes(&self, plane: &MirrorPlane, pairs: &[Pair]) -> Option<MirrorPlane> {
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
        self.farthest(plane) <= self.farthest(other) + BETTER * self.diagonal
    }

    /// How far the images of vertices are from the surface at most, as a share of the diagonal; some more than `most` if
    /// more.
    fn away(&self, plane: &MirrorPlane, most: f64) -> f64 {
        let n = self.mesh.n_vertices();
        let step = n.div_ceil(MOST_VERTICES).max(1);
        let points: Vec<DVec3> = self.mesh.positions().iter().copied().step_by(step).collect();
        let mut away: f64 = 0.0;
        for some in points.chunks(SAMPLES) {
            let pairs = self.pairs(plane, some.par_iter());
            away = pairs.into_iter().map(|(p, c, _)| plane.image(p).distance(c)).fold(away, f64::max);
            if away > most * self.diagonal {
                break;
            }
        }
        away / self.diagonal
    }
}

/// The faces in which the `n` shares of the area end, each with the number of shares that do.
fn evenly(mesh: &TriMesh, n: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
    let share = mesh.total_area() / n as f64;
    let (mut sum, mut done) = (0.0, 0);
    (0..mesh.n_faces()).filter_map(move |f| {
        sum += mesh.area(f);
        let due = ((sum / share + 0.5) as usize).min(n);
        let many = due - done;
        done = due;
        (many > 0).then_some((f, many))
    })
}

/// Points of the surface, evenly by area: centroids of triangles, and several points of those that are larger than a share.
fn samples(mesh: &TriMesh) -> Vec<DVec3> {
    let points = evenly(mesh, SAMPLES).flat_map(|(f, many)| {
        let [a, b, c] = mesh.triangle(f);
        (0..many).map(move |i| {
            // The additive sequence of the plastic number fills a triangle evenly.
            let (x, y) = ((0.5 + 0.754_877_666 * i as f64).fract(), (0.5 + 0.569_840_291 * i as f64).fract());
            let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            if many == 1 { (a + b + c) / 3.0 } else { a + x * (b - a) + y * (c - a) }
        })
    });
    points.collect()
}

/// Normals of planes that are worth a look: coordinate axes, principal axes, and where two of their moments are alike, the
/// mirror planes that rotational symmetries of the samples would have.
fn candidates(&PrincipalAxes { centre, axes, moments }: &PrincipalAxes, samples: &[DVec3]) -> Vec<DVec3> {
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
