//! Making the graph simple: where two arcs join the same two nodes, the arcs across a closed curve are split.
//!
//! The curve may follow a chain of quads, which keeps all degrees, or turn (`dual_curve.rs`): one chain can wind through
//! the whole surface, and would make several times as many quads where a few more irregular nodes will do.

use std::collections::{BTreeSet, VecDeque};

use glam::DVec3;

use crate::engine::quad::fill::dual_curve::CurveSearch;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::faces::Faces;
use crate::engine::quad::fill::patterns::Pattern;
use crate::engine::quad::fill::polygons::insert;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// How often arcs are split before giving up.
const ROUNDS: usize = 8;
/// Most arcs between two nodes for which the cheapest curve is looked for.
const MAX_COMPARED: usize = 6;

/// Splits arcs across closed curves until no arc is a loop and no two arcs join the same nodes. All faces inside must be
/// quads. Returns how many arcs were split, or `None` if it did not come to an end.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub(super) fn make_simple(ctx: &RunContext, graph: &mut EmbeddedGraph) -> Result<Option<usize>, Cancelled> {
    let mut total = 0;
    for _ in 0..ROUNDS {
        let parallel = parallel_arcs(graph);
        if parallel.is_empty() {
            return Ok(Some(total));
        }
        let faces = Faces::new(graph);
        let split = arcs_to_split(ctx, graph, &faces, &parallel)?;
        total += split_arcs(graph, &faces, &split);
    }
    Ok(None)
}

/// The loops of each node, and the arcs between each two nodes if there are several.
fn parallel_arcs(graph: &EmbeddedGraph) -> Vec<Vec<u32>> {
    let mut arcs: Vec<(u32, u32, u32)> = (0..graph.alive.len() as u32)
        .filter(|&arc| graph.alive[arc as usize])
        .map(|arc| {
            let (a, b) = (graph.origin(2 * arc), graph.target(2 * arc));
            (a.min(b), a.max(b), arc)
        })
        .collect();
    arcs.sort_unstable();
    let between = arcs.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    let several = between.filter(|arcs| arcs.len() > 1 || arcs[0].0 == arcs[0].1);
    several.map(|arcs| arcs.iter().map(|a| a.2).collect()).collect()
}

/// Per arc whether it is to be split: all loops and all but one of the arcs between two nodes, and what is crossed by the
/// curves across them. Every face has an even number of them.
fn arcs_to_split(
    ctx: &RunContext,
    graph: &EmbeddedGraph,
    faces: &Faces,
    parallel: &[Vec<u32>],
) -> Result<Vec<bool>, Cancelled> {
    let mut split = vec![false; graph.alive.len()];
    let mut is_parallel = split.clone();
    parallel.iter().flatten().for_each(|&arc| is_parallel[arc as usize] = true);
    let mut search = CurveSearch::new(graph, faces);
    for group in parallel {
        ctx.check()?;
        let is_loop = graph.origin(2 * group[0]) == graph.target(2 * group[0]);
        let wanted = if is_loop { group.len() } else { group.len() - 1 };
        // Each turn takes one at least, unless no curve is left.
        for _ in 0..wanted {
            let left: Vec<u32> = group.iter().copied().filter(|&arc| !split[arc as usize]).collect();
            if left.len() + wanted <= group.len() {
                break;
            }
            let mut best = None;
            for &arc in left.iter().take(MAX_COMPARED) {
                let run = run(graph, faces, arc, &is_parallel, &split);
                let limit = best.as_ref().map_or(u32::MAX, |b: &(u32, Vec<u32>)| b.0);
                best = search.along(&run, &split, limit).or(best);
            }
            let curve = best.map_or_else(|| chain(graph, faces, left[0]), |b| b.1);
            curve.iter().for_each(|&arc| split[arc as usize] ^= true);
        }
    }
    Ok(split)
}

/// Darts of the arcs one after another in the chain of quads through `arc` that have parallel arcs and are not taken.
fn run(graph: &EmbeddedGraph, faces: &Faces, arc: u32, is_parallel: &[bool], taken: &[bool]) -> Vec<u32> {
    let mut darts = VecDeque::from([2 * arc]);
    let mut is_in = BTreeSet::from([arc]);
    for is_forward in [true, false] {
        let mut d = if is_forward { 2 * arc } else { 2 * arc + 1 };
        while !faces.outside[faces.of[d as usize] as usize] {
            d = graph.next(graph.next(d)) ^ 1;
            let next = d / 2;
            if !is_parallel[next as usize] || taken[next as usize] || !is_in.insert(next) {
                break;
            }
            if is_forward { darts.push_back(d) } else { darts.push_front(d ^ 1) }
        }
    }
    darts.into()
}

/// The arcs across the chain of quads through an arc.
fn chain(graph: &EmbeddedGraph, faces: &Faces, arc: u32) -> Vec<u32> {
    let all = vec![true; graph.alive.len()];
    run(graph, faces, arc, &all, &vec![false; graph.alive.len()]).iter().map(|d| d / 2).collect()
}

/// Splits arcs and the quads beside them, of which each has none, two or four, and returns how many arcs there were.
fn split_arcs(graph: &mut EmbeddedGraph, faces: &Faces, split: &[bool]) -> usize {
    let arcs: Vec<usize> = (0..split.len()).filter(|&arc| split[arc]).collect();
    let first_middle = graph.nodes.len() as u32;
    for &arc in &arcs {
        graph.split(2 * arc as u32);
    }
    // The first dart of a face may now lie in its middle, but it is still a dart of that face.
    for first in faces.inside(|_| true) {
        let word: Vec<u32> = graph.face(first).collect();
        if word.len() == 4 {
            continue;
        }
        let is_middle = |i: usize| graph.origin(word[i % word.len()]) >= first_middle;
        // Two middles on opposite sides, or on sides that meet.
        let is_begin = |&i: &usize| !is_middle(i) && is_middle(i + 1) && (is_middle(i + 3) || is_middle(i + 4));
        let Some(begin) = (0..word.len()).find(is_begin) else { continue };
        let pattern = match word.len() {
            8 => Pattern::grid(2, 2, 0),
            _ if is_middle(begin + 3) => Pattern::star(&[1, 1, 1], 0),
            _ => Pattern::grid(2, 1, 0),
        };
        let word: Vec<u32> = (0..word.len()).map(|i| word[(begin + i) % word.len()]).collect();
        let at = |i: usize| graph.nodes[graph.origin(word[i % word.len()]) as usize].position;
        let mut positions = vec![DVec3::ZERO; word.len()];
        positions.push((0..word.len()).map(at).sum::<DVec3>() / word.len() as f64);
        insert(graph, &word, &pattern, &positions);
    }
    arcs.len()
}
