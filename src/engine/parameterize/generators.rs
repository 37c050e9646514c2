//! The basis in which the thesis rounds: translations between neighbouring branch points, along a shortest cut graph
//! through all of them (`[kaelberer_2013]` section 4.2.2 and 6.3).

use crate::engine::parameterize::corner_forms::CornerForms;
use crate::engine::parameterize::elimination::{Elimination, RealForm};
use crate::engine::parameterize::reduced::{Place, Unknowns};
use crate::engine::parameterize::rounding::Basis;
use crate::engine::topology::CutGraph;

/// A basis of the integers whose coordinates are the translations of the cut graph's segments, those of points of odd
/// index in the lattice of (1, 1) and (−1, 1): shortest segments first, each is taken that leaves a basis possible.
/// Integers that no translation fixes stay themselves. `cost` is the length of
/// the path between singularities that each segment is a part of, 0 for parts of several, which come last. O(n³).
pub(super) fn generators(cut: &CutGraph, forms: &CornerForms, unknowns: &Unknowns, cost: &[f64]) -> Basis {
    let n = unknowns.n_integers;
    let mut order: Vec<usize> = (0..cut.segments.len()).collect();
    order.sort_by(|&a, &b| (cost[a] == 0.0).cmp(&(cost[b] == 0.0)).then(cost[a].total_cmp(&cost[b])).then(a.cmp(&b)));
    let found = order.into_iter().flat_map(|k| {
        let u = 2 * (forms.n_vertices + k) as u32;
        let candidates: [RealForm; 4] =
            [vec![(u, 1.0), (u + 1, 1.0)], vec![(u, -1.0), (u + 1, 1.0)], vec![(u, 1.0)], vec![(u + 1, 1.0)]];
        candidates.into_iter().filter_map(|form| primitive(integer_form(unknowns, &form)?))
    });
    // Unknowns n + j are the coordinates: eliminating the integers expresses them by coordinates.
    let mut elimination = Elimination::new((0..2 * n).map(|x| u8::from(x >= n)).collect());
    let mut coordinates: Vec<Vec<(u32, f64)>> = Vec::with_capacity(n);
    let units = (0..n as u32).map(|i| vec![(i, 1.0)]);
    for form in found.chain(units) {
        let is_primitive = elimination.resolve(&form).iter().any(|&(x, c)| (x as usize) < n && c.abs() == 1.0);
        if coordinates.len() < n && is_primitive {
            let mut relation = form.clone();
            relation.push(((n + coordinates.len()) as u32, -1.0));
            elimination.add(&relation);
            coordinates.push(form);
        }
    }
    let mut integers = elimination.finish();
    integers.truncate(n);
    integers.iter_mut().for_each(|form| form.iter_mut().for_each(|(x, _)| *x -= n as u32));
    Basis::from_forms(&integers, &coordinates)
}

/// The form over integers; `None` if it needs others.
fn integer_form(unknowns: &Unknowns, raw: &[(u32, f64)]) -> Option<RealForm> {
    let mut sum = RealForm::new();
    for &(x, c) in raw {
        for &(y, d) in &unknowns.forms[x as usize] {
            let Place::Integer(i) = unknowns.place[y as usize] else { return None };
            match sum.iter_mut().find(|t| t.0 == i) {
                Some(t) => t.1 += c * d,
                None => sum.push((i, c * d)),
            }
        }
    }
    sum.retain(|t| t.1 != 0.0);
    Some(sum)
}

/// The form divided by the greatest common divisor of its coefficients; `None` if they are no integers.
fn primitive(mut form: RealForm) -> Option<RealForm> {
    let mut divisor = 0.0_f64;
    for &(_, c) in &form {
        let mut rest = c.abs();
        while rest > 0.0 {
            (divisor, rest) = (rest, divisor % rest);
        }
    }
    form.iter_mut().for_each(|t| t.1 /= divisor);
    (divisor >= 0.5).then_some(form)
}
