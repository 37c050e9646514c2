//! The wishes of a spec that a method hears.

/// What becomes of boundary loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Boundary loops become quad edges aligned with the field.
    #[default]
    Align,
    /// The field crosses the boundary at any angle; the loops still become quad edges.
    Free,
}

/// Guidance of the cross field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// Principal curvature directions where they are stable.
    #[default]
    Curvature,
    /// As smooth as possible.
    Smooth,
}

/// What is done about branch points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optimise {
    /// As found.
    None,
    /// Moved.
    Relocate,
    /// Created, moved and balanced.
    #[default]
    Balance,
}

/// Whether the parameterisation may live on a remeshed copy of the input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WorkingMesh {
    /// Refined or remeshed as the density needs.
    #[default]
    Auto,
    /// The triangles of the input, in input order.
    Input,
}

/// What is asked of every component alike, besides its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// Boundary treatment.
    pub boundary: Boundary,
    /// Guidance of the field.
    pub align: Align,
    /// Between alignment with curvature (0) and smoothness (1).
    pub smoothing: f64,
    /// Branch points.
    pub optimise: Optimise,
    /// Where a parameterisation lives.
    pub working_mesh: WorkingMesh,
    /// Whether the scale is iterated until the number of quads is met.
    pub adapts_count: bool,
}
