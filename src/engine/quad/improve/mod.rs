//! Making the connectivity of a quad draft more regular.

mod doublets;
mod net;
mod operations;
mod pillow;
mod reach;
mod repair;
mod sequence;
mod shaping;
mod turning;
mod valence;

#[cfg(test)]
mod tests;

pub use doublets::remove_doublets;
pub(crate) use net::{Change, DEAD, QuadNet};
pub(crate) use operations::candidates;
pub use pillow::pillow_quads;
pub use reach::reach_out;
pub use repair::{Bad, count_against, repair_quads};
pub use sequence::improve_connectivity;
pub(crate) use valence::irregularity;
