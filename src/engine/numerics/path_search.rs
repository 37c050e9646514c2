//! Shortest paths in graphs that are known by their neighbours only `[dijkstra_1959]`.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No node, or no step.
const NONE: u32 = u32::MAX;

/// One search after another over the nodes 0..n; starting again costs what the last one reached. Of nodes in the same
/// distance the lesser comes first.
///
/// ```
/// use quadrille::engine::numerics::PathSearch;
///
/// // From, to, length; the step by which a node is reached is the number of its edge.
/// let edges = [(0, 1, 1.0), (1, 2, 1.0), (0, 2, 3.0)];
/// let mut search = PathSearch::new(3);
/// search.start(0, 0.0);
/// while let Some((distance, node)) = search.nearest() {
///     for (step, &(_, to, length)) in (0..).zip(&edges).filter(|(_, edge)| edge.0 == node) {
///         search.reach(to, distance + length, step, node);
///     }
/// }
/// assert_eq!((search.distance(2), search.nodes(2), search.steps(2)), (2.0, vec![0, 1, 2], vec![0, 1]));
/// ```
#[derive(Clone, Debug)]
pub struct PathSearch {
    distance: Vec<f64>,
    /// By which step a node was reached, and from where.
    via: Vec<u32>,
    from: Vec<u32>,
    done: Vec<bool>,
    touched: Vec<u32>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl PathSearch {
    /// A search over n nodes, none of them reached.
    pub fn new(n: usize) -> Self {
        Self {
            distance: vec![f64::INFINITY; n],
            via: vec![NONE; n],
            from: vec![NONE; n],
            done: vec![false; n],
            touched: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        for node in self.touched.drain(..) {
            let i = node as usize;
            (self.distance[i], self.via[i], self.from[i], self.done[i]) = (f64::INFINITY, NONE, NONE, false);
        }
        self.heap.clear();
    }

    /// Lets a search begin at a node, in this distance, not below 0.
    pub fn start(&mut self, node: u32, distance: f64) -> bool {
        self.reach(node, distance, NONE, NONE)
    }

    /// Tells that a node can be reached from another one by a step, any number of the caller's, in this distance, which is
    /// not below that of the other one. Whether it is nearer that way than it was known to be.
    pub fn reach(&mut self, node: u32, distance: f64, via: u32, from: u32) -> bool {
        let i = node as usize;
        let is_nearer = distance < self.distance[i];
        if is_nearer {
            if self.distance[i] == f64::INFINITY {
                self.touched.push(node);
            }
            (self.distance[i], self.via[i], self.from[i]) = (distance, via, from);
            // Distances are not negative: their bits are ordered like themselves.
            self.heap.push(Reverse((distance.to_bits(), node)));
        }
        is_nearer
    }

    /// The nearest node that did not come yet, with its distance: both are final.
    pub fn nearest(&mut self) -> Option<(f64, u32)> {
        while let Some(Reverse((_, node))) = self.heap.pop() {
            if !std::mem::replace(&mut self.done[node as usize], true) {
                return Some((self.distance[node as usize], node));
            }
        }
        None
    }

    /// The distance of a node as far as it is known; infinite if it was not reached.
    pub fn distance(&self, node: u32) -> f64 {
        self.distance[node as usize]
    }

    /// The step by which a node was reached; nothing where a search begins, or was not.
    pub fn via(&self, node: u32) -> Option<u32> {
        (self.from[node as usize] != NONE).then(|| self.via[node as usize])
    }

    /// The nodes on the way to a node, from where it began.
    pub fn nodes(&self, node: u32) -> Vec<u32> {
        let mut nodes = vec![node];
        let mut at = node;
        while self.from[at as usize] != NONE {
            at = self.from[at as usize];
            nodes.push(at);
        }
        nodes.reverse();
        nodes
    }

    /// The steps on the way to a node, in order.
    pub fn steps(&self, node: u32) -> Vec<u32> {
        self.nodes(node).into_iter().skip(1).map(|node| self.via[node as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::numerics::Random;

    /// Shortest distances by trying all edges again until nothing changes.
    fn exhaustive(n: usize, edges: &[(u32, u32, f64)], start: u32) -> Vec<f64> {
        let mut distance = vec![f64::INFINITY; n];
        distance[start as usize] = 0.0;
        for _ in 0..n {
            for &(a, b, length) in edges {
                distance[b as usize] = distance[b as usize].min(distance[a as usize] + length);
            }
        }
        distance
    }

    #[test]
    fn distances_and_ways_are_the_shortest_in_search_after_search() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let n = 2 + random.below(30);
            let edge = |random: &mut Random| (random.below(n) as u32, random.below(n) as u32, random.unit());
            let edges: Vec<(u32, u32, f64)> = (0..3 * n).map(|_| edge(&mut random)).collect();
            let mut search = PathSearch::new(n);
            for start in 0..n.min(4) as u32 {
                search.clear();
                search.start(start, 0.0);
                let mut last = 0.0;
                while let Some((distance, node)) = search.nearest() {
                    assert!(distance >= last);
                    last = distance;
                    for (i, &(_, b, length)) in edges.iter().enumerate().filter(|(_, edge)| edge.0 == node) {
                        search.reach(b, distance + length, i as u32, node);
                    }
                }
                let wanted = exhaustive(n, &edges, start);
                for v in 0..n as u32 {
                    assert!(
                        (search.distance(v) - wanted[v as usize]).abs() < 1e-12
                            || search.distance(v) == wanted[v as usize]
                    );
                    let steps = search.steps(v);
                    let length: f64 = steps.iter().map(|&i| edges[i as usize].2).sum();
                    let is_reached = search.distance(v) < f64::INFINITY;
                    assert!(!is_reached || (length - search.distance(v)).abs() < 1e-9);
                    assert_eq!(search.nodes(v).len(), steps.len() + 1);
                    assert_eq!(search.via(v), steps.last().copied());
                    assert!(!is_reached || search.nodes(v)[0] == start);
                }
            }
        }
    }
}
