//! `quadrille sample`: the built-in surfaces as files.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::shapes::{SHAPES, sample};
use crate::service::cli::failure::Failure;
use crate::service::cli::files::{self, Outputs, Overwrite};

/// Most triangles that are made.
const MAX_TRIANGLES: u64 = 4_000_000;

/// Arguments of `sample`.
#[derive(Debug, Args)]
pub(super) struct SampleArgs {
    /// Name of the surface; --list shows all
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// About this many triangles
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(12..=MAX_TRIANGLES))]
    triangles: u64,
    /// Move every vertex along its normal by up to this many mean edge lengths
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    noise: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// File to write, .obj or .stl; - is stdout, as OBJ
    #[arg(short, long, value_name = "F", required_unless_present = "list")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// List the surfaces
    #[arg(long)]
    list: bool,
}

pub(super) fn run(args: SampleArgs) -> Result<(), Failure> {
    let (Some(name), Some(output), false) = (&args.name, &args.output, args.list) else {
        let mut list = String::new();
        for shape in SHAPES {
            let _ = writeln!(
                list,
                "{:<18}{} Genus {}, {} boundaries.",
                shape.name, shape.about, shape.genus, shape.boundaries
            );
        }
        return files::print(list.into_bytes());
    };
    if !(0.0..=1.0).contains(&args.noise) {
        return Err(Failure::Usage(format!("--noise must be from 0 to 1, not {}", args.noise)));
    }
    let write = match files::extension(output) {
        _ if files::is_pipe(output) => write_obj,
        Some("obj") => write_obj,
        Some("stl") => write_stl,
        _ => return Err(Failure::Usage(format!("{} must end in .obj or .stl", output.display()))),
    };
    files::check_writable(output)?;
    let existing = args.overwrite.allow([output.as_path()])?;
    let soup = sample(name, args.triangles as usize, args.noise, args.seed)
        .ok_or_else(|| Failure::Usage(format!("there is no sample {name}; --list shows all")))?;
    let mut outputs = Outputs::new(existing);
    outputs.add(output, write(&soup))?;
    outputs.publish()
}

/// A soup as OBJ, with all digits.
pub(super) fn write_obj(soup: &TriangleSoup) -> Vec<u8> {
    let mut text = String::with_capacity(60 * soup.positions.len() + 24 * soup.n_polygons());
    for p in &soup.positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for polygon in soup.polygons() {
        text.push('f');
        for v in polygon {
            let _ = write!(text, " {}", v + 1);
        }
        text.push('\n');
    }
    text.into_bytes()
}

/// Triangles as binary STL; samples have no other polygons.
fn write_stl(soup: &TriangleSoup) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((soup.n_polygons() as u32).to_le_bytes());
    for polygon in soup.polygons() {
        let [a, b, c] = [0, 1, 2].map(|k| soup.positions[polygon[k] as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for p in [normal, a, b, c] {
            bytes.extend(p.as_vec3().to_array().iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::formats::{Format, ReadLimits, read_soup};

    #[test]
    fn samples_reread_to_the_same_surface() {
        let soup = sample("cube", 300, 0.0, 0).unwrap();
        let obj = read_soup(&write_obj(&soup), None, &ReadLimits::default()).unwrap();
        assert_eq!((&obj.positions, &obj.indices), (&soup.positions, &soup.indices));
        let stl = write_stl(&soup);
        assert_eq!(Format::sniff(&stl), Some(Format::Stl));
        assert_eq!(read_soup(&stl, None, &ReadLimits::default()).unwrap().n_polygons(), soup.n_polygons());
    }
}
