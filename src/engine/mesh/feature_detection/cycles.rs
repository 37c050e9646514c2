//! Cycles of sharp edges that are too small to run along quads.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::collections::BinaryHeap;

use crate::engine::mesh::feature_detection::network::Network;
use crate::engine::mesh::prev;

/// Drops chains, the flattest first, until no cycle through junctions is shorter than `least` (model units): two quad
/// edges cannot go around anything. Edges that the user asked for stay. O(E log E) for few cycles.
pub(super) fn open_small_cycles(network: &mut Network, least: f64) {
    let mut chains: Vec<(f64, f64, Vec<usize>)> = Vec::new();
    for chain in network.chains() {
        let length: f64 = chain.iter().map(|&h| network.length(h)).sum();
        let bend: f64 = chain.iter().map(|&h| network.dihedral(h) * network.length(h)).sum();
        if length < least && !chain.iter().any(|&h| network.kept[h]) {
            chains.push((bend / length, length, chain));
        }
    }
    chains.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    for (_, length, chain) in chains {
        chain.iter().for_each(|&h| network.set(h, false));
        let (first, last) = (network.mesh.origin(chain[0]), network.mesh.target(chain[chain.len() - 1]));
        let is_cycle = first != last && is_within(network, first, last, least - length);
        if !is_cycle {
            chain.iter().for_each(|&h| network.set(h, true));
        }
    }
}

/// Whether marked edges lead from one vertex to another within a length.
fn is_within(network: &Network, from: u32, to: u32, length: f64) -> bool {
    let mesh = network.mesh;
    let mut reached: BTreeMap<u32, f64> = BTreeMap::from([(from, 0.0)]);
    // Lengths are not negative, so their bits have their order.
    let mut heap = BinaryHeap::from([(Reverse(0u64), from)]);
    while let Some((Reverse(bits), v)) = heap.pop() {
        let so_far = f64::from_bits(bits);
        if v == to {
            return true;
        }
        if reached.get(&v).is_some_and(|&best| best < so_far) {
            continue;
        }
        let ends = mesh.fan(v).flat_map(|h| [(h, mesh.target(h)), (prev(h), mesh.origin(prev(h)))]);
        for (h, w) in ends.filter(|&(h, _)| network.is_marked(h)) {
            let there = so_far + network.length(h);
            if there < length && reached.get(&w).is_none_or(|&best| there < best) {
                reached.insert(w, there);
                heap.push((Reverse(there.to_bits()), w));
            }
        }
    }
    false
}
