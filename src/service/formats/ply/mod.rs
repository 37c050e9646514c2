//! PLY: reading ASCII and binary, writing binary.

mod body;
mod header;
mod write;

pub(super) use body::read;
pub(super) use write::write;

pub(super) const PLY: &str = "PLY";
