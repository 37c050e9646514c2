//! What a run tells while it goes on, as a program that reads its lines sees it.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

/// Seconds and line.
fn told(folder: &std::path::Path, mode: &str) -> Vec<(f64, String)> {
    let program = || Command::new(env!("CARGO_BIN_EXE_quadrille"));
    let (input, output) = (folder.join("in.obj"), folder.join(format!("{mode}.obj")));
    if !input.exists() {
        let sample = program().args(["sample", "genus2", "--triangles", "12000", "-o"]).arg(&input).status();
        assert!(sample.expect("the program").success());
    }
    let mut process = program()
        .args(["remesh", "--target-quads", "3000", "--progress", mode, "-o"])
        .args([&output, &input])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    let begun = Instant::now();
    let lines = BufReader::new(process.stderr.take().expect("a pipe")).lines();
    let told = lines.map(|line| (begun.elapsed().as_secs_f64(), line.expect("text"))).collect();
    assert!(process.wait().expect("the program ends").success());
    told
}

#[test]
fn progress_is_told_without_long_silence_or_large_jumps() {
    let folder = tempfile::tempdir().unwrap();
    let lines = told(folder.path(), "json");
    let end = lines[lines.len() - 1].0;
    let json = |line: &String| serde_json::from_str::<Value>(line).ok().filter(|line| line["event"] == "progress");
    let steps: Vec<(f64, Value)> = lines.iter().filter_map(|(at, line)| Some((*at, json(line)?))).collect();
    assert!(steps.len() > 10, "{lines:?}");
    // With room above what was seen on a busy machine: 14 points at once, nothing for 2.7 s.
    let (mut before, mut at_before) = (0.0, 0.0);
    for (at, step) in &steps {
        let progress = step["progress"].as_f64().expect("a number");
        assert!(progress > before && progress <= 1.0, "{progress} after {before}");
        assert!(progress - before < 0.25, "from {before} to {progress} at once");
        assert!(at - at_before < (0.3 * end).max(4.0), "nothing for {} of {end} s", at - at_before);
        assert!(step["stage"].is_string());
        (before, at_before) = (progress, *at);
    }
    assert!(before > 0.99, "the last progress is {before}");
    let half = steps.iter().find(|(_, step)| step["progress"].as_f64() > Some(0.5)).expect("half of it");
    assert!(half.1["seconds_left"].as_u64().expect("seconds") <= 1 + 3 * end as u64);
}

#[test]
fn open_job_description_hears_shares_and_the_time_left() {
    let folder = tempfile::tempdir().unwrap();
    let lines = told(folder.path(), "openjd");
    let progress: Vec<f64> =
        lines.iter().filter_map(|(_, line)| line.strip_prefix("openjd_progress: ")?.parse().ok()).collect();
    assert!(progress.len() > 10 && progress.is_sorted(), "{progress:?}");
    assert!(progress.iter().all(|share| (0.0..=100.0).contains(share)) && progress[progress.len() - 1] > 99.0);
    assert!(lines.iter().any(|(_, line)| line.starts_with("openjd_status: ") && line.contains(" s left")));
}
