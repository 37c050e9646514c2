//! Files: bytes to a triangle soup, quads and maps to bytes. No file and no socket is touched here, and nothing is
//! ever read but the bytes given and what the caller lets lie beside them ([`Beside`]).

mod archive;
mod beside;
mod corner_values;
mod error;
mod field;
mod format;
mod glb_container;
mod glb_file;
mod glb_looks;
mod glb_skin;
mod gltf;
mod looks;
mod map;
mod map_glb;
mod map_json;
mod map_view;
mod model;
mod ngon;
mod number;
mod obj;
mod ply;
mod precision;
mod quads;
mod quads_glb;
mod quads_obj;
mod quads_usda;
mod read;
mod soup_builder;
mod stl;
mod text_writer;
mod usda;

pub use archive::pack;
pub use beside::{Alone, Beside};
pub use error::ReadError;
pub use field::{FieldFormat, read_field, read_matchings};
pub use format::{Format, MapFormat, QuadFormat};
pub use looks::{Encoding, Image, Look, Looks, Texture};
pub use map::write_map;
pub use map_view::MapView;
pub use model::{Joint, Model, NodeTransform, ObjectName, Scene, Skeleton, SkeletonNode};
pub use quads::{read_quads, write_model, write_quads};
pub use read::{read_model, read_soup};
pub use soup_builder::ReadLimits;

#[cfg(test)]
mod attribute_tests;
#[cfg(test)]
mod tests;
