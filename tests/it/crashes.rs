//! Processes that die in mid-job.

use serde_json::json as value;

use crate::child::ChildServer;
use crate::client::json;
use crate::server::{Server, config};

const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[tokio::test(flavor = "multi_thread")]
async fn a_job_survives_the_death_of_its_server() {
    let folder = tempfile::tempdir().unwrap();
    let child = ChildServer::start(folder.path());
    let slow = child.client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    let waiting = child.client.submit("a.obj", MESH, &value!({})).await;
    child.client.running(&slow).await;
    child.kill();

    let server = Server::scripted(config(folder.path())).await;
    let client = &server.client;
    assert_eq!(client.finished(&waiting).await["status"], "succeeded");
    let again = client.until(&slow, |job| job["attempt"] == 2).await;
    assert_eq!(again["status"], "running");
    json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!(client.finished(&slow).await["status"], "cancelled");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_kills_its_worker_again_and_again_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let child = ChildServer::start(folder.path());
    let poison = child.client.submit("a.obj", MESH, &value!({"tags": ["abort"]})).await;
    child.crashed();
    for _ in 1..config(folder.path()).jobs.max_attempts {
        ChildServer::start(folder.path()).crashed();
    }
    let server = Server::scripted(config(folder.path())).await;
    let done = server.client.finished(&poison).await;
    assert_eq!(done["status"], "failed");
    assert_eq!(done["problem"]["type"], "urn:quadrille:problem:job-crashed");
    assert!(done["problem"]["detail"].as_str().unwrap().contains("crashed 3 times"), "{done}");
    let fine = server.client.submit("a.obj", MESH, &value!({})).await;
    assert_eq!(server.client.finished(&fine).await["status"], "succeeded");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_processes_on_one_folder_share_the_work_and_hear_of_cancellations() {
    let folder = tempfile::tempdir().unwrap();
    let child = ChildServer::start(folder.path());
    let slow = child.client.submit("a.obj", MESH, &value!({"tags": ["slow"]})).await;
    child.client.running(&slow).await;
    let server = Server::scripted(config(folder.path())).await;
    let quick = child.client.submit("a.obj", MESH, &value!({})).await;
    assert_eq!(child.client.finished(&quick).await["status"], "succeeded", "the other process has a free worker");
    let (_, cancelled) = json(server.client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    assert_eq!(cancelled["status"], "cancelled", "within the second that the answer waits");
    assert_eq!(cancelled["attempt"], 1);
    server.stop().await;
    child.kill();
}
