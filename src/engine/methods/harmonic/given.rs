//! A singularity graph as a parameter: what may stand there, and reading it.

use glam::DVec3;

use crate::engine::methods::harmonic::tag::{Tag, of_name};
use crate::engine::methods::{Data, Shape};

/// Most vertices, edges and points of a path that a graph may have.
const MOST: usize = 100_000;
/// Most grid units of an edge.
const MOST_UNITS: f64 = 65_536.0;

/// The shape of the parameter.
pub(super) const SHAPE: Shape = Shape {
    schema: r#"{"type": ["object", "null"], "required": ["vertices", "edges"], "additionalProperties": false, "properties": {
        "vertices": {"type": "array", "description": "Meta-vertices: a place [x, y, z] in model units, which goes to the nearest vertex of the working mesh, a vertex of the input by its number from 0, or an object with `at` (one of these) and `held`, whether the map puts it on its integer point (default true).", "items": {"oneOf": [{"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}, {"type": "integer", "minimum": 0}, {"type": "object", "required": ["at"], "additionalProperties": false, "properties": {"at": {"oneOf": [{"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}, {"type": "integer", "minimum": 0}]}, "held": {"type": "boolean"}}}]}},
        "edges": {"type": "array", "description": "Meta-edges, which cut the surface into discs.", "items": {"type": "object", "required": ["ends", "tags"], "additionalProperties": false, "properties": {
            "ends": {"type": "array", "description": "Numbers of the meta-vertices at its ends, from 0.", "minItems": 2, "maxItems": 2, "items": {"type": "integer", "minimum": 0}},
            "tags": {"type": "array", "description": "How the two half edges run in the charts of the faces on their left: from the first end to the second, and back.", "minItems": 2, "maxItems": 2, "items": {"type": "string", "enum": ["u", "v", "-u", "-v"]}},
            "path": {"type": "array", "description": "Points [x, y, z] near which it runs; without them it takes the shortest way that crosses no earlier edge.", "items": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}},
            "du": {"type": "integer", "minimum": 0, "description": "Grid units in u, of an edge whose first tag is u or -u."},
            "dv": {"type": "integer", "minimum": 0, "description": "Grid units in v, of an edge whose first tag is v or -v."}}}}}}"#,
    check: |data| read(data).err().unwrap_or_default(),
};

/// Where a meta-vertex is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// A place in model units.
    At(DVec3),
    /// A vertex of the input.
    Input(u32),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct GivenVertex {
    pub(super) place: Place,
    pub(super) is_held: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct GivenEdge {
    pub(super) ends: [u32; 2],
    pub(super) tags: [Tag; 2],
    pub(super) path: Vec<DVec3>,
    pub(super) extent: Option<i64>,
}

/// A graph as it was given.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GivenGraph {
    pub(super) vertices: Vec<GivenVertex>,
    pub(super) edges: Vec<GivenEdge>,
}

/// JSON pointers and what must hold there.
type Wrong = Vec<(String, String)>;

/// Reads a graph.
///
/// # Errors
/// All that is wrong with it.
pub(super) fn read(data: &Data) -> Result<GivenGraph, Wrong> {
    let mut wrong = Wrong::new();
    let mut must = |pointer: String, what: &str| wrong.push((pointer, what.to_owned()));
    let Data::Record(fields) = data else {
        return Err(vec![(String::new(), "must be an object".to_owned())]);
    };
    for (name, _) in fields.iter().filter(|(name, _)| name != "vertices" && name != "edges") {
        must(format!("/{name}"), "unknown; there is vertices, edges");
    }
    let (vertices, edges) = (data.get("vertices").list(), data.get("edges").list());
    if vertices.is_empty() || vertices.len() > MOST {
        must("/vertices".to_owned(), "must be a list of 1 to 100000 meta-vertices");
    }
    if edges.is_empty() || edges.len() > MOST {
        must("/edges".to_owned(), "must be a list of 1 to 100000 meta-edges");
    }
    let mut graph = GivenGraph { vertices: Vec::new(), edges: Vec::new() };
    for (i, data) in vertices.iter().enumerate().take(MOST) {
        match vertex(data) {
            Some(vertex) => graph.vertices.push(vertex),
            None => must(format!("/vertices/{i}"), "must be [x, y, z], the number of an input vertex, or {at, held}"),
        }
    }
    for (i, data) in edges.iter().enumerate().take(MOST) {
        match edge(data, vertices.len()) {
            Ok(edge) => graph.edges.push(edge),
            Err((below, what)) => must(format!("/edges/{i}{below}"), what),
        }
    }
    if wrong.is_empty() { Ok(graph) } else { Err(wrong) }
}

fn vertex(data: &Data) -> Option<GivenVertex> {
    match data {
        Data::Record(_) => {
            let is_held = match data.get("held") {
                Data::None => true,
                Data::Switch(held) => *held,
                _ => return None,
            };
            Some(GivenVertex { place: place(data.get("at"))?, is_held })
        }
        _ => Some(GivenVertex { place: place(data)?, is_held: true }),
    }
}

fn place(data: &Data) -> Option<Place> {
    match data {
        Data::Number(_) => whole(data, f64::from(u32::MAX - 1)).map(|v| Place::Input(v as u32)),
        _ => point(data).map(Place::At),
    }
}

fn point(data: &Data) -> Option<DVec3> {
    let [x, y, z] = data.list() else { return None };
    let point = DVec3::new(x.number()?, y.number()?, z.number()?);
    point.is_finite().then_some(point)
}

fn whole(data: &Data, most: f64) -> Option<i64> {
    data.number().filter(|x| x.fract() == 0.0 && (0.0..=most).contains(x)).map(|x| x as i64)
}

fn edge(data: &Data, n_vertices: usize) -> Result<GivenEdge, (&'static str, &'static str)> {
    let Data::Record(fields) = data else { return Err(("", "must be an object with ends and tags")) };
    if fields.iter().any(|(name, _)| !["ends", "tags", "path", "du", "dv"].contains(&name.as_str())) {
        return Err(("", "has unknown fields; there is ends, tags, path, du, dv"));
    }
    let of = |data: &Data| whole(data, n_vertices as f64 - 1.0).map(|v| v as u32);
    let ends = match data.get("ends").list() {
        [a, b] => of(a).zip(of(b)),
        _ => None,
    };
    let (a, b) = ends.ok_or(("/ends", "must be two numbers of meta-vertices of this graph, from 0"))?;
    let tag = |data: &Data| data.text().and_then(of_name);
    let tags = match data.get("tags").list() {
        [a, b] => tag(a).zip(tag(b)),
        _ => None,
    };
    let (along, against) = tags.ok_or(("/tags", "must be two of u, v, -u, -v"))?;
    let path: Option<Vec<DVec3>> = data.get("path").list().iter().map(point).collect();
    let path = path.filter(|path| path.len() <= MOST).ok_or(("/path", "must be a list of points [x, y, z]"))?;
    let (own, other) = if along % 2 == 0 { ("du", "dv") } else { ("dv", "du") };
    if !matches!(data.get(other), Data::None) && whole(data.get(other), 0.0).is_none() {
        return Err(("", "runs along one coordinate, so du or dv is 0, as the first tag says"));
    }
    let extent = match data.get(own) {
        Data::None => None,
        units => Some(whole(units, MOST_UNITS).ok_or(("", "has du or dv that is no whole number of 0 to 65536"))?),
    };
    Ok(GivenEdge { ends: [a, b], tags: [along, against], path, extent })
}
