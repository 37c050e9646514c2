//! Undoing folds and removing what bounds nothing.

use crate::engine::numerics::DisjointSets;
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::embedded_graph::Tag;
use crate::engine::quad::fill::faces::Faces;

/// Faces longer than this are not looked at when a node with two arcs might be removed.
const LONG_FACE: usize = 64;

/// What becomes of remnants of folds when a graph is pruned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Folds {
    /// They are undone.
    Undo,
    /// They are left.
    Keep,
}

/// How much a node may not be moved: surface, curve, corner.
fn rank(anchor: Anchor) -> u8 {
    match anchor {
        Anchor::Surface => 0,
        Anchor::Curve => 1,
        Anchor::Corner(_) => 2,
    }
}

/// Joins the copies of grid points that collapsed arcs connect, and returns how many nodes vanished. First along
/// curves, then across the surface; never two corners into one, and never two points of curves across the surface,
/// because this would pinch a boundary or glue features together. Collapsed arcs between two nodes that must not be
/// joined count as ordinary arcs from here on: so a strip between two features that the map collapses becomes a strip
/// one quad wide.
pub(super) fn contract_collapsed(graph: &mut EmbeddedGraph) -> usize {
    let mut nodes = DisjointSets::new(graph.nodes.len());
    let mut weight = vec![1.0f64; graph.nodes.len()];
    let mut joined = 0;
    for plain in [false, true] {
        for arc in 0..graph.alive.len() as u32 {
            if !graph.alive[arc as usize]
                || !graph.collapsed[arc as usize]
                || (graph.tag[arc as usize] == Tag::Plain) != plain
            {
                continue;
            }
            let [a, b] = [2 * arc, 2 * arc + 1].map(|d| nodes.find(graph.origin(d)) as usize);
            let ranks = [a, b].map(|n| rank(graph.nodes[n].anchor));
            let allowed = if plain { ranks.contains(&0) } else { ranks != [2, 2] };
            if a == b {
                continue;
            }
            if !allowed {
                graph.collapsed[arc as usize] = false;
                continue;
            }
            graph.contract(arc);
            let (mut kept, other) = (graph.nodes[a], graph.nodes[b]);
            if ranks[0] == ranks[1] {
                let share = weight[b] / (weight[a] + weight[b]);
                kept.position = kept.position.lerp(other.position, share);
            } else if ranks[1] > ranks[0] {
                kept = other;
            }
            graph.nodes[a] = kept;
            weight[a] += weight[b];
            nodes.absorb(a as u32, b as u32);
            joined += 1;
        }
    }
    for d in 0..graph.n_darts() as usize {
        graph.node[d] = nodes.find(graph.node[d]);
    }
    joined
}

/// Deletes plain collapsed arcs that are left (loops), where their two sides are different faces of the surface.
pub(super) fn drop_collapsed(graph: &mut EmbeddedGraph) -> usize {
    let faces = Faces::new(graph);
    let mut sides = DisjointSets::new(faces.first.len());
    let mut dropped = 0;
    for arc in 0..graph.alive.len() as u32 {
        if !graph.alive[arc as usize] || !graph.collapsed[arc as usize] || graph.tag[arc as usize] != Tag::Plain {
            continue;
        }
        let [a, b] = [2 * arc as usize, 2 * arc as usize + 1].map(|d| sides.find(faces.of[d]));
        if a != b && !faces.outside[a as usize] && !faces.outside[b as usize] {
            sides.absorb(a, b);
            graph.remove(arc);
            dropped += 1;
        }
    }
    dropped
}

/// Removes, until there are none: faces of one or two arcs, nodes with one arc, and doublets (nodes with two arcs
/// between two different faces). Arcs on curves stay. Returns how many arcs were removed.
pub(super) fn prune(graph: &mut EmbeddedGraph, folds: Folds) -> usize {
    let mut work: Vec<u32> = (0..graph.n_darts()).rev().collect();
    let mut removed = 0;
    while let Some(d) = work.pop() {
        if !graph.is_alive(d) {
            continue;
        }
        for arc in superfluous(graph, d, folds).into_iter().flatten() {
            push_beside(graph, 2 * arc, &mut work);
            graph.remove(arc);
            removed += 1;
        }
        if folds == Folds::Undo && graph.is_alive(d) && is_crease(graph, d) {
            let s = graph.ccw(d);
            let (a, b) = (graph.target(d) as usize, graph.target(s) as usize);
            push_beside(graph, d, &mut work);
            push_beside(graph, s, &mut work);
            let (kept, dropped) = (graph.nodes[a], graph.nodes[b]);
            if rank(dropped.anchor) > rank(kept.anchor) {
                graph.nodes[a] = dropped;
            } else if rank(dropped.anchor) == rank(kept.anchor) {
                graph.nodes[a].position = kept.position.midpoint(dropped.position);
            }
            graph.zip(d);
            removed += 1;
        }
    }
    removed
}

/// Marks the darts around an arc for another look.
fn push_beside(graph: &EmbeddedGraph, d: u32, work: &mut Vec<u32>) {
    for e in [d, d ^ 1] {
        let beside = [graph.ccw(e), graph.cw(e)];
        work.extend(beside.into_iter().chain(beside.map(|b| b ^ 1)).chain([e]));
    }
}

/// Whether `d` and the next dart leave in the same direction of the map, with nothing between them: then both lead to
/// the same grid point, and the arcs are two copies of one.
fn is_crease(graph: &EmbeddedGraph, d: u32) -> bool {
    let s = graph.ccw(d);
    let plain = |d: u32| graph.tag_of(d) == Tag::Plain && !graph.collapsed[d as usize / 2];
    let ranks = [graph.target(d), graph.target(s)].map(|n| rank(graph.nodes[n as usize].anchor));
    graph.turn[d as usize] == 0
        && s / 2 != d / 2
        && !graph.outside[d as usize]
        && plain(d)
        && plain(s)
        && graph.target(d) != graph.target(s)
        && graph.target(d) != graph.origin(d)
        && graph.target(s) != graph.origin(d)
        && ranks.contains(&0)
}

/// Whether the quads on both sides of `d` lie on each other in the map: they can be folded together.
fn is_fold(graph: &EmbeddedGraph, d: u32) -> bool {
    let flat = |e: u32| graph.turn[e as usize] + graph.turn[graph.cw(e) as usize] == 0;
    let quad = |e: u32| graph.face(e).take(5).count() == 4;
    let inside = !graph.outside[d as usize] && !graph.outside[d as usize ^ 1];
    flat(d) && flat(d ^ 1) && inside && quad(d) && quad(d ^ 1) && graph.face(d).all(|e| e != d ^ 1)
}

/// The arcs at `d` that bound nothing, if there are such.
fn superfluous(graph: &EmbeddedGraph, d: u32, folds: Folds) -> [Option<u32>; 2] {
    let plain = |d: u32| graph.tag_of(d) == Tag::Plain;
    let next = graph.next(d);
    let one_sided = next == d || graph.ccw(d) == d;
    if one_sided && plain(d) {
        return [Some(d / 2), None];
    }
    let inside = !graph.outside[d as usize] && !graph.outside[next as usize];
    if graph.next(next) == d && next != d && next / 2 != d / 2 && inside {
        // Of two parallel arcs the one on a curve stays.
        let dropped = [d, next].into_iter().find(|&e| plain(e));
        return [dropped.map(|e| e / 2), None];
    }
    let second = graph.ccw(d);
    if graph.ccw(second) == d && second != d && is_doublet(graph, d, second, folds) {
        return [Some(d / 2), Some(second / 2)];
    }
    if folds == Folds::Undo && plain(d) && is_fold(graph, d) {
        return [Some(d / 2), None];
    }
    [None, None]
}

/// Whether the node with only the darts `d` and `second` may go with both arcs: its two faces become one.
fn is_doublet(graph: &EmbeddedGraph, d: u32, second: u32, folds: Folds) -> bool {
    let anchored = graph.nodes[graph.origin(d) as usize].anchor != Anchor::Surface;
    if anchored || graph.tag_of(d) != Tag::Plain || graph.tag_of(second) != Tag::Plain {
        return false;
    }
    if graph.target(d) == graph.target(second) {
        return false;
    }
    // The ends lose an arc each and must not become doublets in their turn, or a small closed mesh would vanish.
    let folded = folds == Folds::Undo && graph.turn[d as usize] + graph.turn[second as usize] == 0;
    if !folded && [d ^ 1, second ^ 1].into_iter().any(|e| graph.degree(e, 4) < 4) {
        return false;
    }
    let left: Vec<u32> = graph.face(d).take(LONG_FACE).collect();
    let right = graph.face(second).take(LONG_FACE).count();
    let short = left.len() < LONG_FACE && right < LONG_FACE;
    let outside = graph.outside[d as usize] || graph.outside[second as usize];
    short && !outside && !left.contains(&second) && left.len() + right >= 6
}
