//! The smoothest crosses for a given matching: one real solve (algorithms.md B.3; [kaelberer_2013] eq. 5.3–5.4).

use crate::engine::field::cross_field::{CrossField, FieldError, residual};
use crate::engine::field::frames::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::Cholesky;
use crate::engine::numerics::HermitianMatrix;

/// Turns the crosses that are not fixed so that `Σ w r²` is least, with a pull towards where they were as strong as
/// their `alignment`; then finds the singularities again.
///
/// # Errors
/// [`FieldError`] if the solve failed.
pub(super) fn polish(
    mesh: &TriMesh,
    frames: &Frames,
    field: &mut CrossField,
    is_fixed: &[bool],
    alignment: &[f64],
) -> Result<(), FieldError> {
    // Residuals are taken on the branch that the matching was chosen on: nearest to zero before it was changed, and one
    // quarter off afterwards, never more than half a turn.
    let mut n = 0u32;
    let unknown: Vec<Option<u32>> = is_fixed
        .iter()
        .map(|fixed| {
            (!fixed).then(|| {
                n += 1;
                n - 1
            })
        })
        .collect();
    let mut entries: Vec<(u32, u32, f64)> = Vec::new();
    let mut rhs = vec![0.0; n as usize];
    for h in 0..mesh.n_halfedges() {
        let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) else { continue };
        let r = residual(mesh, frames, &field.angle, &field.matching, h);
        let length = mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)));
        let area = mesh.area(h / 3) + mesh.area(t / 3);
        let w = if area > 0.0 { (3.0 * length * length / area).min(1e4) } else { 1e4 };
        // w (r + δ_s − δ_t)²
        let (s, t) = (unknown[h / 3], unknown[t / 3]);
        if let Some(s) = s {
            entries.push((s, s, w));
            rhs[s as usize] -= w * r;
        }
        if let Some(t) = t {
            entries.push((t, t, w));
            rhs[t as usize] += w * r;
        }
        if let (Some(s), Some(t)) = (s, t) {
            entries.push((s.max(t), s.min(t), -w));
        }
    }
    for (f, u) in unknown.iter().enumerate() {
        if let Some(u) = *u {
            entries.push((u, u, alignment[f] + 1e-9));
        }
    }
    if n > 0 {
        Cholesky::new(&HermitianMatrix::from_lower(n as usize, &entries))?.solve(&mut rhs);
        for (f, u) in unknown.iter().enumerate() {
            if let Some(u) = *u {
                field.angle[f] += rhs[u as usize];
            }
        }
    }
    field.update_indices(mesh, frames);
    Ok(())
}
