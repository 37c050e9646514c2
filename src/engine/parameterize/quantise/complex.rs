//! A seamless map as triangles that know nothing but their corners in the plane: vertices may be joined to themselves and
//! to each other more than once, so few of them are enough for any surface.

use glam::DVec2;

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::parameterize::corner_forms::{Form, Term, turn};
use crate::engine::parameterize::grid_map::{Iso, rotate};
use crate::engine::parameterize::reduced::Place;
use crate::engine::parameterize::separation::Elements;

/// A point in a chart: its value, and what it is made of.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    pub(super) z: DVec2,
    pub(super) form: Form,
}

/// A change of chart: `i^quarters z + shift`.
#[derive(Clone, Debug, Default)]
pub(super) struct Transition {
    pub(super) quarters: u8,
    pub(super) shift: Point,
}

impl Transition {
    pub(super) fn apply(&self, point: &Point) -> Point {
        let mut form = point.form.clone();
        turn(&mut form, self.quarters);
        for &term in &self.shift.form {
            add(&mut form, term);
        }
        Point { z: rotate(point.z, self.quarters) + self.shift.z, form }
    }

    /// First `other`, then `self`.
    fn after(&self, other: &Self) -> Self {
        Self { quarters: (self.quarters + other.quarters) & 3, shift: self.apply(&other.shift) }
    }
}

/// Adds a term, or takes its opposite away.
fn add(form: &mut Form, term: Term) {
    let opposite = |t: &Term| t.unknown == term.unknown && (t.quarters + 2) & 3 == term.quarters;
    match form.iter().position(opposite) {
        Some(at) => drop(form.swap_remove(at)),
        None => form.push(term),
    }
}

/// The triangles; halfedges are numbered as in a mesh, those of removed triangles are `gone`.
#[derive(Clone, Debug)]
pub(super) struct Complex {
    /// Per halfedge, the vertex that it leaves.
    pub(super) origin: Vec<u32>,
    /// Per halfedge, the other one of its edge; `NONE` at the boundary.
    pub(super) twin: Vec<u32>,
    /// Per halfedge, the point that it leaves, in the chart of its triangle.
    pub(super) corner: Vec<Point>,
    /// Per halfedge, from the chart of its twin's triangle to that of its own.
    pub(super) across: Vec<Transition>,
    /// Per halfedge, whether it lies on a line of the map.
    pub(super) iso: Vec<Iso>,
    /// Per triangle.
    pub(super) gone: Vec<bool>,
    /// Per vertex, a halfedge that leaves it; `NONE` if it is gone.
    pub(super) some: Vec<u32>,
    /// Per vertex, whether it must stay.
    pub(super) stays: Vec<bool>,
}

impl Complex {
    /// All triangles of a map; `raw` are the values of its unknowns.
    pub(super) fn new(elements: &Elements<'_>, raw: &[f64], stays: Vec<bool>) -> Self {
        let Elements { mesh, cut, forms, seamless, .. } = *elements;
        let n = mesh.n_halfedges();
        let mut across = vec![Transition::default(); n];
        for (h, change) in across.iter_mut().enumerate() {
            let Some((segment, along)) = cut.segment_of[h] else { continue };
            let unknown = forms.n_vertices as u32 + segment;
            let tau = DVec2::new(raw[2 * unknown as usize], raw[2 * unknown as usize + 1]);
            let m = cut.segments[segment as usize].quarters & 3;
            // z_left = i^m z_right + τ, so z_right = i^-m (z_left − τ).
            let back = (4 - m) & 3;
            let (quarters, turned) = if along { (m, 0) } else { (back, (back + 2) & 3) };
            let form = vec![Term { unknown, quarters: turned }];
            *change = Transition { quarters, shift: Point { z: rotate(tau, turned), form } };
        }
        let mut some = vec![NONE; mesh.n_vertices()];
        (0..n).for_each(|h| some[mesh.origin(h) as usize] = h as u32);
        Self {
            origin: (0..n).map(|h| mesh.origin(h)).collect(),
            twin: (0..n).map(|h| mesh.twin(h).map_or(NONE, |t| t as u32)).collect(),
            corner: (0..n).map(|h| Point { z: seamless[h], form: forms.corner[h].clone() }).collect(),
            across,
            iso: elements.iso.to_vec(),
            gone: vec![false; mesh.n_faces()],
            some,
            stays,
        }
    }

    pub(super) fn is_alive(&self, h: usize) -> bool {
        !self.gone[h / 3]
    }

    /// Whether an edge lies on a feature or the boundary.
    pub(super) fn is_curve(&self, h: usize) -> bool {
        self.iso[h] != Iso::None || self.twin[h] == NONE
    }

    /// From the origin of a halfedge to its end, in the chart of its triangle.
    pub(super) fn along(&self, h: usize) -> DVec2 {
        self.corner[next(h)].z - self.corner[h].z
    }

    /// Twice the area of a triangle in its chart.
    pub(super) fn twice_area(&self, f: usize) -> f64 {
        self.along(3 * f).perp_dot(-self.along(3 * f + 2))
    }

    /// Halfedges that leave a vertex, counter-clockwise, the first after the boundary if there is one.
    pub(super) fn fan(&self, v: u32) -> Vec<usize> {
        let start = self.some[v as usize] as usize;
        let mut first = start;
        // Clockwise to the boundary, or once around.
        while self.twin[first] != NONE {
            first = next(self.twin[first] as usize);
            if first == start {
                break;
            }
        }
        let mut fan = vec![first];
        let mut h = first;
        while self.twin[prev(h)] != NONE {
            h = self.twin[prev(h)] as usize;
            if h == first {
                break;
            }
            fan.push(h);
        }
        fan
    }

    /// Joins the edges of a triangle that has lost its third: what lay beyond them becomes neighbours.
    pub(super) fn remove(&mut self, n: usize, p: usize) {
        let (x, y) = (self.twin[n], self.twin[p]);
        self.gone[n / 3] = true;
        let back = |h: u32| if h == NONE { None } else { Some(h as usize) };
        match (back(x), back(y)) {
            (Some(x), Some(y)) => {
                let to_x = self.across[x].after(&self.across[p]);
                let to_y = self.across[y].after(&self.across[n]);
                let is_turned = to_x.quarters & 1 == 1;
                let seen = |iso: Iso| match iso {
                    Iso::U if is_turned => Iso::V,
                    Iso::V if is_turned => Iso::U,
                    iso => iso,
                };
                if self.iso[x] == Iso::None {
                    self.iso[x] = seen(self.iso[y]);
                } else {
                    self.iso[y] = seen(self.iso[x]);
                }
                (self.across[x], self.across[y]) = (to_x, to_y);
                (self.twin[x], self.twin[y]) = (y as u32, x as u32);
            }
            (Some(x), None) => self.open(x, self.iso[p], self.across[x].quarters),
            (None, Some(y)) => self.open(y, self.iso[n], self.across[y].quarters),
            (None, None) => {}
        }
    }

    /// A halfedge becomes one of the boundary; `iso` is in a chart `quarters` away from its own.
    fn open(&mut self, h: usize, iso: Iso, quarters: u8) {
        self.twin[h] = NONE;
        self.across[h] = Transition::default();
        if self.iso[h] == Iso::None {
            self.iso[h] = match iso {
                Iso::U if quarters & 1 == 1 => Iso::V,
                Iso::V if quarters & 1 == 1 => Iso::U,
                iso => iso,
            };
        }
    }

    /// Where a curve turns, its vertex must stay.
    pub(super) fn keep_turns(&mut self) {
        let integral = self.integral(|_| false);
        for (h, flags) in integral.into_iter().enumerate() {
            self.stays[self.origin[h] as usize] |= flags == [true; 2];
        }
    }

    /// Per halfedge, whether u and v of its origin are integers in the chart of its triangle.
    pub(super) fn integral(&self, is_special: impl Fn(u32) -> bool) -> Vec<[bool; 2]> {
        let mut integral = vec![[false; 2]; self.origin.len()];
        for v in (0..self.some.len() as u32).filter(|&v| self.some[v as usize] != NONE) {
            let fan = self.fan(v);
            if is_special(v) {
                fan.into_iter().for_each(|h| integral[h] = [true; 2]);
                continue;
            }
            // Flags in the chart of the first triangle of the fan.
            let mut turned = 0u8;
            let mut flags = [false; 2];
            let mut seen = Vec::with_capacity(fan.len());
            for &h in &fan {
                seen.push((h, turned & 1));
                for iso in [self.iso[h], self.iso[prev(h)]] {
                    if iso != Iso::None {
                        flags[usize::from((iso == Iso::V) != (turned & 1 == 1))] = true;
                    }
                }
                turned = (turned + self.across[prev(h)].quarters) & 3;
            }
            for (h, turned) in seen {
                integral[h] = if turned == 1 { [flags[1], flags[0]] } else { flags };
            }
        }
        integral
    }
}

/// Vertices of the mesh that a map's integers speak of.
pub(super) fn named(elements: &Elements<'_>) -> Vec<bool> {
    let unknowns = elements.unknowns;
    let is_named = |v: usize| {
        let parts = [2 * v, 2 * v + 1];
        let is_origin = parts.iter().all(|&x| unknowns.forms[x].is_empty());
        is_origin || parts.iter().any(|&x| matches!(unknowns.place[x], Place::Integer(_)))
    };
    let mut named: Vec<bool> = (0..elements.mesh.n_vertices()).map(is_named).collect();
    elements.special.iter().for_each(|&v| named[v as usize] = true);
    named
}
