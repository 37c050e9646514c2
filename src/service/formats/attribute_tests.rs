//! Attributes in the files of quads: a cube that has all of them, and how to compare what was read.

use std::collections::BTreeMap;

use serde_json::Value;

use super::quads::tests::cube;
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::Influences;
use crate::engine::mesh::TriangleSoup;
use crate::engine::quad::QuadMesh;

mod glb;
mod names;
mod values;
mod without_attributes;

/// One of the six directions along an axis.
fn axis(i: usize) -> [f32; 3] {
    let mut axis = [0.0; 3];
    axis[i % 3] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    axis
}

/// A cube whose sides have charts of their own, normals that differ from quad to quad, and materials that change from quad to quad; one of them has no name.
pub(super) fn painted() -> (QuadMesh, QuadAttributes) {
    let mesh = cube(3);
    let n = mesh.quads.len();
    let names = ["paint (old)", "", "2nd", "2nd "];
    let number = |i: usize, k: usize| ((7 * i + 3 * k) % 11) as f32;
    let attributes = QuadAttributes {
        materials: (0..n as u32).map(|q| (q + q * q / 5) % 4).collect(),
        material_names: names.map(str::to_owned).to_vec(),
        colours: (0..mesh.positions.len()).map(|v| [0, 1, 2, 3].map(|k| number(v, k) / 10.0)).collect(),
        uv: (0..n)
            .map(|q| [0, 1, 2, 3].map(|k| [(q / 9) as f32 + number(mesh.quads[q][k] as usize, 0) / 16.0, number(q, k)]))
            .collect(),
        normals: (0..n).map(|q| mesh.quads[q].map(|v| axis(v as usize + 5 * (q % 3)))).collect(),
        ..QuadAttributes::default()
    };
    (mesh, attributes)
}

/// The same with two objects and a skeleton of three joints.
pub(super) fn rigged() -> (QuadMesh, QuadAttributes, Scene) {
    let (mesh, painted) = painted();
    let pairs = |v: usize| [((v % 3) as u16, 0.75), (((v + 1) % 3) as u16, 0.25)];
    let attributes = QuadAttributes {
        skin: (0..mesh.positions.len()).filter_map(|v| Influences::of(pairs(v))).collect(),
        objects: (0..mesh.quads.len() as u32).map(|q| q / 7 % 2).collect(),
        ..painted
    };
    let node = |name: &str, parent| SkeletonNode { name: Some(name.to_owned()), parent, ..SkeletonNode::default() };
    let transform = NodeTransform::Parts { translation: Some([0.0, 0.5, 0.0]), rotation: None, scale: None };
    let nodes = vec![node("hip", None), SkeletonNode { transform, ..node("knee", Some(0)) }, node("toe", Some(1))];
    let moved = |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, 1.0];
    let joints = (0..).zip([0.0, -0.5, -0.5]).map(|(node, y)| Joint { node, inverse_bind: moved(y) }).collect();
    let objects = vec![ObjectName::new("left leg", "leg"), ObjectName::new("right\nleg", "leg")];
    (mesh, attributes, Scene { objects, skeleton: Skeleton { nodes, joints }, ..Scene::default() })
}

fn sorted(quad: &[u32]) -> Vec<u32> {
    let mut quad = quad.to_vec();
    quad.sort_unstable();
    quad
}

/// The attributes of a polygon: the name of its material, and coordinates and normals per vertex.
type PolygonAttributes = (Option<String>, BTreeMap<u32, [f32; 2]>, BTreeMap<u32, [f32; 3]>);

/// What a soup says of its polygons, each by its corners.
fn attributes_by_quad(soup: &TriangleSoup) -> BTreeMap<Vec<u32>, PolygonAttributes> {
    let of_polygon = |p: usize| {
        let mut corners = soup.polygon(p).to_vec();
        let uv = soup.corners_of(p).filter_map(|c| Some((soup.indices[c], *soup.uv.get(c)?))).collect();
        let normals = soup.corners_of(p).filter_map(|c| Some((soup.indices[c], *soup.normals.get(c)?))).collect();
        corners.sort_unstable();
        let name = soup.materials.get(p).map(|&m| soup.material_names[m as usize].clone());
        (corners, (name, uv, normals))
    };
    (0..soup.n_polygons()).map(of_polygon).collect()
}

fn read_back(bytes: &[u8], format: QuadFormat) -> TriangleSoup {
    let format = Format::from_extension(format.extension()).unwrap();
    read_soup(bytes, Some(format), &ReadLimits::default()).unwrap()
}

/// The same quads, whatever their order and first corners.
fn assert_same_quads(made: &QuadMesh, mesh: &QuadMesh) {
    let sorted = |mesh: &QuadMesh| {
        let mut quads = mesh.quads.clone();
        for quad in &mut quads {
            let first = (0..4).min_by_key(|&k| quad[k]).unwrap();
            quad.rotate_left(first);
        }
        quads.sort_unstable();
        quads
    };
    assert_eq!(made.positions.len(), mesh.positions.len());
    assert_eq!(sorted(made), sorted(mesh));
}
