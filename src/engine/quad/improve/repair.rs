//! Quads that are turned over against the surface are mended one by one, where they are.

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::closest_on_triangle;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::improve::net::Change;
use crate::engine::quad::improve::net::DEAD;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::operations::candidates;
use crate::engine::quad::improve::shaping::Shaping;
use crate::engine::quad::optimise::Sheet;
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::quad::optimise::quality;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A draft with more bad quads than this part of all (or than `FEW`) is bad as a whole.
const MOST: f64 = 0.06;
const FEW: usize = 20;
/// Mean edges around a place that is to be left as it is.
const LEFT: f64 = 3.0;
/// Rounds over the bad quads.
const ROUNDS: usize = 6;
/// Steps of single corners, in mean edges,
const SHIFTS: [f64; 6] = [0.5, 0.35, 0.25, 0.5, 0.25, 0.12];
/// into so many directions, as long as quads stay this near to where the corners were.
const DIRECTIONS: u32 = 8;
const CUT_OFF: f64 = 0.3;

/// Which quads are mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bad {
    /// Those that are turned over against the surface or have no area.
    TurnedOver,
    /// Those, and quads with a corner that is straight or reflex.
    Reflex,
    /// All these, and quads that only turn their back to the surface beneath their middle: the certificate lets them
    /// pass, but who looks at no more than that will not.
    Against,
}

/// Least scaled Jacobian of a quad that is not [`Bad::Reflex`].
pub(super) const STRAIGHT: f64 = 0.02;

/// Mends bad quads: their free vertices are evened out on the
/// surface or off it, and where that is not enough an edge is turned or a diagonal shrunk. Everything that is not near
/// a bad quad stays as it is, bit for bit, and so do topology, feature edges, boundary and anchored vertices.
///
/// Quads near `leave` are left as they are: an earlier try did harm there.
///
/// Returns `None` if there is nothing to mend, if too much is bad, or if nothing could be mended; a draft with fewer
/// bad quads otherwise. `index` is the one of `surface.mesh`.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn repair_quads(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: &QuadDraft,
    which: Bad,
    leave: &[DVec3],
) -> Result<Option<QuadDraft>, Cancelled> {
    let mean = mean_edge(draft);
    if !(is_sound(surface, draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(None);
    }
    let mut bad = bad_quads(ctx, index, draft, which)?;
    bad.retain(|&q| {
        let centre =
            draft.mesh.quads[q as usize].iter().map(|&v| draft.mesh.positions[v as usize]).sum::<DVec3>() / 4.0;
        leave.iter().all(|place| place.distance(centre) > LEFT * mean)
    });
    if bad.is_empty() || bad.len() > FEW.max((MOST * draft.mesh.quads.len() as f64) as usize) {
        return Ok(None);
    }
    let sheet = Sheet::new(surface, mean);
    let shaping = Shaping::new(&sheet, index, draft, 0.5 * mean);
    let mut repair = Repair { net: QuadNet::new(draft), shaping, index, which, mean };
    let mut left = bad;
    let mut mended = false;
    for round in 0..ROUNDS {
        let part = ctx.part(round, ROUNDS);
        let before = left.len();
        let mut next = Vec::new();
        for slot in left {
            ctx.check()?;
            part.step(before);
            mended |= repair.mend(slot);
            next.extend(repair.ring(slot).into_iter().filter(|&q| repair.is_bad(q)));
        }
        next.sort_unstable();
        next.dedup();
        left = next;
        if left.is_empty() || left.len() > 2 * before {
            break;
        }
    }
    Ok(mended.then(|| {
        let Repair { net, shaping, .. } = repair;
        net.into_draft(&shaping.positions, draft)
    }))
}

fn bad_quads(ctx: &RunContext, index: &SurfaceIndex, draft: &QuadDraft, which: Bad) -> Result<Vec<u32>, Cancelled> {
    let found: Vec<bool> = draft
        .mesh
        .quads
        .par_iter()
        .enumerate()
        .map(|(q, quad)| {
            if q % 32 == 0 {
                ctx.check()?;
            }
            Ok(which.has(index, &quad.map(|v| draft.mesh.positions[v as usize])))
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok((0u32..).zip(found).filter(|&(_, bad)| bad).map(|(q, _)| q).collect())
}

/// Whether a quad has no area, or turns its back both to the normals beneath its corners and to the one beneath its
/// middle.
pub(super) fn is_turned_over(index: &SurfaceIndex, p: &[DVec3; 4]) -> bool {
    if is_flat(p) {
        return true;
    }
    let around: DVec3 = p.iter().map(|&c| index.smooth_normal(&index.closest(c))).sum();
    area_vector(p).dot(around) <= 0.0 && is_against(index, p)
}

/// Whether a quad turns its back to the normal beneath its middle.
fn is_against(index: &SurfaceIndex, p: &[DVec3; 4]) -> bool {
    area_vector(p).dot(index.normal(index.closest(p.iter().sum::<DVec3>() / 4.0).face)) <= 0.0
}

fn is_flat(p: &[DVec3; 4]) -> bool {
    area_vector(p).length() <= 1e-9 * p[0].distance_squared(p[2]).max(p[1].distance_squared(p[3]))
}

impl Bad {
    fn has(self, index: &SurfaceIndex, p: &[DVec3; 4]) -> bool {
        let is_reflex = || quality(p, area_vector(p).normalize_or_zero()) < STRAIGHT;
        match self {
            Self::TurnedOver => is_turned_over(index, p),
            Self::Reflex => is_reflex() || is_turned_over(index, p),
            Self::Against => is_reflex() || is_flat(p) || is_against(index, p),
        }
    }
}

/// How many quads turn their back to the surface beneath their middle.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn count_against(ctx: &RunContext, index: &SurfaceIndex, mesh: &QuadMesh) -> Result<usize, Cancelled> {
    let judge = |(q, quad): (usize, &[u32; 4])| {
        if q % 32 == 0 {
            ctx.check()?;
        }
        Ok(usize::from(is_against(index, &quad.map(|v| mesh.positions[v as usize]))))
    };
    mesh.quads.par_iter().enumerate().map(judge).sum()
}

struct Repair<'a> {
    net: QuadNet,
    shaping: Shaping<'a>,
    index: &'a SurfaceIndex,
    which: Bad,
    /// Mean length of the edges.
    mean: f64,
}

/// How a region looks: bad quads, and then the worst corner with its sign turned, less is better.
type Score = (usize, f64);

impl Repair<'_> {
    fn corners(&self, slot: u32) -> [DVec3; 4] {
        self.net.quads[slot as usize].map(|v| self.shaping.positions[v as usize])
    }

    fn is_bad(&self, slot: u32) -> bool {
        self.net.quads[slot as usize] != DEAD && self.which.has(self.index, &self.corners(slot))
    }

    /// The slots that meet the quad in a slot, itself among them.
    fn ring(&self, slot: u32) -> Vec<u32> {
        if self.net.quads[slot as usize] == DEAD { Vec::new() } else { self.slots(&self.net.quads[slot as usize]) }
    }

    fn slots(&self, vertices: &[u32]) -> Vec<u32> {
        let mut slots: Vec<u32> = vertices.iter().flat_map(|&v| self.net.at[v as usize].iter().copied()).collect();
        slots.sort_unstable();
        slots.dedup();
        slots
    }

    fn score(&self, vertices: &[u32]) -> Score {
        let (mut bad, mut worst) = (0, f64::INFINITY);
        for slot in self.slots(vertices) {
            let p = self.corners(slot);
            bad += usize::from(self.which.has(self.index, &p));
            worst = worst.min(quality(&p, area_vector(&p).normalize_or_zero()));
        }
        (bad, -worst)
    }

    /// Tries everything at one bad quad and keeps what leaves the fewest bad ones; tells whether anything was kept.
    fn mend(&mut self, slot: u32) -> bool {
        if !self.is_bad(slot) {
            return false;
        }
        if self.which == Bad::Against && self.shift(slot) {
            return true;
        }
        let quad = self.net.quads[slot as usize];
        let mut changes: Vec<Change> = vec![Vec::new()];
        let near = |change: &Change| change.iter().any(|(s, _)| *s == slot);
        changes.extend(candidates(&self.net, &quad).into_iter().filter(near));
        let mut best: Option<(f64, usize, bool)> = None;
        for (i, change) in changes.iter_mut().enumerate() {
            for on_surface in [true, false] {
                let Some((touched, before)) = self.region(slot, change) else { continue };
                let old = self.shaping.places(&touched);
                if !change.is_empty() && !self.net.try_apply(change) {
                    continue;
                }
                self.even_out(&touched, on_surface);
                let after = self.score(&touched);
                self.shaping.put_back(&touched, &old);
                self.net.apply(change);
                // Fewer bad quads first, then better corners; changes of the connectivity have to be worth it.
                let cost = if change.is_empty() { 0.0 } else { 0.1 };
                let value = after.0 as f64 - before.0 as f64 + 0.4 * (after.1 + cost).clamp(-1.0, 1.0);
                if after.0 < before.0 && best.is_none_or(|b| value < b.0) {
                    best = Some((value, i, on_surface));
                }
            }
        }
        let Some((_, i, on_surface)) = best else { return false };
        let Some((touched, _)) = self.region(slot, &changes[i]) else { return false };
        self.net.apply(&mut changes[i]);
        self.even_out(&touched, on_surface);
        true
    }

    /// Shifts the free corners of a bad quad along the surface, one by one and all together, by less and less, and
    /// keeps what leaves fewer bad quads; tells whether anything was kept. At tips and between sheets what lies
    /// beneath the middle of a quad leaps, and no averaging aims at that.
    fn shift(&mut self, slot: u32) -> bool {
        let quad = self.net.quads[slot as usize];
        let free: Vec<u32> = quad.into_iter().filter(|&v| self.net.is_free(v)).collect();
        let groups = free.iter().map(|&v| vec![v]).chain((free.len() > 1).then(|| free.clone()));
        let groups: Vec<Vec<u32>> = groups.collect();
        let tips = quad.map(|v| self.shaping.positions[v as usize]);
        let before = self.score(&quad);
        let mut best = before;
        for part in SHIFTS {
            for group in &groups {
                for turn in 0..DIRECTIONS {
                    let old = self.shaping.places(group);
                    self.shaping.shift(group, part * self.mean, TAU * f64::from(turn) / f64::from(DIRECTIONS));
                    let after = self.score(&quad);
                    if after < best && self.reaches(&quad, &tips) {
                        best = after;
                    } else {
                        self.shaping.put_back(group, &old);
                    }
                }
            }
        }
        best.0 < before.0
    }

    /// Whether the quads at `vertices` come near to all of `tips`.
    fn reaches(&self, vertices: &[u32], tips: &[DVec3]) -> bool {
        let quads: Vec<[DVec3; 4]> = self.slots(vertices).into_iter().map(|slot| self.corners(slot)).collect();
        tips.iter().all(|&tip| {
            let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            halves.into_iter().any(|half| closest_on_triangle(tip, &half).1.distance(tip) < CUT_OFF * self.mean)
        })
    }

    /// The vertices that a change moves, and their score now.
    fn region(&self, slot: u32, change: &Change) -> Option<(Vec<u32>, Score)> {
        let mut touched = if change.is_empty() {
            let mut all: Vec<u32> = self.ring(slot).iter().flat_map(|&q| self.net.quads[q as usize]).collect();
            all.sort_unstable();
            all.dedup();
            all
        } else {
            self.net.touched(change)
        };
        touched.retain(|&v| !self.net.at[v as usize].is_empty());
        (!touched.is_empty()).then(|| {
            let score = self.score(&touched);
            (touched, score)
        })
    }

    fn even_out(&mut self, vertices: &[u32], on_surface: bool) {
        let moving: Vec<u32> =
            vertices.iter().copied().filter(|&v| self.net.is_free(v) && !self.net.at[v as usize].is_empty()).collect();
        self.shaping.even_out(&self.net, &moving);
        if on_surface {
            self.shaping.draw(&moving);
        }
    }
}
