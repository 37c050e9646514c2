//! Extraction from maps that are known exactly, and from the same maps with folds.

mod clean;
mod folded;
mod maps;
