//! A cross field carried from one mesh of a surface to another.

use faer::c64;
use glam::DVec2;
use rayon::prelude::*;

use crate::engine::field::cross_field::CrossField;
use crate::engine::field::frames::Frames;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriMesh;

/// Least cosine between the normals of a face and of the face of the other mesh that it takes its cross from: thin
/// walls have two sides.
const MIN_AGREEMENT: f64 = 0.3;

/// Crosses to begin with, found on another mesh.
#[derive(Clone, Debug)]
pub struct FieldStart {
    /// Per face `e^{4iθ}` in the frame of the face; 0 where the other mesh has nothing to say.
    pub(super) cross: Vec<c64>,
}

/// The crosses of `field`, which lives on `from`, as seen from the faces of `to`: each face takes that of the nearest
/// face of `from` within `reach` (model units) with about the same normal. O(F log F).
pub fn transfer_field(from: (&TriMesh, &Frames, &CrossField), to: (&TriMesh, &Frames), reach: f64) -> FieldStart {
    let (source, source_frames, field) = from;
    let (mesh, frames) = to;
    let index = SurfaceIndex::new(source);
    let seen = |f: usize| {
        let centre = mesh.triangle(f).iter().sum::<glam::DVec3>() / 3.0;
        let normal = mesh.normal(f);
        let at = index.closest_where(centre, reach, |g| source.normal(g as usize).dot(normal) > MIN_AGREEMENT)?;
        let g = at.face as usize;
        let along = frames.coordinates(f, source_frames.vector(g, DVec2::from_angle(field.angle[g])));
        let angle = 4.0 * along.try_normalize()?.to_angle();
        Some(c64::new(angle.cos(), angle.sin()))
    };
    FieldStart { cross: (0..mesh.n_faces()).into_par_iter().map(|f| seen(f).unwrap_or(c64::new(0.0, 0.0))).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::field::{FieldOptions, smooth_cross_field};
    use crate::engine::mesh::shapes::sample_surface;
    use crate::engine::run::RunContext;

    #[test]
    fn branch_points_come_over_to_a_finer_mesh() {
        for name in ["ellipsoid", "genus2"] {
            let [coarse, fine] = [4000, 16_000].map(|n| sample_surface(name, n).unwrap().mesh);
            let [coarse_frames, fine_frames] = [&coarse, &fine].map(Frames::new);
            let edge_length = (coarse.total_area() / 1000.0).sqrt();
            let solve = |mesh: &TriMesh, frames: &Frames, start: Option<FieldStart>| {
                let flags = vec![false; mesh.n_halfedges()];
                let options = FieldOptions { edge_length, smoothing: 0.9, branch_points: None, strokes: None, start };
                smooth_cross_field(&RunContext::silent(), mesh, frames, &flags, None, &options).unwrap().0
            };
            let field = solve(&coarse, &coarse_frames, None);
            let start = transfer_field((&coarse, &coarse_frames, &field), (&fine, &fine_frames), 0.5 * edge_length);
            let carried = solve(&fine, &fine_frames, Some(start));
            let points = |mesh: &TriMesh, field: &CrossField| -> Vec<(glam::DVec3, i32)> {
                field.singularities().iter().map(|s| (mesh.position(s.vertex), s.quarters)).collect()
            };
            let (there, here) = (points(&coarse, &field), points(&fine, &carried));
            assert_eq!(there.len(), here.len(), "{name}");
            for (p, quarters) in there {
                let near = here.iter().any(|(q, k)| *k == quarters && q.distance(p) < 0.7 * edge_length);
                assert!(near, "{name}: none near {p}");
            }
        }
    }
}
