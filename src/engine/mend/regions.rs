//! Which quads make up the discs: bad ones, the rings around them, and what these enclose.

use crate::engine::quad::improve::{DEAD, QuadNet};
use std::collections::{BTreeMap, BTreeSet};

/// How often what was added to a region may enclose something more.
const ROUNDS: usize = 4;
/// A hole of a region has at most half as many quads as the region, or so many.
const SMALL_HOLE: usize = 4;

/// Groups of slots, sorted, that share no vertex: the bad slots with so many rings of quads around them, without holes
/// that are smaller than they are, and nowhere pinched to a vertex.
pub(super) fn regions(net: &QuadNet, bad: &[u32], rings: usize) -> Vec<Vec<u32>> {
    let mut marked = vec![false; net.quads.len()];
    let mut members: Vec<u32> = Vec::new();
    let mut frontier: Vec<u32> = bad.iter().copied().filter(|&s| net.quads[s as usize] != DEAD).collect();
    for ring in 0..=rings {
        frontier.retain(|&s| !std::mem::replace(&mut marked[s as usize], true));
        members.extend_from_slice(&frontier);
        if ring < rings {
            frontier = frontier.iter().flat_map(|&s| meeting(net, s)).collect();
        }
    }
    for _ in 0..ROUNDS {
        let mut more = pinched(net, &marked, &members);
        for group in groups(net, &marked, &members) {
            more.extend(enclosed(net, &marked, &group));
        }
        more.retain(|&s| !std::mem::replace(&mut marked[s as usize], true));
        if more.is_empty() {
            break;
        }
        members.extend(more);
    }
    groups(net, &marked, &members)
}

/// The slots that share a vertex with a slot.
fn meeting(net: &QuadNet, slot: u32) -> impl Iterator<Item = u32> {
    net.quads[slot as usize].into_iter().flat_map(|v| net.at[v as usize].iter().copied())
}

/// The slots across the sides of a slot.
fn across(net: &QuadNet, slot: u32) -> impl Iterator<Item = Option<u32>> {
    let quad = net.quads[slot as usize];
    (0..4).map(move |k| net.left_of(quad[(k + 1) % 4], quad[k]))
}

fn groups(net: &QuadNet, marked: &[bool], members: &[u32]) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<u32> = members.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(seed) = left.pop_first() {
        let (mut group, mut next) = (vec![seed], 0);
        while let Some(&slot) = group.get(next) {
            next += 1;
            group.extend(meeting(net, slot).filter(|s| marked[*s as usize] && left.remove(s)));
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// The quads at vertices around which marked and other quads take turns.
fn pinched(net: &QuadNet, marked: &[bool], members: &[u32]) -> Vec<u32> {
    let mut vertices: Vec<u32> = members.iter().flat_map(|&s| net.quads[s as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let is_pinched = |v: &u32| {
        let Some(fan) = net.fan(*v) else { return true };
        let is_in: Vec<bool> = fan.quads.iter().map(|&s| marked[s as usize]).collect();
        let begins = |i: usize| is_in[i] && !(if i > 0 { is_in[i - 1] } else { fan.closed && is_in[is_in.len() - 1] });
        (0..is_in.len()).filter(|&i| begins(i)).count() > 1
    };
    let open = vertices.into_iter().filter(is_pinched).flat_map(|v| net.at[v as usize].iter().copied());
    open.filter(|&s| !marked[s as usize]).collect()
}

/// The quads in the holes of a group; where all that is outside is no more than a hole, its largest part is left out.
fn enclosed(net: &QuadNet, marked: &[bool], group: &[u32]) -> Vec<u32> {
    let most = SMALL_HOLE.max(group.len() / 2);
    let mut part_of: BTreeMap<u32, usize> = BTreeMap::new();
    let mut parts: Vec<Option<Vec<u32>>> = Vec::new();
    for start in group.iter().flat_map(|&s| across(net, s)).flatten().filter(|&s| !marked[s as usize]) {
        if part_of.contains_key(&start) {
            continue;
        }
        let part = parts.len();
        part_of.insert(start, part);
        let (mut found, mut next, mut is_large) = (vec![start], 0, false);
        while let Some(&slot) = found.get(next) {
            next += 1;
            for other in across(net, slot).flatten().filter(|&s| !marked[s as usize]) {
                match part_of.get(&other) {
                    Some(&known) => is_large |= known != part,
                    None => {
                        part_of.insert(other, part);
                        found.push(other);
                    }
                }
            }
            is_large |= found.len() > most;
            if is_large {
                break;
            }
        }
        parts.push((!is_large).then_some(found));
    }
    let is_all = parts.iter().all(Option::is_some);
    let largest = (0..parts.len()).max_by_key(|&i| (parts[i].as_ref().map_or(0, Vec::len), std::cmp::Reverse(i)));
    let kept = (0..parts.len()).filter(|&i| !(is_all && Some(i) == largest));
    kept.filter_map(|i| parts[i].as_deref()).flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::quad::{Anchor, QuadDraft, QuadMesh};
    use glam::DVec3;

    /// A torus of n by m quads; quad i m + j has its least corner at (i, j).
    fn torus(n: u32, m: u32) -> QuadNet {
        let at = |i: u32, j: u32| (i % n) * m + j % m;
        let cells = (0..n * m).map(|c| (c / m, c % m));
        let quads = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let positions = vec![DVec3::ZERO; (n * m) as usize];
        let anchors = vec![Anchor::Surface; positions.len()];
        QuadNet::new(&QuadDraft { mesh: QuadMesh { positions, quads }, anchors, feature_edges: Vec::new() })
    }

    #[test]
    fn rings_grow_and_what_touches_is_one() {
        let net = torus(20, 20);
        let one = regions(&net, &[8 * 20 + 8], 1);
        assert_eq!(one.iter().map(Vec::len).collect::<Vec<_>>(), [9]);
        assert_eq!(regions(&net, &[8 * 20 + 8], 2)[0].len(), 25);
        // Three quads apart the rings leave a quad between them; two apart they meet.
        assert_eq!(regions(&net, &[8 * 20 + 8, 8 * 20 + 12], 1).len(), 2);
        assert_eq!(regions(&net, &[8 * 20 + 8, 8 * 20 + 11], 1).iter().map(Vec::len).collect::<Vec<_>>(), [18]);
    }

    #[test]
    fn holes_and_pinches_are_filled() {
        let net = torus(20, 20);
        // A frame around one quad: the quad inside belongs to it.
        let frame: Vec<u32> = (0..9).filter(|&c| c != 4).map(|c| (5 + c / 3) * 20 + 5 + c % 3).collect();
        assert_eq!(regions(&net, &frame, 0), [[105, 106, 107, 125, 126, 127, 145, 146, 147]]);
        // Two quads at a vertex: the two others there join them.
        assert_eq!(regions(&net, &[105, 126], 0), [[105, 106, 125, 126]]);
        // Right round the torus the outside is no hole.
        let band: Vec<u32> = (0..20).map(|i| i * 20 + 3).collect();
        assert_eq!(regions(&net, &band, 0)[0].len(), 20);
        // All but four quads of a small one: these are not drawn in.
        let small = torus(4, 4);
        let most: Vec<u32> = (0..16).filter(|q| ![5, 6, 9, 10].contains(q)).collect();
        assert_eq!(regions(&small, &most, 0)[0].len(), 12);
    }
}
