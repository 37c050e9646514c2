//! A run is over by its deadline + 1 s + 10 %, and hears clients and the end of the process at all times. The bounds here
//! are those with room for a busy machine.

use std::time::{Duration, Instant};

use quadrille::engine::mesh::TriangleSoup;
use serde_json::{Value, json};

use crate::client::json as answer;
use crate::meshes::{obj, surface};
use crate::server::Server;

/// What a deadline of 5 s allows, 6.5 s, and as much again for other work on the machine.
const BOUND: Duration = Duration::from_secs(13);
/// What a cancellation may take, 1 s, and room.
const HEARD: Duration = Duration::from_secs(4);

/// Every triangle between `n` points on the moment curve: components by the hundred that run through each other.
fn complete(n: u32) -> TriangleSoup {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let positions = (0..n).map(|i| glam::DVec3::new(at(i), at(i).powi(2), at(i).powi(3))).collect();
    let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
    for a in 0..n {
        for b in a + 1..n {
            (b + 1..n).for_each(|c| soup.push_polygon(&[a, b, c]));
        }
    }
    soup
}

/// Spheres in a row, apart from each other.
fn scene(parts: u32, triangles: usize) -> TriangleSoup {
    let part = surface("sphere", triangles);
    let mut soup = TriangleSoup::default();
    for k in 0..parts {
        let start = soup.positions.len() as u32;
        soup.positions.extend(part.positions.iter().map(|&p| p + 3.0 * f64::from(k) * glam::DVec3::X));
        part.polygons().for_each(|p| soup.push_polygon(&p.iter().map(|v| v + start).collect::<Vec<_>>()));
    }
    soup.uv = vec![[0.25; 2]; soup.indices.len()];
    soup
}

fn is_final(job: &Value) -> bool {
    !matches!(job["status"].as_str(), Some("queued" | "running"))
}

#[tokio::test(flavor = "multi_thread")]
async fn runs_are_over_soon_after_their_deadline() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    for (name, mesh) in [("complete.obj", obj(&complete(30))), ("scene.obj", obj(&scene(40, 2000)))] {
        let job = server.client.submit(name, &mesh, &json!({"target": {"quads": 3000}, "deadline_s": 5})).await;
        let begun = Instant::now();
        let job = server.client.until(&job, is_final).await;
        assert!(begun.elapsed() < BOUND, "{name}: {:?}", begun.elapsed());
        match job["status"].as_str() {
            Some("succeeded") => assert_eq!(job["result"]["certified"], true, "{name}"),
            _ => assert_eq!(job["problem"]["type"], "urn:quadrille:problem:deadline-exceeded", "{name}: {job}"),
        }
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelling_and_stopping_act_before_and_after_the_deadline() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let mesh = obj(&complete(30));
    for (deadline, wait) in [(60, 1500), (1, 1200)] {
        let job = server.client.submit("complete.obj", &mesh, &json!({"deadline_s": deadline})).await;
        let running = server.client.until(&job, |job| job["status"] != "queued").await;
        tokio::time::sleep(Duration::from_millis(wait)).await;
        let begun = Instant::now();
        let (status, _) = answer(server.client.post(running["urls"]["cancel"].as_str().unwrap()).await).await;
        assert!(status.is_success());
        server.client.until(&job, is_final).await;
        assert!(begun.elapsed() < HEARD, "{:?}", begun.elapsed());
    }
    let job = server.client.submit("complete.obj", &mesh, &json!({"deadline_s": 60})).await;
    server.client.until(&job, |job| job["status"] != "queued").await;
    let begun = Instant::now();
    server.stop().await;
    assert!(begun.elapsed() < HEARD, "{:?}", begun.elapsed());
}
