//! Writing quads and reading them back.

use super::error::ReadError;
use super::format::{Format, QuadFormat};
use super::model::Scene;
use super::precision::as_written;
use super::read::read_soup;
use super::soup_builder::ReadLimits;
use super::{ply, quads_glb, quads_obj, quads_usda, usda};
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::TriangleSoup;
use crate::engine::quad::QuadMesh;

/// Writes quads of which no names or joints are known; see [`write_model`].
pub fn write_quads(quads: &QuadMesh, attributes: &QuadAttributes, format: QuadFormat) -> Vec<u8> {
    write_model(quads, attributes, &Scene::default(), format)
}

/// Writes quads. Vertices keep their order in every format, so that an index means the same in every file and in the
/// mesh; quads keep their first corner except in GLB. Positions re-read to the same numbers from OBJ, PLY and USDA, and
/// to the nearest single precision numbers from GLB. OBJ groups the quads by component, in order of their first quads,
/// and within each by material; GLB has one node per object, each with one primitive per material; USDA one prim.
///
/// Colours are in all formats (in OBJ without opacity), texture coordinates and materials in all but PLY. In GLB a
/// vertex whose quads disagree about its texture coordinates is there several times; its copies follow all vertices,
/// and the attribute `_VERTEX` says whose copies they are. Joints and weights are in GLB, with the skeleton of the scene;
/// names of objects are in GLB, OBJ and USDA.
///
/// The indices of the quads and materials must be in range, those of objects and joints in that of the scene, where it has
/// any, and lists of attributes as long as they must be or empty. Positions should be finite; others are written as the
/// format can.
pub fn write_model(quads: &QuadMesh, attributes: &QuadAttributes, scene: &Scene, format: QuadFormat) -> Vec<u8> {
    match format {
        QuadFormat::Obj => quads_obj::write(quads, attributes, scene),
        QuadFormat::Glb => quads_glb::write(quads, attributes, scene),
        QuadFormat::Ply => ply::write(quads, attributes),
        QuadFormat::Usda => quads_usda::write(quads, attributes, scene),
    }
}

/// Reads a file that holds nothing but quads: what [`write_quads`] writes, or another writer's.
///
/// # Errors
/// [`ReadError::NotQuads`] with the first face that is no quad, and all errors of [`read_soup`].
pub fn read_quads(bytes: &[u8], format: QuadFormat) -> Result<QuadMesh, ReadError> {
    let limits = ReadLimits::default();
    let (soup, name) = match format {
        QuadFormat::Obj => (read_soup(bytes, Some(Format::Obj), &limits)?, "OBJ"),
        QuadFormat::Glb => (read_soup(bytes, Some(Format::Glb), &limits)?, "GLB"),
        QuadFormat::Ply => (read_soup(bytes, Some(Format::Ply), &limits)?, "PLY"),
        QuadFormat::Usda => (usda::read(bytes, &limits)?, "USDA"),
    };
    let mut quads = quads_of(soup, name)?;
    if matches!(format, QuadFormat::Obj | QuadFormat::Usda) {
        as_written(&mut quads.positions);
    }
    Ok(quads)
}

fn quads_of(soup: TriangleSoup, format: &'static str) -> Result<QuadMesh, ReadError> {
    if soup.dropped_by_reader > 0 {
        let cause = format!("{} faces have fewer than three different corners", soup.dropped_by_reader);
        return Err(ReadError::malformed(format, "faces", cause));
    }
    let quads = soup.polygons().enumerate().map(|(face, corners)| {
        <[u32; 4]>::try_from(corners).map_err(|_| ReadError::NotQuads {
            format,
            face: face as u64,
            degree: corners.len() as u64,
        })
    });
    let quads = quads.collect::<Result<_, _>>()?;
    Ok(QuadMesh { positions: soup.positions, quads })
}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec3;

    use super::*;

    /// The surface of a cube, n by n quads per side, moved and scaled to numbers that need all their digits.
    pub(in super::super) fn cube(n: u32) -> QuadMesh {
        let mut mesh = QuadMesh::default();
        let mut seen = std::collections::BTreeMap::new();
        let m = n as i32;
        for axis in 0..3 {
            for side in [0, m] {
                for i in 0..m {
                    for j in 0..m {
                        let corner = |di: i32, dj: i32| {
                            let mut p = [0; 3];
                            p[axis] = side;
                            p[(axis + 1) % 3] = i + di;
                            p[(axis + 2) % 3] = j + dj;
                            p
                        };
                        let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if side == 0 {
                            quad.reverse();
                        }
                        let quad = quad.map(|p| {
                            *seen.entry(p).or_insert_with(|| {
                                let p = DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
                                mesh.positions.push(p / 3.0 + DVec3::new(0.1, -1e-7, 12345.678));
                                mesh.positions.len() as u32 - 1
                            })
                        });
                        mesh.quads.push(quad);
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn exact_formats_re_read_to_the_same_mesh() {
        let mesh = cube(3);
        assert_eq!((mesh.positions.len(), mesh.quads.len()), (56, 54));
        let mut single = mesh.clone();
        single.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        for format in [QuadFormat::Obj, QuadFormat::Ply, QuadFormat::Usda] {
            let bytes = write_quads(&mesh, &QuadAttributes::default(), format);
            assert_eq!(read_quads(&bytes, format).unwrap(), mesh, "{format:?}");
            assert_eq!(bytes, write_quads(&mesh, &QuadAttributes::default(), format));
            // What single precision holds is shorter by a tenth at least and comes back the same.
            let short = write_quads(&single, &QuadAttributes::default(), format);
            assert_eq!(read_quads(&short, format).unwrap(), single, "{format:?}");
            assert!(10 * short.len() < 9 * bytes.len(), "{format:?}: {} of {}", short.len(), bytes.len());
        }
    }

    #[test]
    fn one_object_per_component() {
        let mut two = cube(1);
        let shift = two.positions.len() as u32;
        let other = cube(1);
        two.positions.extend(other.positions);
        // The quads of the two components alternate.
        let first = std::mem::take(&mut two.quads);
        for (a, b) in first.iter().zip(other.quads) {
            two.quads.extend([*a, b.map(|v| v + shift)]);
        }
        let text = String::from_utf8(write_quads(&two, &QuadAttributes::default(), QuadFormat::Obj)).unwrap();
        let objects: Vec<_> = text.lines().filter(|line| line.starts_with("o ")).collect();
        assert_eq!(objects, ["o component_1", "o component_2"]);
        let back = read_quads(text.as_bytes(), QuadFormat::Obj).unwrap();
        assert_eq!(back.positions, two.positions);
        assert_eq!(back.quads[..6], first);
        assert_eq!(back.quads.len(), 12);
    }

    #[test]
    fn what_is_no_quad_is_named() {
        let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\n";
        let error = read_quads(text, QuadFormat::Obj).unwrap_err();
        assert_eq!(error, ReadError::NotQuads { format: "OBJ", face: 1, degree: 3 });
        let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2\n";
        assert!(read_quads(text, QuadFormat::Obj).unwrap_err().to_string().contains("1 faces"));
    }
}
