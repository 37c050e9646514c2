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
    /// The symmetric block of the integers, n × n: where an integer moves much of the map, nearly full.
    pub(super) qq: Vec<f64>,
    pub(super) b_z: Vec<f64>,
    pub(super) b_q: Vec<f64>,
}

impl Reduced {
    /// Substitutes the forms into the raw quadratic form. Of each pair of coupled unknowns the one with the longer form
    /// takes the other's into one sum: time and memory stay linear in the lengths where translations hang on hundreds
    /// of integers.
    pub(super) fn new(raw: &Quadratic, unknowns: &Unknowns) -> Self {
        let (nz, nq) = (unknowns.n_continuous, unknowns.n_integers);
        let mut r = Self {
            zz: Vec::with_capacity(raw.lower.len()),
            zq: vec![Vec::new(); nq],
            qq: vec![0.0; nq * nq],
            b_z: vec![0.0; nz],
            b_q: vec![0.0; nq],
        };
        let length = |x: u32| unknowns.forms[x as usize].len();
        let mut coupled = merge(&raw.lower);
        for (i, j, value) in &mut coupled {
            match *i == *j {
                true => *value *= 0.5,
                false if length(*i) > length(*j) => std::mem::swap(i, j),
                false => {}
            }
        }
        let coupled = by_column(unknowns.forms.len(), &coupled);
        for group in coupled.chunk_by(|a, b| a.1 == b.1) {
            let mut sum: Vec<(u32, f64)> = Vec::new();
            for &(other, _, value) in group {
                sum.extend(unknowns.forms[other as usize].iter().map(|&(x, c)| (x, c * value)));
            }
            r.add(unknowns, &unknowns.forms[group[0].1 as usize], &merge_column(sum));
        }
        for i in 0..nq {
            for j in 0..=i {
                let both = r.qq[i * nq + j] + r.qq[j * nq + i];
                (r.qq[i * nq + j], r.qq[j * nq + i]) = (both, both);
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

    /// Adds `f gᵀ + g fᵀ` for two forms; of the block of integers only one of the two.
    fn add(&mut self, unknowns: &Unknowns, f: &[(u32, f64)], g: &[(u32, f64)]) {
        let nq = self.zq.len();
        let placed = g.iter().map(|&(x, c)| (unknowns.place[x as usize], c)).collect::<Vec<_>>();
        for &(x, a) in f {
            match unknowns.place[x as usize] {
                Place::Continuous(i) => {
                    for &(place, c) in &placed {
                        match place {
                            Place::Continuous(j) if i == j => self.zz.push((i, i, 2.0 * a * c)),
                            Place::Continuous(j) => self.zz.push((i.max(j), i.min(j), a * c)),
                            Place::Integer(j) => self.zq[j as usize].push((i, a * c)),
                            Place::Removed => {}
                        }
                    }
                }
                Place::Integer(i) => {
                    let row = &mut self.qq[i as usize * nq..][..nq];
                    for &(place, c) in &placed {
                        match place {
                            Place::Continuous(j) => self.zq[i as usize].push((j, a * c)),
                            Place::Integer(j) => row[j as usize] += a * c,
                            Place::Removed => {}
                        }
                    }
                }
                Place::Removed => {}
            }
        }
    }

    /// Factors the continuous block.
    pub(super) fn factor(&self) -> Result<Cholesky<f64>, SolveError> {
        Cholesky::new(&HermitianMatrix::from_lower(self.b_z.len(), &self.zz))
    }

    /// Real optimum of the integers for scale 1 without the period matrix: one more factorisation, of all unknowns.
    pub(super) fn optimum(&self) -> Result<Vec<f64>, SolveError> {
        let (nz, nq) = (self.b_z.len(), self.b_q.len());
        let mut entries = self.zz.clone();
        for (j, column) in self.zq.iter().enumerate() {
            entries.extend(column.iter().map(|&(i, v)| ((nz + j) as u32, i, v)));
            let row = self.qq[j * nq..][..=j].iter().enumerate();
            entries.extend(row.filter(|(_, v)| **v != 0.0).map(|(i, &v)| ((nz + j) as u32, (nz + i) as u32, v)));
        }
        let mut all = [self.b_z.as_slice(), &self.b_q].concat();
        Cholesky::new(&HermitianMatrix::from_lower(nz + nq, &entries))?.solve(&mut all);
        Ok(all.split_off(nz))
    }

    /// The energy of unknowns at this scale, up to a constant.
    pub(super) fn energy(&self, scale: f64, z: &[f64], q: &[f64]) -> f64 {
        let both = |(i, j, v): &(u32, u32, f64)| if i == j { *v } else { 2.0 * v } * z[*i as usize] * z[*j as usize];
        let zz: f64 = self.zz.iter().map(both).sum();
        let column =
            |(column, q): (&Vec<(u32, f64)>, &f64)| q * column.iter().map(|&(i, v)| v * z[i as usize]).sum::<f64>();
        let zq: f64 = self.zq.iter().zip(q).map(column).sum();
        let qq: f64 = self.qq.chunks(q.len().max(1)).zip(q).map(|(row, x)| x * dot(row, q)).sum();
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
