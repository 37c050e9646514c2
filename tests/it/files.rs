//! Downloads: formats, entity tags, ranges.

use reqwest::{Method, StatusCode};
use serde_json::{Value, json as value};

use crate::client::{Client, problem};
use crate::server::scripted;

async fn with_header(client: &Client, path: &str, name: &str, header: &str) -> reqwest::Response {
    client.request(Method::GET, path).header(name, header).send().await.unwrap()
}

async fn finished(client: &Client) -> Value {
    let job = client.submit("a.obj", b"v 0 0 0\n", &value!({})).await;
    client.finished(&job).await
}

#[tokio::test(flavor = "multi_thread")]
async fn every_format_is_there_by_name_and_by_negotiation() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = finished(client).await;
    let path = job["urls"]["quad_mesh"].as_str().unwrap();
    for (format, media_type) in
        [("obj", "model/obj"), ("glb", "model/gltf-binary"), ("ply", "application/ply"), ("usda", "model/vnd.usda")]
    {
        let named = client.get(&format!("{path}?format={format}")).await;
        assert_eq!(named.headers()["content-type"], media_type);
        let name = format!("attachment; filename=\"{}-quad-mesh.{format}\"", job["id"].as_str().unwrap());
        assert_eq!(named.headers()["content-disposition"], name.as_str());
        let liked = with_header(client, path, "accept", &format!("text/html, {media_type};q=0.9")).await;
        assert_eq!(named.bytes().await.unwrap(), liked.bytes().await.unwrap());
    }
    problem(with_header(client, path, "accept", "image/png").await, 406, "not-acceptable").await;
    problem(client.get(&format!("{path}?format=fbx")).await, 400, "invalid-request").await;
    let map = client.get(job["urls"]["parameterisation"].as_str().unwrap()).await;
    problem(map, 404, "no-artefact").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn tags_and_ranges_follow_the_rules_of_http() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = finished(client).await;
    let path = format!("{}?format=obj", job["urls"]["quad_mesh"].as_str().unwrap());
    let whole = client.get(&path).await;
    let etag = whole.headers()["etag"].to_str().unwrap().to_owned();
    assert!(etag.starts_with('"') && whole.headers()["accept-ranges"] == "bytes");
    let whole = whole.bytes().await.unwrap();

    let part = with_header(client, &path, "range", "bytes=2-5").await;
    assert_eq!(part.status(), StatusCode::PARTIAL_CONTENT);
    assert_eq!(part.headers()["content-range"], format!("bytes 2-5/{}", whole.len()).as_str());
    assert_eq!(part.bytes().await.unwrap(), whole.slice(2..6));
    let outside = with_header(client, &path, "range", "bytes=100000-").await;
    assert_eq!(outside.headers()["content-range"], format!("bytes */{}", whole.len()).as_str());
    problem(outside, 416, "range-not-satisfiable").await;
    let changed = client.request(Method::GET, &path).header("range", "bytes=0-1").header("if-range", "\"other\"");
    assert_eq!(changed.send().await.unwrap().status(), StatusCode::OK);
    let same = client.request(Method::GET, &path).header("range", "bytes=0-1").header("if-range", &etag);
    assert_eq!(same.send().await.unwrap().bytes().await.unwrap(), whole.slice(0..2));

    let known = with_header(client, &path, "if-none-match", &etag).await;
    assert_eq!((known.status(), known.headers()["etag"].to_str().unwrap()), (StatusCode::NOT_MODIFIED, &*etag));
    let head = client.request(Method::HEAD, &path).send().await.unwrap();
    assert_eq!(head.headers()["content-length"], whole.len().to_string().as_str());
    assert!(head.bytes().await.unwrap().is_empty());

    let small = client.get(&format!("{}?size=64", job["urls"]["preview"].as_str().unwrap())).await;
    assert_eq!(small.headers()["content-type"], "image/png");
    assert!(small.text().await.unwrap().starts_with("64 pixels"));
    problem(client.get(&format!("{}?size=9", job["urls"]["preview"].as_str().unwrap())).await, 400, "invalid-request")
        .await;
    server.stop().await;
}
