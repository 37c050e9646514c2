//! The integers of the map from the extents of the decimated triangles.

use std::collections::VecDeque;

use glam::I64Vec2;

use crate::engine::mesh::{NONE, next};
use crate::engine::parameterize::corner_forms::real_parts;
use crate::engine::parameterize::elimination::Elimination;
use crate::engine::parameterize::quantise::complex::Complex;
use crate::engine::parameterize::reduced::Place;
use crate::engine::parameterize::separation::Elements;
use crate::engine::run::{Cancelled, RunContext};

/// Constants are carried as multiples of an unknown that stands for this many units: their coefficients are then never
/// ±1, so it is never expressed through others, and stay exact.
const UNIT: f64 = 1.0 / (1 << 20) as f64;

/// Integers of the map with which every edge has its extents; `None` if the extents contradict the map or leave integers
/// open. Triangles are developed one from the next, those in the same chart first, so that nearly every relation has one
/// open unknown. Near linear.
pub(super) fn recover(
    ctx: &RunContext,
    elements: &Elements<'_>,
    complex: &Complex,
    along: &[I64Vec2],
) -> Result<Option<Vec<f64>>, Cancelled> {
    let Elements { forms, unknowns, .. } = *elements;
    let n_raw = 2 * forms.n_unknowns;
    let constant = n_raw as u32;
    let mut rank = vec![0; n_raw];
    rank.push(u8::MAX);
    let mut elimination = Elimination::new(rank);
    for x in (0..n_raw).filter(|&x| unknowns.forms[x].is_empty()) {
        elimination.add(&[(x as u32, 1.0)]);
    }
    let order = in_order(complex);
    for (count, &h) in order.iter().enumerate() {
        if count % 1024 == 0 {
            ctx.check()?;
            ctx.advance(count as f64 / order.len() as f64);
        }
        let [from, to] = [h, next(h)].map(|h| real_parts(&complex.corner[h].form));
        for c in 0..2 {
            let mut relation = to[c].clone();
            relation.extend(from[c].iter().map(|&(x, d)| (x, -d)));
            relation.push((constant, -(along[h][c] as f64) * UNIT));
            let rest = elimination.resolve(&relation);
            if let [(x, _)] = rest[..]
                && x == constant
            {
                return Ok(None);
            }
            elimination.add(&rest);
        }
    }
    for closure in &forms.closures {
        for part in real_parts(closure) {
            elimination.add(&part);
        }
    }
    let mut q = vec![f64::NAN; unknowns.n_integers];
    for (x, place) in unknowns.place.iter().enumerate() {
        let Place::Integer(i) = *place else { continue };
        q[i as usize] = match elimination.resolve(&[(x as u32, 1.0)])[..] {
            [] => 0.0,
            [(y, c)] if y == constant => c / UNIT,
            _ => return Ok(None),
        };
    }
    Ok(q.iter().all(|q| (q - q.round()).abs() < 1e-9).then_some(q))
}

/// Two halfedges of every triangle: one triangle after the other over edges, those between equal charts first.
fn in_order(complex: &Complex) -> Vec<usize> {
    let mut order = Vec::new();
    let mut reached = complex.gone.clone();
    let mut queue: VecDeque<usize> = VecDeque::new();
    for seed in 0..reached.len() {
        queue.push_back(seed);
        while let Some(f) = queue.pop_front() {
            if std::mem::replace(&mut reached[f], true) {
                continue;
            }
            order.extend([3 * f, 3 * f + 1]);
            for h in 3 * f..3 * f + 3 {
                let t = complex.twin[h];
                if t == NONE || reached[t as usize / 3] {
                    continue;
                }
                match complex.across[h].shift.form.is_empty() {
                    true => queue.push_front(t as usize / 3),
                    false => queue.push_back(t as usize / 3),
                }
            }
        }
    }
    order
}
