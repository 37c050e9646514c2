//! Many jobs at once: filters of lists, cancelling and deleting by the same filters.

use reqwest::StatusCode;
use serde_json::{Value, json as value};

use crate::client::{Client, json, problem};
use crate::server::scripted;

const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

async fn submit(client: &Client, tags: &[&str]) -> Value {
    client.submit("a.obj", MESH, &value!({"tags": tags})).await
}

async fn listed(client: &Client, query: &str) -> Vec<String> {
    let (status, list) = json(client.get(&format!("/v1/jobs?{query}")).await).await;
    assert_eq!(status, StatusCode::OK, "{query}: {list}");
    list["jobs"].as_array().unwrap().iter().map(id).collect()
}

fn id(job: &Value) -> String {
    job["id"].as_str().unwrap().to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn several_values_of_a_filter_are_joined_by_commas_or_repeated() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let done = submit(client, &["red", "round"]).await;
    client.finished(&done).await;
    let failed = submit(client, &["fail", "green"]).await;
    client.finished(&failed).await;
    let plain = submit(client, &[]).await;
    client.finished(&plain).await;
    let (done, failed, plain) = (id(&done), id(&failed), id(&plain));
    let both = [failed.clone(), done.clone()];
    for query in ["tag=red,green", "tag=red&tag=green", "tag=round,green,none", "tag=red%2Cgreen"] {
        assert_eq!(listed(client, query).await, both, "{query}");
    }
    assert_eq!(listed(client, "status=failed,cancelled").await, std::slice::from_ref(&failed));
    assert_eq!(listed(client, "status=failed&status=succeeded").await, [plain.clone(), failed.clone(), done.clone()]);
    assert_eq!(listed(client, "status=succeeded&tag=red,green").await, [done]);
    assert_eq!(listed(client, "method=quadcover&status=failed").await, [failed]);
    for query in ["status=failed,lost", "method=magic", "created_after=yesterday", "created_after=1", "limit=1&limit=2"]
    {
        problem(client.get(&format!("/v1/jobs?{query}")).await, 400, "invalid-request").await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn windows_of_time_share_no_job_and_miss_none() {
    let (_folder, server) = scripted().await;
    let client = &server.client;
    let mut jobs = Vec::new();
    for _ in 0..3 {
        jobs.push(client.finished(&submit(client, &[]).await).await);
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    let middle = jobs[1]["created_at"].as_str().unwrap();
    assert_eq!(listed(client, &format!("created_after={middle}")).await, [id(&jobs[2]), id(&jobs[1])]);
    assert_eq!(listed(client, &format!("created_before={middle}")).await, [id(&jobs[0])]);
    // The same time as clocks of another zone show it, with a plus sign that is not escaped.
    let elsewhere = middle.replace('Z', "+00:00");
    assert_eq!(listed(client, &format!("created_before={elsewhere}")).await, [id(&jobs[0])]);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_cancelled_and_deleted_by_the_filters_of_lists() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    let running = submit(client, &["slow", "batch"]).await;
    client.running(&running).await;
    let mut waiting = Vec::new();
    for _ in 0..120 {
        waiting.push(submit(client, &["batch"]).await);
    }
    let other = submit(client, &["other"]).await;

    for query in ["", "?", "?tag=", "?status=,"] {
        problem(client.post(&format!("/v1/jobs/cancel{query}")).await, 400, "invalid-request").await;
        problem(client.delete(&format!("/v1/jobs{query}")).await, 400, "invalid-request").await;
    }
    problem(client.delete("/v1/jobs?tag=batch&limit=1").await, 400, "invalid-request").await;

    let (status, counted) = json(client.post("/v1/jobs/cancel?tag=batch").await).await;
    assert_eq!((status, counted["jobs"].as_u64()), (StatusCode::OK, Some(121)));
    assert_eq!(client.finished(&running).await["status"], "cancelled");
    assert_eq!(client.finished(&waiting[7]).await["status"], "cancelled");
    assert_eq!(client.events(&waiting[7], None).await.last().unwrap().kind, "cancelled");
    assert_eq!(client.finished(&other).await["status"], "succeeded");
    assert_eq!(json(client.post("/v1/jobs/cancel?tag=batch,other").await).await.1["jobs"], 0);

    assert_eq!(json(client.delete("/v1/jobs?tag=batch&status=succeeded").await).await.1["jobs"], 0);
    assert_eq!(json(client.delete("/v1/jobs?tag=batch").await).await.1["jobs"], 121);
    assert_eq!(listed(client, "limit=200").await, [id(&other)]);
    assert_eq!(json(client.delete("/v1/jobs?status=succeeded").await).await.1["jobs"], 1);
    let left = std::fs::read_dir(folder.path().join("objects/assets")).map_or(0, Iterator::count);
    assert_eq!(left, 0, "the mesh goes with its last job");
    server.stop().await;
}
