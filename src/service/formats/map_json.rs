//! Parameterisations as JSON.

use glam::I64Vec2;
use serde::Serialize;

use super::map_view::MapView;

#[derive(Serialize)]
struct Map<'a> {
    /// Grid units per model unit.
    scale: f64,
    vertices: Vec<[f64; 3]>,
    triangles: &'a [[u32; 3]],
    /// Per triangle, per corner, in grid units.
    uv: Vec<[[f64; 2]; 3]>,
    /// Per interior edge.
    transitions: Vec<Transition>,
    /// Edges whose transition is not the identity.
    cut_edges: Vec<[u32; 2]>,
    singularities: Vec<Singular>,
}

/// A point of `edge` has the values z in triangle `faces[0]` and z' in `faces[1]` with
/// z = i^rotation z' + translation; `edge` runs as in `faces[0]`.
#[derive(Serialize)]
struct Transition {
    faces: [u32; 2],
    edge: [u32; 2],
    rotation: u8,
    translation: [i64; 2],
}

#[derive(Serialize)]
struct Singular {
    vertex: u32,
    index_quarters: i32,
    uv: [f64; 2],
}

pub(super) fn write(map: &MapView<'_>) -> Vec<u8> {
    let transitions: Vec<Transition> = interior_edges(map.faces)
        .into_iter()
        .map(|(h, twin)| Transition {
            faces: [h / 3, twin / 3],
            edge: side(map.faces, h),
            rotation: map.grid.rotation[h as usize],
            translation: map.grid.translation[h as usize].to_array(),
        })
        .collect();
    let is_cut = |t: &&Transition| t.rotation != 0 || t.translation != I64Vec2::ZERO.to_array();
    let json = Map {
        scale: map.scale,
        vertices: map.positions.iter().map(|p| p.to_array()).collect(),
        triangles: map.faces,
        uv: map.grid.uv.chunks_exact(3).map(|uv| [uv[0].to_array(), uv[1].to_array(), uv[2].to_array()]).collect(),
        cut_edges: transitions.iter().filter(is_cut).map(|t| t.edge).collect(),
        transitions,
        singularities: map
            .singularities
            .iter()
            .map(|s| Singular { vertex: s.vertex, index_quarters: s.index_quarters, uv: s.uv })
            .collect(),
    };
    serde_json::to_vec(&json).expect("numbers and lists always have a JSON form")
}

fn side(faces: &[[u32; 3]], h: u32) -> [u32; 2] {
    let (face, k) = (faces[h as usize / 3], h as usize % 3);
    [face[k], face[(k + 1) % 3]]
}

/// The two halfedges of each edge between two triangles, the lower one first, in order of the lower one.
fn interior_edges(faces: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut sides: Vec<(u32, u32, u32)> = (0..3 * faces.len() as u32)
        .map(|h| {
            let [a, b] = side(faces, h);
            (a.min(b), a.max(b), h)
        })
        .collect();
    sides.sort_unstable();
    let runs = sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)).filter(|run| run.len() == 2);
    let mut edges: Vec<(u32, u32)> = runs.map(|run| (run[0].2, run[1].2)).collect();
    edges.sort_unstable();
    edges
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::map::tests::with_square;
    use super::*;

    #[test]
    fn transitions_join_the_charts() {
        let json: serde_json::Value = with_square(|map| serde_json::from_slice(&write(map)).unwrap());
        assert_eq!(json["scale"], 3.0);
        assert_eq!(json["triangles"], json!([[0, 1, 2], [0, 2, 3]]));
        assert_eq!(
            json["transitions"],
            json!([{"faces": [0, 1], "edge": [2, 0], "rotation": 1, "translation": [2, -1]}])
        );
        assert_eq!(json["cut_edges"], json!([[2, 0]]));
        assert_eq!(json["singularities"], json!([{"vertex": 1, "index_quarters": -1, "uv": [1.0, 0.0]}]));
        // z_0 = i z_1 + tau at vertex 2: corner 2 of face 0, corner 1 of face 1.
        let uv = |f: usize, k: usize, c: usize| json["uv"][f][k][c].as_f64().unwrap();
        assert_eq!([uv(0, 2, 0), uv(0, 2, 1)], [2.0 - uv(1, 1, 1), -1.0 + uv(1, 1, 0)]);
    }
}
