//! Where quads come from, as reports say it.

/// Where the quads of a component came from, from best to surest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Field and integer-grid map.
    L0,
    /// Combinatorial extraction from a seamless map.
    L1,
    /// Patch layout.
    L2,
    /// Quad-dominant remesh, every polygon split once.
    L3,
    /// Every triangle of a remesh split into three quads.
    L4,
}
