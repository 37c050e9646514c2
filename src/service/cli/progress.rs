//! Progress of a run on stderr: a bar for people, lines for programs.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::engine::run::{Observer, Silent, Stage};
use crate::service::time_left::TimeLeft;

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum ProgressMode {
    /// A bar on a terminal, otherwise nothing
    #[default]
    Auto,
    /// A bar
    Bar,
    /// One JSON object per line
    Json,
    /// Lines of Open Job Description
    Openjd,
    /// Nothing
    None,
}

impl ProgressMode {
    /// The observer that shows progress this way.
    pub(super) fn observer(self) -> Box<dyn Observer> {
        match self {
            ProgressMode::Auto if std::io::stderr().is_terminal() => Box::new(Bar::new()),
            ProgressMode::Bar => Box::new(Bar::new()),
            ProgressMode::Json => Box::new(Lines::new(json_line)),
            ProgressMode::Openjd => Box::new(Lines::new(openjd_line)),
            ProgressMode::Auto | ProgressMode::None => Box::new(Silent),
        }
    }

    /// The last line of a failed run, in modes that have one.
    pub(super) fn failed(self, problem: &str) {
        if self == ProgressMode::Openjd {
            eprintln!("openjd_fail: {}", problem.replace('\n', " "));
        }
    }
}

/// How far a run is known to be, and when it began.
struct RunState {
    begun: Instant,
    time_left: TimeLeft,
    stage: Option<Stage>,
    thousandths: u32,
}

impl RunState {
    fn new() -> Self {
        Self { begun: Instant::now(), time_left: TimeLeft::default(), stage: None, thousandths: 0 }
    }

    /// Notes progress; `false` if it is none.
    fn progress(&mut self, thousandths: u32) -> bool {
        // Threads may call in another order than they counted.
        let is_news = thousandths > self.thousandths;
        self.thousandths = self.thousandths.max(thousandths);
        is_news
    }

    fn seconds_left(&mut self) -> Option<u64> {
        self.time_left.seconds(self.begun.elapsed(), f64::from(self.thousandths) / 1000.0)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Bar {
    bar: ProgressBar,
    state: Mutex<RunState>,
}

impl Bar {
    fn new() -> Self {
        let style = ProgressStyle::with_template("{spinner} {msg:<10} {bar:40} {percent:>3} % {elapsed} {prefix}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(1000).with_style(style);
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar, state: Mutex::new(RunState::new()) }
    }
}

impl Observer for Bar {
    fn stage_begins(&self, stage: Stage) {
        self.bar.set_message(stage.name());
    }

    fn stage_ends(&self, _: Stage) {}

    fn progress(&self, thousandths: u32) {
        let mut state = locked(&self.state);
        if state.progress(thousandths) {
            self.bar.set_position(u64::from(state.thousandths));
            let left = state.seconds_left();
            self.bar.set_prefix(left.map(|seconds| format!("about {seconds} s left")).unwrap_or_default());
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What a line of progress says.
enum Event {
    Stage(Stage),
    Progress { thousandths: u32, stage: Option<Stage>, seconds_left: Option<u64> },
}

/// Shortest time between two lines of progress.
const LINE_INTERVAL: Duration = Duration::from_millis(200);

struct Lines {
    write: fn(&Event) -> String,
    last: Mutex<Last>,
}

struct Last {
    state: RunState,
    /// The last stage that was printed, and the furthest one.
    printed: Option<Stage>,
    furthest: Option<Stage>,
    at: Option<Instant>,
}

impl Lines {
    fn new(write: fn(&Event) -> String) -> Self {
        let last = Last { state: RunState::new(), printed: None, furthest: None, at: None };
        Self { write, last: Mutex::new(last) }
    }

    fn print(&self, event: &Event) {
        // A broken pipe on stderr is no reason to stop the work.
        let _ = writeln!(std::io::stderr(), "{}", (self.write)(event));
    }

    fn print_stage(&self, last: &mut Last, stage: Stage) {
        last.printed = Some(stage);
        last.furthest = last.furthest.max(Some(stage));
        self.print(&Event::Stage(stage));
    }
}

impl Observer for Lines {
    fn stage_begins(&self, stage: Stage) {
        let mut last = locked(&self.last);
        last.state.stage = Some(stage);
        // Components pass through the stages side by side, and stages come again: those are printed with the progress.
        if last.furthest < Some(stage) {
            self.print_stage(&mut last, stage);
        }
    }

    fn stage_ends(&self, _: Stage) {}

    fn progress(&self, thousandths: u32) {
        let mut last = locked(&self.last);
        let is_due = last.at.is_none_or(|at| at.elapsed() >= LINE_INTERVAL) || thousandths == 1000;
        if !(last.state.progress(thousandths) && is_due) {
            return;
        }
        last.at = Some(Instant::now());
        let (stage, thousandths, seconds_left) = (last.state.stage, last.state.thousandths, last.state.seconds_left());
        if let Some(stage) = stage.filter(|_| stage != last.printed) {
            self.print_stage(&mut last, stage);
        }
        self.print(&Event::Progress { thousandths, stage, seconds_left });
    }
}

fn json_line(event: &Event) -> String {
    let value = match event {
        Event::Stage(stage) => json!({"event": "stage", "stage": stage.name()}),
        Event::Progress { thousandths, stage, seconds_left } => json!({
            "event": "progress",
            "progress": f64::from(*thousandths) / 1000.0,
            "stage": stage.map(Stage::name),
            "seconds_left": seconds_left,
        }),
    };
    value.to_string()
}

fn openjd_line(event: &Event) -> String {
    match event {
        Event::Stage(stage) => format!("openjd_status: {}", stage.name()),
        Event::Progress { thousandths, stage, seconds_left } => {
            let progress = format!("openjd_progress: {}", f64::from(*thousandths) / 10.0);
            match (stage, seconds_left) {
                (Some(stage), Some(seconds)) => {
                    format!("{progress}\nopenjd_status: {}, about {seconds} s left", stage.name())
                }
                _ => progress,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_stage_progress_and_time_left() {
        let event = Event::Progress { thousandths: 70, stage: Some(Stage::Field), seconds_left: Some(12) };
        for event in [&event, &Event::Stage(Stage::Field)] {
            let line: serde_json::Value = serde_json::from_str(&json_line(event)).unwrap();
            assert!(line["event"].is_string() && line["stage"] == "field");
        }
        let line: serde_json::Value = serde_json::from_str(&json_line(&event)).unwrap();
        assert_eq!((line["progress"].as_f64(), line["seconds_left"].as_u64()), (Some(0.07), Some(12)));
        let lines = openjd_line(&event);
        assert_eq!(lines.lines().next(), Some("openjd_progress: 7"));
        assert!(
            lines.lines().nth(1).is_some_and(|line| line.starts_with("openjd_status: field") && line.contains("12"))
        );
        let early = Event::Progress { thousandths: 5, stage: None, seconds_left: None };
        assert_eq!(openjd_line(&early), "openjd_progress: 0.5");
    }
}
