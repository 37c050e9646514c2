//! What materials look like, read and written again.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::beside::Alone;
use super::super::format::QuadFormat;
use super::super::looks::{Encoding, Look, Looks};
use super::super::{glb_container, write_model};
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nfirst";
const JPEG: &[u8] = b"\xff\xd8\xffsecond";
const WEBP: &[u8] = b"RIFF\x04\0\0\0WEBPthird";
const KTX2: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\nfourth";

/// One file.
#[derive(Debug)]
struct OneFile;

impl Beside for OneFile {
    fn get(&self, path: &str, _: u64) -> Result<Option<Vec<u8>>, ReadError> {
        Ok((path == "maps/a b.jpg").then(|| JPEG.to_vec()))
    }
}

/// A triangle with one material, three images (in the binary chunk, in a data URI, beside the file) and a texture of each.
fn sample(material: Value) -> Value {
    let data = |bytes: &[u8]| format!("data:image/webp;base64,{}", STANDARD.encode(bytes));
    json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": PNG.len()}],
        "buffers": [{"byteLength": 36 + PNG.len()}],
        "materials": [material],
        "textures": [
            {"source": 0, "sampler": 0},
            {"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}, "name": "two"},
            {"source": 2},
            {"extensions": {"KHR_texture_basisu": {"source": 3}}},
        ],
        "samplers": [{"magFilter": 9728, "wrapS": 1, "wrapT": 10497, "extras": {}}],
        "images": [
            {"bufferView": 1, "mimeType": "image/png", "name": "png"},
            {"uri": data(WEBP)},
            {"uri": "maps/a%20b.jpg"},
            {"uri": data(KTX2)},
        ],
    })
}

fn read_limited(json: &Value, limits: &ReadLimits) -> Result<Model, ReadError> {
    let positions = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bin = positions.iter().flat_map(|x| x.to_le_bytes()).chain(PNG.iter().copied()).collect();
    read(&glb_container::write(json, bin), &OneFile, limits)
}

fn read_all(json: &Value) -> Model {
    read_limited(json, &ReadLimits::default()).unwrap()
}

fn look(model: &Model) -> Value {
    Value::from(model.scene.looks.materials[0].as_ref().unwrap().json.clone())
}

#[test]
fn images_come_from_the_binary_chunk_from_data_and_from_files() {
    let all = json!({
        "normalTexture": {"index": 2}, "occlusionTexture": {"index": 1, "strength": 0.5},
        "emissiveTexture": {"index": 0, "texCoord": 0}, "pbrMetallicRoughness": {"baseColorTexture": {"index": 3}},
    });
    let model = read_all(&sample(all));
    assert_eq!(model.warnings, []);
    let Looks { textures, images, .. } = &model.scene.looks;
    let encoded = |i: usize| textures[i].images.iter().map(|&i| (images[i].encoding, images[i].bytes.as_slice()));
    let expected: [&[(Encoding, &[u8])]; 4] = [
        &[(Encoding::Ktx2, KTX2)],
        &[(Encoding::Jpeg, JPEG)],
        &[(Encoding::Png, PNG), (Encoding::WebP, WEBP)],
        &[(Encoding::Png, PNG)],
    ];
    assert_eq!((textures.len(), images.len()), (4, 4), "an image that two textures have is there once");
    for (i, expected) in expected.iter().enumerate() {
        assert_eq!(encoded(i).collect::<Vec<_>>(), *expected);
    }
    assert_eq!(textures[2].name.as_deref(), Some("two"));
    assert_eq!(Value::from(textures[3].sampler.clone()), json!({"magFilter": 9728, "wrapT": 10497}));
    assert_eq!(look(&model)["occlusionTexture"], json!({"index": 2, "strength": 0.5}));
}

#[test]
fn what_is_wrong_is_left_out_with_a_warning() {
    let lost = |material: Value, patch: Option<(&str, Value)>| {
        let mut json = sample(material);
        if let Some((pointer, value)) = patch {
            *json.pointer_mut(pointer).unwrap() = value;
        }
        let model = read_all(&json);
        assert!(matches!(model.warnings[..], [Warning { kind: WarningKind::AttributesLost { .. }, .. }]));
        (look(&model), model.scene.looks.images.len())
    };
    let with = |reference: Value| json!({"name": "m", "doubleSided": true, "normalTexture": reference});
    let nothing = (json!({"name": "m", "doubleSided": true}), 0);
    assert_eq!(lost(with(json!({"index": 4})), None), nothing);
    assert_eq!(lost(with(json!({"index": 0, "texCoord": 1})), None), nothing);
    let moved = json!({"KHR_texture_transform": {"texCoord": 2}});
    assert_eq!(lost(with(json!({"index": 0, "extensions": moved})), None), nothing);
    for (pointer, value) in [
        ("/images/0/bufferView", json!(0)),
        ("/images/0/bufferView", json!(7)),
        ("/images/0", json!({})),
        ("/images/0", json!({"uri": "missing.png"})),
        ("/images/0", json!({"uri": "../maps/a b.jpg"})),
        ("/images/0", json!({"uri": "data:image/png;base64,*"})),
        ("/bufferViews/1/byteLength", json!(1000)),
        ("/bufferViews/1/buffer", json!(3)),
        ("/textures/0/source", json!(9)),
    ] {
        assert_eq!(lost(with(json!({"index": 0})), Some((pointer, value))), nothing, "{pointer}");
    }
    // A transform that goes back to the first set is as good as none that names a set.
    let moved = json!({"KHR_texture_transform": {"texCoord": 0, "rotation": 1.0}});
    let model = read_all(&sample(with(json!({"index": 0, "texCoord": 1, "extensions": moved}))));
    let expected = json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": 1.0}}});
    assert_eq!((&look(&model)["normalTexture"], model.warnings.len()), (&expected, 0));
    // Many of them are not listed one by one.
    let many: serde_json::Map<_, _> = (0..40).map(|i| (format!("{i}Texture"), json!({"index": 9}))).collect();
    let model = read_all(&sample(json!({"extensions": {"KHR_materials_new": many}})));
    assert_eq!(model.warnings.len(), 11);
}

#[test]
fn values_that_gltf_does_not_know_are_left_out() {
    let json = json!({
        "name": "", "alphaMode": "GLOW", "alphaCutoff": -1.0, "doubleSided": true, "emissiveFactor": [1, 0, 2],
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 2], "metallicFactor": 0.5, "roughnessFactor": 1.5, "other": 1},
        "other": 1, "extras": {"baseTexture": 7},
        "extensions": {
            "KHR_materials_ior": {"ior": 1.2, "extras": 1, "list": [{"aTexture": {"index": 0}}], "xTexture": 3},
            "KHR_materials_odd": 4,
            "OTHER_materials": {"a": 1},
        },
    });
    let kept = json!({
        "doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0.5}, "extras": {"baseTexture": 7},
        "extensions": {"KHR_materials_ior": {"ior": 1.2}},
    });
    assert_eq!(look(&read_all(&sample(json))), kept);
}

#[test]
fn images_count_as_unpacked() {
    let json = sample(json!({"normalTexture": {"index": 0}, "occlusionTexture": {"index": 1}}));
    let most = (PNG.len() + WEBP.len()) as u64;
    let limits = ReadLimits { max_bytes_unpacked: most, ..ReadLimits::default() };
    assert!(read_limited(&json, &limits).is_ok());
    let limits = ReadLimits { max_bytes_unpacked: most - 1, ..ReadLimits::default() };
    let error = read_limited(&json, &limits).unwrap_err();
    assert_eq!(error, ReadError::TooLarge { what: "bytes unpacked", claimed: most, limit: most - 1 });
}

#[test]
fn materials_of_one_name_stay_apart_and_unused_ones_are_not_read() {
    let mut json = sample(json!({"name": "a", "normalTexture": {"index": 9}}));
    json["materials"].as_array_mut().unwrap().extend([json!({"name": "a"}), json!({"name": "a", "doubleSided": true})]);
    let attributes = json!({"POSITION": 0});
    json["meshes"][0]["primitives"] = json!([
        {"attributes": attributes, "material": 2},
        {"attributes": attributes},
        {"attributes": attributes, "material": 1},
        {"attributes": attributes, "material": 2},
        {"attributes": attributes, "material": 0, "mode": 1},
    ]);
    let model = read_all(&json);
    assert_eq!((model.soup.materials.as_slice(), model.warnings.len()), ([0, 1, 2, 0].as_slice(), 0));
    assert_eq!(model.soup.material_names, ["a", "", "a"]);
    let looks: Vec<Option<Value>> =
        model.scene.looks.materials.iter().map(|look| look.clone().map(|look| look.json.into())).collect();
    assert_eq!(looks, [Some(json!({"name": "a", "doubleSided": true})), None, Some(json!({"name": "a"}))]);
}

#[test]
fn looks_come_back_from_what_is_written() {
    let material = json!({
        "name": "all",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 3}, "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 0, "scale": -2.5},
        "occlusionTexture": {"index": 2, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.5]}}},
    });
    let scene = read_all(&sample(material)).scene;
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(glam::DVec3::from_array);
    let mesh = QuadMesh { positions: positions.to_vec(), quads: vec![[0, 1, 2, 3]] };
    let attributes = QuadAttributes {
        materials: vec![0],
        material_names: vec!["all".to_owned()],
        material_numbers: vec![0],
        uv: vec![[[0.0; 2]; 4]],
        ..QuadAttributes::default()
    };
    let bytes = write_model(&mesh, &attributes, &scene, QuadFormat::Glb);
    let back = read(&bytes, &Alone, &ReadLimits::default()).unwrap();
    assert_eq!(back.warnings, []);
    // What only an extension can show is required.
    let required = vec!["KHR_texture_basisu".to_owned()];
    let chunks = glb_container::open(&bytes).unwrap();
    let json: Value = serde_json::from_slice(chunks.json).unwrap();
    assert_eq!(json["extensionsRequired"], json!(required));
    assert_eq!(back.scene.looks, scene.looks);
    // Numbers that the quads have and the scene does not are no reason to fail.
    let unknown = QuadAttributes { material_numbers: vec![5], ..attributes.clone() };
    assert!(read(&write_model(&mesh, &unknown, &scene, QuadFormat::Glb), &Alone, &ReadLimits::default()).is_ok());
    let mut broken = scene.clone();
    let json = json!({"normalTexture": {"index": 17}}).as_object().unwrap().clone();
    broken.looks.materials = vec![Some(Look { json })];
    let back = read(&write_model(&mesh, &attributes, &broken, QuadFormat::Glb), &Alone, &ReadLimits::default());
    assert!(back.unwrap().scene.looks.textures.is_empty());
}
