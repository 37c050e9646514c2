//! One order among quads of the same component, used wherever anything asks which are better.

use std::cmp::Ordering;

/// Quads within this many edges of the surface are as near as any: relaxed quads cut corners by about as much.
const NEAR: f64 = 0.55;
/// Distances beyond are told apart by this factor.
const NEARLY: f64 = 1.15;

/// What is to be said about the quads of one component; the greater is better. Compared in the order of the fields: what
/// a user cannot use comes before what only looks worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Quality {
    /// How often the certificate refuses; 0 is certified.
    pub(super) refused: usize,
    /// Whether another method than the one asked for made them.
    pub(super) is_substitute: bool,
    /// Whether the count is missed.
    pub(super) misses_count: bool,
    /// Whether a part of the surface is not shown at all.
    pub(super) loses_a_part: bool,
    /// Feature edges that were given up, in quad edges of length.
    pub(super) features_given_up: usize,
    /// Quads with a corner that is nearly straight.
    pub(super) straight: usize,
    /// Interior vertices with two quads.
    pub(super) doublets: usize,
    /// Distance between quads and surface, in steps; see [`Quality::distance_step`].
    pub(super) distance_step: usize,
    /// Irregular vertices.
    pub(super) irregular: usize,
}

impl Quality {
    /// The step of a distance in quad edges: 0 up to about half an edge, then one for every factor of 1.15.
    pub(super) fn distance_step(edges: f64) -> usize {
        if edges <= NEAR { 0 } else { 1 + ((edges / NEAR).ln() / NEARLY.ln()) as usize }
    }

    fn key(&self) -> impl Ord {
        let Self { refused, is_substitute, misses_count, loses_a_part, features_given_up, .. } = *self;
        let Self { straight, doublets, distance_step, irregular, .. } = *self;
        (
            (refused, is_substitute, misses_count, loses_a_part, features_given_up),
            (straight, doublets, distance_step, irregular),
        )
    }
}

impl Ord for Quality {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key().cmp(&self.key())
    }
}

impl PartialOrd for Quality {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERFECT: Quality = Quality {
        refused: 0,
        is_substitute: false,
        misses_count: false,
        loses_a_part: false,
        features_given_up: 0,
        straight: 0,
        doublets: 0,
        distance_step: 0,
        irregular: 0,
    };

    #[test]
    fn what_cannot_be_used_weighs_more_than_what_looks_worse() {
        let worse = [
            Quality { irregular: 1, ..PERFECT },
            Quality { distance_step: 1, ..PERFECT },
            Quality { doublets: 1, distance_step: 0, ..PERFECT },
            Quality { straight: 1, ..PERFECT },
            Quality { features_given_up: 1, ..PERFECT },
            Quality { loses_a_part: true, ..PERFECT },
            Quality { misses_count: true, ..PERFECT },
            Quality { is_substitute: true, ..PERFECT },
            Quality { refused: 1, ..PERFECT },
        ];
        assert!(worse.iter().all(|quality| *quality < PERFECT));
        assert!(worse.windows(2).all(|pair| pair[1] < pair[0]), "{worse:?}");
        assert!(Quality { irregular: 1000, ..PERFECT } > worse[1]);
    }

    #[test]
    fn distances_within_a_seventh_are_alike() {
        assert_eq!([0.0, 0.3, 0.55].map(Quality::distance_step), [0; 3]);
        assert_eq!([0.56, 0.62, 0.7].map(Quality::distance_step), [1, 1, 2]);
        assert!(Quality::distance_step(2.0) < Quality::distance_step(3.0));
    }
}
