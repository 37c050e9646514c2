//! Where grid lines enter and leave a face.

use glam::I64Vec2;

use crate::engine::mesh::next;
use crate::engine::quad::extract::exact_map::ExactMap;
use crate::engine::quad::extract::exact_map::orient;

/// Where a grid line enters or leaves a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gate {
    /// Across this halfedge of the face.
    Edge(usize),
    /// At this corner of the face.
    Corner(usize),
}

/// The places where the line crosses the boundary of face `f`: two, if it goes through the face and not along a side.
pub(super) fn gates(map: &ExactMap<'_>, f: usize, fix: usize, c: i64) -> Option<[Gate; 2]> {
    let mut found = [None; 2];
    let mut n = 0;
    for h in 3 * f..3 * f + 3 {
        let (a, b) = (map.corner[h][fix], map.corner[next(h)][fix]);
        let gate = if a == c {
            Gate::Corner(h)
        } else if (a < c && c < b) || (b < c && c < a) {
            Gate::Edge(h)
        } else {
            continue;
        };
        *found.get_mut(n)? = Some(gate);
        n += 1;
    }
    let both = [found[0]?, found[1]?];
    // Two corners: the line runs along a side, not through the face.
    (!matches!(both, [Gate::Corner(_), Gate::Corner(_)])).then_some(both)
}

/// Whether the gate lies above `point` on the line through it; `None` if the gate is the point itself. A point on an
/// edge that no grid line runs along counts as lying to the left of the halfedge that stands for the edge: an
/// infinitely small move that both faces of the edge agree on.
pub(super) fn is_above(map: &ExactMap<'_>, gate: Gate, fix: usize, point: I64Vec2) -> Option<bool> {
    match gate {
        Gate::Corner(h) => {
            let r = map.corner[h][1 - fix];
            (r != point[1 - fix]).then_some(r > point[1 - fix])
        }
        Gate::Edge(h) => {
            let (a, b) = (map.corner[h], map.corner[next(h)]);
            let mut left = orient(a, b, point);
            if left == 0 {
                if map.line_axis(h).is_some() {
                    return None;
                }
                left = if map.mesh.is_edge_owner(h) { 1 } else { -1 };
            }
            Some((left > 0) == ((a[fix] < b[fix]) == (fix == 1)))
        }
    }
}

/// v (rounded down) where the line u = c passes the gate.
pub(super) fn crossing(map: &ExactMap<'_>, gate: Gate, c: i64) -> i64 {
    match gate {
        Gate::Corner(h) => map.corner[h].y,
        Gate::Edge(h) => {
            let (a, b) = (map.corner[h], map.corner[next(h)]);
            let (num, den) = (i128::from(c - a.x) * i128::from(b.y - a.y), i128::from(b.x - a.x));
            a.y + num.div_euclid(den) as i64
        }
    }
}

/// Whether the face keeps its orientation, seen from a point between its gates on a line u = c: the upper gate must be
/// crossed towards smaller u when the boundary of the face is walked counter-clockwise.
pub(super) fn is_upright(map: &ExactMap<'_>, gates: [Gate; 2], above: [bool; 2]) -> bool {
    for (gate, above) in gates.into_iter().zip(above) {
        if let Gate::Edge(h) = gate {
            return (map.corner[next(h)].x < map.corner[h].x) == above;
        }
    }
    true
}
