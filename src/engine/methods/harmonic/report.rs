//! A singularity graph as data that can be edited and given again.

use crate::engine::mesh::{TriMesh, next};
use crate::engine::methods::Data;
use crate::engine::methods::harmonic::given::{GivenGraph, Place};
use crate::engine::methods::harmonic::graph::SingularityGraph;
use crate::engine::methods::harmonic::tag::name;
use crate::engine::problem::Problem;

/// Points of a path are this far apart at least, in quad edges: between them it may run as it likes.
const APART: f64 = 0.5;
/// A meta-vertex belongs to a component if it is at most this far from it, in quad edges.
const OFF: f64 = 1.0;

/// The graph as the parameter `graph` says it.
pub(super) fn data_of(graph: &SingularityGraph, mesh: &TriMesh, is_held: &[bool], edge_length: f64) -> Data {
    let record = |fields: Vec<(&str, Data)>| {
        Data::Record(fields.into_iter().map(|(name, data)| (name.to_owned(), data)).collect())
    };
    let place = |v: u32| Data::numbers(mesh.position(v).to_array());
    let vertex = |&v: &u32| record(vec![("at", place(v)), ("held", Data::Switch(is_held[v as usize]))]);
    let edges = graph.edges.iter().map(|edge| {
        let mut last = mesh.position(mesh.origin(edge.path[0]));
        let mut path = Vec::new();
        for &h in edge.path.iter().skip(1) {
            let v = mesh.origin(h);
            if mesh.position(v).distance(last) >= APART * edge_length {
                last = mesh.position(v);
                path.push(place(v));
            }
        }
        debug_assert!(edge.path.windows(2).all(|h| mesh.origin(next(h[0])) == mesh.origin(h[1])));
        record(vec![
            ("ends", Data::numbers(edge.ends.map(f64::from))),
            ("tags", Data::List(edge.tags.iter().map(|&tag| Data::Text(name(tag).to_owned())).collect())),
            (if edge.tags[0] % 2 == 0 { "du" } else { "dv" }, Data::Number(edge.extent as f64)),
            ("path", Data::List(path)),
        ])
    });
    let graph = record(vec![
        ("vertices", Data::List(graph.vertices.iter().map(vertex).collect())),
        ("edges", Data::List(edges.collect())),
    ]);
    record(vec![("graph", graph)])
}

/// Whether a graph is one of this component: one of its meta-vertices is.
pub(super) fn lies_on(graph: &GivenGraph, problem: &Problem) -> bool {
    graph.vertices.iter().any(|vertex| match vertex.place {
        Place::At(p) => problem.index.closest(p).position.distance(p) <= OFF * problem.edge_length,
        Place::Input(v) => problem.inputs.contains(&v),
    })
}
