//! How many cases are drawn, from which seed, and what is counted over all of them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Debug;

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseResult, TestRunner};
use quadrille::engine::mesh::TriangleSoup;

/// Whether this is the long run.
pub(crate) fn is_soak() -> bool {
    std::env::var_os("QUADRILLE_SOAK").is_some()
}

/// `gate` cases, or in the long run `soak`.
pub(crate) fn number_of_cases(gate: u32, soak: u32) -> u32 {
    if is_soak() { soak } else { gate }
}

/// Milliseconds after which a failure is small enough.
const LONGEST_SHRINKING: u32 = 60_000;

fn seed() -> u64 {
    std::env::var("QUADRILLE_SEED").map_or(1, |seed| seed.parse().expect("QUADRILLE_SEED is a whole number"))
}

/// Judges so many values of a strategy; a failure is made as small as possible and names the seed.
pub(crate) fn for_all<S: Strategy>(cases: u32, strategy: S, judge: impl Fn(S::Value) -> TestCaseResult) {
    let config = ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(seed()),
        failure_persistence: None,
        max_shrink_iters: 300,
        max_shrink_time: LONGEST_SHRINKING,
        ..ProptestConfig::default()
    };
    if let Err(error) = TestRunner::new(config).run(&strategy, judge) {
        panic!("QUADRILLE_SEED={} draws this again: {error}", seed());
    }
}

/// Writes a soup that failed where whoever looks for the cause can remesh it by hand; where that is.
pub(crate) fn kept(soup: &TriangleSoup) -> String {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/failed.obj");
    let mut text = String::new();
    for p in &soup.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for polygon in soup.polygons() {
        let corners: Vec<String> = polygon.iter().map(|v| (v + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    match std::fs::write(path, text) {
        Ok(()) => path.to_owned(),
        Err(error) => error.to_string(),
    }
}

/// How often something was met, over all cases.
#[derive(Debug)]
pub(crate) struct Met<K>(RefCell<BTreeMap<K, u32>>);

impl<K> Default for Met<K> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<K: Copy + Debug + Ord> Met<K> {
    pub(crate) fn count(&self, kind: K) {
        *self.0.borrow_mut().entry(kind).or_default() += 1;
    }

    pub(crate) fn of(&self, kind: K) -> u32 {
        self.0.borrow().get(&kind).copied().unwrap_or_default()
    }

    /// Each of these at least so often: a generator that stopped making one of them would prove nothing about it.
    pub(crate) fn assert_each(&self, kinds: &[K], least: u32) {
        for &kind in kinds {
            assert!(self.of(kind) >= least, "{kind:?} was met {} times of all {:?}", self.of(kind), self.0.borrow());
        }
    }
}
