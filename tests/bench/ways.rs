//! Ways of rounding the integers of a map, and what the period matrix predicts of them (`[kaelberer_2013]` sections 6.3 and
//! 6.4). Energies are those of [`PeriodForm`].

use quadrille::engine::numerics::{Random, positive_definite_inverse};
use quadrille::engine::parameterize::{MapError, MapSystem, PeriodForm};
use quadrille::engine::run::RunContext;

/// Mean energies over random real optima.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Means {
    /// Every integer to its nearest, in the basis of a shortest cut graph; over more optima than the others, for a few
    /// stiff directions make its mean settle slowly.
    pub(crate) direct: f64,
    /// One at a time, the one that raises the energy least first, the others following, in the same basis.
    pub(crate) greedy: f64,
    /// Up to 1, 2, 3 integers change by ±1 at a time while the energy falls, in the same basis, from direct rounding.
    pub(crate) r_search: [f64; 3],
    /// The search of the engine.
    pub(crate) search: f64,
    /// What the trace of the matrix predicts for direct rounding: every error is uniform in [−½, ½], so 1/12 of it.
    pub(crate) predicted_direct: f64,
    /// What the reduced matrix predicts for the search.
    pub(crate) predicted_search: f64,
}

/// Optima that are rounded directly for each that is searched.
const MORE_DIRECT: u64 = 20;
/// Energy after the search relative to what nearest planes leave in the reduced basis, which is 1/12 of what the matrix has
/// left of each direction when the integers fixed later are free. Measured on random optima of many models.
const SEARCHED: f64 = 0.9;

/// Rounds `offsets` random real optima in every way.
pub(crate) fn means(system: &MapSystem, seed: u64, offsets: usize) -> Result<Means, MapError> {
    let form = system.period_form()?;
    let n = form.n;
    let plain = Form { n, rows: form.matrix.clone() };
    let cut = plain.in_basis(&form.shortest_cut);
    let trace = |form: &Form| (0..n).map(|i| form.at(i, i)).sum::<f64>();
    let mut means = Means {
        predicted_direct: trace(&cut) / 12.0,
        predicted_search: match &form.reduced {
            Some(reduced) => SEARCHED / 12.0 * reduced.iter().sum::<f64>(),
            None => trace(&plain) / 12.0,
        },
        ..Means::default()
    };
    let Some(inverse) = positive_definite_inverse(n, &cut.rows) else { return Ok(means) };
    for offset in 0..offsets as u64 {
        let mut random = Random::new(seed ^ (offset << 32));
        let target: Vec<f64> = (0..n).map(|_| random.unit()).collect();
        for _ in 0..MORE_DIRECT {
            means.direct += cut.value(&(0..n).map(|_| random.unit() - 0.5).collect::<Vec<_>>());
        }
        means.greedy += cut.value(&difference(&greedy(&inverse, &target), &target));
        let mut candidate = Candidate::new(&cut, &target, target.iter().map(|t| t.round()).collect());
        means.direct += candidate.energy;
        for r in 1..=3 {
            candidate.search(r);
            means.r_search[r - 1] += candidate.energy;
        }
        let target = combine(n, &form.shortest_cut, &target);
        let q = system.nearest(&RunContext::silent(), &target)?;
        means.search += plain.value(&difference(&q, &target));
    }
    let optima = offsets.max(1) as f64;
    means.direct /= optima * (MORE_DIRECT + 1) as f64;
    means.greedy /= optima;
    means.r_search.iter_mut().for_each(|mean| *mean /= optima);
    means.search /= optima;
    Ok(means)
}

/// What the integers nearest to the optimum at a scale cost, relative to ½‖X‖² of that scale.
pub(crate) fn found(system: &MapSystem, form: &PeriodForm, scale: f64) -> Result<f64, MapError> {
    let target: Vec<f64> = form.optimum.iter().map(|q| scale * q).collect();
    let q = system.nearest(&RunContext::silent(), &target)?;
    let plain = Form { n: form.n, rows: form.matrix.clone() };
    Ok(plain.value(&difference(&q, &target)) / (scale * scale))
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// `Σ x_j v_j` over the rows of a basis.
fn combine(n: usize, basis: &[f64], x: &[f64]) -> Vec<f64> {
    (0..n).map(|i| (0..n).map(|j| x[j] * basis[j * n + i]).sum()).collect()
}

/// A symmetric positive definite form, n × n, row after row.
pub(crate) struct Form {
    pub(crate) n: usize,
    pub(crate) rows: Vec<f64>,
}

impl Form {
    fn at(&self, i: usize, j: usize) -> f64 {
        self.rows[i * self.n + j]
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.n..(i + 1) * self.n]
    }

    fn times(&self, d: &[f64]) -> Vec<f64> {
        (0..self.n).map(|i| self.row(i).iter().zip(d).map(|(p, d)| p * d).sum()).collect()
    }

    pub(crate) fn value(&self, d: &[f64]) -> f64 {
        self.times(d).iter().zip(d).map(|(p, d)| p * d).sum()
    }

    fn in_basis(&self, basis: &[f64]) -> Self {
        let n = self.n;
        let images: Vec<Vec<f64>> = basis.chunks(n.max(1)).map(|vector| self.times(vector)).collect();
        let entry = |k: usize| images[k / n].iter().zip(&basis[k % n * n..]).map(|(a, b)| a * b).sum();
        Self { n, rows: (0..n * n).map(entry).collect() }
    }
}

/// One integer at a time, the one that raises the energy least first; the others follow to their new optimum.
fn greedy(inverse: &[f64], target: &[f64]) -> Vec<f64> {
    let n = target.len();
    let (mut q, mut covariance) = (target.to_vec(), inverse.to_vec());
    let mut open: Vec<usize> = (0..n).collect();
    while !open.is_empty() {
        let cost = |i: usize| (q[i] - q[i].round()).powi(2) / covariance[i * n + i].max(1e-300);
        let at = (0..open.len()).min_by(|&a, &b| cost(open[a]).total_cmp(&cost(open[b]))).unwrap_or(0);
        let i = open.swap_remove(at);
        let step = q[i].round() - q[i];
        let row: Vec<f64> = covariance[i * n..(i + 1) * n].to_vec();
        let variance = row[i].max(1e-300);
        q[i] = q[i].round();
        for &j in &open {
            q[j] += step * row[j] / variance;
            let factor = row[j] / variance;
            covariance[j * n..(j + 1) * n].iter_mut().zip(&row).for_each(|(c, r)| *c -= factor * r);
        }
    }
    q
}

/// Integers with the energy and half its gradient.
pub(crate) struct Candidate<'a> {
    form: &'a Form,
    pub(crate) q: Vec<f64>,
    slope: Vec<f64>,
    pub(crate) energy: f64,
}

impl<'a> Candidate<'a> {
    pub(crate) fn new(form: &'a Form, target: &[f64], q: Vec<f64>) -> Self {
        let d = difference(&q, target);
        Self { form, slope: form.times(&d), energy: form.value(&d), q }
    }

    /// The search of the thesis (section 6.3.1): the result is optimal among all that differ in at most `r` ≤ 3 integers by
    /// one.
    pub(crate) fn search(&mut self, r: usize) {
        let tolerance = 1e-12 * (1.0 + (0..self.form.n).map(|i| self.form.at(i, i)).sum::<f64>());
        while (1..=r).any(|size| self.step(&mut Vec::new(), size, tolerance)) {}
    }

    /// Takes the first step of `more` integers after those chosen that lowers the energy.
    fn step(&mut self, chosen: &mut Vec<usize>, more: usize, tolerance: f64) -> bool {
        if more == 0 {
            return self.try_signs(chosen, tolerance);
        }
        for i in chosen.last().map_or(0, |last| last + 1)..self.form.n {
            chosen.push(i);
            // No choice of signs does better than this; with more to come it says little.
            let is_hopeful = more > 1 || self.least(chosen) < -tolerance;
            if is_hopeful && self.step(chosen, more - 1, tolerance) {
                return true;
            }
            chosen.pop();
        }
        false
    }

    fn least(&self, integers: &[usize]) -> f64 {
        let alone = integers.iter().map(|&i| self.form.at(i, i) - 2.0 * self.slope[i].abs()).sum::<f64>();
        let pairs = integers.iter().enumerate().flat_map(|(a, &i)| integers[..a].iter().map(move |&j| (i, j)));
        alone - 2.0 * pairs.map(|(i, j)| self.form.at(i, j).abs()).sum::<f64>()
    }

    fn try_signs(&mut self, integers: &[usize], tolerance: f64) -> bool {
        for signs in 0..1u32 << integers.len() {
            let sign = |a: usize| if signs >> a & 1 == 0 { 1.0 } else { -1.0 };
            let mut change = 0.0;
            for (a, &i) in integers.iter().enumerate() {
                change += self.form.at(i, i) + 2.0 * sign(a) * self.slope[i];
                change += 2.0 * (0..a).map(|b| sign(a) * sign(b) * self.form.at(i, integers[b])).sum::<f64>();
            }
            if change < -tolerance {
                for (a, &i) in integers.iter().enumerate() {
                    self.q[i] += sign(a);
                    self.slope.iter_mut().zip(self.form.row(i)).for_each(|(g, p)| *g += sign(a) * p);
                }
                self.energy += change;
                return true;
            }
        }
        false
    }
}
