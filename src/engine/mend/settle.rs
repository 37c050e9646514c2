//! The one local solver: positions of the vertices inside a disc.
//!
//! The energy is that of `[garanzha_2021]` on corners of the quads, against the surface's normals averaged at the scale
//! of the quads: shape and area of every corner over a positive stand-in χ(D, ε) for the corner's area D, so that a corner
//! that is turned over is expensive but not infinitely so, and is drawn back. Vertices move one by one in the tangent
//! plane and are drawn to the surface, or along their curve.

use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::{Freedom, Patch};
use crate::engine::quad::improve::DEAD;
use crate::engine::quad::optimise::{ScaledCorner, quality};
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use std::f64::consts::TAU;

/// Sweeps per change of the regularisation.
const SWEEPS: usize = 4;
/// Directions in which a better place is looked for.
const DIRECTIONS: usize = 8;
/// Least scaled Jacobian at which the work ends.
const GOOD: f64 = 0.4;
/// Quads between curves are at least this part of those around: below that the energy loses its digits.
const MIN_SIZE: f64 = 1e-3;
/// Vertices that were spread out are drawn to the surface from this many edges, if its normal agrees, …
const REACH: f64 = 3.0;
/// … and those that move from so many times their way and this many edges: less than a vertex may be off at the start is
/// enough, since it comes nearer with every move.
const NEAR: f64 = 1.5;
const OFF: f64 = 0.05;
/// Rounds between two looks at the surface beneath the quads: it turns slowly as they move.
const LOOKING: usize = 2;
/// Rounds without progress (areas in squares of the wanted edge) after which corners that are turned over stay so.
const STALLED: usize = 8;
const PROGRESS: f64 = 1e-4;
/// Rounds of averaging that spread vertices out over a disc, so many per ring.
const SPREADING: usize = 40;

/// How long positions are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    /// To see what a candidate is worth: 6 rounds.
    Glance,
    /// To the end: 30 rounds.
    Full,
}

impl Effort {
    fn rounds(self) -> usize {
        match self {
            Self::Glance => 6,
            Self::Full => 30,
        }
    }
}

/// Spreads the free vertices among some out evenly: each at the mean of its neighbours, with all others fixed.
pub(super) fn spread(ground: &Ground<'_>, patch: &mut Patch, among: &[u32]) {
    let corners = corners_of(patch);
    let free = free(patch, &corners, among);
    for _ in 0..SPREADING {
        for v in free.iter().map(|&v| v as usize) {
            let target = middle(patch, &corners[v]);
            patch.positions[v] = patch.room(ground, v as u32).map_or(target, |room| room.nearest(target));
        }
    }
    let ups = ups_of(ground, patch);
    let reach = REACH * ground.edge;
    for v in free.into_iter().map(|v| v as usize) {
        if patch.freedom[v] == Freedom::Surface {
            let up = up_at(&corners[v], &ups);
            let p = patch.positions[v];
            patch.positions[v] =
                ground.drawn(p, up, reach).or_else(|| ground.drawn(p, DVec3::ZERO, f64::INFINITY)).unwrap_or(p);
        }
    }
}

/// The vertices among some that may move and have quads.
fn free(patch: &Patch, corners: &[Vec<(u32, u32)>], among: &[u32]) -> Vec<u32> {
    let is_free = |&v: &u32| patch.freedom[v as usize] != Freedom::Fixed && !corners[v as usize].is_empty();
    among.iter().copied().filter(is_free).collect()
}

/// Moves the free vertices among some to where the energy of the quads is least.
pub(super) fn settle(
    ctx: &RunContext,
    ground: &Ground<'_>,
    patch: &mut Patch,
    among: &[u32],
    effort: Effort,
) -> Result<(), Cancelled> {
    let corners = corners_of(patch);
    let free = free(patch, &corners, among);
    if free.is_empty() {
        return Ok(());
    }
    let size = own_size(patch, &free);
    let has_free = |q: &usize| patch.quads[*q].iter().any(|v| free.binary_search(v).is_ok());
    let moving: Vec<usize> = (0..patch.quads.len()).filter(has_free).collect();
    let mut steps = vec![0.3; patch.positions.len()];
    let mut epsilon = 0.0;
    let rounds = effort.rounds();
    let (mut ups, mut best) = (Vec::new(), (f64::NEG_INFINITY, 0));
    for round in 0..rounds {
        if round % LOOKING == 0 {
            ups = ups_of(ground, patch);
        }
        let least = least_area(patch, &ups, &moving, size);
        if round > 2 && least > 0.0 && worst(patch, &ups, &moving) > GOOD {
            break;
        }
        if least > best.0 + PROGRESS {
            best = (least, round);
        } else if least <= 0.0 && round >= best.1 + STALLED {
            break;
        }
        // The schedule of the paper with a constant rate.
        let wanted = (1e-6 + 0.04 * least.min(0.0) * least).abs().sqrt();
        epsilon = if round == 0 { wanted.max(1e-3) } else { (0.7 * epsilon).max(0.3 * wanted).max(1e-3) };
        // The last third of the rounds is for the worst corner of each vertex alone.
        let for_worst = 3 * round >= 2 * rounds && least > 0.0;
        for _ in 0..SWEEPS {
            ctx.check()?;
            for &v in &free {
                let at = &corners[v as usize];
                let step = &mut steps[v as usize];
                let moved = if for_worst {
                    compass(ground, patch, v, at, &ups, *step, |s, p| -s.worst_at(p))
                } else {
                    compass(ground, patch, v, at, &ups, *step, |s, p| s.energy(p, size, epsilon))
                };
                *step = if moved.is_some() { (1.5 * *step).min(0.6) } else { (0.5 * *step).max(0.004) };
                if let Some(p) = moved {
                    patch.positions[v as usize] = p;
                }
            }
        }
    }
    Ok(())
}

/// Per vertex, its corners (quad, corner of it) among the quads of the disc.
fn corners_of(patch: &Patch) -> Vec<Vec<(u32, u32)>> {
    let mut corners = vec![Vec::new(); patch.positions.len()];
    for (q, quad) in (0u32..).zip(&patch.quads).filter(|(_, quad)| **quad != DEAD) {
        (0u32..).zip(quad).for_each(|(k, &v)| corners[v as usize].push((q, k)));
    }
    corners
}

/// Mean of the edge neighbours, with the opposite corners at half weight to resist shear.
fn middle(patch: &Patch, corners: &[(u32, u32)]) -> DVec3 {
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for &(q, k) in corners {
        let quad = &patch.quads[q as usize];
        for (offset, w) in [(1, 1.0), (2, 0.5), (3, 1.0)] {
            sum += w * patch.positions[quad[(k as usize + offset) % 4] as usize];
            weight += w;
        }
    }
    sum / weight
}

/// The surface's averaged normal at each quad of the disc.
fn ups_of(ground: &Ground<'_>, patch: &mut Patch) -> Vec<DVec3> {
    patch.look(ground);
    patch.known.iter().map(|known| known.as_ref().map_or(DVec3::ZERO, |k| k.1.up)).collect()
}

fn up_at(corners: &[(u32, u32)], ups: &[DVec3]) -> DVec3 {
    corners.iter().map(|c| ups[c.0 as usize]).sum::<DVec3>().normalize_or_zero()
}

/// Edge of squares with the area of the quads at some vertices, at most twice what is around: folded quads have more area than
/// the surface beneath them.
fn own_size(patch: &Patch, free: &[u32]) -> f64 {
    let area = |q: &[u32; 4]| {
        let [a, b, c, d] = patch.corners(q);
        0.5 * (c - a).cross(d - b).length()
    };
    let moving = patch.living().filter(|q| q.iter().any(|v| free.binary_search(v).is_ok()));
    let (sum, n) = moving.fold((0.0, 0.0), |(sum, n), q| (sum + area(q), n + 1.0));
    (sum / n).sqrt().clamp(MIN_SIZE * patch.size, 2.0 * patch.size)
}

fn least_area(patch: &Patch, ups: &[DVec3], quads: &[usize], size: f64) -> f64 {
    let mut least = f64::INFINITY;
    for &q in quads {
        let p = patch.corners(&patch.quads[q]);
        least = (0..4).map(|k| ScaledCorner::of(&p, k, ups[q], size).area).fold(least, f64::min);
    }
    least
}

fn worst(patch: &Patch, ups: &[DVec3], quads: &[usize]) -> f64 {
    quads.iter().map(|&q| quality(&patch.corners(&patch.quads[q]), ups[q])).fold(f64::INFINITY, f64::min)
}

/// A vertex and its quads.
struct Star<'a> {
    patch: &'a Patch,
    corners: &'a [(u32, u32)],
    ups: &'a [DVec3],
}

impl Star<'_> {
    fn quads(&self, p: DVec3) -> impl Iterator<Item = ([DVec3; 4], usize, DVec3)> {
        self.corners.iter().map(move |&(q, k)| {
            let mut corners = self.patch.corners(&self.patch.quads[q as usize]);
            corners[k as usize] = p;
            (corners, k as usize, self.ups[q as usize])
        })
    }

    /// Regularised energy of the three corners of each quad that move with the vertex, if it were at `p`.
    fn energy(&self, p: DVec3, size: f64, epsilon: f64) -> f64 {
        let mut sum = 0.0;
        for (corners, k, up) in self.quads(p) {
            for at in [(k + 3) % 4, k, (k + 1) % 4] {
                sum += ScaledCorner::of(&corners, at, up, size).energy(epsilon);
            }
        }
        sum
    }

    fn worst_at(&self, p: DVec3) -> f64 {
        self.quads(p).map(|(corners, _, up)| quality(&corners, up)).fold(f64::INFINITY, f64::min)
    }
}

/// The best of the places around `v` at distance `step` (in units of the mean edge at `v`), if better than where it is.
fn compass(
    ground: &Ground<'_>,
    patch: &Patch,
    v: u32,
    corners: &[(u32, u32)],
    ups: &[DVec3],
    step: f64,
    cost: impl Fn(&Star<'_>, DVec3) -> f64,
) -> Option<DVec3> {
    let star = Star { patch, corners, ups };
    let here = patch.positions[v as usize];
    let edge = |&(q, k): &(u32, u32)| {
        let quad = &patch.quads[q as usize];
        let at = |i: usize| patch.positions[quad[(k as usize + i) % 4] as usize];
        0.5 * (at(1).distance(here) + at(3).distance(here))
    };
    let reach = step * corners.iter().map(edge).sum::<f64>() / corners.len() as f64;
    let up = up_at(corners, ups);
    let (x, y) = up.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    let around = (0..DIRECTIONS).map(|d| {
        let (sin, cos) = (TAU * d as f64 / DIRECTIONS as f64).sin_cos();
        here + reach * (cos * x + sin * y)
    });
    let targets = around.chain([here.lerp(middle(patch, corners), (2.0 * step).min(1.0))]);
    let now = cost(&star, here);
    let least = now - 1e-9 * now.abs();
    if let Some(room) = patch.room(ground, v) {
        let places = targets.map(|p| room.nearest(p)).map(|p| (cost(&star, p), p));
        return places.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 < least).map(|best| best.1);
    }
    let best = targets.map(|p| (cost(&star, p), p)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    if best.0 >= least {
        return None;
    }
    // The vertex lies on the surface, so that is no further away than the vertex.
    let reach = NEAR * best.1.distance(here) + OFF * ground.edge;
    ground.drawn(best.1, up, reach).filter(|&p| cost(&star, p) < least)
}
