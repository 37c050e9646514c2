//! Periods of harmonic 1-forms of a closed surface: scalar products, intersection numbers, conjugation, Riemann's matrix.

use crate::engine::calculus::chain::Step;
use crate::engine::calculus::forms::OneForm;
use crate::engine::calculus::stars::Stars;
use crate::engine::numerics::inverse;

/// What the products of the forms of a basis say. Matrices are n × n, row after row.
#[derive(Clone, Debug)]
pub struct Periods {
    /// Number of forms.
    pub n: usize,
    /// `∫ ⟨ω_i, ω_j⟩`, symmetric and positive: energies.
    pub energy: Vec<f64>,
    /// `∫ ω_i ∧ ω_j`, antisymmetric integers of determinant 1 for a basis that is dual to generators.
    pub intersection: Vec<f64>,
}

impl Periods {
    /// Products of closed forms. O(n² F).
    pub fn new(stars: &Stars, forms: &[OneForm]) -> Self {
        let n = forms.len();
        let pairs = || (0..n * n).map(|k| (&forms[k / n], &forms[k % n]));
        let energy = pairs().map(|(a, b)| stars.product(a, b)).collect();
        Self { n, energy, intersection: pairs().map(|(a, b)| a.wedge(b)).collect() }
    }

    /// The matrix S with `⋆ω_j ≈ Σ_k S_kj ω_k`: from `∫ ω_i ∧ ⋆ω_j = ∫ ⟨ω_i, ω_j⟩`. Its square is −1 up to the discretisation.
    /// `None` if the intersection form is degenerate.
    pub fn conjugation(&self) -> Option<Vec<f64>> {
        Some(product(self.n, &inverse(self.n, &self.intersection)?, &self.energy))
    }

    /// A basis in which the intersection form is `[[0, 1], [−1, 0]]` in blocks of g: row i has the integer coefficients of the
    /// i-th new form. `None` if the form is not unimodular.
    pub fn symplectic(&self) -> Option<Vec<f64>> {
        let n = self.n;
        let meet = |a: &[f64], b: &[f64]| -> f64 {
            (0..n * n).map(|k| a[k / n] * self.intersection[k % n + (k / n) * n].round() * b[k % n]).sum()
        };
        let mut rest: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        let (mut first, mut second) = (Vec::new(), Vec::new());
        let add = |a: &mut Vec<f64>, factor: f64, b: &[f64]| a.iter_mut().zip(b).for_each(|(x, y)| *x += factor * y);
        while !rest.is_empty() {
            // Euclid's algorithm on the intersections with the first form that is left, until one of them is ±1.
            let a = rest.swap_remove(0);
            let mut b = loop {
                let mut by_size: Vec<(f64, usize)> =
                    rest.iter().enumerate().map(|(k, r)| (meet(&a, r), k)).filter(|p| p.0 != 0.0).collect();
                by_size.sort_by(|p, q| p.0.abs().total_cmp(&q.0.abs()).then(p.1.cmp(&q.1)));
                let &(least, at) = by_size.first()?;
                if least.abs() == 1.0 {
                    break rest.swap_remove(at);
                }
                let &(other, to) = by_size.get(1)?;
                let smaller = rest[at].clone();
                add(&mut rest[to], -(other / least).trunc(), &smaller);
            };
            if meet(&a, &b) < 0.0 {
                b.iter_mut().for_each(|x| *x = -*x);
            }
            for r in &mut rest {
                let (with_a, with_b) = (meet(&a, r), meet(&b, r));
                add(r, -with_a, &b);
                add(r, with_b, &a);
            }
            first.push(a);
            second.push(b);
        }
        first.append(&mut second);
        Some(first.concat())
    }

    /// Riemann's period matrix τ in a symplectic basis, real and imaginary part, g × g: the holomorphic forms with A-periods 1
    /// have the B-periods τ. Symmetric with positive imaginary part; on the torus of periods 1 and τ it is τ up to the choice of
    /// the basis. `None` as for [`Periods::symplectic`].
    pub fn riemann(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let (n, g) = (self.n, self.n / 2);
        let basis = self.symplectic()?;
        let transposed: Vec<f64> = (0..n * n).map(|k| basis[(k % n) * n + k / n]).collect();
        let energy = product(n, &product(n, &basis, &self.energy), &transposed);
        let block = |i: usize, j: usize| -> Vec<f64> {
            (0..g * g).map(|k| energy[(i * g + k / g) * n + j * g + k % g]).collect()
        };
        // ⋆ has the blocks −P₂₁, −P₂₂ in its upper half, and ⋆θ = −iθ for θ = α + τβ.
        let imaginary = inverse(g, &block(1, 1))?;
        let real = product(g, &imaginary, &block(1, 0)).iter().map(|x| -x).collect();
        Some((real, imaginary))
    }
}

/// Forms with integral 1 along the chain of the same number and 0 along the others; `None` if the chains are dependent on these
/// forms or their numbers differ.
pub fn dual_basis(forms: &[OneForm], chains: &[Vec<Step>]) -> Option<Vec<OneForm>> {
    let n = forms.len();
    if chains.len() != n {
        return None;
    }
    let periods: Vec<f64> = (0..n * n).map(|k| forms[k % n].integral(&chains[k / n])).collect();
    let coefficients = inverse(n, &periods)?;
    let combined = |j: usize| {
        let mut form = OneForm { along: vec![0.0; forms[0].along.len()] };
        (0..n).for_each(|i| form.add(coefficients[i * n + j], &forms[i]));
        form
    };
    Some((0..n).map(combined).collect())
}

fn product(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    (0..n * n).map(|k| (0..n).map(|m| a[(k / n) * n + m] * b[m * n + k % n]).sum()).collect()
}
