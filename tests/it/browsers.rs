//! What browsers may do for pages of other origins, told by the headers that browsers send.

use reqwest::{Method, RequestBuilder, Response};
use serde_json::{Value, json as value};
use tempfile::TempDir;

use crate::client::{Client, problem};
use crate::server::{Server, config, scripted};

const FRIEND: &str = "https://models.example.org";
const STRANGER: &str = "https://evil.example";
const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A server that knows a friend.
async fn friendly() -> (TempDir, Server) {
    let folder = tempfile::tempdir().unwrap();
    let mut config = config(folder.path());
    config.http.allowed_origins = vec![FRIEND.to_owned()];
    let server = Server::scripted(config).await;
    (folder, server)
}

/// As a browser sends it for a page of `origin`.
fn from_page(request: RequestBuilder, origin: &str) -> RequestBuilder {
    request.header("Origin", origin).header("Sec-Fetch-Site", "cross-site").header("Sec-Fetch-Mode", "cors")
}

fn submission(client: &Client) -> RequestBuilder {
    client.submission("a.obj", MESH, &value!({}))
}

async fn preflight(client: &Client, path: &str, method: &str, origin: &str) -> Response {
    let request = client.request(Method::OPTIONS, path).header("Access-Control-Request-Method", method);
    from_page(request, origin).header("Access-Control-Request-Headers", "idempotency-key,prefer").send().await.unwrap()
}

fn header(response: &Response, name: &str) -> String {
    response.headers().get(name).map(|value| value.to_str().unwrap().to_ascii_lowercase()).unwrap_or_default()
}

async fn job_count(client: &Client) -> usize {
    let list: Value = client.get("/v1/jobs").await.json().await.unwrap();
    list["jobs"].as_array().unwrap().len()
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_of_other_origins_change_nothing() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let job = client.submit("a.obj", MESH, &value!({})).await;
    let path = job["urls"]["self"].as_str().unwrap();
    for origin in [STRANGER, FRIEND, "null", "http://localhost.evil.example"] {
        let posted = from_page(submission(client), origin).send().await.unwrap();
        assert_eq!(header(&posted, "access-control-allow-origin"), "");
        problem(posted, 403, "foreign-origin").await;
        let deleted = from_page(client.request(Method::DELETE, path), origin).send().await.unwrap();
        problem(deleted, 403, "foreign-origin").await;
        let asked = preflight(client, "/v1/jobs", "POST", origin).await;
        assert_eq!(header(&asked, "access-control-allow-origin"), "");
    }
    // Browsers that do not say what kind of site the page is of.
    let posted = submission(client).header("Origin", STRANGER).send().await.unwrap();
    problem(posted, 403, "foreign-origin").await;
    assert_eq!(job_count(client).await, 1);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_of_the_server_itself_and_programs_may_do_everything() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let own = submission(client).header("Origin", client.base()).header("Sec-Fetch-Site", "same-origin");
    assert_eq!(own.send().await.unwrap().status(), 202);
    let old = submission(client).header("Origin", client.base());
    assert_eq!(old.send().await.unwrap().status(), 202);
    assert_eq!(submission(client).send().await.unwrap().status(), 202);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_of_an_allowed_origin_work_from_the_preflight_to_the_download() {
    let (_folder, server) = friendly().await;
    let client = &server.client;
    for method in ["POST", "GET", "DELETE"] {
        let asked = preflight(client, "/v1/jobs", method, FRIEND).await;
        assert!(asked.status().is_success());
        assert_eq!(header(&asked, "access-control-allow-origin"), FRIEND);
        assert!(header(&asked, "access-control-allow-methods").contains(&method.to_ascii_lowercase()));
        assert!(header(&asked, "access-control-allow-headers").contains("idempotency-key"));
    }
    let posted = from_page(submission(client), FRIEND).send().await.unwrap();
    assert_eq!((posted.status().as_u16(), header(&posted, "access-control-allow-origin")), (202, FRIEND.to_owned()));
    for exposed in ["location", "etag", "content-disposition", "retry-after"] {
        assert!(header(&posted, "access-control-expose-headers").contains(exposed), "{exposed}");
    }
    let job: Value = posted.json().await.unwrap();
    client.finished(&job).await;
    for url in ["self", "events", "quad_mesh", "report", "preview"] {
        let path = job["urls"][url].as_str().unwrap();
        let got = from_page(client.request(Method::GET, path), FRIEND).send().await.unwrap();
        assert_eq!(
            (got.status().as_u16(), header(&got, "access-control-allow-origin")),
            (200, FRIEND.to_owned()),
            "{url}"
        );
        assert!(got.headers().get_all("vary").iter().any(|vary| vary.to_str().unwrap().contains("origin")), "{url}");
    }
    // Pages can read why they were refused, too.
    let missing = from_page(client.request(Method::GET, "/v1/jobs/7"), FRIEND).send().await.unwrap();
    assert_eq!(header(&missing, "access-control-allow-origin"), FRIEND);
    problem(missing, 404, "not-found").await;
    let stranger = from_page(submission(client), STRANGER).send().await.unwrap();
    problem(stranger, 403, "foreign-origin").await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn names_that_are_not_ours_get_no_answer() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    for host in ["evil.example", "evil.example:8620", "127.0.0.1.evil.example"] {
        for path in ["/v1/jobs", "/", "/nowhere"] {
            let answer = client.request(Method::GET, path).header("Host", host).send().await.unwrap();
            problem(answer, 421, "foreign-host").await;
        }
    }
    for host in ["localhost", "127.0.0.1:1", "[::1]:8620", "LocalHost:80"] {
        let answer = client.request(Method::GET, "/v1/jobs").header("Host", host).send().await.unwrap();
        assert_eq!(answer.status(), 200, "{host}");
    }
    server.stop().await;

    let folder = tempfile::tempdir().unwrap();
    let mut named = config(folder.path());
    named.http.allowed_hosts = vec!["models.example.org".to_owned()];
    let server = Server::scripted(named).await;
    let get = |host: &'static str| server.client.request(Method::GET, "/healthz").header("Host", host).send();
    assert_eq!(get("models.example.org:8620").await.unwrap().status(), 200);
    assert_eq!(get("localhost").await.unwrap().status(), 200);
    assert_eq!(get("evil.example").await.unwrap().status(), 421);
    server.stop().await;
}
