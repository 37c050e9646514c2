//! The free meta-parameters that make the map as conformal as its graph allows (`[tong_2006]` appendix C and section 4): of all
//! extents that close the meta-faces, those with the least ‖du − ⋆dv‖² for the size that the lengths ask for.
//!
//! The map is linear in the extents, so this is a quadratic form in the free ones: a harmonic map for each, all by one
//! factorisation. Real extents are the result; integers are looked for around them.

use crate::engine::mesh::NONE;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::SingularityGraph;
use crate::engine::methods::harmonic::solve::OnMesh;
use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::gradients;
use crate::engine::run::RunContext;

/// Most free parameters: each costs a solve, and each pair a sum over all triangles.
const MOST_FREE: usize = 150;
/// Weight of the lengths against the energy: it decides where the energy does not.
const LENGTHS: f64 = 1e-4;
/// Shortest target: extents are positive.
const SHORTEST: f64 = 0.05;
/// Entries below this are rounding errors of an elimination of entries 0, 1 and −1.
const NOTHING: f64 = 1e-9;

/// Sets the real lengths of the graph's edges to the extents of the most conformal map. Whether there were few enough free
/// parameters for it.
///
/// # Errors
/// [`HarmonicError`] if nothing holds the map or the run was stopped.
pub(super) fn conformal_extents(ctx: &RunContext, on: &OnMesh<'_>) -> Result<Option<Vec<f64>>, HarmonicError> {
    let basis = closed_extents(on.graph);
    let n = basis.len();
    if n == 0 || n > MOST_FREE {
        return Ok(None);
    }
    ctx.check()?;
    let maps = on.maps(&basis)?;
    ctx.check()?;
    // ‖du − ⋆dv‖² = Σ A (|∇u|² + |∇v|² − 2 ∇u × ∇v), of two maps half of what mixes them.
    let mut form = vec![0.0; n * n];
    for f in 0..on.mesh.n_faces() {
        let area = on.frames.area(on.mesh, f);
        // With ∇u − rotated ∇v as one vector per map the form is their scalar product.
        let parts: Vec<_> = maps
            .iter()
            .map(|uv| {
                let (du, dv) = gradients(on.mesh, on.frames, uv, f);
                du + dv.perp()
            })
            .collect();
        for i in 0..n {
            for j in 0..=i {
                form[i * n + j] += area * parts[i].dot(parts[j]);
            }
        }
    }
    let weight = |real: f64| 1.0 / (real + 0.1);
    let real: Vec<f64> = on.graph.edges.iter().map(|edge| edge.real).collect();
    let product = |a: &[f64], b: &[f64]| -> f64 { (0..real.len()).map(|e| weight(real[e]) * a[e] * b[e]).sum() };
    let trace: f64 = (0..n).map(|i| form[i * n + i]).sum();
    let lengths: f64 = (0..n).map(|i| product(&basis[i], &basis[i])).sum();
    let small = LENGTHS * trace / lengths.max(f64::MIN_POSITIVE);
    for i in 0..n {
        for j in 0..=i {
            form[i * n + j] += small * product(&basis[i], &basis[j]);
            form[j * n + i] = form[i * n + j];
        }
    }
    let Some(inverse) = positive_definite_inverse(n, &form) else { return Ok(None) };
    let pull: Vec<f64> = basis.iter().map(|b| product(b, &real)).collect();
    let x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| inverse[i * n + j] * pull[j]).sum()).collect();
    let size: f64 = x.iter().zip(&pull).map(|(x, p)| x * p).sum();
    if size <= 0.0 {
        return Ok(None);
    }
    let scale = product(&real, &real) / size;
    let extent = |e: usize| scale * basis.iter().zip(&x).map(|(b, x)| b[e] * x).sum::<f64>();
    Ok(Some((0..real.len()).map(|e| extent(e).max(SHORTEST)).collect()))
}

/// A basis of all extents that close every meta-face: Gauss elimination of the two equations of each, redundant ones fall
/// away (`[tong_2006]` section 3.3).
fn closed_extents(graph: &SingularityGraph) -> Vec<Vec<f64>> {
    let n = graph.edges.len();
    let mut rows: Vec<Vec<f64>> = vec![vec![0.0; n]; 2 * graph.faces.len()];
    for (e, edge) in graph.edges.iter().enumerate() {
        for (face, tag) in edge.faces.into_iter().zip(edge.tags).filter(|(face, _)| *face != NONE) {
            rows[2 * face as usize + usize::from(tag % 2)][e] += if tag < 2 { 1.0 } else { -1.0 };
        }
    }
    let mut pivot_of = vec![None; n];
    let mut done = 0;
    for e in 0..n {
        let best = (done..rows.len()).max_by(|&a, &b| rows[a][e].abs().total_cmp(&rows[b][e].abs()).then(b.cmp(&a)));
        let Some(row) = best.filter(|&row| rows[row][e].abs() > NOTHING) else { continue };
        rows.swap(done, row);
        let pivot = rows[done][e];
        rows[done].iter_mut().for_each(|x| *x /= pivot);
        let own = rows[done].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(other, _)| *other != done) {
            let factor = row[e];
            if factor != 0.0 {
                row.iter_mut().zip(&own).for_each(|(x, y)| *x -= factor * y);
            }
        }
        pivot_of[e] = Some(done);
        done += 1;
    }
    let free = (0..n).filter(|&e| pivot_of[e].is_none());
    let vector = |e: usize| {
        let mut vector = vec![0.0; n];
        vector[e] = 1.0;
        for (other, row) in pivot_of.iter().enumerate() {
            vector[other] = row.map_or(vector[other], |row| -rows[row][e]);
        }
        vector
    };
    free.map(vector).collect()
}
