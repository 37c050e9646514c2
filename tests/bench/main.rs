//! Measurements that are no tests: `rounding` compares ways of rounding, `settings` the settings of `optimise`.
//!
//! ```text
//! cargo bench -- settings [--quads 5000] [--no-features] MODEL.obj …
//! cargo bench -- rounding [--quads 6500] [--offsets 100] [--features] [--optimise none|relocate|balance] MODEL.obj …
//! ```
//!
//! `rounding`: one line per component with integers: energies relative to direct rounding over random real optima, as the thesis gives
//! them (61.0, 63.8 and 54.8 % for greedy, r = 1 and r = 3 on the bunny), then energies relative to ½‖X‖²: predicted,
//! found, and with separations. The thesis has no sharp edges that must be followed: `--features` follows them, and then
//! only energies relative to ½‖X‖² mean something, for the integers of feature lines are no translations of the cut graph.
//! Branch points as found (`--optimise none`) come nearest to its figures.

mod model;
mod rounding;
mod settings;

fn main() {
    // cargo adds --bench.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let result = match arguments.split_first() {
        Some((command, rest)) if command == "rounding" => rounding::run(rest),
        Some((command, rest)) if command == "settings" => settings::run(rest),
        _ => Err("usage: cargo bench -- rounding|settings [options] MODEL.obj …".to_owned()),
    };
    if let Err(message) = result {
        eprintln!("{message}");
        std::process::exit(2);
    }
}
