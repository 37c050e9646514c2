//! A client that knows the contract and nothing else.

use std::time::{Duration, Instant};

use reqwest::multipart::{Form, Part};
use reqwest::{Method, RequestBuilder, Response, StatusCode};
use serde_json::Value;

/// Longest time that any test waits for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) struct Client {
    base: String,
    http: reqwest::Client,
}

/// One event of a stream.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    pub(crate) id: u64,
    pub(crate) kind: String,
    pub(crate) data: Value,
}

impl Client {
    pub(crate) fn new(base: String) -> Self {
        let http = reqwest::Client::builder().timeout(PATIENCE).build().expect("a client");
        Self { base, http }
    }

    pub(crate) fn base(&self) -> &str {
        &self.base
    }

    pub(crate) fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.http.request(method, format!("{}{path}", self.base))
    }

    pub(crate) async fn get(&self, path: &str) -> Response {
        self.request(Method::GET, path).send().await.expect("an answer")
    }

    pub(crate) async fn post(&self, path: &str) -> Response {
        self.request(Method::POST, path).send().await.expect("an answer")
    }

    pub(crate) async fn delete(&self, path: &str) -> Response {
        self.request(Method::DELETE, path).send().await.expect("an answer")
    }

    pub(crate) fn submission(&self, name: &str, mesh: &[u8], spec: &Value) -> RequestBuilder {
        let form = Form::new()
            .part("spec", Part::text(spec.to_string()))
            .part("mesh", Part::bytes(mesh.to_vec()).file_name(name.to_owned()));
        self.request(Method::POST, "/v1/jobs").multipart(form)
    }

    /// Submits a mesh that must be accepted; the job object.
    pub(crate) async fn submit(&self, name: &str, mesh: &[u8], spec: &Value) -> Value {
        let response = self.submission(name, mesh, spec).send().await.expect("an answer");
        let location = response.headers().get("location").cloned();
        let (status, job) = json(response).await;
        assert_eq!(status, StatusCode::ACCEPTED, "{job}");
        assert_eq!(location.expect("Location").to_str().ok(), job["urls"]["self"].as_str());
        job
    }

    /// The job once `wanted` holds.
    pub(crate) async fn until(&self, job: &Value, wanted: impl Fn(&Value) -> bool) -> Value {
        let path = job["urls"]["self"].as_str().expect("a job");
        let begun = Instant::now();
        loop {
            let (status, job) = json(self.get(path).await).await;
            assert_eq!(status, StatusCode::OK, "{job}");
            if wanted(&job) {
                return job;
            }
            assert!(begun.elapsed() < PATIENCE, "still waiting: {job}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    pub(crate) async fn finished(&self, job: &Value) -> Value {
        self.until(job, |job| !matches!(job["status"].as_str(), Some("queued" | "running"))).await
    }

    pub(crate) async fn running(&self, job: &Value) -> Value {
        self.until(job, |job| job["status"] == "running").await
    }

    /// All events after `last`, to the end of the stream.
    pub(crate) async fn events(&self, job: &Value, last: Option<u64>) -> Vec<Event> {
        let mut request = self.request(Method::GET, job["urls"]["events"].as_str().expect("a job"));
        if let Some(last) = last {
            request = request.header("Last-Event-ID", last.to_string());
        }
        let response = request.send().await.expect("an answer");
        if response.status() == StatusCode::NO_CONTENT {
            return Vec::new();
        }
        assert_eq!(response.headers()["content-type"], "text/event-stream");
        parse_events(&response.text().await.expect("events to the end"))
    }
}

/// Status and JSON body. Everything that is not a success must be a problem.
pub(crate) async fn json(response: Response) -> (StatusCode, Value) {
    let status = response.status();
    let media_type = response.headers().get("content-type").cloned();
    let text = response.text().await.expect("a body");
    let body: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    if !status.is_success() {
        assert_eq!(media_type.expect("a media type"), "application/problem+json", "{text}");
        assert_eq!(body["status"], status.as_u16());
        for member in ["type", "title", "detail"] {
            assert!(body[member].as_str().is_some_and(|text| !text.is_empty()), "{member}: {text}");
        }
    }
    (status, body)
}

/// Asserts that an answer is the problem `slug`, and returns it.
pub(crate) async fn problem(response: Response, status: u16, slug: &str) -> Value {
    let (actual, body) = json(response).await;
    assert_eq!(
        (actual.as_u16(), body["type"].as_str()),
        (status, Some(&*format!("urn:quadrille:problem:{slug}"))),
        "{body}"
    );
    body
}

fn parse_events(text: &str) -> Vec<Event> {
    let mut events = Vec::new();
    for block in text.split("\n\n") {
        let field = |name: &str| block.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
        if let (Some(id), Some(kind), Some(data)) = (field("id:"), field("event:"), field("data:")) {
            events.push(Event {
                id: id.parse().expect("a number"),
                kind: kind.to_owned(),
                data: serde_json::from_str(data).expect("JSON"),
            });
        }
    }
    events
}
