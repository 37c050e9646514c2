//! Filling faces with quads.

use glam::DVec3;

use crate::engine::quad::Anchor;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::embedded_graph::GraphNode;
use crate::engine::quad::fill::patterns::Pattern;

/// How many of the patterns with the best node degrees are also judged by shape.
const SHORTLIST: usize = 24;
/// Weight of the loss of shape of a quad (0 to 2) against squared deviations of node degrees.
const SHAPE: f64 = 2.0;

/// Fills the face to the left of `first`, which has an even number of sides, four or more, with quads and returns how
/// many; leaves a face with four sides alone.
pub(super) fn fill_face(graph: &mut EmbeddedGraph, first: u32) -> usize {
    let word: Vec<u32> = graph.face(first).collect();
    if word.len() == 4 {
        return 1;
    }
    let mut candidates: Vec<(i64, Pattern)> = Pattern::candidates(word.len() as u32)
        .into_iter()
        .filter(|p| is_simple(graph, &word, p))
        .map(|p| (degree_cost(graph, &word, &p), p))
        .collect();
    candidates.sort_by_key(|c| c.0);
    candidates.truncate(SHORTLIST);
    if candidates.is_empty() {
        let half = word.len() as u32 / 2;
        let core = if half < 4 { Pattern::grid(1, half - 1, 0) } else { Pattern::grid(half / 2, half - half / 2, 0) };
        candidates.push((0, Pattern::padded(&core)));
    }
    let mut best: Option<(f64, Pattern, Vec<DVec3>)> = None;
    for (degrees, pattern) in candidates {
        let positions = lay_out(graph, &word, &pattern);
        let cost = degrees as f64 + SHAPE * shape_cost(&pattern, &positions);
        if best.as_ref().is_none_or(|b| cost < b.0) {
            best = Some((cost, pattern, positions));
        }
    }
    let Some((_, pattern, positions)) = best else { return 0 };
    insert(graph, &word, &pattern, &positions);
    pattern.quads.len()
}

/// Whether the pattern joins no two nodes that are joined already, or twice, or a node to itself.
fn is_simple(graph: &EmbeddedGraph, word: &[u32], pattern: &Pattern) -> bool {
    let n = pattern.sides;
    let id = |v: u32| if v < n { graph.origin(word[v as usize]) } else { graph.nodes.len() as u32 + v };
    let mut new_arcs = Vec::new();
    for q in &pattern.quads {
        for k in 0..4 {
            let (a, b) = (q[k], q[(k + 1) % 4]);
            let side = a < n && b == (a + 1) % n;
            if !side && (a < b) {
                new_arcs.push((id(a).min(id(b)), id(a).max(id(b))));
                if id(a) == id(b) {
                    return false;
                }
                if a < n && b < n && graph.around(word[a as usize]).any(|d| graph.target(d) == id(b)) {
                    return false;
                }
            }
        }
    }
    // Each new arc lies in two quads, once in each direction.
    new_arcs.sort_unstable();
    new_arcs.windows(2).all(|w| w[0] != w[1])
}

fn ideal_degree(anchor: Anchor, on_boundary: bool) -> Option<i64> {
    match (anchor, on_boundary) {
        (Anchor::Corner(_), _) => None,
        (_, true) => Some(3),
        (_, false) => Some(4),
    }
}

/// Sum of squared deviations of the degrees of all nodes of the filled polygon.
fn degree_cost(graph: &EmbeddedGraph, word: &[u32], pattern: &Pattern) -> i64 {
    let mut quads_at = vec![0i64; (pattern.sides + pattern.new_nodes) as usize];
    pattern.quads.iter().flatten().for_each(|&v| quads_at[v as usize] += 1);
    let old = word.iter().zip(&quads_at).map(|(&d, added)| {
        let on_boundary = graph.around(d).any(|e| graph.outside[e as usize]);
        let anchor = graph.nodes[graph.origin(d) as usize].anchor;
        let degree = graph.degree(d, 64) as i64 + added - 1;
        ideal_degree(anchor, on_boundary).map_or(0, |ideal| (degree - ideal).pow(2))
    });
    let new = quads_at[pattern.sides as usize..].iter().map(|degree| (degree - 4).pow(2));
    old.sum::<i64>() + new.sum::<i64>()
}

/// Positions of all nodes of the pattern: new nodes at the mean of their neighbours.
fn lay_out(graph: &EmbeddedGraph, word: &[u32], pattern: &Pattern) -> Vec<DVec3> {
    let n = pattern.sides as usize;
    let mut positions: Vec<DVec3> = word.iter().map(|&d| graph.nodes[graph.origin(d) as usize].position).collect();
    let centre = positions.iter().sum::<DVec3>() / n as f64;
    positions.resize(n + pattern.new_nodes as usize, centre);
    let mut neighbours = vec![Vec::new(); positions.len()];
    for q in &pattern.quads {
        for k in 0..4 {
            // Each new node sees each of its neighbours from one quad.
            neighbours[q[k] as usize].push(q[(k + 1) % 4] as usize);
        }
    }
    let rounds = if pattern.new_nodes == 0 { 0 } else { (2 * n).clamp(20, 120) };
    for _ in 0..rounds {
        for v in n..positions.len() {
            let sum: DVec3 = neighbours[v].iter().map(|&w| positions[w]).sum();
            positions[v] = sum / neighbours[v].len().max(1) as f64;
        }
    }
    positions
}

/// Sum over the quads of one minus the smallest scaled Jacobian, against the mean normal of the polygon.
fn shape_cost(pattern: &Pattern, positions: &[DVec3]) -> f64 {
    let n = pattern.sides as usize;
    let normal: DVec3 = (0..n).map(|i| positions[i].cross(positions[(i + 1) % n])).sum();
    let normal = normal.normalize_or_zero();
    let loss = |q: &[u32; 4]| {
        let p = q.map(|v| positions[v as usize]);
        let jacobian = |k: usize| {
            let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            a.normalize_or_zero().cross(b.normalize_or_zero()).dot(normal)
        };
        let worst = (0..4).map(jacobian).fold(1.0, f64::min);
        if worst < 0.1 { 4.0 - worst } else { 1.0 - worst }
    };
    pattern.quads.iter().map(loss).sum()
}

/// Draws the pattern into the face with the darts `word`.
pub(super) fn insert(graph: &mut EmbeddedGraph, word: &[u32], pattern: &Pattern, positions: &[DVec3]) {
    let n = pattern.sides;
    let mut sides: Vec<(u32, u32)> = Vec::with_capacity(4 * pattern.quads.len());
    // Per pattern node: (the neighbour where a quad begins, the neighbour where it ends), counter-clockwise.
    let mut turns: Vec<Vec<(u32, u32)>> = vec![Vec::new(); (n + pattern.new_nodes) as usize];
    for q in &pattern.quads {
        for k in 0..4 {
            sides.push((q[k], q[(k + 1) % 4]));
            turns[q[k] as usize].push((q[(k + 1) % 4], q[(k + 3) % 4]));
        }
    }
    sides.sort_unstable();
    let nodes: Vec<u32> = (0..n + pattern.new_nodes)
        .map(|v| {
            if v < n {
                return graph.origin(word[v as usize]);
            }
            graph.add_node(GraphNode { position: positions[v as usize], anchor: Anchor::Surface })
        })
        .collect();
    // All new arcs first, each dart alone around its node; then the order around the nodes.
    let mut darts: Vec<(u32, u32, u32)> = Vec::new();
    for &(a, b) in &sides {
        if a < b && !(b == a + 1 && b < n) && !(a == 0 && b == n - 1) {
            let d = graph.draw(nodes[a as usize], nodes[b as usize]);
            darts.extend([(a, b, d), (b, a, d + 1)]);
        }
    }
    darts.sort_unstable();
    let dart = |a: u32, b: u32| {
        let found = darts.binary_search_by_key(&(a, b), |&(a, b, _)| (a, b));
        found.map(|i| darts[i].2).ok()
    };
    for v in 0..n + pattern.new_nodes {
        let Some(&(start, _)) = turns[v as usize].first() else { continue };
        let (mut neighbour, mut last) =
            if v < n { ((v + 1) % n, word[v as usize]) } else { (start, dart(v, start).unwrap_or(0)) };
        for _ in 1..turns[v as usize].len() {
            let Some(&(_, after)) = turns[v as usize].iter().find(|t| t.0 == neighbour) else { break };
            let Some(d) = dart(v, after) else { break };
            graph.place_after(d, last);
            (neighbour, last) = (after, d);
        }
    }
}
