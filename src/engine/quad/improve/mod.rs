//! Making the connectivity of a quad draft more regular.

mod doublets;
mod facing;
mod net;
mod operations;
mod reach;
mod sequence;
mod shaping;
mod valence;

#[cfg(test)]
mod tests;

pub use doublets::remove_doublets;
pub(crate) use net::{Change, DEAD, QuadNet};
pub(crate) use operations::candidates;
pub use reach::reach_out;
pub use sequence::improve_connectivity;
pub(crate) use valence::irregularity;
