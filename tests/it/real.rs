//! The whole way with the real engine, in this process and in a child that is the real program.

use std::time::{Duration, Instant};

use quadrille::service::formats::{Format, QuadFormat, ReadLimits, read_quads, read_soup};
use reqwest::StatusCode;
use serde_json::{Value, json as value};

use crate::client::{Client, json, problem};
use crate::meshes::{embedded, glb, gltf, obj, surface, zip};
use crate::program::Program;
use crate::server::Server;

async fn bytes(client: &Client, path: &str) -> Vec<u8> {
    let response = client.get(path).await;
    assert_eq!(response.status(), StatusCode::OK, "{path}");
    response.bytes().await.unwrap().to_vec()
}

/// Downloads everything that a finished job has, and reads it again.
async fn check_files(client: &Client, job: &Value) {
    let quad_mesh = job["urls"]["quad_mesh"].as_str().unwrap();
    let n_quads = job["result"]["quads"].as_u64().unwrap() as usize;
    let exact = read_quads(&bytes(client, &format!("{quad_mesh}?format=ply")).await, QuadFormat::Ply).unwrap();
    assert_eq!(exact.quads.len(), n_quads);
    for format in QuadFormat::ALL {
        let file = bytes(client, &format!("{quad_mesh}?format={}", format.extension())).await;
        let quads = read_quads(&file, format).unwrap();
        assert_eq!(quads.quads.len(), n_quads, "{format:?}");
        assert_eq!(quads.positions.len(), exact.positions.len(), "{format:?}");
        let far = quads.positions.iter().zip(&exact.positions).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(far < 1e-5, "{format:?} moves vertices by {far}");
    }
    let report: Value = serde_json::from_slice(&bytes(client, job["urls"]["report"].as_str().unwrap()).await).unwrap();
    assert_eq!(report["certified"], true);
    assert_eq!(report["quads"]["count"], n_quads);
    assert!(report["timings_ms"]["total"].as_f64().unwrap() > 0.0);

    let map = job["urls"]["parameterisation"].as_str().unwrap();
    if report["map"].is_null() {
        problem(client.get(map).await, 404, "no-artefact").await;
    } else {
        let file = bytes(client, &format!("{map}?format=obj")).await;
        let triangles = read_soup(&file, Some(Format::Obj), &ReadLimits::default()).unwrap();
        assert_eq!(triangles.n_polygons() as u64, report["map"]["triangles"].as_u64().unwrap());
        assert!(file.windows(4).any(|text| text == b"\nvt "), "texture coordinates");
        let file = bytes(client, &format!("{map}?format=glb")).await;
        let again = read_soup(&file, Some(Format::Glb), &ReadLimits::default()).unwrap();
        assert_eq!(again.n_polygons(), triangles.n_polygons());
        let transitions: Value = serde_json::from_slice(&bytes(client, &format!("{map}?format=json")).await).unwrap();
        assert!(transitions.is_object());
    }
    let preview = job["urls"]["preview"].as_str().unwrap();
    for path in [preview.to_owned(), format!("{preview}?size=100")] {
        assert!(bytes(client, &path).await.starts_with(b"\x89PNG"));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn obj_gltf_and_zip_go_in_and_every_file_comes_out() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let sphere = surface("sphere", 1000);
    let (document, buffer) = gltf(&sphere);
    let mut apart = document.clone();
    apart["buffers"][0]["uri"] = "sphere.bin".into();
    let uploads = [
        ("sphere.obj", obj(&sphere)),
        ("sphere.glb", glb(&document, &buffer)),
        ("sphere.gltf", embedded(document, &buffer)),
        ("sphere.zip", zip(&[("sphere.gltf", apart.to_string().as_bytes()), ("sphere.bin", &buffer)])),
    ];
    let mut counts = Vec::new();
    for (name, mesh) in uploads {
        let job = client.submit(name, &mesh, &value!({"target": {"quads": 400}, "tags": ["whole"]})).await;
        assert_eq!(job["input"]["format"], name.rsplit('.').next().unwrap());
        let events = client.events(&job, None).await;
        let done = &events.last().unwrap().data;
        assert_eq!(done["status"], "succeeded", "{name}: {}", done["problem"]);
        let stages: Vec<_> =
            events.iter().filter(|event| event.kind == "stage").map(|event| &event.data["stage"]).collect();
        assert!(stages.contains(&&value!("read")) && stages.contains(&&value!("write")), "{stages:?}");
        assert_eq!(
            (done["input"]["triangles"].as_u64(), done["result"]["certified"].as_bool()),
            (Some(sphere.n_polygons() as u64), Some(true))
        );
        counts.push(done["result"]["quads"].as_u64().unwrap());
        check_files(client, done).await;
    }
    assert!(counts[0] > 200 && counts[0] < 800, "{counts:?}");
    assert_eq!(counts[1], counts[2], "GLB and glTF hold the same numbers");
    server.stop().await;
}

/// A job that takes long enough to be caught in the act.
fn long_job() -> (Vec<u8>, Value) {
    (obj(&surface("genus5", 30_000)), value!({"target": {"quads": 6_000}}))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_real_run_stops_when_it_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let (mesh, spec) = long_job();
    let job = client.submit("blob.obj", &mesh, &spec).await;
    client.until(&job, |job| job["stage"].is_string() && job["stage"] != "read").await;
    let (_, cancelled) = json(client.post(job["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!(cancelled["status"], "cancelled", "within the second that the answer waits");
    problem(client.get(job["urls"]["quad_mesh"].as_str().unwrap()).await, 410, "job-failed").await;
    let small = client.submit("cube.obj", &obj(&surface("cube", 500)), &value!({"target": {"quads": 100}})).await;
    assert_eq!(client.finished(&small).await["status"], "succeeded", "the worker is free again");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deadline_ends_in_a_result_or_in_its_problem() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let (mesh, mut spec) = long_job();
    spec["deadline_s"] = value!(0.2);
    let job = client.submit("blob.obj", &mesh, &spec).await;
    let begun = Instant::now();
    let done = client.finished(&job).await;
    // With room for a machine that does other things as well; without the deadline it would be half a minute or more.
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    match done["status"].as_str() {
        Some("succeeded") => check_files(client, &done).await,
        _ => assert_eq!(done["problem"]["type"], "urn:quadrille:problem:deadline-exceeded", "{done}"),
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_finishes_after_the_program_was_killed() {
    let folder = tempfile::tempdir().unwrap();
    let program = Program::serve(folder.path());
    let mesh = obj(&surface("torus", 20_000));
    let job = program.client.submit("torus.obj", &mesh, &value!({"target": {"quads": 4000}})).await;
    let other =
        program.client.submit("cube.obj", &obj(&surface("cube", 500)), &value!({"target": {"quads": 100}})).await;
    program.client.until(&job, |job| job["stage"].is_string()).await;
    program.kill();

    let program = Program::serve(folder.path());
    let done = program.client.finished(&job).await;
    assert_eq!(
        (done["status"].as_str(), done["attempt"].as_u64()),
        (Some("succeeded"), Some(2)),
        "{}",
        done["problem"]
    );
    check_files(&program.client, &done).await;
    assert_eq!(program.client.finished(&other).await["attempt"], 1);
    program.end();
}
