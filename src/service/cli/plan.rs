//! What `remesh` reads and writes, judged before any work.

use std::path::{Path, PathBuf};

use crate::service::cli::failure::Failure;
use crate::service::cli::files::{self, extension};
use crate::service::cli::places::{is_folder, is_for_many, make_folder, place};
use crate::service::cli::remesh_args::RemeshArgs;
use crate::service::formats::{Format, MapFormat, QuadFormat};

/// One input and what is made of it.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) input: PathBuf,
    pub(super) from: Option<Format>,
    pub(super) quads: PathBuf,
    pub(super) to: QuadFormat,
    pub(super) map: Option<(PathBuf, MapFormat)>,
    pub(super) report: Option<PathBuf>,
    pub(super) preview: Option<PathBuf>,
}

impl Plan {
    /// A plan per input. No two write the same file.
    pub(super) fn all(args: &RemeshArgs) -> Result<Vec<Self>, Failure> {
        let patterns =
            [Some(&args.output), args.parameterisation.as_ref(), args.report.as_ref(), args.preview.as_ref()];
        for pattern in patterns.into_iter().flatten() {
            if args.inputs.len() > 1 && !is_for_many(pattern) {
                let name = pattern.display();
                return Err(Failure::Usage(format!(
                    "{name} is one file for several inputs; name a folder, or use {{stem}}"
                )));
            }
            make_folder(pattern)?;
        }
        let plans: Vec<Self> = args.inputs.iter().map(|input| Self::of(args, input)).collect::<Result<_, _>>()?;
        let mut outputs: Vec<&Path> = plans.iter().flat_map(Self::outputs).collect();
        outputs.sort_unstable();
        if let Some(pair) = outputs.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Failure::Usage(format!("{} would be written twice", pair[0].display())));
        }
        outputs.iter().try_for_each(|path| files::check_writable(path))?;
        Ok(plans)
    }

    fn of(args: &RemeshArgs, input: &Path) -> Result<Self, Failure> {
        let from = read_format(args.from.as_deref(), input)?;
        let to = match &args.to {
            Some(name) => quad_format(name)?,
            None if is_folder(&args.output) => same_or_obj(from),
            None => quad_format(extension(&args.output).unwrap_or_default())?,
        };
        let map = args.parameterisation.as_ref().map(|pattern| {
            let name = if is_folder(pattern) { "obj" } else { extension(pattern).unwrap_or_default() };
            let format = known(MapFormat::from_extension(name), name, "obj, glb, json")?;
            Ok::<_, Failure>((place(pattern, input, &format!("parameterisation.{name}"))?, format))
        });
        let beside = |pattern: &Option<PathBuf>, ending: &str| {
            pattern.as_ref().map(|pattern| place(pattern, input, ending)).transpose()
        };
        Ok(Self {
            input: input.to_owned(),
            from,
            quads: place(&args.output, input, &format!("quads.{}", to.extension()))?,
            to,
            map: map.transpose()?,
            report: beside(&args.report, "report.json")?,
            preview: beside(&args.preview, "png")?,
        })
    }

    /// All files that are written.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        let others = [self.map.as_ref().map(|(path, _)| path), self.report.as_ref(), self.preview.as_ref()];
        std::iter::once(&self.quads).chain(others.into_iter().flatten()).map(PathBuf::as_path)
    }
}

/// The format that quads of such an input go to if nobody says which.
fn same_or_obj(from: Option<Format>) -> QuadFormat {
    match from {
        Some(Format::Glb | Format::Gltf) => QuadFormat::Glb,
        Some(Format::Ply) => QuadFormat::Ply,
        Some(Format::Obj | Format::Stl | Format::Zip) | None => QuadFormat::Obj,
    }
}

/// The format of a mesh by its name on the command line, or by the file's ending; otherwise its first bytes tell it.
pub(super) fn read_format(name: Option<&str>, input: &Path) -> Result<Option<Format>, Failure> {
    match name {
        Some(name) => Ok(Some(known(Format::from_extension(name), name, "obj, glb, gltf, ply, stl, zip")?)),
        None => Ok(extension(input).and_then(Format::from_extension)),
    }
}

/// The format of quads with this name.
pub(super) fn quad_format(name: &str) -> Result<QuadFormat, Failure> {
    known(QuadFormat::from_extension(name), name, "obj, glb, ply, usda")
}

/// The format, or the names that are known.
fn known<T>(format: Option<T>, name: &str, names: &str) -> Result<T, Failure> {
    format.ok_or_else(|| Failure::Usage(format!("{name:?} is no format known here; use one of {names}")))
}
