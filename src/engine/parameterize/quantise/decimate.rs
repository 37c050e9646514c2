//! Takes vertices away from a map until hardly any are left but those that its integers speak of.
//!
//! A vertex is drawn into a neighbour if no triangle turns over in the map; how the surface lies in space does not
//! matter. Vertices of curves stay on their curves.

use std::collections::BTreeSet;

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::parameterize::quantise::complex::{Complex, Point};
use crate::engine::run::{Cancelled, RunContext};

/// Triangles thinner than this, as twice their area over the squares of their sides, are not made.
const THINNEST: f64 = 1e-7;

/// Takes away what can be taken. Near linear.
pub(super) fn decimate(ctx: &RunContext, complex: &mut Complex) -> Result<(), Cancelled> {
    // Few neighbours first: they leave the fewest thin triangles.
    let mut queue: BTreeSet<(usize, u32)> =
        (0..complex.some.len() as u32).filter(|&v| complex.may_go(v)).map(|v| (complex.fan(v).len(), v)).collect();
    let mut degree: Vec<usize> = vec![usize::MAX; complex.some.len()];
    queue.iter().for_each(|&(n, v)| degree[v as usize] = n);
    let (mut steps, all) = (0u32, queue.len());
    while let Some((_, v)) = queue.pop_first() {
        degree[v as usize] = usize::MAX;
        steps += 1;
        if steps.is_multiple_of(256) {
            ctx.check()?;
            ctx.advance(1.0 - queue.len() as f64 / all as f64);
        }
        let fan = complex.fan(v);
        let mut around: Vec<u32> =
            fan.iter().flat_map(|&h| [complex.origin[next(h)], complex.origin[prev(h)]]).collect();
        let best = complex.edges_at(v, &fan).into_iter().filter_map(|edge| Some((complex.try_collapse(edge)?, edge)));
        let Some((_, edge)) = best.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.corner.cmp(&a.1.corner))) else {
            continue;
        };
        complex.collapse(edge);
        around.sort_unstable();
        around.dedup();
        for w in around.into_iter().filter(|&w| w != v && complex.may_go(w)) {
            queue.remove(&(degree[w as usize], w));
            degree[w as usize] = complex.fan(w).len();
            queue.insert((degree[w as usize], w));
        }
    }
    Ok(())
}

/// An edge by which a vertex may be drawn away.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The vertex's corner in a triangle of the edge.
    corner: usize,
    /// Whether the edge is the one that comes to the vertex, instead of the one that leaves it.
    comes: bool,
}

impl Complex {
    fn may_go(&self, v: u32) -> bool {
        !self.stays[v as usize] && self.some[v as usize] != NONE
    }

    fn edges_at(&self, v: u32, fan: &[usize]) -> Vec<Edge> {
        let leaving = fan.iter().map(|&h| Edge { corner: h, comes: false });
        let coming = fan.iter().filter(|&&h| self.twin[prev(h)] == NONE).map(|&h| Edge { corner: h, comes: true });
        let halfedge = |e: &Edge| if e.comes { prev(e.corner) } else { e.corner };
        let edges: Vec<Edge> = leaving.chain(coming).collect();
        let curves: Vec<Edge> = edges.iter().copied().filter(|e| self.is_curve(halfedge(e))).collect();
        let mut edges = match curves.len() {
            0 => edges,
            2 => curves,
            _ => Vec::new(),
        };
        edges.retain(|e| {
            let h = halfedge(e);
            let ends = [self.origin[h], self.origin[next(h)]];
            ends.contains(&v) && ends[0] != ends[1] && self.is_link_whole(h)
        });
        edges
    }

    /// Whether the triangles at an edge can go: what lies beyond them can be joined.
    fn is_link_whole(&self, h: usize) -> bool {
        let (n, p) = (next(h), prev(h));
        let (x, y) = (self.twin[n], self.twin[p]);
        let can_join = |n: usize, p: usize, x: u32, y: u32| {
            let is_whole = x != p as u32 && (x != NONE || y != NONE);
            is_whole && !(self.is_curve(n) && self.is_curve(p))
        };
        if !can_join(n, p, x, y) {
            return false;
        }
        let t = self.twin[h];
        if t == NONE {
            return true;
        }
        let (n2, p2) = (next(t as usize), prev(t as usize));
        // When the first triangle has gone.
        let beyond = |e: usize| match self.twin[e] {
            other if other == n as u32 => y,
            other if other == p as u32 => x,
            other => other,
        };
        t as usize / 3 != h / 3 && can_join(n2, p2, beyond(n2), beyond(p2))
    }

    /// The corners of the vertex that move, with where they move to, and the triangles that go.
    fn moves(&self, edge: Edge) -> (Vec<(usize, Point)>, [usize; 2]) {
        let h = edge.corner;
        if edge.comes {
            // Clockwise from the boundary.
            let mut point = self.corner[prev(h)].clone();
            let mut moves = Vec::new();
            let mut c = h;
            loop {
                moves.push((c, point.clone()));
                let t = self.twin[c];
                if t == NONE {
                    break;
                }
                point = self.across[t as usize].apply(&point);
                c = next(t as usize);
            }
            return (moves, [h / 3; 2]);
        }
        let mut point = self.corner[next(h)].clone();
        let mut moves = Vec::new();
        let mut c = h;
        loop {
            moves.push((c, point.clone()));
            let t = self.twin[prev(c)];
            if t == NONE || t as usize == h {
                break;
            }
            point = self.across[t as usize].apply(&point);
            c = t as usize;
        }
        let other = self.twin[h];
        (moves, [h / 3, if other == NONE { h / 3 } else { other as usize / 3 }])
    }

    /// How thin the thinnest of the changed triangles would become; `None` if one turned over.
    fn try_collapse(&mut self, edge: Edge) -> Option<f64> {
        let (moves, gone) = self.moves(edge);
        let before: Vec<_> = moves.iter().map(|(c, _)| self.corner[*c].z).collect();
        moves.iter().for_each(|(c, point)| self.corner[*c].z = point.z);
        let changed = moves.iter().map(|(c, _)| c / 3).filter(|f| !gone.contains(f));
        let thinnest = changed.map(|f| self.shape(f)).fold(f64::INFINITY, f64::min);
        moves.iter().zip(before).for_each(|((c, _), z)| self.corner[*c].z = z);
        (thinnest > THINNEST).then_some(thinnest)
    }

    /// Twice the area of a triangle over the squares of its sides.
    fn shape(&self, f: usize) -> f64 {
        let squares: f64 = (3 * f..3 * f + 3).map(|h| self.along(h).length_squared()).sum();
        self.twice_area(f) / squares.max(f64::MIN_POSITIVE)
    }

    fn collapse(&mut self, edge: Edge) {
        let h = if edge.comes { prev(edge.corner) } else { edge.corner };
        let v = self.origin[edge.corner];
        let w = if edge.comes { self.origin[h] } else { self.origin[next(h)] };
        let (moves, _) = self.moves(edge);
        for (c, point) in moves {
            (self.origin[c], self.corner[c]) = (w, point);
        }
        self.some[v as usize] = NONE;
        let sides = [h as u32, self.twin[h]];
        for side in sides.into_iter().filter(|&side| side != NONE) {
            let (n, p) = (next(side as usize), prev(side as usize));
            let outer = [self.twin[n], self.twin[p]];
            self.remove(n, p);
            for x in outer.into_iter().filter(|&x| x != NONE) {
                let x = x as usize;
                self.some[self.origin[x] as usize] = x as u32;
                self.some[self.origin[next(x)] as usize] = next(x) as u32;
            }
        }
    }
}
