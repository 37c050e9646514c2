//! The values that fields of the spec may take, as spelt in JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Which system runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MethodName {
    /// Frame fields on a branched covering, integrated and rounded.
    #[default]
    Quadcover,
    /// Not available in this version.
    Harmonic,
    /// Not available in this version.
    Holomorphic,
    /// Not available in this version.
    Layout,
}

impl MethodName {
    /// The name in JSON and in flags.
    pub fn name(self) -> &'static str {
        match self {
            MethodName::Quadcover => "quadcover",
            MethodName::Harmonic => "harmonic",
            MethodName::Holomorphic => "holomorphic",
            MethodName::Layout => "layout",
        }
    }
}

/// The density asked for: `{"quads": N}` or `{"edge_length": L}`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TargetBody {
    /// Quads of the whole model, 1 to 10 000 000.
    Quads(u64),
    /// Edge length in model units, positive.
    EdgeLength(f64),
}

impl Default for TargetBody {
    fn default() -> Self {
        TargetBody::Quads(5000)
    }
}

/// What must come out as quad edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FeaturesBody {
    /// Dihedral angle in degrees from which an edge is sharp, 0 to 180; 180 is none.
    pub angle: f64,
    /// Whether edges where the normals of the file are split (different on both sides) are sharp.
    pub normals: bool,
    /// Whether borders between materials are features.
    pub materials: bool,
    /// Explicit feature edges, pairs of vertex indices of the input, from 0.
    pub edges: Vec<[u32; 2]>,
}

impl Default for FeaturesBody {
    fn default() -> Self {
        Self { angle: 40.0, normals: false, materials: true, edges: Vec::new() }
    }
}

/// What becomes of boundary loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryName {
    /// The field follows them and they become quad edges.
    #[default]
    Align,
    /// The field crosses them at any angle, and a row of quads lies along each; not together with `symmetry`. Where a
    /// row has no room, the boundary is aligned, with a warning.
    Free,
}

/// Guidance of the cross field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlignName {
    /// Principal curvature directions where they are stable.
    #[default]
    Curvature,
    /// As smooth as possible.
    Smooth,
}

/// What is done about branch points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OptimiseName {
    /// As found.
    None,
    /// Moved to where the field has least curl.
    Relocate,
    /// Created, moved and balanced.
    #[default]
    Balance,
}

/// A mirror plane of the result, through the origin or through the middle of the model, whichever fits the model better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SymmetryAxis {
    /// x = const.
    X,
    /// y = const.
    Y,
    /// z = const.
    Z,
}

impl SymmetryAxis {
    /// The axis of a number as the engine has it, 0 to 2.
    pub fn of_index(index: usize) -> Option<Self> {
        [SymmetryAxis::X, SymmetryAxis::Y, SymmetryAxis::Z].get(index).copied()
    }
}

/// Kind of the resulting mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutputName {
    /// Quads only.
    #[default]
    Pure,
    /// Mostly quads; not available in this version.
    Dominant,
}

/// Whether the parameterisation may live on a remeshed copy of the input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WorkingMeshName {
    /// Refined or remeshed as the density needs.
    #[default]
    Auto,
    /// The triangles of the input, in input order.
    Input,
}

/// What is done with components that have no consistent orientation (an extension of the contract).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NonOrientable {
    /// The input is refused with the reason.
    #[default]
    Refuse,
    /// They are cut open along a curve.
    Cut,
}

/// An attribute of the input that can be carried to the quads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AttributeName {
    /// Material of each face.
    Materials,
    /// Colours of the vertices.
    VertexColours,
    /// Texture coordinates.
    Uv,
    /// Joints and weights, from glTF to GLB.
    Skin,
}
