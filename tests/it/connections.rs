//! Clients that are slow, silent or many, and the end of the process.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use serde_json::json as value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};

use crate::program::Program;
use crate::server::{Server, config, scripted};

/// Well above the limits that these tests set, well below the defaults.
const SOON: Duration = Duration::from_secs(10);
const HALF_A_HEAD: &[u8] = b"GET /healthz HTTP/1.1\r\nHost: a\r\nX-Slow: ";
const HALF_A_BODY: &[u8] =
    b"POST /v1/assets HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=x\r\n\
    Content-Length: 9999\r\n\r\n--x\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"a.obj\"\r\n\r\nv 0 0";
/// More than the buffers between two sockets hold.
const LARGE: usize = 24 << 20;

async fn impatient() -> (tempfile::TempDir, Server) {
    let folder = tempfile::tempdir().unwrap();
    let mut impatient = config(folder.path());
    impatient.limits.headers = Duration::from_secs(2);
    impatient.limits.stalled = Duration::from_secs(2);
    let server = Server::scripted(impatient).await;
    (folder, server)
}

fn address(base: &str) -> SocketAddr {
    base.trim_start_matches("http://").parse().unwrap()
}

async fn connected(base: &str, bytes: &[u8]) -> TcpStream {
    let mut stream = TcpStream::connect(address(base)).await.unwrap();
    stream.write_all(bytes).await.unwrap();
    stream
}

/// What the server says before it closes the connection, and how long that took.
async fn last_words(stream: &mut TcpStream) -> (String, Duration) {
    let (begun, mut answer) = (Instant::now(), Vec::new());
    // A reset is an end, too.
    let _ = tokio::time::timeout(Duration::from_secs(60), stream.read_to_end(&mut answer)).await.expect("it closes");
    (String::from_utf8_lossy(&answer).into_owned(), begun.elapsed())
}

#[tokio::test(flavor = "multi_thread")]
async fn heads_and_bodies_that_do_not_come_are_not_waited_for() {
    let (_folder, server) = impatient().await;
    let base = server.client.base();
    for head in [HALF_A_HEAD, b""] {
        let mut silent = connected(base, head).await;
        let (_, took) = last_words(&mut silent).await;
        assert!(took > Duration::from_secs(1) && took < SOON, "{took:?}");
    }
    let mut stalled = connected(base, HALF_A_BODY).await;
    let (answer, took) = last_words(&mut stalled).await;
    assert!(answer.starts_with("HTTP/1.1 408 ") && answer.contains("problem:request-timeout"), "{answer}");
    assert!(took > Duration::from_secs(1) && took < SOON, "{took:?}");
    // One byte after the other is slow and no more than that.
    let mut slow = connected(base, b"GET /healthz HTTP/1.1\r\nConnection: close\r\nHost: localhost").await;
    for byte in b"\r\n\r\n" {
        tokio::time::sleep(Duration::from_millis(100)).await;
        slow.write_all(&[*byte]).await.unwrap();
    }
    assert!(last_words(&mut slow).await.0.starts_with("HTTP/1.1 200 "));
    server.stop().await;
}

/// A job with large files; the request for one of them.
async fn large_download(server: &Server) -> String {
    let client = &server.client;
    let job = client.submit("a.obj", &vec![b'v'; LARGE], &value!({})).await;
    let done = client.finished(&job).await;
    assert_eq!(done["status"], "succeeded");
    format!("GET {}?format=obj HTTP/1.1\r\nHost: localhost\r\n\r\n", done["urls"]["quad_mesh"].as_str().unwrap())
}

/// A client that asks for little at a time.
async fn reader(base: &str, request: &str) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(1 << 14).unwrap();
    let mut stream = socket.connect(address(base)).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut begin = [0; 64];
    stream.read_exact(&mut begin).await.unwrap();
    assert!(begin.starts_with(b"HTTP/1.1 200 "));
    stream
}

#[tokio::test(flavor = "multi_thread")]
async fn a_reader_that_does_not_read_loses_its_connection() {
    let (_folder, server) = impatient().await;
    let request = large_download(&server).await;
    let mut reader = reader(server.client.base(), &request).await;
    tokio::time::sleep(Duration::from_secs(6)).await;
    let (rest, _) = last_words(&mut reader).await;
    assert!(rest.len() < LARGE, "{} bytes came", rest.len());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn more_connections_than_allowed_wait_for_their_turn() {
    let folder = tempfile::tempdir().unwrap();
    let mut few = config(folder.path());
    few.limits.connections = 2;
    few.limits.headers = Duration::from_secs(3);
    let server = Server::scripted(few).await;
    let base = server.client.base();
    let _silent = [connected(base, HALF_A_HEAD).await, connected(base, HALF_A_HEAD).await];
    tokio::time::sleep(Duration::from_millis(300)).await;
    let begun = Instant::now();
    assert_eq!(server.client.get("/healthz").await.status(), StatusCode::OK);
    let took = begun.elapsed();
    assert!(took > Duration::from_secs(1) && took < Duration::from_secs(20), "{took:?}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn half_sent_requests_do_not_delay_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let program = Program::serve(folder.path());
    let base = program.client.base().to_owned();
    let mut open = Vec::new();
    for n in 0..200 {
        open.push(connected(&base, [HALF_A_HEAD, HALF_A_BODY, b""][n % 3]).await);
    }
    // Kept alive, with nothing to say.
    assert_eq!(program.client.get("/healthz").await.status(), StatusCode::OK);
    tokio::time::sleep(Duration::from_millis(500)).await;
    let begun = Instant::now();
    tokio::task::spawn_blocking(move || program.end()).await.unwrap();
    let took = begun.elapsed();
    eprintln!("ended in {took:?}");
    assert!(took < Duration::from_secs(2), "{took:?}");
    let (answer, _) = last_words(&mut open[1]).await;
    assert!(answer.starts_with("HTTP/1.1 503 ") && answer.contains("problem:shutting-down"), "{answer}");
}

#[tokio::test(flavor = "multi_thread")]
async fn downloads_come_to_their_end_when_the_process_does() {
    let (_folder, server) = scripted().await;
    let request = large_download(&server).await;
    let mut reader = reader(server.client.base(), &request).await;
    let end = tokio::spawn(server.stop());
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(!end.is_finished(), "the download is waited for");
    let (rest, _) = last_words(&mut reader).await;
    assert!(rest.len() > LARGE, "{} bytes came", rest.len());
    end.await.unwrap();
}
