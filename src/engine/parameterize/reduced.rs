//! The quadratic form in the unknowns that are left after all linear relations are eliminated, split into continuous
//! unknowns and integers.

use crate::engine::numerics::Cholesky;
use crate::engine::numerics::HermitianMatrix;
use crate::engine::numerics::SolveError;
use crate::engine::numerics::by_column;
use crate::engine::parameterize::elimination::RealForm;
use crate::engine::parameterize::poisson::Quadratic;

/// Which free unknowns there are and where they stand in the two blocks.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// Every raw real unknown as a form in free raw unknowns.
    pub(super) forms: Vec<RealForm>,
    /// Per raw unknown, its position in the continuous block or the integer block, if it is free.
    pub(super) place: Vec<Place>,
    pub(super) n_continuous: usize,
    pub(super) n_integers: usize,
}

/// Where a raw unknown went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Expressed through others.
    Removed,
    /// Free, any real value.
    Continuous(u32),
    /// Free, must be an integer.
    Integer(u32),
}

impl Unknowns {
    /// Splits the free unknowns by whether they must be integers.
    pub(super) fn new(forms: Vec<RealForm>, is_integer: &[bool]) -> Self {
        let (mut n_continuous, mut n_integers) = (0, 0);
        let place = (0..forms.len())
            .map(|x| {
                if forms[x].as_slice() != [(x as u32, 1.0)] {
                    Place::Removed
                } else if is_integer[x] {
                    n_integers += 1;
                    Place::Integer(n_integers - 1)
                } else {
                    n_continuous += 1;
                    Place::Continuous(n_continuous - 1)
                }
            })
            .collect();
        Self { forms, place, n_continuous: n_continuous as usize, n_integers: n_integers as usize }
    }

    /// The same unknowns with integers that may take any real value: they come after the others.
    pub(super) fn relaxed(&self) -> Self {
        let mut relaxed = self.clone();
        for place in &mut relaxed.place {
            if let Place::Integer(i) = *place {
                *place = Place::Continuous(self.n_continuous as u32 + i);
            }
        }
        (relaxed.n_continuous, relaxed.n_integers) = (self.n_continuous + self.n_integers, 0);
        relaxed
    }

    /// All raw unknowns from the values of the two blocks.
    pub(super) fn expand(&self, z: &[f64], q: &[f64]) -> Vec<f64> {
        let value = |x: u32| match self.place[x as usize] {
            Place::Continuous(i) => z[i as usize],
            Place::Integer(i) => q[i as usize],
            Place::Removed => 0.0,
        };
        self.forms.iter().map(|form| form.iter().map(|&(x, c)| c * value(x)).sum()).collect()
    }
}

/// `xᵀ L x − 2 bᵀ x` in blocks: continuous unknowns z, integers q.
#[derive(Clone, Debug)]
pub(super) struct Reduced {
    pub(super) zz: Vec<(u32, u32, f64)>,
    /// Per integer, its column of couplings to continuous unknowns, sorted.
    pub(super) zq: Vec<Vec<(u32, f64)>>,
    /// Entries of the full symmetric block, repeated ones to be summed.
    pub(super) qq: Vec<(u32, u32, f64)>,
    pub(super) b_z: Vec<f64>,
    pub(super) b_q: Vec<f64>,
}

impl Reduced {
    /// Substitutes the forms into the raw quadratic form.
    pub(super) fn new(raw: &Quadratic, unknowns: &Unknowns) -> Self {
        let (nz, nq) = (unknowns.n_continuous, unknowns.n_integers);
        let mut r = Self {
            zz: Vec::with_capacity(raw.lower.len()),
            zq: vec![Vec::new(); nq],
            qq: Vec::new(),
            b_z: vec![0.0; nz],
            b_q: vec![0.0; nq],
        };
        let merged = merge(&raw.lower);
        for &(i, j, value) in &merged {
            for &(a, ca) in &unknowns.forms[i as usize] {
                for &(b, cb) in &unknowns.forms[j as usize] {
                    let v = value * ca * cb;
                    r.add(unknowns.place[a as usize], unknowns.place[b as usize], v);
                    if i != j {
                        r.add(unknowns.place[b as usize], unknowns.place[a as usize], v);
                    }
                }
            }
        }
        for column in &mut r.zq {
            *column = merge_column(std::mem::take(column));
        }
        for (x, &b) in raw.b.iter().enumerate() {
            for &(a, c) in &unknowns.forms[x] {
                match unknowns.place[a as usize] {
                    Place::Continuous(i) => r.b_z[i as usize] += b * c,
                    Place::Integer(i) => r.b_q[i as usize] += b * c,
                    Place::Removed => {}
                }
            }
        }
        r
    }

    /// One entry of the full symmetric matrix.
    fn add(&mut self, row: Place, column: Place, v: f64) {
        match (row, column) {
            (Place::Continuous(i), Place::Continuous(j)) if i >= j => self.zz.push((i, j, v)),
            (Place::Continuous(i), Place::Integer(j)) => self.zq[j as usize].push((i, v)),
            (Place::Integer(i), Place::Integer(j)) => self.qq.push((i, j, v)),
            _ => {}
        }
    }

    /// Factors the continuous block.
    pub(super) fn factor(&self) -> Result<Cholesky<f64>, SolveError> {
        Cholesky::new(&HermitianMatrix::from_lower(self.b_z.len(), &self.zz))
    }

    /// Factors the continuous block of the same unknowns with other weights.
    pub(super) fn factor_like(&self, factor: &Cholesky<f64>) -> Result<Cholesky<f64>, SolveError> {
        factor.refactor(&HermitianMatrix::from_lower(self.b_z.len(), &self.zz))
    }

    /// The energy of unknowns at this scale, up to a constant.
    pub(super) fn energy(&self, scale: f64, z: &[f64], q: &[f64]) -> f64 {
        let both = |(i, j, v): &(u32, u32, f64)| if i == j { *v } else { 2.0 * v } * z[*i as usize] * z[*j as usize];
        let zz: f64 = self.zz.iter().map(both).sum();
        let column =
            |(column, q): (&Vec<(u32, f64)>, &f64)| q * column.iter().map(|&(i, v)| v * z[i as usize]).sum::<f64>();
        let zq: f64 = self.zq.iter().zip(q).map(column).sum();
        let qq: f64 = self.qq.iter().map(|&(i, j, v)| v * q[i as usize] * q[j as usize]).sum();
        zz + 2.0 * zq + qq - 2.0 * scale * (dot(&self.b_z, z) + dot(&self.b_q, q))
    }

    /// The best continuous unknowns for given integers: `L_zz z = scale · b_z − L_zq q`.
    pub(super) fn solve_continuous(&self, factor: &Cholesky<f64>, scale: f64, q: &[f64]) -> Vec<f64> {
        let mut z: Vec<f64> = self.b_z.iter().map(|b| scale * b).collect();
        for (column, &q) in self.zq.iter().zip(q) {
            for &(i, v) in column {
                z[i as usize] -= v * q;
            }
        }
        factor.solve(&mut z);
        z
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Sums entries at the same place.
fn merge(entries: &[(u32, u32, f64)]) -> Vec<(u32, u32, f64)> {
    let n = entries.iter().map(|&(_, c, _)| c as usize + 1).max().unwrap_or(0);
    let sorted = by_column(n, entries);
    let mut merged: Vec<(u32, u32, f64)> = Vec::with_capacity(sorted.len() / 2);
    for (r, c, v) in sorted {
        match merged.last_mut() {
            Some(last) if (last.0, last.1) == (r, c) => last.2 += v,
            _ => merged.push((r, c, v)),
        }
    }
    merged
}

fn merge_column(mut column: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    column.sort_by_key(|&(i, _)| i);
    let mut merged: Vec<(u32, f64)> = Vec::with_capacity(column.len());
    for (i, v) in column {
        match merged.last_mut() {
            Some(last) if last.0 == i => last.1 += v,
            _ => merged.push((i, v)),
        }
    }
    merged
}
