//! From port to port along grid lines, with exact comparisons only.

use glam::I64Vec2;

use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::quad::extract::exact_map::ExactMap;
use crate::engine::quad::extract::gates::Gate;
use crate::engine::quad::extract::gates::gates;
use crate::engine::quad::extract::gates::is_above;
use crate::engine::quad::extract::nodes::Nodes;
use crate::engine::quad::extract::nodes::Place;
use crate::engine::quad::extract::ports::Port;

/// Where a grid line ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    /// At a grid point.
    Node {
        /// The port that leads back.
        port: u32,
        /// The line came back to the grid point where it began: it lies in a fold.
        collapsed: bool,
    },
    /// At the boundary, which does not follow the grid: on this halfedge, or at its origin where a feature ends.
    Outside {
        /// The halfedge of the boundary.
        halfedge: usize,
    },
}

/// A line on its way: the grid point where it began, carried along into the chart of the present face, and the axis
/// that is constant on the line.
#[derive(Clone, Copy)]
struct Line {
    start: I64Vec2,
    fix: usize,
}

/// Follows the line that leaves node `node` through port `port`. `None` where it runs into a curve on which it does
/// not belong; only folds have such lines.
pub(super) fn trace(map: &ExactMap<'_>, nodes: &Nodes, node: u32, port: u32) -> Option<Arrival> {
    let here = nodes.nodes[node as usize];
    match nodes.ports[port as usize] {
        Port::Axis { run, up } => {
            let Place::Face(f, _) = here.place else { return None };
            let (f, fix) = (f as usize, 1 - run);
            let mut neighbour = here.point;
            neighbour[run] += if up { map.one } else { -map.one };
            if let Some(n) = nodes.in_face(f, neighbour) {
                return Some(Arrival::Node { port: nodes.port(n, Port::Axis { run, up: !up })?, collapsed: false });
            }
            let both = gates(map, f, fix, here.point[fix])?;
            let first_is_above = is_above(map, both[0], fix, here.point)?;
            let exit = both[usize::from(first_is_above != up)];
            leave(map, nodes, exit, Line { start: here.point, fix })
        }
        Port::Into { halfedge } => {
            let h = halfedge as usize;
            let Place::Edge(edge) = here.place else { return None };
            let start = if h == edge as usize { here.point } else { map.across[edge as usize].apply(here.point) };
            let fix = 1 - map.line_axis(h)?;
            cross(map, nodes, Gate::Edge(h), Line { start, fix })
        }
        Port::Wedge { corner, fix } => {
            let corner = corner as usize;
            cross(map, nodes, Gate::Corner(corner), Line { start: map.corner[corner], fix })
        }
        Port::Along { edge, forward } => {
            let start = match here.place {
                Place::Vertex(_) => map.corner[if forward { edge as usize } else { next(edge as usize) }],
                _ => here.point,
            };
            let from = matches!(here.place, Place::Edge(_)).then_some(node);
            follow(map, nodes, edge as usize, forward, from, start)
        }
    }
}

/// Goes through faces from the gate `entry` on to the next node.
fn cross(map: &ExactMap<'_>, nodes: &Nodes, entry: Gate, line: Line) -> Option<Arrival> {
    let (mut entry, mut line) = (entry, line);
    loop {
        let f = match entry {
            Gate::Edge(h) | Gate::Corner(h) => h / 3,
        };
        let c = line.start[line.fix];
        if let Some((lowest, highest)) = nodes.on_line(f, line.fix, c) {
            let down = is_above(map, entry, line.fix, nodes.nodes[lowest as usize].point)?;
            let n = if down { highest } else { lowest };
            let port = nodes.port(n, Port::Axis { run: 1 - line.fix, up: down })?;
            return Some(Arrival::Node { port, collapsed: nodes.nodes[n as usize].point == line.start });
        }
        let both = gates(map, f, line.fix, c)?;
        let exit = if both[0] == entry { both[1] } else { both[0] };
        match step(map, exit, line) {
            Some((gate, moved)) => (entry, line) = (gate, moved),
            None => return leave(map, nodes, exit, line),
        }
    }
}

/// The line in the next face, unless there is a node or an end at the gate.
fn step(map: &ExactMap<'_>, exit: Gate, line: Line) -> Option<(Gate, Line)> {
    let Gate::Edge(h) = exit else { return None };
    if map.line_axis(h).is_some() {
        return None;
    }
    let t = map.mesh.twin(h)?;
    let to = map.across[h];
    Some((Gate::Edge(t), Line { start: to.apply(line.start), fix: (line.fix + to.quarters as usize) & 1 }))
}

fn leave(map: &ExactMap<'_>, nodes: &Nodes, exit: Gate, line: Line) -> Option<Arrival> {
    if let Some((entry, line)) = step(map, exit, line) {
        return cross(map, nodes, entry, line);
    }
    match exit {
        Gate::Edge(h) => {
            // The edge lies on a grid line: the crossing is a grid point.
            let mut point = line.start;
            point[1 - line.fix] = map.corner[h][1 - line.fix];
            if map.mesh.is_boundary(h) && map.line_axis(h).is_none() {
                return Some(Arrival::Outside { halfedge: h });
            }
            let edge = map.mesh.twin(h).map_or(h, |t| t.min(h));
            let there = if edge == h { point } else { map.across[h].apply(point) };
            let n = nodes.on_edge(edge, there)?;
            let port = nodes.port(n, Port::Into { halfedge: h as u32 })?;
            Some(Arrival::Node { port, collapsed: point == line.start })
        }
        Gate::Corner(h) => {
            let n = nodes.at_vertex[map.mesh.origin(h) as usize]?;
            let port = nodes.port(n, Port::Wedge { corner: h as u32, fix: line.fix })?;
            Some(Arrival::Node { port, collapsed: map.corner[h] == line.start })
        }
    }
}

/// Goes along edges that lie on the line: from node `from` of the edge, or from its end.
fn follow(
    map: &ExactMap<'_>,
    nodes: &Nodes,
    edge: usize,
    forward: bool,
    from: Option<u32>,
    start: I64Vec2,
) -> Option<Arrival> {
    let (mesh, first_edge) = (map.mesh, edge);
    let (mut edge, mut forward, mut from, mut start) = (edge, forward, from, start);
    loop {
        let (low, high) = (nodes.at_edge[edge], nodes.at_edge[edge + 1]);
        let beyond = match (from, forward) {
            (Some(n), true) => n + 1,
            (Some(n), false) => n.wrapping_sub(1),
            (None, true) => low,
            (None, false) => high.wrapping_sub(1),
        };
        if (low..high).contains(&beyond) {
            let port = nodes.port(beyond, Port::Along { edge: edge as u32, forward: !forward })?;
            return Some(Arrival::Node { port, collapsed: nodes.nodes[beyond as usize].point == start });
        }
        let corner = if forward { next(edge) } else { edge };
        let v = mesh.origin(corner);
        if let Some(n) = nodes.at_vertex[v as usize] {
            let port = nodes.port(n, Port::Along { edge: edge as u32, forward: !forward })?;
            return Some(Arrival::Node { port, collapsed: map.corner[corner] == start });
        }
        if !map.guided[edge] {
            return None;
        }
        if mesh.is_boundary_vertex(v) && !mesh.is_boundary(edge) {
            return mesh.fan(v).find(|&h| mesh.is_boundary(h)).map(|halfedge| Arrival::Outside { halfedge });
        }
        let onward = guided_edges(map, v).into_iter().find(|&e| e != edge)?;
        if onward == first_edge {
            return None;
        }
        forward = mesh.origin(onward) == v;
        let there = if forward { onward } else { next(onward) };
        start = map.around(corner, there).apply(start);
        (edge, from) = (onward, None);
    }
}

/// The two guided edges on grid lines at a curve vertex, or none if there are not two.
fn guided_edges(map: &ExactMap<'_>, v: u32) -> Vec<usize> {
    let mesh = map.mesh;
    let mut edges = Vec::new();
    for h in mesh.fan(v) {
        for side in [h, prev(h)] {
            if (side == h || mesh.is_boundary(side)) && map.guided[side] && map.line_axis(side).is_some() {
                edges.push(mesh.twin(side).map_or(side, |t| t.min(side)));
            }
        }
    }
    if edges.len() != 2 {
        edges.clear();
    }
    edges
}
