//! Making the graph simple: a chain of quads is split lengthwise where two arcs join the same two nodes.

use glam::DVec3;

use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::faces::Faces;
use crate::engine::quad::fill::patterns::Pattern;
use crate::engine::quad::fill::polygons::insert;

/// How often chains are split before giving up.
const ROUNDS: usize = 8;

/// Splits chains of quads until no arc is a loop and no two arcs join the same nodes. All faces inside must be quads.
/// Returns how many arcs were split, or `None` if it did not come to an end.
pub(super) fn make_simple(graph: &mut EmbeddedGraph) -> Option<usize> {
    let mut total = 0;
    for _ in 0..ROUNDS {
        let parallel = parallel_arcs(graph);
        if parallel.is_empty() {
            return Some(total);
        }
        total += split_chains(graph, &parallel);
    }
    None
}

/// Loops, and all but one of the arcs between each two nodes.
fn parallel_arcs(graph: &EmbeddedGraph) -> Vec<u32> {
    let mut arcs: Vec<(u32, u32, u32)> = (0..graph.alive.len() as u32)
        .filter(|&arc| graph.alive[arc as usize])
        .map(|arc| {
            let (a, b) = (graph.origin(2 * arc), graph.target(2 * arc));
            (a.min(b), a.max(b), arc)
        })
        .collect();
    arcs.sort_unstable();
    let again = (0..arcs.len()).filter(|&i| {
        let (a, b, _) = arcs[i];
        a == b || (i > 0 && (arcs[i - 1].0, arcs[i - 1].1) == (a, b))
    });
    again.map(|i| arcs[i].2).collect()
}

fn split_chains(graph: &mut EmbeddedGraph, seeds: &[u32]) -> usize {
    let faces = Faces::new(graph);
    let mut split = vec![false; graph.alive.len()];
    for &seed in seeds {
        if split[seed as usize] {
            continue;
        }
        split[seed as usize] = true;
        for start in [2 * seed, 2 * seed + 1] {
            let mut d = start;
            while !faces.outside[faces.of[d as usize] as usize] {
                d = graph.next(graph.next(d)) ^ 1;
                if std::mem::replace(&mut split[d as usize / 2], true) {
                    break;
                }
            }
        }
    }
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
        let is_middle = |d: u32| graph.origin(d) >= first_middle;
        let Some(begin) = word.iter().position(|&d| !is_middle(d) && (word.len() == 8 || is_middle(graph.next(d))))
        else {
            continue;
        };
        let word: Vec<u32> = (0..word.len()).map(|i| word[(begin + i) % word.len()]).collect();
        let pattern = if word.len() == 8 { Pattern::grid(2, 2, 0) } else { Pattern::grid(2, 1, 0) };
        let centre = word.iter().map(|&d| graph.nodes[graph.origin(d) as usize].position).sum::<DVec3>();
        let mut positions = vec![DVec3::ZERO; word.len()];
        positions.push(centre / word.len() as f64);
        insert(graph, &word, &pattern, &positions);
    }
    arcs.len()
}
