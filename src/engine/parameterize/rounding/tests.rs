use super::gram::Gram;
use super::greedy::greedy;
use super::lattice::Lattice;
use super::*;
use crate::engine::numerics::Random;
use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::reduced::Reduced;

/// `Bᵀ B` and a little of the identity.
fn gram(n: usize, seed: u64) -> Gram {
    let mut random = Random::new(seed);
    let b: Vec<f64> = (0..n * n).map(|_| random.unit() - 0.5).collect();
    let entry = |i: usize, j: usize| (0..n).map(|k| b[k * n + i] * b[k * n + j]).sum::<f64>();
    let rows = (0..n * n).map(|k| entry(k / n, k % n) + if k / n == k % n { 0.05 } else { 0.0 }).collect();
    Gram { n, rows }
}

fn target(n: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..n).map(|_| 7.0 * random.unit()).collect()
}

/// Periods whose optimum at scale 1 is the target.
fn periods(gram: &Gram, target: &[f64]) -> Periods {
    let b = gram.times(target);
    Periods::from_matrix(&RunContext::silent(), gram.clone(), &b).unwrap().unwrap()
}

/// Every integer to its nearest.
fn direct(target: &[f64]) -> Vec<f64> {
    target.iter().map(|t| t.round()).collect()
}

fn energy(gram: &Gram, target: &[f64], q: &[f64]) -> f64 {
    gram.value(&q.iter().zip(target).map(|(q, t)| q - t).collect::<Vec<_>>())
}

/// The least energy of all integers within `reach` of the target that keep the separations.
fn exhaustive(gram: &Gram, target: &[f64], reach: i32, separations: &[Separation]) -> f64 {
    let n = gram.n;
    let width = 2 * reach + 1;
    let mut best = f64::INFINITY;
    for code in 0..(width as usize).pow(n as u32) {
        let digit = |i: usize| (code / (width as usize).pow(i as u32) % width as usize) as f64;
        let q: Vec<f64> = (0..n).map(|i| target[i].round() + digit(i) - f64::from(reach)).collect();
        if separations.iter().all(|s| s.value(&q) >= 1.0) {
            best = best.min(energy(gram, target, &q));
        }
    }
    best
}

/// Fixing integers and solving for everything else, densely, costs what the period matrix says.
#[test]
fn the_period_matrix_is_what_a_solve_with_fixed_integers_costs() {
    let (nz, n) = (9, 5);
    let whole = gram(nz + n, 3);
    let b = target(nz + n, 4);
    let mut reduced = Reduced {
        zz: Vec::new(),
        zq: vec![Vec::new(); n],
        qq: Vec::new(),
        b_z: b[..nz].to_vec(),
        b_q: b[nz..].to_vec(),
    };
    for i in 0..nz {
        reduced.zz.extend((0..=i).map(|j| (i as u32, j as u32, whole.at(i, j))));
        (0..n).for_each(|q| reduced.zq[q].push((i as u32, whole.at(i, nz + q))));
    }
    for i in 0..n {
        reduced.qq.extend((0..n).map(|j| whole.at(nz + i, nz + j)));
    }
    let factor = reduced.factor().unwrap();
    let periods = Periods::new(&RunContext::silent(), &reduced, &factor).unwrap().unwrap();
    let zz: Vec<f64> = (0..nz * nz).map(|k| whole.at(k / nz, k % nz)).collect();
    let inverse = positive_definite_inverse(nz, &zz).unwrap();
    let total = |q: &[f64], scale: f64| {
        let right: Vec<f64> =
            (0..nz).map(|i| scale * b[i] - (0..n).map(|j| whole.at(i, nz + j) * q[j]).sum::<f64>()).collect();
        let mut x: Vec<f64> = (0..nz).map(|i| (0..nz).map(|j| inverse[i * nz + j] * right[j]).sum()).collect();
        x.extend(q);
        whole.value(&x) - 2.0 * scale * x.iter().zip(&b).map(|(x, b)| x * b).sum::<f64>()
    };
    for (seed, scale) in [(5, 1.0), (6, 0.3)] {
        let [p, q] = [seed, seed + 10].map(|s| direct(&target(n, s)));
        let found = total(&p, scale) - total(&q, scale);
        let said = periods.excess(scale, &p) - periods.excess(scale, &q);
        assert!((found - said).abs() < 1e-9 * total(&p, scale).abs().max(1.0), "{found} {said}");
    }
}

#[test]
fn a_reduced_basis_is_a_basis_and_shorter() {
    for seed in 0..4 {
        // Partial sums: a basis far from orthogonal.
        let n = 20;
        let plain = gram(n, seed);
        let mut basis = Basis::unit(n);
        (0..n).for_each(|i| (0..i).for_each(|j| basis.vectors[i * n + j] = 1.0));
        let long = plain.in_basis(&basis);
        let lattice = Lattice::reduced(&long).unwrap();
        assert!(lattice.gram.trace() < 0.5 * long.trace(), "{} {}", lattice.gram.trace(), long.trace());
        let q = direct(&target(n, seed));
        let coordinates = lattice.basis.coordinates(&q);
        assert_eq!(lattice.basis.combine(&coordinates), q);
        assert!(coordinates.iter().all(|c| c.fract() == 0.0));
        let difference = lattice.gram.value(&coordinates) - long.value(&q);
        assert!(difference.abs() < 1e-9 * long.value(&q), "{difference}");
    }
}

#[test]
fn few_integers_are_rounded_to_the_exact_optimum() {
    let ctx = RunContext::silent();
    for seed in 0..20 {
        let n = 1 + seed as usize % 6;
        let (gram, target) = (gram(n, seed), target(n, 50 + seed));
        let (q, _) = periods(&gram, &target).round(&ctx, 1.0, &[]).unwrap();
        let (found, best) = (energy(&gram, &target, &q), exhaustive(&gram, &target, 4, &[]));
        assert!(q.iter().all(|q| q.fract() == 0.0));
        assert!((found - best).abs() < 1e-9, "seed {seed}: {found} {best}");
    }
}

#[test]
fn few_integers_with_separations_are_rounded_to_the_best_that_keeps_them() {
    let ctx = RunContext::silent();
    for seed in 0..20 {
        let n = 4;
        let (gram, target) = (gram(n, seed), target(n, 50 + seed));
        let form = |i: u32| vec![(i, 1.0), (i + 1, if seed % 2 == 0 { -1.0 } else { 1.0 })];
        let separations = [Separation { form: form(0) }, Separation { form: form(1) }];
        let (q, violated) = periods(&gram, &target).round(&ctx, 1.0, &separations).unwrap();
        let (found, best) = (energy(&gram, &target, &q), exhaustive(&gram, &target, 5, &separations));
        assert_eq!(violated, 0, "seed {seed}");
        assert!(separations.iter().all(|s| s.value(&q) >= 1.0));
        assert!(found < best + 1e-9, "seed {seed}: {found} {best}");
    }
}

#[test]
fn the_search_is_deterministic_and_never_worse_than_its_starts() {
    let ctx = RunContext::silent();
    for seed in 0..3 {
        let n = 60;
        let (gram, target) = (gram(n, seed), target(n, 9 + seed));
        let periods = periods(&gram, &target);
        let separations: Vec<Separation> =
            (0..20).map(|i| Separation { form: vec![(2 * i, 1.0), (2 * i + 1, -1.0)] }).collect();
        let (q, n_violated) = periods.round(&ctx, 1.0, &separations).unwrap();
        assert_eq!(periods.round(&ctx, 1.0, &separations).unwrap(), (q.clone(), n_violated));
        assert_eq!(separations.iter().filter(|s| s.is_violated(&q)).count(), n_violated);
        let old = pulled(&ctx, &periods.gram, &periods.inverse, &target, &separations).unwrap();
        let of_old = separations.iter().filter(|s| s.is_violated(&old)).count();
        assert!((n_violated, energy(&gram, &target, &q)) <= (of_old, energy(&gram, &target, &old) + 1e-9));
    }
}

#[test]
fn one_integer_after_the_other_is_better_than_all_at_once() {
    let ctx = RunContext::silent();
    let gram = gram(30, 1);
    let inverse = positive_definite_inverse(30, &gram.rows).unwrap();
    let (mut all, mut one) = (0.0, 0.0);
    for seed in 0..20 {
        let target = target(30, seed);
        all += energy(&gram, &target, &direct(&target));
        one += energy(&gram, &target, &greedy(&ctx, &inverse, &target).unwrap());
    }
    assert!(one < 0.9 * all, "{one} {all}");
}

#[test]
fn nothing_to_round_is_rounded() {
    let gram = Gram { n: 0, rows: Vec::new() };
    assert_eq!(periods(&gram, &[]).round(&RunContext::silent(), 1.0, &[]).unwrap(), (Vec::new(), 0));
}
