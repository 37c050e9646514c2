//! The program itself as a child.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::client::Client;

pub(crate) struct Program {
    process: Child,
    pub(crate) client: Client,
}

impl Program {
    /// `quadrille serve` on a folder and a free port.
    pub(crate) fn serve(folder: &Path) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_quadrille"))
            .args(["serve", "--listen", "127.0.0.1:0", "--log", "info", "--log-format", "json", "--data"])
            .arg(folder)
            .env("QUADRILLE_JOBS__HEARTBEAT_MS", "1000")
            .env("QUADRILLE_JOBS__MISSED_HEARTBEATS", "3")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut lines = BufReader::new(process.stderr.take().expect("a pipe")).lines();
        let address = lines.find_map(|line| {
            let line: serde_json::Value = serde_json::from_str(&line.ok()?).ok()?;
            (line["message"] == "listening").then(|| line["address"].as_str().map(str::to_owned))?
        });
        let base = format!("http://{}", address.expect("the program says where it listens"));
        // Whoever stops reading stops the writer.
        std::thread::spawn(move || lines.for_each(drop));
        Self { process, client: Client::new(base) }
    }

    /// Most memory that the process ever had, as Linux tells it.
    pub(crate) fn peak_bytes(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).expect("the process runs");
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("its peak");
        let kib: u64 = peak.trim().trim_end_matches(" kB").parse().expect("a number");
        kib << 10
    }

    /// SIGKILL.
    pub(crate) fn kill(mut self) {
        self.process.kill().expect("the child can be killed");
        self.process.wait().expect("the child is gone");
    }

    /// SIGTERM; the end must be an orderly one.
    pub(crate) fn end(mut self) {
        let id = self.process.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().expect("kill").success());
        assert!(self.process.wait().expect("the child is gone").success());
    }
}
