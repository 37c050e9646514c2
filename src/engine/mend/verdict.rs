//! The local judge: how many quads of a patch are bad, and how bad the worst corner is.

use crate::engine::certify::Stance;
use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::Patch;
use crate::engine::quad::improve::DEAD;
use std::cmp::Ordering;

/// Least scaled Jacobian of a quad that is sound: files of single precision move corners of quads a thousandth of the
/// diagonal large by some 1e-4 of their edges.
pub(super) const SOUND: f64 = 0.02;
/// Least cosine between a sound quad and the surface, for the same reason.
const UPRIGHT: f64 = 0.02;
/// A patch without bad quads whose worst corner is at least this is not worked on further.
const DECENT: f64 = 0.15;

/// Whether quads still stand for the surface that they stood for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cover {
    /// All points are in reach.
    Kept,
    /// Something was cut off: this is never better than anything that was there.
    Lost,
}

/// How good the quads of a patch are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    pub(super) cover: Cover,
    /// Quads that the certificate refuses.
    pub(super) refused: usize,
    /// Quads that are bad: those, and what files may turn into them.
    pub(super) bad: usize,
    /// Sum over the quads of what their least scaled Jacobian lacks to a decent one.
    pub(super) lacking: f64,
    /// The least of them, less than −1 + cosine with the surface for quads that are turned over.
    pub(super) worst: f64,
}

impl Verdict {
    /// Nothing is bad, and no corner nearly so.
    pub(super) fn is_decent(&self) -> bool {
        self.cover == Cover::Kept && self.bad == 0 && self.worst >= DECENT
    }

    pub(super) fn is_better_than(&self, other: &Self) -> bool {
        self.order(other) == Ordering::Less
    }

    /// The better one first.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let key = |v: &Self| (v.cover, v.refused, v.bad);
        key(self).cmp(&key(other)).then(self.lacking.total_cmp(&other.lacking))
    }
}

/// Whether a quad that stands like this is bad by itself.
pub(super) fn is_bad(stance: &Stance) -> bool {
    stance.defect.is_some() || stance.jacobian < SOUND || lean(stance) < UPRIGHT
}

/// Cosine between a quad and the surface.
pub(super) fn lean(stance: &Stance) -> f64 {
    stance.area.normalize_or_zero().dot(stance.up)
}

/// Judges the quads of a patch, and those against the quads around.
pub(super) fn judge(ground: &Ground<'_>, patch: &Patch) -> Verdict {
    let Flags { stances, refused, bad } = flags(ground, patch);
    let value = |s: &Stance| if lean(s) < UPRIGHT { s.jacobian.min(0.0) + lean(s) - 1.0 } else { s.jacobian };
    let worst = stances.iter().flatten().map(value).fold(f64::INFINITY, f64::min);
    let lacking = stances.iter().flatten().map(|s| (DECENT - value(s)).max(0.0)).sum();
    let cover = if patch.farthest().1 > patch.reach { Cover::Lost } else { Cover::Kept };
    let count = |flags: Vec<bool>| flags.into_iter().filter(|flag| *flag).count();
    Verdict { cover, refused: count(refused), bad: count(bad), lacking, worst }
}

/// Per quad of a patch whether it is bad, by itself or with a neighbour.
pub(super) fn bad_quads(ground: &Ground<'_>, patch: &Patch) -> Vec<bool> {
    flags(ground, patch).bad
}

/// Per quad of a patch, how it stands.
struct Flags {
    stances: Vec<Option<Stance>>,
    /// Whether the certificate refuses it, by itself or with a neighbour.
    refused: Vec<bool>,
    bad: Vec<bool>,
}

fn flags(ground: &Ground<'_>, patch: &Patch) -> Flags {
    let stances: Vec<Option<Stance>> = (0..patch.quads.len()).map(|q| patch.stance(ground, q)).collect();
    let mut refused: Vec<bool> = stances.iter().map(|s| s.as_ref().is_some_and(|s| s.defect.is_some())).collect();
    let mut bad: Vec<bool> = stances.iter().map(|s| s.as_ref().is_some_and(is_bad)).collect();
    let off: Vec<bool> =
        patch.anchors.iter().zip(&patch.positions).map(|(&anchor, &p)| ground.is_off(anchor, p)).collect();
    for (quad, bad) in patch.quads.iter().zip(&mut bad).filter(|(quad, _)| **quad != DEAD) {
        *bad |= quad.iter().any(|&v| off[v as usize]);
    }
    let own = patch.quads.len();
    let all = patch.quads.iter().chain(&patch.around).enumerate().filter(|(_, quad)| **quad != DEAD);
    let mut sides: Vec<(u32, u32, usize)> = all
        .flat_map(|(q, quad)| (0..4).map(move |k| (quad[k], quad[(k + 1) % 4], q)))
        .map(|(a, b, q)| (a.min(b), a.max(b), q))
        .collect();
    sides.sort_unstable();
    let stance = |q: usize| if q < own { stances[q].as_ref() } else { patch.around_stances.get(q - own) };
    for pair in sides.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)) {
        let (q, r) = (pair[0].2, pair[1].2);
        if let (Some(a), Some(b)) = (stance(q), stance(r))
            && q < own
            && !patch.is_feature(pair[0].0, pair[0].1)
            && ground.judge.lie_on_each_other(a, b)
        {
            let worse = if r >= own || lean(a) < lean(b) { q } else { r };
            (refused[worse], bad[worse]) = (true, true);
        }
    }
    Flags { stances, refused, bad }
}
