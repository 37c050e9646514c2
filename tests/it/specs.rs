//! Specs: long ones cost little, job objects carry a summary, and results that miss what is accepted fail.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use reqwest::multipart::{Form, Part};
use reqwest::{Method, StatusCode};
use serde_json::{Value, json as value};

use crate::client::{Client, json, problem};
use crate::meshes::{obj, surface};
use crate::program::Program;
use crate::server::{Server, scripted};

const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// `item` again and again, with commas, up to about `bytes`.
fn repeated(item: &str, bytes: usize) -> String {
    vec![item; bytes / (item.len() + 1)].join(",")
}

async fn submitted(client: &Client, spec: &str) -> reqwest::Response {
    let form = Form::new()
        .part("spec", Part::text(spec.to_owned()))
        .part("mesh", Part::bytes(MESH.to_vec()).file_name("a.obj"));
    client.request(Method::POST, "/v1/jobs").multipart(form).send().await.expect("an answer")
}

#[tokio::test(flavor = "multi_thread")]
async fn three_bombs_at_once_are_refused_and_cost_little_memory() {
    if !Path::new("/proc/self/status").exists() {
        eprintln!("skipped: this system does not tell the memory of processes");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let server = Program::serve(folder.path());
    let client = &server.client;
    assert_eq!(client.get("/healthz").await.status(), StatusCode::OK);
    let before = server.peak_bytes();
    // 32 MiB, which no spec may have, and 15, which one with edges may have.
    for bytes in [32 << 20, 15 << 20] {
        let bombs = [
            format!("{{\"tags\":[{}]}}", repeated("[0]", bytes)),
            format!("{{\"tags\":{}{}}}", "[".repeat(bytes / 2), "]".repeat(bytes / 2)),
            format!("{{\"edges\":[{}]}}", repeated("[0,1]", bytes)),
        ];
        let sent = bombs.iter().map(|spec| submitted(client, spec));
        for refused in futures_util::future::join_all(sent).await {
            let (status, body) = json(refused).await;
            assert!([413, 422].contains(&status.as_u16()), "{body}");
        }
        let bodies = bombs.iter().map(|spec| {
            let body = format!("{{\"asset\":\"x\",\"spec\":{spec}}}");
            client.request(Method::POST, "/v1/jobs").header("content-type", "application/json").body(body).send()
        });
        for refused in futures_util::future::join_all(bodies).await {
            let (status, body) = json(refused.expect("an answer")).await;
            assert!([413, 422].contains(&status.as_u16()), "{body}");
        }
    }
    let grown = server.peak_bytes().saturating_sub(before);
    assert!(grown < 200 << 20, "the server grew by {} MiB", grown >> 20);
    assert_eq!(client.get("/healthz").await.status(), StatusCode::OK);
    server.kill();
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_carry_a_summary_and_the_whole_spec_has_its_own_route() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let edges = format!("[{}]", vec!["[0,1]"; 1_000_000].join(","));
    let spec = format!("{{\"features\": {{\"edges\": {edges}}}, \"seed\": 7}}");
    let mut jobs = Vec::new();
    for _ in 0..8 {
        let (status, job) = json(submitted(client, &spec).await).await;
        assert_eq!(status, StatusCode::ACCEPTED, "{job}");
        jobs.push(job);
    }
    for job in &jobs {
        assert_eq!(job["spec"]["features"]["edges"], value!({"count": 1_000_000}));
        assert_eq!((&job["spec"]["seed"], &job["spec"]["strokes"]), (&value!(7), &value!({"count": 0})));
        assert_eq!(client.finished(job).await["spec"], job["spec"]);
        let events = client.events(job, None).await;
        assert_eq!(events.last().unwrap().data["spec"], job["spec"]);
    }
    let mut fastest = Duration::MAX;
    for _ in 0..10 {
        let begun = Instant::now();
        let list = client.get("/v1/jobs").await.text().await.unwrap();
        fastest = fastest.min(begun.elapsed());
        assert!(list.len() < 200 << 10, "{} bytes", list.len());
        assert_eq!(serde_json::from_str::<Value>(&list).unwrap()["jobs"].as_array().unwrap().len(), 8);
    }
    assert!(fastest < Duration::from_millis(50), "{fastest:?}");

    let (status, whole) = json(client.get(jobs[0]["urls"]["spec"].as_str().unwrap()).await).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(whole["features"]["edges"].as_array().unwrap().len(), 1_000_000);
    assert_eq!((&whole["seed"], &whole["target"]["quads"]), (&value!(7), &value!(5000)));
    // What the route shows may be sent again.
    let (status, again) = json(submitted(client, &whole.to_string()).await).await;
    assert_eq!((status, &again["spec"]), (StatusCode::ACCEPTED, &jobs[0]["spec"]));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_that_misses_what_is_accepted_is_a_failed_job_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let mesh = obj(&surface("sphere", 1000));
    let spec = |accept: Value| value!({"target": {"quads": 200}, "accept": accept});
    let job = client.submit("a.obj", &mesh, &spec(value!({"distance": 1e-9}))).await;
    let failed = client.finished(&job).await;
    assert_eq!((failed["status"].as_str(), &failed["result"]), (Some("failed"), &Value::Null));
    let figures = failed["problem"]["figures"].clone();
    assert!(figures["distance"].as_f64().unwrap() > 1e-9, "{failed}");
    assert_eq!(figures["wanted"], 200);
    let gone = problem(client.get(job["urls"]["quad_mesh"].as_str().unwrap()).await, 410, "job-failed").await;
    assert_eq!((&gone["problem"]["type"], &gone["figures"]), (&failed["problem"]["type"], &figures));
    assert_eq!(gone["problem"]["type"], "urn:quadrille:problem:not-acceptable");

    let generous = client.submit("a.obj", &mesh, &spec(value!({"level": "L4", "count": 10, "distance": 1}))).await;
    let done = client.finished(&generous).await;
    assert_eq!((&done["status"], &done["result"]["quads"]), (&value!("succeeded"), &figures["quads"]));
    server.stop().await;
}

#[test]
fn a_result_that_is_not_acceptable_ends_the_command_line_with_4_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.obj"), folder.path().join("out.obj"));
    std::fs::write(&input, obj(&surface("sphere", 1000))).unwrap();
    let remesh = |distance: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_quadrille"));
        command.arg("remesh").arg(&input).arg("-o").arg(&output);
        command.args(["--target-quads", "200", "--accept-distance", distance, "--progress", "none"]);
        command.output().unwrap().status.code()
    };
    assert_eq!((remesh("1e-9"), output.exists()), (Some(4), false));
    assert_eq!((remesh("0.5"), output.exists()), (Some(0), true));
}
