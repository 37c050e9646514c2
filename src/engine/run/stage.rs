//! The stages of a run.

/// The stages of a run, in the order in which a run meets them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Bytes to a triangle soup.
    Read,
    /// Soup to an oriented 2-manifold.
    Condition,
    /// Sharp edges, corners.
    Features,
    /// Triangles fine enough for the target density.
    Refine,
    /// Cross field, matching, singularities.
    Field,
    /// Cut graph, combing, Poisson solve.
    Map,
    /// Jumps and singularities to integers.
    Round,
    /// Integer grid lines to quads.
    Extract,
    /// Quads without a map.
    Fallback,
    /// Positions of the quads.
    Optimise,
    /// Certificate and measures.
    Certify,
    /// Attributes to the quads, results to bytes.
    Write,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Stage; 12] = [
        Stage::Read,
        Stage::Condition,
        Stage::Features,
        Stage::Refine,
        Stage::Field,
        Stage::Map,
        Stage::Round,
        Stage::Extract,
        Stage::Fallback,
        Stage::Optimise,
        Stage::Certify,
        Stage::Write,
    ];

    /// The stage's name in reports, logs and events.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Read => "read",
            Stage::Condition => "condition",
            Stage::Features => "features",
            Stage::Refine => "refine",
            Stage::Field => "field",
            Stage::Map => "map",
            Stage::Round => "round",
            Stage::Extract => "extract",
            Stage::Fallback => "fallback",
            Stage::Optimise => "optimise",
            Stage::Certify => "certify",
            Stage::Write => "write",
        }
    }
}
