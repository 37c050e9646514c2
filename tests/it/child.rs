//! A scripted server in a process of its own, which can be killed: this test binary, started again.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::client::Client;
use crate::server::{Server, config};

const FOLDER: &str = "QUADRILLE_TEST_CHILD_FOLDER";
const READY: &str = "child listens on ";

pub(crate) struct ChildServer {
    process: Child,
    pub(crate) client: Client,
}

impl ChildServer {
    pub(crate) fn start(folder: &Path) -> Self {
        let mut process = Command::new(std::env::current_exe().expect("this binary"))
            .args(["--exact", "child::a_scripted_server_when_started_as_a_child", "--nocapture", "--test-threads=1"])
            .env(FOLDER, folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a child");
        let mut lines = BufReader::new(process.stdout.take().expect("a pipe")).lines();
        let line = lines.find_map(|line| Some(line.ok()?.split_once(READY)?.1.to_owned()));
        let base = line.expect("the child says where it listens");
        Self { process, client: Client::new(base) }
    }

    /// SIGKILL.
    pub(crate) fn kill(mut self) {
        self.process.kill().expect("the child can be killed");
        self.process.wait().expect("the child is gone");
    }

    /// Waits until the child ends on its own.
    pub(crate) fn crashed(mut self) {
        let status = self.process.wait().expect("the child is gone");
        assert!(!status.success());
    }
}

/// No test of its own: it does something only in a child.
#[tokio::test(flavor = "multi_thread")]
async fn a_scripted_server_when_started_as_a_child() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let server = Server::scripted(config(Path::new(&folder))).await;
    println!("{READY}{}", server.client.base());
    std::future::pending::<()>().await;
}
