//! Progress of a run on stderr: a bar for people, lines for programs.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};

use crate::engine::run::{Observer, Silent, Stage};

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
            ProgressMode::Json => Box::new(Lines { write: json_line, last: Mutex::default() }),
            ProgressMode::Openjd => Box::new(Lines { write: openjd_line, last: Mutex::default() }),
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

struct Bar(ProgressBar);

impl Bar {
    fn new() -> Self {
        let style = ProgressStyle::with_template("{spinner} {msg:<10} {bar:40} {percent:>3} % {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(1000).with_style(style);
        bar.enable_steady_tick(std::time::Duration::from_millis(100));
        Self(bar)
    }
}

impl Observer for Bar {
    fn stage_begins(&self, stage: Stage) {
        self.0.set_message(stage.name());
    }

    fn stage_ends(&self, _: Stage) {}

    fn progress(&self, thousandths: u32) {
        self.0.set_position(u64::from(thousandths));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// What a line tells.
enum Event {
    Stage(Stage),
    Percent(u32),
}

struct Lines {
    write: fn(&Event) -> String,
    last: Mutex<(Option<Stage>, u32)>,
}

impl Lines {
    fn tell(&self, event: &Event) {
        // A broken pipe on stderr is no reason to stop the work.
        let _ = writeln!(std::io::stderr(), "{}", (self.write)(event));
    }
}

impl Observer for Lines {
    fn stage_begins(&self, stage: Stage) {
        let mut last = self.last.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        // Components pass through the stages side by side: only what is new is told.
        if last.0.is_none_or(|before| before < stage) {
            last.0 = Some(stage);
            self.tell(&Event::Stage(stage));
        }
    }

    fn stage_ends(&self, _: Stage) {}

    fn progress(&self, thousandths: u32) {
        let mut last = self.last.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if thousandths / 10 > last.1 {
            last.1 = thousandths / 10;
            self.tell(&Event::Percent(last.1));
        }
    }
}

fn json_line(event: &Event) -> String {
    match event {
        Event::Stage(stage) => format!(r#"{{"event":"stage","stage":"{}"}}"#, stage.name()),
        Event::Percent(percent) => format!(r#"{{"event":"progress","progress":{}}}"#, f64::from(*percent) / 100.0),
    }
}

fn openjd_line(event: &Event) -> String {
    match event {
        Event::Stage(stage) => format!("openjd_status: {}", stage.name()),
        Event::Percent(percent) => format!("openjd_progress: {percent}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_lines_are_json() {
        for event in [Event::Stage(Stage::Field), Event::Percent(7)] {
            let line: serde_json::Value = serde_json::from_str(&json_line(&event)).unwrap();
            assert!(line["event"].is_string());
        }
        assert_eq!(openjd_line(&Event::Percent(7)), "openjd_progress: 7");
    }
}
