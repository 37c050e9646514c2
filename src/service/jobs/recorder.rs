//! The books of one running attempt: what the engine says, throttled into the database; what clients say, to the engine.

use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use crate::engine::run::{Observer, RunContext, Stage, StopReason};
use crate::service::jobs::Live;
use crate::service::store::{Holding, Store};

/// Shortest time between two writes, and longest until a cancellation by another process is seen.
const PACE: Duration = Duration::from_millis(400);

/// What the engine said.
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

/// What the engine said, on its way to [`Recorder::keep`].
#[derive(Debug)]
pub(super) struct Said(UnboundedReceiver<Step>);

/// A listener for the engine and what it hears.
pub(super) fn channel() -> (Listener, Said) {
    let (tell, told) = unbounded_channel();
    (Listener(tell), Said(told))
}

/// The service's side.
#[derive(Debug)]
pub(super) struct Recorder {
    pub(super) store: Store,
    pub(super) live: Live,
    pub(super) job: Uuid,
    pub(super) attempt: u32,
    pub(super) context: RunContext,
}

impl Recorder {
    /// Writes until `done`, then writes the rest; ends early if the job is lost.
    pub(super) async fn keep(self, mut said: Said, done: CancellationToken) {
        let mut page = Page::default();
        loop {
            let over = tokio::select! {
                () = done.cancelled() => true,
                () = tokio::time::sleep(PACE) => false,
            };
            while let Ok(step) = said.0.try_recv() {
                page.take(step);
            }
            let held = self.write(&mut page).await;
            if over || !held {
                return;
            }
        }
    }

    /// `false` if the job is not ours any more.
    async fn write(&self, page: &mut Page) -> bool {
        let changed = page.changed;
        let events = page.turn();
        match self.store.note(self.job, self.attempt, page.stage.map(Stage::name), page.progress, &events).await {
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
            self.live.ring(self.job);
        }
        true
    }
}

/// What has not been written yet.
#[derive(Debug, Default)]
struct Page {
    stage: Option<Stage>,
    progress: u32,
    changed: bool,
    progressed: bool,
    events: Vec<(&'static str, Value)>,
}

impl Page {
    fn take(&mut self, step: Step) {
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

    /// The events so far; many steps of progress are one.
    fn turn(&mut self) -> Vec<(&'static str, Value)> {
        let mut events = std::mem::take(&mut self.events);
        if self.progressed {
            let stage = self.stage.map(Stage::name);
            events.push(("progress", json!({"progress": f64::from(self.progress) / 1000.0, "stage": stage})));
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
        let mut page = Page::default();
        page.take(Step::Begins(Stage::Read));
        for n in 0..500 {
            page.take(Step::Progress(n));
        }
        let events = page.turn();
        assert_eq!(events.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), ["stage", "progress"]);
        assert_eq!(events[1].1, json!({"progress": 0.499, "stage": "read"}));
        assert!(page.turn().is_empty());
    }
}
