//! Energies of ways of rounding.

use std::path::Path;
use std::time::Instant;

use quadrille::engine::pipeline::{Optimise, RoundingTrial, rounding_trials};
use quadrille::engine::run::RunContext;

use crate::model::{Trials, read, trials};

/// Runs the command.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let Trials { spec, offsets, models } = trials(arguments, 6500, Optimise::Balance)?;
    println!(
        "{:20} {:>4} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} | {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6}",
        "model",
        "n",
        "direct",
        "greedy",
        "r=1",
        "r=2",
        "r=3",
        "ours",
        "direct",
        "predicted",
        "ours",
        "predicted",
        "found",
        "separated",
        "secs"
    );
    for model in models {
        let start = Instant::now();
        let soup = read(Path::new(&model))?;
        let trials = rounding_trials(&RunContext::silent(), &soup, &spec, offsets).map_err(|e| e.to_string())?;
        let name = Path::new(&model).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        for trial in trials.iter().filter(|t| t.statistics.n_integers > 0) {
            println!("{}", line(&name, trial, start.elapsed().as_secs_f64()));
        }
    }
    Ok(())
}

fn line(name: &str, trial: &RoundingTrial, seconds: f64) -> String {
    let s = &trial.statistics;
    let percent = |energy: f64| 100.0 * energy / s.direct;
    format!(
        "{name:20} {:4} {:6.1} {:6.1} {:6.1} {:6.1} {:6.1} {:6.1} | {:9.5} {:9.5} {:9.5} {:9.5} {:9.5} {:9.5} {seconds:6.1}",
        s.n_integers,
        100.0,
        percent(s.greedy),
        percent(s.r_search[0]),
        percent(s.r_search[1]),
        percent(s.r_search[2]),
        percent(s.search),
        s.direct,
        s.predicted_direct,
        s.search,
        s.predicted_search,
        trial.found,
        trial.separated
    )
}
