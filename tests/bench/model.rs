//! What the commands read.

use std::path::Path;

use quadrille::engine::mesh::TriangleSoup;
use quadrille::engine::pipeline::{Optimise, RemeshSpec, Target};

/// What the trials of single stages are told.
pub(super) struct Trials {
    pub(super) spec: RemeshSpec,
    /// Random real optima.
    pub(super) offsets: usize,
    pub(super) models: Vec<String>,
}

/// Reads the options of the commands that try single stages. Sharp edges are followed only with `--features`.
pub(super) fn trials(arguments: &[String], quads: u64, optimise: Optimise) -> Result<Trials, String> {
    let mut spec = RemeshSpec { target: Target::Quads(quads), optimise, ..RemeshSpec::default() };
    spec.features.angle_degrees = 180.0;
    let (mut offsets, mut models) = (100, Vec::new());
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut value = || rest.next().ok_or(format!("{argument} wants a value"));
        match argument.as_str() {
            "--quads" => spec.target = Target::Quads(number(value()?)?),
            "--offsets" => offsets = number(value()?)? as usize,
            "--features" => spec.features.angle_degrees = RemeshSpec::default().features.angle_degrees,
            "--optimise" => {
                spec.optimise = match value()?.as_str() {
                    "none" => Optimise::None,
                    "relocate" => Optimise::Relocate,
                    "balance" => Optimise::Balance,
                    other => return Err(format!("no such optimisation: {other}")),
                }
            }
            model => models.push(model.to_owned()),
        }
    }
    Ok(Trials { spec, offsets, models })
}

/// A number of the command line.
pub(super) fn number(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("{text} is no number"))
}

/// Positions and faces of an OBJ file.
pub(super) fn read(path: &Path) -> Result<TriangleSoup, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut soup = TriangleSoup::default();
    for line in String::from_utf8_lossy(&bytes).lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|w| w.parse().ok()).ok_or(format!("not a position: {line}"));
                soup.positions.push([next()?, next()?, next()?].into());
            }
            Some("f") => {
                for word in words {
                    let index: i64 = word.split('/').next().and_then(|w| w.parse().ok()).unwrap_or(0);
                    let n = soup.positions.len() as i64;
                    let at = if index < 0 { n + index } else { index - 1 };
                    soup.indices.push(u32::try_from(at).map_err(|_| format!("not a face: {line}"))?);
                }
                soup.polygon_ends.push(soup.indices.len() as u32);
            }
            _ => {}
        }
    }
    Ok(soup)
}
