//! Triangles without a usable normal: needles and caps.

use std::collections::VecDeque;

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::editable::Editable;
use crate::engine::mesh::condition::fans::split_fans;
use crate::engine::mesh::condition::patches::components;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Least height of a triangle relative to the diagonal of its component.
const LEAST_HEIGHT: f64 = 1e-9;
/// Least height of a triangle relative to its longest side.
const LEAST_SHAPE: f64 = 1e-6;
/// Files of single precision hold coordinates to 6e-8 of their size: the parts of a split triangle of less than about
/// thirty times that height may have no area in them. Relative to the coordinates or the diagonal, whichever is less:
/// models far from the origin keep their detail.
const LEAST_HEIGHT_WRITTEN: f64 = 2e-6;
/// Longest way, relative to the diagonal of the component, that a vertex is pulled along an edge.
const LONGEST_PULL: f64 = 1e-5;

/// What is too thin in one component.
#[derive(Clone, Copy, Debug)]
struct Scale {
    least_height: f64,
    longest_pull: f64,
}

/// Twice the area over the longest side.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = longest([a, b, c]);
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

fn is_thin(triangle: [DVec3; 3], scale: Scale) -> bool {
    height(triangle) < scale.least_height.max(LEAST_SHAPE * longest(triangle))
}

fn triangle(draft: &Draft, f: u32) -> [DVec3; 3] {
    draft.faces[f as usize].map(|v| draft.positions[v as usize])
}

/// Drops components in which every triangle is thin: they have no area.
pub(super) fn drop_flat_components(draft: &mut Draft, tally: &mut Tally) {
    let (component, scales) = scales(draft);
    let mut has_area = vec![false; scales.len()];
    for f in 0..draft.faces.len() {
        let c = component[f] as usize;
        has_area[c] |= !is_thin(triangle(draft, f as u32), scales[c]);
    }
    let flat = has_area.iter().filter(|&&area| !area).count();
    if flat > 0 {
        let keep: Vec<bool> = component.iter().map(|&c| has_area[c as usize]).collect();
        tally.add("degenerate_faces_dropped", keep.iter().filter(|&&k| !k).count());
        draft.retain(&keep);
    }
    tally.add("components_without_area_dropped", flat);
}

/// A closed component thinner than this part of the model's diagonal has no volume: eight times the rounding of single
/// precision, in which most files are written.
const LEAST_THICKNESS: f64 = 8.0 * f32::EPSILON as f64;

/// Drops closed components whose mean thickness, twice the volume over the area, is nothing at the size of the model
/// (`diagonal`): shards that exporters and cuts leave behind. A model that has nothing else keeps them.
pub(super) fn drop_shards(draft: &mut Draft, diagonal: f64, tally: &mut Tally) {
    let (component, n) = components(&draft.twin);
    let (mut volume, mut area, mut is_closed) = (vec![0.0; n], vec![0.0; n], vec![true; n]);
    let mut origin: Vec<Option<DVec3>> = vec![None; n];
    for (f, &c) in component.iter().enumerate() {
        let c = c as usize;
        let [p, q, r] = triangle(draft, f as u32);
        // Seen from a point of the component, so that its distance from the origin costs no digits.
        let from = *origin[c].get_or_insert(p);
        volume[c] += (p - from).dot((q - from).cross(r - from)) / 6.0;
        area[c] += 0.5 * (q - p).cross(r - p).length();
        is_closed[c] &= draft.twin[3 * f..3 * f + 3].iter().all(|&t| t != NONE);
    }
    let is_shard = |c: usize| is_closed[c] && 2.0 * f64::abs(volume[c]) <= LEAST_THICKNESS * diagonal * area[c];
    let shards = (0..n).filter(|&c| is_shard(c)).count();
    if shards == 0 || shards == n {
        return;
    }
    let keep: Vec<bool> = component.iter().map(|&c| !is_shard(c as usize)).collect();
    draft.retain(&keep);
    tally.add("components_without_volume_dropped", shards);
}

fn scales(draft: &Draft) -> (Vec<u32>, Vec<Scale>) {
    let (component, n) = components(&draft.twin);
    let mut low = vec![DVec3::INFINITY; n];
    let mut high = vec![DVec3::NEG_INFINITY; n];
    for (f, &c) in component.iter().enumerate() {
        for p in triangle(draft, f as u32) {
            low[c as usize] = low[c as usize].min(p);
            high[c as usize] = high[c as usize].max(p);
        }
    }
    let scale = |c: usize| {
        let diagonal = low[c].distance(high[c]);
        let far = low[c].abs().max(high[c].abs()).max_element();
        // Below a few units in the last place of the coordinates a height is rounding.
        let least_height =
            (LEAST_HEIGHT * diagonal).max(16.0 * f64::EPSILON * far).max(LEAST_HEIGHT_WRITTEN * far.min(diagonal));
        Scale { least_height, longest_pull: LONGEST_PULL * diagonal }
    };
    (component, (0..n).map(scale).collect())
}

/// Mends every thin triangle: flips the longest side of caps, collapses the shortest side of needles, peels what lies
/// on the boundary, and where topology forbids all that moves the vertex by the least height that will do. Faces that
/// resist even this are cut out.
pub(super) fn mend(ctx: &RunContext, draft: Draft, tally: &mut Tally) -> Result<Draft, Cancelled> {
    let (component, scales) = scales(&draft);
    let scale = |f: u32| scales[component[f as usize] as usize];
    let thin: Vec<u32> = (0..draft.faces.len() as u32).filter(|&f| is_thin(triangle(&draft, f), scale(f))).collect();
    if thin.is_empty() {
        return Ok(draft);
    }
    let mut mender = Mender { mesh: Editable::new(draft), collapsed: 0, flipped: 0, peeled: 0 };
    let mut queue: VecDeque<u32> = thin.into();
    let mut budget = 16 * queue.len() + 1000;
    while let Some(f) = queue.pop_front().filter(|_| budget > 0) {
        if budget.is_multiple_of(1024) {
            ctx.check()?;
        }
        budget -= 1;
        if mender.mesh.alive[f as usize] && is_thin(triangle(&mender.mesh.draft, f), scale(f)) {
            queue.extend(mender.mend_face(f, scale(f)).unwrap_or_default());
        }
    }
    let moved = unstick(&mut mender.mesh, &scale);
    let stuck = thin_faces(&mender.mesh, &scale);
    for &f in &stuck {
        mender.mesh.alive[f as usize] = false;
    }
    tally.add("edges_collapsed", mender.collapsed);
    tally.add("edges_flipped", mender.flipped);
    tally.add("degenerate_faces_dropped", mender.peeled);
    tally.add("vertices_moved", moved);
    tally.add("degenerate_faces_cut_out", stuck.len());
    let draft = mender.mesh.finish();
    Ok(if stuck.is_empty() { draft } else { split_fans(draft, tally) })
}

fn thin_faces(mesh: &Editable, scale: &impl Fn(u32) -> Scale) -> Vec<u32> {
    let faces = 0..mesh.draft.faces.len() as u32;
    faces.filter(|&f| mesh.alive[f as usize] && is_thin(triangle(&mesh.draft, f), scale(f))).collect()
}

/// Moves the corner opposite the longest side of each thin face away from that side, against the face beyond it.
/// Moves that make neighbours thin are followed by a few more rounds. Returns the number of moves.
fn unstick(mesh: &mut Editable, scale: &impl Fn(u32) -> Scale) -> usize {
    let mut moves = 0;
    for round in 0..4 {
        let stuck = thin_faces(mesh, scale);
        for &f in &stuck {
            let t = triangle(&mesh.draft, f);
            if is_thin(t, scale(f)) {
                let step = f64::from(4 << round) * scale(f).least_height.max(LEAST_SHAPE * longest(t));
                move_off(&mut mesh.draft, f, step);
                moves += 1;
            }
        }
        if stuck.is_empty() {
            break;
        }
    }
    moves
}

/// Puts the corner of `f` opposite its longest side at the height `step` over that side.
fn move_off(draft: &mut Draft, f: u32, step: f64) {
    let t = triangle(draft, f);
    let k = longest_side(t);
    let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
    let along = (b - a).normalize_or_zero();
    let across = |p: DVec3| (p - a) - along * (p - a).dot(along);
    let beyond = draft.twin[3 * f as usize + k];
    let away = if beyond == NONE {
        across(c)
    } else {
        -across(draft.positions[draft.start(prev(beyond as usize) as u32) as usize])
    };
    let away =
        away.try_normalize().unwrap_or_else(|| along.try_normalize().unwrap_or(DVec3::X).any_orthonormal_vector());
    let v = draft.faces[f as usize][(k + 2) % 3] as usize;
    draft.positions[v] = c - across(c) + away * step;
    draft.moved[v] = true;
}

fn longest_side([a, b, c]: [DVec3; 3]) -> usize {
    let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
    if ab >= bc && ab >= ca {
        0
    } else if bc >= ca {
        1
    } else {
        2
    }
}

struct Mender {
    mesh: Editable,
    collapsed: usize,
    flipped: usize,
    peeled: usize,
}

impl Mender {
    /// Mends face `f`; returns the faces that changed, or `None` if nothing could be done.
    fn mend_face(&mut self, f: u32, scale: Scale) -> Option<Vec<u32>> {
        let t = triangle(&self.mesh.draft, f);
        let long = 3 * f + longest_side(t) as u32;
        let sides = [0, 1, 2].map(|k| t[k].distance(t[(k + 1) % 3]));
        let mut short: Vec<u32> = (0..3).collect();
        short.sort_by(|&i, &j| sides[i as usize].total_cmp(&sides[j as usize]));
        let is_needle = sides[short[0] as usize] <= 4.0 * scale.least_height.max(height(t));
        if is_needle && let Some(touched) = self.collapse_side(3 * f + short[0], scale) {
            return Some(touched);
        }
        if self.mesh.may_flip(long) && self.flip_improves(long) {
            let g = self.mesh.draft.twin[long as usize] / 3;
            self.mesh.flip(long);
            self.flipped += 1;
            return Some(vec![f, g]);
        }
        for k in short.into_iter().filter(|&k| sides[k as usize] <= scale.longest_pull) {
            if let Some(touched) = self.collapse_side(3 * f + k, scale) {
                return Some(touched);
            }
        }
        self.mesh.peel(f).then(|| {
            self.peeled += 1;
            Vec::new()
        })
    }

    fn collapse_side(&mut self, h: u32, scale: Scale) -> Option<Vec<u32>> {
        let twin = self.mesh.draft.twin[h as usize];
        let backwards = if twin < NONE { twin } else { h };
        for (h, along) in [(h, true), (backwards, twin < NONE)] {
            if along && self.mesh.may_collapse(h) && self.collapse_is_harmless(h, scale) {
                let end = self.mesh.draft.end(h);
                self.mesh.collapse(h);
                self.collapsed += 1;
                return Some(self.mesh.fan(end).0.into_iter().map(|g| g / 3).collect());
            }
        }
        None
    }

    /// No other face at the start of `h` is turned by more than 60 degrees or made thin.
    fn collapse_is_harmless(&self, h: u32, scale: Scale) -> bool {
        let draft = &self.mesh.draft;
        let (twin, end) = (draft.twin[h as usize], draft.positions[draft.end(h) as usize]);
        self.mesh
            .fan(draft.start(h))
            .0
            .into_iter()
            .filter(|&g| g / 3 != h / 3 && (twin == NONE || g / 3 != twin / 3))
            .all(|g| {
                let old = triangle(draft, g / 3);
                if is_thin(old, scale) {
                    return true;
                }
                let (p, q) = (
                    draft.positions[draft.end(g) as usize],
                    draft.positions[draft.end(next(g as usize) as u32) as usize],
                );
                let normal = (p - end).cross(q - end).normalize_or_zero();
                let before = (old[1] - old[0]).cross(old[2] - old[0]).normalize_or_zero();
                !is_thin([end, p, q], scale) && normal.dot(before) > 0.5
            })
    }

    /// The thinner of the two faces becomes less thin.
    fn flip_improves(&self, h: u32) -> bool {
        let draft = &self.mesh.draft;
        let t = draft.twin[h as usize];
        let at = |h: u32| draft.positions[draft.start(h) as usize];
        let (a, b) = (at(h), at(t));
        let (c, e) = (at(prev(h as usize) as u32), at(prev(t as usize) as u32));
        let before = height([a, b, c]).min(height([b, a, e]));
        height([a, e, c]).min(height([e, b, c])) > 1.5 * before.max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::TriangleSoup;
    use crate::engine::mesh::condition::{ConditionOptions, condition};
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn shards_without_volume_go_unless_there_is_nothing_else() {
        let mesh = sample_surface("cube", 300).unwrap().mesh;
        let mut soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
        let boxes = soup.n_polygons();
        let shard = |soup: &mut TriangleSoup, at: DVec3, thick: f64| {
            let n = soup.positions.len() as u32;
            soup.positions.extend(
                [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(0.3) * DVec3::new(1.0, 1.0, thick)]
                    .map(|p| at + 0.1 * p),
            );
            for [a, b, c] in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                soup.push_polygon(&[n + a, n + b, n + c]);
            }
        };
        shard(&mut soup, DVec3::splat(2.0), 1e-6);
        shard(&mut soup, DVec3::splat(3.0), 1e-3);
        let run = |soup: &TriangleSoup| condition(&RunContext::silent(), soup, &ConditionOptions::default()).unwrap();
        let c = run(&soup);
        assert_eq!(c.repairs.iter().find(|r| r.0 == "components_without_volume_dropped").map(|r| r.1), Some(1));
        assert_eq!(c.mesh.topology().components, 2, "a thin one with some volume stays");
        assert!(c.polygon.iter().all(|&p| (p as usize) < boxes || (p as usize) >= boxes + 4));
        let mut alone = TriangleSoup::default();
        shard(&mut alone, DVec3::splat(2.0), 1e-6);
        assert_eq!(run(&alone).mesh.topology().components, 1);
    }
}
