//! The strongest search: every block of strongly coupled integers is brought to its optimum, over and over; then
//! a few integers are kicked off it, the blocks around them settle again, and what is better is kept (iterated local
//! search). Work is counted in visited values, not in seconds, so a result does not depend on the machine.

use crate::engine::numerics::Random;
use crate::engine::parameterize::rounding::candidate::Candidate;
use crate::engine::parameterize::rounding::enumeration::Block;
use crate::engine::parameterize::rounding::gram::Gram;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Integers of a block.
const BLOCK: usize = 12;
/// Up to so many integers are one block: the result is the exact optimum unless the work runs out.
pub(super) const EXACT: usize = 24;
/// Values that one block may visit at once; a single block may use all the work that the search is given.
const WORK_OF_BLOCK: u64 = 50_000;
/// Integers kicked at a time.
const KICKED: usize = 3;
/// Share of the kicks that go where the energy rises least.
const DOWNHILL: f64 = 0.75;

/// One block around every integer, and the blocks that each integer is in.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    blocks: Vec<Block>,
    of: Vec<Vec<usize>>,
    /// Largest work of one block.
    share: u64,
}

impl Blocks {
    /// `None` if the matrix is numerically indefinite.
    pub(super) fn new(gram: &Gram) -> Option<Self> {
        let n = gram.n;
        let (blocks, share): (Option<Vec<Block>>, u64) = if n <= EXACT {
            (Block::new(gram, (0..n).collect()).map(|b| vec![b]), u64::MAX)
        } else {
            ((0..n).map(|i| Block::new(gram, coupled(gram, i))).collect(), WORK_OF_BLOCK)
        };
        let blocks = blocks?;
        let mut of = vec![Vec::new(); n];
        for (b, block) in blocks.iter().enumerate() {
            block.integers.iter().for_each(|&i| of[i].push(b));
        }
        Some(Self { blocks, of, share })
    }

    fn touch(&self, is_open: &mut [bool], i: usize) {
        self.of[i].iter().for_each(|&b| is_open[b] = true);
    }

    /// Solves open blocks until none of them has a better value.
    fn settle(
        &self,
        ctx: &RunContext,
        candidate: &mut Candidate<'_>,
        is_open: &mut [bool],
        work: &mut u64,
    ) -> Result<(), Cancelled> {
        while let Some(first) = is_open.iter().position(|o| *o) {
            ctx.check()?;
            for b in first..self.blocks.len() {
                if !std::mem::take(&mut is_open[b]) {
                    continue;
                }
                let mut share = self.share.min(*work);
                let given = share;
                let steps = self.blocks[b].best_steps(candidate, &mut share);
                *work -= given - share;
                if let Some(steps) = steps {
                    candidate.take(&steps);
                    *work = work.saturating_sub((steps.len() * candidate.q.len() / 16) as u64);
                    steps.iter().for_each(|&(i, _)| self.touch(is_open, i));
                }
            }
        }
        Ok(())
    }
}

/// The integer and those coupled to it and to each other most, relative to their stiffnesses.
fn coupled(gram: &Gram, i: usize) -> Vec<usize> {
    let mut block = vec![i];
    let mut coupling = vec![0.0; gram.n];
    while block.len() < BLOCK {
        let last = block[block.len() - 1];
        for (j, (c, p)) in coupling.iter_mut().zip(gram.row(last)).enumerate() {
            *c += p * p / (gram.at(last, last) * gram.at(j, j));
        }
        let others = (0..gram.n).filter(|j| !block.contains(j));
        let Some(next) = others.max_by(|&a, &b| coupling[a].total_cmp(&coupling[b])) else { break };
        block.push(next);
    }
    block
}

/// Improves the candidate until `work` is used up: fewer separations are violated, or as many with less energy.
pub(super) fn block_search(
    ctx: &RunContext,
    blocks: &Blocks,
    candidate: &mut Candidate<'_>,
    seed: u64,
    mut work: u64,
) -> Result<(), Cancelled> {
    let (n, all) = (candidate.q.len(), work.max(1) as f64);
    let mut is_open = vec![true; blocks.blocks.len()];
    blocks.settle(ctx, candidate, &mut is_open, &mut work)?;
    if blocks.blocks.len() < 2 && candidate.violated().is_empty() {
        return Ok(());
    }
    let mut random = Random::new(seed);
    let mut best = (candidate.violated(), candidate.clone());
    while work > 0 {
        ctx.check()?;
        ctx.advance(1.0 - work as f64 / all);
        for (i, s) in kick(blocks, candidate, &best.0, &mut random) {
            if !candidate.breaks(&[(i, s)]) {
                candidate.take(&[(i, s)]);
                blocks.touch(&mut is_open, i);
            }
        }
        blocks.settle(ctx, candidate, &mut is_open, &mut work)?;
        work = work.saturating_sub(50 + n as u64 / 2);
        let violated = candidate.violated();
        let by = candidate.tolerance();
        let is_better =
            violated.len() < best.0.len() || violated.len() == best.0.len() && candidate.energy < best.1.energy - by;
        if is_better {
            best = (violated, candidate.clone());
        } else {
            candidate.clone_from(&best.1);
        }
    }
    *candidate = best.1;
    Ok(())
}

/// Steps away from an optimum: in one block, or one that raises a violated separation.
fn kick(blocks: &Blocks, candidate: &Candidate<'_>, violated: &[usize], random: &mut Random) -> Vec<(usize, f64)> {
    if !violated.is_empty() && random.unit() < 0.5 {
        let form = &candidate.guard.separation(violated[random.below(violated.len())]).form;
        let (i, c) = form[random.below(form.len())];
        return vec![(i as usize, c.signum())];
    }
    let integers = &blocks.blocks[random.below(blocks.blocks.len())].integers;
    (0..KICKED)
        .map(|_| {
            let i = integers[random.below(integers.len())];
            let downhill = if candidate.slope[i] > 0.0 { -1.0 } else { 1.0 };
            (i, if random.unit() < DOWNHILL { downhill } else { -downhill })
        })
        .collect()
}
