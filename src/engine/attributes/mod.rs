//! What the input carries besides its shape, brought to the quads: materials, vertex colours, texture coordinates,
//! weights of joints, and which object each quad belongs to; and the normals of the quads, which come from their own shape.
//!
//! Files say these things of corners of polygons. [`Origin`] finds them again at the corners of the conditioned faces;
//! [`carry()`] samples them where the quads are. Borders between materials are features, so no quad crosses them; seams
//! of texture coordinates are not, and a quad that lies on one takes the side of its centre.

mod carry;
mod charts;
mod corner_values;
mod normals;
mod origin;
mod quad_attributes;
#[cfg(test)]
mod seam_tests;
#[cfg(test)]
mod tests;

pub use carry::carry;
pub use normals::corner_normals;
pub use origin::Origin;
pub use quad_attributes::{Preserve, QuadAttributes};
