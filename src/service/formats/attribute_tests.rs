//! Attributes in the files of quads.

use std::collections::BTreeMap;

use serde_json::Value;

use super::quads::tests::cube;
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::Influences;
use crate::engine::mesh::TriangleSoup;
use crate::engine::quad::QuadMesh;

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

#[test]
fn names_and_skins_are_in_the_files_that_can_hold_them() {
    let (mesh, attributes, scene) = rigged();
    for format in QuadFormat::ALL {
        let bytes = write_model(&mesh, &attributes, &scene, format);
        assert_same_quads(&read_quads(&bytes, format).unwrap(), &mesh);
        if format == QuadFormat::Ply {
            assert_eq!(bytes, write_quads(&mesh, &attributes, format));
        }
    }
    let read = |format: QuadFormat| {
        let bytes = write_model(&mesh, &attributes, &scene, format);
        read_model(&bytes, Format::from_extension(format.extension()), &Alone, &ReadLimits::default()).unwrap()
    };
    let glb = read(QuadFormat::Glb);
    assert_eq!((&glb.scene.objects, &glb.scene.skeleton), (&scene.objects, &scene.skeleton));
    assert_eq!(glb.soup.skin, attributes.skin);
    let mut expected: Vec<_> = mesh.quads.iter().zip(&attributes.objects).map(|(q, &o)| (sorted(q), o)).collect();
    let mut made: Vec<_> = glb.soup.polygons().zip(&glb.soup.objects).map(|(q, &o)| (sorted(q), o)).collect();
    expected.sort_unstable();
    made.sort_unstable();
    assert_eq!(made, expected);
    // One component is one object of an OBJ.
    let obj = read(QuadFormat::Obj);
    assert_eq!(
        (obj.scene.objects.as_slice(), obj.soup.objects.len()),
        ([ObjectName::new("left leg", "left leg")].as_slice(), 0)
    );
    // Every object is a prim of USDA, and the vertices that two of them share are one again in the end.
    let text = String::from_utf8(write_model(&mesh, &attributes, &scene, QuadFormat::Usda)).unwrap();
    for line in
        ["def Mesh \"left_leg\" (", "displayName = \"left leg\"", "def Mesh \"right_leg\" (", "def Material \"_2nd\""]
    {
        assert_eq!(text.matches(line).count(), 1, "{line}");
    }
    let apart = text.replace("quadrille:vertices", "other");
    let apart = read_quads(apart.as_bytes(), QuadFormat::Usda).unwrap();
    assert!(apart.positions.len() > mesh.positions.len() && apart.quads.len() == mesh.quads.len());
    // Numbers of objects that the quads did not get mean nothing.
    let unknown = QuadAttributes { objects: Vec::new(), ..attributes.clone() };
    let text = String::from_utf8(write_model(&mesh, &unknown, &scene, QuadFormat::Obj)).unwrap();
    assert!(text.contains("\no component_1\n"));
}

fn sorted(quad: &[u32]) -> Vec<u32> {
    let mut quad = quad.to_vec();
    quad.sort_unstable();
    quad
}

#[test]
fn components_of_one_object_have_different_names() {
    let (one, n) = (cube(1), 8);
    let mut mesh = QuadMesh::default();
    for copy in 0..5 {
        mesh.positions.extend(&one.positions);
        mesh.quads.extend(one.quads.iter().map(|quad| quad.map(|v| v + copy * n)));
    }
    let objects = (0..30).map(|q| [0, 0, 1, 2, 0][q / 6]).collect();
    let attributes = QuadAttributes { objects, ..QuadAttributes::default() };
    let objects = ["arm", "arm_2", " \t"].map(|name| ObjectName::new(name, "")).to_vec();
    let scene = Scene { objects, ..Scene::default() };
    let text = String::from_utf8(write_model(&mesh, &attributes, &scene, QuadFormat::Obj)).unwrap();
    let names: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("o ")).collect();
    assert_eq!(names, ["arm", "arm_2", "arm_2_2", "component_4", "arm_3"]);
    let single = Scene { objects: scene.objects[..1].to_vec(), ..Scene::default() };
    let text = String::from_utf8(write_model(&one, &QuadAttributes::default(), &single, QuadFormat::Obj)).unwrap();
    assert!(text.contains("\no arm\n"));
}

/// The attributes of a polygon: the name of its material, and coordinates and normals per vertex.
type PolygonAttributes = (Option<String>, BTreeMap<u32, [f32; 2]>, BTreeMap<u32, [f32; 3]>);

/// What a soup says of its polygons, each by its corners.
fn said(soup: &TriangleSoup) -> BTreeMap<Vec<u32>, PolygonAttributes> {
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

#[test]
fn the_quads_of_every_format_are_the_same_with_attributes() {
    let (mesh, all) = painted();
    let some = [
        all.clone(),
        QuadAttributes { uv: all.uv.clone(), ..QuadAttributes::default() },
        QuadAttributes { uv: Vec::new(), ..all.clone() },
        QuadAttributes { normals: all.normals.clone(), ..QuadAttributes::default() },
        QuadAttributes { normals: Vec::new(), ..all.clone() },
        QuadAttributes { colours: all.colours.clone(), ..QuadAttributes::default() },
    ];
    for attributes in &some {
        for format in QuadFormat::ALL {
            let bytes = write_quads(&mesh, attributes, format);
            let made = read_quads(&bytes, format).unwrap_or_else(|error| panic!("{format:?}: {error}"));
            assert_same_quads(&made, &mesh);
            assert_eq!(bytes, write_quads(&mesh, attributes, format));
            for (a, b) in made.positions.iter().zip(&mesh.positions) {
                assert_eq!(*a, if format == QuadFormat::Glb { b.as_vec3().as_dvec3() } else { *b });
            }
        }
    }
}

#[test]
fn obj_and_glb_hold_materials_colours_normals_and_texture_coordinates() {
    let (mesh, attributes) = painted();
    for format in [QuadFormat::Obj, QuadFormat::Glb] {
        let soup = read_back(&write_quads(&mesh, &attributes, format), format);
        let said = said(&soup);
        for (q, quad) in mesh.quads.iter().enumerate() {
            let mut key = quad.to_vec();
            key.sort_unstable();
            let (name, uv, normals) = &said[&key];
            let expected = attributes.material_names[attributes.materials[q] as usize].as_str();
            let expected = match format {
                QuadFormat::Obj => {
                    match expected {
                        "" => "default",
                        // Without its space it would be the name of another.
                        "2nd " => "2nd_2",
                        name => name,
                    }
                }
                _ => expected,
            };
            assert_eq!(name.as_deref(), Some(expected), "{format:?}");
            for (k, &v) in quad.iter().enumerate() {
                let (a, b) = (uv[&v], attributes.uv[q][k]);
                assert!((a[0] - b[0]).abs() == 0.0 && (a[1] - b[1]).abs() < 1e-6, "{format:?}: {a:?}, {b:?}");
                assert_eq!(normals[&v], attributes.normals[q][k], "{format:?}");
            }
        }
        for (made, colour) in soup.colours.iter().zip(&attributes.colours) {
            let alpha = if format == QuadFormat::Obj { 1.0 } else { colour[3] };
            assert_eq!(*made, [colour[0], colour[1], colour[2], alpha], "{format:?}");
        }
        assert_eq!(soup.colours.len(), mesh.positions.len());
    }
}

#[test]
fn ply_holds_colours_as_bytes() {
    let (mesh, attributes) = painted();
    let soup = read_back(&write_quads(&mesh, &attributes, QuadFormat::Ply), QuadFormat::Ply);
    assert_eq!(soup.colours.len(), mesh.positions.len());
    for (made, colour) in soup.colours.iter().flatten().zip(attributes.colours.iter().flatten()) {
        assert!((made - colour).abs() <= 0.5001 / 255.0);
    }
    assert!(soup.uv.is_empty() && soup.materials.is_empty());
}

#[test]
fn usda_holds_primvars_and_subsets() {
    let (mesh, attributes) = painted();
    let text = String::from_utf8(write_quads(&mesh, &attributes, QuadFormat::Usda)).unwrap();
    let list = |line: &str| line.split_once("= [").unwrap().1.split(']').next().unwrap().to_owned();
    let line =
        |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{name}"));
    for name in ["texCoord2f[] primvars:st", "normal3f[] normals"] {
        assert_eq!(list(line(name)).split("), (").count(), 4 * mesh.quads.len());
    }
    assert_eq!(list(line("color3f[] primvars:displayColor")).split("), (").count(), mesh.positions.len());
    assert_eq!(list(line("float[] primvars:displayOpacity")).split(", ").count(), mesh.positions.len());
    let subsets: Vec<Vec<usize>> = text
        .lines()
        .filter(|line| line.trim_start().starts_with("int[] indices"))
        .map(|line| list(line).split(", ").map(|q| q.parse().unwrap()).collect())
        .collect();
    // The quads of the material without a name are in no subset.
    let of = |m: u32| (0..mesh.quads.len()).filter(|&q| attributes.materials[q] == m).collect::<Vec<_>>();
    assert_eq!(subsets, [of(0), of(2), of(3)]);
    for name in ["paint__old_", "_2nd", "_2nd_"] {
        assert!(
            text.contains(&format!("def GeomSubset \"{name}\"")) && text.contains(&format!("def Material \"{name}\""))
        );
        assert!(text.contains(&format!("rel material:binding = </quads/materials/{name}>")));
    }
}

#[test]
fn copies_in_glb_go_back_to_their_own_vertices() {
    // Two cubes at the same place: which vertex a copy belongs to does not follow from where it is.
    let (one, painted) = painted();
    let n = one.positions.len() as u32;
    let mut two = one.clone();
    two.positions.extend(&one.positions);
    two.quads.extend(one.quads.iter().map(|quad| quad.map(|v| v + n)));
    let uv = painted.uv.iter().chain(&painted.uv).copied().collect();
    let bytes = write_quads(&two, &QuadAttributes { uv, ..QuadAttributes::default() }, QuadFormat::Glb);
    assert_same_quads(&read_quads(&bytes, QuadFormat::Glb).unwrap(), &two);

    // An order that cannot be is none: all vertices are read, and no more than that is wrong.
    let chunks = glb_container::open(&bytes).unwrap();
    let mut json: Value = serde_json::from_slice(chunks.json).unwrap();
    let count = json["accessors"][0]["count"].as_u64().unwrap() as usize;
    assert!(count > two.positions.len());
    json["meshes"][0]["primitives"][0]["extensions"]["FB_ngon_encoding"]["extras"]["vertices"] = 0.into();
    let damaged = glb_container::write(&json, chunks.bin.unwrap().to_vec());
    assert_eq!(read_quads(&damaged, QuadFormat::Glb).unwrap().positions.len(), count);
}

#[test]
fn every_primitive_names_its_material_and_starts_its_quads_apart() {
    let (mesh, attributes) = painted();
    let bytes = write_quads(&mesh, &attributes, QuadFormat::Glb);
    let chunks = glb_container::open(&bytes).unwrap();
    let json: Value = serde_json::from_slice(chunks.json).unwrap();
    let (bin, accessors) = (chunks.bin.unwrap(), json["accessors"].as_array().unwrap());
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    let names: Vec<_> =
        primitives.iter().map(|p| p["material"].as_u64().map(|m| &json["materials"][m as usize]["name"])).collect();
    assert_eq!(names, [Some(&"paint (old)".into()), None, Some(&"2nd".into()), Some(&"2nd ".into())]);
    let mut quads = 0;
    for primitive in primitives {
        let accessor = &accessors[primitive["indices"].as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() + accessor["byteOffset"].as_u64().unwrap_or(0);
        let count = accessor["count"].as_u64().unwrap() as usize;
        let indices = bin[start as usize..][..4 * count].as_chunks::<4>().0;
        let anchors: Vec<u32> = indices.chunks(6).map(|quad| u32::from_le_bytes(quad[0])).collect();
        assert!(anchors.windows(2).all(|pair| pair[0] != pair[1]));
        quads += anchors.len();
        for attribute in primitive["attributes"].as_object().unwrap().values() {
            assert_eq!(accessors[attribute.as_u64().unwrap() as usize]["count"], accessors[0]["count"]);
        }
    }
    assert_eq!(quads, mesh.quads.len());
}

#[test]
fn names_of_materials_cannot_break_lines() {
    let (mesh, mut attributes) = painted();
    attributes.material_names = ["a\nf 1 1 1", "b\\", " \t", "\"\\"].map(str::to_owned).to_vec();
    for format in QuadFormat::ALL {
        assert_same_quads(&read_quads(&write_quads(&mesh, &attributes, format), format).unwrap(), &mesh);
    }
}

#[test]
fn files_without_attributes_are_what_they_were() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]].map(glam::DVec3::from_array);
    let mesh = QuadMesh { positions: positions.to_vec(), quads: vec![[0, 1, 2, 3]] };
    let bytes = |format| write_quads(&mesh, &QuadAttributes::default(), format);
    let text = |format| String::from_utf8(bytes(format)).unwrap();
    assert_eq!(
        text(QuadFormat::Obj),
        "# quads by Quadrille\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\no component_1\nf 1 2 3 4\n"
    );
    assert_eq!(
        text(QuadFormat::Usda),
        "#usda 1.0\n(\n    defaultPrim = \"quads\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
         def Xform \"quads\"\n{\n    def Mesh \"mesh\"\n    {\n        \
         float3[] extent = [(0, 0, 0), (1, 1, 0.5)]\n        int[] faceVertexCounts = [4]\n        \
         int[] faceVertexIndices = [0, 1, 2, 3]\n        \
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]\n        \
         uniform token subdivisionScheme = \"none\"\n    }\n}\n"
    );
    let header = "ply\nformat binary_little_endian 1.0\ncomment quads by Quadrille\nelement vertex 4\nproperty float x\n\
                  property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = bytes(QuadFormat::Ply);
    assert!(ply.starts_with(header.as_bytes()));
    assert_eq!(ply.len(), header.len() + 4 * 12 + 17);
    let glb = bytes(QuadFormat::Glb);
    let chunks = glb_container::open(&glb).unwrap();
    assert_eq!(
        std::str::from_utf8(chunks.json).unwrap().trim_end(),
        concat!(
            r#"{"asset":{"version":"2.0","generator":"Quadrille "#,
            env!("CARGO_PKG_VERSION"),
            r#""},"extensionsUsed":["FB_ngon_encoding"],"scene":0,"scenes":[{"nodes":[0]}],"#,
            r#""nodes":[{"mesh":0,"name":"quads"}],"meshes":[{"name":"quads","primitives":[{"attributes":{"POSITION":0},"#,
            r#""indices":1,"mode":4,"extensions":{"FB_ngon_encoding":{}}}]}],"accessors":[{"bufferView":0,"#,
            r#""componentType":5126,"count":4,"type":"VEC3","min":[0.0,0.0,0.0],"max":[1.0,1.0,0.5]},{"bufferView":1,"#,
            r#""componentType":5125,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48,"#,
            r#""target":34962},{"buffer":0,"byteOffset":48,"byteLength":24,"target":34963}],"buffers":[{"byteLength":72}]}"#
        )
    );
    assert_eq!(chunks.bin.map(<[u8]>::len), Some(72));
}
