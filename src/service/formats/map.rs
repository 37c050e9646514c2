//! Writing parameterisations.

use super::format::MapFormat;
use super::map_view::MapView;
use super::precision::Shortest;
use super::text_writer::push_line;
use super::{map_glb, map_json};

/// Writes a parameterisation: vertices and triangles in their order, and per corner its coordinates in grid units
/// (1 = one quad edge) in the chart of its triangle.
///
/// OBJ has one `vt` per corner with all digits. GLB has three vertices per triangle in single precision and, as glTF
/// counts v downwards, `TEXCOORD_0` = (u, 1 − v): importers turn it back. JSON adds what is not in the coordinates:
/// transitions, cut edges, singularities, scale.
pub fn write_map(map: &MapView<'_>, format: MapFormat) -> Vec<u8> {
    match format {
        MapFormat::Obj => write_obj(map),
        MapFormat::Glb => map_glb::write(map),
        MapFormat::Json => map_json::write(map),
    }
}

fn write_obj(map: &MapView<'_>) -> Vec<u8> {
    let mut out = Vec::with_capacity(60 * map.positions.len() + 170 * map.faces.len());
    out.extend_from_slice(b"# parameterisation by Quadrille: vt per corner in grid units, 1 = one quad edge\n");
    for p in map.positions {
        push_line(&mut out, format_args!("v {} {} {}", Shortest(p.x), Shortest(p.y), Shortest(p.z)));
    }
    for uv in &map.grid.uv {
        push_line(&mut out, format_args!("vt {} {}", Shortest(uv.x), Shortest(uv.y)));
    }
    for (f, face) in map.faces.iter().enumerate() {
        let [a, b, c] = face.map(|v| u64::from(v) + 1);
        let corner = 3 * f + 1;
        push_line(&mut out, format_args!("f {a}/{corner} {b}/{} {c}/{}", corner + 1, corner + 2));
    }
    out
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{DVec2, DVec3, I64Vec2};

    use super::super::format::Format;
    use super::super::read::read_soup;
    use super::super::soup_builder::ReadLimits;
    use super::*;
    use crate::engine::parameterize::{GridMap, Iso, rotate};
    use crate::engine::pipeline::Singularity;

    /// Two triangles over a square whose second chart is turned by one quarter and moved.
    pub(in super::super) fn square() -> (Vec<DVec3>, Vec<[u32; 3]>, GridMap) {
        let positions = vec![DVec3::ZERO, DVec3::X / 3.0, DVec3::new(1.0, 1.0, 0.0) / 3.0, DVec3::Y / 3.0];
        let faces = vec![[0, 1, 2], [0, 2, 3]];
        // z_0 = i z_1 + (2, -1) over the diagonal: halfedge 2 of face 0 (2 to 0), halfedge 0 of face 1 (0 to 2).
        let (z0, tau) = ([DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y], DVec2::new(2.0, -1.0));
        let z1 = z0.map(|z| rotate(z - tau, 3));
        let uv = vec![z0[0], z0[1], z0[2], z1[0], z1[2], z1[3]];
        let mut grid =
            GridMap { uv, rotation: vec![0; 6], translation: vec![I64Vec2::ZERO; 6], iso: vec![Iso::None; 6] };
        (grid.rotation[2], grid.translation[2]) = (1, I64Vec2::new(2, -1));
        (grid.rotation[3], grid.translation[3]) = (3, I64Vec2::new(1, 2));
        (positions, faces, grid)
    }

    pub(in super::super) fn with_square<T>(test: impl FnOnce(&MapView<'_>) -> T) -> T {
        let (positions, faces, grid) = square();
        let singularities = [Singularity { vertex: 1, index_quarters: -1, uv: [1.0, 0.0] }];
        let (positions, faces, grid) = (&positions, &faces, &grid);
        test(&MapView { positions, faces, grid, scale: 3.0, singularities: &singularities })
    }

    #[test]
    fn obj_keeps_vertices_triangles_and_corners() {
        with_square(|map| {
            let bytes = write_map(map, MapFormat::Obj);
            let soup = read_soup(&bytes, Some(Format::Obj), &ReadLimits::default()).unwrap();
            assert_eq!(soup.positions, map.positions);
            assert!(soup.polygons().eq(map.faces.iter().map(|face| face.as_slice())));
            let text = String::from_utf8(bytes).unwrap();
            let uv: Vec<f64> = text
                .lines()
                .filter_map(|line| line.strip_prefix("vt "))
                .flat_map(|line| line.split(' ').map(|number| number.parse::<f64>().unwrap()))
                .collect();
            assert_eq!(uv, map.grid.uv.iter().flat_map(|z| [z.x, z.y]).collect::<Vec<_>>());
            assert!(text.ends_with("f 1/1 2/2 3/3\nf 1/4 3/5 4/6\n"));
        });
    }
}
