//! Counters of repairs.

/// Names of repairs and how often they were made, in order of first use.
#[derive(Debug, Default)]
pub(super) struct Tally(Vec<(&'static str, usize)>);

impl Tally {
    /// Adds `n` to the counter; 0 leaves no trace.
    pub(super) fn add(&mut self, name: &'static str, n: usize) {
        if n == 0 {
            return;
        }
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += n,
            None => self.0.push((name, n)),
        }
    }

    /// The counters that are not 0.
    pub(super) fn into_counts(self) -> Vec<(&'static str, usize)> {
        self.0
    }
}
