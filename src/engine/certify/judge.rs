//! Whether one quad stands on the surface as it should: the same predicate for the certificate and for whoever mends.

use crate::engine::certify::footprint::{Ball, Cells, Steps};
use crate::engine::certify::shape::{area_vector, scaled_jacobian};
use crate::engine::mesh::{Surface, SurfaceIndex, SurfacePoint};
use glam::DVec3;

/// A quad further from the surface than this many edges does not stand for the surface beneath it: edges as they were
/// asked for or as they are in the mean, or its own shortest, whichever is longest.
const FAR: f64 = 2.0;
/// A quad has no area if its area is below this part of the square of its longer diagonal: CAD surfaces have slivers,
/// and their quads may be as thin.
const NO_AREA: f64 = 1e-12;
/// A face says which sheet a quad lies on if its normal is within 80 degrees of the quad's (cosine); one at right angles
/// says nothing.
const TELLING: f64 = 0.17;
/// Sheets nearer to each other than this many edges lie in the same place.
const SAME_PLACE: f64 = 1e-3;
/// Quads with edges below this part of the length that the judge was made for are compared with faces, not cells.
const SMALL: f64 = 0.5;
/// Two quads at an edge may turn by 150 degrees (cosine), …
const MAX_TURN: f64 = -0.866_025_403_784_438_6;
/// … or further if the surface turns there by 120 degrees (cosine), which is as much as an average can show.
const SURFACE_TURNS: f64 = -0.5;

/// What is wrong with a quad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Defect {
    /// It has no area.
    ZeroArea,
    /// Its area vector opposes the surface: the faces right beneath it do not all agree with it, and neither does the normal
    /// averaged over its footprint.
    Flipped,
    /// One of its corners is straight or reflex: the least scaled Jacobian is not positive.
    Folded,
    /// Its centre or a corner is further than two edges from the surface: edges as they were asked for or as they are in the
    /// mean, or its own shortest, whichever is longest.
    Far,
}

/// How a quad stands on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Twice the area vector: the cross product of the diagonals.
    pub area: DVec3,
    /// The surface's unit normal: of the faces right beneath the quad if all agree with it, else averaged over what lies
    /// within half an edge of the quad on its own sheet.
    pub up: DVec3,
    /// The largest distance of the centre and the corners from the surface, in model units.
    pub distance: f64,
    /// The least scaled Jacobian of the corners against the quad's own normal, −1 to 1.
    pub jacobian: f64,
    /// What is wrong with the quad, the gravest first named by [`Defect`].
    pub defect: Option<Defect>,
}

/// The judge of single quads over one connected surface, for quads with edges of about one length.
#[derive(Clone, Debug)]
pub struct QuadJudge<'a> {
    surface: &'a Surface,
    index: &'a SurfaceIndex,
    cells: Cells,
    /// Per halfedge, whether it lies on a feature or on the boundary.
    barrier: Vec<bool>,
    /// The length that cells are made for, in model units.
    scale: f64,
    edge_length: f64,
    /// The longest edge by which distances are judged, except a quad's own.
    reach: f64,
}

impl<'a> QuadJudge<'a> {
    /// `index` is the index of `surface.mesh`; `edge_length` is the mean edge of the quads in model units. O(F log F).
    pub fn new(surface: &'a Surface, index: &'a SurfaceIndex, edge_length: f64) -> Self {
        let barrier = surface.features.halfedge_flags(&surface.mesh);
        let scale = scale_of(edge_length);
        let cells = Cells::new(surface, &barrier, scale);
        Self { surface, index, cells, barrier, scale, edge_length, reach: edge_length }
    }

    /// The same judge for quads that were asked for with this edge length.
    pub fn reaching(self, edge_length: f64) -> Self {
        Self { reach: self.reach.max(edge_length), ..self }
    }

    /// What is wrong with the quad with these corners, if anything. Some ten microseconds.
    pub fn defect(&self, corners: &[DVec3; 4]) -> Option<Defect> {
        self.stance(corners).defect
    }

    /// How the quad with these corners stands on the surface.
    pub fn stance(&self, corners: &[DVec3; 4]) -> Stance {
        self.stance_over(corners, &corners.map(|p| self.index.closest(p)))
    }

    /// The same where the points of the surface nearest to the corners are known.
    pub fn stance_over(&self, corners: &[DVec3; 4], feet: &[SurfacePoint; 4]) -> Stance {
        let area = area_vector(*corners);
        let centre = corners.iter().sum::<DVec3>() / 4.0;
        let foot = self.index.closest(centre);
        let own = area.normalize_or_zero();
        let edge = (0..4).map(|k| corners[k].distance(corners[(k + 1) % 4])).sum::<f64>() / 4.0;
        let around = corners.iter().map(|p| p.distance(centre)).sum::<f64>() / 4.0;
        let ball = Ball { centre, radius: around + 0.5 * edge };
        let distance = feet.iter().map(|f| f.distance).fold(foot.distance, f64::max);
        let up = self.up_beneath(own, &foot, feet, distance, edge).unwrap_or_else(|| {
            let start = self.sheet(own, &foot, feet, edge);
            let steps = if edge < SMALL * self.scale { Steps::Faces } else { Steps::Cells };
            self.cells.mean(self.surface, &self.barrier, start, ball, steps)
        });
        let jacobian = scaled_jacobian(*corners);
        let diagonal = corners[0].distance_squared(corners[2]).max(corners[1].distance_squared(corners[3]));
        let defect = if area.length() <= NO_AREA * diagonal {
            Some(Defect::ZeroArea)
        } else if area.dot(up) <= 0.0 {
            Some(Defect::Flipped)
        } else if jacobian <= 0.0 {
            Some(Defect::Folded)
        } else {
            let least = (0..4).map(|k| corners[k].distance(corners[(k + 1) % 4])).fold(f64::INFINITY, f64::min);
            (distance > Defect::far(self.reach.max(least))).then_some(Defect::Far)
        };
        Stance { area, up, distance, jacobian, defect }
    }

    /// The mean normal of the faces right beneath a quad with this unit normal, where all of them agree with it: beneath its
    /// centre and its corners, or only beneath its centre if it lies in the surface. Nothing else around matters then.
    fn up_beneath(
        &self,
        own: DVec3,
        foot: &SurfacePoint,
        feet: &[SurfacePoint; 4],
        distance: f64,
        edge: f64,
    ) -> Option<DVec3> {
        let all = std::iter::once(foot).chain(feet).map(|f| self.index.normal(f.face));
        if all.clone().all(|n| n.dot(own) > TELLING) {
            return Some(all.sum::<DVec3>().normalize_or_zero());
        }
        let face = self.face_in(own, foot, edge).filter(|_| distance <= SAME_PLACE * edge)?;
        Some(self.index.normal(face))
    }

    /// A face of the sheet that a quad with this unit normal lies on: of the faces nearest to its centre and its corners
    /// the one that agrees best with it; where none does, one that agrees and lies in the same place, or else the one
    /// beneath the centre.
    fn sheet(&self, own: DVec3, foot: &SurfacePoint, feet: &[SurfacePoint; 4], edge: f64) -> u32 {
        let agrees = |face: u32| self.index.normal(face).dot(own);
        let mut best = (agrees(foot.face), foot.face);
        for other in feet {
            let agreement = agrees(other.face);
            if agreement > best.0 {
                best = (agreement, other.face);
            }
        }
        if best.0 > TELLING {
            return best.1;
        }
        self.face_in(own, foot, edge).unwrap_or(foot.face)
    }

    /// A face at the place beneath the centre of a quad with this unit normal that agrees with it.
    fn face_in(&self, own: DVec3, foot: &SurfacePoint, edge: f64) -> Option<u32> {
        let agrees = |face: u32| self.index.normal(face).dot(own) > TELLING;
        if agrees(foot.face) {
            return Some(foot.face);
        }
        self.index.closest_where(foot.position, SAME_PLACE * edge, agrees).map(|p| p.face)
    }

    /// Whether two quads at an edge lie folded on each other: they turn by more than 150 degrees and the surface does not.
    /// Edges on kept features need not be asked about.
    pub fn lie_on_each_other(&self, a: &Stance, b: &Stance) -> bool {
        let turned = a.area.normalize_or_zero().dot(b.area.normalize_or_zero());
        turned < MAX_TURN && a.up.dot(b.up) > SURFACE_TURNS
    }

    /// The mean edge of the quads that the judge was made for.
    pub fn edge_length(&self) -> f64 {
        self.edge_length
    }
}

/// The length that cells are made for: one of two per octave, so that quads that are mended are judged as they were before,
/// though their mean edge is another.
fn scale_of(edge_length: f64) -> f64 {
    let scale = ((2.0 * edge_length.log2()).round() / 2.0).exp2();
    if scale.is_finite() { scale } else { edge_length }
}

impl Defect {
    /// The distance beyond which a quad is [`Defect::Far`], in model units.
    pub(super) fn far(edge_length: f64) -> f64 {
        FAR * edge_length
    }
}
