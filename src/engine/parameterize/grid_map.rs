//! Maps of a triangle mesh to the plane, chart by chart, with transitions that are quarter turns plus translations.

use glam::{DVec2, I64Vec2};

/// Whether a halfedge must lie on a grid line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Iso {
    /// It need not.
    #[default]
    None,
    /// u is the same integer at both ends, in the chart of the halfedge's own face.
    U,
    /// v is the same integer at both ends, in the chart of the halfedge's own face.
    V,
}

/// An integer-grid map, up to flipped triangles: each face has its own chart; crossing an edge is a quarter turn plus
/// an integer translation; singular vertices, feature corners lie on integer points, feature curves and the boundary
/// on integer lines.
///
/// For a halfedge h of face s with twin in face t, a point of both closed faces has the values
/// `z_s = i^rotation[h] · z_t + translation[h]`. Boundary halfedges have rotation 0 and translation 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridMap {
    /// Per corner `3 f + k`, in grid units (1 = one quad edge), in the chart of face f.
    pub uv: Vec<DVec2>,
    /// Per halfedge, quarter turns 0 to 3.
    pub rotation: Vec<u8>,
    /// Per halfedge, translation in grid units.
    pub translation: Vec<I64Vec2>,
    /// Per halfedge, whether it lies on a grid line (features, boundary).
    pub iso: Vec<Iso>,
}

/// `i^quarters · z`.
pub fn rotate(z: DVec2, quarters: u8) -> DVec2 {
    match quarters & 3 {
        0 => z,
        1 => DVec2::new(-z.y, z.x),
        2 => -z,
        _ => DVec2::new(z.y, -z.x),
    }
}

/// `i^quarters · z` for integer points.
pub fn rotate_integer(z: I64Vec2, quarters: u8) -> I64Vec2 {
    match quarters & 3 {
        0 => z,
        1 => I64Vec2::new(-z.y, z.x),
        2 => -z,
        _ => I64Vec2::new(z.y, -z.x),
    }
}
