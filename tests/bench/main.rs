//! Measurements that are no tests: `rounding` compares ways of rounding, `settings` the settings of `optimise`, `curve`
//! follows the search for branch points, `stages` says what the stages of a run cost.
//!
//! ```text
//! cargo bench -- settings [--quads 5000] [--no-features] MODEL.obj …
//! cargo bench -- curve [--quads 5000] [--features] [--optimise balance] MODEL.obj …
//! cargo bench -- rounding [--quads 6500] [--offsets 100] [--features] [--optimise none|relocate|balance] MODEL.obj …
//! cargo bench -- stages [--quads 1000,5000,20000] MODEL.obj …
//! ```
//!
//! `rounding`: one line per component with integers: energies relative to direct rounding over random real optima, as
//! the thesis gives them (61.0, 63.8 and 54.8 % for greedy, r = 1 and r = 3 on the bunny), then energies relative to
//! ½‖X‖²: predicted, found, and with separations. The thesis has no sharp edges that must be followed: `--features`
//! follows them, and then only energies relative to ½‖X‖² mean something, for the integers of feature lines are no
//! translations of the cut graph. Branch points as found (`--optimise none`) come nearest to its figures.
//!
//! `curve`: per component, the curl energy and the number of branch points after every batch of moves that was kept,
//! with about the seconds until then: the share of the energies computed so far in the time of the field. Those of the
//! coarse mesh cost less than those of the working mesh, and the making of that mesh is counted too. The number of points
//! jumps where the search goes on from the coarse mesh to the working mesh, and so may the energy.
//!
//! `stages`: one line per run, then the mean shares of the stages by the size of the runs, then the costs from which
//! `engine/pipeline/costs.rs` derives the shares of progress: copy them there after changes that make stages faster or
//! slower. Nothing else should run on the machine meanwhile, but only ratios matter.

mod component;
mod curve;
mod model;
mod rounding;
mod settings;
mod stages;
mod ways;

fn main() {
    // cargo adds --bench.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let result = match arguments.split_first() {
        Some((command, rest)) if command == "rounding" => rounding::run(rest),
        Some((command, rest)) if command == "settings" => settings::run(rest),
        Some((command, rest)) if command == "curve" => curve::run(rest),
        Some((command, rest)) if command == "stages" => stages::run(rest),
        _ => Err("usage: cargo bench -- rounding|settings|curve|stages [options] MODEL.obj …".to_owned()),
    };
    if let Err(message) = result {
        eprintln!("{message}");
        std::process::exit(2);
    }
}
