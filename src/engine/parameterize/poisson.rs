//! The energy `Σ w A |∇z − Z|²` of a map whose gradients should be the cross field's, as a quadratic form in the real
//! unknowns of the corner forms (`[kaelberer_2007]` section 4).

use glam::DVec2;

use crate::engine::field::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::parameterize::corner_forms::CornerForms;

/// Gradients of the three hat functions of face `f` in its frame, and its area.
pub(super) fn hat_gradients(mesh: &TriMesh, frames: &Frames, f: usize) -> ([DVec2; 3], f64) {
    let area = frames.area(mesh, f);
    let gradient = std::array::from_fn(|k| frames.edge(mesh, 3 * f + (k + 1) % 3).perp() / (2.0 * area));
    (gradient, area)
}

/// What the gradients of a map are to be on each face, besides their directions.
#[derive(Clone, Debug)]
pub struct FaceTargets {
    /// Length of both gradients per face, in grid units per model unit at scale 1.
    pub length: Vec<f64>,
    /// How closely the map is to follow them, per face.
    pub weight: Vec<f64>,
}

impl From<Vec<f64>> for FaceTargets {
    /// Gradients of length 1 with these weights.
    fn from(weight: Vec<f64>) -> Self {
        Self { length: vec![1.0; weight.len()], weight }
    }
}

/// A quadratic form `xᵀ L x − 2 bᵀ x + constant` in real unknowns, lower triangle of L as summable entries.
#[derive(Clone, Debug, Default)]
pub(super) struct Quadratic {
    pub(super) lower: Vec<(u32, u32, f64)>,
    pub(super) b: Vec<f64>,
    pub(super) constant: f64,
}

/// Assembles the energy. `direction[f]` is the angle of grad u in the frame of face f in the combed chart; grid lines
/// are one model unit apart where the length of the gradients is 1 (scale the right-hand side for other densities).
pub(super) fn assemble(
    mesh: &TriMesh,
    frames: &Frames,
    direction: &[f64],
    targets: &FaceTargets,
    forms: &CornerForms,
) -> Quadratic {
    let mut q = Quadratic { lower: Vec::new(), b: vec![0.0; 2 * forms.n_unknowns], constant: 0.0 };
    q.lower.reserve(mesh.n_faces() * 24);
    for f in 0..mesh.n_faces() {
        let (gradient, area) = hat_gradients(mesh, frames, f);
        let area = area * targets.weight[f];
        let length = targets.length[f];
        q.constant += 2.0 * area * length * length;
        let x = DVec2::from_angle(direction[f]) * length;
        let y = x.perp();
        for k in 0..3 {
            // ∂/∂z_k of 2 Re ∫ ⟨∇z, Z⟩: u pairs with X, v with Y.
            let pull = DVec2::new(gradient[k].dot(x), gradient[k].dot(y)) * area;
            for t in &forms.corner[3 * f + k] {
                let turned = crate::engine::parameterize::rotate(pull, (4 - t.quarters) & 3);
                q.b[2 * t.unknown as usize] += turned.x;
                q.b[2 * t.unknown as usize + 1] += turned.y;
            }
            for l in 0..3 {
                let stiffness = area * gradient[k].dot(gradient[l]);
                for s in &forms.corner[3 * f + k] {
                    for t in &forms.corner[3 * f + l] {
                        add_block(&mut q.lower, s.unknown, t.unknown, (t.quarters + 4 - s.quarters) & 3, stiffness);
                    }
                }
            }
        }
    }
    q
}

/// Adds `value · R^quarters` at the 2×2 block (row, column), lower triangle only. Blocks above the diagonal are left
/// out: their transpose is added when the loop meets the pair the other way round.
fn add_block(lower: &mut Vec<(u32, u32, f64)>, row: u32, column: u32, quarters: u8, value: f64) {
    let (r, c) = (2 * row, 2 * column);
    let entries = match quarters {
        0 => [(r, c, value), (r + 1, c + 1, value)],
        1 => [(r, c + 1, -value), (r + 1, c, value)],
        2 => [(r, c, -value), (r + 1, c + 1, -value)],
        _ => [(r, c + 1, value), (r + 1, c, -value)],
    };
    lower.extend(entries.into_iter().filter(|&(r, c, _)| r >= c));
}
