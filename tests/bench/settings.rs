//! Energies, quality and times of the settings of `optimise`.

use std::path::Path;
use std::time::Instant;

use quadrille::engine::pipeline::{Optimise, RemeshSpec, Target, remesh};
use quadrille::engine::run::RunContext;

use crate::model::{number, read};

/// Runs the command.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let mut spec = RemeshSpec { target: Target::Quads(5000), ..RemeshSpec::default() };
    let mut models = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--quads" => spec.target = Target::Quads(number(rest.next().ok_or("--quads wants a value")?)?),
            "--no-features" => spec.features.angle_degrees = 180.0,
            model => models.push(model),
        }
    }
    println!("{:16} {:9} points before and after, E_D before and after, energies computed", "", "");
    println!(
        "{:16} {:9} {:>4} {:>4} {:>8} {:>8} {:>4} | {:>8} {:>8} {:>8} {:>6} | {:>6} {:>5} {:>7} {:>7} {:>2} {:>6}",
        "model",
        "optimise",
        "",
        "",
        "",
        "",
        "",
        "E_D",
        "E_H",
        "sum",
        "ARAP",
        "quads",
        "irr",
        "rsd_e",
        "rsd_a",
        "L",
        "secs"
    );
    for model in models {
        let soup = read(Path::new(model))?;
        let name = Path::new(model).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        for (setting, optimise) in
            [("none", Optimise::None), ("relocate", Optimise::Relocate), ("balance", Optimise::Balance)]
        {
            let start = Instant::now();
            let spec = RemeshSpec { optimise, ..spec.clone() };
            let report = remesh(&RunContext::silent(), &soup, &spec).map_err(|e| format!("{name}: {e}"))?.report;
            let (quads, map) = (&report.quads, report.map.clone().unwrap_or_default());
            let search = map.branch_search.unwrap_or_default();
            let [curl, rounding] = [map.curl_energy, map.rounding_energy].map(|energy| energy.unwrap_or(f64::NAN));
            println!(
                "{name:16} {setting:9} {:4} {:4} {:8.5} {:8.5} {:4} | {:8.5} {:8.5} {:8.5} {:6.4} | {:6} {:5} {:7.4} {:7.4} {:?} {:6.1}",
                search.points[0],
                search.points[1],
                search.curl_energy[0],
                search.curl_energy[1],
                search.evaluations,
                curl,
                rounding,
                curl + rounding,
                map.arap_mean,
                quads.count,
                quads.irregular_interior,
                quads.rsd_edge,
                quads.rsd_angle,
                report.level,
                start.elapsed().as_secs_f64()
            );
        }
    }
    Ok(())
}
