//! The moving quad mesh: where every vertex is, how it may move, and how good its quads are.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::closest_on_triangle;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::optimise::chains::Limit;
use crate::engine::quad::optimise::chains::Slider;
use crate::engine::quad::optimise::chains::place_chains;
use crate::engine::quad::optimise::curves::Curve;
use crate::engine::quad::optimise::incidence::Incidence;
use crate::engine::quad::optimise::shape::area_vector;
use crate::engine::quad::optimise::shape::centre;
use crate::engine::quad::optimise::shape::quality;
use crate::engine::quad::optimise::surface_walker::SurfaceWalker;

/// A vertex keeps this share of the gap to its neighbour on a curve.
const KEEP_OFF: f64 = 0.15;
/// … and this share of the mean gap of its chain: many small steps would otherwise bring it there.
const CLOSEST: f64 = 0.2;

/// Where a vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// It does not move.
    Fixed,
    /// On a curve: its slider and its arc parameter.
    Curve(u32, f64),
    /// In a face of the surface.
    Face(u32),
}

/// Quads on a surface.
#[derive(Debug)]
pub(crate) struct State<'a> {
    pub(crate) walker: &'a SurfaceWalker<'a>,
    pub(crate) quads: &'a [[u32; 4]],
    pub(crate) incidence: Incidence,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) places: Vec<Place>,
    /// Per quad: the unit normal of the surface beneath its centre.
    pub(crate) ups: Vec<DVec3>,
    /// Per quad: the face beneath its centre.
    beneath: Vec<u32>,
    curves: Vec<Curve>,
    sliders: Vec<Slider>,
}

impl<'a> State<'a> {
    /// Puts every vertex where its anchor wants it. `reach`: how far a draft's vertex may lie off the surface.
    /// Vertices that are `held` stay at their positions.
    pub(crate) fn new(
        walker: &'a SurfaceWalker<'a>,
        draft: &'a QuadDraft,
        held: &[bool],
        curves: Vec<Curve>,
        reach: f64,
    ) -> Self {
        let quads = &draft.mesh.quads[..];
        let mut positions = draft.mesh.positions.clone();
        let incidence = Incidence::new(positions.len(), quads);
        let mut places = vec![Place::Fixed; positions.len()];
        let sliders = place_chains(draft, &curves);
        for (i, slider) in sliders.iter().enumerate() {
            let v = slider.vertex as usize;
            places[v] = Place::Curve(i as u32, slider.arc);
            positions[v] = curves[slider.curve as usize].at(slider.arc);
        }
        let mesh = &walker.surface().mesh;
        for (v, anchor) in draft.anchors.iter().enumerate() {
            match *anchor {
                Anchor::Corner(c) => positions[v] = mesh.position(c),
                Anchor::Curve if places[v] == Place::Fixed && !curves.is_empty() => {
                    let nearest = curves.iter().map(|c| (c.nearest(positions[v]), c));
                    if let Some((near, curve)) =
                        nearest.min_by(|a, b| a.0.distance_squared.total_cmp(&b.0.distance_squared))
                    {
                        positions[v] = curve.at(near.arc);
                    }
                }
                _ => {}
            }
        }
        let normal = |q: usize| area_vector(&quads[q].map(|w| draft.mesh.positions[w as usize]));
        let landed: Vec<Option<(u32, DVec3)>> = (0..positions.len())
            .into_par_iter()
            .map(|v| {
                let corners = incidence.corners_of(v as u32);
                let is_held = held.get(v) == Some(&true);
                if is_held || draft.anchors[v] != Anchor::Surface || places[v] != Place::Fixed || corners.is_empty() {
                    return None;
                }
                let own: DVec3 = corners.iter().map(|&c| normal(c as usize / 4)).sum();
                Some(walker.land(positions[v], own.normalize_or_zero(), reach))
            })
            .collect();
        for (v, landed) in landed.into_iter().enumerate() {
            if let Some((face, position)) = landed {
                places[v] = Place::Face(face);
                positions[v] = position;
            }
        }
        let mut state = Self {
            walker,
            quads,
            incidence,
            positions,
            places,
            ups: vec![DVec3::ZERO; quads.len()],
            beneath: Vec::new(),
            curves,
            sliders,
        };
        state.beneath = (0..quads.len())
            .into_par_iter()
            .map(|q| {
                let p = state.corners(q);
                let of_corner = quads[q].iter().find_map(|&v| match state.places[v as usize] {
                    Place::Face(face) => Some(face),
                    _ => None,
                });
                of_corner.unwrap_or_else(|| walker.land(centre(&p), area_vector(&p).normalize_or_zero(), reach).0)
            })
            .collect();
        state.look_beneath();
        state
    }

    /// Finds the surface beneath every quad again.
    pub(crate) fn look_beneath(&mut self) {
        let this = &*self;
        let beneath: Vec<u32> = (0..this.quads.len())
            .into_par_iter()
            .map(|q| this.walker.follow(this.beneath[q], centre(&this.corners(q))).0)
            .collect();
        self.ups = beneath.iter().map(|&f| self.walker.normal(f)).collect();
        self.beneath = beneath;
    }

    /// The local size beneath quad `q`, from the logarithms per vertex of the surface; 1 if there are none.
    pub(crate) fn local_size(&self, q: usize, log_size: &[f64]) -> f64 {
        let mesh = &self.walker.surface().mesh;
        if log_size.len() != mesh.n_vertices() {
            return 1.0;
        }
        let f = self.beneath[q] as usize;
        let (weight, _) = closest_on_triangle(centre(&self.corners(q)), &mesh.triangle(f));
        let face = mesh.face(f);
        (0..3).map(|k| weight[k] * log_size[face[k] as usize]).sum::<f64>().exp()
    }

    /// Corner positions of quad `q`.
    pub(crate) fn corners(&self, q: usize) -> [DVec3; 4] {
        self.quads[q].map(|v| self.positions[v as usize])
    }

    /// Corner positions of quad `q` if its corner `k` were at `p`.
    pub(crate) fn corners_with(&self, q: usize, k: usize, p: DVec3) -> [DVec3; 4] {
        let mut corners = self.corners(q);
        corners[k] = p;
        corners
    }

    /// Quality of quad `q`.
    pub(crate) fn quality(&self, q: usize) -> f64 {
        quality(&self.corners(q), self.ups[q])
    }

    /// Least quality of the quads at `v` if `v` were at `p`.
    pub(crate) fn quality_at(&self, v: u32, p: DVec3) -> f64 {
        let of = |&c: &u32| {
            let (q, k) = (c as usize / 4, c as usize % 4);
            quality(&self.corners_with(q, k, p), self.ups[q])
        };
        self.incidence.corners_of(v).iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Where `v` comes to lie if it is drawn towards `p`: on its surface or its curve, between its neighbours.
    pub(crate) fn drawn(&self, v: u32, p: DVec3) -> (Place, DVec3) {
        match self.places[v as usize] {
            Place::Fixed => (Place::Fixed, self.positions[v as usize]),
            Place::Face(face) => {
                let (face, position) = self.walker.follow(face, p);
                (Place::Face(face), position)
            }
            Place::Curve(slider, arc) => {
                let curve = &self.curves[self.sliders[slider as usize].curve as usize];
                let least = CLOSEST * self.sliders[slider as usize].gap;
                let [below, above] = [0, 1].map(|side| {
                    let room = self.room(slider, arc, side);
                    (room - least.max(KEEP_OFF * room)).max(0.0)
                });
                let arc = curve.wrap(curve.nearest_between(p, arc - below, arc + above));
                (Place::Curve(slider, arc), curve.at(arc))
            }
        }
    }

    /// The curve of a slider, the mean gap of its chain, and its distances along the curve to what comes before and
    /// after it; `None` where its chain is not known from end to end.
    pub(super) fn stretch(&self, slider: u32, arc: f64) -> Option<(&Curve, f64, [f64; 2])> {
        let own = &self.sliders[slider as usize];
        if own.gap <= 0.0 || own.limits.contains(&Limit::Loose) {
            return None;
        }
        Some((&self.curves[own.curve as usize], own.gap, [0, 1].map(|side| self.room(slider, arc, side))))
    }

    /// Distance along the curve to the next vertex or end below (side 0) or above (side 1).
    fn room(&self, slider: u32, arc: f64, side: usize) -> f64 {
        let slider = &self.sliders[slider as usize];
        let curve = &self.curves[slider.curve as usize];
        let way = |to: f64| if side == 0 { arc - to } else { to - arc };
        match slider.limits[side] {
            Limit::Arc(end) => way(end).max(0.0),
            Limit::Vertex(w) => match self.places[w as usize] {
                Place::Curve(_, there) if curve.is_closed() => way(there).rem_euclid(curve.length()),
                Place::Curve(_, there) => way(there).max(0.0),
                _ => 0.0,
            },
            Limit::Loose => {
                // No neighbour on this side: half of the other side's room at most.
                match slider.limits[1 - side] {
                    Limit::Loose => 0.0,
                    _ => 0.5 * self.room_other(slider, arc, 1 - side),
                }
            }
        }
    }

    fn room_other(&self, slider: &Slider, arc: f64, side: usize) -> f64 {
        match slider.limits[side] {
            Limit::Vertex(w) => match self.places[w as usize] {
                Place::Curve(_, there) => (arc - there).abs(),
                _ => 0.0,
            },
            _ => 0.0,
        }
    }

    /// Moves vertices to where `go` says, one colour after the other. `go` sees the state before its colour moved, so
    /// the result does not depend on the number of threads. Returns the number of moved vertices.
    pub(crate) fn sweep(&mut self, go: impl Fn(&Self, u32) -> Option<(Place, DVec3)> + Sync) -> usize {
        let colours = std::mem::take(&mut self.incidence.colours);
        let mut moved = 0;
        for class in &colours {
            let this = &*self;
            let moves: Vec<Option<(Place, DVec3)>> = class.par_iter().map(|&v| go(this, v)).collect();
            for (&v, to) in class.iter().zip(moves) {
                if let Some((place, position)) = to {
                    self.places[v as usize] = place;
                    self.positions[v as usize] = position;
                    moved += 1;
                }
            }
        }
        self.incidence.colours = colours;
        moved
    }
}
