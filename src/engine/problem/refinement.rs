//! Places around which quads are to be smaller.

use glam::DVec3;

/// Size of quads around a place without a size of its own, relative to the edge length.
const HALVED: f64 = 0.5;
/// A place has its size within so many times that size,
const RADIUS: f64 = 2.0;
/// and sizes grow by this per edge length beyond: the gradation.
const GRADATION: f64 = 0.3;
/// Places nearer to each other than so many times their size are one.
const APART: f64 = 1.0;

/// A place where quads are to be smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinementPoint {
    /// Where, in model units.
    pub at: DVec3,
    /// Size of the quads there relative to the edge length, 0 to 1.
    pub size: f64,
}

impl From<DVec3> for RefinementPoint {
    /// Quads half as large.
    fn from(at: DVec3) -> Self {
        Self { at, size: HALVED }
    }
}

impl RefinementPoint {
    /// The size, relative to the edge length, that this place asks for at a distance of so many edge lengths.
    pub(super) fn size_at(&self, away: f64) -> f64 {
        self.size + GRADATION * (away - RADIUS * self.size).max(0.0)
    }

    /// Those of the places that are apart from all before them.
    pub(super) fn apart(places: impl Iterator<Item = Self>, edge_length: f64) -> Vec<Self> {
        let mut kept: Vec<Self> = Vec::new();
        for place in places {
            let least = APART * place.size * edge_length;
            if kept.iter().all(|other| other.at.distance(place.at) >= least || other.size > place.size) {
                kept.push(place);
            }
        }
        kept
    }
}
