//! What the input carries besides its shape goes the whole way to the files.

use quadrille::engine::mesh::Influences;
use quadrille::service::formats::{Alone, Format, QuadFormat, ReadLimits, read_model, read_quads, read_soup};
use reqwest::StatusCode;
use serde_json::{Value, json as value};

use crate::client::Client;
use crate::meshes::{glb, gltf, obj, surface};
use crate::server::Server;

/// Files of a job that has to succeed.
pub(crate) async fn files(client: &Client, name: &str, mesh: &[u8], spec: &Value) -> Vec<(QuadFormat, Vec<u8>)> {
    let job = client.submit(name, mesh, spec).await;
    let done = client.finished(&job).await;
    assert_eq!(done["status"], "succeeded", "{}", done["problem"]);
    let mut files = Vec::new();
    for format in QuadFormat::ALL {
        let path = format!("{}?format={}", done["urls"]["quad_mesh"].as_str().unwrap(), format.extension());
        let response = client.get(&path).await;
        assert_eq!(response.status(), StatusCode::OK, "{path}");
        files.push((format, response.bytes().await.unwrap().to_vec()));
    }
    files
}

/// The side of a cube around the origin that these corners lie on.
fn side(corners: &[glam::DVec3]) -> usize {
    let centre = corners.iter().sum::<glam::DVec3>();
    let axis = centre.abs().max_position();
    2 * axis + usize::from(centre[axis] > 0.0)
}

/// A cube as OBJ: colours linear in position, one material per side, and per side coordinates of its own: u is the number
/// of the side plus a number between 0.1 and 0.9.
fn painted() -> Vec<u8> {
    let cube = surface("cube", 300);
    let mut text = String::new();
    for p in &cube.positions {
        let [r, g, b] = p.to_array().map(|x| 0.5 + 0.5 * x);
        text += &format!("v {} {} {} {r} {g} {b}\n", p.x, p.y, p.z);
    }
    let mut n = 0;
    for polygon in cube.polygons() {
        let corners: Vec<_> = polygon.iter().map(|&v| cube.positions[v as usize]).collect();
        let (axis, side) = (side(&corners) / 2, side(&corners));
        text += &format!("usemtl side {side}\nf");
        let mut coordinates = String::new();
        for (v, p) in polygon.iter().zip(&corners) {
            n += 1;
            coordinates += &format!("vt {} {}\n", side as f64 + 0.5 + 0.4 * p[(axis + 1) % 3], p[(axis + 2) % 3]);
            text += &format!(" {}/{n}", v + 1);
        }
        text += "\n";
        text += &coordinates;
    }
    text.into_bytes()
}

#[tokio::test(flavor = "multi_thread")]
async fn materials_colours_and_texture_coordinates_come_out_of_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let spec = value!({"target": {"quads": 150}});
    for (format, bytes) in files(client, "cube.obj", &painted(), &spec).await {
        let quads = read_quads(&bytes, format).unwrap();
        if format == QuadFormat::Usda {
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(text.matches("def GeomSubset").count(), 6);
            assert!(text.contains("primvars:st") && text.contains("primvars:displayColor"));
            continue;
        }
        let soup = read_soup(&bytes, Format::from_extension(format.extension()), &ReadLimits::default()).unwrap();
        assert_eq!(soup.colours.len(), quads.positions.len(), "{format:?}");
        let tolerance = if format == QuadFormat::Ply { 0.51 / 255.0 } else { 1e-6 };
        for (p, colour) in soup.positions.iter().zip(&soup.colours) {
            for k in 0..3 {
                assert!((f64::from(colour[k]) - (0.5 + 0.5 * p[k])).abs() < tolerance, "{format:?}: {p} {colour:?}");
            }
        }
        if format == QuadFormat::Ply {
            continue;
        }
        assert_eq!(soup.uv.len(), soup.indices.len());
        for p in 0..soup.n_polygons() {
            let corners: Vec<_> = soup.polygon(p).iter().map(|&v| soup.positions[v as usize]).collect();
            let (side, axis) = (side(&corners), side(&corners) / 2);
            assert_eq!(soup.material_names[soup.materials[p] as usize], format!("side {side}"));
            for (uv, p) in soup.uv[soup.corners_of(p)].iter().zip(&corners) {
                let expected = [side as f64 + 0.5 + 0.4 * p[(axis + 1) % 3], p[(axis + 2) % 3]];
                let far = (0..2).map(|k| (f64::from(uv[k]) - expected[k]).abs()).fold(0.0, f64::max);
                assert!(far < 1e-5, "{format:?}: {uv:?} instead of {expected:?}");
            }
        }
    }
    let mut nothing = spec.clone();
    nothing["preserve"] = value!([]);
    let plain = obj(&surface("cube", 300));
    let bare = files(client, "cube.obj", &painted(), &nothing).await;
    assert_eq!(files(client, "cube.obj", &plain, &spec).await, files(client, "cube.obj", &plain, &nothing).await);
    assert!(!String::from_utf8_lossy(&bare[0].1).contains("usemtl"));
    server.stop().await;
}

/// How two joints share the places of the torus: linear in height.
fn shared_by(z: f64) -> Influences {
    Influences::of([(0, 0.5 - z), (1, 0.5 + z)]).unwrap()
}

/// A torus that two joints share, as GLB, with names for everything.
fn rigged() -> Vec<u8> {
    let torus = surface("torus", 2000);
    let (mut json, mut bin) = gltf(&torus);
    let n = torus.positions.len();
    let mut attribute = |bytes: Vec<u8>, component: u32, count: usize, kind: &str| {
        let view = value!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()});
        bin.extend(bytes);
        let list = |json: &mut Value, name: &str, item: Value| {
            let list = json[name].as_array_mut().unwrap();
            list.push(item);
            list.len() - 1
        };
        let view = list(&mut json, "bufferViews", view);
        let accessor = value!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        list(&mut json, "accessors", accessor)
    };
    let floats = |values: Vec<f32>| values.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let joints = attribute([0, 1, 0, 0].repeat(n), 5121, n, "VEC4");
    let weights = torus.positions.iter().flat_map(|p| [0.5 - p.z as f32, 0.5 + p.z as f32, 0.0, 0.0]).collect();
    let weights = attribute(floats(weights), 5126, n, "VEC4");
    let moved = |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, 1.0];
    let matrices = attribute(floats([moved(-1.0), moved(-3.0)].concat()), 5126, 2, "MAT4");
    json["meshes"][0]["name"] = "ring mesh".into();
    json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints.into();
    json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
    json["nodes"] = value!([
        {"mesh": 0, "skin": 0, "name": "ring", "translation": [50, 0, 0]},
        {"name": "lower", "translation": [0, 1, 0], "children": [2]},
        {"name": "upper", "translation": [0, 2, 0]},
    ]);
    json["scenes"] = value!([{"nodes": [0, 1]}]);
    json["skins"] = value!([{"joints": [1, 2], "inverseBindMatrices": matrices}]);
    json["animations"] = value!([{"channels": [], "samplers": []}]);
    json["buffers"][0]["byteLength"] = bin.len().into();
    glb(&json, &bin)
}

#[tokio::test(flavor = "multi_thread")]
async fn skins_and_names_come_out_of_the_glb() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let mut spec = value!({"target": {"quads": 600}});
    let made = files(client, "ring.glb", &rigged(), &spec).await;
    let read = |bytes: &[u8]| read_model(bytes, Some(Format::Glb), &Alone, &ReadLimits::default()).unwrap();
    let of = |files: &[(QuadFormat, Vec<u8>)], format| files.iter().find(|(f, _)| *f == format).unwrap().1.clone();
    let bytes = of(&made, QuadFormat::Glb);
    let model = read(&bytes);
    let input = read(&rigged());
    assert_eq!(input.warnings.len(), 1);
    assert_eq!(model.scene, input.scene, "names, skeleton and inverse bind matrices are those of the input");
    assert_eq!((model.scene.objects[0].node.as_str(), model.scene.objects[0].mesh.as_str()), ("ring", "ring mesh"));
    assert_eq!(model.scene.skeleton.joints.len(), 2);
    // What moves the input and where it is bound is untouched by where its node stands.
    assert_eq!(model.soup.skin.len(), model.soup.positions.len());
    let mut worst = 0.0_f64;
    for (p, made) in model.soup.positions.iter().zip(&model.soup.skin) {
        assert!(p.abs().max_element() < 1.5, "{p}");
        worst = worst.max(made.difference(&shared_by(p.z)));
    }
    assert!(worst < 0.01, "{worst}");
    assert_eq!(read_quads(&bytes, QuadFormat::Glb).unwrap().positions, model.soup.positions);
    let text = String::from_utf8(of(&made, QuadFormat::Obj)).unwrap();
    assert!(text.contains("\no ring\n"));

    spec["preserve"] = value!(["uv"]);
    let bare = read(&of(&files(client, "ring.glb", &rigged(), &spec).await, QuadFormat::Glb));
    assert!(bare.soup.skin.is_empty() && bare.scene.skeleton.joints.is_empty());
    assert_eq!(bare.scene.objects, model.scene.objects);
    assert_eq!(bare.soup.positions, model.soup.positions);
    server.stop().await;
}
