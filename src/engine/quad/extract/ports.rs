//! The ports at which grid lines leave a grid point.

use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::quad::extract::exact_map::ExactMap;

/// How a grid line leaves a grid point. `fix` is the axis that is constant on the line, `run` the other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Port {
    /// Inside a face, along axis `run`, upwards or downwards.
    Axis { run: usize, up: bool },
    /// Along the edge of this halfedge, in its direction or against it.
    Along { edge: u32, forward: bool },
    /// From a point of the edge into the face of this halfedge.
    Into { halfedge: u32 },
    /// From a vertex through the face of this corner.
    Wedge { corner: u32, fix: usize },
}

pub(super) fn push_vertex_ports(map: &ExactMap<'_>, v: u32, ports: &mut Vec<Port>) {
    let mesh = map.mesh;
    for h in mesh.fan(v) {
        push_along(map, h, true, ports);
        let (a, b, c) = (map.corner[h], map.corner[next(h)], map.corner[prev(h)]);
        let opens = |fix: usize| (b[fix] - a[fix]).signum() * (c[fix] - a[fix]).signum() < 0;
        let wedge = |fix: usize| Port::Wedge { corner: h as u32, fix };
        match (opens(0), opens(1)) {
            (true, true) => {
                // Which line crosses the opposite side nearer to its origin b? Shares t = (a - b) / (c - b) of the side.
                let share = |fix: usize| (i128::from((a - b)[fix]).abs(), i128::from((c - b)[fix]).abs());
                let ((p, q), (r, s)) = (share(0), share(1));
                let first = usize::from(p * s > r * q);
                ports.extend([wedge(first), wedge(1 - first)]);
            }
            (true, false) => ports.push(wedge(0)),
            (false, true) => ports.push(wedge(1)),
            (false, false) => {}
        }
        if mesh.is_boundary(prev(h)) {
            push_along(map, prev(h), false, ports);
        }
    }
}

fn push_along(map: &ExactMap<'_>, h: usize, leaves: bool, ports: &mut Vec<Port>) {
    if map.line_axis(h).is_some() {
        let edge = map.mesh.twin(h).map_or(h, |t| t.min(h));
        ports.push(Port::Along { edge: edge as u32, forward: (edge == h) == leaves });
    }
}
