//! What a user may ask for (docs/contract.md, section 3), validated by the service before the engine sees it.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::attributes::Preserve;
use crate::engine::field::{GivenBranchPoints, GivenField};
use crate::engine::methods::{MethodRef, Parameters};
use crate::engine::problem::{Align, Boundary, Optimise, Wishes, WorkingMesh};

/// How much work may be spent beyond the first attempt at a component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// One attempt of the method; what it cannot do, sure methods do.
    Fast,
    /// About three times the first attempt.
    #[default]
    Normal,
    /// About ten times the first attempt.
    Thorough,
}

/// The density asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// This many quads for the whole model, at least 1.
    Quads(u64),
    /// This edge length in model units, positive.
    EdgeLength(f64),
}

/// What is done with components that have only one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NonOrientable {
    /// The input is refused.
    #[default]
    Refuse,
    /// They are cut open along a curve.
    Cut,
}

/// At which planes the quads are to be exactly their own mirror image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Those across these axes (0, 1, 2, each at most once), through the origin or the middle of the model; none, and
    /// planes that the model has are only offered in a warning.
    Across(Vec<usize>),
    /// Those that the model nearly has, up to three at right angles to each other, in any direction.
    Auto,
}

impl Default for Symmetry {
    fn default() -> Self {
        Self::Across(Vec::new())
    }
}

impl Symmetry {
    /// Whether any is asked for.
    pub fn is_wanted(&self) -> bool {
        *self != Self::default()
    }
}

/// What must come out as quad edges.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureSpec {
    /// Dihedral angle in degrees, 0 to 180, from which an edge is sharp; 180 = none.
    pub angle_degrees: f64,
    /// Whether borders between materials are features.
    pub materials: bool,
    /// Whether edges are features where the input's normals are split.
    pub normals: bool,
    /// Explicit feature edges as pairs of input vertex indices.
    pub edges: Vec<[u32; 2]>,
}

impl Default for FeatureSpec {
    fn default() -> Self {
        Self { angle_degrees: 40.0, materials: true, normals: false, edges: Vec::new() }
    }
}

/// A validated request. `Default` is the contract's default of every field.
#[derive(Clone, Debug, PartialEq)]
pub struct RemeshSpec {
    /// Which system runs.
    pub method: MethodRef,
    /// Its own parameters.
    pub parameters: Parameters,
    /// How much work may be spent.
    pub effort: Effort,
    /// Units of work (see [`crate::engine::run::Budget`]) that there is time for before the deadline; infinite without one.
    /// Where the method may need more, something sure is made first.
    pub time_limit: f64,
    /// The density.
    pub target: Target,
    /// Iterate the scale until the count is met.
    pub adapt_count: bool,
    /// How far the size of the quads follows curvature: 0 not at all, 100 fully.
    pub adaptive_size: f64,
    /// Whether the input's vertex colours scale the density, from 1/4 at black to 4 at white.
    pub density_from_vertex_colour: bool,
    /// Features.
    pub features: FeatureSpec,
    /// Boundary treatment.
    pub boundary: Boundary,
    /// Guidance of the field.
    pub align: Align,
    /// λ between curvature alignment (0) and smoothness (1).
    pub smoothing: f64,
    /// Directions to follow, polylines in model units.
    pub strokes: Vec<Vec<DVec3>>,
    /// A field to follow instead of one from curvature, per polygon of the input.
    pub field: Option<Arc<GivenField>>,
    /// Branch points.
    pub optimise: Optimise,
    /// Whether the quads are to be exactly their own mirror image.
    pub symmetry: Symmetry,
    /// Where the parameterisation lives.
    pub working_mesh: WorkingMesh,
    /// Attributes carried to the quads, where the input has them.
    pub preserve: Preserve,
    /// Components with only one side.
    pub non_orientable: NonOrientable,
    /// Seed of every random choice.
    pub seed: u64,
}

impl RemeshSpec {
    /// Whether a number of quads is to be met.
    pub fn keeps_count(&self) -> bool {
        self.adapt_count && matches!(self.target, Target::Quads(_))
    }

    /// Whether branch points are searched for.
    pub fn searches(&self) -> bool {
        let is_kept = self.field.as_ref().is_some_and(|field| field.branch_points == GivenBranchPoints::Keep);
        self.optimise != Optimise::None && !is_kept
    }

    /// What is asked of every component alike.
    pub fn wishes(&self) -> Wishes {
        Wishes {
            boundary: self.boundary,
            align: self.align,
            smoothing: self.smoothing,
            optimise: if self.searches() { self.optimise } else { Optimise::None },
            working_mesh: self.working_mesh,
            adapts_count: self.adapt_count,
        }
    }
}

impl Default for RemeshSpec {
    fn default() -> Self {
        Self {
            method: MethodRef::default(),
            parameters: Parameters::default(),
            effort: Effort::default(),
            time_limit: f64::INFINITY,
            target: Target::Quads(5000),
            adapt_count: true,
            adaptive_size: 0.0,
            density_from_vertex_colour: false,
            features: FeatureSpec::default(),
            boundary: Boundary::default(),
            align: Align::default(),
            smoothing: 0.5,
            strokes: Vec::new(),
            field: None,
            optimise: Optimise::default(),
            symmetry: Symmetry::default(),
            working_mesh: WorkingMesh::default(),
            preserve: Preserve::default(),
            non_orientable: NonOrientable::default(),
            seed: 0,
        }
    }
}
