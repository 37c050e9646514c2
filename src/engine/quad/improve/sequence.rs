//! The order in which changes are tried.

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::net::Change;
use crate::engine::quad::improve::net::DEAD;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::operations::candidates;
use crate::engine::quad::improve::operations::valence_shifts;
use crate::engine::quad::improve::shaping::Shaping;
use crate::engine::quad::improve::valence::irregularity;
use crate::engine::quad::optimise::SurfaceWalker;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Passes over all irregular vertices.
const PASSES: usize = 8;
/// Changes at one vertex in one pass.
const REPEATS: usize = 8;
/// Irregularity that a first change may add if a second one takes away more.
const LOAN: f64 = 2.0;
/// A change that loses quads must gain this much more than one that does not.
const LOSS: f64 = 0.5;
/// First changes that are followed up at one vertex.
const FOLLOWED: usize = 12;

/// Makes the quads of a draft more regular: removes doublets, turns edges and shrinks diagonals where that lowers the
/// sum of squared deviations of the valences from their ideal, one change or two at a time.
///
/// Topology, feature edges, the boundary and all vertices that are not free on the surface stay; quads keep a scaled
/// Jacobian of 0.25 or what they had. A draft whose parts do not fit together is returned as it is; one with few
/// irregular vertices is hardly changed. Vertices that are no longer used are left out.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn improve_connectivity(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: QuadDraft,
) -> Result<QuadDraft, Cancelled> {
    let mean = mean_edge(&draft);
    if !(is_sound(surface, &draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(draft);
    }
    let walker = SurfaceWalker::new(surface, index, mean);
    let mut work = Work {
        net: QuadNet::new(&draft),
        shaping: Shaping::new(&walker, &draft, 0.5 * mean),
        stale: vec![true; draft.mesh.positions.len()],
    };
    for pass in 0..PASSES {
        let part = ctx.part(pass, PASSES);
        // After the first pass pairs of changes are tried too, so everything has to be looked at again.
        if pass == 1 {
            work.stale.fill(true);
        }
        let n = work.net.n_vertices() as u32;
        for v in 0..n {
            // A pair of changes at a vertex takes up to some 20 ms.
            ctx.check()?;
            if v % 64 == 0 {
                part.advance(f64::from(v) / f64::from(n));
            }
            for _ in 0..REPEATS {
                if !std::mem::take(&mut work.stale[v as usize]) || work.cost(v) == 0.0 {
                    break;
                }
                let _changed = work.improve_once(v) || pass > 0 && work.improve_twice(v);
            }
        }
    }
    Ok(work.net.into_draft(&work.shaping.positions, &draft))
}

struct Work<'a> {
    net: QuadNet,
    shaping: Shaping<'a>,
    /// Vertices near which something changed since they were looked at.
    stale: Vec<bool>,
}

impl Work<'_> {
    fn cost(&self, v: u32) -> f64 {
        irregularity(&self.net, &self.shaping.positions, v)
    }

    fn costs(&self, vertices: &[u32]) -> f64 {
        vertices.iter().map(|&v| self.cost(v)).sum()
    }

    /// Irregularity that a change adds, if it is possible at all and adds less than `limit`. Leaves everything as it is.
    fn gain(&mut self, change: &mut Change, limit: f64) -> Option<f64> {
        let loss = if change.iter().any(|(_, contents)| *contents == DEAD) { LOSS } else { 0.0 };
        if self.least_gain(change) + loss >= limit {
            return None;
        }
        let touched = self.net.touched(change);
        let before = self.costs(&touched);
        if !self.net.try_apply(change) {
            return None;
        }
        let after = self.costs(&touched);
        self.net.apply(change);
        Some(after - before + loss).filter(|&gain| gain < limit)
    }

    /// A lower bound of what a change adds, from the numbers of quads alone: exact for free vertices.
    fn least_gain(&self, change: &Change) -> f64 {
        let gain = |(v, shift): (u32, i32)| {
            let (n, shift) = (self.net.valence(v) as f64, f64::from(shift));
            match n + shift {
                0.0 => -(n - 4.0) * (n - 4.0),
                after if self.net.is_free(v) => (after - 4.0) * (after - 4.0) - (n - 4.0) * (n - 4.0),
                _ => -self.cost(v),
            }
        };
        valence_shifts(&self.net, change).into_iter().map(gain).sum()
    }

    /// The possible changes near vertices that add less than `limit`, the best first.
    fn ranked(&mut self, vertices: &[u32], limit: f64) -> Vec<(f64, Change)> {
        let mut ranked: Vec<(f64, Change)> = Vec::new();
        for mut change in candidates(&self.net, vertices) {
            if let Some(gain) = self.gain(&mut change, limit) {
                ranked.push((gain, change));
            }
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked
    }

    fn improve_once(&mut self, v: u32) -> bool {
        for (_, change) in self.ranked(&[v], 0.0) {
            if self.carry_out(&mut [change]) {
                return true;
            }
        }
        false
    }

    fn improve_twice(&mut self, v: u32) -> bool {
        for (loan, mut first) in self.ranked(&[v], LOAN + LOSS + 0.1).into_iter().take(FOLLOWED) {
            if !self.net.try_apply(&mut first) {
                continue;
            }
            let mut near = self.net.touched(&first);
            near.retain(|&w| self.net.valence(w) > 0 && self.cost(w) > 0.0);
            let second = self.ranked(&near, -loan - 0.1).into_iter().next();
            self.net.apply(&mut first);
            if let Some((_, second)) = second
                && self.carry_out(&mut [first, second])
            {
                return true;
            }
        }
        false
    }

    /// Applies changes one after the other if their quads can then be given a decent shape; all of them or none.
    fn carry_out(&mut self, changes: &mut [Change]) -> bool {
        // What a later change touches is known only when the earlier ones are applied, but must be judged as it is now.
        let mut touched = Vec::new();
        let mut done = 0;
        for change in changes.iter_mut() {
            touched.extend(self.net.touched(change));
            if !self.net.try_apply(change) {
                break;
            }
            done += 1;
        }
        touched.sort_unstable();
        touched.dedup();
        let whole = done == changes.len();
        changes[..done].iter_mut().rev().for_each(|change| self.net.apply(change));
        if !whole {
            return false;
        }
        let before = self.shaping.least(&self.net, &touched);
        changes.iter_mut().for_each(|change| self.net.apply(change));
        if self.shaping.settle(&self.net, &touched, before) {
            for &v in touched.iter().flat_map(|&v| &self.net.at[v as usize]).flat_map(|&q| &self.net.quads[q as usize])
            {
                self.stale[v as usize] = true;
            }
            return true;
        }
        changes.iter_mut().rev().for_each(|change| self.net.apply(change));
        false
    }
}
