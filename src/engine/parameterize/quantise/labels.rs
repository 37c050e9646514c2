//! What the search for negative cycles keeps between its passes: states that wait, and who gave each its label.

/// A set of states that is gone through in ascending order while it grows.
#[derive(Debug)]
pub(super) struct States {
    words: Vec<u64>,
}

impl States {
    /// The empty set of states below `n`.
    pub(super) fn new(n: usize) -> Self {
        Self { words: vec![0; n.div_ceil(64)] }
    }

    pub(super) fn insert(&mut self, state: u32) {
        self.words[state as usize / 64] |= 1 << (state % 64);
    }

    /// Removes the first state that is not below `from`. O(n / 64).
    pub(super) fn take_from(&mut self, from: u32) -> Option<u32> {
        let first = from as usize / 64;
        let mut mask = u64::MAX << (from % 64);
        for (w, word) in self.words.iter_mut().enumerate().skip(first) {
            let left = *word & mask;
            if left != 0 {
                let bit = left.trailing_zeros();
                *word &= !(1 << bit);
                return Some(64 * w as u32 + bit);
            }
            mask = u64::MAX;
        }
        None
    }
}

/// A graph in which every state has at most one parent, with the arc that comes from there.
#[derive(Debug)]
pub(super) struct Parents {
    of: Vec<Option<(u32, u32)>>,
    /// States with a parent.
    known: Vec<u32>,
    /// The walk on which each state was met last.
    met: Vec<u64>,
    n_walks: u64,
}

impl Parents {
    /// No parents for `n` states.
    pub(super) fn new(n: usize) -> Self {
        Self { of: vec![None; n], known: Vec::new(), met: vec![0; n], n_walks: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.known.drain(..).for_each(|state| self.of[state as usize] = None);
    }

    pub(super) fn set(&mut self, state: u32, parent: (u32, u32)) {
        if self.of[state as usize].replace(parent).is_none() {
            self.known.push(state);
        }
    }

    /// The cycles as arcs, each against its direction; the order of `set` does not matter. O(p log p) for p states with
    /// a parent.
    pub(super) fn cycles(&mut self) -> Vec<Vec<u32>> {
        self.known.sort_unstable();
        let before = self.n_walks;
        let mut cycles = Vec::new();
        for &start in &self.known {
            self.n_walks += 1;
            let mut state = start;
            while self.met[state as usize] <= before {
                self.met[state as usize] = self.n_walks;
                match self.of[state as usize] {
                    Some((above, _)) => state = above,
                    None => break,
                }
            }
            if self.met[state as usize] != self.n_walks || self.of[state as usize].is_none() {
                continue;
            }
            let (mut cycle, mut at) = (Vec::new(), state);
            while let Some((above, a)) = self.of[at as usize] {
                cycle.push(a);
                at = above;
                if at == state {
                    break;
                }
            }
            cycles.push(cycle);
        }
        cycles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_taken_in_order_and_those_behind_wait() {
        let mut states = States::new(200);
        [3, 64, 130].into_iter().for_each(|s| states.insert(s));
        assert_eq!(states.take_from(0), Some(3));
        states.insert(1);
        states.insert(65);
        assert_eq!(states.take_from(4), Some(64));
        assert_eq!(states.take_from(65), Some(65));
        assert_eq!(states.take_from(66), Some(130));
        assert_eq!(states.take_from(131), None);
        assert_eq!((states.take_from(0), states.take_from(0)), (Some(1), None));
    }

    #[test]
    fn cycles_are_found_once_each_and_tails_are_not() {
        let mut parents = Parents::new(8);
        // 0 <- 1 <- 2 <- 0 with a tail at 3; 5 hangs on 4, which has no parent; 6 hangs on itself.
        for (state, parent, arc) in [(1, 0, 10), (2, 1, 11), (0, 2, 12), (3, 1, 13), (5, 4, 14), (6, 6, 15)] {
            parents.set(state, (parent, arc));
        }
        let expected = [vec![12, 11, 10], vec![15]];
        assert_eq!(parents.cycles(), expected);
        assert_eq!(parents.cycles(), expected);
        parents.clear();
        assert!(parents.cycles().is_empty());
    }
}
