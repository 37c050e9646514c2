//! One disc, cut out of the draft with a ring around it.

use crate::engine::certify::Stance;
use crate::engine::mend::ground::Ground;
use crate::engine::quad::Anchor;
use crate::engine::quad::improve::{DEAD, QuadNet};
use crate::engine::quad::optimise::Curve;
use glam::DVec3;

/// Part of the way between its neighbours on a curve that a vertex keeps from either.
const APART: f64 = 1.0 / 6.0;

/// How a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    /// Not at all: it is a corner, belongs to quads outside the disc, or is no longer used.
    Fixed,
    /// On the surface.
    Surface,
    /// On this curve, between these two vertices of its chain.
    Curve {
        /// The curve of the ground.
        curve: u32,
        /// Its neighbours on the chain.
        ends: [u32; 2],
    },
}

/// A disc of quads with what is around it, in its own numbers.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Per vertex of the patch that was there, its vertex in the draft; new ones come after these.
    pub(super) origin: Vec<u32>,
    pub(super) positions: Vec<DVec3>,
    pub(super) anchors: Vec<Anchor>,
    pub(super) freedom: Vec<Freedom>,
    /// The quads of the disc, [`DEAD`] where there is none any more.
    pub(super) quads: Vec<[u32; 4]>,
    /// The quads that meet the disc: they stay.
    pub(super) around: Vec<[u32; 4]>,
    /// How those stand.
    pub(super) around_stances: Vec<Stance>,
    /// Edges on features, as (lower, higher) vertex, sorted.
    pub(super) features: Vec<[u32; 2]>,
    /// Edge length of the quads around, in model units.
    pub(super) size: f64,
    /// Points of the surface that the disc stands for.
    pub(super) points: Vec<DVec3>,
    /// How far they may be from its quads, in model units.
    pub(super) reach: f64,
    /// Per quad of the disc where its corners were when it was looked at last, and how it stood.
    pub(super) known: Vec<Option<([DVec3; 4], Stance)>>,
}

impl Patch {
    /// Cuts the quads in these slots (sorted) out, which stand for these points of the surface.
    pub(super) fn new(
        ground: &Ground<'_>,
        net: &QuadNet,
        positions: &[DVec3],
        own: &[u32],
        points: Vec<DVec3>,
    ) -> Self {
        let slots_at = |v: u32| net.at[v as usize].iter().copied();
        let is_own = |slot: &u32| own.binary_search(slot).is_ok();
        let mut around: Vec<u32> =
            own.iter().flat_map(|&s| net.quads[s as usize]).flat_map(slots_at).filter(|s| !is_own(s)).collect();
        around.sort_unstable();
        around.dedup();
        let mut origin: Vec<u32> = own.iter().chain(&around).flat_map(|&s| net.quads[s as usize]).collect();
        origin.sort_unstable();
        origin.dedup();
        let local = |v: u32| origin.partition_point(|&o| o < v) as u32;
        let quads: Vec<[u32; 4]> = own.iter().map(|&s| net.quads[s as usize].map(local)).collect();
        let around: Vec<[u32; 4]> = around.iter().map(|&s| net.quads[s as usize].map(local)).collect();
        let mut features: Vec<[u32; 2]> = sides(&quads)
            .chain(sides(&around))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .filter(|&[a, b]| net.is_feature(origin[a as usize], origin[b as usize]))
            .collect();
        features.sort_unstable();
        features.dedup();
        let positions: Vec<DVec3> = origin.iter().map(|&v| positions[v as usize]).collect();
        let stance = |q: &[u32; 4]| ground.judge.stance(&q.map(|v| positions[v as usize]));
        let around_stances = around.iter().map(stance).collect();
        let anchors: Vec<Anchor> = origin.iter().map(|&v| net.anchors[v as usize]).collect();
        let freedom = vec![Freedom::Fixed; origin.len()];
        let mut patch = Self {
            origin,
            positions,
            anchors,
            freedom,
            quads,
            around,
            around_stances,
            features,
            size: ground.edge,
            points,
            reach: f64::INFINITY,
            known: Vec::new(),
        };
        patch.reach = patch.allowed(ground);
        patch.size = patch.size_around(ground.edge);
        patch.set_free(ground);
        patch
    }

    /// Corner positions of a quad.
    pub(super) fn corners(&self, quad: &[u32; 4]) -> [DVec3; 4] {
        quad.map(|v| self.positions[v as usize])
    }

    /// The quads of the disc that are there.
    pub(super) fn living(&self) -> impl Iterator<Item = &[u32; 4]> {
        self.quads.iter().filter(|q| **q != DEAD)
    }

    /// How a quad of the disc stands; nothing if it is no longer there.
    pub(super) fn stance(&self, ground: &Ground<'_>, q: usize) -> Option<Stance> {
        let quad = &self.quads[q];
        (*quad != DEAD).then(|| {
            let corners = self.corners(quad);
            match self.known.get(q) {
                Some(Some((then, stance))) if *then == corners => *stance,
                _ => ground.judge.stance(&corners),
            }
        })
    }

    /// Looks at all quads whose corners moved.
    pub(super) fn look(&mut self, ground: &Ground<'_>) {
        let stances = (0..self.quads.len()).map(|q| self.stance(ground, q).map(|s| (self.corners(&self.quads[q]), s)));
        self.known = stances.collect();
    }

    /// All vertices.
    pub(super) fn all(&self) -> Vec<u32> {
        (0..self.positions.len() as u32).collect()
    }

    pub(super) fn is_feature(&self, a: u32, b: u32) -> bool {
        self.features.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    fn size_around(&self, otherwise: f64) -> f64 {
        let lengths = sides(&self.around).map(|[a, b]| self.positions[a as usize].distance(self.positions[b as usize]));
        let (sum, n) = lengths.fold((0.0, 0.0), |(sum, n), l| (sum + l, n + 1.0));
        if sum > 0.0 { sum / n } else { otherwise }
    }

    /// Finds out how each vertex may move, and puts those that are anchored to where they belong.
    fn set_free(&mut self, ground: &Ground<'_>) {
        let n = self.positions.len();
        let (mut inside, mut outside) = (vec![false; n], vec![false; n]);
        self.living().flatten().for_each(|&v| inside[v as usize] = true);
        self.around.iter().flatten().for_each(|&v| outside[v as usize] = true);
        let mut curve_edges = self.features.clone();
        let mut all: Vec<[u32; 2]> =
            sides(&self.quads).chain(sides(&self.around)).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        all.sort_unstable();
        // An edge with one quad lies on the boundary, if one of its ends has all its quads here.
        curve_edges.extend(all.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]));
        for v in 0..n {
            self.freedom[v] = Freedom::Fixed;
            if !inside[v] || outside[v] {
                continue;
            }
            match self.anchors[v] {
                Anchor::Corner(c) => self.positions[v] = ground.surface.mesh.position(c),
                Anchor::Surface => self.freedom[v] = Freedom::Surface,
                Anchor::Curve => {
                    let at = |e: &&[u32; 2]| e.contains(&(v as u32));
                    let mut ends: Vec<u32> =
                        curve_edges.iter().filter(at).flatten().copied().filter(|&w| w != v as u32).collect();
                    ends.dedup();
                    if let [a, b] = ends[..]
                        && let Some(curve) = self.curve_of(ground, v as u32, [a, b])
                    {
                        self.freedom[v] = Freedom::Curve { curve, ends: [a, b] };
                    }
                }
            }
        }
        // Those that left their curve come back between their neighbours.
        for v in 0..n as u32 {
            if let Some(room) = self.room(ground, v) {
                self.positions[v as usize] = room.nearest(self.positions[v as usize]);
            }
        }
    }

    /// The curve on which both neighbours of a vertex lie, and the vertex as near as may be.
    fn curve_of(&self, ground: &Ground<'_>, v: u32, ends: [u32; 2]) -> Option<u32> {
        let [a, b] = ends.map(|w| self.positions[w as usize]);
        let p = self.positions[v as usize];
        let near = [a, b, p, a.midpoint(b)].into_iter().filter_map(|q| ground.nearest_curve(q)).map(|found| found.0);
        let cost = |c: u32| {
            let distance = |q: DVec3| ground.curves[c as usize].nearest(q).distance_squared.sqrt();
            10.0 * (distance(a) + distance(b)) + distance(p) + distance(a.midpoint(b))
        };
        near.min_by(|&c, &d| cost(c).total_cmp(&cost(d)).then(c.cmp(&d)))
    }

    /// Where a vertex on a curve may be: between its neighbours, a sixth of the way from either.
    pub(super) fn room<'a>(&self, ground: &'a Ground<'_>, v: u32) -> Option<Room<'a>> {
        let Freedom::Curve { curve, ends } = self.freedom[v as usize] else { return None };
        let curve = &ground.curves[curve as usize];
        let arc = |v: u32| curve.nearest(self.positions[v as usize]).arc;
        let ([mut from, mut to], here, length) = (ends.map(arc), arc(v), curve.length());
        if curve.is_closed() {
            let forward = (to - from).rem_euclid(length);
            let is_forward = (here - from).rem_euclid(length) <= forward;
            let (low, span) = if is_forward { (from, forward) } else { (to, length - forward) };
            let gap = APART * span;
            return Some(Room { curve, low: low + gap, high: low + span - gap });
        }
        if curve.ends()[0] == curve.ends()[1] {
            // The corner is both ends: the one on the vertex's own side of the other neighbour is meant.
            let is_end = |arc: f64| arc.min(length - arc) < 1e-9 * length;
            let end = |other: f64| if here < other { 0.0 } else { length };
            match (is_end(from), is_end(to)) {
                (true, true) => (from, to) = (0.0, length),
                (true, false) => from = end(to),
                (false, true) => to = end(from),
                (false, false) => {}
            }
        }
        let (low, high) = (from.min(to), from.max(to));
        let gap = APART * (high - low);
        Some(Room { curve, low: low + gap, high: high - gap })
    }
}

/// A stretch of a curve, by arc length.
pub(super) struct Room<'a> {
    curve: &'a Curve,
    low: f64,
    high: f64,
}

impl Room<'_> {
    /// The point of it nearest to `p`.
    pub(super) fn nearest(&self, p: DVec3) -> DVec3 {
        self.curve.at(self.curve.nearest_between(p, self.low, self.high))
    }
}

/// The sides of quads that are there, directed.
pub(super) fn sides(quads: &[[u32; 4]]) -> impl Iterator<Item = [u32; 2]> {
    quads.iter().filter(|q| **q != DEAD).flat_map(|q| (0..4).map(move |k| [q[k], q[(k + 1) % 4]]))
}
