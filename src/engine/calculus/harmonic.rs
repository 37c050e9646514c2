//! Bases of harmonic 1-forms `[tong_2006]` section 3 and appendix B.

use crate::engine::calculus::error::CalculusError;
use crate::engine::calculus::forms::OneForm;
use crate::engine::calculus::homology::{Generator, Side, generators};
use crate::engine::calculus::laplacian::Laplacian;
use crate::engine::calculus::signs::Signs;
use crate::engine::calculus::stars::Stars;
use crate::engine::mesh::TriMesh;
use crate::engine::run::RunContext;

/// Harmonic 1-forms with the generators that they are dual to.
#[derive(Clone, Debug)]
pub struct HarmonicBasis {
    /// Generators of homology, shortest first.
    pub generators: Vec<Generator>,
    /// Form i has integral 1 along generator i and 0 along all others.
    pub forms: Vec<OneForm>,
}

/// The basis of a connected surface of genus g with b boundary loops: 2g forms if it is closed, else 2g + b − 1. All of them by
/// one factorisation. Chains begin at vertex `root`. O(F^1.5 + g F log F).
///
/// # Errors
/// [`CalculusError`] if the run was stopped or the factorisation fails.
///
/// ```
/// use quadrille::engine::calculus::{Side, Stars, harmonic_basis};
/// use quadrille::engine::mesh::shapes::sample_surface;
/// use quadrille::engine::run::RunContext;
///
/// let mesh = sample_surface("torus", 800).expect("a sample").mesh;
/// let stars = Stars::new(&mesh);
/// let basis = harmonic_basis(&RunContext::silent(), &mesh, &stars, Side::Tangential, 0)?;
/// assert_eq!(basis.forms.len(), 2);
/// assert!((basis.forms[0].integral(&basis.generators[0].chain) - 1.0).abs() < 1e-9);
/// # Ok::<(), quadrille::engine::calculus::CalculusError>(())
/// ```
pub fn harmonic_basis(
    ctx: &RunContext,
    mesh: &TriMesh,
    stars: &Stars,
    side: Side,
    root: u32,
) -> Result<HarmonicBasis, CalculusError> {
    let generators = generators(ctx, mesh, side, root)?;
    let is_held: Vec<bool> =
        (0..mesh.n_vertices() as u32).map(|v| side == Side::Normal && mesh.is_boundary_vertex(v)).collect();
    let laplacian = Laplacian::new(mesh, stars, &Signs::trivial(mesh), &is_held)?;
    let mut forms = Vec::with_capacity(generators.len());
    for generator in &generators {
        ctx.check()?;
        forms.push(laplacian.harmonic(mesh, stars, &generator.closed));
    }
    Ok(HarmonicBasis { generators, forms })
}
