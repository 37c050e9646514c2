//! Faults for tests, put into good drafts: each keeps the topology and makes a place bad.

use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::{Freedom, Patch};
use crate::engine::mend::refill::insert;
use crate::engine::mend::words::pieces;
use crate::engine::numerics::Random;
use crate::engine::quad::fill::Pattern;
use crate::engine::quad::improve::{Change, QuadNet, candidates};
use crate::engine::quad::{Anchor, QuadDraft};
use glam::DVec3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Fault {
    /// A vertex is moved across a quad, beyond its opposite corner.
    Flip,
    /// A vertex is moved over the diagonal of a quad.
    Fold,
    /// Edges are turned at random and nothing is evened out.
    Turn,
    /// The quads around a quad are replaced by a ring around a ring with all new vertices in one place.
    Refill,
    /// The vertices around a vertex are drawn into it, nearly.
    Pinch,
}

pub(super) const FAULTS: [Fault; 5] = [Fault::Flip, Fault::Fold, Fault::Turn, Fault::Refill, Fault::Pinch];

/// A number that depends on nothing but its argument.
pub(super) fn scatter(index: u64) -> u64 {
    Random::at(0, index).bits()
}

/// The draft with a fault at a place chosen by `seed`; `None` where that fault cannot be made there.
pub(super) fn inject(ground: &Ground<'_>, draft: &QuadDraft, fault: Fault, seed: u64) -> Option<QuadDraft> {
    let mut bad = draft.clone();
    let net = QuadNet::new(draft);
    let slot = (scatter(seed) % draft.mesh.quads.len() as u64) as u32;
    let quad = draft.mesh.quads[slot as usize];
    let k = (scatter(seed ^ 0x55) % 4) as usize;
    let (v, opposite) = (quad[k], quad[(k + 2) % 4]);
    let at = |v: u32| draft.mesh.positions[v as usize];
    match fault {
        Fault::Flip | Fault::Fold => {
            let part = if fault == Fault::Flip { 1.6 } else { 0.7 };
            (draft.anchors[v as usize] == Anchor::Surface).then_some(())?;
            bad.mesh.positions[v as usize] = at(v).lerp(at(opposite), part);
        }
        Fault::Turn => {
            let mut net = net;
            for i in 0..4 {
                let mut changes: Vec<Change> = candidates(&net, &quad).into_iter().filter(|c| c.len() == 2).collect();
                let n = changes.len() as u64;
                let change = changes.get_mut((scatter(seed + 1000 * i) % n.max(1)) as usize)?;
                net.try_apply(change);
            }
            bad = net.into_draft(&draft.mesh.positions, draft);
        }
        Fault::Refill => {
            let ring = |slots: &[u32]| {
                let mut all: Vec<u32> = slots
                    .iter()
                    .flat_map(|&s| net.quads[s as usize])
                    .flat_map(|v| net.at[v as usize].iter().copied())
                    .collect();
                all.sort_unstable();
                all.dedup();
                all
            };
            let own = ring(&[slot]);
            let patch = Patch::new(ground, &net, &draft.mesh.positions, &own, Vec::new());
            let [piece] = &pieces(&patch)[..] else { return None };
            let n = piece.word.len() as u32;
            (n >= 4).then_some(())?;
            let core = Pattern::grid(1, n / 2 - 1, (scatter(seed ^ 0x77) % u64::from(n)) as u32);
            let filled = insert(&patch, piece, &Pattern::padded(&core));
            let shift = draft.mesh.positions.len() as u32 - filled.origin.len() as u32;
            let rename = |v: u32| filled.origin.get(v as usize).map_or(v + shift, |&o| o);
            bad.mesh.positions.extend_from_slice(&filled.positions[filled.origin.len()..]);
            bad.anchors.extend_from_slice(&filled.anchors[filled.origin.len()..]);
            let mut net = QuadNet::new(&bad);
            let slots: Vec<u32> =
                own.iter().copied().chain((own.len()..filled.quads.len()).map(|_| net.add_slot())).collect();
            let mut change: Change = slots
                .into_iter()
                .zip(filled.quads.iter().map(|q| if q[0] == u32::MAX { *q } else { q.map(rename) }))
                .collect();
            net.apply(&mut change);
            bad = net.into_draft(&bad.mesh.positions.clone(), &bad);
        }
        Fault::Pinch => {
            let patch = Patch::new(ground, &net, &draft.mesh.positions, &net.at[v as usize].clone(), Vec::new());
            let spokes = patch.living().flatten().filter(|&&w| patch.anchors[w as usize] == Anchor::Surface);
            let mut spokes: Vec<u32> = spokes.map(|&w| patch.origin[w as usize]).collect();
            spokes.sort_unstable();
            spokes.dedup();
            (spokes.len() > 4 && patch.freedom.contains(&Freedom::Surface)).then_some(())?;
            // In an order that turns some quads over.
            for (i, w) in spokes.into_iter().enumerate() {
                let jitter = DVec3::new(scatter(i as u64) as f64, scatter(i as u64 + 99) as f64, 0.0) / u64::MAX as f64;
                bad.mesh.positions[w as usize] = at(v).lerp(at(w), 0.03) + 0.05 * ground.edge * jitter;
            }
        }
    }
    Some(bad)
}
