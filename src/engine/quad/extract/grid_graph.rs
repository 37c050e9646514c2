//! Grid points and grid lines as a graph embedded in the surface.

use crate::engine::mesh::Features;
use crate::engine::mesh::prev;
use crate::engine::quad::Anchor;
use crate::engine::quad::extract::exact_map::ExactMap;
use crate::engine::quad::extract::nodes::Nodes;
use crate::engine::quad::extract::nodes::Place;
use crate::engine::quad::extract::ports::Port;
use crate::engine::quad::extract::trace::{Arrival, trace};
use crate::engine::quad::extract::turns::port_turns;
use crate::engine::quad::fill::EmbeddedGraph;
use crate::engine::quad::fill::GraphArc;
use crate::engine::quad::fill::GraphNode;
use crate::engine::quad::fill::Tag;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// A port whose grid line ends at the boundary.
pub(super) struct PortOut {
    port: u32,
    /// The dart clockwise of the port at its node.
    pub(super) before: u32,
    /// The boundary halfedge that the line meets; a feature meets its origin.
    pub(super) halfedge: usize,
    /// Whether the line is a feature.
    pub(super) is_feature: bool,
}

/// Traces all grid lines; also says which of them end at a boundary that is off the grid.
pub(super) fn grid_graph(
    ctx: &RunContext,
    map: &ExactMap<'_>,
    features: &Features,
    nodes: &Nodes,
) -> Result<(EmbeddedGraph, Vec<PortOut>), Cancelled> {
    let mesh = map.mesh;
    let on_curve = |h: usize| mesh.is_boundary(h) || features.is_edge(mesh.origin(h), mesh.target(h));
    let graph_nodes = (0..nodes.nodes.len()).map(|n| {
        let anchor = match nodes.nodes[n].place {
            Place::Vertex(v) if features.is_corner(v) => Anchor::Corner(v),
            Place::Vertex(v) if mesh.fan(v).any(|h| on_curve(h) || on_curve(prev(h))) => Anchor::Curve,
            Place::Edge(h) if on_curve(h as usize) => Anchor::Curve,
            _ => Anchor::Surface,
        };
        GraphNode { position: nodes.position(map, n), anchor }
    });
    let graph_nodes = graph_nodes.collect();

    // Per port, the dart that leaves through it.
    let mut dart = vec![u32::MAX; nodes.ports.len()];
    let (mut arcs, mut out) = (Vec::new(), Vec::new());
    let mut node_of_port = vec![0u32; nodes.ports.len()];
    for n in 0..nodes.nodes.len() as u32 {
        for p in nodes.first_port[n as usize]..nodes.first_port[n as usize + 1] {
            node_of_port[p as usize] = n;
        }
    }
    for port in 0..nodes.ports.len() as u32 {
        if port % 4096 == 0 {
            ctx.check()?;
        }
        if dart[port as usize] != u32::MAX {
            continue;
        }
        let (arrival, collapsed) = match trace(map, nodes, node_of_port[port as usize], port) {
            None => continue,
            Some(Arrival::Outside { halfedge }) => {
                let is_feature = matches!(nodes.ports[port as usize], Port::Along { .. });
                out.push(PortOut { port, halfedge, is_feature, before: u32::MAX });
                continue;
            }
            Some(Arrival::Node { port, collapsed }) => (port, collapsed),
        };
        if arrival == port || dart[arrival as usize] != u32::MAX {
            continue;
        }
        let tag = match nodes.ports[port as usize] {
            Port::Along { edge, .. } if mesh.is_boundary(edge as usize) => Tag::Boundary,
            Port::Along { edge, .. } if on_curve(edge as usize) => Tag::Feature,
            _ => Tag::Plain,
        };
        dart[port as usize] = 2 * arcs.len() as u32;
        dart[arrival as usize] = 2 * arcs.len() as u32 + 1;
        let ends = [node_of_port[port as usize], node_of_port[arrival as usize]];
        let outside = [port, arrival].map(|p| leaves_outside(map, nodes.ports[p as usize]));
        arcs.push(GraphArc { ends, tag, collapsed, outside });
    }
    let rotation = (0..nodes.nodes.len()).map(|n| {
        // A port without an arc gives its turn to the port before it.
        let (start, end) = (nodes.first_port[n] as usize, nodes.first_port[n + 1] as usize);
        let turns = port_turns(map, nodes, n);
        let mut darts: Vec<(u32, i32)> = Vec::with_capacity(turns.len());
        let mut before_first = 0;
        for (&d, turn) in dart[start..end].iter().zip(turns) {
            match darts.last_mut() {
                _ if d != u32::MAX => darts.push((d, turn)),
                Some(last) => last.1 += turn,
                None => before_first += turn,
            }
        }
        if let Some(last) = darts.last_mut() {
            last.1 += before_first;
        }
        darts
    });
    let graph = EmbeddedGraph::new(graph_nodes, &arcs, rotation);
    for port_out in &mut out {
        let node = node_of_port[port_out.port as usize] as usize;
        let (start, end) = (nodes.first_port[node], nodes.first_port[node + 1]);
        let clockwise = (start..port_out.port).rev().chain((port_out.port + 1..end).rev());
        let mut darts = clockwise.map(|p| dart[p as usize]);
        port_out.before = darts.find(|&d| d != u32::MAX).unwrap_or(u32::MAX);
    }
    out.retain(|port_out| port_out.before != u32::MAX);
    Ok((graph, out))
}

/// Whether the outside of the surface is to the left of the line that leaves through `port`: it runs against the
/// boundary.
fn leaves_outside(map: &ExactMap<'_>, port: Port) -> bool {
    matches!(port, Port::Along { edge, forward: false } if map.mesh.is_boundary(edge as usize))
}

/// How many feature edges do not lie on a grid line of the map.
pub(super) fn features_off_grid(map: &ExactMap<'_>, features: &Features) -> usize {
    let mesh = map.mesh;
    let off = |&h: &usize| {
        mesh.is_edge_owner(h)
            && features.is_edge(mesh.origin(h), mesh.target(h))
            && (map.line_axis(h).is_none() || !map.guided[h])
    };
    (0..mesh.n_halfedges()).filter(off).count()
}
