//! Exact elimination of linear relations with small integer coefficients.
//!
//! Each relation `Σ c x = 0` removes one unknown. Unknowns that may take any value go first, then translations; unknowns
//! that must be integers go last, so that integers stay free and everything removed is an integer combination of them.
//! Among equals the unknown that fewer others depend on is removed: chains of equalities stay shallow.

use std::collections::BTreeMap;

/// A linear form in real unknowns, sorted by unknown, no zero coefficients.
pub(super) type RealForm = Vec<(u32, f64)>;

/// Unknowns and the relations eliminated so far.
#[derive(Clone, Debug)]
pub(super) struct Elimination {
    /// Expression of each removed unknown, in unknowns that were free at the time.
    expression: Vec<RealForm>,
    /// When each unknown was removed, if it was.
    turn: Vec<Option<u32>>,
    /// Order of removal.
    removed: Vec<u32>,
    /// Removed first when lowest.
    rank: Vec<u8>,
    /// Number of unknowns that were expressed through this one.
    weight: Vec<u32>,
}

impl Elimination {
    /// Unknowns with their rank: lower ranks are removed before higher ones.
    pub(super) fn new(rank: Vec<u8>) -> Self {
        let n = rank.len();
        Self { expression: vec![Vec::new(); n], turn: vec![None; n], removed: Vec::new(), rank, weight: vec![1; n] }
    }

    /// The form in unknowns that are still free. Unknowns are replaced in the order in which they were removed: what
    /// replaces them was removed later, so that each is met once, with all that was collected for it.
    pub(super) fn resolve(&self, form: &[(u32, f64)]) -> RealForm {
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        let mut pending: BTreeMap<u32, (u32, f64)> = BTreeMap::new();
        let mut collect = |pending: &mut BTreeMap<u32, (u32, f64)>, x: u32, c: f64| match self.turn[x as usize] {
            Some(turn) => pending.entry(turn).or_insert((x, 0.0)).1 += c,
            None => *sum.entry(x).or_insert(0.0) += c,
        };
        for &(x, c) in form {
            collect(&mut pending, x, c);
        }
        while let Some((_, (x, c))) = pending.pop_first() {
            // Coefficients are sums of products of ±1 and halves: exact, so zero is zero.
            if c != 0.0 {
                self.expression[x as usize].iter().for_each(|&(y, d)| collect(&mut pending, y, c * d));
            }
        }
        sum.into_iter().filter(|&(_, c)| c != 0.0).collect()
    }

    /// Adds the relation `form = 0`. Returns whether it removed an unknown (a dependent relation does not).
    pub(super) fn add(&mut self, form: &[(u32, f64)]) -> bool {
        let form = self.resolve(form);
        // A pivot of ±1 keeps integers integers; a larger one is the last resort.
        let key = |&(x, c): &(u32, f64)| {
            (c.abs() != 1.0, self.rank[x as usize], (c.abs() * 16.0) as u64, self.weight[x as usize], x)
        };
        let Some(&(pivot, coefficient)) = form.iter().min_by_key(|t| key(t)) else { return false };
        let expression: RealForm =
            form.iter().filter(|&&(x, _)| x != pivot).map(|&(x, c)| (x, -c / coefficient)).collect();
        for &(x, _) in &expression {
            self.weight[x as usize] += self.weight[pivot as usize];
        }
        self.expression[pivot as usize] = expression;
        self.turn[pivot as usize] = Some(self.removed.len() as u32);
        self.removed.push(pivot);
        true
    }

    /// Every unknown as a form in the unknowns that stayed free. O(total length).
    pub(super) fn finish(mut self) -> Vec<RealForm> {
        for i in (0..self.removed.len()).rev() {
            let x = self.removed[i] as usize;
            // Whatever this expression names was removed later, hence is final already: one level is enough.
            self.expression[x] = self.resolve(&self.expression[x]);
        }
        let free = (0..self.turn.len()).filter(|&x| self.turn[x].is_none());
        free.for_each(|x| self.expression[x] = vec![(x as u32, 1.0)]);
        self.expression
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relations_hold_after_elimination() {
        let mut e = Elimination::new(vec![0, 0, 1, 2, 2]);
        let relations: [&[(u32, f64)]; 4] = [
            &[(0, 1.0), (1, -1.0), (2, 1.0)],
            &[(1, 1.0), (3, -1.0), (4, 1.0)],
            &[(2, 1.0), (3, 1.0), (4, 1.0)],
            &[(0, 1.0), (1, -1.0), (3, -1.0), (4, -1.0)],
        ];
        let independent: Vec<bool> = relations.iter().map(|r| e.add(r)).collect();
        assert_eq!(independent, [true, true, true, false]);
        let forms = e.finish();
        for relation in relations {
            let mut sum = [0.0; 5];
            for &(x, c) in relation {
                for &(y, d) in &forms[x as usize] {
                    sum[y as usize] += c * d;
                }
            }
            assert_eq!(sum, [0.0; 5]);
        }
        // The integers, of highest rank, stayed free.
        assert_eq!(forms[3], vec![(3, 1.0)]);
        assert_eq!(forms[4], vec![(4, 1.0)]);
    }
}
