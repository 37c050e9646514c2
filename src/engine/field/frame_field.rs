//! A frame per face of a mesh, as it was given: put on the conditioned surface, carried to other meshes of it, and as the
//! cross field and the gradients that the map is made from.

use faer::c64;
use glam::{DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;

use crate::engine::field::cleanup::mend_sectors;
use crate::engine::field::cross_field::{CrossField, unit};
use crate::engine::field::frames::Frames;
use crate::engine::field::given::{GivenBranchPoints, GivenField, GivenFieldError, GivenVectors};
use crate::engine::field::transfer::FieldStart;
use crate::engine::mesh::{SurfaceIndex, TriMesh, TriangleSoup};
use crate::engine::topology::Matching;

/// Sine of the least angle between a vector and the normal of its face, and between the vectors of a frame: below, rounding
/// chooses the direction.
const LEAST_SINE: f64 = 1e-6;
/// Least cosine between the normals of a face and of the face of the other mesh that it takes its frame from: thin walls
/// have two sides.
const MIN_AGREEMENT: f64 = 0.3;

/// What a frame says besides directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// Nothing: both vectors have length 1 and are at right angles.
    Cross,
    /// Lengths and an angle.
    Skew,
}

/// A frame per face.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameField {
    /// Two vectors in the plane of each face, the second counter-clockwise of the first.
    vectors: Vec<[DVec3; 2]>,
    kind: FrameKind,
    /// Per halfedge the quarter turns across it where they are given; empty if none are.
    quarters: Vec<Option<u8>>,
    branch_points: GivenBranchPoints,
}

impl FrameField {
    /// A given field on the conditioned surface of a soup. `polygon` is the polygon of the soup that each face comes from.
    ///
    /// # Errors
    /// [`GivenFieldError`].
    pub fn on_surface(
        given: &GivenField,
        soup: &TriangleSoup,
        mesh: &TriMesh,
        polygon: &[u32],
    ) -> Result<Self, GivenFieldError> {
        if soup.dropped_by_reader > 0 {
            return Err(GivenFieldError::LeftOut { polygons: soup.dropped_by_reader });
        }
        if given.vectors.len() != soup.n_polygons() {
            return Err(GivenFieldError::Count { given: given.vectors.len(), polygons: soup.n_polygons() });
        }
        let on_face = |f: usize| frame_on(mesh.normal(f), &given.vectors, polygon[f] as usize);
        let found: Vec<_> = (0..mesh.n_faces()).into_par_iter().map(on_face).collect();
        let is_bad = |(f, found): (usize, &Option<_>)| found.is_none().then_some(polygon[f]);
        let bad = sorted(found.iter().enumerate().filter_map(is_bad).collect());
        if !bad.is_empty() {
            return Err(GivenFieldError::Degenerate { polygons: bad });
        }
        let found: Vec<([DVec3; 2], bool)> = found.into_iter().flatten().collect();
        // Directions of a cross are counted around the normal of the polygon, those of a pair from the first to the second.
        let is_reversed = |f: usize| match given.vectors {
            GivenVectors::Crosses(_) => newell(soup, polygon[f] as usize).dot(mesh.normal(f)) < 0.0,
            GivenVectors::Frames(_) => found[f].1,
        };
        let quarters = match given.matchings.is_empty() {
            true => Vec::new(),
            false => quarters(given, mesh, polygon, &(0..mesh.n_faces()).map(is_reversed).collect::<Vec<_>>())?,
        };
        let kind = match given.vectors {
            GivenVectors::Crosses(_) => FrameKind::Cross,
            GivenVectors::Frames(_) => FrameKind::Skew,
        };
        let vectors = found.into_iter().map(|found| found.0).collect();
        Ok(Self { vectors, kind, quarters, branch_points: given.branch_points })
    }

    /// The field of a part of the mesh, from the halfedge of the whole per halfedge of the part.
    pub fn of_part(&self, halfedges: &[u32]) -> Self {
        let vectors = halfedges.iter().step_by(3).map(|&h| self.vectors[h as usize / 3]).collect();
        let of_halfedge = |&h: &u32| self.quarters.get(h as usize).copied().flatten();
        let quarters = if self.quarters.is_empty() { Vec::new() } else { halfedges.iter().map(of_halfedge).collect() };
        Self { vectors, kind: self.kind, quarters, branch_points: self.branch_points }
    }

    /// The field of a model that was moved by a rotation.
    pub fn turned(&self, turn: DMat3) -> Self {
        let vectors = self.vectors.iter().map(|frame| frame.map(|x| turn * x)).collect();
        Self { vectors, ..self.clone() }
    }

    /// The field on another mesh of the same surface: each face takes the frame of the face nearest to its centre with about
    /// the same normal, turned from one plane to the other. Where the other mesh only subdivides faces that is exact;
    /// matchings hold between faces that come from the same face or from neighbours, and others are the smallest turn.
    /// O(F log F).
    pub fn carried(&self, from: &TriMesh, to: &TriMesh) -> Self {
        if from.positions() == to.positions() && from.faces() == to.faces() {
            return self.clone();
        }
        let index = SurfaceIndex::new(from);
        let source = |f: usize| {
            let centre = to.triangle(f).iter().sum::<DVec3>() / 3.0;
            let agrees = |g: u32| from.normal(g as usize).dot(to.normal(f)) > MIN_AGREEMENT;
            let at = index.closest_where(centre, from.diagonal(), agrees).unwrap_or_else(|| index.closest(centre));
            at.face as usize
        };
        let source: Vec<usize> = (0..to.n_faces()).into_par_iter().map(source).collect();
        let turned = |(f, &g): (usize, &usize)| {
            let turn = DQuat::from_rotation_arc(from.normal(g), to.normal(f));
            self.vectors[g].map(|x| in_plane(turn * x, to.normal(f)))
        };
        let vectors = source.iter().enumerate().map(turned).collect();
        let across = |h: usize| {
            let (g, k) = (source[h / 3], source[to.twin(h)? / 3]);
            if g == k {
                return Some(0);
            }
            (3 * g..3 * g + 3).find(|&side| from.twin(side).is_some_and(|t| t / 3 == k)).and_then(|h| self.quarters[h])
        };
        let quarters = if self.quarters.is_empty() { Vec::new() } else { (0..to.n_halfedges()).map(across).collect() };
        Self { vectors, kind: self.kind, quarters, branch_points: self.branch_points }
    }

    /// What becomes of its branch points.
    pub fn branch_points(&self) -> GivenBranchPoints {
        self.branch_points
    }

    /// Whether frames have lengths and angles of their own.
    pub fn kind(&self) -> FrameKind {
        self.kind
    }

    /// Per vertex the logarithm of the size of quads that the lengths ask for, up to a constant; 0 for crosses.
    pub fn sizes(&self, mesh: &TriMesh) -> Vec<f64> {
        if self.kind == FrameKind::Cross {
            return vec![0.0; mesh.n_vertices()];
        }
        let mut sum = vec![(0.0, 0.0); mesh.n_vertices()];
        for (f, [x, y]) in self.vectors.iter().enumerate() {
            let log_size = -0.5 * x.cross(*y).length().ln();
            for v in mesh.face(f) {
                sum[v as usize].0 += mesh.area(f) * log_size;
                sum[v as usize].1 += mesh.area(f);
            }
        }
        sum.into_iter().map(|(sum, area)| sum / f64::max(area, f64::MIN_POSITIVE)).collect()
    }

    /// The frames as the gradients of u and v in the frames of the faces, scaled such that the map has the area of the mesh;
    /// `None` for crosses.
    pub fn gradients(&self, mesh: &TriMesh, frames: &Frames) -> Option<Vec<[DVec2; 2]>> {
        if self.kind == FrameKind::Cross {
            return None;
        }
        let of_face = |f: usize| self.vectors[f].map(|x| frames.coordinates(f, x));
        let plain: Vec<[DVec2; 2]> = (0..mesh.n_faces()).map(of_face).collect();
        let grid: f64 = plain.iter().enumerate().map(|(f, [x, y])| mesh.area(f) * x.perp_dot(*y)).sum();
        let scale = (mesh.total_area() / grid.max(f64::MIN_POSITIVE)).sqrt();
        Some(plain.into_iter().map(|frame| frame.map(|x| x * scale)).collect())
    }

    /// The cross field: of each frame the nearest cross, which has the same index around a vertex. Without given matchings
    /// sectors between features are given the quarter turns of their angles, without which no map follows the features;
    /// `is_feature` is a flag per halfedge.
    pub fn crosses(&self, mesh: &TriMesh, frames: &Frames, is_feature: &[bool]) -> CrossField {
        let plane: Vec<[DVec2; 2]> =
            (0..mesh.n_faces()).map(|f| self.vectors[f].map(|x| frames.coordinates(f, x))).collect();
        let mut field = CrossField::from_angles(mesh, frames, plane.iter().map(nearest_cross).collect());
        field.matching = Matching::from_owners(mesh, |h| {
            let given = self.quarters.get(h).copied().flatten().map(i32::from);
            given.unwrap_or_else(|| smallest_turn(mesh, frames, &plane, h))
        });
        if self.quarters.is_empty() {
            mend_sectors(mesh, frames, &mut field, is_feature);
        }
        field.update_indices(mesh, frames);
        field
    }

    /// The crosses as what a search for branch points begins with.
    pub fn start(&self, mesh: &TriMesh, frames: &Frames) -> FieldStart {
        let cross = |f: usize| -> c64 { unit(4.0 * nearest_cross(&self.vectors[f].map(|x| frames.coordinates(f, x)))) };
        FieldStart { cross: (0..mesh.n_faces()).map(cross).collect() }
    }
}

/// The angle of the cross nearest to a frame: the rotation of its polar decomposition.
fn nearest_cross([x, y]: &[DVec2; 2]) -> f64 {
    let (x, y) = (x.normalize_or_zero(), y.normalize_or_zero());
    (x.y - y.x).atan2(x.x + y.y)
}

/// Quarter turns across halfedge `h` such that directions turn least, in sum over both vectors.
fn smallest_turn(mesh: &TriMesh, frames: &Frames, plane: &[[DVec2; 2]], h: usize) -> i32 {
    let Some(t) = mesh.twin(h) else { return 0 };
    let turn = DVec2::from_angle(frames.transport(mesh, h));
    let [x, y] = plane[h / 3].map(|x| turn.rotate(x.normalize_or_zero()));
    let [p, q] = plane[t / 3].map(DVec2::normalize_or_zero);
    let ahead = [p, q, -p, -q];
    let agreement = |k: usize| x.dot(ahead[k]) + y.dot(ahead[(k + 1) % 4]);
    // Directions of the near face go on as those k further on: z_near = i^-k z_far.
    let best = (0..4).max_by(|&j, &k| agreement(j).total_cmp(&agreement(k)).then(k.cmp(&j))).unwrap_or(0);
    -(best as i32)
}

/// The part of a vector in a plane, as long as the vector.
fn in_plane(x: DVec3, normal: DVec3) -> DVec3 {
    x.reject_from_normalized(normal).normalize_or_zero() * x.length()
}

/// The frame of a face, and whether the second vector had to be reversed to be counter-clockwise of the first; `None` where
/// the vectors span none.
fn frame_on(normal: DVec3, vectors: &GivenVectors, polygon: usize) -> Option<([DVec3; 2], bool)> {
    let tangential = |x: DVec3| {
        let part = x.reject_from_normalized(normal);
        (x.is_finite() && part.length() > LEAST_SINE * x.length()).then_some(part)
    };
    match vectors {
        GivenVectors::Crosses(vectors) => {
            // Of unit length first: squares of very long and very short vectors leave the range of numbers.
            let x = tangential(unit_of(vectors[polygon])?)?.normalize();
            Some(([x, normal.cross(x)], false))
        }
        GivenVectors::Frames(vectors) => {
            let [long, other] = vectors[polygon];
            let (x, y) = (tangential(unit_of(long)?)?, tangential(unit_of(other)?)?);
            let sine = x.cross(y).dot(normal) / (x.length() * y.length());
            let [x, y] = [x * long.length(), y * other.length()];
            let area = x.cross(y).length();
            let is_frame = sine.abs() > LEAST_SINE && area > f64::MIN_POSITIVE && area.is_finite();
            is_frame.then_some(([x, if sine < 0.0 { -y } else { y }], sine < 0.0))
        }
    }
}

fn unit_of(x: DVec3) -> Option<DVec3> {
    let most = x.abs().max_element();
    if x.is_finite() && most > 0.0 { (x / most).try_normalize() } else { None }
}

/// Twice the area vector of a polygon of the soup.
fn newell(soup: &TriangleSoup, polygon: usize) -> DVec3 {
    let corners = soup.polygon(polygon);
    let first = soup.positions[corners[0] as usize];
    let sides = corners.windows(2).map(|w| [w[0], w[1]].map(|v| soup.positions[v as usize] - first));
    sides.map(|[a, b]| a.cross(b)).sum()
}

/// Given matchings per halfedge of the mesh. `is_reversed` says per face that its directions are counted the other way
/// round.
fn quarters(
    given: &GivenField,
    mesh: &TriMesh,
    polygon: &[u32],
    is_reversed: &[bool],
) -> Result<Vec<Option<u8>>, GivenFieldError> {
    let mut pairs: Vec<([u32; 2], usize)> = Vec::new();
    for h in 0..mesh.n_halfedges() {
        if let Some(t) = mesh.twin(h) {
            pairs.push(([polygon[h / 3], polygon[t / 3]], h));
        }
    }
    pairs.sort_unstable();
    let mut quarters = vec![None; mesh.n_halfedges()];
    let mut bad = Vec::new();
    for &matching in &given.matchings {
        let pair = [matching.from, matching.to];
        let first = pairs.partition_point(|p| p.0 < pair);
        let edges = pairs[first..].iter().take_while(|p| p.0 == pair);
        let mut met = 0;
        for &(_, h) in edges {
            let Some(t) = mesh.twin(h) else { continue };
            met += usize::from(is_reversed[h / 3] == is_reversed[t / 3]);
            let k = if is_reversed[h / 3] { 4 - matching.quarters % 4 } else { matching.quarters % 4 };
            (quarters[h], quarters[t]) = (Some((4 - k) & 3), Some(k & 3));
        }
        if met == 0 || matching.from == matching.to || matching.quarters > 3 {
            bad.push(matching.from);
        }
    }
    if bad.is_empty() { Ok(quarters) } else { Err(GivenFieldError::Matching { polygons: sorted(bad) }) }
}

fn sorted(mut items: Vec<u32>) -> Vec<u32> {
    items.sort_unstable();
    items.dedup();
    items
}

#[cfg(test)]
#[path = "given_tests.rs"]
mod tests;
