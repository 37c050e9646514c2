//! Disks that are full, blobs that are lost, files that are taken away.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json as value};

use crate::client::{Client, PATIENCE, json, problem};
use crate::server::{Server, config, scripted};

const MESH: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const OTHER: &[u8] = b"v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n";
/// Longest time until work goes on when the storage works again.
const RECOVERY: Duration = Duration::from_secs(5);

/// A small file system, where the machine lets us make one.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=6m", "none"]).arg(folder.path()).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(Self(folder))
    }

    /// Writes until nothing more fits.
    fn fill(&self) -> PathBuf {
        let path = self.0.path().join("full");
        let mut file = std::fs::File::create(&path).unwrap();
        for block in [1 << 16, 1 << 12, 1] {
            while file.write_all(&vec![0; block]).is_ok() {}
        }
        path
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // Lazily: a test that failed may still have files open.
        let _ = Command::new("umount").arg("-l").arg(self.0.path()).output();
    }
}

async fn submitted(client: &Client, mesh: &[u8], tag: &str) -> Result<Value, Value> {
    let (status, body) = json(client.submission("a.obj", mesh, &value!({"tags": [tag]})).send().await.unwrap()).await;
    if status == StatusCode::ACCEPTED { Ok(body) } else { Err(body) }
}

#[tokio::test(flavor = "multi_thread")]
async fn work_goes_on_soon_after_a_full_disk_has_space_again() {
    let Some(disk) = SmallDisk::mount() else {
        eprintln!("skipped: no file system can be mounted here");
        return;
    };
    let server = Server::scripted(config(&disk.0.path().join("data"))).await;
    let client = &server.client;
    client.finished(&client.submit("a.obj", MESH, &value!({})).await).await;
    // One job comes to its end while the disk is full, two wait.
    let mut jobs = vec![client.submit("a.obj", MESH, &value!({"tags": ["deaf"]})).await];
    client.running(&jobs[0]).await;
    for n in 0..2 {
        jobs.push(client.submit("a.obj", OTHER, &value!({"seed": n})).await);
    }
    let ballast = disk.fill();
    let full = Instant::now();
    let mut refused = 0;
    while full.elapsed() < Duration::from_secs(8) {
        match submitted(client, MESH, "late").await {
            Ok(job) => jobs.push(job),
            Err(body) => {
                assert_eq!(body["type"], "urn:quadrille:problem:storage-unavailable", "{body}");
                refused += 1;
            }
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert!(refused > 0, "the disk was full");

    std::fs::remove_file(ballast).unwrap();
    let space = Instant::now();
    let job = loop {
        match submitted(client, MESH, "after").await {
            Ok(job) => break job,
            Err(_) => assert!(space.elapsed() < RECOVERY, "still refused"),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    let accepted = space.elapsed();
    jobs.push(job);
    for job in &jobs {
        let done = client.finished(job).await;
        assert_eq!((&done["status"], &done["problem"]), (&value!("succeeded"), &Value::Null), "{done}");
    }
    eprintln!("accepted after {accepted:?}, all done after {:?}", space.elapsed());
    assert!(space.elapsed() < RECOVERY, "{:?}", space.elapsed());
    assert_eq!(client.get("/readyz").await.status(), StatusCode::OK);
    server.stop().await;
}

/// The blob of the only asset of these bytes.
fn blob_of(data: &Path, mesh: &[u8]) -> PathBuf {
    let entries = std::fs::read_dir(data.join("objects/assets")).unwrap().flatten().map(|entry| entry.path());
    let mut same = entries.filter(|path| std::fs::read(path).is_ok_and(|bytes| bytes == mesh));
    let blob = same.next().expect("a blob");
    assert!(same.next().is_none(), "stored once");
    blob
}

/// A job of `MESH` that will find its blob as `harm` left it.
async fn harmed(server: &Server, data: &Path, harm: impl FnOnce(&Path)) -> Value {
    let client = &server.client;
    let slow = client.submit("b.obj", OTHER, &value!({"tags": ["slow"]})).await;
    client.running(&slow).await;
    let job = client.submit("a.obj", MESH, &value!({})).await;
    harm(&blob_of(data, MESH));
    json(client.post(slow["urls"]["cancel"].as_str().unwrap()).await).await;
    job
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_waits_for_its_lost_mesh_and_a_new_upload_brings_it_back() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    let lost = harmed(&server, folder.path(), |blob| std::fs::remove_file(blob).unwrap()).await;
    let waiting = client.until(&lost, |job| job["attempt"] == 2).await;
    assert!(matches!(waiting["status"].as_str(), Some("queued" | "running")), "{waiting}");
    // It is in nobody's way.
    let fine = client.submit("b.obj", OTHER, &value!({"seed": 1})).await;
    assert_eq!(client.finished(&fine).await["status"], "succeeded");

    let form = Form::new().part("mesh", Part::bytes(MESH).file_name("a.obj"));
    let (status, _) =
        json(client.request(reqwest::Method::POST, "/v1/assets").multipart(form).send().await.unwrap()).await;
    assert_eq!(status, StatusCode::OK, "these bytes are known");
    assert_eq!(client.finished(&lost).await["status"], "succeeded");
    blob_of(folder.path(), MESH);

    // The same with a blob that was cut short, brought back by another job.
    let short = harmed(&server, folder.path(), |blob| std::fs::write(blob, b"v 0").unwrap()).await;
    client.until(&short, |job| job["attempt"] == 2).await;
    let again = client.submit("a.obj", MESH, &value!({"seed": 1})).await;
    for job in [&again, &short] {
        assert_eq!(client.finished(job).await["status"], "succeeded");
    }
    blob_of(folder.path(), MESH);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_that_stays_lost_is_a_problem_of_the_storage() {
    let folder = tempfile::tempdir().unwrap();
    let mut impatient = config(folder.path());
    impatient.jobs.storage_patience = Duration::from_secs(4);
    let server = Server::scripted(impatient).await;
    let lost = harmed(&server, folder.path(), |blob| std::fs::remove_file(blob).unwrap()).await;
    let begun = Instant::now();
    let done = server.client.finished(&lost).await;
    assert_eq!(done["problem"]["type"], "urn:quadrille:problem:storage-unavailable", "{done}");
    assert!((2..=6).contains(&done["attempt"].as_u64().unwrap()), "it did not spin: {done}");
    assert!(begun.elapsed() > Duration::from_secs(2) && begun.elapsed() < Duration::from_secs(20));
    server.stop().await;
}

/// Asks until the answer is `wanted`; answers hold for a second.
async fn ready(client: &Client, wanted: StatusCode) {
    let begun = Instant::now();
    loop {
        let (status, body) = json(client.get("/readyz").await).await;
        if status == wanted {
            return;
        }
        assert!(begun.elapsed() < PATIENCE, "{body}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_cannot_store_is_not_ready_and_accepts_nothing() {
    let (folder, server) = scripted().await;
    let client = &server.client;
    for part in ["uploads", "jobs.sqlite"] {
        ready(client, StatusCode::OK).await;
        let (here, away) = (folder.path().join(part), folder.path().join("away"));
        std::fs::rename(&here, &away).unwrap();
        ready(client, StatusCode::SERVICE_UNAVAILABLE).await;
        let refused = client.submission("a.obj", MESH, &value!({})).send().await.unwrap();
        problem(refused, 503, "storage-unavailable").await;
        std::fs::rename(&away, &here).unwrap();
        ready(client, StatusCode::OK).await;
        client.finished(&client.submit("a.obj", MESH, &value!({})).await).await;
    }
    server.stop().await;
}
