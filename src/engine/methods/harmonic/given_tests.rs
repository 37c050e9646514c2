//! Graphs as data: what is read, and what is refused where.

use glam::DVec3;

use crate::engine::methods::Data;
use crate::engine::methods::harmonic::given::{GivenEdge, GivenVertex, Place, SHAPE, read};

fn record(fields: Vec<(&str, Data)>) -> Data {
    Data::Record(fields.into_iter().map(|(name, data)| (name.to_owned(), data)).collect())
}

fn tags(a: &str, b: &str) -> Data {
    Data::List([a, b].map(|tag| Data::Text(tag.to_owned())).to_vec())
}

#[test]
fn a_graph_is_read_as_it_stands() {
    let vertices = vec![
        Data::numbers([1.0, 2.0, 3.0]),
        Data::Number(7.0),
        record(vec![("at", Data::numbers([0.0; 3])), ("held", Data::Switch(false))]),
    ];
    let edge = record(vec![
        ("ends", Data::numbers([2.0, 0.0])),
        ("tags", tags("-v", "u")),
        ("dv", Data::Number(4.0)),
        ("du", Data::Number(0.0)),
        ("path", Data::List(vec![Data::numbers([0.5; 3])])),
    ]);
    let graph = read(&record(vec![("vertices", Data::List(vertices)), ("edges", Data::List(vec![edge]))])).unwrap();
    let held = |place| GivenVertex { place, is_held: true };
    assert_eq!(graph.vertices[..2], [held(Place::At(DVec3::new(1.0, 2.0, 3.0))), held(Place::Input(7))]);
    assert!(!graph.vertices[2].is_held);
    let wanted = GivenEdge { ends: [2, 0], tags: [3, 0], path: vec![DVec3::splat(0.5)], extent: Some(4) };
    assert_eq!(graph.edges, [wanted]);
}

#[test]
fn everything_that_is_wrong_is_named_with_its_place() {
    let edge = |ends: [f64; 2], a: &str, more: Vec<(&str, Data)>| {
        record([vec![("ends", Data::numbers(ends)), ("tags", tags(a, "u"))], more].concat())
    };
    let vertices = vec![Data::numbers([0.0; 3]), Data::numbers([1.0; 2]), Data::Number(-1.0)];
    let edges = vec![
        edge([0.0, 1.0], "u", Vec::new()),
        edge([0.0, 3.0], "u", Vec::new()),
        edge([0.0, 1.5], "u", Vec::new()),
        edge([0.0, 1.0], "x", Vec::new()),
        edge([0.0, 1.0], "u", vec![("dv", Data::Number(2.0))]),
        edge([0.0, 1.0], "v", vec![("dv", Data::Number(0.5))]),
        edge([0.0, 1.0], "u", vec![("path", Data::List(vec![Data::Number(1.0)]))]),
        edge([0.0, 1.0], "u", vec![("colour", Data::Number(1.0))]),
    ];
    let graph = record(vec![("vertices", Data::List(vertices)), ("edges", Data::List(edges)), ("faces", Data::None)]);
    let pointers: Vec<String> = (SHAPE.check)(&graph).into_iter().map(|(pointer, _)| pointer).collect();
    let wanted = [
        "/faces",
        "/vertices/1",
        "/vertices/2",
        "/edges/1/ends",
        "/edges/2/ends",
        "/edges/3/tags",
        "/edges/4",
        "/edges/5",
        "/edges/6/path",
        "/edges/7",
    ];
    assert_eq!(pointers, wanted);
    assert_eq!((SHAPE.check)(&Data::Number(1.0)).len(), 1);
    assert_eq!((SHAPE.check)(&record(Vec::new())).len(), 2);
}
