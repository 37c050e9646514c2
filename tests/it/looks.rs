//! What a model looks like goes through a run: normals, materials, textures, images.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;
use quadrille::service::formats::{Alone, Format, Model, QuadFormat, ReadLimits, read_model, read_quads};
use serde_json::{Value, json as value};

use crate::attributes::files;
use crate::meshes::{glb, gltf, obj, surface};
use crate::server::Server;

/// A picture of one grey pixel.
fn png(grey: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&[grey])).expect("a picture in memory");
    bytes
}

/// The materials of [`textured`]: two of the same name, and one between them that nothing has.
fn materials() -> Value {
    let moved = value!({"KHR_texture_transform": {"offset": [0.5, 0.25], "scale": [2.0, 2.0]}});
    value!([
        {
            "name": "paint",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.25, 0.5, 0.75, 0.5], "metallicFactor": 0.1, "roughnessFactor": 0.7,
                "baseColorTexture": {"index": 1, "extensions": moved},
            },
            "normalTexture": {"index": 1, "scale": 0.5},
            "emissiveFactor": [0.1, 0.2, 0.3],
            "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 1}}},
        },
        {"name": "nobody's", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
        {"name": "paint", "extensions": {"KHR_materials_unlit": {}}},
    ])
}

/// A unit cube around the origin as GLB with the given materials, the first one on its upper half; texture coordinates are
/// x and y.
fn textured(materials: Value) -> Vec<u8> {
    let cube = surface("cube", 432);
    let (mut json, mut bin) = gltf(&cube);
    let n = cube.positions.len();
    let views = |json: &mut Value, bin: &mut Vec<u8>, bytes: &[u8]| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        let views = json["bufferViews"].as_array_mut().expect("a list");
        views.push(value!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()}));
        bin.extend_from_slice(bytes);
        views.len() - 1
    };
    let uv: Vec<u8> = cube.positions.iter().flat_map(|p| [p.x as f32, p.y as f32]).flat_map(f32::to_le_bytes).collect();
    let uv = views(&mut json, &mut bin, &uv);
    let (upper, lower): (Vec<&[u32]>, Vec<&[u32]>) =
        cube.polygons().partition(|p| p.iter().all(|&v| cube.positions[v as usize].z >= 0.0));
    let [upper, lower] = [upper, lower].map(|triangles| {
        let bytes: Vec<u8> = triangles.concat().into_iter().flat_map(u32::to_le_bytes).collect();
        (views(&mut json, &mut bin, &bytes), 3 * triangles.len())
    });
    let images = [png(7), png(200)].map(|bytes| views(&mut json, &mut bin, &bytes));
    json["accessors"] = value!([
        json["accessors"][0],
        {"bufferView": uv, "componentType": 5126, "count": n, "type": "VEC2"},
        {"bufferView": upper.0, "componentType": 5125, "count": upper.1, "type": "SCALAR"},
        {"bufferView": lower.0, "componentType": 5125, "count": lower.1, "type": "SCALAR"},
    ]);
    let attributes = value!({"POSITION": 0, "TEXCOORD_0": 1});
    json["meshes"] = value!([{"primitives": [
        {"attributes": attributes, "indices": 2, "material": 0},
        {"attributes": attributes, "indices": 3, "material": 2},
    ]}]);
    json["materials"] = materials;
    json["textures"] = value!([{"source": 0}, {"source": 1, "sampler": 1, "name": "grey"}]);
    json["samplers"] = value!([{}, {"magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648}]);
    json["images"] = value!([
        {"bufferView": images[0], "mimeType": "image/png"},
        {"bufferView": images[1], "mimeType": "image/png", "name": "pixel"},
    ]);
    json["extensionsUsed"] = value!(["KHR_texture_transform", "KHR_materials_clearcoat", "KHR_materials_unlit"]);
    json["extensionsRequired"] = value!(["KHR_texture_transform"]);
    json["buffers"][0]["byteLength"] = bin.len().into();
    glb(&json, &bin)
}

/// The JSON of a GLB and the bytes of its images.
fn opened(bytes: &[u8]) -> (Value, Vec<Vec<u8>>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    let end = 20 + word(12);
    let json: Value = serde_json::from_slice(&bytes[20..end]).expect("JSON");
    let bin = &bytes[end + 8..];
    let image = |image: &Value| {
        let view = &json["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
        let (start, length) =
            (view["byteOffset"].as_u64().unwrap_or(0), view["byteLength"].as_u64().expect("a length"));
        bin[start as usize..(start + length) as usize].to_vec()
    };
    let images = json["images"].as_array().into_iter().flatten().map(image).collect();
    (json, images)
}

fn of(files: &[(QuadFormat, Vec<u8>)], format: QuadFormat) -> &[u8] {
    &files.iter().find(|(f, _)| *f == format).expect("the format").1
}

fn read(bytes: &[u8], format: Format) -> Model {
    read_model(bytes, Some(format), &Alone, &ReadLimits::default()).expect("our own file")
}

/// Position and normal at every corner; the normals must be unit vectors.
fn corners(model: &Model) -> Vec<(DVec3, DVec3)> {
    let soup = &model.soup;
    assert_eq!(soup.normals.len(), soup.indices.len());
    let corner = |(v, n): (&u32, &[f32; 3])| (soup.positions[*v as usize], DVec3::from_array(n.map(f64::from)));
    let corners: Vec<_> = soup.indices.iter().zip(&soup.normals).map(corner).collect();
    for (_, normal) in &corners {
        assert!((normal.length() - 1.0).abs() < 1e-5, "{normal}");
    }
    corners
}

#[tokio::test(flavor = "multi_thread")]
async fn a_textured_model_keeps_its_materials_and_images() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let input = textured(materials());
    let mut spec = value!({"target": {"quads": 300}});
    let made = files(&server.client, "cube.glb", &input, &spec).await;
    // The validator of `tests/run` judges these files, too.
    let shown = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(shown.join("textured.glb"), &input).unwrap();
    std::fs::write(shown.join("textured.quads.glb"), of(&made, QuadFormat::Glb)).unwrap();

    let (json, images) = opened(of(&made, QuadFormat::Glb));
    let mut expected = materials();
    expected.as_array_mut().unwrap().remove(1);
    let at = |json: &mut Value, path: &str| *json.pointer_mut(path).unwrap() = 0.into();
    for path in [
        "/0/pbrMetallicRoughness/baseColorTexture/index",
        "/0/normalTexture/index",
        "/0/extensions/KHR_materials_clearcoat/clearcoatTexture/index",
    ] {
        at(&mut expected, path);
    }
    assert_eq!(json["materials"], expected, "of the used materials everything, the texture by its new number");
    assert_eq!(json["textures"], value!([{"source": 0, "sampler": 0, "name": "grey"}]));
    assert_eq!(json["samplers"], value!([{"magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648}]));
    assert_eq!(images, [png(200)], "the used image, byte for byte, and no other");
    assert_eq!(
        (json["images"][0]["name"].as_str(), json["images"][0]["mimeType"].as_str()),
        (Some("pixel"), Some("image/png"))
    );
    assert_eq!(json["extensionsRequired"], value!(["KHR_texture_transform"]));
    let used: BTreeSet<_> = json["extensionsUsed"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let needed = ["FB_ngon_encoding", "KHR_materials_clearcoat", "KHR_materials_unlit", "KHR_texture_transform"];
    assert_eq!(used, BTreeSet::from(needed));

    let model = read(of(&made, QuadFormat::Glb), Format::Glb);
    assert_eq!(read(&input, Format::Glb).scene.looks, model.scene.looks, "what comes out reads as what went in");
    assert_eq!(model.soup.uv.len(), model.soup.indices.len());
    for (uv, (p, _)) in model.soup.uv.iter().zip(corners(&model)) {
        assert!((f64::from(uv[0]) - p.x).abs() < 1e-4 && (1.0 - f64::from(uv[1]) - p.y).abs() < 1e-4, "{uv:?} at {p}");
    }
    for (p, &material) in model.soup.polygons().zip(&model.soup.materials) {
        let z = p.iter().map(|&v| model.soup.positions[v as usize].z).sum::<f64>();
        assert_eq!(material == 0, z > 0.0, "the upper half has the first material");
    }
    // OBJ knows materials by their names only: they must differ there.
    let text = std::str::from_utf8(of(&made, QuadFormat::Obj)).unwrap();
    let names: BTreeSet<_> = text.lines().filter(|line| line.starts_with("usemtl")).collect();
    assert_eq!(names, BTreeSet::from(["usemtl paint", "usemtl paint_2"]));

    // Without texture coordinates textures mean nothing, factors do.
    spec["preserve"] = value!(["materials"]);
    let bare = files(&server.client, "cube.glb", &input, &spec).await;
    let (json, images) = opened(of(&bare, QuadFormat::Glb));
    assert!(images.is_empty() && json.get("textures").is_none() && json.get("samplers").is_none());
    let material = &json["materials"][0];
    assert_eq!(material["pbrMetallicRoughness"]["roughnessFactor"], 0.7);
    assert_eq!(material["doubleSided"], true);
    assert!(material.get("normalTexture").is_none() && json.get("extensionsRequired").is_none());
    spec["preserve"] = value!(["uv"]);
    let bare = files(&server.client, "cube.glb", &input, &spec).await;
    assert!(opened(of(&bare, QuadFormat::Glb)).0.get("materials").is_none());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn normals_are_split_at_sharp_edges_and_smooth_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let spec = value!({"target": {"quads": 600}});
    let formats = [(QuadFormat::Obj, Format::Obj), (QuadFormat::Glb, Format::Glb)];
    let cube = files(&server.client, "cube.obj", &obj(&surface("cube", 300)), &spec).await;
    for (format, as_read) in formats {
        let model = read(of(&cube, format), as_read);
        let corners = corners(&model);
        let extent = corners.iter().map(|(p, _)| p.abs().max_element()).fold(0.0, f64::max);
        let nearest = |n: DVec3| [DVec3::X, DVec3::Y, DVec3::Z].iter().map(|a| n.dot(*a).abs()).fold(0.0, f64::max);
        assert!(corners.iter().all(|(_, n)| nearest(*n) > 0.9999), "{format:?}");
        let tips = corners.iter().filter(|(p, _)| p.abs().min_element() > 0.999 * extent);
        let signs = |p: DVec3| p.to_array().map(|x| (2.0 * x) as i32);
        let tips: BTreeSet<_> = tips.map(|(p, n)| (signs(p.signum()), signs(*n))).collect();
        assert_eq!(tips.len(), 24, "{format:?}: three normals at every tip");
        assert_eq!(read_quads(of(&cube, format), format).unwrap().positions.len(), model.soup.positions.len());
    }
    let sphere = files(&server.client, "sphere.obj", &obj(&surface("sphere", 4000)), &spec).await;
    for (format, as_read) in formats {
        let model = read(of(&sphere, format), as_read);
        let worst = corners(&model).into_iter().map(|(p, n)| p.angle_between(n).to_degrees()).fold(0.0, f64::max);
        assert!(worst < 2.0, "{format:?}: {worst} degrees");
    }
    server.stop().await;
}
