//! Other connectivity of a disc: edges turned, diagonals shrunk, doublets removed.

use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::{Freedom, Patch};
use crate::engine::mend::settle::{Effort, settle};
use crate::engine::mend::verdict::{Verdict, bad_quads, judge};
use crate::engine::quad::improve::{Change, QuadNet, candidates, irregularity};
use crate::engine::quad::{Anchor, QuadDraft, QuadMesh};
use crate::engine::run::{Cancelled, RunContext};

/// Changes with the least irregularity that are looked at, one after another.
const SHORTLIST: usize = 8;
/// … as long as these patches have no more quads in sum, but two at least.
const MAX_LOOKED_AT: usize = 1000;
/// Changes after each other.
const DEPTH: usize = 3;

/// The best patch that changes near bad quads lead to, with its verdict; nothing if none is better than `known`.
pub(super) fn turned(
    ctx: &RunContext,
    ground: &Ground<'_>,
    patch: &Patch,
    known: Verdict,
) -> Result<Option<(Verdict, Patch)>, Cancelled> {
    let mut best: Option<(Verdict, Patch)> = None;
    for _ in 0..DEPTH {
        let (verdict, base) = best.as_ref().map_or((known, patch), |b| (b.0, &b.1));
        match once(ctx, ground, base, verdict)? {
            Some(found) => best = Some(found),
            None => break,
        }
        if best.as_ref().is_some_and(|b| b.0.is_decent()) {
            break;
        }
    }
    Ok(best)
}

fn once(
    ctx: &RunContext,
    ground: &Ground<'_>,
    patch: &Patch,
    known: Verdict,
) -> Result<Option<(Verdict, Patch)>, Cancelled> {
    let mut net = net_of(patch);
    let bad = bad_quads(ground, patch);
    let mut near: Vec<u32> = patch.quads.iter().zip(&bad).filter(|(_, bad)| **bad).flat_map(|(q, _)| *q).collect();
    near.sort_unstable();
    near.dedup();
    let own = patch.quads.len() as u32;
    let mut ranked: Vec<(f64, Change)> = Vec::new();
    for mut change in candidates(&net, &near) {
        if change.iter().any(|(slot, _)| *slot >= own) {
            continue;
        }
        let touched = net.touched(&change);
        let cost = |net: &QuadNet| touched.iter().map(|&v| irregularity(net, &patch.positions, v)).sum::<f64>();
        let before = cost(&net);
        if net.try_apply(&mut change) {
            ranked.push((cost(&net) - before, change.clone()));
            net.apply(&mut change);
            if let Some(last) = ranked.last_mut() {
                last.1 = change;
            }
        }
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(Verdict, Patch)> = None;
    for (_, mut change) in ranked.into_iter().take(SHORTLIST.min(MAX_LOOKED_AT / patch.quads.len()).max(2)) {
        ctx.check()?;
        net.apply(&mut change);
        let mut changed = patch.clone();
        changed.quads.copy_from_slice(&net.quads[..own as usize]);
        net.apply(&mut change);
        // Two rings around what changed.
        let mut among = net.touched(&change);
        for _ in 0..2 {
            let near = changed.living().filter(|q| q.iter().any(|v| among.binary_search(v).is_ok())).flatten();
            among = among.iter().chain(near).copied().collect();
            among.sort_unstable();
            among.dedup();
        }
        changed.spread_over(ground, &among);
        settle(ctx, ground, &mut changed, &among, Effort::Glance)?;
        let verdict = judge(ground, &changed);
        if verdict.is_better_than(&best.as_ref().map_or(known, |b| b.0)) {
            let is_decent = verdict.is_decent();
            best = Some((verdict, changed));
            if is_decent {
                break;
            }
        }
    }
    Ok(best)
}

/// A net of the disc and what is around; vertices that may not move there are held.
fn net_of(patch: &Patch) -> QuadNet {
    let held = |(anchor, freedom): (&Anchor, &Freedom)| match (anchor, freedom) {
        (Anchor::Surface, Freedom::Fixed) => Anchor::Curve,
        _ => *anchor,
    };
    let quads = patch.quads.iter().chain(&patch.around).copied().collect();
    QuadNet::new(&QuadDraft {
        mesh: QuadMesh { positions: patch.positions.clone(), quads },
        anchors: patch.anchors.iter().zip(&patch.freedom).map(held).collect(),
        feature_edges: patch.features.clone(),
    })
}
