//! The search of the thesis: up to r integers change by ±1 at a time, while the energy falls (`[kaelberer_2013]`
//! section 6.3.1).

use crate::engine::parameterize::rounding::candidate::Candidate;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Takes steps of at most `r` ≤ 3 integers that lower the energy and break no separation, the fewest integers first,
/// until there are none: the result is optimal among all that differ in at most r integers by one. O(nʳ) per step, with
/// a small constant: most combinations are ruled out by the best that their signs could do.
pub(super) fn r_search(ctx: &RunContext, candidate: &mut Candidate<'_>, r: usize) -> Result<(), Cancelled> {
    loop {
        ctx.check()?;
        if singles(candidate) || r >= 2 && pairs(candidate) {
            continue;
        }
        if r < 3 || !triples(ctx, candidate)? {
            return Ok(());
        }
    }
}

fn singles(candidate: &mut Candidate<'_>) -> bool {
    let tolerance = candidate.tolerance();
    let mut is_better = false;
    for i in 0..candidate.gram.n {
        let s = -candidate.slope[i].signum();
        if candidate.single(i, s) < -tolerance && !candidate.breaks(&[(i, s)]) {
            candidate.take(&[(i, s)]);
            is_better = true;
        }
    }
    is_better
}

/// The change of each integer alone, with its better sign.
fn alone(candidate: &Candidate<'_>) -> Vec<f64> {
    (0..candidate.gram.n).map(|i| candidate.gram.at(i, i) - 2.0 * candidate.slope[i].abs()).collect()
}

/// Takes the first combination of signs for these integers that lowers the energy.
fn try_signs(candidate: &mut Candidate<'_>, integers: &[usize], tolerance: f64) -> bool {
    for signs in 0..1u32 << integers.len() {
        let sign = |a: usize| if signs >> a & 1 == 0 { 1.0 } else { -1.0 };
        let mut change = 0.0;
        let mut steps = [(0, 0.0); 3];
        for (a, &i) in integers.iter().enumerate() {
            steps[a] = (i, sign(a));
            change += candidate.single(i, sign(a));
            change += 2.0 * (0..a).map(|b| sign(a) * sign(b) * candidate.gram.at(i, integers[b])).sum::<f64>();
        }
        let steps = &steps[..integers.len()];
        if change < -tolerance && !candidate.breaks(steps) {
            candidate.take(steps);
            return true;
        }
    }
    false
}

fn pairs(candidate: &mut Candidate<'_>) -> bool {
    let (gram, tolerance) = (candidate.gram, candidate.tolerance());
    let alone = alone(candidate);
    for i in 0..gram.n {
        let row = gram.row(i);
        for j in i + 1..gram.n {
            let is_hopeful = alone[i] + alone[j] - 2.0 * row[j].abs() < -tolerance;
            if is_hopeful && try_signs(candidate, &[i, j], tolerance) {
                return true;
            }
        }
    }
    false
}

fn triples(ctx: &RunContext, candidate: &mut Candidate<'_>) -> Result<bool, Cancelled> {
    let (gram, tolerance) = (candidate.gram, candidate.tolerance());
    let alone = alone(candidate);
    for i in 0..gram.n {
        ctx.check()?;
        let first = gram.row(i);
        for j in i + 1..gram.n {
            let second = gram.row(j);
            let two = alone[i] + alone[j] - 2.0 * first[j].abs();
            for k in j + 1..gram.n {
                let is_hopeful = two + alone[k] - 2.0 * (first[k].abs() + second[k].abs()) < -tolerance;
                if is_hopeful && try_signs(candidate, &[i, j, k], tolerance) {
                    return Ok(true);
                }
            }
        }
    }
    Ok(false)
}
