//! Every corner's value as a linear form of few unknowns, so that the transitions hold by construction.
//!
//! Unknowns are complex: one value per vertex (in the chart of the first corner of its fan) and one translation per cut
//! segment. Walking the fan counter-clockwise applies `z_t = i^{-m} (z_s − τ)` at every cut edge.

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;
use crate::engine::topology::CutGraph;

/// One term `i^quarters · x[unknown]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Term {
    pub(super) unknown: u32,
    pub(super) quarters: u8,
}

/// A sum of terms, unknowns not repeated more often than the walk met them.
pub(super) type Form = Vec<Term>;

/// The corner values of a cut surface as linear forms.
#[derive(Clone, Debug)]
pub(super) struct CornerForms {
    /// Per corner `3 f + k`. A corner whose vertex is not cut has the single term of its vertex.
    pub(super) corner: Vec<Form>,
    /// Forms that must vanish: the walk around an interior vertex must end where it began.
    pub(super) closures: Vec<Form>,
    /// Number of vertices; unknown `n_vertices + k` is the translation of segment k.
    pub(super) n_vertices: usize,
    /// Number of complex unknowns.
    pub(super) n_unknowns: usize,
}

impl CornerForms {
    pub(super) fn new(mesh: &TriMesh, cut: &CutGraph) -> Self {
        let n_vertices = mesh.n_vertices();
        let mut corner = vec![Form::new(); mesh.n_halfedges()];
        let mut closures = Vec::new();
        for v in 0..n_vertices as u32 {
            let mut form = vec![Term { unknown: v, quarters: 0 }];
            for h in mesh.fan(v) {
                corner[h] = form.clone();
                if !mesh.is_boundary(prev(h)) {
                    cross(&mut form, cut, n_vertices, prev(h));
                }
            }
            if !mesh.is_boundary_vertex(v) && form.len() > 1 {
                // The form after one turn minus the form before it.
                form.push(Term { unknown: v, quarters: 2 });
                closures.push(form);
            }
        }
        Self { corner, closures, n_vertices, n_unknowns: n_vertices + cut.segments.len() }
    }
}

/// Replaces the form in the chart of the face of `h` by the form in the chart of the twin's face.
fn cross(form: &mut Form, cut: &CutGraph, n_vertices: usize, h: usize) {
    let Some((segment, along)) = cut.segment_of[h] else { return };
    let unknown = n_vertices as u32 + segment;
    let m = cut.segments[segment as usize].quarters;
    if along {
        // z_right = i^{-m} (z_left − τ)
        form.push(Term { unknown, quarters: 2 });
        turn(form, 4 - m);
    } else {
        // z_left = i^m z_right + τ
        turn(form, m);
        form.push(Term { unknown, quarters: 0 });
    }
}

pub(super) fn turn(form: &mut Form, quarters: u8) {
    for term in form {
        term.quarters = (term.quarters + quarters) & 3;
    }
}

/// The real and the imaginary part of `Σ i^q z` as sums over real unknowns `2 u` (real part of unknown u) and
/// `2 u + 1` (imaginary part).
pub(super) fn real_parts(form: &[Term]) -> [Vec<(u32, f64)>; 2] {
    let mut parts = [Vec::with_capacity(form.len()), Vec::with_capacity(form.len())];
    for t in form {
        let (x, y) = (2 * t.unknown, 2 * t.unknown + 1);
        let (re, im) = match t.quarters {
            0 => ((x, 1.0), (y, 1.0)),
            1 => ((y, -1.0), (x, 1.0)),
            2 => ((x, -1.0), (y, -1.0)),
            _ => ((y, 1.0), (x, -1.0)),
        };
        parts[0].push(re);
        parts[1].push(im);
    }
    parts
}
