//! The run as a worker sees it: an upload in, all files of a job out.

use crate::engine::run::RunContext;
use crate::service::formats::{Alone, Format, MapFormat, QuadFormat, ReadError, ReadLimits, read_quads, read_soup};
use crate::service::jobs::{Driver, InputFile, Inspection, Made, Products};
use crate::service::run::execute::draw;
use crate::service::run::{Input, Wanted, execute};
use crate::service::wire::{Problem, ResolvedSpec};

/// Runs the engine on uploads.
#[derive(Clone, Copy, Debug)]
pub struct EngineDriver {
    /// What a file may claim.
    pub limits: ReadLimits,
}

impl Driver for EngineDriver {
    fn inspect(&self, input: &InputFile, whole: bool) -> Result<Inspection, Problem> {
        let format = format_of(input)?;
        let mut found = Inspection { format: format.name().to_ascii_lowercase(), ..Inspection::default() };
        if whole {
            let soup = read_soup(&input.bytes, Some(format), &self.limits).map_err(|error| Problem::from(&error))?;
            found.vertices = Some(soup.positions.len() as u64);
            found.faces = Some(soup.n_polygons() as u64);
        }
        Ok(found)
    }

    fn run(&self, context: &RunContext, input: &InputFile, spec: &ResolvedSpec) -> Result<Products, Problem> {
        let known = input.format.as_deref().and_then(Format::from_extension);
        let format = known.map_or_else(|| format_of(input), Ok)?;
        // What lies beside an upload is in the same archive.
        let input = Input { bytes: &input.bytes, format: Some(format), beside: &Alone, limits: self.limits };
        // PLY first: it is the file that is certified, and it holds all digits.
        let quads = vec![QuadFormat::Ply, QuadFormat::Obj, QuadFormat::Glb, QuadFormat::Usda];
        let wanted = Wanted { quads, map: MapFormat::ALL.to_vec(), preview: None };
        let made = execute(context, &input, spec, &wanted)?;
        let quads = made.quads.into_iter().map(|(format, bytes)| {
            let name = match format {
                QuadFormat::Obj => "quad-mesh.obj",
                QuadFormat::Glb => "quad-mesh.glb",
                QuadFormat::Ply => "quad-mesh.ply",
                QuadFormat::Usda => "quad-mesh.usda",
            };
            Made { name, media_type: format.media_type(), bytes }
        });
        let map = made.map.into_iter().map(|(format, bytes)| {
            let name = match format {
                MapFormat::Obj => "parameterisation.obj",
                MapFormat::Glb => "parameterisation.glb",
                MapFormat::Json => "parameterisation.json",
            };
            Made { name, media_type: format.media_type(), bytes }
        });
        Ok(Products { files: quads.chain(map).collect(), report: made.report })
    }

    fn preview(&self, quads: &[u8], size: u32) -> Result<Vec<u8>, Problem> {
        let quads = read_quads(quads, QuadFormat::Ply).map_err(|error| {
            tracing::error!(%error, "stored quads cannot be read");
            Problem::internal()
        })?;
        draw(&quads, size)
    }
}

/// The format by the first bytes, and where these are silent by the name.
fn format_of(input: &InputFile) -> Result<Format, Problem> {
    let named = || Format::from_extension(input.name.as_deref()?.rsplit_once('.')?.1);
    Format::sniff(&input.bytes).or_else(named).ok_or_else(|| Problem::from(&ReadError::UnknownFormat))
}
