//! The progress of one running attempt: from the engine into the database, throttled; and a request to cancel from the
//! database to the engine.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use crate::engine::run::{Observer, RunContext, Stage, StopReason};
use crate::service::jobs::Live;
use crate::service::store::{Holding, RunProgress, Store};
use crate::service::time_left::TimeLeft;

/// Shortest time between two writes, and longest until a cancellation by another process is seen.
const WRITE_INTERVAL: Duration = Duration::from_millis(400);

/// What the engine reports.
#[derive(Clone, Copy, Debug)]
enum Step {
    Begins(Stage),
    Ends(Stage),
    Progress(u32),
}

/// The engine's side: never blocks.
#[derive(Debug)]
pub(super) struct Listener(UnboundedSender<Step>);

impl Observer for Listener {
    fn stage_begins(&self, stage: Stage) {
        let _ = self.0.send(Step::Begins(stage));
    }

    fn stage_ends(&self, stage: Stage) {
        let _ = self.0.send(Step::Ends(stage));
    }

    fn progress(&self, thousandths: u32) {
        let _ = self.0.send(Step::Progress(thousandths));
    }
}

/// What the engine reports, on its way to [`Recorder::keep`].
#[derive(Debug)]
pub(super) struct Steps(UnboundedReceiver<Step>);

/// A listener for the engine, and the steps that it receives.
pub(super) fn channel() -> (Listener, Steps) {
    let (sender, receiver) = unbounded_channel();
    (Listener(sender), Steps(receiver))
}

/// The service's side.
#[derive(Debug)]
pub(super) struct Recorder {
    pub(super) store: Store,
    pub(super) live: Live,
    pub(super) job: Uuid,
    pub(super) attempt: u32,
    /// How far earlier attempts came, in thousandths: the progress that is shown never falls.
    pub(super) before: u32,
    pub(super) context: RunContext,
}

impl Recorder {
    /// Writes until `done`, then writes the rest; ends early if the job is lost.
    pub(super) async fn keep(self, mut steps: Steps, done: CancellationToken) {
        let mut unwritten = Unwritten::new(self.before);
        loop {
            let over = tokio::select! {
                () = done.cancelled() => true,
                () = tokio::time::sleep(WRITE_INTERVAL) => false,
            };
            while let Ok(step) = steps.0.try_recv() {
                unwritten.add(step);
            }
            let held = self.write(&mut unwritten).await;
            if over || !held {
                return;
            }
        }
    }

    /// `false` if this attempt does not hold the job any more.
    async fn write(&self, unwritten: &mut Unwritten) -> bool {
        let changed = unwritten.changed;
        let events = unwritten.take_events(unwritten.begun.elapsed());
        let progress = RunProgress {
            stage: unwritten.stage.map(Stage::name),
            progress: unwritten.progress,
            seconds_left: unwritten.seconds_left,
        };
        match self.store.note(self.job, self.attempt, &progress, &events).await {
            Ok(Holding::Held { cancel: true }) => self.context.stop(StopReason::Client),
            Ok(Holding::Held { cancel: false }) => {}
            // Whoever took the job over, or deleted it, decides about it now.
            Ok(Holding::Lost) => {
                self.context.stop(StopReason::Shutdown);
                return false;
            }
            Err(error) => tracing::warn!(%error, "progress was not noted"),
        }
        if changed {
            self.live.notify(self.job);
        }
        true
    }
}

/// What has not been written yet.
#[derive(Debug)]
struct Unwritten {
    begun: Instant,
    time_left: TimeLeft,
    stage: Option<Stage>,
    before: u32,
    progress: u32,
    seconds_left: Option<u64>,
    changed: bool,
    progressed: bool,
    events: Vec<(&'static str, Value)>,
}

impl Unwritten {
    fn new(before: u32) -> Self {
        Self {
            before,
            begun: Instant::now(),
            time_left: TimeLeft::default(),
            stage: None,
            progress: 0,
            seconds_left: None,
            changed: false,
            progressed: false,
            events: Vec::new(),
        }
    }

    fn add(&mut self, step: Step) {
        self.changed = true;
        match step {
            Step::Begins(stage) => {
                self.stage = Some(stage);
                self.events.push(("stage", json!({"stage": stage.name(), "state": "begins"})));
            }
            Step::Ends(stage) => self.events.push(("stage", json!({"stage": stage.name(), "state": "ends"}))),
            Step::Progress(thousandths) => {
                self.progress = self.progress.max(thousandths);
                self.progressed = true;
            }
        }
    }

    /// The events so far, this long after the start; many steps of progress are one.
    fn take_events(&mut self, elapsed: Duration) -> Vec<(&'static str, Value)> {
        let mut events = std::mem::take(&mut self.events);
        if self.progressed {
            let (stage, progress) = (self.stage.map(Stage::name), f64::from(self.progress) / 1000.0);
            self.seconds_left = self.time_left.seconds(elapsed, progress);
            let told = f64::from(self.progress.max(self.before)) / 1000.0;
            let data = json!({"progress": told, "stage": stage, "seconds_left": self.seconds_left});
            events.push(("progress", data));
        }
        self.progressed = false;
        self.changed = false;
        events
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_steps_of_progress_are_one_event() {
        let mut unwritten = Unwritten::new(0);
        unwritten.add(Step::Begins(Stage::Read));
        for n in 0..500 {
            unwritten.add(Step::Progress(n));
        }
        let events = unwritten.take_events(Duration::from_secs(10));
        assert_eq!(events.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), ["stage", "progress"]);
        assert_eq!(events[1].1, json!({"progress": 0.499, "stage": "read", "seconds_left": 10}));
        assert!(unwritten.take_events(Duration::from_secs(11)).is_empty());
    }

    #[test]
    fn another_attempt_tells_no_less_than_the_one_before() {
        let mut unwritten = Unwritten::new(600);
        let mut told = |thousandths, seconds| {
            unwritten.add(Step::Progress(thousandths));
            unwritten.take_events(Duration::from_secs(seconds)).remove(0).1
        };
        let (early, late) = (told(100, 10), told(700, 70));
        assert_eq!((&early["progress"], &early["seconds_left"]), (&json!(0.6), &json!(90)));
        assert_eq!(late["progress"], json!(0.7));
    }
}
