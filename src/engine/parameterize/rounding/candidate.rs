//! Integers under search: their energy, its gradient, and the separations that steps must not break.

use crate::engine::parameterize::rounding::gram::{Gram, dot};
use crate::engine::parameterize::separation::{Separation, is_violated};

/// One step of a search: these integers change by these amounts.
pub(super) type Steps = [(usize, f64)];

/// Integers, kept with what every search needs to know of them.
#[derive(Clone, Debug)]
pub(super) struct Candidate<'a> {
    pub(super) gram: &'a Gram,
    pub(super) guard: &'a Guard,
    pub(super) q: Vec<f64>,
    /// Half the gradient of the energy: `G (q − target)`.
    pub(super) slope: Vec<f64>,
    pub(super) energy: f64,
    /// Value of each separation.
    value: Vec<f64>,
    /// Scratch, all zero.
    change: Vec<f64>,
}

/// The separations by integer.
#[derive(Clone, Debug, Default)]
pub(super) struct Guard {
    separations: Vec<Separation>,
    /// Per integer, the separations that it moves, and how far.
    concerns: Vec<Vec<(usize, f64)>>,
}

impl Guard {
    pub(super) fn new(n: usize, separations: &[Separation]) -> Self {
        let mut concerns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        for (k, separation) in separations.iter().enumerate() {
            for &(i, c) in &separation.form {
                concerns[i as usize].push((k, c));
            }
        }
        Self { separations: separations.to_vec(), concerns }
    }

    pub(super) fn separation(&self, k: usize) -> &Separation {
        &self.separations[k]
    }
}

impl<'a> Candidate<'a> {
    pub(super) fn new(gram: &'a Gram, guard: &'a Guard, target: &[f64], q: Vec<f64>) -> Self {
        let d: Vec<f64> = q.iter().zip(target).map(|(q, t)| q - t).collect();
        let slope = gram.times(&d);
        let energy = dot(&slope, &d);
        let value: Vec<f64> = guard.separations.iter().map(|s| s.value(&q)).collect();
        Self { gram, guard, q, slope, energy, change: vec![0.0; value.len()], value }
    }

    /// What the energy changes by when integer i changes by `s`.
    pub(super) fn single(&self, i: usize, s: f64) -> f64 {
        s * s * self.gram.at(i, i) + 2.0 * s * self.slope[i]
    }

    /// Whether these steps lower a separation below its bound, or further below it.
    pub(super) fn breaks(&mut self, steps: &Steps) -> bool {
        if self.value.is_empty() {
            return false;
        }
        let Self { guard, change, value, .. } = self;
        let concerned = || steps.iter().flat_map(|&(i, s)| guard.concerns[i].iter().map(move |&(k, c)| (k, s * c)));
        concerned().for_each(|(k, by)| change[k] += by);
        concerned().fold(false, |is_broken, (k, _)| {
            let by = std::mem::take(&mut change[k]);
            is_broken || by < 0.0 && value[k] + by < 1.0
        })
    }

    /// Takes the steps. O(n) each.
    pub(super) fn take(&mut self, steps: &Steps) {
        for &(i, s) in steps {
            self.energy += self.single(i, s);
            self.q[i] += s;
            self.slope.iter_mut().zip(self.gram.row(i)).for_each(|(g, p)| *g += s * p);
            for &(k, c) in self.guard.concerns.get(i).map_or(&[][..], |c| c) {
                self.value[k] += s * c;
            }
        }
    }

    /// Separations that do not hold.
    pub(super) fn violated(&self) -> Vec<usize> {
        (0..self.value.len()).filter(|&k| is_violated(self.value[k])).collect()
    }

    /// Changes below this are rounding errors of the energy.
    pub(super) fn tolerance(&self) -> f64 {
        1e-12 * (1.0 + self.gram.trace())
    }
}
