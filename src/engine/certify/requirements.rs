//! What a certificate demands.

use crate::engine::certify::Check;

/// Which checks refuse. Measures are the same for both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Requirements {
    /// All checks but those of [`Requirements::Strict`].
    Valid,
    /// [`Check::Folded`] and [`Check::Far`] refuse too, and quads that lie folded on their neighbour are
    /// [`Check::Flipped`].
    #[default]
    Strict,
}

impl Requirements {
    /// Whether a violation of `check` refuses.
    pub fn demand(self, check: Check) -> bool {
        self == Self::Strict || !matches!(check, Check::Folded | Check::Far)
    }
}
