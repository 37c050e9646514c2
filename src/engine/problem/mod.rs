//! What methods are asked for: one connected component of a surface, with the density, the curves and the wishes that its
//! quads are to follow. A problem knows no method; what is changed between two attempts is a changed problem.

mod choices;
mod features;
#[allow(clippy::module_inception)]
mod problem;
mod refinement;
mod sizing;
mod split;

pub use choices::{Align, Boundary, Optimise, Wishes, WorkingMesh};
pub use problem::Problem;
pub use refinement::RefinementPoint;
pub use sizing::size_at;
pub use split::split;
