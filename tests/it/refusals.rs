//! What cannot be used is refused at once, with the cause and the place.

use reqwest::Method;
use reqwest::multipart::{Form, Part};
use serde_json::json as value;

use crate::client::problem;
use crate::server::{Server, config, scripted};

#[tokio::test(flavor = "multi_thread")]
async fn bodies_that_are_no_submissions_are_refused() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let post = |form: Form| client.request(Method::POST, "/v1/jobs").multipart(form).send();
    let mesh = || Part::bytes(b"v 0 0 0\n".to_vec()).file_name("a.obj");
    problem(post(Form::new().text("spec", "{}")).await.unwrap(), 400, "invalid-request").await;
    problem(post(Form::new().part("mesh", mesh()).part("mesh", mesh())).await.unwrap(), 400, "invalid-request").await;
    problem(post(Form::new().part("mesh", mesh()).text("colour", "red")).await.unwrap(), 400, "invalid-request").await;
    let raw = |media_type: &'static str, body: &'static str| {
        client.request(Method::POST, "/v1/jobs").header("content-type", media_type).body(body).send()
    };
    for (media_type, body) in [
        ("text/plain", "v 0 0 0"),
        ("application/json", "{"),
        ("application/json", "[]"),
        ("application/json", "{\"asset\": 1}"),
        ("application/json", "{\"asset\": \"x\", \"speck\": {}}"),
        ("multipart/form-data", "x"),
        (
            "multipart/form-data; boundary=x",
            "--x\r\ncontent-disposition: form-data; name=\"mesh\"; filename=\"a.obj\"\r\n\r\nv 0",
        ),
    ] {
        problem(raw(media_type, body).await.unwrap(), 400, "invalid-request").await;
    }
    problem(raw("application/json", "{\"asset\": \"x\"}").await.unwrap(), 404, "not-found").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn all_violations_of_a_spec_come_at_once() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let spec = value!({"colour": 1, "target": {"quads": 0}, "features": {"angle": 200}});
    let refused = client.submission("a.obj", b"v 0 0 0\n", &spec).send().await.unwrap();
    let body = problem(refused, 422, "invalid-spec").await;
    let mut pointers: Vec<_> =
        body["errors"].as_array().unwrap().iter().filter_map(|e| e["pointer"].as_str()).collect();
    pointers.sort_unstable();
    assert_eq!(pointers, ["/colour", "/features/angle", "/target/quads"]);
    for spec in [value!({"target": {"quads": 1_000_000_000}}), value!({"deadline_s": 1e6}), value!(7)] {
        let refused = client.submission("a.obj", b"v 0 0 0\n", &spec).send().await.unwrap();
        problem(refused, 422, "invalid-spec").await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn uploads_have_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let mut small = config(folder.path());
    small.limits.upload_bytes = 1000;
    let server = Server::scripted(small).await;
    let refused = server.client.submission("a.obj", &[b'v'; 1001], &value!({})).send().await.unwrap();
    problem(refused, 413, "body-too-large").await;
    let accepted = server.client.submission("a.obj", &[b'v'; 1000], &value!({})).send().await.unwrap();
    assert_eq!(accepted.status(), 202);
    assert_eq!(std::fs::read_dir(folder.path().join("uploads")).unwrap().count(), 0);
    server.stop().await;
}
