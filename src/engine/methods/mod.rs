//! One folder per family of methods; methods do not use each other.

pub mod quad_cover;
