//! Branch points where the field can be integrated best (`[kaelberer_2013]` chapter 6).
//!
//! The energy of a matching is what the best seamless map leaves of the field: the curl that no map can follow
//! (`Curl`). It changes when a branch point moves, that is when the matching of one edge turns by a quarter. Its
//! derivative with respect to *all* matchings costs two solves, so whole batches of moves are proposed at once, and the
//! energy is evaluated anew by a numeric factorisation of the same pattern. That measured better than rank-one updates
//! of single moves: a batch holds as many moves as a hundred updates, and rejected batches cost one factorisation.

mod curl;
mod curl_system;
mod moves;
mod search;
mod sides;
#[cfg(test)]
mod tests;

pub use curl::curl_energy;
pub(super) use moves::Surroundings;
pub use search::{BranchOptions, BranchSearch, SearchStep};
pub(super) use search::{Effort, search_branch_points};
