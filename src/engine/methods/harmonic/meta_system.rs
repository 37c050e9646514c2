//! The meta-system `[tong_2006]` section 3.3: integers for all meta-edges with which every meta-face closes. Each meta-face has
//! one equation for Du and one for Dv, and every meta-edge is in two of them at most, with the coefficient +1 or −1: so the
//! integers nearest to given lengths are a minimum-deviation flow. Redundant equations do no harm to it.

use crate::engine::mesh::NONE;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::{MetaEdge, SingularityGraph};
use crate::engine::methods::harmonic::tag::name;
use crate::engine::numerics::DisjointSets;
use crate::engine::parameterize::{Flow, Variable};
use crate::engine::run::{Cancelled, RunContext};

/// Lengths below this share of a grid unit weigh no more than it.
const SHORT: f64 = 0.1;
/// Weight of integers that are given: no others give way before all else has.
const FIRM: f64 = 1e6;
/// Times that meta-edges are pulled open where held meta-vertices have fallen together.
const MOST_PULLS: usize = 30;
/// Factors of all lengths tried so that the count is met, and how near is near enough.
const MOST_FACTORS: usize = 6;
const COUNT_TOLERANCE: f64 = 0.02;

/// Integers near the real lengths of a graph, scaled so that there are about `wanted` quads.
///
/// # Errors
/// [`HarmonicError::NoIntegers`] if the graph has none.
pub(super) fn find_integers(
    ctx: &RunContext,
    graph: &mut SingularityGraph,
    is_held: &[bool],
    wanted: Option<f64>,
) -> Result<(), HarmonicError> {
    near_count(ctx, graph, wanted, |ctx, graph, factor| Ok(near(ctx, graph, is_held, factor)?))
}

/// Integers for a given graph: the given ones where there are any, others positive and near the lengths of their edges.
///
/// # Errors
/// [`HarmonicError::OneSided`] and [`HarmonicError::Open`] name the meta-face and the equation that cannot be met.
pub(super) fn complete_integers(
    ctx: &RunContext,
    graph: &mut SingularityGraph,
    given: &[Option<i64>],
    wanted: Option<f64>,
) -> Result<(), HarmonicError> {
    check_signs(graph)?;
    near_count(ctx, graph, wanted, |ctx, graph, factor| {
        let mut variables = variables(graph, factor, |_| 1);
        for (variable, given) in variables.iter_mut().zip(given) {
            let Some(extent) = *given else { continue };
            (variable.target, variable.least) = (extent as f64, extent);
            variable.weight = FIRM;
        }
        let start: Vec<i64> = variables.iter().map(|v| v.target.round() as i64).collect();
        let found = Flow::new(2 * graph.faces.len(), variables).solve(ctx, &start)?;
        let fixed = |extents: Vec<i64>| extents.iter().zip(given).map(|(&x, given)| given.unwrap_or(x)).collect();
        Ok(found.map(fixed))
    })
}

/// Gives the graph the integers that `solve` finds for lengths scaled by a factor, of the factors tried those that come
/// nearest to the count wanted.
fn near_count(
    ctx: &RunContext,
    graph: &mut SingularityGraph,
    wanted: Option<f64>,
    solve: impl Fn(&RunContext, &SingularityGraph, f64) -> Result<Option<Vec<i64>>, HarmonicError>,
) -> Result<(), HarmonicError> {
    let mut factor = 1.0;
    let mut best: Option<(f64, Vec<i64>)> = None;
    for attempt in 0..MOST_FACTORS {
        let Some(extents) = solve(&ctx.part(attempt, MOST_FACTORS), graph, factor)? else { break };
        set(graph, &extents);
        let quads = graph.quads()?.max(1.0);
        let off = wanted.map_or(0.0, |wanted| (quads / wanted).ln().abs());
        if best.as_ref().is_none_or(|b| off < b.0) {
            best = Some((off, extents));
        }
        if off < COUNT_TOLERANCE {
            break;
        }
        factor *= (wanted.unwrap_or(quads) / quads).sqrt().clamp(0.5, 2.0);
    }
    let (_, extents) = best.ok_or(HarmonicError::NoIntegers)?;
    set(graph, &extents);
    Ok(())
}

/// Whether every equation has both signs: with positive integers none can hold otherwise.
fn check_signs(graph: &SingularityGraph) -> Result<(), HarmonicError> {
    for (face, sides) in (0..).zip(&graph.faces) {
        let has = [0, 1, 2, 3].map(|tag| sides.iter().any(|&side| graph.tag(side) == tag));
        for (coordinate, own) in [('u', 0), ('v', 1)] {
            if has[own] != has[own + 2] {
                let missing = name(if has[own] { own + 2 } else { own } as u8);
                return Err(HarmonicError::OneSided { face, coordinate, missing });
            }
        }
    }
    Ok(())
}

/// Variables for all meta-edges with targets of `factor` times their real lengths.
fn variables(graph: &SingularityGraph, factor: f64, least: impl Fn(&MetaEdge) -> i64) -> Vec<Variable> {
    let variable = |edge: &MetaEdge| {
        let target = factor * edge.real;
        let end = |half: usize| {
            let (face, tag) = (edge.faces[half], edge.tags[half]);
            (face != NONE).then(|| (2 * face + u32::from(tag % 2), if tag < 2 { 1 } else { -1 }))
        };
        Variable { ends: [end(0), end(1)], target, weight: 1.0 / (target + SHORT), least: least(edge) }
    };
    graph.edges.iter().map(variable).collect()
}

fn set(graph: &mut SingularityGraph, extents: &[i64]) {
    for (edge, &extent) in graph.edges.iter_mut().zip(extents) {
        edge.extent = extent;
    }
}

/// Integers near `factor` times the real lengths. Those of meta-edges with an end that nothing holds may vanish: two lines
/// that run side by side are then one. Held meta-vertices never fall together.
fn near(
    ctx: &RunContext,
    graph: &SingularityGraph,
    is_held: &[bool],
    factor: f64,
) -> Result<Option<Vec<i64>>, Cancelled> {
    let held = |n: u32| is_held[graph.vertices[n as usize] as usize];
    let mut variables = variables(graph, factor, |edge| i64::from(edge.ends.map(held) == [true, true]));
    let mut x: Vec<i64> = variables.iter().map(|v| v.target.round() as i64).collect();
    for pull in 0..MOST_PULLS {
        let flow = Flow::new(2 * graph.faces.len(), variables.clone());
        let Some(solved) = flow.solve(&ctx.part(pull, MOST_PULLS), &x)? else { return Ok(None) };
        x = solved;
        let fallen = fallen_together(graph, &x, held);
        if fallen.is_empty() {
            return Ok(Some(x));
        }
        for edge in fallen {
            variables[edge].least = 1;
        }
    }
    Ok(None)
}

/// Of the meta-edges without extent by which held meta-vertices hang together, the longest of each group.
fn fallen_together(graph: &SingularityGraph, extents: &[i64], held: impl Fn(u32) -> bool) -> Vec<usize> {
    let n = graph.vertices.len();
    let mut without: Vec<usize> = (0..extents.len()).filter(|&e| extents[e] == 0).collect();
    // Shortest first: the edge that joins two groups with a held vertex each is the one to be pulled open.
    without.sort_by(|&a, &b| graph.edges[a].real.total_cmp(&graph.edges[b].real).then(a.cmp(&b)));
    let mut sets = DisjointSets::new(n);
    let mut has_held: Vec<bool> = (0..n as u32).map(held).collect();
    let mut open = Vec::new();
    for e in without {
        let [a, b] = graph.edges[e].ends.map(|v| sets.find(v) as usize);
        if a == b {
            continue;
        }
        if has_held[a] && has_held[b] {
            open.push(e);
            continue;
        }
        let both = has_held[a] || has_held[b];
        sets.join(a as u32, b as u32);
        let root = sets.find(a as u32) as usize;
        has_held[root] = both;
    }
    open
}
