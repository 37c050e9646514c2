//! The changes that are tried: rotation of an edge, shrinking of a diagonal, removal of a doublet.

use crate::engine::mesh::NONE;
use crate::engine::quad::improve::net::Change;
use crate::engine::quad::improve::net::DEAD;
use crate::engine::quad::improve::net::QuadNet;

/// Which way an edge is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    /// Against the clock, seen from outside.
    Counterclockwise,
    /// With the clock, seen from outside.
    Clockwise,
}

/// Turns the edge `a`–`b` in the hexagon of its two quads.
pub(crate) fn rotation(net: &QuadNet, a: u32, b: u32, sense: Sense) -> Option<Change> {
    if net.is_feature(a, b) {
        return None;
    }
    let (left, right) = (net.left_of(a, b)?, net.left_of(b, a)?);
    if left == right {
        return None;
    }
    let of = |slot: u32, v: u32, k: usize| net.quads[slot as usize][(net.corner(slot, v) + k) % 4];
    // The hexagon counter-clockwise: a, two of the right quad, b, two of the left quad.
    let ring = [a, of(right, a, 1), of(right, a, 2), b, of(left, b, 1), of(left, b, 2)];
    let s = match sense {
        Sense::Counterclockwise => 1,
        Sense::Clockwise => 5,
    };
    let at = |k: usize| ring[(s + k) % 6];
    Some(vec![(right, [at(0), at(1), at(2), at(3)]), (left, [at(3), at(4), at(5), at(0)])])
}

/// Shrinks the diagonal of the quad in `slot` from its corner `k`: the vertex that is free moves into the other and is
/// removed.
pub(crate) fn collapse(net: &QuadNet, slot: u32, k: usize) -> Option<Change> {
    let quad = net.quads[slot as usize];
    let (kept, removed) = if net.is_free(quad[(k + 2) % 4]) {
        (quad[k], quad[(k + 2) % 4])
    } else if net.is_free(quad[k]) {
        (quad[(k + 2) % 4], quad[k])
    } else {
        return None;
    };
    let renamed = |q: u32| net.quads[q as usize].map(|v| if v == removed { kept } else { v });
    let contents = |q: u32| if q == slot { DEAD } else { renamed(q) };
    Some(net.at[removed as usize].iter().map(|&q| (q, contents(q))).collect())
}

/// Removes `v`, which has two quads only, by making them one.
pub(crate) fn doublet(net: &QuadNet, v: u32) -> Option<Change> {
    let [p, q] = net.at[v as usize][..] else { return None };
    let fan = net.fan(v)?;
    if !net.is_free(v) || !fan.closed {
        return None;
    }
    let across = |slot: u32| net.quads[slot as usize][(net.corner(slot, v) + 2) % 4];
    let (first, second) = (fan.quads[0], fan.quads[1]);
    let merged = [fan.spokes[0], across(first), fan.spokes[1], across(second)];
    Some(vec![(p, merged), (q, DEAD)])
}

/// Everything that can be tried close to the given vertices, in a fixed order and each once.
pub(crate) fn candidates(net: &QuadNet, vertices: &[u32]) -> Vec<Change> {
    let mut changes: Vec<Change> = vertices.iter().filter_map(|&v| doublet(net, v)).collect();
    let mut slots: Vec<u32> = vertices.iter().flat_map(|&v| net.at[v as usize].iter().copied()).collect();
    slots.sort_unstable();
    slots.dedup();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for slot in slots {
        let quad = net.quads[slot as usize];
        changes.extend([collapse(net, slot, 0), collapse(net, slot, 1)].into_iter().flatten());
        edges.extend((0..4).map(|k| [quad[k].min(quad[(k + 1) % 4]), quad[k].max(quad[(k + 1) % 4])]));
    }
    edges.sort_unstable();
    edges.dedup();
    for [a, b] in edges {
        let turned = [Sense::Counterclockwise, Sense::Clockwise].map(|sense| rotation(net, a, b, sense));
        changes.extend(turned.into_iter().flatten());
    }
    changes
}

/// How many quads each vertex gains by a change that has not been applied, sorted by vertex, without zeros.
pub(crate) fn valence_shifts(net: &QuadNet, change: &Change) -> Vec<(u32, i32)> {
    let signed = change.iter().flat_map(|(slot, contents)| {
        let old = net.quads[*slot as usize].into_iter().map(|v| (v, -1));
        old.chain(contents.iter().map(|&v| (v, 1)))
    });
    let mut all: Vec<(u32, i32)> = signed.filter(|s| s.0 != NONE).collect();
    all.sort_unstable();
    let mut shifts: Vec<(u32, i32)> = Vec::new();
    for (v, shift) in all {
        match shifts.last_mut() {
            Some(last) if last.0 == v => last.1 += shift,
            _ => shifts.push((v, shift)),
        }
    }
    shifts.retain(|s| s.1 != 0);
    shifts
}
