//! The flow against exhaustive search.

use super::flow::{Flow, Variable};
use crate::engine::numerics::Random;
use crate::engine::run::RunContext;

fn random_flow(random: &mut Random) -> (usize, Vec<Variable>) {
    let n_sums = 2 + random.below(3);
    let end = |random: &mut Random| {
        let sign = if random.below(2) == 0 { 1 } else { -1 };
        (random.below(6) > 0).then(|| (random.below(n_sums) as u32, sign))
    };
    let variable = |random: &mut Random| Variable {
        ends: [end(random), end(random)],
        target: 3.0 * random.unit(),
        weight: 0.5 + random.unit(),
        least: random.below(2) as i64 - random.below(2) as i64,
    };
    let n = 5 + random.below(3);
    (n_sums, (0..n).map(|_| variable(random)).collect())
}

fn sums(n_sums: usize, variables: &[Variable], x: &[i64]) -> Vec<i64> {
    let mut sums = vec![0; n_sums];
    for (variable, x) in variables.iter().zip(x) {
        for (sum, sign) in variable.ends.iter().flatten() {
            sums[*sum as usize] += sign * x;
        }
    }
    sums
}

/// The least cost over all values from the bounds to 6.
fn exhaustive(n_sums: usize, variables: &[Variable]) -> Option<f64> {
    let mut x: Vec<i64> = variables.iter().map(|v| v.least).collect();
    let mut sums = sums(n_sums, variables, &x);
    let mut best: Option<f64> = None;
    loop {
        if sums.iter().all(|&s| s == 0) {
            let cost: f64 = variables.iter().zip(&x).map(|(v, &x)| v.weight * (x as f64 - v.target).powi(2)).sum();
            best = Some(best.map_or(cost, |b| b.min(cost)));
        }
        let Some(at) = (0..x.len()).find(|&i| x[i] < 6) else { return best };
        for (i, variable) in variables.iter().enumerate().take(at + 1) {
            let to = if i == at { x[i] + 1 } else { variable.least };
            let by = to - std::mem::replace(&mut x[i], to);
            variable.ends.iter().flatten().for_each(|&(sum, sign)| sums[sum as usize] += sign * by);
        }
    }
}

#[test]
fn flows_balance_keep_their_bounds_and_are_nearly_optimal() {
    let mut random = Random::new(7);
    let (mut tried, mut optimal, mut gap) = (0, 0, 0.0);
    while tried < 150 {
        let (n_sums, variables) = random_flow(&mut random);
        let Some(best) = exhaustive(n_sums, &variables) else { continue };
        let flow = Flow::new(n_sums, variables.clone());
        let nearest: Vec<i64> = variables.iter().map(|v| v.target.round() as i64).collect();
        let Some(x) = flow.solve(&RunContext::silent(), &nearest).unwrap() else { continue };
        assert!(sums(n_sums, &variables, &x).iter().all(|&s| s == 0));
        assert!(variables.iter().zip(&x).all(|(v, &x)| x >= v.least));
        tried += 1;
        let cost = flow.cost(&x);
        optimal += usize::from(cost < best + 1e-9);
        gap += (cost - best) / (best + 1.0);
    }
    assert!(optimal * 20 >= tried as usize * 19, "{optimal} of {tried}");
    assert!(gap < 0.02 * f64::from(tried), "{gap}");
}

#[test]
fn sums_that_cannot_vanish_are_refused() {
    let one = |sign| Variable { ends: [Some((0, sign)), None], target: 1.0, weight: 1.0, least: 1 };
    let pair = Variable { ends: [Some((0, 1)), Some((0, 1))], target: 1.0, weight: 1.0, least: 1 };
    assert!(Flow::new(1, vec![pair]).solve(&RunContext::silent(), &[1]).unwrap().is_none());
    let x = Flow::new(1, vec![one(1), one(-1)]).solve(&RunContext::silent(), &[3, 1]).unwrap().unwrap();
    assert_eq!(x, [1, 1]);
}
