//! Maximum matching in a general graph: Edmonds' blossom algorithm `[edmonds_1965]`, grown from a given matching.

use crate::engine::mesh::NONE;
use crate::engine::run::{Cancelled, RunContext};

/// Enlarges `mate` (partner per node or `NONE`) to a matching of maximum size along augmenting paths. `neighbours` are
/// the nodes adjacent to each; the order decides among equally large matchings. Nodes once matched stay matched.
pub(super) fn enlarge(ctx: &RunContext, neighbours: &[Vec<u32>], mate: &mut [u32]) -> Result<(), Cancelled> {
    let n = neighbours.len();
    let mut search = Search {
        neighbours,
        parent: vec![NONE; n],
        base: (0..n as u32).collect(),
        outer: vec![false; n],
        touched: Vec::new(),
        queue: Vec::new(),
        mark: vec![0; n],
        stamp: 0,
    };
    for root in 0..n as u32 {
        if mate[root as usize] != NONE {
            continue;
        }
        ctx.check()?;
        if let Some(mut v) = search.find(mate, root) {
            while v != NONE {
                let p = search.parent[v as usize];
                let next = mate[p as usize];
                mate[v as usize] = p;
                mate[p as usize] = v;
                v = next;
            }
            search.forget();
        }
        // A search that fails leaves a Hungarian tree, which no later path can use: it stays marked.
        search.touched.clear();
    }
    Ok(())
}

/// One breadth-first search over alternating paths; blossoms are shrunk to their base.
struct Search<'a> {
    neighbours: &'a [Vec<u32>],
    /// The node before an inner node.
    parent: Vec<u32>,
    /// The base of the blossom that a node was shrunk into.
    base: Vec<u32>,
    /// Reached by an alternating path of even length.
    outer: Vec<bool>,
    touched: Vec<u32>,
    queue: Vec<u32>,
    mark: Vec<u32>,
    stamp: u32,
}

impl Search<'_> {
    fn forget(&mut self) {
        for v in std::mem::take(&mut self.touched) {
            self.parent[v as usize] = NONE;
            self.base[v as usize] = v;
            self.outer[v as usize] = false;
        }
    }

    /// The free end of an augmenting path from `root`, to be followed along `parent` and the mates.
    fn find(&mut self, mate: &[u32], root: u32) -> Option<u32> {
        self.queue.clear();
        self.queue.push(root);
        self.outer[root as usize] = true;
        self.touched.push(root);
        let mut head = 0;
        while head < self.queue.len() {
            let v = self.queue[head];
            head += 1;
            let neighbours = self.neighbours;
            for &w in &neighbours[v as usize] {
                if self.base[v as usize] == self.base[w as usize] || mate[v as usize] == w {
                    continue;
                }
                let inner_mate = mate[w as usize];
                if w == root || inner_mate != NONE && self.parent[inner_mate as usize] != NONE {
                    self.shrink(mate, v, w);
                } else if self.parent[w as usize] == NONE && !self.outer[w as usize] {
                    self.parent[w as usize] = v;
                    self.touched.push(w);
                    if inner_mate == NONE {
                        return Some(w);
                    }
                    self.outer[inner_mate as usize] = true;
                    self.touched.push(inner_mate);
                    self.queue.push(inner_mate);
                }
            }
        }
        None
    }

    /// Shrinks the odd cycle that the edge between the outer nodes `v` and `w` closes.
    fn shrink(&mut self, mate: &[u32], v: u32, w: u32) {
        let base = self.common_base(mate, v, w);
        let mut in_blossom = Vec::new();
        self.mark_path(mate, v, base, w, &mut in_blossom);
        self.mark_path(mate, w, base, v, &mut in_blossom);
        in_blossom.sort_unstable();
        in_blossom.dedup();
        for i in 0..self.touched.len() {
            let u = self.touched[i];
            if in_blossom.binary_search(&self.base[u as usize]).is_ok() {
                self.base[u as usize] = base;
                if !self.outer[u as usize] {
                    self.outer[u as usize] = true;
                    self.queue.push(u);
                }
            }
        }
    }

    fn common_base(&mut self, mate: &[u32], v: u32, w: u32) -> u32 {
        self.stamp += 1;
        let mut a = v;
        loop {
            a = self.base[a as usize];
            self.mark[a as usize] = self.stamp;
            if mate[a as usize] == NONE {
                break;
            }
            a = self.parent[mate[a as usize] as usize];
        }
        let mut b = w;
        loop {
            b = self.base[b as usize];
            if self.mark[b as usize] == self.stamp {
                return b;
            }
            b = self.parent[mate[b as usize] as usize];
        }
    }

    fn mark_path(&mut self, mate: &[u32], mut v: u32, base: u32, mut child: u32, in_blossom: &mut Vec<u32>) {
        while self.base[v as usize] != base {
            let m = mate[v as usize];
            in_blossom.extend([self.base[v as usize], self.base[m as usize]]);
            self.parent[v as usize] = child;
            child = m;
            v = self.parent[m as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::numerics::Random;

    /// Size of the largest matching among the nodes in `free`, by trying everything.
    fn largest(neighbours: &[Vec<u32>], free: u32) -> usize {
        if free == 0 {
            return 0;
        }
        let v = free.trailing_zeros();
        let rest = free & !(1 << v);
        let with = neighbours[v as usize].iter().filter(|&&w| rest >> w & 1 == 1);
        with.map(|&w| 1 + largest(neighbours, rest & !(1 << w))).max().unwrap_or(0).max(largest(neighbours, rest))
    }

    #[test]
    fn matchings_of_random_graphs_are_as_large_as_the_largest() {
        let mut sequence = Random::new(7);
        let mut random = move |n: usize| sequence.below(n);
        for case in 0..400 {
            let n = 4 + random(9);
            let mut neighbours = vec![Vec::new(); n];
            for _ in 0..n + random(n) {
                let (a, b) = (random(n), random(n));
                if a != b && !neighbours[a].contains(&(b as u32)) {
                    neighbours[a].push(b as u32);
                    neighbours[b].push(a as u32);
                }
            }
            let mut mate = vec![NONE; n];
            // Some cases start from a greedy matching.
            for v in 0..n * (case % 2) {
                let free = neighbours[v].iter().copied().find(|&w| mate[w as usize] == NONE);
                if let (NONE, Some(w)) = (mate[v], free) {
                    (mate[v], mate[w as usize]) = (w, v as u32);
                }
            }
            enlarge(&RunContext::silent(), &neighbours, &mut mate).unwrap();
            let matched = (0..n).filter(|&v| mate[v] != NONE).count();
            for v in (0..n).filter(|&v| mate[v] != NONE) {
                assert_eq!(mate[mate[v] as usize], v as u32);
                assert!(neighbours[v].contains(&mate[v]));
            }
            assert_eq!(matched, 2 * largest(&neighbours, (1 << n) - 1), "case {case}: {neighbours:?}");
        }
    }
}
