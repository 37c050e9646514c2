//! Quads with a straight or reflex corner become five: a smaller quad inside, and one along each side.

use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::repair::STRAIGHT;
use crate::engine::quad::improve::repair::is_turned_over;
use crate::engine::quad::improve::turning::{Pair, Turning};
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::corner_jacobians;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::quality;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Corners with a smaller scaled Jacobian are split close to the corner, so that the inner quad bulges towards them.
const FLAT: f64 = 0.3;
/// How far towards the middle the inner corners are put, at flat corners and at the others.
const NEAR: [f64; 4] = [0.08, 0.15, 0.25, 0.35];
const INNER: [f64; 4] = [0.3, 0.4, 0.5, 0.65];
/// The search for better inner corners: sweeps, how sharply the worst corner counts, and the first step as a part of the
/// longest side.
const SWEEPS: usize = 60;
const SHARPNESS: f64 = 40.0;
const FIRST_STEP: f64 = 0.1;
/// Least scaled Jacobian of the five parts.
const ACCEPTED: f64 = 0.005;
/// More such quads than this part of all are no single faults.
const MOST: f64 = 0.02;

/// Splits every quad that has a straight or reflex corner and whose five parts have none. Where all four corners are
/// held by curves or corners of features no motion can help, but the angle at each corner can be shared by two quads.
///
/// Nothing that was there moves, so topology, curves and corners stay as they are. Returns `None` if nothing was split.
/// `index` is the one of `surface.mesh`.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn pillow_quads(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: &QuadDraft,
) -> Result<Option<QuadDraft>, Cancelled> {
    if !is_sound(surface, draft) {
        return Ok(None);
    }
    let corners = |quad: &[u32; 4]| quad.map(|v| draft.mesh.positions[v as usize]);
    let straight: Vec<usize> = (0..draft.mesh.quads.len())
        .filter(|&q| {
            let p = corners(&draft.mesh.quads[q]);
            quality(&p, area_vector(&p).normalize_or_zero()) < STRAIGHT
        })
        .collect();
    if straight.len() > 20.max((MOST * draft.mesh.quads.len() as f64) as usize) {
        return Ok(None);
    }
    let mut split = draft.clone();
    let turning = Turning::new(draft);
    let mut is_taken = vec![false; draft.mesh.quads.len()];
    let mut stubborn = Vec::new();
    for &q in &straight {
        ctx.check()?;
        match inner_quad(index, &corners(&draft.mesh.quads[q])) {
            Some(inner) => put(&mut split, q, inner),
            None => stubborn.push(q),
        }
        is_taken[q] = true;
    }
    // Where no vertex is free and all lie on one line only the neighbour has room. Quads around a turned edge keep out
    // of each other's way.
    let mut is_used = vec![false; draft.mesh.positions.len()];
    for q in stubborn {
        ctx.check()?;
        let is_free =
            |&(other, pair): &(usize, Pair)| !is_taken[other] && pair.iter().flatten().all(|&v| !is_used[v as usize]);
        let rated = turning.ways(q).into_iter().filter(is_free).filter_map(|(other, pair)| {
            let inner = pair.map(|quad| whole_or_split(index, &corners(&quad)));
            let [Some(first), Some(second)] = inner else { return None };
            Some((first.0.min(second.0), other, pair, [first.1, second.1]))
        });
        let Some((_, other, pair, inner)) = rated.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        for ((q, quad), inner) in [q, other].into_iter().zip(pair).zip(inner) {
            is_taken[q] = true;
            quad.iter().for_each(|&v| is_used[v as usize] = true);
            split.mesh.quads[q] = quad;
            if let Some(inner) = inner {
                put(&mut split, q, inner);
            }
        }
    }
    Ok((split != *draft).then_some(split))
}

/// Makes five quads of one.
fn put(split: &mut QuadDraft, q: usize, inner: [DVec3; 4]) {
    let quad = split.mesh.quads[q];
    let first = split.mesh.positions.len() as u32;
    split.mesh.positions.extend(inner);
    split.anchors.extend([Anchor::Surface; 4]);
    let new = [first, first + 1, first + 2, first + 3];
    split.mesh.quads[q] = new;
    split.mesh.quads.extend((0..4).map(|k| [quad[k], quad[(k + 1) % 4], new[(k + 1) % 4], new[k]]));
}

/// The worst corner of a quad, or else of its five parts with the inner corners; `None` if none of the two will do.
fn whole_or_split(index: &SurfaceIndex, p: &[DVec3; 4]) -> Option<(f64, Option<[DVec3; 4]>)> {
    let up = area_vector(p).try_normalize()?;
    let whole = quality(p, up);
    if whole >= STRAIGHT && !is_turned_over(index, p) {
        return Some((whole, None));
    }
    let inner = inner_quad(index, p)?;
    Some((least(p, &inner, up), Some(inner)))
}

/// The corners of the best inner quad, in the surface if that is no worse; `None` if one of the five parts would have a
/// straight corner again.
fn inner_quad(index: &SurfaceIndex, p: &[DVec3; 4]) -> Option<[DVec3; 4]> {
    let up = area_vector(p).try_normalize()?;
    let jacobians = corner_jacobians(p, up);
    let mut best = (f64::NEG_INFINITY, *p);
    for middle in middles(p) {
        for near in NEAR {
            for inner in INNER {
                let at = |k: usize| p[k].lerp(middle, if jacobians[k] < FLAT { near } else { inner });
                let free: [DVec3; 4] = std::array::from_fn(at);
                let worst = least(p, &free, up);
                if worst > best.0 {
                    best = (worst, free);
                }
            }
        }
    }
    let (mut worst, mut free) = best;
    if worst < STRAIGHT {
        free = searched(p, free, up);
        worst = least(p, &free, up);
    }
    if worst < ACCEPTED {
        return None;
    }
    let drawn = free.map(|c| index.closest(c).position);
    let inner = if least(p, &drawn, up) >= ACCEPTED.max(0.5 * worst) { drawn } else { free };
    parts(p, &inner).iter().all(|part| !is_turned_over(index, part)).then_some(inner)
}

/// Moves the inner corners one by one, across `up`, as long as the worst corners of the five parts become better.
fn searched(p: &[DVec3; 4], start: [DVec3; 4], up: DVec3) -> [DVec3; 4] {
    let along = up.any_orthonormal_vector();
    let directions = [along, -along, up.cross(along), -up.cross(along)];
    let cost = |inner: &[DVec3; 4]| {
        let corners = parts(p, inner).into_iter().flat_map(|part| corner_jacobians(&part, up));
        corners.map(|jacobian| (-SHARPNESS * jacobian).exp()).sum::<f64>()
    };
    let mut step = FIRST_STEP * (0..4).map(|k| p[k].distance(p[(k + 1) % 4])).fold(0.0, f64::max);
    let mut best = (cost(&start), start);
    for _ in 0..SWEEPS {
        let before = best.0;
        for (k, direction) in (0..4).flat_map(|k| directions.map(|direction| (k, direction))) {
            let mut moved = best.1;
            moved[k] += step * direction;
            let cost = cost(&moved);
            if cost < best.0 {
                best = (cost, moved);
            }
        }
        if best.0 >= before {
            step *= 0.5;
        }
    }
    best.1
}

/// Places from which all four sides may be seen.
fn middles(p: &[DVec3; 4]) -> impl Iterator<Item = DVec3> {
    let sum = p.iter().sum::<DVec3>();
    let thirds = p.map(|c| (sum - c) / 3.0);
    let diagonals = [0, 1].map(|k| 0.5 * (p[k] + p[k + 2]));
    [0.25 * sum].into_iter().chain(thirds).chain(diagonals)
}

/// The five quads that a quad becomes with this inner one, that first.
fn parts(p: &[DVec3; 4], inner: &[DVec3; 4]) -> [[DVec3; 4]; 5] {
    let side = |k: usize| [p[k], p[(k + 1) % 4], inner[(k + 1) % 4], inner[k]];
    [*inner, side(0), side(1), side(2), side(3)]
}

/// The worst corner of the five parts, against `up`.
fn least(p: &[DVec3; 4], inner: &[DVec3; 4], up: DVec3) -> f64 {
    parts(p, inner).iter().map(|part| quality(part, up)).fold(f64::INFINITY, f64::min)
}
