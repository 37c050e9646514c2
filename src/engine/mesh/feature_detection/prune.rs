//! Which sharp edges are only noise.

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::feature_detection::cycles::open_small_cycles;
use crate::engine::mesh::feature_detection::network::Network;
use crate::engine::mesh::feature_detection::relief::Relief;

/// Edges and mean dihedral angle, relative to the angle asked for, from which a chain is a feature however flat it
/// seems from afar: the rims of thin walls are such, and noise never keeps so sharp for so long.
const PERSISTENT: (usize, f64) = (10, 1.15);

/// Networks with junctions that are smaller than this share of the shortest length are tangles.
const TANGLE: f64 = 0.6;
/// So are networks up to this many times as large whose junctions are nearer to each other, in the mean, than this share
/// of it.
const LARGE_TANGLE: (f64, f64) = (2.0, 0.4);

/// Largest mesh in which tangles are looked for.
const MOST_FACES_TANGLED: usize = 300_000;

/// Drops, until none is left, what is sharp only from edge to edge: chains with a loose end and closed chains that are
/// short (below `min_length`, or twice that if they are not persistently sharp) or bend less than `angle` on average
/// when seen over half of `min_length`; anchored chains that bend less than half of `angle`; networks smaller than `min_length`, tangles, and
/// what closes cycles shorter than `min_length`. Edges that the user asked for stay. Nothing is dropped for a length of 0.
pub(super) fn prune(network: &mut Network, angle: f64, min_length: f64) {
    if min_length <= 0.0 {
        return;
    }
    let bends = bends(network, 0.5 * min_length);
    let diagonals = component_diagonals(network.mesh);
    // Without its tangles a huge scan gets a map that takes longer than it is worth.
    let may_tangle = network.mesh.n_faces() <= MOST_FACES_TANGLED;
    loop {
        let before = network.n_marked();
        for chain in network.chains() {
            if is_noise(network, &chain, &bends, angle, min_length) {
                unmark(network, &chain);
            }
        }
        for cluster in clusters(network) {
            let size = extent(network.mesh, &cluster);
            let small = size < min_length.min(0.5 * diagonals[cluster[0] / 3]);
            let tangled = may_tangle && is_tangled(network, &cluster, size, min_length);
            let noise = tangled || !is_persistent(network, &cluster, angle);
            if (small || tangled) && noise && !cluster.iter().any(|&h| network.kept[h]) {
                unmark(network, &cluster);
            }
        }
        if network.n_marked() == before {
            open_small_cycles(network, min_length);
        }
        if network.n_marked() == before {
            return;
        }
    }
}

fn unmark(network: &mut Network, halfedges: &[usize]) {
    for &h in halfedges {
        network.set(h, false);
    }
}

fn is_persistent(network: &Network, halfedges: &[usize], angle: f64) -> bool {
    let length: f64 = halfedges.iter().map(|&h| network.length(h)).sum();
    let sharpness: f64 = halfedges.iter().map(|&h| network.dihedral(h) * network.length(h)).sum();
    halfedges.len() >= PERSISTENT.0 && sharpness >= PERSISTENT.1 * angle * length
}

/// Whether quads cannot show the junctions of a network, because they are too close to each other, however sharp it is.
fn is_tangled(network: &Network, cluster: &[usize], size: f64, min_length: f64) -> bool {
    let ends = cluster.iter().flat_map(|&h| [network.mesh.origin(h), network.mesh.target(h)]);
    let mut junctions: Vec<u32> = ends.filter(|&v| network.degree(v) > 2).collect();
    junctions.sort_unstable();
    junctions.dedup();
    let length: f64 = cluster.iter().map(|&h| network.length(h)).sum();
    let is_dense = size < LARGE_TANGLE.0 * min_length && length < LARGE_TANGLE.1 * min_length * junctions.len() as f64;
    !junctions.is_empty() && size < TANGLE * min_length || is_dense
}

fn is_noise(network: &Network, chain: &[usize], bends: &[f64], angle: f64, min_length: f64) -> bool {
    if chain.iter().any(|&h| network.kept[h]) {
        return false;
    }
    let first = network.mesh.origin(chain[0]);
    let last = network.mesh.target(chain[chain.len() - 1]);
    let length: f64 = chain.iter().map(|&h| network.length(h)).sum();
    let bend = chain.iter().map(|&h| bends[h] * network.length(h)).sum::<f64>() / length;
    let persistent = is_persistent(network, chain, angle);
    if first == last || network.is_loose(first) || network.is_loose(last) {
        let least = if persistent { min_length } else { 2.0 * min_length };
        length < least || (bend < angle && !persistent)
    } else {
        bend < 0.5 * angle && !persistent
    }
}

/// Per halfedge of a marked edge, the angle at it seen over `reach`.
fn bends(network: &Network, reach: f64) -> Vec<f64> {
    let mesh = network.mesh;
    let mut relief = Relief::new(mesh);
    let mut bends = vec![0.0; mesh.n_halfedges()];
    for h in (0..bends.len()).filter(|&h| network.is_marked(h) && mesh.is_edge_owner(h)) {
        bends[h] = relief.angle(h, reach, &network.marked);
        if let Some(t) = mesh.twin(h) {
            bends[t] = bends[h];
        }
    }
    bends
}

/// Marked edges that hang together, each edge once.
fn clusters(network: &Network) -> Vec<Vec<usize>> {
    let mesh = network.mesh;
    let mut seen = vec![false; mesh.n_vertices()];
    let mut clusters = Vec::new();
    for v in 0..mesh.n_vertices() as u32 {
        if seen[v as usize] || network.degree(v) == 0 {
            continue;
        }
        let (mut cluster, mut stack) = (Vec::new(), vec![v]);
        seen[v as usize] = true;
        while let Some(v) = stack.pop() {
            for h in mesh.fan(v).filter(|&h| network.is_marked(h)) {
                if mesh.is_edge_owner(h) {
                    cluster.push(h);
                }
                let w = mesh.target(h);
                if !seen[w as usize] {
                    seen[w as usize] = true;
                    stack.push(w);
                }
            }
        }
        clusters.push(cluster);
    }
    clusters
}

/// Diagonal of the bounding box of the edges.
fn extent(mesh: &TriMesh, halfedges: &[usize]) -> f64 {
    let ends = halfedges.iter().flat_map(|&h| [mesh.origin(h), mesh.target(h)]).map(|v| mesh.position(v));
    let (low, high) = ends.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    low.distance(high)
}

/// Per face, the diagonal of the bounding box of its component.
fn component_diagonals(mesh: &TriMesh) -> Vec<f64> {
    let (component, n) = mesh.components();
    debug_assert!(!component.contains(&NONE));
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); n];
    for (f, &c) in component.iter().enumerate() {
        let (low, high) = &mut boxes[c as usize];
        for p in mesh.triangle(f) {
            *low = low.min(p);
            *high = high.max(p);
        }
    }
    component.iter().map(|&c| boxes[c as usize].0.distance(boxes[c as usize].1)).collect()
}
