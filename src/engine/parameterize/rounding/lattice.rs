//! The integers in another basis of their lattice, with all that a search in it needs.

use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::rounding::block_search::Blocks;
use crate::engine::parameterize::rounding::gram::{Basis, Gram};
use crate::engine::parameterize::rounding::reduction::reduce;
use crate::engine::parameterize::separation::Separation;

/// With more integers than this, fewer pulls and steps and no search by blocks: each costs the square or the cube of
/// the number.
pub(super) const MANY_INTEGERS: usize = 400;

/// A basis, the period matrix in it, and its blocks.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    pub(super) basis: Basis,
    pub(super) gram: Gram,
    /// Inverse of the matrix in the basis, n × n.
    pub(super) inverse: Vec<f64>,
    pub(super) blocks: Blocks,
}

impl Lattice {
    /// The reduced basis; `None` if there are too many integers, or the matrix is too ill-conditioned.
    pub(super) fn reduced(gram: &Gram) -> Option<Self> {
        if gram.n == 0 || gram.n > MANY_INTEGERS {
            return None;
        }
        let basis = reduce(gram)?;
        let gram = gram.in_basis(&basis);
        let blocks = Blocks::new(&gram)?;
        let inverse = positive_definite_inverse(gram.n, &gram.rows)?;
        Some(Self { basis, gram, inverse, blocks })
    }

    /// The separations as forms in the coordinates of the basis.
    pub(super) fn separations(&self, separations: &[Separation]) -> Vec<Separation> {
        separations.iter().map(|s| Separation { form: self.basis.form(&s.form) }).collect()
    }
}
