//! Cross fields: guidance, smoothing, matching, singularities.

mod cleanup;
mod cross_field;
mod curvature;
mod frames;
mod polish;
mod smooth;

pub use cross_field::{CrossField, FieldError};
pub use curvature::{Guidance, curvature_guidance};
pub use frames::Frames;
pub use smooth::{FieldOptions, smooth_cross_field};
