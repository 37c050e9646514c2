//! Discrete exterior calculus on triangles: cochains with their differentials and Hodge stars, generators of homology,
//! bases of harmonic 1-forms, their periods; and the same with signs, for forms on a twofold covering that change their
//! sign under the exchange of its sheets.
//!
//! A 1-form has one value per halfedge, its integral along it as seen from the halfedge's own triangle. Without signs
//! twins have opposite values; across an edge where the sheets are exchanged, equal ones. So forms on the covering are
//! stored on the surface itself, and their Laplacian has one real unknown per vertex.

mod chain;
mod error;
mod forms;
mod harmonic;
mod homology;
mod laplacian;
mod periods;
mod signs;
mod stars;
#[cfg(test)]
mod tests;

pub use chain::Step;
pub use error::CalculusError;
pub use forms::OneForm;
pub use harmonic::{HarmonicBasis, harmonic_basis};
pub use homology::{Generator, Side, generators};
pub use laplacian::Laplacian;
pub use periods::{Periods, dual_basis};
pub use signs::Signs;
pub use stars::Stars;
