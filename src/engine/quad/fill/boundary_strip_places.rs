//! Where the vertices of a boundary strip lie on a boundary loop: in order, near their partners, corners on corners.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::engine::mesh::closest_on_segment;
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::embedded_graph::GraphNode;
use crate::engine::run::{Cancelled, RunContext};

/// Neighbours on the loop are at least this part of their mean distance apart.
const MIN_GAP: f64 = 0.3;

/// A boundary loop, as it is seen from outside the surface: the surface lies to the right.
#[derive(Clone, Debug)]
pub(crate) struct BoundaryLoop {
    /// Its points in order.
    pub(crate) points: Vec<DVec3>,
    /// Per point, the corner that it is.
    pub(crate) corner: Vec<Option<u32>>,
}

/// The point of a loop nearest to another.
pub(super) struct Nearest {
    /// It is on the segment from this point of the loop to the next,
    segment: usize,
    /// at this part of it.
    t: f64,
    pub(super) distance: f64,
}

impl BoundaryLoop {
    /// The nearest point of the loop. Linear in its size.
    pub(super) fn nearest(&self, p: DVec3) -> Nearest {
        let next = |i: usize| self.points[(i + 1) % self.points.len()];
        let mut best = Nearest { segment: 0, t: 0.0, distance: f64::INFINITY };
        for (segment, &a) in self.points.iter().enumerate() {
            let (t, q) = closest_on_segment(p, a, next(segment));
            let distance = q.distance(p);
            if distance < best.distance {
                best = Nearest { segment, t, distance };
            }
        }
        best
    }
}

/// A place on a loop.
#[derive(Clone, Copy)]
struct OnLoop {
    /// Its arc length.
    arc: f64,
    /// How far it is from what it is nearest to.
    distance: f64,
}

/// A point of the loop that a node gets.
#[derive(Clone, Copy)]
struct Fixed {
    /// The number of the point.
    point: usize,
    /// Its arc length, counted on from where the order of the nodes starts.
    arc: f64,
}

/// A loop by arc length.
struct Measured<'a> {
    outline: &'a BoundaryLoop,
    /// Arc length at each point, and at last the whole.
    at: Vec<f64>,
}

impl Measured<'_> {
    fn total(&self) -> f64 {
        self.at[self.outline.points.len()]
    }

    /// The nearest point.
    fn nearest(&self, p: DVec3) -> OnLoop {
        let Nearest { segment: i, t, distance } = self.outline.nearest(p);
        OnLoop { arc: self.at[i] + t * (self.at[i + 1] - self.at[i]), distance }
    }

    fn position(&self, s: f64) -> DVec3 {
        let points = &self.outline.points;
        let s = s.rem_euclid(self.total());
        let i = (self.at.partition_point(|&a| a <= s).max(1) - 1).min(points.len() - 1);
        let length = self.at[i + 1] - self.at[i];
        let t = if length > 0.0 { (s - self.at[i]) / length } else { 0.0 };
        points[i].lerp(points[(i + 1) % points.len()], t.clamp(0.0, 1.0))
    }
}

/// Positions and anchors on the loop for nodes that go around it in its order; `forced` says which point of the loop
/// some of them must get. `None` if there are too few nodes for the corners of the loop, or they do not go around it
/// once.
pub(super) fn places(
    ctx: &RunContext,
    outline: &BoundaryLoop,
    nodes: &[DVec3],
    forced: &[Option<usize>],
) -> Result<Option<Vec<GraphNode>>, Cancelled> {
    let n = outline.points.len();
    let mut at = vec![0.0; n + 1];
    for i in 0..n {
        at[i + 1] = at[i] + outline.points[i].distance(outline.points[(i + 1) % n]);
    }
    let measured = Measured { outline, at };
    let look = |&p: &DVec3| {
        ctx.check()?;
        Ok(measured.nearest(p))
    };
    let near = nodes.iter().map(look).collect::<Result<Vec<OnLoop>, Cancelled>>()?;
    Ok(in_order(&measured, &near, forced))
}

/// Places by the nearest points.
fn in_order(measured: &Measured<'_>, near: &[OnLoop], forced: &[Option<usize>]) -> Option<Vec<GraphNode>> {
    let (outline, total) = (measured.outline, measured.total());
    // Around the loop from the node that is surest of its place.
    let is_forced = |i: &usize| forced[*i].is_some();
    let first = (0..near.len())
        .find(is_forced)
        .or_else(|| (0..near.len()).min_by(|&a, &b| near[a].distance.total_cmp(&near[b].distance)))?;
    let order: Vec<usize> = (0..near.len()).map(|k| (first + k) % near.len()).collect();
    let start = forced[first].map_or(near[first].arc, |point| measured.at[point]);
    let mut wished = vec![start];
    for &i in &order[1..] {
        let last = wished[wished.len() - 1];
        let s = forced[i].map_or(near[i].arc, |point| measured.at[point]);
        let step = (s - last).rem_euclid(total);
        wished.push(last + if step > 0.5 * total { step - total } else { step });
    }
    let step = (start - wished[wished.len() - 1]).rem_euclid(total);
    let turned = wished[wished.len() - 1] + if step > 0.5 * total { step - total } else { step } - start;
    if (turned - total).abs() > 0.5 * total {
        return None;
    }
    let fixed = fixed_places(measured, &order, &wished, forced)?;
    let place = spread(&wished, &fixed, total);
    let mut places = vec![GraphNode { position: DVec3::ZERO, anchor: Anchor::Curve }; near.len()];
    for (k, &i) in order.iter().enumerate() {
        places[i] = match fixed[k] {
            Some(Fixed { point, .. }) => GraphNode {
                position: outline.points[point],
                anchor: outline.corner[point].map_or(Anchor::Curve, Anchor::Corner),
            },
            None => GraphNode { position: measured.position(place[k]), anchor: Anchor::Curve },
        };
    }
    Some(places)
}

/// Per node in order, the corner that it gets.
fn fixed_places(
    measured: &Measured<'_>,
    order: &[usize],
    wished: &[f64],
    forced: &[Option<usize>],
) -> Option<Vec<Option<Fixed>>> {
    let (start, total) = (wished[0], measured.total());
    let holders: BTreeMap<usize, usize> =
        order.iter().enumerate().rev().filter_map(|(k, &i)| Some((forced[i]?, k))).collect();
    let holder = |p: usize| holders.get(&p).copied();
    let mut corners: Vec<(f64, usize)> = (0..measured.outline.points.len())
        .filter(|&p| measured.outline.corner[p].is_some() || holder(p).is_some())
        .map(|p| (start + (measured.at[p] - start).rem_euclid(total), p))
        .collect();
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut fixed = vec![None; order.len()];
    let mut from = 0;
    for (c, &(s, p)) in corners.iter().enumerate() {
        // The nodes up to the one of the next corner that has its own must do for those in between.
        let next = (c + 1..corners.len()).find_map(|d| holder(corners[d].1).map(|k| (k, d - c)));
        let (to, needed) = next.unwrap_or((order.len(), corners.len() - c));
        let room = from..(to + 1).checked_sub(needed)?;
        let nearest = || room.min_by(|&a, &b| (wished[a] - s).abs().total_cmp(&(wished[b] - s).abs()));
        let k = holder(p).filter(|&k| k >= from).or_else(|| holder(p).is_none().then(nearest)?)?;
        fixed[k] = Some(Fixed { point: p, arc: s });
        from = k + 1;
    }
    Some(fixed)
}

/// Arc lengths in order as near as may be to those wished for, with gaps, between those that are fixed.
fn spread(wished: &[f64], fixed: &[Option<Fixed>], total: f64) -> Vec<f64> {
    let n = wished.len();
    let mut place = monotone(wished);
    // The first node is fixed where it is if nothing else is.
    let mut stops: Vec<(usize, f64)> = (0..n).filter_map(|k| fixed[k].map(|fixed| (k, fixed.arc))).collect();
    if stops.is_empty() {
        stops.push((0, wished[0]));
    }
    let (k, s) = stops[0];
    stops.push((k + n, s + total));
    for pair in stops.windows(2) {
        let [(a, low), (b, high)] = [pair[0], pair[1]];
        let gap = MIN_GAP * (high - low) / (b - a) as f64;
        for k in a..b {
            let turns = if k >= n { total } else { 0.0 };
            let least = low + (k - a) as f64 * gap;
            let most = high - (b - k) as f64 * gap;
            let s = if k == a { low } else { (place[k % n] + turns).clamp(least, most) };
            place[k % n] = s - turns;
        }
        // Clamping keeps the order but not the gaps inside.
        for k in a + 1..b {
            let turns = |k: usize| if k >= n { total } else { 0.0 };
            let before = place[(k - 1) % n] + turns(k - 1);
            let s = (place[k % n] + turns(k)).max(before + gap);
            place[k % n] = s - turns(k);
        }
        for k in (a + 1..b).rev() {
            let turns = |k: usize| if k >= n { total } else { 0.0 };
            let after = if k + 1 == b { high } else { place[(k + 1) % n] + turns(k + 1) };
            let s = (place[k % n] + turns(k)).min(after - gap);
            place[k % n] = s - turns(k);
        }
    }
    place
}

/// The nearest sequence that never falls (pool adjacent violators).
fn monotone(values: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for &value in values {
        let mut pool = (value, 1);
        while let Some(&(sum, n)) = pools.last()
            && sum / n as f64 > pool.0 / pool.1 as f64
        {
            pools.pop();
            pool = (pool.0 + sum, pool.1 + n);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(sum, n)| std::iter::repeat_n(sum / n as f64, n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(outline: &BoundaryLoop, nodes: &[DVec3], forced: &[Option<usize>]) -> Option<Vec<GraphNode>> {
        places(&RunContext::silent(), outline, nodes, forced).unwrap()
    }

    fn square() -> BoundaryLoop {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
        let at = |a: (f64, f64), b: (f64, f64), t: f64| DVec3::new(a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1), 0.0);
        let points = (0..16).map(|i| at(corners[i / 4], corners[(i / 4 + 1) % 4], (i % 4) as f64 / 4.0));
        let corner = (0..16).map(|i| (i % 4 == 0).then_some(i as u32)).collect();
        BoundaryLoop { points: points.collect(), corner }
    }

    /// Nodes on a circle inside.
    fn ring(n: usize, shift: f64) -> Vec<DVec3> {
        let angle = |i: usize| (i as f64 + shift) * std::f64::consts::TAU / n as f64;
        (0..n).map(|i| DVec3::new(2.0 + angle(i).cos(), 2.0 + angle(i).sin(), 0.0)).collect()
    }

    #[test]
    fn places_go_round_in_order_and_take_every_corner() {
        for (n, shift) in [(4, 0.3), (5, 0.0), (12, 0.7), (40, 0.1)] {
            let outline = square();
            let places = placed(&outline, &ring(n, shift), &vec![None; n]).unwrap();
            let mut corners: Vec<Anchor> = places.iter().map(|p| p.anchor).filter(|a| *a != Anchor::Curve).collect();
            corners.sort_by_key(|a| format!("{a:?}"));
            assert_eq!(corners.len(), 4);
            corners.dedup();
            assert_eq!(corners.len(), 4, "each corner once");
            // Shoelace: a polygon in order on the loop has its area, but for corners cut off.
            let twice: f64 = (0..n)
                .map(|i| (places[i].position, places[(i + 1) % n].position))
                .map(|(a, b)| a.x * b.y - b.x * a.y)
                .sum();
            assert!((twice / 2.0 - 16.0).abs() < 1e-9, "{twice}");
            let gap =
                (0..n).map(|i| places[i].position.distance(places[(i + 1) % n].position)).fold(f64::INFINITY, f64::min);
            assert!(gap > 0.1 * 16.0 / n as f64, "{gap}");
        }
    }

    #[test]
    fn forced_points_are_met_and_too_few_nodes_refused() {
        let outline = square();
        let mut forced = vec![None; 12];
        forced[3] = Some(6);
        let mut with_end = outline.clone();
        with_end.corner[6] = Some(99);
        let places = placed(&with_end, &ring(12, 0.0), &forced).unwrap();
        assert_eq!(places[3], GraphNode { position: outline.points[6], anchor: Anchor::Corner(99) });
        assert_eq!(places.iter().filter(|p| p.anchor != Anchor::Curve).count(), 5);
        assert!(placed(&outline, &ring(3, 0.0), &[None; 3]).is_none());
    }

    #[test]
    fn pooled_values_never_fall() {
        assert_eq!(monotone(&[1.0, 3.0, 2.0, 2.0, 5.0]), [1.0, 7.0 / 3.0, 7.0 / 3.0, 7.0 / 3.0, 5.0]);
    }
}
