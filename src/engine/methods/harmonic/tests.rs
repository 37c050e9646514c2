//! The method on samples: graphs that are given, graphs of its own, and graphs that cannot be.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::methods::{Data, Harmonic, MapProduct, Method, MethodError, Parameters, Product, Value};
use crate::engine::problem::{Align, Boundary, Optimise, Problem, Wishes, WorkingMesh, split};
use crate::engine::quad::extract::extract_quads;
use crate::engine::run::RunContext;

const WISHES: Wishes = Wishes {
    boundary: Boundary::Align,
    align: Align::Curvature,
    smoothing: 0.5,
    optimise: Optimise::None,
    working_mesh: WorkingMesh::Auto,
    adapts_count: true,
};

pub(super) fn problem(surface: &Surface, quads: f64) -> Problem {
    let edge_length = (surface.mesh.total_area() / quads).sqrt();
    split(surface, edge_length, true, &WISHES, &[], &[], &[]).remove(0)
}

fn propose(problem: &Problem, graph: Option<Data>) -> Result<Box<MapProduct>, MethodError> {
    let mut parameters = Parameters::default();
    if let Some(graph) = graph {
        assert!(parameters.set(Harmonic.parameters(), "graph", Value::Data(Arc::new(graph))));
    }
    propose_with(problem, &parameters)
}

pub(super) fn propose_with(problem: &Problem, parameters: &Parameters) -> Result<Box<MapProduct>, MethodError> {
    match Harmonic.propose(&RunContext::silent(), problem, parameters)? {
        Product::Map(map) => Ok(map),
        other => panic!("{other:?}"),
    }
}

fn quads_of(map: &MapProduct) -> usize {
    let surface = &map.surface;
    let extraction = extract_quads(&RunContext::silent(), &surface.mesh, &surface.features, &map.grid).unwrap();
    assert_eq!(map.measures.flipped, 0);
    extraction.draft.mesh.quads.len()
}

fn record(fields: Vec<(&str, Data)>) -> Data {
    Data::Record(fields.into_iter().map(|(name, data)| (name.to_owned(), data)).collect())
}

/// The sides of a box, counter-clockwise seen from outside; bit k of a corner's number is its side of axis k.
const SIDES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
const TAGS: [&str; 4] = ["u", "v", "-u", "-v"];

/// The graph of a box with these grid units along its axes; `tags` of its sides may be changed.
fn box_graph(half: DVec3, units: [i64; 3], tags: impl Fn(usize, usize) -> usize) -> Data {
    let corner = |k: usize| {
        let sign = |axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
        Data::numbers((half * DVec3::new(sign(0), sign(1), sign(2))).to_array())
    };
    let half_edge = |a: usize, b: usize| {
        let all =
            SIDES.iter().enumerate().flat_map(|(s, side)| (0..4).map(move |k| (s, k, side[k], side[(k + 1) % 4])));
        let (s, k, ..) = all.into_iter().find(|&(_, _, from, to)| (from, to) == (a, b)).unwrap();
        tags(s, k)
    };
    let mut edges = Vec::new();
    for (a, b) in (0..8).flat_map(|a| (0..3).map(move |axis| (a, a ^ (1 << axis)))).filter(|(a, b)| a < b) {
        let (along, against) = (half_edge(a, b), half_edge(b, a));
        let axis = (a ^ b).trailing_zeros() as usize;
        edges.push(record(vec![
            ("ends", Data::numbers([a as f64, b as f64])),
            ("tags", Data::List([along, against].map(|tag| Data::Text(TAGS[tag].to_owned())).to_vec())),
            (if along % 2 == 0 { "du" } else { "dv" }, Data::Number(units[axis] as f64)),
        ]));
    }
    record(vec![("vertices", Data::List((0..8).map(corner).collect())), ("edges", Data::List(edges))])
}

fn half_of(surface: &Surface) -> DVec3 {
    surface.mesh.positions().iter().fold(DVec3::ZERO, |most, p| most.max(p.abs()))
}

#[test]
fn a_given_graph_gives_exactly_the_quads_of_its_patches() {
    let [a, b, c] = [5, 8, 3];
    let surface = sample_surface("cube", 1200).unwrap();
    let problem = problem(&surface, 158.0);
    let map = propose(&problem, Some(box_graph(half_of(&surface), [a, b, c], |_, k| k))).unwrap();
    assert_eq!(quads_of(&map), 2 * (a * b + b * c + c * a) as usize);
    assert!((map.measures.grid_area - 158.0).abs() < 1e-6);
    assert_eq!(map.singularities.len(), 8);
    assert!(map.singularities.iter().all(|s| s.quarters == 1));
    // The charts of the sides may be turned as one likes.
    let turned = box_graph(half_of(&surface), [a, b, c], |s, k| (k + s) % 4);
    assert_eq!(quads_of(&propose(&problem, Some(turned)).unwrap()), 158);
}

#[test]
fn the_graph_of_the_report_gives_the_same_map_again() {
    for (name, quads) in [("cube", 400.0), ("torus", 600.0)] {
        let surface = sample_surface(name, 1200).unwrap();
        let problem = problem(&surface, quads);
        let first = propose(&problem, None).unwrap();
        let again = propose(&problem, Some(first.details.get("graph").clone())).unwrap();
        assert_eq!(quads_of(&first), quads_of(&again), "{name}");
        assert!((first.measures.grid_area - again.measures.grid_area).abs() < 1e-6, "{name}");
        assert!((first.measures.arap_mean - again.measures.arap_mean).abs() < 2e-3, "{name}");
    }
}

#[test]
fn a_graph_of_its_own_suits_every_sample() {
    for (name, singular) in [("cube", 8), ("torus", 0), ("sphere", 8), ("half_pipe", 0)] {
        let surface = sample_surface(name, 2000).unwrap();
        let problem = problem(&surface, 600.0);
        let map = propose(&problem, None).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!((map.measures.grid_area / 600.0 - 1.0).abs() < 0.15, "{name}: {}", map.measures.grid_area);
        assert_eq!(map.singularities.len(), singular, "{name}");
        let index: i32 = map.singularities.iter().map(|s| s.quarters).sum();
        let topology = surface.mesh.topology();
        if topology.boundaries == 0 {
            assert_eq!(i64::from(index), 4 * topology.euler, "{name}");
        }
        assert!(quads_of(&map) > 500 && map.measures.seam_residual < 1e-9, "{name}");
    }
}

#[test]
fn graphs_that_cannot_be_are_refused_with_the_face_and_the_equation() {
    let surface = sample_surface("cube", 1200).unwrap();
    let problem = problem(&surface, 158.0);
    let half = half_of(&surface);
    let cause = |graph: Data| match propose(&problem, Some(graph)) {
        Err(MethodError::Refused { cause }) => cause,
        other => panic!("{other:?}"),
    };
    // A side whose first half edge runs the wrong way.
    let turned = cause(box_graph(half, [5, 8, 3], |s, k| if (s, k) == (1, 0) { 1 } else { k }));
    assert!(turned.contains("turn by") && turned.contains("meta-vertices"), "{turned}");
    // One edge longer than the other three along its axis.
    let mut open = box_graph(half, [5, 8, 3], |_, k| k);
    edges(&mut open)[0] = with(&edges(&mut open)[0], "du", "dv", 9.0);
    let open = cause(open);
    assert!(open.contains("is not closed: Σ D"), "{open}");
    // Four edges around one side: beyond them lies the rest of the box, a disc as well, but of no turning.
    let mut less = box_graph(half, [5, 8, 3], |_, k| k);
    let side = |edge: &Data| edge.get("ends").list().iter().all(|end| end.number().unwrap() < 4.0);
    edges(&mut less).retain(side);
    assert_eq!(edges(&mut less).len(), 4);
    let less = cause(less);
    assert!(less.contains("turn by"), "{less}");
    // Two opposite edges: what lies around them is a ring.
    let mut ring = box_graph(half, [5, 8, 3], |_, k| k);
    edges(&mut ring).truncate(2);
    edges(&mut ring).remove(0);
    let mut other = box_graph(half, [5, 8, 3], |_, k| k);
    let last = edges(&mut other).pop().unwrap();
    edges(&mut ring).push(last);
    let ring = cause(ring);
    assert!(ring.contains("is not a disc"), "{ring}");
    // Two meta-vertices at the same place.
    let Data::Record(mut fields) = box_graph(half, [5, 8, 3], |_, k| k) else { panic!() };
    if let Data::List(vertices) = &mut fields[0].1 {
        vertices[1] = vertices[0].clone();
    }
    assert!(cause(Data::Record(fields)).contains("at the same place"));
}

fn edges(graph: &mut Data) -> &mut Vec<Data> {
    let Data::Record(fields) = graph else { panic!("no record") };
    match &mut fields[1].1 {
        Data::List(edges) => edges,
        _ => panic!("no list"),
    }
}

/// An edge with other grid units.
fn with(edge: &Data, own: &str, other: &str, units: f64) -> Data {
    let Data::Record(fields) = edge else { panic!("no record") };
    let set = |(name, data): &(String, Data)| match name == own || name == other {
        true => (name.clone(), Data::Number(units)),
        false => (name.clone(), data.clone()),
    };
    Data::Record(fields.iter().map(set).collect())
}
