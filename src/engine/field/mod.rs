//! Cross fields: guidance, smoothing, matching, singularities.

mod branch;
mod cleanup;
mod cross_field;
mod curvature;
mod frames;
mod smooth;
mod turning;

pub use branch::{BranchOptions, BranchSearch, curl_energy};
pub use cross_field::{CrossField, FieldError};
pub use curvature::{Guidance, curvature_guidance};
pub use frames::Frames;
pub use smooth::{FieldOptions, smooth_cross_field};
