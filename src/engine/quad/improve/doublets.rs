//! Doublets: vertices inside the surface with two quads only.

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::net::Change;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::operations::Sense;
use crate::engine::quad::improve::operations::doublet;
use crate::engine::quad::improve::operations::rotation;
use crate::engine::quad::improve::operations::valence_shifts;
use crate::engine::quad::improve::shaping::Shaping;
use crate::engine::quad::improve::valence::irregularity;
use crate::engine::quad::optimise::SurfaceWalker;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Quality that is good enough for quads around what was a doublet: pipelines stumble over doublets, not over these.
const DECENT: f64 = 0.1;

/// Gives doublets a third quad, by the turn of an edge of their quads that adds least irregularity and can be given a
/// decent shape; where there is none, the two quads become one. Maps put doublets on tips, which a third quad serves as
/// well and merging cuts off: the tip stays where it is if that is possible. Everything that is not near a doublet
/// stays as it is, bit for bit, and so do topology, feature edges, the boundary and anchored vertices.
///
/// Returns `None` if there is nothing that could be removed. `index` is the one of `surface.mesh`.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn remove_doublets(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: &QuadDraft,
) -> Result<Option<QuadDraft>, Cancelled> {
    let mean = mean_edge(draft);
    if !(is_sound(surface, draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(None);
    }
    let mut net = QuadNet::new(draft);
    let doublets: Vec<u32> = (0..net.n_vertices() as u32).filter(|&v| is_doublet(&net, v)).collect();
    if doublets.is_empty() {
        return Ok(None);
    }
    let walker = SurfaceWalker::new(surface, index, mean);
    let mut shaping = Shaping::new(&walker, draft, 0.5 * mean);
    let mut removed = false;
    for v in doublets {
        ctx.check()?;
        removed |= is_doublet(&net, v) && remove(&mut net, &mut shaping, v);
    }
    Ok(removed.then(|| net.into_draft(&shaping.positions, draft)))
}

fn is_doublet(net: &QuadNet, v: u32) -> bool {
    net.valence(v) == 2 && net.fan(v).is_some_and(|fan| fan.closed)
}

fn remove(net: &mut QuadNet, shaping: &mut Shaping<'_>, v: u32) -> bool {
    let mut changes: Vec<(f64, Change)> = Vec::new();
    for mut change in turns(net, v) {
        let touched = net.touched(&change);
        let cost = |net: &QuadNet| touched.iter().map(|&w| irregularity(net, &shaping.positions, w)).sum::<f64>();
        let before = cost(net);
        if net.try_apply(&mut change) {
            let gain = cost(net) - before;
            net.apply(&mut change);
            changes.push((gain, change));
        }
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    changes.into_iter().map(|change| change.1).chain(doublet(net, v)).any(|change| carry_out(net, shaping, v, change))
}

/// Applies a change if its quads can then be given a decent shape, at best without a move of `v`.
fn carry_out(net: &mut QuadNet, shaping: &mut Shaping<'_>, v: u32, mut change: Change) -> bool {
    let all = net.touched(&change);
    let others: Vec<u32> = all.iter().copied().filter(|&w| w != v).collect();
    let ring = others.iter().flat_map(|&w| &net.at[w as usize]).flat_map(|&slot| net.quads[slot as usize]);
    let mut wide: Vec<u32> = ring.filter(|&w| w != v).collect();
    wide.sort_unstable();
    wide.dedup();
    let before = [&others, &wide, &all].map(|moving| (moving, shaping.least(net, moving).min(DECENT)));
    if !net.try_apply(&mut change) {
        return false;
    }
    let settled = before.into_iter().any(|(moving, least)| shaping.settle(net, moving, least));
    if !settled {
        net.apply(&mut change);
    }
    settled
}

/// The turns of edges opposite to `v` after which it has a quad more.
fn turns(net: &QuadNet, v: u32) -> Vec<Change> {
    let opposite = net.at[v as usize].iter().flat_map(|&slot| {
        let (quad, k) = (net.quads[slot as usize], net.corner(slot, v));
        let at = |i: usize| quad[(k + i) % 4];
        [[at(1), at(2)], [at(2), at(3)]]
    });
    let turned =
        opposite.flat_map(|[a, b]| [Sense::Counterclockwise, Sense::Clockwise].map(|sense| rotation(net, a, b, sense)));
    turned.flatten().filter(|change| valence_shifts(net, change).contains(&(v, 1))).collect()
}
