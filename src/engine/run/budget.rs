//! How much work a run may do, counted independently of machine and load.

/// Work in units: milliseconds of one core of the machine that the costs of the stages were measured on. It is predicted
/// from sizes before it is done, so the same request has the same budget and spends the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    left: f64,
}

impl Budget {
    /// So many units.
    pub fn of(units: f64) -> Self {
        Self { left: units.max(0.0) }
    }

    /// What is left, in units.
    pub fn left(&self) -> f64 {
        self.left
    }

    /// Whether work of so many units fits.
    pub fn allows(&self, units: f64) -> bool {
        units <= self.left
    }

    /// Takes so many units; below zero there is nothing.
    pub fn spend(&mut self, units: f64) {
        self.left = (self.left - units).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_spent_is_gone() {
        let mut budget = Budget::of(10.0);
        assert!(budget.allows(10.0) && !budget.allows(10.1));
        budget.spend(7.0);
        assert!(budget.allows(3.0) && !budget.allows(3.1));
        budget.spend(5.0);
        assert_eq!(budget.left(), 0.0);
    }
}
