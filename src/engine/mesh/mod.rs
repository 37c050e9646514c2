//! Surfaces: what a file says ([`TriangleSoup`]), what the engine works on ([`TriMesh`]), and what must survive
//! ([`Features`]).

mod canonical;
mod closest;
pub mod condition;
mod conditioned;
mod face_cells;
mod feature_detection;
mod features;
mod handles;
mod influences;
mod locate;
mod paths;
mod principal_axes;
mod refine;
pub mod remesh;
pub mod shapes;
mod soup;
mod tri_mesh;

pub use closest::{closest_on_segment, closest_on_triangle};
pub use conditioned::{Conditioned, Surface, SurfacePart};
pub use face_cells::FaceCells;
pub use feature_detection::{Detected, FeatureOptions, detect_features, detect_features_and_detail, features_of_edges};
pub use features::Features;
pub use handles::{SmallHandle, small_handles};
pub use influences::Influences;
pub use locate::{FaceTree, SurfaceIndex, SurfacePoint};
pub use paths::ShortestPaths;
pub use principal_axes::{PrincipalAxes, eigenvectors, principal_axes};
pub use refine::{Refined, refine};
pub use remesh::{IsotropicOptions, LogSize, remesh_graded, remesh_isotropic, straightened, working_mesh};
pub use soup::TriangleSoup;
pub use tri_mesh::{MeshError, NONE, Topology, TriMesh, next, prev};
