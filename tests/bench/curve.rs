//! Energy and time of the search for branch points.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use quadrille::engine::pipeline::Optimise;
use quadrille::engine::run::{Observer, RunContext, Stage};

use crate::component::components;
use crate::model::{Trials, trials};

/// Seconds of the field of each component.
#[derive(Debug, Default)]
struct FieldClock {
    begun: Mutex<Option<Instant>>,
    took: Mutex<Vec<Duration>>,
}

struct Listener(Arc<FieldClock>);

impl Observer for Listener {
    fn stage_begins(&self, stage: Stage) {
        if let (Stage::Field, Ok(mut begun)) = (stage, self.0.begun.lock()) {
            *begun = Some(Instant::now());
        }
    }

    fn stage_ends(&self, stage: Stage) {
        if let (Stage::Field, Ok(begun), Ok(mut took)) = (stage, self.0.begun.lock(), self.0.took.lock()) {
            took.extend(begun.map(|begun| begun.elapsed()));
        }
    }

    fn progress(&self, _: u32) {}
}

/// Runs the command.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let Trials { spec, models, .. } = trials(arguments, 5000, Optimise::Balance)?;
    for model in models {
        let clock = Arc::new(FieldClock::default());
        let components = components(&RunContext::new(0, Listener(clock.clone())), &model, &spec)?;
        let took = clock.took.lock().map_err(|e| e.to_string())?.clone();
        for (c, (component, took)) in components.iter().zip(took).enumerate() {
            let search = &component.prepared.branch_search;
            println!("{model}, component {c}: field {:.2} s, {} energies", took.as_secs_f64(), search.evaluations);
            println!("{:>8} {:>9} {:>9} {:>7}", "seconds", "energies", "E_D", "points");
            for step in &search.curve {
                let share = step.evaluations as f64 / search.evaluations as f64;
                let seconds = share * took.as_secs_f64();
                println!("{seconds:8.2} {:9} {:9.5} {:7}", step.evaluations, step.energy, step.points);
            }
        }
    }
    Ok(())
}
