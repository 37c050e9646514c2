//! The systems that propose quads. Each is a folder and one line in [`STANDARD`]; methods do not use each other, and know
//! neither the certificate nor what comes after them.

mod coarse;
mod cuboid;
mod data;
mod harmonic;
mod holomorphic;
mod level;
mod method;
mod parameters;
mod product;
pub mod quad_cover;
mod registry;
mod subdivide;
mod triangle_pairs;
mod triangle_split;
mod working;

pub use cuboid::Cuboid;
pub use data::{Data, Shape};
pub use harmonic::Harmonic;
pub use holomorphic::Holomorphic;
pub use level::Level;
pub use method::{Method, MethodError};
pub use parameters::{Parameter, Parameters, Range, Value};
pub use product::{BoundaryLines, MapProduct, Product};
pub use registry::{MethodRef, all, by_name, register};
pub use triangle_pairs::TrianglePairs;
pub use triangle_split::TriangleSplit;
pub use working::{Working, working_surface};

/// The methods of this version; the first one is the default.
pub const STANDARD: &[&dyn Method] =
    &[&quad_cover::QuadCover, &Harmonic, &Holomorphic, &TrianglePairs, &TriangleSplit, &Cuboid];
