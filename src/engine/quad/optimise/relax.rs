//! Local/global relaxation towards right angles and even edges.

use glam::DVec2;
use glam::DVec3;
use rayon::prelude::*;

use crate::engine::numerics::Cholesky;
use crate::engine::numerics::HermitianMatrix;
use crate::engine::quad::optimise::shape::area_vector;
use crate::engine::quad::optimise::state::Place;
use crate::engine::quad::optimise::state::State;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// How much the length of a side counts against its direction: 0 favours squares, 1 rhombi. Without it the
/// edges of most models vary more than their angles do.
const EVENNESS: f64 = 0.3;
/// Weight of the last position: keeps the system definite and the steps tangential.
const STAY: f64 = 0.05;
/// The same for vertices on curves, which can follow only along one direction.
const STAY_ON_CURVE: f64 = 0.3;
/// Weight of quads that are turned along a stroke.
const GUIDED_WEIGHT: f64 = 20.0;
/// A quad may get worse down to this, for the sake of its neighbours, but not further.
const FLOOR: f64 = 0.3;
/// Halvings of a refused step.
const HALVINGS: usize = 4;
/// Relaxation ends when no vertex moves further than this share of its wanted edge.
const STILL: f64 = 2e-3;

/// The square of this size that is turned like the quad, as its first and second side; one of them along `guide` unless
/// that is zero.
fn fitted_sides(p: &[DVec3; 4], up: DVec3, size: f64, guide: DVec3) -> (DVec3, DVec3) {
    let own = area_vector(p).normalize_or_zero();
    let n = if own.dot(up) > 0.0 { own } else { up };
    let Some(n) = n.try_normalize() else {
        return (0.5 * (p[1] - p[0] + p[2] - p[3]), 0.5 * (p[3] - p[0] + p[2] - p[1]));
    };
    let (x, y) = n.any_orthonormal_pair();
    let flat = |v: DVec3| DVec2::new(v.dot(x), v.dot(y));
    let (e, f) = (flat(0.5 * (p[1] - p[0] + p[2] - p[3])), flat(0.5 * (p[3] - p[0] + p[2] - p[1])));
    // Rotation of the polar decomposition of the Jacobian (e f), f turned back by a quarter.
    let direction = (e + DVec2::new(f.y, -f.x)).try_normalize().unwrap_or(DVec2::X);
    let direction = flat(guide).try_normalize().map_or(direction, |along| {
        let turns = [along, along.perp(), -along, -along.perp()];
        turns.into_iter().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction))).unwrap_or(direction)
    });
    let (r, s) = (direction.x * x + direction.y * y, direction.x * y - direction.y * x);
    (size * r, size * s)
}

/// Which vertices are relaxed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Moving {
    /// All that may move at all.
    All,
    /// Those that are on no curve.
    Inner,
}

/// Relaxes for at most `rounds` rounds. `sizes`: wanted edge length per quad; `guides`: a direction to turn to per quad,
/// zero for none, or empty.
pub(crate) fn relax(
    ctx: &RunContext,
    state: &mut State<'_>,
    sizes: &[f64],
    guides: &[DVec3],
    moving: Moving,
    rounds: usize,
) -> Result<(), Cancelled> {
    let guide = |q: usize| guides.get(q).copied().unwrap_or(DVec3::ZERO);
    let weight: Vec<f64> =
        (0..state.quads.len()).map(|q| if guide(q) == DVec3::ZERO { 1.0 } else { GUIDED_WEIGHT }).collect();
    let n_vertices = state.positions.len();
    let mut unknown = vec![u32::MAX; n_vertices];
    let mut free: Vec<u32> = Vec::new();
    for v in 0..n_vertices {
        let may_move = match state.places[v] {
            Place::Fixed => false,
            Place::Curve(..) => moving == Moving::All,
            Place::Face(_) => true,
        };
        if may_move && !state.incidence.corners_of(v as u32).is_empty() {
            unknown[v] = free.len() as u32;
            free.push(v as u32);
        }
    }
    if free.is_empty() {
        return Ok(());
    }
    let stay = |s: &State<'_>, v: u32| match s.places[v as usize] {
        Place::Curve(..) => STAY_ON_CURVE,
        _ => STAY,
    };
    let mut entries: Vec<(u32, u32, f64)> =
        free.iter().enumerate().map(|(i, &v)| (i as u32, i as u32, stay(state, v))).collect();
    for (quad, &w) in state.quads.iter().zip(&weight) {
        for k in 0..4 {
            let (i, j) = (unknown[quad[k] as usize], unknown[quad[(k + 1) % 4] as usize]);
            entries.extend([i, j].into_iter().filter(|&i| i != u32::MAX).map(|i| (i, i, w)));
            if i != u32::MAX && j != u32::MAX {
                entries.push((i.max(j), i.min(j), -w));
            }
        }
    }
    let n = free.len();
    // Diagonally dominant, so the factorisation fails only for want of memory: then the draft stays as it is.
    let Ok(factor) = Cholesky::new(&HermitianMatrix::from_lower(n, &entries)) else { return Ok(()) };
    for round in 0..rounds {
        ctx.check()?;
        ctx.advance(round as f64 / rounds as f64);
        state.look_beneath();
        let this = &*state;
        let sides: Vec<[DVec3; 4]> = (0..this.quads.len())
            .into_par_iter()
            .map(|q| {
                let p = this.corners(q);
                let (e, f) = fitted_sides(&p, this.ups[q], sizes[q], guide(q));
                let square = [e, f, -e, -f];
                let own = |k: usize| (p[(k + 1) % 4] - p[k]).normalize_or_zero() * sizes[q];
                std::array::from_fn(|k| square[k].lerp(own(k), EVENNESS))
            })
            .collect();
        let mut right = vec![0.0; 3 * n];
        let mut add = |i: usize, value: DVec3| (0..3).for_each(|axis| right[axis * n + i] += value[axis]);
        for (i, &v) in free.iter().enumerate() {
            add(i, stay(state, v) * state.positions[v as usize]);
        }
        for ((quad, sides), &w) in state.quads.iter().zip(&sides).zip(&weight) {
            for (k, &side) in sides.iter().enumerate() {
                let (a, b) = (quad[k] as usize, quad[(k + 1) % 4] as usize);
                let (i, j) = (unknown[a], unknown[b]);
                if i != u32::MAX {
                    add(i as usize, w * if j == u32::MAX { state.positions[b] - side } else { -side });
                }
                if j != u32::MAX {
                    add(j as usize, w * if i == u32::MAX { state.positions[a] + side } else { side });
                }
            }
        }
        factor.solve(&mut right);
        let before = state.positions.clone();
        state.sweep(|s, v| {
            let i = unknown[v as usize] as usize;
            (i < n).then(|| DVec3::new(right[i], right[n + i], right[2 * n + i])).and_then(|p| guarded(s, v, p))
        });
        let shift = |(q, quad): (usize, &[u32; 4])| {
            let far = quad.iter().map(|&v| before[v as usize].distance(state.positions[v as usize]));
            far.fold(0.0, f64::max) / sizes[q]
        };
        if state.quads.iter().enumerate().map(shift).fold(0.0, f64::max) < STILL {
            break;
        }
    }
    Ok(())
}

/// Moves `v` towards `p` as far as its quads bear it.
fn guarded(s: &State<'_>, v: u32, p: DVec3) -> Option<(Place, DVec3)> {
    let here = s.positions[v as usize];
    let bound = s.quality_at(v, here).min(FLOOR);
    let mut step = 1.0;
    for _ in 0..=HALVINGS {
        let to = s.drawn(v, here.lerp(p, step));
        if to.1 != here && s.quality_at(v, to.1) >= bound {
            return Some(to);
        }
        step *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_square_turns_with_the_quad() {
        let (x, y) = (DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.8, 0.6, 0.0));
        let p = [DVec3::ZERO, 4.0 * x, 4.0 * x + y, y];
        let (e, f) = fitted_sides(&p, DVec3::Z, 1.0, DVec3::ZERO);
        assert!(e.distance(x) < 1e-12 && f.distance(y) < 1e-12);
    }
}
