//! Turning folded quads right side up.

use glam::DVec3;

use crate::engine::quad::optimise::shape::ScaledCorner;
use crate::engine::quad::optimise::state::Place;
use crate::engine::quad::optimise::state::State;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Quads worse than this are worked on.
const SOUND: f64 = 0.1;
/// Rings of quads around a bad one that take part.
const RINGS: usize = 3;
/// Changes of the regularisation.
const ROUNDS: usize = 24;
/// Sweeps per change.
const SWEEPS: usize = 4;
/// Directions in which a better place is looked for.
const DIRECTIONS: usize = 8;

/// Untangles with the regularised energy of `[garanzha_2021]`: shape and area of every corner, over a positive
/// stand-in χ(D, ε) for the corner's area D, so that a turned over corner is expensive but not infinitely so and the
/// energy draws it back. ε falls as the worst corner improves. `sizes`: wanted edge length per quad.
pub(crate) fn untangle(ctx: &RunContext, state: &mut State<'_>, sizes: &[f64]) -> Result<(), Cancelled> {
    let mut steps: Vec<f64> = Vec::new();
    let mut epsilon = 0.0;
    for round in 0..ROUNDS {
        ctx.check()?;
        ctx.advance(round as f64 / ROUNDS as f64);
        state.look_beneath();
        let bad: Vec<bool> = (0..state.quads.len()).map(|q| state.quality(q) < SOUND).collect();
        if !bad.contains(&true) {
            return Ok(());
        }
        let active = neighbourhood(state, bad, RINGS);
        if round == 0 {
            steps = vec![0.3; state.positions.len()];
        }
        let least = least_area(state, sizes, &active);
        // The schedule of the paper with a constant rate.
        let wanted = (1e-6 + 0.04 * least.min(0.0) * least).abs().sqrt();
        epsilon = if round == 0 { wanted.max(1e-3) } else { (0.7 * epsilon).max(0.3 * wanted).max(1e-3) };
        for _ in 0..SWEEPS {
            let grown: Vec<(u32, f64)> = descend(state, sizes, &active, &steps, epsilon);
            for (v, step) in grown {
                steps[v as usize] = step;
            }
        }
    }
    Ok(())
}

/// One sweep of compass search over the active vertices; returns their new steps.
fn descend(state: &mut State<'_>, sizes: &[f64], active: &[bool], steps: &[f64], epsilon: f64) -> Vec<(u32, f64)> {
    let before = state.positions.clone();
    state.sweep(|s, v| {
        if !active[v as usize] || s.places[v as usize] == Place::Fixed {
            return None;
        }
        compass(s, v, steps[v as usize], |p| energy(s, v, p, sizes, epsilon))
    });
    let changed = |v: &usize| before[*v] != state.positions[*v];
    (0..active.len())
        .filter(|&v| active[v])
        .map(|v| (v as u32, if changed(&v) { (1.5 * steps[v]).min(0.6) } else { (0.5 * steps[v]).max(0.004) }))
        .collect()
}

/// Improves vertices whose worst quad is below `below`, by the quality of that quad itself.
pub(crate) fn lift_worst(ctx: &RunContext, state: &mut State<'_>, below: f64, sweeps: usize) -> Result<(), Cancelled> {
    let mut step = 0.25;
    for sweep in 0..sweeps {
        ctx.check()?;
        ctx.advance(sweep as f64 / sweeps as f64);
        let bad: Vec<bool> = (0..state.quads.len()).map(|q| state.quality(q) < below).collect();
        if !bad.contains(&true) {
            break;
        }
        let active = neighbourhood(state, bad, 0);
        state.sweep(|s, v| {
            if !active[v as usize] || s.places[v as usize] == Place::Fixed {
                return None;
            }
            compass(s, v, step, |p| -s.quality_at(v, p))
        });
        step = if step < 0.02 { 0.25 } else { 0.6 * step };
    }
    Ok(())
}

/// The best of the places around `v` at distance `step` (in units of the mean edge at `v`), if better than where it is.
fn compass(s: &State<'_>, v: u32, step: f64, cost: impl Fn(DVec3) -> f64) -> Option<(Place, DVec3)> {
    let here = s.positions[v as usize];
    let corners = s.incidence.corners_of(v);
    let (mut ring, mut edge, mut up) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for &c in corners {
        let (q, k) = (c as usize / 4, c as usize % 4);
        let next = s.positions[s.quads[q][(k + 1) % 4] as usize];
        let prev = s.positions[s.quads[q][(k + 3) % 4] as usize];
        ring += 0.5 * (next + prev);
        edge += 0.5 * (next.distance(here) + prev.distance(here));
        up += s.ups[q];
    }
    let n = corners.len() as f64;
    let reach = step * edge / n;
    let (x, y) = up.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    let compass = (0..DIRECTIONS).map(|d| {
        let (sin, cos) = (std::f64::consts::TAU * d as f64 / DIRECTIONS as f64).sin_cos();
        here + reach * (cos * x + sin * y)
    });
    let mut best = (cost(here), None);
    for target in compass.chain([here.lerp(ring / n, (2.0 * step).min(1.0))]) {
        let to = s.drawn(v, target);
        let there = cost(to.1);
        if there < best.0 - 1e-9 * best.0.abs() {
            best = (there, Some(to));
        }
    }
    best.1
}

/// Regularised energy of the three corners that move with `v`, of each of its quads, if `v` were at `p`.
fn energy(s: &State<'_>, v: u32, p: DVec3, sizes: &[f64], epsilon: f64) -> f64 {
    let mut sum = 0.0;
    for &c in s.incidence.corners_of(v) {
        let (q, k) = (c as usize / 4, c as usize % 4);
        let corners = s.corners_with(q, k, p);
        for at in [(k + 3) % 4, k, (k + 1) % 4] {
            sum += ScaledCorner::of(&corners, at, s.ups[q], sizes[q]).energy(epsilon);
        }
    }
    sum
}

fn least_area(state: &State<'_>, sizes: &[f64], active: &[bool]) -> f64 {
    let mut least = f64::INFINITY;
    for (q, quad) in state.quads.iter().enumerate() {
        if quad.iter().any(|&v| active[v as usize]) {
            let p = state.corners(q);
            least = (0..4).map(|k| ScaledCorner::of(&p, k, state.ups[q], sizes[q]).area).fold(least, f64::min);
        }
    }
    least
}

/// Vertices within `rings` rings of quads around the marked quads.
fn neighbourhood(state: &State<'_>, mut marked: Vec<bool>, rings: usize) -> Vec<bool> {
    let mut active = vec![false; state.positions.len()];
    for ring in 0..=rings {
        for (quad, _) in state.quads.iter().zip(&marked).filter(|(_, m)| **m) {
            quad.iter().for_each(|&v| active[v as usize] = true);
        }
        if ring < rings {
            for (quad, mark) in state.quads.iter().zip(&mut marked) {
                *mark = quad.iter().any(|&v| active[v as usize]);
            }
        }
    }
    active
}
