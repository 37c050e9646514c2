//! Disjoint sets of numbers `[tarjan_1975]`.

/// Sets of 0..n, each named by one of its members: at first by itself.
///
/// ```
/// use quadrille::engine::numerics::DisjointSets;
///
/// let mut sets = DisjointSets::new(5);
/// assert!(sets.join(4, 2) && sets.join(2, 1) && !sets.join(1, 4));
/// assert_eq!(sets.names(), [0, 1, 1, 3, 1]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Each number of 0..n in a set of its own.
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parent.is_empty()
    }

    /// Adds the next number, in a set of its own.
    pub fn push(&mut self) -> u32 {
        let next = self.parent.len() as u32;
        self.parent.push(next);
        next
    }

    /// The member that names the set of `v`. The path is halved.
    pub fn find(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let above = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = above;
            v = above;
        }
        v
    }

    /// Joins the sets of two numbers; whether they were two. The lesser name stays, so that names do not depend on the order
    /// of joins.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// Joins the set of `other` to that of `kept`, whose name stays.
    pub fn absorb(&mut self, kept: u32, other: u32) {
        let (kept, other) = (self.find(kept), self.find(other));
        self.parent[other as usize] = kept;
    }

    /// Per number, the name of its set.
    pub fn names(mut self) -> Vec<u32> {
        (0..self.parent.len() as u32).map(|v| self.find(v)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_the_least_members_in_whatever_order_sets_are_joined() {
        let pairs = [(7, 3), (1, 9), (3, 9), (4, 5), (5, 4)];
        for turn in 0..pairs.len() {
            let mut sets = DisjointSets::new(10);
            let joined = pairs.iter().cycle().skip(turn).take(pairs.len()).filter(|p| sets.join(p.0, p.1)).count();
            assert_eq!(joined, 4, "five joins, of which one is of a set with itself");
            assert_eq!(sets.names(), [0, 1, 2, 1, 4, 4, 6, 1, 8, 1]);
        }
    }

    #[test]
    fn the_set_that_is_kept_keeps_its_name() {
        let mut sets = DisjointSets::default();
        let [a, b, c] = [(); 3].map(|()| sets.push());
        sets.absorb(c, a);
        sets.absorb(b, a);
        assert_eq!((sets.find(a), sets.find(c), sets.len()), (b, b, 3));
    }
}
