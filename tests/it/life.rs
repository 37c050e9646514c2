//! The life of jobs: accepted, waiting, running, finished, listed, deleted.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use reqwest::{Method, StatusCode};
use serde_json::{Value, json as value};

use crate::client::{json, problem};
use crate::server::{Server, config, scripted};

const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[tokio::test(flavor = "multi_thread")]
async fn a_job_runs_and_its_events_tell_the_whole_story_again_and_again() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = client.submit("triangle.obj", MESH, &value!({"tags": ["one"], "seed": 7})).await;
    assert_eq!(job["status"], "queued");
    assert_eq!(job["spec"]["target"]["quads"], 5000, "defaults are filled in");
    assert_eq!(job["input"]["bytes"], MESH.len());
    let events = client.events(&job, None).await;
    let last = events.last().unwrap();
    assert_eq!(last.kind, "succeeded");
    assert_eq!(last.data["result"]["quads"], 3);
    assert!(events.iter().any(|event| event.kind == "stage" && event.data["stage"] == "write"));
    assert!(events.iter().all(|event| event.kind != "progress" || event.data["progress"].as_f64().is_some()));
    assert!(events.windows(2).all(|pair| pair[0].id < pair[1].id));
    assert_ne!(events[0].data["progress"], 0.0, "what was over before it was followed does not begin again");
    let middle = events[events.len() / 2].id;
    let rest: Vec<_> = events.iter().filter(|event| event.id > middle).cloned().collect();
    assert_eq!(client.events(&job, Some(middle)).await, rest);
    assert!(client.events(&job, Some(last.id)).await.is_empty());

    let done = client.finished(&job).await;
    assert_eq!((done["status"].as_str(), done["progress"].as_f64()), (Some("succeeded"), Some(1.0)));
    assert_eq!(done["attempt"], 1);
    assert_eq!(done["input"]["triangles"], 1);
    assert!(done["finished_at"].as_str() < done["expires_at"].as_str());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_job_runs_and_the_others_know_their_place() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let slow = client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    client.running(&slow).await;
    let low = client.submit("a.obj", MESH, &value!({"tags": ["low"], "priority": -5})).await;
    let high = client.submit("a.obj", MESH, &value!({"tags": ["high"], "priority": 5})).await;
    let place = |job: Value| async move { client.until(&job, |_| true).await["queue_position"].clone() };
    assert_eq!(place(high.clone()).await, 0);
    assert_eq!(place(low.clone()).await, 1);
    assert_eq!(place(slow.clone()).await, Value::Null);

    // A running job stops within a second, a waiting one at once, and both stay cancelled.
    let begun = Instant::now();
    let (status, job) = json(client.post(&format!("{}/cancel", slow["urls"]["self"].as_str().unwrap())).await).await;
    assert!(begun.elapsed() < Duration::from_secs(1));
    assert_eq!((status, job["status"].as_str()), (StatusCode::OK, Some("cancelled")));
    assert_eq!(job["problem"]["type"], "urn:quadrille:problem:cancelled");
    let done = client.finished(&high).await;
    let later = client.finished(&low).await;
    // Which of the two runs first is not asserted: the worker may hold the ticket of the first already when the second,
    // of higher priority, comes. Positions in the queue are by priority, as asserted above.
    for job in [&done, &later] {
        assert_eq!(job["status"], "succeeded", "{}", job["problem"]);
    }
    let (status, again) = json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!((status, again["status"].as_str()), (StatusCode::OK, Some("cancelled")), "cancelling is idempotent");
    assert_eq!(client.events(&slow, None).await.last().unwrap().kind, "cancelled");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_waiting_job_is_cancelled_at_once_and_never_runs() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let slow = client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    client.running(&slow).await;
    let waiting = client.submit("a.obj", MESH, &value!({})).await;
    let (_, cancelled) = json(client.post(waiting["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!((cancelled["status"].as_str(), cancelled["attempt"].as_u64()), (Some("cancelled"), Some(0)));
    json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    let next = client.submit("a.obj", MESH, &value!({})).await;
    client.finished(&next).await;
    assert_eq!(client.until(&waiting, |_| true).await["status"], "cancelled");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_failed_job_carries_its_problem_and_so_do_its_files() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = client.submit("a.obj", MESH, &value!({"tags": ["fail"]})).await;
    let done = client.finished(&job).await;
    assert_eq!(done["status"], "failed");
    assert_eq!(done["problem"]["type"], "urn:quadrille:problem:no-quad-mesh-found");
    assert_eq!(done["problem"]["instance"], job["urls"]["self"]);
    assert_eq!(done["problem"]["stage"], "extract");
    for url in ["quad_mesh", "parameterisation", "report", "preview"] {
        let gone = problem(client.get(job["urls"][url].as_str().unwrap()).await, 410, "job-failed").await;
        assert_eq!(gone["problem"], done["problem"]);
        assert_eq!(gone["stage"], "extract");
    }
    let panicking = client.submit("a.obj", MESH, &value!({"tags": ["panic"]})).await;
    let done = client.finished(&panicking).await;
    assert_eq!(done["problem"]["type"], "urn:quadrille:problem:internal");
    assert!(!done["problem"]["detail"].as_str().unwrap().contains("on purpose"));
    let fine = client.submit("a.obj", MESH, &value!({})).await;
    assert_eq!(client.finished(&fine).await["status"], "succeeded", "a panic ends one job only");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn files_that_do_not_exist_yet_are_a_conflict() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let slow = client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    for url in ["quad_mesh", "parameterisation", "report", "preview"] {
        let early = problem(client.get(slow["urls"][url].as_str().unwrap()).await, 409, "not-ready").await;
        assert!(early["retry_after"].as_u64().is_some());
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_key_and_body_are_the_same_job() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let keyed = |mesh: &'static [u8], spec: Value| {
        client.submission("a.obj", mesh, &spec).header("Idempotency-Key", "k-1").send()
    };
    let (status, first) = json(keyed(MESH, value!({"seed": 1})).await.unwrap()).await;
    assert_eq!(status, StatusCode::ACCEPTED);
    let (_, second) = json(keyed(MESH, value!({"seed": 1})).await.unwrap()).await;
    assert_eq!(first["id"], second["id"]);
    problem(keyed(MESH, value!({"seed": 2})).await.unwrap(), 422, "idempotency-conflict").await;
    problem(keyed(b"v 0 0 0\n", value!({"seed": 1})).await.unwrap(), 422, "idempotency-conflict").await;
    client.finished(&first).await;
    assert_eq!(client.delete(first["urls"]["self"].as_str().unwrap()).await.status(), StatusCode::NO_CONTENT);
    let (_, third) = json(keyed(MESH, value!({"seed": 2})).await.unwrap()).await;
    assert_ne!(first["id"], third["id"], "a deleted job frees its key");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_prefers_to_wait_gets_the_result() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let wait =
        |spec: Value, n: u32| client.submission("a.obj", MESH, &spec).header("Prefer", format!("wait={n}")).send();
    let response = wait(value!({}), 60).await.unwrap();
    assert_eq!(response.headers()["preference-applied"], "wait");
    let (status, job) = json(response).await;
    assert_eq!((status, job["status"].as_str()), (StatusCode::OK, Some("succeeded")));
    let (status, job) = json(wait(value!({"tags": ["slow"]}), 1).await.unwrap()).await;
    assert_eq!((status, job["status"].as_str()), (StatusCode::ACCEPTED, Some("running")));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_hold_every_job_once_newest_first() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let mut submitted = Vec::new();
    for n in 0..7 {
        let tag = if n % 2 == 0 { "even" } else { "odd" };
        let job = client.submit("a.obj", MESH, &value!({"tags": [tag], "seed": n})).await;
        submitted.push(client.finished(&job).await["id"].clone());
    }
    submitted.reverse();
    let (mut found, mut path) = (Vec::new(), "/v1/jobs?limit=3".to_owned());
    loop {
        let (status, page) = json(client.get(&path).await).await;
        assert_eq!(status, StatusCode::OK);
        let jobs = page["jobs"].as_array().unwrap();
        assert!(jobs.len() <= 3);
        found.extend(jobs.iter().map(|job| job["id"].clone()));
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        path = format!("/v1/jobs?limit=3&cursor={cursor}");
    }
    assert_eq!(found, submitted);
    let count = |query: &'static str| async move {
        json(client.get(&format!("/v1/jobs?{query}")).await).await.1["jobs"].as_array().unwrap().len()
    };
    assert_eq!(count("tag=odd").await, 3);
    assert_eq!(count("status=succeeded&method=quadcover").await, 7);
    assert_eq!(count("status=failed").await, 0);
    for query in ["limit=0", "limit=201", "cursor=abc", "status=lost", "colour=red", "limit=x"] {
        problem(client.get(&format!("/v1/jobs?{query}")).await, 400, "invalid-request").await;
    }
    server.stop().await;
}

fn files_below(folder: &std::path::Path) -> BTreeSet<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths.flat_map(|path| if path.is_dir() { files_below(&path) } else { [path].into() }).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn deleting_leaves_nothing_behind() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    let done = client.submit("a.obj", MESH, &value!({})).await;
    client.finished(&done).await;
    let slow = client.submit("b.obj", b"v 1 1 1\n", &value!({"tags": ["slow"]})).await;
    client.running(&slow).await;
    let waiting = client.submit("b.obj", b"v 2 2 2\n", &value!({})).await;
    for job in [&done, &slow, &waiting] {
        let path = job["urls"]["self"].as_str().unwrap();
        assert_eq!(client.delete(path).await.status(), StatusCode::NO_CONTENT);
        problem(client.get(path).await, 404, "not-found").await;
        problem(client.delete(path).await, 404, "not-found").await;
    }
    // The worker is free again: the deleted run was stopped, and its ticket starts nothing.
    let next = client.submit("c.obj", b"v 3 3 3\n", &value!({})).await;
    client.finished(&next).await;
    client.delete(next["urls"]["self"].as_str().unwrap()).await;
    assert_eq!(files_below(&folder.path().join("objects")), BTreeSet::new());
    assert_eq!(files_below(&folder.path().join("uploads")), BTreeSet::new());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_bytes_are_one_asset() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    let upload = |bytes: &'static [u8]| {
        let part = reqwest::multipart::Part::bytes(bytes).file_name("a.obj");
        client.request(Method::POST, "/v1/assets").multipart(reqwest::multipart::Form::new().part("mesh", part)).send()
    };
    let (status, asset) = json(upload(MESH).await.unwrap()).await;
    assert_eq!(
        (status, asset["vertices"].as_u64(), asset["name"].as_str()),
        (StatusCode::CREATED, Some(3), Some("a.obj"))
    );
    let (status, again) = json(upload(MESH).await.unwrap()).await;
    assert_eq!((status, &again["id"]), (StatusCode::OK, &asset["id"]));
    problem(upload(b"bad").await.unwrap(), 422, "unreadable-mesh").await;
    assert_eq!(files_below(&folder.path().join("objects")).len(), 1);

    let path = format!("/v1/assets/{}", asset["id"].as_str().unwrap());
    assert_eq!(client.get(&path).await.status(), StatusCode::OK);
    assert_eq!(client.request(Method::HEAD, &path).send().await.unwrap().status(), StatusCode::OK);
    let order = |tags: Value| {
        let body = value!({"asset": asset["id"], "spec": {"tags": tags}});
        client.request(Method::POST, "/v1/jobs").json(&body).send()
    };
    let (status, slow) = json(order(value!(["slow"])).await.unwrap()).await;
    assert_eq!((status, &slow["input"]["sha256"]), (StatusCode::ACCEPTED, &asset["sha256"]));
    problem(client.delete(&path).await, 409, "asset-in-use").await;
    json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    client.finished(&slow).await;
    let (_, done) = json(order(value!([])).await.unwrap()).await;
    assert_eq!(client.finished(&done).await["status"], "succeeded");
    assert_eq!(client.delete(&path).await.status(), StatusCode::NO_CONTENT);
    problem(client.get(&path).await, 404, "not-found").await;
    problem(order(value!([])).await.unwrap(), 404, "not-found").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_orderly_shutdown_puts_running_jobs_back_in_line() {
    let (folder, server) = scripted().await;
    let slow = server.client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    let quick = server.client.submit("a.obj", MESH, &value!({})).await;
    server.client.running(&slow).await;
    server.stop().await;
    // On the same folder: both are still there, and the interrupted one counts no crash.
    let mut once = config(folder.path());
    once.jobs.max_attempts = 1;
    let server = Server::scripted(once).await;
    let client = &server.client;
    assert_eq!(client.finished(&quick).await["status"], "succeeded", "the interrupted job went to the end of the line");
    let again = client.running(&slow).await;
    assert_eq!(again["attempt"], 2);
    json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!(client.finished(&slow).await["status"], "cancelled");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn finished_jobs_expire() {
    let folder = tempfile::tempdir().unwrap();
    let mut short = config(folder.path());
    short.jobs.retention = Duration::ZERO;
    let server = Server::scripted(short.clone()).await;
    let job = server.client.submit("a.obj", MESH, &value!({})).await;
    let path = job["urls"]["self"].as_str().unwrap().to_owned();
    server.client.finished(&job).await;
    server.stop().await;
    // Every start begins with a sweep.
    let server = Server::scripted(short).await;
    let begun = Instant::now();
    while server.client.get(&path).await.status() == StatusCode::OK {
        assert!(begun.elapsed() < crate::client::PATIENCE);
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    // The job goes first, its files after it.
    while files_below(&folder.path().join("objects")) != BTreeSet::new() {
        assert!(begun.elapsed() < crate::client::PATIENCE);
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_line_takes_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let mut short = config(folder.path());
    short.limits.queued_jobs = 1;
    let server = Server::scripted(short).await;
    let client = &server.client;
    let slow = client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    client.running(&slow).await;
    client.submit("a.obj", MESH, &value!({})).await;
    let refused = client.submission("a.obj", MESH, &value!({})).send().await.unwrap();
    assert!(refused.headers().contains_key("retry-after"));
    problem(refused, 503, "queue-full").await;
    server.stop().await;
}
