//! Several files in one upload: a mesh with what lies beside it.

use reqwest::multipart::{Form, Part};
use reqwest::{Method, Response};
use serde_json::{Value, json as value};

use crate::client::{Client, json, problem};
use crate::meshes;
use crate::server::{Server, config, scripted};

/// A glTF document whose buffer lies beside it, and the buffer.
fn split(uri: &str) -> (Vec<u8>, Vec<u8>) {
    let (mut document, buffer) = meshes::gltf(&meshes::surface("torus", 300));
    document["buffers"][0]["uri"] = uri.into();
    (document.to_string().into_bytes(), buffer)
}

async fn post(client: &Client, path: &str, files: &[(&str, &[u8])]) -> Response {
    let form = files.iter().fold(Form::new(), |form, (name, bytes)| {
        form.part("mesh", Part::bytes(bytes.to_vec()).file_name((*name).to_owned()))
    });
    client.request(Method::POST, path).multipart(form).send().await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_read_with_the_files_that_it_names() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let (gltf, bin) = split("data/torus.bin");
    let faces = |asset: &Value| asset["faces"].as_u64().unwrap();
    // In any order, with the folders of the files or without them.
    for files in [
        [("ring.gltf", gltf.as_slice()), ("data/torus.bin", &bin)],
        [("torus.bin", &bin), ("ring.gltf", &gltf)],
        [("models/ring.gltf", &gltf), ("models/data/torus.bin", &bin)],
    ] {
        let (status, asset) = json(post(client, "/v1/assets", &files).await).await;
        assert_eq!((status.as_u16(), asset["name"].as_str()), (201, Some("ring.gltf")), "{asset}");
        assert!(faces(&asset) > 200);
        let (status, again) = json(post(client, "/v1/assets", &files).await).await;
        assert_eq!((status.as_u16(), &again["id"]), (200, &asset["id"]), "the same files are the same asset");
    }
    let obj = meshes::obj(&meshes::surface("torus", 300));
    let files = [("a.obj", obj.as_slice()), ("a.mtl", b"newmtl red\n"), ("red.png", b"\x89PNG\r\n\x1a\n")];
    let (status, asset) = json(post(client, "/v1/assets", &files).await).await;
    assert_eq!((status.as_u16(), asset["name"].as_str()), (201, Some("a.obj")), "{asset}");

    let (_, job) = json(post(client, "/v1/jobs", &[("ring.gltf", &gltf), ("data/torus.bin", &bin)]).await).await;
    assert_eq!(job["input"]["name"], "ring.gltf");
    client.delete(job["urls"]["self"].as_str().unwrap()).await;

    problem(post(client, "/v1/jobs", &[("ring.gltf", &gltf), ("other.bin", &bin)]).await, 422, "unreadable-mesh").await;
    problem(post(client, "/v1/jobs", &[("a.obj", &obj), ("b.obj", &obj)]).await, 422, "unreadable-mesh").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn files_that_cannot_be_told_apart_or_lead_out_are_refused() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    for names in [["a.obj", "a.obj"], ["a.obj", "./a.obj"], ["a.obj", "../b.mtl"], ["a.obj", ""]] {
        let files = names.map(|name| (name, b"v 0 0 0\n".as_slice()));
        problem(post(client, "/v1/jobs", &files).await, 400, "invalid-request").await;
        problem(post(client, "/v1/assets", &files).await, 400, "invalid-request").await;
    }
    assert_eq!(json(client.get("/v1/jobs").await).await.1["jobs"], value!([]));
    assert_eq!(std::fs::read_dir(folder.path().join("uploads")).unwrap().count(), 0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_limit_of_an_upload_holds_for_all_its_files_together() {
    let folder = tempfile::tempdir().unwrap();
    let mut small = config(folder.path());
    small.limits.upload_bytes = 1000;
    let server = Server::scripted(small).await;
    let client = &server.client;
    let half = [b'v'; 600];
    problem(post(client, "/v1/jobs", &[("a.obj", &half), ("a.mtl", &half)]).await, 413, "body-too-large").await;
    assert_eq!(post(client, "/v1/jobs", &[("a.obj", &half), ("a.mtl", &half[..300])]).await.status(), 202);
    assert_eq!(std::fs::read_dir(folder.path().join("uploads")).unwrap().count(), 0);
    server.stop().await;
}
