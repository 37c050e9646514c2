//! Cross fields: guidance, smoothing, matching, singularities.

mod branch;
mod cleanup;
mod cross_field;
mod curvature;
mod frame_field;
mod frames;
mod given;
mod sizing;
mod smooth;
mod smooth_system;
mod strokes;
mod transfer;
mod turning;

pub use branch::{BranchOptions, BranchSearch, SearchStep, curl_energy};
pub use cross_field::{CrossField, FieldError};
pub use curvature::{Guidance, curvature_guidance};
pub use frame_field::{FrameField, FrameKind};
pub use frames::Frames;
pub use given::{GivenBranchPoints, GivenField, GivenFieldError, GivenMatching, GivenVectors};
pub use sizing::{MAX_GRADIENT, colour_size, curvature_sizes, graded_sizes, quads_of};
pub use smooth::{FieldOptions, smooth_cross_field};
pub use strokes::{StrokeGuidance, stroke_guidance, strokes_off_surface};
pub use transfer::{FieldStart, transfer_field};
