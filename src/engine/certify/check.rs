//! What can be wrong with a quad mesh.

use glam::DVec3;
use std::fmt::{Display, Formatter};

/// The checks of the certificate, all of them fatal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Check {
    /// A quad does not have four different vertices in range; witnesses are quads.
    FourVertices,
    /// A quad has the same vertices as another; witnesses are quads.
    DuplicateQuad,
    /// A vertex belongs to no quad; witnesses are vertices.
    UnusedVertex,
    /// A coordinate or a measure is not a finite number; witnesses are vertices, or none for a measure.
    Finite,
    /// An edge has more than two quads; witnesses are quads at such edges.
    EdgeFaces,
    /// Two quads run along their edge in the same direction; witnesses are quads at such edges.
    EdgeOrientation,
    /// The quads at a vertex form more than one fan; witnesses are vertices.
    VertexFan,
    /// The number of components differs from the surface's; the count is the difference.
    Components,
    /// The number of boundary loops differs from the surface's; the count is the difference.
    Boundaries,
    /// The genus differs from the surface's; the count is the difference.
    Genus,
    /// A component of the surface has no component of the quads with the same topology over it; witnesses are
    /// components of the surface.
    ComponentMatch,
    /// A quad is flipped against the surface; witnesses are quads.
    Flipped,
    /// A quad has a straight or reflex corner; witnesses are quads.
    Folded,
    /// A quad or a point of the surface is further than two quad edges from the other side; witnesses are quads, the
    /// ones nearest to such points of the surface.
    Far,
    /// A quad has no area; witnesses are quads.
    ZeroArea,
    /// A corner of the feature network is not a vertex of the quads; witnesses are vertices of the surface.
    Corner,
    /// A feature curve is not a chain of quad edges; witnesses are vertices in the middle of curves of the surface.
    FeatureCurve,
    /// A piece of the surface's boundary is not a chain of boundary edges of the quads; witnesses are vertices in
    /// the middle of pieces of the surface's boundary.
    BoundaryCurve,
    /// The boundary loops do not correspond one to one; witnesses are vertices of the quads, one of each such loop.
    BoundaryLoop,
}

impl Check {
    /// What is wrong, with a plural subject before it.
    fn says(self) -> &'static str {
        match self {
            Check::FourVertices => "quads do not have four different vertices in range",
            Check::DuplicateQuad => "quads have the same vertices as another",
            Check::UnusedVertex => "vertices belong to no quad",
            Check::Finite => "numbers are not finite",
            Check::EdgeFaces => "edges have more than two quads",
            Check::EdgeOrientation => "edges have two quads of opposite orientation",
            Check::VertexFan => "vertices have more than one fan of quads",
            Check::Components => "components too many or too few",
            Check::Boundaries => "boundary loops too many or too few",
            Check::Genus => "handles too many or too few",
            Check::ComponentMatch => "components of the surface have no equal among the quads",
            Check::Flipped => "quads are flipped against the surface",
            Check::Folded => "quads have a corner that is straight or reflex",
            Check::Far => "quads are further than two edges from the surface beneath them",
            Check::ZeroArea => "quads have no area",
            Check::Corner => "corners of the surface are not vertices of the quads",
            Check::FeatureCurve => "feature curves are not chains of quad edges",
            Check::BoundaryCurve => "pieces of the boundary are not chains of quad edges",
            Check::BoundaryLoop => "boundary loops of the quads do not correspond to the surface's one to one",
        }
    }
}

/// At most this many places are kept …
const MAX_WITNESSES: usize = 200;
/// … and so many told to people.
const MAX_TOLD: usize = 10;

/// One failed check.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The check that failed.
    pub check: Check,
    /// How often.
    pub count: usize,
    /// The first places, by index; of what, the check says.
    pub witnesses: Vec<u32>,
    /// Where that is, in model units; empty where a check says nothing about places. For a curve: the first point of each
    /// piece that is not followed, which may be more or fewer than the witnesses.
    pub places: Vec<DVec3>,
}

impl Violation {
    /// The violation of `check` at these places, or nothing if there are none.
    pub(super) fn at(check: Check, places: impl IntoIterator<Item = u32>) -> Option<Self> {
        let mut places = places.into_iter();
        let witnesses: Vec<u32> = places.by_ref().take(MAX_WITNESSES).collect();
        let count = witnesses.len() + places.count();
        (count > 0).then_some(Self { check, count, witnesses, places: Vec::new() })
    }

    /// The same with the place of each.
    pub(super) fn at_places(check: Check, places: impl IntoIterator<Item = (u32, DVec3)>) -> Option<Self> {
        let mut places = places.into_iter();
        let (witnesses, at): (Vec<u32>, Vec<DVec3>) = places.by_ref().take(MAX_WITNESSES).unzip();
        let count = witnesses.len() + places.count();
        (count > 0).then_some(Self { check, count, witnesses, places: at })
    }

    /// With these places; the first are kept.
    pub(super) fn with_places(mut self, places: Vec<DVec3>) -> Self {
        self.places = places;
        self.places.truncate(MAX_WITNESSES);
        self
    }

    /// Adds another violation of the same check.
    pub(super) fn join(&mut self, other: Self) {
        self.count += other.count;
        self.witnesses.extend(other.witnesses);
        self.witnesses.truncate(MAX_WITNESSES);
        self.places.extend(other.places);
        self.places.truncate(MAX_WITNESSES);
    }

    /// The violation of `check` if two numbers differ.
    pub(super) fn unequal(check: Check, found: usize, wanted: usize) -> Option<Self> {
        let count = found.abs_diff(wanted);
        (count > 0).then_some(Self { check, count, witnesses: Vec::new(), places: Vec::new() })
    }
}

impl Display for Violation {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.count, self.check.says())?;
        if !self.witnesses.is_empty() {
            let list: Vec<String> = self.witnesses.iter().take(MAX_TOLD).map(u32::to_string).collect();
            write!(f, " (at {}{})", list.join(", "), if self.count > list.len() { ", …" } else { "" })?;
        }
        Ok(())
    }
}
