//! Answers are compressed for those who accept it, and stay what they are for everyone else.

use reqwest::{Method, Response, StatusCode};
use serde_json::{Value, json as value};

use crate::client::Client;
use crate::server::scripted;

/// A job whose files are about as long as its mesh.
async fn long_job(client: &Client) -> Value {
    let mesh = "v 0.25 0.5 0.125\n".repeat(2000);
    let job = client.submit("a.obj", mesh.as_bytes(), &value!({})).await;
    client.finished(&job).await
}

async fn get(client: &Client, path: &str, headers: &[(&str, &str)]) -> Response {
    let request = client.request(Method::GET, path);
    headers.iter().fold(request, |request, (name, value)| request.header(*name, *value)).send().await.unwrap()
}

fn header(response: &Response, name: &str) -> String {
    let values: Vec<_> = response.headers().get_all(name).iter().map(|value| value.to_str().unwrap()).collect();
    values.join(", ")
}

#[tokio::test(flavor = "multi_thread")]
async fn text_is_compressed_by_what_the_client_accepts() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = long_job(client).await;
    let path = format!("{}?format=obj", job["urls"]["quad_mesh"].as_str().unwrap());
    let plain = get(client, &path, &[]).await;
    let etag = header(&plain, "etag");
    assert_eq!(header(&plain, "content-encoding"), "");
    let length = plain.bytes().await.unwrap().len();
    for (accepted, encoding, magic) in [
        ("gzip, deflate, br", "gzip", [0x1f, 0x8b].as_slice()),
        ("gzip;q=0.5, zstd", "zstd", &[0x28, 0xb5, 0x2f, 0xfd]),
        ("gzip;q=0, zstd;q=0", "", b"qu"),
    ] {
        let answer = get(client, &path, &[("accept-encoding", accepted)]).await;
        assert_eq!(header(&answer, "content-encoding"), encoding);
        assert!(header(&answer, "vary").to_ascii_lowercase().contains("accept-encoding"));
        if !encoding.is_empty() {
            // Other bytes than those of the file: no strong tag, no ranges, no length that is not theirs.
            assert_eq!(header(&answer, "etag"), format!("W/{etag}"));
            assert_eq!(
                (header(&answer, "accept-ranges"), header(&answer, "content-length")),
                <(String, String)>::default()
            );
        }
        let bytes = answer.bytes().await.unwrap();
        assert!(bytes.starts_with(magic), "{accepted}");
        assert!(encoding.is_empty() || bytes.len() * 10 < length, "{accepted}: {} of {length}", bytes.len());
    }
    let list = get(client, "/openapi.json", &[("accept-encoding", "gzip")]).await;
    assert_eq!(header(&list, "content-encoding"), "gzip");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn ranges_tags_pictures_and_events_are_left_alone() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = long_job(client).await;
    let path = format!("{}?format=obj", job["urls"]["quad_mesh"].as_str().unwrap());
    let packed = ("accept-encoding", "gzip, zstd");
    let whole = get(client, &path, &[]).await;
    let etag = header(&whole, "etag");
    let whole = whole.bytes().await.unwrap();
    let part = get(client, &path, &[packed, ("range", "bytes=100-4999")]).await;
    assert_eq!((part.status(), header(&part, "content-encoding")), (StatusCode::PARTIAL_CONTENT, String::new()));
    assert_eq!(header(&part, "etag"), etag);
    assert_eq!(part.bytes().await.unwrap(), whole.slice(100..5000));
    // The rest of a compressed copy cannot be had by ranges of the file.
    let weak = format!("W/{etag}");
    let resumed = get(client, &path, &[packed, ("range", "bytes=100-"), ("if-range", &weak)]).await;
    assert_eq!(resumed.status(), StatusCode::OK);
    for tag in [&etag, &weak] {
        let known = get(client, &path, &[packed, ("if-none-match", tag)]).await;
        assert_eq!((known.status(), &header(&known, "etag")), (StatusCode::NOT_MODIFIED, tag));
    }
    for url in ["preview", "archive", "events"] {
        let answer = get(client, job["urls"][url].as_str().unwrap(), &[packed]).await;
        assert_eq!((answer.status(), header(&answer, "content-encoding")), (StatusCode::OK, String::new()), "{url}");
    }
    let glb = format!("{}?format=glb", job["urls"]["quad_mesh"].as_str().unwrap());
    assert_eq!(header(&get(client, &glb, &[packed]).await, "content-encoding"), "");
    // Whoever takes nothing at all is answered all the same.
    let nothing = get(client, "/healthz", &[("accept-encoding", "identity;q=0, *;q=0")]).await;
    assert_eq!(nothing.status(), StatusCode::OK);
    server.stop().await;
}
