//! Routes beside the jobs, and what every answer has.

use reqwest::{Method, StatusCode};
use serde_json::json as value;

use crate::client::{json, problem};
use crate::server::scripted;

#[tokio::test(flavor = "multi_thread")]
async fn unknown_routes_ids_and_methods_are_problems() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    problem(client.get("/v2/jobs").await, 404, "not-found").await;
    problem(client.get("/v1/jobs/7").await, 404, "not-found").await;
    for id in ["%ff", "%00", "a%2Fb", "%C3%28", "..%2f", "%F0%9F%A6%86"] {
        for path in ["", "/events", "/quad-mesh", "/parameterisation", "/report", "/preview.png"] {
            problem(client.get(&format!("/v1/jobs/{id}{path}")).await, 404, "not-found").await;
        }
        problem(client.get(&format!("/v1/assets/{id}")).await, 404, "not-found").await;
        problem(client.post(&format!("/v1/jobs/{id}/cancel")).await, 404, "not-found").await;
        for path in ["jobs", "assets"] {
            problem(client.delete(&format!("/v1/{path}/{id}")).await, 404, "not-found").await;
        }
    }
    let unknown = "/v1/jobs/01890000-0000-7000-8000-000000000000";
    for path in ["", "/events", "/quad-mesh", "/parameterisation", "/report", "/preview.png"] {
        problem(client.get(&format!("{unknown}{path}")).await, 404, "not-found").await;
    }
    problem(client.post(&format!("{unknown}/cancel")).await, 404, "not-found").await;
    let refused = client.request(Method::PUT, "/v1/jobs").send().await.unwrap();
    let allowed = refused.headers()["allow"].to_str().unwrap().to_owned();
    assert!(allowed.contains("GET") && allowed.contains("POST"), "{allowed}");
    problem(refused, 405, "method-not-allowed").await;
    let response = client.get("/nowhere").await;
    let id = response.headers()["x-request-id"].to_str().unwrap().to_owned();
    let (_, body) = json(response).await;
    assert_eq!(body["instance"], format!("urn:request:{id}"));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_service_describes_itself() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    assert_eq!(json(client.get("/healthz").await).await.1["status"], "ok");
    assert_eq!(json(client.get("/readyz").await).await.1["status"], "ok");
    let (_, methods) = json(client.get("/v1/methods").await).await;
    let method = &methods["methods"][0];
    assert_eq!(method["name"], "quadcover");
    assert_eq!(method["defaults"]["target"]["quads"], 5000);
    assert!(method["parameters"]["properties"]["target"].is_object());
    assert!(!method["cannot"].as_array().unwrap().is_empty());

    let job = client.submit("a.obj", b"v 0 0 0\n", &value!({})).await;
    client.finished(&job).await;
    let metrics = client.get("/metrics").await;
    assert!(metrics.headers()["content-type"].to_str().unwrap().starts_with("text/plain"));
    let metrics = metrics.text().await.unwrap();
    for line in [
        "quadrille_jobs{status=\"succeeded\"} ",
        "quadrille_http_requests_total{route=\"/v1/jobs\"",
        "quadrille_jobs_finished_total",
    ] {
        assert!(metrics.contains(line), "{line} is missing in:\n{metrics}");
    }

    let (status, document) = json(client.get("/openapi.json").await).await;
    assert_eq!(status, StatusCode::OK);
    for path in ["/v1/jobs", "/v1/jobs/{id}/events", "/v1/assets/{id}", "/v1/methods", "/readyz"] {
        assert!(document["paths"][path].is_object(), "{path}");
    }
    for page in ["/", "/docs"] {
        let response = client.get(page).await;
        assert!(response.headers()["content-type"].to_str().unwrap().starts_with("text/html"));
        let html = response.text().await.unwrap();
        assert!(!html.contains("https://") && !html.contains("http://"), "{page} loads something from elsewhere");
    }
    server.stop().await;
}
