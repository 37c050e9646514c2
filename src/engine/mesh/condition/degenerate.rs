//! Triangles without a usable normal: needles and caps.

use std::collections::VecDeque;

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::editable::Editable;
use crate::engine::mesh::condition::fans::split_fans;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::thin::{
    MIN_SHAPE, Scale, height, is_thin, longest, longest_side, scales, triangle,
};
use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

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
                let step = f64::from(4 << round) * scale(f).least_height.max(MIN_SHAPE * longest(t));
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
        for k in short.into_iter().filter(|&k| sides[k as usize] <= scale.max_collapsed) {
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
