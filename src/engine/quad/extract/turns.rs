//! The quarter turns from port to port around a grid point.

use crate::engine::mesh::next;
use crate::engine::quad::extract::exact_map::ExactMap;
use crate::engine::quad::extract::gates::Gate;
use crate::engine::quad::extract::gates::is_above;
use crate::engine::quad::extract::nodes::Nodes;
use crate::engine::quad::extract::nodes::Place;
use crate::engine::quad::extract::ports::Port;

/// Per port of node `n`, the quarter turns in the map from it to the next port counter-clockwise: no port lies between
/// them, so this is 1, −1 (where the map is flipped), or 0 (where a fold turns back in between).
pub(super) fn port_turns(map: &ExactMap<'_>, nodes: &Nodes, n: usize) -> Vec<i32> {
    let ports = &nodes.ports[nodes.first_port[n] as usize..nodes.first_port[n + 1] as usize];
    match nodes.nodes[n].place {
        Place::Face(_, upright) => vec![if upright { 1 } else { -1 }; 4],
        Place::Edge(edge) => {
            let sign = |h: usize| if map.orientation(h / 3) < 0 { -1 } else { 1 };
            let left = sign(edge as usize);
            let right = map.mesh.twin(edge as usize).map_or(left, sign);
            [left, left, right, right][..ports.len()].to_vec()
        }
        Place::Vertex(v) => {
            // Directions in the chart of the first corner, carried on around the vertex.
            let mut directions: Vec<i32> = ports.iter().filter_map(|&port| direction(map, v, port)).collect();
            let once = map.turn_around(v);
            let Some(&first) = directions.first() else { return Vec::new() };
            directions.push(first + i32::from(once));
            let turn = |w: &[i32]| match (w[1] - w[0]).rem_euclid(4) {
                3 => -1,
                quarters => quarters,
            };
            directions.windows(2).map(turn).collect()
        }
    }
}

/// Direction of a port of vertex `v` in quarter turns, in the chart of the first corner of the vertex.
fn direction(map: &ExactMap<'_>, v: u32, port: Port) -> Option<i32> {
    let (corner, run, up) = match port {
        Port::Wedge { corner, fix } => {
            let corner = corner as usize;
            let up = is_above(map, Gate::Edge(next(corner)), fix, map.corner[corner]).unwrap_or(true);
            (corner, 1 - fix, up)
        }
        Port::Along { edge, forward } => {
            let edge = edge as usize;
            let (here, there) = if forward { (edge, next(edge)) } else { (next(edge), edge) };
            let run = 1 - map.line_axis(edge)?;
            (here, run, map.corner[there][run] > map.corner[here][run])
        }
        Port::Axis { .. } | Port::Into { .. } => return None,
    };
    debug_assert_eq!(map.mesh.origin(corner), v);
    let quarters = run as i32 + if up { 0 } else { 2 };
    Some(quarters + i32::from(map.quarters_to_root(corner)))
}
