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
        let name = format!("attachment; filename=\"a.quads.{format}\"");
        assert_eq!(named.headers()["content-disposition"], name.as_str());
        let liked = with_header(client, path, "accept", &format!("text/html, {media_type};q=0.9")).await;
        assert_eq!(named.bytes().await.unwrap(), liked.bytes().await.unwrap());
    }
    problem(with_header(client, path, "accept", "image/png").await, 406, "format-not-offered").await;
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

#[tokio::test(flavor = "multi_thread")]
async fn downloads_are_named_after_the_input() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    for (name, stem, encoded) in [
        ("my duck.v2.obj", "my duck.v2", None),
        ("B\u{fc}ste.obj", "B_ste", Some("B%C3%BCste")),
        ("a;b=\u{1F986}.obj", "a;b=_", Some("a%3Bb%3D%F0%9F%A6%86")),
        ("..\\..\\secret.obj", "secret", None),
    ] {
        let job = client.submit(name, format!("v 0 0 0\n# {name}").as_bytes(), &value!({})).await;
        client.finished(&job).await;
        for (url, ending) in
            [("quad_mesh", "quads.obj"), ("archive", "zip"), ("report", "report.json"), ("preview", "png")]
        {
            let answer = client.get(job["urls"][url].as_str().unwrap()).await;
            let shown = answer.headers()["content-disposition"].to_str().unwrap().to_owned();
            assert!(shown.contains(&format!("; filename=\"{stem}.{ending}\"")), "{shown}");
            let saved = matches!(url, "quad_mesh" | "archive");
            assert_eq!(shown.starts_with("attachment"), saved, "{shown}");
            let expected = encoded.map(|encoded| format!("filename*=UTF-8''{encoded}.{ending}"));
            assert_eq!(shown.contains("filename*"), expected.is_some(), "{shown}");
            assert!(expected.is_none_or(|expected| shown.ends_with(&expected)), "{shown}");
        }
    }
    // The same bytes under another name, and without one.
    let renamed = client.submit("other.obj", b"v 0 0 0\n# my duck.v2.obj", &value!({})).await;
    assert_eq!(renamed["input"]["name"], "other.obj");
    let nameless = client.submit("", b"v 0 0 0\n", &value!({})).await;
    client.finished(&nameless).await;
    let shown = client.get(nameless["urls"]["quad_mesh"].as_str().unwrap()).await;
    assert!(shown.headers()["content-disposition"].to_str().unwrap().contains(nameless["id"].as_str().unwrap()));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_archive_has_every_file_as_it_is_downloaded() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let mesh: String = (0..200_000).map(|n| format!("v {n} 0 0\n")).collect();
    let job = client.submit("duck.obj", mesh.as_bytes(), &value!({})).await;
    let path = job["urls"]["archive"].as_str().unwrap();
    client.finished(&job).await;
    let answer = client.get(path).await;
    assert_eq!(answer.headers()["content-type"], "application/zip");
    let etag = answer.headers()["etag"].to_str().unwrap().to_owned();
    let bytes = answer.bytes().await.unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let mut names: Vec<_> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    names.sort();
    assert_eq!(names, ["duck.quads.glb", "duck.quads.obj", "duck.quads.ply", "duck.quads.usda", "duck.report.json"]);
    for format in ["obj", "glb"] {
        let mut entry = archive.by_name(&format!("duck.quads.{format}")).unwrap();
        let mut packed = Vec::new();
        std::io::Read::read_to_end(&mut entry, &mut packed).unwrap();
        let single = client.get(&format!("{}?format={format}", job["urls"]["quad_mesh"].as_str().unwrap())).await;
        assert_eq!(packed, single.bytes().await.unwrap());
    }
    assert!(bytes.len() < 3 * mesh.len(), "text is packed");
    assert_eq!(client.get(path).await.bytes().await.unwrap(), bytes, "the same files are the same archive");
    assert_eq!(with_header(client, path, "if-none-match", &etag).await.status(), StatusCode::NOT_MODIFIED);

    let failed = client.submit("a.obj", b"v 0 0 0\n", &value!({"tags": ["fail"]})).await;
    client.finished(&failed).await;
    problem(client.get(failed["urls"]["archive"].as_str().unwrap()).await, 410, "job-failed").await;
    let slow = client.submit("a.obj", b"v 0 0 0\n", &value!({"tags": ["slow"]})).await;
    problem(client.get(slow["urls"]["archive"].as_str().unwrap()).await, 409, "not-ready").await;
    server.stop().await;
}
