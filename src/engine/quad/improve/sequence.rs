//! The order in which changes are tried.

use crate::engine::mesh::NONE;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::improve::net::Change;
use crate::engine::quad::improve::net::DEAD;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::operations::candidates;
use crate::engine::quad::improve::shaping::Shaping;
use crate::engine::quad::improve::valence::irregularity;
use crate::engine::quad::optimise::Sheet;
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
    if !is_sound(surface, &draft) || !(mean > 0.0 && mean.is_finite()) {
        return Ok(draft);
    }
    let sheet = Sheet::new(surface, mean);
    let mut work = Work { net: QuadNet::new(&draft), shaping: Shaping::new(&sheet, index, &draft, 0.5 * mean) };
    for pass in 0..PASSES {
        let mut changed = 0;
        for v in 0..work.net.n_vertices() as u32 {
            if v % 64 == 0 {
                ctx.check()?;
            }
            for _ in 0..REPEATS {
                if work.cost(v) == 0.0 || !(work.improve_once(v) || pass > 0 && work.improve_twice(v)) {
                    break;
                }
                changed += 1;
            }
        }
        if pass > 0 && changed == 0 {
            break;
        }
    }
    Ok(work.into_draft(draft))
}

struct Work<'a> {
    net: QuadNet,
    shaping: Shaping<'a>,
}

impl Work<'_> {
    fn cost(&self, v: u32) -> f64 {
        irregularity(&self.net, &self.shaping.positions, v)
    }

    fn costs(&self, vertices: &[u32]) -> f64 {
        vertices.iter().map(|&v| self.cost(v)).sum()
    }

    /// Irregularity that a change adds, if it is possible at all. Leaves everything as it is.
    fn gain(&mut self, change: &mut Change) -> Option<f64> {
        let touched = self.net.touched(change);
        let before = self.costs(&touched);
        let loses = change.iter().any(|(_, contents)| *contents == DEAD);
        if !self.net.try_apply(change) {
            return None;
        }
        let after = self.costs(&touched);
        self.net.apply(change);
        Some(after - before + if loses { LOSS } else { 0.0 })
    }

    /// The possible changes near `v` that add less than `limit`, the best first.
    fn ranked(&mut self, v: u32, limit: f64) -> Vec<(f64, Change)> {
        let mut ranked: Vec<(f64, Change)> = Vec::new();
        for mut change in candidates(&self.net, v) {
            if let Some(gain) = self.gain(&mut change).filter(|&g| g < limit) {
                ranked.push((gain, change));
            }
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked
    }

    fn improve_once(&mut self, v: u32) -> bool {
        for (_, mut change) in self.ranked(v, 0.0) {
            let touched = self.net.touched(&change);
            let before = self.shaping.least(&self.net, &touched);
            if self.net.try_apply(&mut change) {
                if self.shaping.settle(&self.net, &touched, before) {
                    return true;
                }
                self.net.apply(&mut change);
            }
        }
        false
    }

    fn improve_twice(&mut self, v: u32) -> bool {
        for (loan, mut first) in self.ranked(v, LOAN + LOSS + 0.1).into_iter().take(FOLLOWED) {
            let mut touched = self.net.touched(&first);
            let before = self.shaping.least(&self.net, &touched);
            if !self.net.try_apply(&mut first) {
                continue;
            }
            let mut follow: Option<(f64, Change)> = None;
            for &w in &touched {
                if self.net.valence(w) > 0 && self.cost(w) > 0.0 {
                    let best = follow.as_ref().map_or(-loan - 0.1, |f| f.0);
                    follow = self.ranked(w, best).into_iter().next().or(follow);
                }
            }
            if let Some((_, mut second)) = follow {
                let more = self.net.touched(&second);
                let before = before.min(self.shaping.least(&self.net, &more));
                touched.extend(more);
                touched.sort_unstable();
                touched.dedup();
                if self.net.try_apply(&mut second) {
                    if self.shaping.settle(&self.net, &touched, before) {
                        return true;
                    }
                    self.net.apply(&mut second);
                }
            }
            self.net.apply(&mut first);
        }
        false
    }

    fn into_draft(self, draft: QuadDraft) -> QuadDraft {
        let mut number = vec![NONE; self.net.n_vertices()];
        let (mut positions, mut anchors) = (Vec::new(), Vec::new());
        for (v, number) in number.iter_mut().enumerate() {
            if !self.net.at[v].is_empty() {
                *number = positions.len() as u32;
                positions.push(self.shaping.positions[v]);
                anchors.push(self.net.anchors[v]);
            }
        }
        let renamed = |v: u32| number[v as usize];
        let quads = self.net.quads.iter().filter(|&&q| q != DEAD).map(|q| q.map(renamed)).collect();
        let edges = draft.feature_edges.into_iter().map(|e| e.map(renamed));
        let feature_edges = edges.filter(|e| !e.contains(&NONE)).collect();
        QuadDraft { mesh: QuadMesh { positions, quads }, anchors, feature_edges }
    }
}
