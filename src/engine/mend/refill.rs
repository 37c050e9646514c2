//! Other fillings of the pieces of a disc: patterns of quads over their boundaries.

use crate::engine::mend::ground::Ground;
use crate::engine::mend::patch::{Freedom, Patch, sides};
use crate::engine::mend::settle::{Effort, settle};
use crate::engine::mend::verdict::{Verdict, bad_quads, judge};
use crate::engine::mend::words::{Piece, pieces};
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::Pattern;
use crate::engine::quad::improve::DEAD;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Patterns with the best degrees that are looked at.
const SHORTLIST: usize = 10;
/// … as long as these patches have no more quads in sum, but two at least.
const MAX_LOOKED_AT: usize = 1000;
/// The best of them that are solved to the end.
const FINALISTS: usize = 2;
/// Boundaries with more sides are not refilled.
const MAX_SIDES: usize = 60;
/// Cost of a vertex inside with two quads, in squared deviations of a number of quads: it is never wanted.
const DOUBLET: i64 = 40;
/// A corner of a quad of more than 170 degrees is as good as straight.
const STRAIGHT: f64 = 170.0 / 180.0 * PI;

/// The best filling of the pieces with bad quads, with its verdict; nothing if no piece can be refilled.
pub(super) fn refilled(
    ctx: &RunContext,
    ground: &Ground<'_>,
    patch: &Patch,
) -> Result<Option<(Verdict, Patch)>, Cancelled> {
    let mut best: Option<(Verdict, Patch)> = None;
    let bad = bad_quads(ground, patch);
    for piece in pieces(patch).iter().filter(|piece| piece.quads.iter().any(|&q| bad[q])) {
        let base = best.as_ref().map_or(patch, |b| &b.1);
        if let Some(found) = refill_piece(ctx, ground, base, piece)?
            && best.as_ref().is_none_or(|b| found.0.is_better_than(&b.0))
        {
            best = Some(found);
        }
    }
    Ok(best)
}

fn refill_piece(
    ctx: &RunContext,
    ground: &Ground<'_>,
    patch: &Patch,
    piece: &Piece,
) -> Result<Option<(Verdict, Patch)>, Cancelled> {
    let n = piece.word.len();
    if !(4..=MAX_SIDES).contains(&n) || n % 2 == 1 {
        return Ok(None);
    }
    let surroundings = Surroundings::new(ground, patch, piece);
    let mut patterns = Pattern::candidates(n as u32);
    let half = n as u32 / 2;
    let cores: Vec<Pattern> = (1..=half / 2).map(|a| Pattern::grid(a, half - a, 0)).collect();
    patterns.extend(cores.iter().map(Pattern::padded));
    let simple = patterns.into_iter().filter(|p| surroundings.is_simple(&piece.word, p));
    let mut ranked: Vec<(i64, Pattern)> = simple.map(|p| (surroundings.cost(patch, &piece.word, &p), p)).collect();
    ranked.sort_by_key(|r| r.0);
    ranked.truncate(SHORTLIST.min(MAX_LOOKED_AT / patch.quads.len()).max(2));
    let mut glanced: Vec<(Verdict, Patch)> = Vec::new();
    for (_, pattern) in &ranked {
        ctx.check()?;
        let mut filled = insert(patch, piece, pattern);
        let among = vertices_of(&filled, piece, patch.quads.len());
        filled.spread_over(ground, &among);
        settle(ctx, ground, &mut filled, &among, Effort::Glance)?;
        let verdict = judge(ground, &filled);
        let is_decent = verdict.is_decent();
        glanced.push((verdict, filled));
        if is_decent {
            break;
        }
    }
    glanced.sort_by(|a, b| a.0.order(&b.0));
    let mut best: Option<(Verdict, Patch)> = None;
    for (_, mut filled) in glanced.into_iter().take(FINALISTS) {
        let among = vertices_of(&filled, piece, patch.quads.len());
        settle(ctx, ground, &mut filled, &among, Effort::Full)?;
        let verdict = judge(ground, &filled);
        if best.as_ref().is_none_or(|b| verdict.is_better_than(&b.0)) {
            best = Some((verdict, filled));
        }
    }
    Ok(best)
}

/// The vertices of a piece with another filling, of which the quads from `new` on are, too.
fn vertices_of(patch: &Patch, piece: &Piece, new: usize) -> Vec<u32> {
    let quads = piece.quads.iter().copied().chain(new..patch.quads.len());
    let mut all: Vec<u32> = quads.map(|q| patch.quads[q]).filter(|q| *q != DEAD).flatten().collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// What a filling must fit to: all quads of the patch but those of the piece.
struct Surroundings {
    edges: BTreeSet<[u32; 2]>,
    /// Per vertex the number of its quads.
    quads_at: Vec<i64>,
    is_boundary: BTreeSet<u32>,
    /// Per place of the word where two curves meet, the angle of the piece between them in radians.
    angles: Vec<Option<f64>>,
}

impl Surroundings {
    fn new(ground: &Ground<'_>, patch: &Patch, piece: &Piece) -> Self {
        let mut all: Vec<[u32; 2]> =
            sides(&patch.quads).chain(sides(&patch.around)).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        all.sort_unstable();
        let lone = all.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        let lone: BTreeSet<[u32; 2]> = lone.map(|same| same[0]).collect();
        let is_boundary = lone.iter().flatten().copied().collect();
        let mut kept = patch.quads.clone();
        piece.quads.iter().for_each(|&q| kept[q] = DEAD);
        let mut quads_at = vec![0; patch.positions.len()];
        let living = kept.iter().filter(|q| **q != DEAD).chain(&patch.around);
        living.flatten().for_each(|&v| quads_at[v as usize] += 1);
        let ends = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let mut edges: BTreeSet<[u32; 2]> = sides(&kept).chain(sides(&patch.around)).map(ends).collect();
        let word = &piece.word;
        edges.extend((0..word.len()).map(|i| ends([word[i], word[(i + 1) % word.len()]])));
        let is_curve = |a: u32, b: u32| patch.is_feature(a, b) || lone.contains(&ends([a, b]));
        let angle = |i: usize| {
            let [before, at, after] = [word.len() - 1, 0, 1].map(|k| word[(i + k) % word.len()]);
            (is_curve(before, at) && is_curve(at, after)).then(|| {
                let quads = piece.quads.iter().copied().filter(|&q| patch.quads[q].contains(&at));
                let up: DVec3 = quads.filter_map(|q| patch.stance(ground, q)).map(|s| s.up).sum();
                let [before, at, after] = [before, at, after].map(|v| patch.positions[v as usize]);
                let (e, f) = (after - at, before - at);
                let angle = e.cross(f).dot(up.normalize_or_zero()).atan2(e.dot(f));
                if angle <= 0.0 { angle + TAU } else { angle }
            })
        };
        let angles = (0..word.len()).map(angle).collect();
        Self { edges, quads_at, is_boundary, angles }
    }

    /// Whether a pattern joins no two vertices that are joined already, or twice, or a vertex to itself.
    fn is_simple(&self, word: &[u32], pattern: &Pattern) -> bool {
        let n = pattern.sides;
        let id = |v: u32| if v < n { word[v as usize] } else { self.quads_at.len() as u32 + v };
        let inner = pattern.quads.iter().flat_map(|q| (0..4).map(move |k| (q[k], q[(k + 1) % 4])));
        // Each new edge lies in two quads, once in each direction.
        let inner = inner.filter(|&(a, b)| a < b && !(b < n && b == a + 1) && !(a == 0 && b == n - 1));
        let mut new: Vec<[u32; 2]> = inner.map(|(a, b)| [id(a).min(id(b)), id(a).max(id(b))]).collect();
        new.sort_unstable();
        let is_distinct = |q: &[u32; 4]| (0..4).all(|i| (i + 1..4).all(|j| id(q[i]) != id(q[j])));
        new.windows(2).all(|w| w[0] != w[1])
            && new.iter().all(|e| e[0] != e[1] && !self.edges.contains(e))
            && pattern.quads.iter().all(is_distinct)
    }

    /// Sum of squared deviations of the numbers of quads at all vertices of the filled piece.
    fn cost(&self, patch: &Patch, word: &[u32], pattern: &Pattern) -> i64 {
        let mut at: BTreeMap<u32, i64> = word.iter().map(|&v| (v, self.quads_at[v as usize])).collect();
        let id = |v: u32| if v < pattern.sides { word[v as usize] } else { self.quads_at.len() as u32 + v };
        let between = word.iter().zip(&self.angles).filter(|(_, angle)| angle.is_some());
        let between_curves: Vec<u32> = between.map(|(&v, _)| v).collect();
        pattern.quads.iter().flatten().for_each(|&v| *at.entry(id(v)).or_insert(0) += 1);
        let cost = |(&v, &n): (&u32, &i64)| {
            let is_boundary = self.is_boundary.contains(&v);
            let doublet = if n == 2 && !is_boundary { DOUBLET } else { 0 };
            match patch.anchors.get(v as usize) {
                Some(Anchor::Corner(_)) => doublet,
                _ if between_curves.contains(&v) => 0,
                _ => doublet + (n - if is_boundary { 2 } else { 4 }).pow(2),
            }
        };
        // Between two curves each quad has about a right angle, and none a straight one.
        let sector = |(i, angle): (usize, &Option<f64>)| {
            let Some(angle) = *angle else { return 0 };
            let n = pattern.quads.iter().flatten().filter(|&&v| v as usize == i).count() as i64;
            let wanted = (angle / FRAC_PI_2).round().max(1.0) as i64;
            (n - wanted).pow(2) + if angle > n as f64 * STRAIGHT { DOUBLET } else { 0 }
        };
        at.iter().map(cost).sum::<i64>() + self.angles.iter().enumerate().map(sector).sum::<i64>()
    }
}

/// The patch with another filling of a piece. New vertices lie in the middle of the boundary; those that are no longer
/// used stay behind without quads.
pub(super) fn insert(patch: &Patch, piece: &Piece, pattern: &Pattern) -> Patch {
    let mut filled = patch.clone();
    let word = &piece.word;
    let centre = word.iter().map(|&v| patch.positions[v as usize]).sum::<DVec3>() / word.len() as f64;
    let first = filled.positions.len() as u32;
    for _ in 0..pattern.new_nodes {
        filled.positions.push(centre);
        filled.anchors.push(Anchor::Surface);
        filled.freedom.push(Freedom::Surface);
    }
    let id = |v: u32| if v < pattern.sides { word[v as usize] } else { first + v - pattern.sides };
    let mut slots = piece.quads.iter().copied();
    slots.by_ref().zip(&pattern.quads).for_each(|(slot, quad)| filled.quads[slot] = quad.map(id));
    if pattern.quads.len() < piece.quads.len() {
        piece.quads[pattern.quads.len()..].iter().for_each(|&slot| filled.quads[slot] = DEAD);
    } else {
        filled.quads.extend(pattern.quads[piece.quads.len()..].iter().map(|quad| quad.map(id)));
    }
    filled
}
