//! Every bad input of the acceptance list gets its problem, over HTTP, from the real readers and the real engine.

use serde_json::{Value, json as value};

use crate::client::problem;
use crate::meshes::{embedded, glb, gltf, obj, surface, zip};
use crate::server::Server;

/// Name, bytes, status and slug of the refusal.
fn refused_at_once() -> Vec<(&'static str, Vec<u8>, u16, &'static str)> {
    let cube = surface("cube", 500);
    let (document, buffer) = gltf(&cube);
    let whole = glb(&document, &buffer);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = document.clone();
        change(&mut changed);
        embedded(changed, &buffer)
    };
    let noise: Vec<u8> = (0..5000u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let bomb = vec![b'\n'; 300 << 20];
    vec![
        ("nothing", Vec::new(), 415, "unknown-format"),
        ("nothing.obj", Vec::new(), 422, "unreadable-mesh"),
        ("noise", noise.clone(), 415, "unknown-format"),
        ("noise.glb", noise.clone(), 422, "unreadable-mesh"),
        ("noise.ply", noise, 422, "unreadable-mesh"),
        ("truncated.glb", whole[..whole.len() / 2].to_vec(), 422, "unreadable-mesh"),
        ("past.gltf", with(&|d| d["accessors"][0]["count"] = 100_000.into()), 422, "unreadable-mesh"),
        ("view.gltf", with(&|d| d["bufferViews"][1]["byteOffset"] = u64::MAX.into()), 422, "unreadable-mesh"),
        ("billions.gltf", with(&|d| d["accessors"][0]["count"] = 4_000_000_000u64.into()), 422, "unreadable-mesh"),
        (
            "billions.ply",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n\
              property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                .to_vec(),
            413,
            "mesh-too-large",
        ),
        (
            "cycle.gltf",
            with(&|d| d["nodes"] = value!([{"mesh": 0, "children": [1]}, {"children": [0]}])),
            422,
            "unreadable-mesh",
        ),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".to_vec(), 422, "unreadable-mesh"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n".to_vec(), 422, "unreadable-mesh"),
        (
            "extension.gltf",
            with(&|d| d["extensionsRequired"] = value!(["EXT_of_tomorrow"])),
            422,
            "unsupported-extension",
        ),
        ("bomb.zip", zip(&[("bomb.obj", &bomb)]), 413, "mesh-too-large"),
        ("escape.zip", zip(&[("../escape.obj", &obj(&cube))]), 422, "unreadable-mesh"),
        ("other.zip", zip(&[("readme.txt", b"hello")]), 422, "unreadable-mesh"),
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_read_is_refused_when_it_is_sent() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    for (name, mesh, status, slug) in refused_at_once() {
        let refused = server.client.submission(name, &mesh, &value!({})).send().await.unwrap();
        assert_eq!(refused.status(), status, "{name}: {}", refused.text().await.unwrap());
        problem(refused, status, slug).await;
    }
    assert_eq!(std::fs::read_dir(folder.path().join("uploads")).unwrap().count(), 0, "nothing is left behind");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_no_surface_fails_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let cases = [
        ("nan.obj", "v nan nan nan\nv nan 0 0\nv 0 nan 0\nf 1 2 3\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\nf 2 3 4\n"),
        ("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"),
    ];
    for (name, mesh) in cases {
        let response = server.client.submission(name, mesh.as_bytes(), &value!({})).send().await.unwrap();
        // Whether the reader or the conditioning finds it, the kind is one of the input's and the detail says why.
        let body: Value = response.json().await.unwrap();
        let body = if body["id"].is_string() { server.client.finished(&body).await["problem"].clone() } else { body };
        let slug = body["type"].as_str().unwrap_or_default().rsplit(':').next().unwrap_or_default().to_owned();
        assert!(["mesh-rejected", "unreadable-mesh"].contains(&&*slug), "{name}: {body}");
        assert!(!body["detail"].as_str().unwrap_or_default().is_empty(), "{name}");
    }
    let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let job = server.client.submit("triangle.obj", triangle, &value!({"target": {"quads": 12}})).await;
    let done = server.client.finished(&job).await;
    assert_eq!(done["status"], "succeeded", "a single triangle is a surface: {}", done["problem"]);
    server.stop().await;
}
