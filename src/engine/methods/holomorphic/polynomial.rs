//! Complex polynomials of low degree as lists of coefficients, the constant one first.

use faer::c64;

/// Rounds of the search for roots, which converges quadratically where roots are apart.
const ROUNDS: usize = 60;

/// The polynomial with `terms` coefficients nearest to some values: rows are place, value and weight; `None` if the places do
/// not determine it.
pub(super) fn fitted(rows: &[(c64, c64, f64)], terms: usize) -> Option<Vec<c64>> {
    let zero = c64::new(0.0, 0.0);
    let width = terms + 1;
    let mut m = vec![zero; terms * width];
    for &(z, value, weight) in rows {
        let mut power = vec![c64::new(1.0, 0.0); terms];
        (1..terms).for_each(|j| power[j] = power[j - 1] * z);
        for i in 0..terms {
            let left = power[i].conj() * weight;
            (0..terms).for_each(|j| m[i * width + j] += left * power[j]);
            m[i * width + terms] += left * value;
        }
    }
    let least = 1e-13 * (0..terms).map(|i| m[i * width + i].norm()).fold(0.0, f64::max);
    for k in 0..terms {
        // The matrix is Hermitian and positive: its diagonal has pivots.
        let pivot = m[k * width + k];
        if pivot.norm() <= least {
            return None;
        }
        for i in (0..terms).filter(|&i| i != k) {
            let factor = m[i * width + k] / pivot;
            for j in k..width {
                let above = m[k * width + j];
                m[i * width + j] -= factor * above;
            }
        }
    }
    Some((0..terms).map(|i| m[i * width + terms] / m[i * width + i]).collect())
}

/// The product of two polynomials.
pub(super) fn product(a: &[c64], b: &[c64]) -> Vec<c64> {
    let mut c = vec![c64::new(0.0, 0.0); a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        b.iter().enumerate().for_each(|(j, y)| c[i + j] += x * y);
    }
    c
}

/// The polynomial part of `a / b`, with b of leading coefficient 1.
pub(super) fn quotient(a: &[c64], b: &[c64]) -> Vec<c64> {
    let mut rest = a.to_vec();
    let n = (a.len() + 1).saturating_sub(b.len());
    let mut q = vec![c64::new(0.0, 0.0); n];
    for k in (0..n).rev() {
        q[k] = rest[k + b.len() - 1];
        for (j, y) in b.iter().enumerate() {
            let taken = q[k] * y;
            rest[k + j] -= taken;
        }
    }
    q
}

/// The roots of a polynomial of leading coefficient 1, all at once by the method of Weierstrass, from near `guess`.
pub(super) fn roots(p: &[c64], guess: &[c64]) -> Vec<c64> {
    let value = |z: c64| p.iter().rev().fold(c64::new(0.0, 0.0), |sum, c| sum * z + c);
    // Guesses apart from each other and off any symmetry.
    let mut z: Vec<c64> = guess.iter().enumerate().map(|(k, g)| g + c64::from_polar(1e-3, 0.4 + k as f64)).collect();
    for _ in 0..ROUNDS {
        for k in 0..z.len() {
            let others = (0..z.len()).filter(|&j| j != k).map(|j| z[k] - z[j]);
            let apart = others.fold(c64::new(1.0, 0.0), |a, b| a * b);
            if apart.norm() > 1e-30 {
                let step = value(z[k]) / apart;
                z[k] -= step;
            }
        }
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn c(re: f64, im: f64) -> c64 {
        c64::new(re, im)
    }

    #[test]
    fn roots_products_and_quotients_agree() {
        let known = [c(0.3, -0.2), c(-0.5, 0.1), c(0.0, 0.7)];
        let p = known.iter().fold(vec![c(1.0, 0.0)], |p, root| product(&p, &[-root, c(1.0, 0.0)]));
        let found = roots(&p, &[c(0.0, 0.0); 3]);
        for root in known {
            assert!(found.iter().any(|z| (z - root).norm() < 1e-9), "{found:?}");
        }
        let q = quotient(&product(&p, &p), &p);
        assert!(q.iter().zip(&p).all(|(a, b)| (a - b).norm() < 1e-12) && q.len() == p.len());
    }

    #[test]
    fn a_polynomial_is_found_from_its_values() {
        let p = [c(1.0, 2.0), c(-0.5, 0.0), c(0.0, 3.0)];
        let rows: Vec<_> = (0..20)
            .map(|k| {
                let z = c64::from_polar(0.3 + 0.03 * f64::from(k), 1.7 * f64::from(k));
                (z, p[0] + p[1] * z + p[2] * z * z, 1.0 + f64::from(k))
            })
            .collect();
        let found = fitted(&rows, 3).unwrap();
        assert!(found.iter().zip(&p).all(|(a, b)| (a - b).norm() < 1e-10), "{found:?}");
        assert!(fitted(&rows[..2], 3).is_none());
    }
}
