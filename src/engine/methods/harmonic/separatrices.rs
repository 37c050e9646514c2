//! A singularity graph from a seamless map: from every singular vertex and every corner of features or boundary the
//! coordinate lines run at equal speed until they meet a line (a motorcycle graph). They are cut into the mesh as they run.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::regions::Regions;
use crate::engine::parameterize::{Iso, rotate};
use crate::engine::run::RunContext;

/// The line of all features and boundaries.
const BORDER: u32 = NONE - 1;
/// A line that meets an edge nearer to its end than this share of it goes through that vertex, if it can be moved there in
/// the map: triangles stay well shaped.
const SNAP: f64 = 0.2;
/// A direction this near to an edge, in radians, runs along it: coordinates are exact to about 1e-12 of the surface.
const STRAIGHT: f64 = 1e-9;
/// Steps per face of the mesh before lines are taken not to end.
const MOST_STEPS: usize = 8;
/// Base points at most: a disc needs none, every handle and boundary loop a few.
const MOST_BASES: usize = 200;
const AXES: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];

/// A line on its way.
#[derive(Clone, Copy, Debug)]
struct Start {
    corner: usize,
    direction: DVec2,
}

/// Where a direction leads from a vertex.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Along the edge that leaves the corner.
    Along(usize),
    /// Into the face of the corner.
    Into(usize, DVec2),
}

/// Cuts the lines of all special vertices into the mesh, and more where that leaves no discs. `is_special` is per vertex, and
/// gets the base points of these as well.
pub(super) fn cut_separatrices(
    ctx: &RunContext,
    cut: &mut CutMesh,
    is_special: &mut Vec<bool>,
) -> Result<(), HarmonicError> {
    for h in 0..3 * cut.n_faces() {
        if cut.twin(h).is_none() || cut.map.iso[h] != Iso::None {
            cut.mark(h, BORDER);
        }
    }
    let starts =
        (0..cut.n_vertices() as u32).filter(|&v| is_special[v as usize]).flat_map(|v| starts_at(cut, v)).collect();
    let mut n_lines = 0;
    run(ctx, cut, is_special, starts, &mut n_lines)?;
    for _ in 0..MOST_BASES {
        ctx.check()?;
        let regions = Regions::new(cut);
        let Some(open) = regions.first_open() else { return Ok(()) };
        let Some((f, z)) = base_point(cut, &regions, open) else {
            return Err(HarmonicError::NotDisc { face: open });
        };
        let base = cut.split_face(f, [1.0 / 3.0; 3], z);
        is_special.resize(cut.n_vertices(), false);
        is_special[base as usize] = true;
        let more = starts_at(cut, base);
        run(ctx, cut, is_special, more, &mut n_lines)?;
    }
    Err(HarmonicError::Endless)
}

/// The directions in which lines leave a special vertex.
fn starts_at(cut: &CutMesh, v: u32) -> Vec<Start> {
    let mut starts = Vec::new();
    for h in cut.fan(v) {
        for direction in AXES {
            match way(cut, h, direction) {
                Some(Way::Along(h)) if cut.is_line(h) => {}
                Some(_) => starts.push(Start { corner: h, direction }),
                None => {}
            }
        }
    }
    starts
}

/// Whether a direction leads into a face or along its first edge at a corner.
fn way(cut: &CutMesh, corner: usize, direction: DVec2) -> Option<Way> {
    let uv = &cut.map.uv;
    let (first, second) = (uv[next(corner)] - uv[corner], uv[prev(corner)] - uv[corner]);
    let off = first.perp_dot(direction);
    if off.abs() <= STRAIGHT * first.length() && first.dot(direction) > 0.0 {
        return Some(Way::Along(corner));
    }
    let is_before = direction.perp_dot(second) > STRAIGHT * second.length();
    (off > 0.0 && is_before).then_some(Way::Into(corner, direction))
}

/// The first way in this direction (in the chart of the corner) at or after a corner, counter-clockwise.
fn way_from(cut: &CutMesh, corner: usize, direction: DVec2) -> Option<Way> {
    let (mut h, mut direction) = (corner, direction);
    loop {
        if let Some(way) = way(cut, h, direction) {
            return Some(way);
        }
        let p = prev(h);
        direction = rotate(direction, (4 - cut.map.rotation[p]) & 3);
        h = cut.twin(p).filter(|&n| n != corner)?;
    }
}

fn run(
    ctx: &RunContext,
    cut: &mut CutMesh,
    is_special: &[bool],
    starts: Vec<Start>,
    n_lines: &mut u32,
) -> Result<(), HarmonicError> {
    let mut queue: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
    let first = *n_lines;
    let mut tips = Vec::new();
    for start in &starts {
        tips.push(cut.origin(start.corner));
        queue.push(Reverse((0, *n_lines)));
        *n_lines += 1;
    }
    let most = MOST_STEPS * cut.n_faces();
    let mut steps = 0;
    while let Some(Reverse((travelled, id))) = queue.pop() {
        steps += 1;
        if steps > most {
            return Err(HarmonicError::Endless);
        }
        if steps % 1024 == 0 {
            ctx.check()?;
        }
        let i = (id - first) as usize;
        let start = &starts[i];
        let found = match travelled {
            0 => way_from(cut, start.corner, start.direction),
            _ => onwards(cut, tips[i], id),
        };
        let (end, length, goes_on) = step(cut, is_special, found.ok_or(HarmonicError::Fold)?, id);
        tips[i] = end;
        if goes_on {
            queue.push(Reverse(((f64::from_bits(travelled) + length).to_bits(), id)));
        }
    }
    Ok(())
}

/// Straight on from the tip of a line.
fn onwards(cut: &CutMesh, tip: u32, id: u32) -> Option<Way> {
    let fan = cut.fan(tip);
    let back = fan.iter().copied().find(|&h| cut.line[h] == id)?;
    let along = cut.map.uv[next(back)] - cut.map.uv[back];
    let axis = AXES.into_iter().max_by(|a, b| a.dot(along).total_cmp(&b.dot(along)))?;
    way_from(cut, back, -axis)
}

/// One edge of a line: where it ends, how long it is in the map, and whether the line goes on from there.
fn step(cut: &mut CutMesh, is_special: &[bool], way: Way, id: u32) -> (u32, f64, bool) {
    let (corner, direction) = match way {
        Way::Along(h) => return walk(cut, h, cut.origin(h), id),
        Way::Into(corner, direction) => (corner, direction),
    };
    let fix = usize::from(direction.x != 0.0);
    let o = next(corner);
    let (from, a, b) = (cut.map.uv[corner], cut.map.uv[o], cut.map.uv[next(o)]);
    let share = (from[fix] - a[fix]) / (b[fix] - a[fix]);
    let is_line = cut.is_line(o);
    if !is_line && share < SNAP && slide(cut, is_special, o, fix, from[fix]) {
        return walk(cut, corner, cut.origin(corner), id);
    }
    if !is_line && share > 1.0 - SNAP && slide(cut, is_special, next(o), fix, from[fix]) {
        return walk(cut, prev(corner), cut.origin(corner), id);
    }
    let mut z = a.lerp(b, share);
    z[fix] = from[fix];
    let m = cut.split_edge(o, share, z);
    cut.mark(prev(corner), id);
    (m, from.distance(z).max(f64::MIN_POSITIVE), !is_line)
}

/// From the tip of a line along an edge, which leaves the tip or comes to it.
fn walk(cut: &mut CutMesh, h: usize, tip: u32, id: u32) -> (u32, f64, bool) {
    let length = cut.map.uv[h].distance(cut.map.uv[next(h)]);
    let end = if cut.origin(h) == tip { cut.origin(next(h)) } else { cut.origin(h) };
    let goes_on = !cut.is_on_line(end);
    cut.mark(h, id);
    (end, length.max(f64::MIN_POSITIVE), goes_on)
}

/// Moves a vertex in the map onto a coordinate line, if no triangle turns over; `corner` is one of its corners, whose
/// coordinate `fix` becomes `value`. Vertices of a line move along it only, special ones and meeting points not at all.
fn slide(cut: &mut CutMesh, is_special: &[bool], corner: usize, fix: usize, value: f64) -> bool {
    let v = cut.origin(corner);
    if is_special.get(v as usize).copied().unwrap_or(false) {
        return false;
    }
    let charts = quarters_around(cut, corner);
    let mut lines = 0;
    for &(h, quarters) in &charts {
        let p = prev(h);
        let both = [(h, true), (p, cut.twin(p).is_none())];
        for (edge, _) in both.into_iter().filter(|&(edge, counts)| counts && cut.is_line(edge)) {
            let along = rotate(cut.map.uv[next(edge)] - cut.map.uv[edge], (4 - quarters) & 3);
            if along[1 - fix].abs() > STRAIGHT * along.length() {
                return false;
            }
            lines += 1;
        }
    }
    if lines != 0 && lines != 2 {
        return false;
    }
    let before: Vec<(usize, DVec2)> = charts.iter().map(|&(h, _)| (h, cut.map.uv[h])).collect();
    let mut by = DVec2::ZERO;
    by[fix] = value - cut.map.uv[corner][fix];
    for &(h, quarters) in &charts {
        cut.map.uv[h] += rotate(by, quarters);
    }
    cut.map.uv[corner][fix] = value;
    let is_upright = |&(h, _): &(usize, u8)| {
        let uv = &cut.map.uv;
        (uv[next(h)] - uv[h]).perp_dot(uv[prev(h)] - uv[h]) > 0.0
    };
    if charts.iter().all(is_upright) {
        return true;
    }
    before.into_iter().for_each(|(h, z)| cut.map.uv[h] = z);
    false
}

/// The corners around the vertex of a corner, each with the quarter turns from the chart of that corner to its own.
fn quarters_around(cut: &CutMesh, corner: usize) -> Vec<(usize, u8)> {
    let mut around = Vec::new();
    let mut quarters = 0u8;
    let mut at = 0;
    for h in cut.fan(cut.origin(corner)) {
        around.push((h, quarters));
        if h == corner {
            at = quarters;
        }
        quarters = (quarters + 4 - cut.map.rotation[prev(h)]) & 3;
    }
    around.into_iter().map(|(h, quarters)| (h, (quarters + 4 - at) & 3)).collect()
}

/// The middle of the face of a region that is largest in the map, and the point in its chart.
fn base_point(cut: &CutMesh, regions: &Regions, region: u32) -> Option<(usize, DVec2)> {
    let area =
        |f: usize| (cut.map.uv[3 * f + 1] - cut.map.uv[3 * f]).perp_dot(cut.map.uv[3 * f + 2] - cut.map.uv[3 * f]);
    let of_region = (0..cut.n_faces()).filter(|&f| regions.of_face[f] == region);
    let largest = of_region.max_by(|&f, &g| area(f).total_cmp(&area(g)).then(g.cmp(&f)))?;
    Some((largest, (0..3).map(|k| cut.map.uv[3 * largest + k]).sum::<DVec2>() / 3.0))
}
