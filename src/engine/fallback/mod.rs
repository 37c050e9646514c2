//! Quads without a map: what a component gets when nothing better was certified. Always succeeds.

mod draft;
mod matching;
mod pair;
mod subdivide;
#[cfg(test)]
mod tests;

pub use draft::{fallback_draft, split_draft};
