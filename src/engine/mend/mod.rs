//! Mending a draft where it is bad.
//!
//! Quads that the judge of the certificate refuses are grouped with their rings into discs. For each disc candidates are
//! tried, the cheapest first: other positions, other connectivity, another filling. All are solved by one solver
//! (`settle`) and judged by one judge (`verdict`); the first that is decent is taken, else the best that is strictly
//! better stays and the disc grows. Nothing outside the discs changes, and topology is kept by construction.

mod cover;
mod ground;
mod patch;
mod refill;
mod regions;
mod sequence;
mod settle;
mod turns;
mod verdict;
mod words;

#[cfg(test)]
mod faults;
#[cfg(test)]
mod tests;

pub use sequence::{MendOptions, Mended, mend};
