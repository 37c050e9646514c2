//! Integers by minimum-deviation flow `[coudert_osmont_2024]`, for maps with more of them than the period matrix can be
//! held for, and where rounding by it lets neighbours collapse.
//!
//! The seamless map is decimated to triangles between singularities, corners and curves. Both extents of every edge are
//! integers near those of the map that keep their signs; the sum around a triangle vanishes. The map's own integers
//! follow from them. Unlike rounding by the period matrix this says nothing of the energy, only of lengths, but needs
//! no matrix, and neighbours that must not collapse are bounds of single variables.

mod complex;
mod decimate;
mod flow;
mod labels;
mod recover;
#[cfg(test)]
mod tests;

pub use flow::{Flow, Variable};

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::parameterize::grid_map::{Iso, rotate};
use crate::engine::parameterize::quantise::complex::{Complex, named};
use crate::engine::parameterize::quantise::decimate::decimate;
use crate::engine::parameterize::quantise::recover::recover;
use crate::engine::parameterize::separation::{Elements, SHORTEST};
use crate::engine::run::{Cancelled, RunContext};
use glam::{DVec2, I64Vec2};

/// Extents this short, in grid units, may vanish or change their sign.
const MAY_TURN: f64 = 0.05;
/// Times that triangles that turn over are pulled open, while that leaves at most two thirds of them.
const MAX_PULLS: usize = 5;
/// Each pull takes this share of what is left of the progress: there are mostly fewer than allowed.
const SHARE_OF_PULL: f64 = 0.5;

/// Integers for the map with these real unknowns, grid units; `None` if there is no flow, or it leaves some of them open.
pub(super) fn quantise(ctx: &RunContext, elements: &Elements<'_>, raw: &[f64]) -> Result<Option<Vec<f64>>, Cancelled> {
    let mut complex = Complex::new(elements, raw, named(elements));
    complex.keep_turns();
    decimate(&ctx.span(0.05, 0.25), &mut complex)?;
    let is_special = |v: u32| elements.special.binary_search(&v).is_ok();
    let (extents, mut flow) = flow_of(&complex, &complex.integral(is_special));
    let nearest: Vec<i64> = flow.variables().iter().map(|v| v.target.round() as i64).collect();
    let Some(mut x) = flow.solve(&ctx.span(0.25, 0.6), &nearest)? else { return Ok(None) };
    let mut most = usize::MAX;
    let pulls = ctx.span(0.6, 0.9);
    for _ in 0..MAX_PULLS {
        let turned = pull_open(&complex, &extents, &mut flow, &x);
        if turned == 0 || turned > most {
            break;
        }
        most = turned * 2 / 3;
        let Some(pulled) = flow.solve(&pulls.attempt(SHARE_OF_PULL), &x)? else { break };
        x = pulled;
    }
    let along = extents.iter().map(|extent| extent.value(&x)).collect::<Vec<_>>();
    recover(&ctx.span(0.9, 1.0), elements, &complex, &along)
}

/// Where the extents of a halfedge come from.
#[derive(Clone, Copy, Debug, Default)]
struct Extent {
    /// Per coordinate, in the chart of the halfedge's triangle, the variable and its sign; no variable means 0.
    parts: [Option<(u32, i64)>; 2],
}

impl Extent {
    fn value(&self, x: &[i64]) -> I64Vec2 {
        let part = |c: usize| self.parts[c].map_or(0, |(e, sign)| sign * x[e as usize]);
        I64Vec2::new(part(0), part(1))
    }

    /// The same edge the other way in a chart that this one's is `quarters` away from.
    fn seen_from_twin(&self, quarters: u8) -> Self {
        let mut parts = [None; 2];
        for (c, part) in self.parts.iter().enumerate() {
            let unit = if c == 0 { DVec2::X } else { DVec2::Y };
            let there = -rotate(unit, (4 - quarters) & 3);
            let to = usize::from(there.y != 0.0);
            parts[to] = part.map(|(e, sign)| (e, if there[to] > 0.0 { sign } else { -sign }));
        }
        Self { parts }
    }
}

/// Variables for the extents of all edges; per triangle and coordinate their sum vanishes.
fn flow_of(complex: &Complex, integral: &[[bool; 2]]) -> (Vec<Extent>, Flow) {
    let mut extents = vec![Extent::default(); complex.origin.len()];
    let mut variables: Vec<Variable> = Vec::new();
    let edges = (0..complex.origin.len()).filter(|&h| complex.is_alive(h));
    for h in edges.filter(|&h| complex.twin[h] == NONE || (h as u32) < complex.twin[h]) {
        let along = complex.along(h);
        let end = next(h);
        let longer = usize::from(along.y.abs() > along.x.abs());
        for c in 0..2 {
            let fixed = if c == 0 { Iso::U } else { Iso::V };
            if complex.iso[h] == fixed {
                continue;
            }
            let sign = if along[c] < 0.0 { -1 } else { 1 };
            let target = along[c].abs();
            let must_not_vanish = c == longer && target >= SHORTEST && integral[h][c] && integral[end][c];
            let least = match must_not_vanish {
                true => 1,
                false if target < MAY_TURN => -1,
                false => 0,
            };
            extents[h].parts[c] = Some((variables.len() as u32, sign));
            variables.push(Variable { ends: [None; 2], target, weight: 1.0 / (target + 0.1), least });
        }
        let mut sides = vec![h];
        if complex.twin[h] != NONE {
            let twin = complex.twin[h] as usize;
            extents[twin] = extents[h].seen_from_twin(complex.across[h].quarters);
            sides.push(twin);
        }
        for (side, &h) in sides.iter().enumerate() {
            for (c, part) in extents[h].parts.iter().enumerate() {
                if let Some((e, sign)) = part {
                    variables[*e as usize].ends[side] = Some((2 * (h / 3) as u32 + c as u32, *sign));
                }
            }
        }
    }
    keep_strips(complex, integral, &extents, &mut variables);
    let n_sums = 2 * complex.gone.len();
    (extents, Flow::new(n_sums, variables))
}

/// A point over a line must not fall onto it: the height of a triangle over an edge of a curve must not vanish if its
/// third vertex lies over the edge.
fn keep_strips(complex: &Complex, integral: &[[bool; 2]], extents: &[Extent], variables: &mut [Variable]) {
    for h in (0..complex.origin.len()).filter(|&h| complex.is_alive(h)) {
        let c = match complex.iso[h] {
            Iso::None => continue,
            Iso::U => 0,
            Iso::V => 1,
        };
        let (n, p) = (next(h), prev(h));
        let (base, up) = (complex.along(h), complex.along(n));
        let is_over = base[1 - c] * up[1 - c] <= 0.0 && base[1 - c] * complex.along(p)[1 - c] <= 0.0;
        if up[c].abs() < SHORTEST || !is_over || !integral[p][c] {
            continue;
        }
        for side in [n, p] {
            if let Some((e, _)) = extents[side].parts[c] {
                variables[e as usize].least = 1;
            }
        }
    }
}

/// Raises the bounds of extents of triangles that have turned over; how many could be raised.
fn pull_open(complex: &Complex, extents: &[Extent], flow: &mut Flow, x: &[i64]) -> usize {
    let mut turned = 0;
    for f in (0..complex.gone.len()).filter(|&f| !complex.gone[f]) {
        let [a, b] = [3 * f, 3 * f + 1].map(|h| extents[h].value(x));
        if a.perp_dot(b) >= 0 || complex.twice_area(f) <= 0.0 {
            continue;
        }
        // The extents that make its area positive are to be as large as they were, at least.
        let [p, q] = [3 * f, 3 * f + 1].map(|h| complex.along(h));
        let (first, second) =
            if (p.x * q.y) > -(p.y * q.x) { ([3 * f, 0], [3 * f + 1, 1]) } else { ([3 * f, 1], [3 * f + 1, 0]) };
        let mut is_changed = false;
        for [h, c] in [first, second] {
            let Some((e, _)) = extents[h].parts[c] else { continue };
            let variable = &flow.variables()[e as usize];
            let least = (variable.target.ceil() as i64).min(x[e as usize] + 1);
            if least > variable.least {
                flow.raise(e as usize, least);
                is_changed = true;
            }
        }
        turned += usize::from(is_changed);
    }
    turned
}
