//! A singularity graph from an integer-grid map: from every singular vertex and every corner of features or boundary the
//! coordinate lines run at equal speed until they meet a line (a motorcycle graph). They are cut into the mesh as they run.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::regions::Regions;
use crate::engine::parameterize::{GridMap, Iso, rotate};
use crate::engine::run::RunContext;

/// The line of all features and boundaries.
const BORDER: u32 = NONE - 1;
/// A line that meets an edge nearer to its end than this share of it goes through that vertex, if it can be moved there in
/// the map: triangles stay well shaped.
const SNAP: f64 = 0.2;
/// Steps per face of the mesh before lines are taken not to end.
const MOST_STEPS: usize = 8;
/// Base points at most: a disc needs none, every handle and boundary loop a few.
const MOST_BASES: usize = 200;
const AXES: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];

/// Puts special vertices on the integer points and borders on the integer lines that they are on up to rounding errors.
pub(super) fn snap(map: &mut GridMap, is_special: impl Fn(usize) -> bool) {
    for h in 0..map.uv.len() {
        if is_special(h) {
            map.uv[h] = map.uv[h].round();
        }
        let ends = [h, next(h)];
        match map.iso[h] {
            Iso::None => {}
            Iso::U => ends.iter().for_each(|&c| map.uv[c].x = map.uv[c].x.round()),
            Iso::V => ends.iter().for_each(|&c| map.uv[c].y = map.uv[c].y.round()),
        }
    }
}

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
        let Some((f, at, z)) = grid_point(cut, &regions, open) else {
            return Err(HarmonicError::NotDisc { face: open });
        };
        let base = cut.split_face(f, at, z);
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
    if off == 0.0 && first.dot(direction) > 0.0 {
        return Some(Way::Along(corner));
    }
    (off > 0.0 && direction.perp_dot(second) > 0.0).then_some(Way::Into(corner, direction))
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

/// Moves a vertex in the map onto a coordinate line, if it is free to and no triangle turns over; `corner` is one of its
/// corners, whose coordinate `fix` becomes `value`.
fn slide(cut: &mut CutMesh, is_special: &[bool], corner: usize, fix: usize, value: f64) -> bool {
    let v = cut.origin(corner);
    let fan = cut.fan(v);
    let is_boundary = fan.iter().any(|&h| cut.twin(h).is_none() || cut.twin(prev(h)).is_none());
    if is_boundary || is_special.get(v as usize).copied().unwrap_or(false) || cut.is_on_line(v) {
        return false;
    }
    let before: Vec<DVec2> = fan.iter().map(|&h| cut.map.uv[h]).collect();
    cut.map.uv[corner][fix] = value;
    let mut h = corner;
    loop {
        let p = prev(h);
        let Some(n) = cut.twin(p) else { break };
        if n == corner {
            break;
        }
        let back = (4 - cut.map.rotation[p]) & 3;
        cut.map.uv[n] = rotate(cut.map.uv[h] - cut.map.translation[p].as_dvec2(), back);
        h = n;
    }
    let is_upright = |&h: &usize| {
        let uv = &cut.map.uv;
        (uv[next(h)] - uv[h]).perp_dot(uv[prev(h)] - uv[h]) > 0.0
    };
    if fan.iter().all(is_upright) {
        return true;
    }
    for (&h, z) in fan.iter().zip(before) {
        cut.map.uv[h] = z;
    }
    false
}

/// A grid point inside a face of a region: the face, barycentric coordinates, and the point in the chart of the face; the one
/// that is furthest from the sides of its face.
fn grid_point(cut: &CutMesh, regions: &Regions, region: u32) -> Option<(usize, [f64; 3], DVec2)> {
    let mut best: Option<(f64, usize, [f64; 3], DVec2)> = None;
    for f in (0..cut.n_faces()).filter(|&f| regions.of_face[f] == region) {
        let [a, b, c] = [0, 1, 2].map(|k| cut.map.uv[3 * f + k]);
        let z = ((a + b + c) / 3.0).round();
        let area = (b - a).perp_dot(c - a);
        let w = [(b - z).perp_dot(c - z), (c - z).perp_dot(a - z), (a - z).perp_dot(b - z)].map(|x| x / area);
        let least = w.iter().copied().fold(f64::INFINITY, f64::min);
        if area > 0.0 && least > best.map_or(1e-6, |b| b.0) {
            best = Some((least, f, w, z));
        }
    }
    best.map(|(_, f, w, z)| (f, w, z))
}
