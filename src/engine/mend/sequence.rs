//! The order of the steps: find what is bad, cut discs out, mend each, put them back, and grow what is left.

use crate::engine::certify::Stance;
use crate::engine::mend::cover::{assigned, points};
use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::Patch;
use crate::engine::mend::refill::refilled;
use crate::engine::mend::regions::regions;
use crate::engine::mend::settle::{Effort, settle};
use crate::engine::mend::turns::turned;
use crate::engine::mend::verdict::{Verdict, is_bad, judge, lean};
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::{Change, DEAD, QuadNet};
use crate::engine::quad::optimise::{is_sound, mean_edge};
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// How often what is left grows by a ring.
const GROWTHS: usize = 4;
/// Discs with more quads get other positions only: so much is no place but the whole draft, and needs another map.
const MAX_QUADS: usize = 250;

/// All discs together, each time they grow, have at most as many quads as the draft, or as this: more would cost more
/// than another map.
const MIN_WORK: usize = 500;

/// How a draft is mended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MendOptions {
    /// Edge length that was asked for, in model units: distances are judged by it where it is longer than the draft's mean.
    pub edge_length: f64,
}

/// What became of a draft.
#[derive(Clone, Debug, PartialEq)]
pub struct Mended {
    /// The draft. Vertices and quads that were there and still are keep their order, new ones come after them (a disc with
    /// another filling takes the places of its old quads first); what is gone is left out.
    pub draft: QuadDraft,
    /// Quads that were bad.
    pub found: usize,
    /// How many fewer are bad now.
    pub fixed: usize,
    /// Centres of the quads that still are bad, in model units.
    pub left: Vec<DVec3>,
    /// Discs that were changed, each time counted that they grew.
    pub discs: usize,
    /// Quads of the draft that was given in discs that were changed, sorted. All others are as they were, and so, bit for
    /// bit, are all vertices that any other quad has.
    pub changed: Vec<u32>,
}

/// Mends the bad quads of a draft on a connected surface where they are: those that
/// [`crate::engine::certify::QuadJudge`] refuses, that lie on a neighbour, or whose vertices left their curve or corner.
/// Everything outside discs of at most five rings around them stays bit for bit; topology, feature edges, the boundary
/// and anchors stay everywhere. Discs are solved side by side; the result does not depend on the number of threads.
///
/// A draft whose parts do not fit together is returned as it is. `index` is the one of `surface.mesh`. O(n) for the search
/// and tens of milliseconds per disc.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn mend(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: QuadDraft,
    options: &MendOptions,
) -> Result<Mended, Cancelled> {
    ctx.check()?;
    let mean = mean_edge(&draft);
    let mut mended = Mended { draft, found: 0, fixed: 0, left: Vec::new(), discs: 0, changed: Vec::new() };
    if !(is_sound(surface, &mended.draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(mended);
    }
    let ground = Ground::new(surface, index, mean, options.edge_length);
    let all: Vec<u32> = (0..mended.draft.mesh.quads.len() as u32).collect();
    let positions = mended.draft.mesh.positions.clone();
    let mut work =
        Work { ground: &ground, net: QuadNet::new(&mended.draft), positions, stances: Vec::new(), points: Vec::new() };
    work.stances = vec![None; all.len()];
    let mut bad = work.bad_among(&ctx.span(0.0, 0.2), &all)?;
    mended.found = bad.len();
    if !bad.is_empty() {
        let points = points(&surface.mesh, mean);
        work.points = assigned(&ctx.span(0.2, 0.3), &work.net.quads, &work.positions, &points)?;
    }
    let mut left = all.len().max(MIN_WORK);
    for round in 0..=GROWTHS {
        if bad.is_empty() {
            break;
        }
        let part = ctx.span(
            0.3 + 0.7 * round as f64 / (1 + GROWTHS) as f64,
            0.3 + 0.7 * (round + 1) as f64 / (1 + GROWTHS) as f64,
        );
        let mut discs = regions(&work.net, &bad, 1 + round);
        discs.retain(|own| {
            let fits = own.len() <= left;
            left -= if fits { own.len() } else { 0 };
            fits
        });
        let solve = |own: &Vec<u32>| {
            let found = work.solve(&part, own);
            part.step(discs.len());
            found
        };
        let solved: Vec<Option<Patch>> = discs.par_iter().map(solve).collect::<Result<_, Cancelled>>()?;
        let mut changed = bad.clone();
        for (own, patch) in discs.iter().zip(solved) {
            if let Some(patch) = patch {
                mended.discs += 1;
                mended.changed.extend(own.iter().filter(|&&slot| (slot as usize) < all.len()));
                changed.extend(work.put_back(ctx, own, &patch)?);
            }
        }
        bad = work.bad_among(&part, &work.with_neighbours(&changed))?;
    }
    mended.fixed = mended.found.saturating_sub(bad.len());
    mended.left = bad.iter().map(|&slot| work.corners(slot).iter().sum::<DVec3>() / 4.0).collect();
    if mended.discs > 0 {
        mended.changed.sort_unstable();
        mended.changed.dedup();
        let Work { net, positions, .. } = work;
        mended.draft = net.into_draft(&positions, &mended.draft);
    }
    Ok(mended)
}

/// The draft under work.
struct Work<'a> {
    ground: &'a Ground<'a>,
    net: QuadNet,
    positions: Vec<DVec3>,
    /// Per slot how its quad stands, as far as that is known.
    stances: Vec<Option<Stance>>,
    /// Per slot the points of the surface that its quad stands for.
    points: Vec<Vec<DVec3>>,
}

impl Work<'_> {
    fn corners(&self, slot: u32) -> [DVec3; 4] {
        self.net.quads[slot as usize].map(|v| self.positions[v as usize])
    }

    /// The bad ones among some slots (sorted), by themselves or with a neighbour.
    fn bad_among(&mut self, ctx: &RunContext, slots: &[u32]) -> Result<Vec<u32>, Cancelled> {
        let this = &*self;
        let known = |(i, &slot): (usize, &u32)| {
            if i % 32 == 0 {
                ctx.check()?;
            }
            let is_living = this.net.quads[slot as usize] != DEAD;
            Ok(is_living
                .then(|| this.stances[slot as usize].unwrap_or_else(|| this.ground.judge.stance(&this.corners(slot)))))
        };
        let found: Vec<Option<Stance>> = slots.par_iter().enumerate().map(known).collect::<Result<_, Cancelled>>()?;
        for (&slot, stance) in slots.iter().zip(found) {
            self.stances[slot as usize] = stance;
        }
        let this = &*self;
        let is_worse = |slot: u32| {
            let Some(own) = &this.stances[slot as usize] else { return false };
            let quad = this.net.quads[slot as usize];
            let is_off = |&v: &u32| this.ground.is_off(this.net.anchors[v as usize], this.positions[v as usize]);
            let lies = |k: usize| {
                let (a, b) = (quad[k], quad[(k + 1) % 4]);
                let other = this.net.left_of(b, a).and_then(|s| this.stances[s as usize].as_ref().map(|o| (s, o)));
                other.is_some_and(|(s, other)| {
                    !this.net.is_feature(a, b)
                        && this.ground.judge.lie_on_each_other(own, other)
                        && (lean(own), slot) < (lean(other), s)
                })
            };
            is_bad(own) || quad.iter().any(is_off) || (0..4).any(lies)
        };
        let flags: Vec<bool> = slots.par_iter().map(|&slot| is_worse(slot)).collect();
        Ok(slots.iter().zip(flags).filter(|(_, bad)| *bad).map(|(&slot, _)| slot).collect())
    }

    /// Some slots and those that meet them, sorted.
    fn with_neighbours(&self, slots: &[u32]) -> Vec<u32> {
        let living = slots.iter().filter(|&&s| self.net.quads[s as usize] != DEAD);
        let meeting = living.flat_map(|&s| self.net.quads[s as usize]).flat_map(|v| self.net.at[v as usize].iter());
        let mut all: Vec<u32> = slots.iter().chain(meeting).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Tries one candidate after the other for a disc, and returns the best if it is better than what is there.
    fn solve(&self, ctx: &RunContext, own: &[u32]) -> Result<Option<Patch>, Cancelled> {
        let ground = self.ground;
        let points = own.iter().flat_map(|&slot| self.points[slot as usize].iter().copied()).collect();
        let mut start = Patch::new(ground, &self.net, &self.positions, own, points);
        start.look(ground);
        let all = start.all();
        // Vertices that were off their curves are back on them: that is a gain of its own.
        let mut best = (judge(ground, &start), start.clone());
        let before = if self.is_as_it_was(&start) { Some(best.0) } else { None };
        let take = |best: &mut (Verdict, Patch), found: (Verdict, Patch)| {
            if found.0.is_better_than(&best.0) {
                *best = found;
            }
            best.0.is_decent()
        };
        for is_spread in [false, true] {
            let mut moved = start.clone();
            if is_spread {
                moved.spread_over(ground, &all);
            }
            settle(ctx, ground, &mut moved, &all, Effort::Full)?;
            if take(&mut best, (judge(ground, &moved), moved)) {
                return Ok(Some(best.1));
            }
        }
        if own.len() <= MAX_QUADS {
            if let Some(found) = turned(ctx, ground, &best.1, best.0)?
                && take(&mut best, found)
            {
                return Ok(Some(best.1));
            }
            if let Some(found) = refilled(ctx, ground, &best.1)? {
                take(&mut best, found);
            }
        }
        Ok(before.is_none_or(|before| best.0.is_better_than(&before)).then_some(best.1))
    }

    fn is_as_it_was(&self, patch: &Patch) -> bool {
        patch.origin.iter().zip(&patch.positions).all(|(&v, &p)| self.positions[v as usize] == p)
    }

    /// Puts a patch in the place of its slots; returns all slots whose quads changed or may have.
    fn put_back(&mut self, ctx: &RunContext, own: &[u32], patch: &Patch) -> Result<Vec<u32>, Cancelled> {
        let known = patch.origin.len();
        for (&v, &p) in patch.origin.iter().zip(&patch.positions) {
            self.positions[v as usize] = p;
        }
        let mut used = vec![false; patch.positions.len()];
        patch.living().flatten().for_each(|&v| used[v as usize] = true);
        let mut number: Vec<u32> = patch.origin.clone();
        for v in known..patch.positions.len() {
            // A vertex that is not used is not put in.
            number.push(if used[v] { self.net.add_vertex(patch.anchors[v]) } else { 0 });
            if used[v] {
                self.positions.push(patch.positions[v]);
            }
        }
        let mut slots = own.to_vec();
        while slots.len() < patch.quads.len() {
            slots.push(self.net.add_slot());
            self.stances.push(None);
            self.points.push(Vec::new());
        }
        let rename = |quad: &[u32; 4]| if *quad == DEAD { DEAD } else { quad.map(|v| number[v as usize]) };
        let mut change: Change = slots.iter().copied().zip(patch.quads.iter().map(rename)).collect();
        self.net.apply(&mut change);
        slots.iter().for_each(|&slot| self.stances[slot as usize] = None);
        let points = assigned(ctx, &patch.quads, &patch.positions, &patch.points)?;
        slots.iter().zip(points).for_each(|(&slot, points)| self.points[slot as usize] = points);
        Ok(slots)
    }
}
