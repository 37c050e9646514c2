//! Energies of ways of rounding.

use std::path::Path;
use std::time::Instant;

use quadrille::engine::pipeline::Optimise;
use quadrille::engine::run::RunContext;

use crate::component::{Component, components};
use crate::model::{Trials, trials};
use crate::ways::{found, means};

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
        let name = Path::new(&model).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        for component in components(&RunContext::silent(), &model, &spec)? {
            if component.prepared.system.n_integers() > 0 {
                let energies = line(&component, offsets).map_err(|e| format!("{model}: {e}"))?;
                println!("{name:20} {energies} {:6.1}", start.elapsed().as_secs_f64());
            }
        }
    }
    Ok(())
}

fn line(component: &Component, offsets: usize) -> Result<String, quadrille::engine::parameterize::MapError> {
    let Component { working, prepared, scale } = component;
    let (ctx, system) = (RunContext::silent(), &prepared.system);
    let s = means(system, ctx.seed(), offsets)?;
    let separated = system.round(&ctx, &working.surface.mesh, *scale)?.rounding_energy;
    let found = found(system, &system.period_form()?, *scale)?;
    let percent = |energy: f64| 100.0 * energy / s.direct;
    let relative = |energy: f64| energy / (scale * scale);
    Ok(format!(
        "{:4} {:6.1} {:6.1} {:6.1} {:6.1} {:6.1} {:6.1} | {:9.5} {:9.5} {:9.5} {:9.5} {:9.5} {:9.5}",
        system.n_integers(),
        100.0,
        percent(s.greedy),
        percent(s.r_search[0]),
        percent(s.r_search[1]),
        percent(s.r_search[2]),
        percent(s.search),
        relative(s.direct),
        relative(s.predicted_direct),
        relative(s.search),
        relative(s.predicted_search),
        found,
        separated
    ))
}
