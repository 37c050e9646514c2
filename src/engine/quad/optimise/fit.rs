//! Vertices on curves go to where the sides between them lie close to the curve: a tight bend is missed by sides of even
//! length, and kept by a vertex in it.

use crate::engine::quad::optimise::curves::Curve;
use crate::engine::quad::optimise::state::Place;
use crate::engine::quad::optimise::state::State;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Sweeps over all vertices on curves.
const SWEEPS: usize = 6;
/// A side this many mean gaps off its curve all along costs as much as one of twice or no length.
const OFF: f64 = 0.15;
/// Points of a side at which its distance from the curve is taken.
const SAMPLES: usize = 12;
/// Places that are tried for a vertex, besides the bends of the curve.
const PLACES: usize = 16;
/// Bends of the curve that are tried at most.
const MAX_BENDS: usize = 24;
/// Sides get no shorter than this share of the mean gap, unless they were.
const SHORTEST: f64 = 0.4;
/// A vertex moves only if that takes this share of the cost.
const WORTH: f64 = 0.02;
/// A quad may get worse down to this (scaled Jacobian), but not further.
const FLOOR: f64 = 0.35;
/// Costs of a vertex' two sides below which it stays.
const FINE: f64 = 0.02;

/// Slides the vertices on curves; whether any one moved. O(n) per sweep.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub(super) fn fit_curves(ctx: &RunContext, state: &mut State<'_>) -> Result<bool, Cancelled> {
    let mut any = false;
    for sweep in 0..SWEEPS {
        ctx.check()?;
        ctx.advance(sweep as f64 / SWEEPS as f64);
        let moved = state.sweep(fitted);
        any |= moved > 0;
        if moved == 0 {
            break;
        }
    }
    Ok(any)
}

/// Where a vertex on a curve is better.
fn fitted(state: &State<'_>, v: u32) -> Option<(Place, glam::DVec3)> {
    let Place::Curve(slider, arc) = state.places[v as usize] else { return None };
    let (curve, gap, [below, above]) = state.stretch(slider, arc)?;
    let (from, to) = (arc - below, arc + above);
    let cost = |arc: f64| side_cost(curve, from, arc, gap) + side_cost(curve, arc, to, gap);
    let now = cost(arc);
    if now < FINE {
        return None;
    }
    let least = SHORTEST * gap;
    let (lo, hi) = ((from + least).min(arc), (to - least).max(arc));
    if lo >= hi {
        return None;
    }
    let even = (0..=PLACES).map(|i| lo + (hi - lo) * i as f64 / PLACES as f64);
    let mut best = (now * (1.0 - WORTH), None);
    for arc in even.chain(curve.bends_between(lo, hi, MAX_BENDS)) {
        let cost = cost(arc);
        if cost < best.0 {
            best = (cost, Some(arc));
        }
    }
    let arc = curve.wrap(best.1?);
    let p = curve.at(arc);
    let bound = state.quality_at(v, state.positions[v as usize]).min(FLOOR);
    (state.quality_at(v, p) >= bound).then_some((Place::Curve(slider, arc), p))
}

/// What a side from one arc parameter to another costs: its mean squared distance from the curve, by length, and how
/// far its length along the curve is from the mean gap.
fn side_cost(curve: &Curve, from: f64, to: f64, gap: f64) -> f64 {
    let (a, b) = (curve.at(from), curve.at(to));
    let along = (b - a).normalize_or_zero();
    let mut off = 0.0;
    for i in 0..SAMPLES {
        let t = (i as f64 + 0.5) / SAMPLES as f64;
        let p = curve.at(from + t * (to - from)) - a;
        off += (p - along * p.dot(along).clamp(0.0, a.distance(b))).length_squared();
    }
    let length = (to - from) / gap;
    let off = off / SAMPLES as f64 / (OFF * gap).powi(2);
    length * off + (length - 1.0).powi(2)
}
