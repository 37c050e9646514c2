//! Zeros that the triangles or the quads cannot tell apart become double zeros.
//!
//! Two branch points that come together leave none: the sheets are no longer exchanged between them, and the harmonic form has
//! a double zero nearby, wherever it wants it. A harmonic form has no poles at vertices that are no branch points.

use crate::engine::calculus::{CalculusError, Stars};
use crate::engine::mesh::{TriMesh, prev};
use crate::engine::methods::holomorphic::differential::{Differential, Solver, index};
use crate::engine::run::RunContext;

/// Vertices around a branch point among which another one is looked for.
const MOST_LOOKED_AT: usize = 1000;
/// Rounds at most: each leaves fewer branch points.
const ROUNDS: usize = 6;
/// Heights are of order 1: a sum of them that should vanish is below this.
const SAME_LEVEL: f64 = 1e-9;

/// Merges branch points with the nearest one where either is a pole, or v rises by less than `least` (in units of the
/// heights) from one to the other. Only those on the same level of u can be merged.
///
/// # Errors
/// A stop, or a failed solve.
pub(super) fn merge_near(
    ctx: &RunContext,
    mesh: &TriMesh,
    stars: &Stars,
    mut differential: Differential,
    least: f64,
) -> Result<Differential, CalculusError> {
    let mut solver = Solver::new(mesh, stars);
    for _ in 0..ROUNDS {
        ctx.check()?;
        let mut branch = differential.foliation.signs.branch_points(mesh);
        let is_pole = |v: u32| index(mesh, &differential.foliation, &differential.form, v) > 0;
        // Poles first: they have the least to lose.
        branch.sort_by_key(|&p| (!is_pole(p), p));
        let mut foliation = differential.foliation.clone();
        let mut is_left = vec![true; branch.len()];
        let mut merged = 0;
        for (k, &p) in branch.iter().enumerate() {
            if !is_left[k] {
                continue;
            }
            let free: Vec<u32> = (0..branch.len()).filter(|&j| j != k && is_left[j]).map(|j| branch[j]).collect();
            let Some(path) = nearest(mesh, p, &free, &branch) else { continue };
            let Some(&last) = path.last() else { continue };
            let q = mesh.target(last);
            let gap: f64 = path.iter().map(|&h| rise_of_v(mesh, &differential, h)).sum();
            if !(is_pole(p) || is_pole(q) || gap < least) {
                continue;
            }
            let mut moved = foliation.clone();
            path[..path.len() - 1].iter().for_each(|&h| moved.drag(mesh, h));
            if moved.form.along[last].abs() > SAME_LEVEL {
                continue;
            }
            moved.form.set(mesh, &moved.signs.clone(), last, 0.0);
            moved.signs.turn(mesh, last);
            foliation = moved;
            is_left[k] = false;
            branch.iter().zip(&mut is_left).filter(|(v, _)| **v == q).for_each(|(_, left)| *left = false);
            merged += 1;
        }
        if merged == 0 {
            break;
        }
        let form = solver.solve(&foliation)?;
        differential = Differential { foliation, form, solves: differential.solves + 1 };
    }
    Ok(differential)
}

/// Halfedges from `p` to the nearest of `targets`, over no vertex of `branch`.
fn nearest(mesh: &TriMesh, p: u32, targets: &[u32], branch: &[u32]) -> Option<Vec<usize>> {
    // Vertices with the number of the one before and the halfedge from there.
    let mut reached: Vec<(u32, usize, usize)> = vec![(p, 0, 0)];
    let mut at = 0;
    while at < reached.len().min(MOST_LOOKED_AT) {
        let v = reached[at].0;
        for h in mesh.fan(v) {
            let w = mesh.target(h);
            if reached.iter().any(|r| r.0 == w) {
                continue;
            }
            if targets.contains(&w) {
                let mut path = vec![h];
                let mut back = at;
                while back != 0 {
                    path.push(reached[back].2);
                    back = reached[back].1;
                }
                path.reverse();
                return Some(path);
            }
            if !branch.contains(&w) {
                reached.push((w, at, h));
            }
        }
        at += 1;
    }
    None
}

/// By how much v rises along an edge, whichever way: the mean of the star of du on both sides.
fn rise_of_v(mesh: &TriMesh, differential: &Differential, h: usize) -> f64 {
    let along = &differential.form.along;
    let of = |h: usize| {
        // The gradient turned by a quarter, times the edge.
        let f = h / 3;
        let e = |h: usize| mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
        let (a, b) = (e(h), -e(prev(h)));
        let twice = mesh.area_vector(f).length().max(f64::MIN_POSITIVE);
        (a.dot(b) * along[h] + a.length_squared() * along[prev(h)]).abs() / twice
    };
    let sides = [Some(h), mesh.twin(h)];
    let n = sides.iter().flatten().count().max(1) as f64;
    sides.into_iter().flatten().map(of).sum::<f64>() / n
}
