//! The spec on the command line: `--spec FILE.json`, and flags that override single fields of it.
//!
//! Flags become fields of the JSON document, so that there is one judge of specs and one wording of its refusals.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Map, Value, json};

use crate::service::cli::{Failure, files};
use crate::service::wire::{Problem, ResolvedSpec, Violation};

/// Longest spec file in bytes.
const MAX_SPEC_BYTES: u64 = 64 << 20;

/// Fields of the spec.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Spec")]
pub(super) struct SpecFlags {
    /// JSON file with any fields of the spec
    #[arg(long, value_name = "FILE.json")]
    spec: Option<PathBuf>,
    /// quadcover
    #[arg(long)]
    method: Option<String>,
    /// Quads of the whole model [default: 5000]
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "edge_length")]
    target_quads: Option<String>,
    /// Edge length of the quads in model units
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    edge_length: Option<String>,
    /// Curvature-adaptive size, 0 to 100
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    adaptive_size: Option<String>,
    /// Dihedral angle in degrees from which edges are sharp; 180: none [default: 40]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    feature_angle: Option<String>,
    /// align
    #[arg(long)]
    boundary: Option<String>,
    /// curvature or smooth
    #[arg(long)]
    align: Option<String>,
    /// λ between curvature alignment (0) and smoothness (1) [default: 0.5]
    #[arg(long, value_name = "LAMBDA", allow_negative_numbers = true)]
    smoothing: Option<String>,
    /// none or balance
    #[arg(long)]
    optimise: Option<String>,
    /// Axes of mirror symmetry, e.g. x,y
    #[arg(long, value_name = "AXES", value_delimiter = ',')]
    symmetry: Vec<String>,
    /// auto, or input: the parameterisation lives on the triangles of the input
    #[arg(long, value_name = "WHICH")]
    working_mesh: Option<String>,
    /// refuse or cut
    #[arg(long, value_name = "HOW")]
    non_orientable: Option<String>,
    /// Seed of every random choice [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<String>,
    /// Seconds, then the best certified result so far, or exit code 5 [default: 300]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    deadline: Option<String>,
}

impl SpecFlags {
    /// Whether a density is asked for on the command line.
    pub(super) fn names_target(&self) -> bool {
        self.spec.is_some() || self.target_quads.is_some() || self.edge_length.is_some()
    }

    /// The judged spec.
    pub(super) fn resolve(&self) -> Result<ResolvedSpec, Failure> {
        let mut document = match &self.spec {
            None => Value::Object(Map::new()),
            Some(path) => {
                let bytes = files::read(path, MAX_SPEC_BYTES)
                    .map_err(|failure| Failure::Usage(failure.line().unwrap_or_default()))?;
                serde_json::from_slice(&bytes).map_err(|error| {
                    let violation = Violation::new("", format!("{} is not JSON: {error}", path.display()));
                    Problem::invalid_spec(vec![violation])
                })?
            }
        };
        // Anything but an object is refused by the judge below, with its own words.
        if let Value::Object(fields) = &mut document {
            self.override_fields(fields);
        }
        Ok(ResolvedSpec::from_value(document).map_err(Problem::invalid_spec)?)
    }

    fn override_fields(&self, fields: &mut Map<String, Value>) {
        let texts = [
            ("method", &self.method),
            ("boundary", &self.boundary),
            ("align", &self.align),
            ("optimise", &self.optimise),
            ("working_mesh", &self.working_mesh),
            ("non_orientable", &self.non_orientable),
        ];
        for (name, text) in texts {
            if let Some(text) = text {
                fields.insert(name.to_owned(), Value::String(text.clone()));
            }
        }
        let numbers = [
            ("adaptive_size", &self.adaptive_size),
            ("smoothing", &self.smoothing),
            ("seed", &self.seed),
            ("deadline_s", &self.deadline),
        ];
        for (name, text) in numbers {
            if let Some(text) = text {
                fields.insert(name.to_owned(), number(text));
            }
        }
        if let Some(quads) = &self.target_quads {
            fields.insert("target".to_owned(), json!({ "quads": number(quads) }));
        }
        if let Some(length) = &self.edge_length {
            fields.insert("target".to_owned(), json!({ "edge_length": number(length) }));
        }
        if let Some(angle) = &self.feature_angle {
            let features = fields.entry("features").or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(features) = features {
                features.insert("angle".to_owned(), number(angle));
            }
        }
        if !self.symmetry.is_empty() {
            fields.insert("symmetry".to_owned(), json!(self.symmetry));
        }
    }
}

/// A JSON number, or the text itself, which the judge refuses as no number.
fn number(text: &str) -> Value {
    match text.parse::<u64>() {
        Ok(whole) => Value::from(whole),
        Err(_) => text
            .parse::<f64>()
            .ok()
            .and_then(serde_json::Number::from_f64)
            .map_or_else(|| Value::String(text.to_owned()), Value::Number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::pipeline::{Align, Target};

    #[test]
    fn flags_override_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("spec.json");
        std::fs::write(&path, r#"{"target": {"quads": 10}, "seed": 3, "features": {"materials": false}}"#).unwrap();
        let flags = SpecFlags {
            spec: Some(path),
            edge_length: Some("0.25".into()),
            feature_angle: Some("30".into()),
            boundary: Some("align".into()),
            align: Some("smooth".into()),
            ..SpecFlags::default()
        };
        let spec = flags.resolve().unwrap().spec;
        assert_eq!(spec.target, Target::EdgeLength(0.25));
        assert_eq!((spec.seed, spec.align), (3, Align::Smooth));
        assert_eq!((spec.features.angle_degrees, spec.features.materials), (30.0, false));
    }

    #[test]
    fn nonsense_is_refused_with_exit_code_2() {
        let wrong = [
            SpecFlags { target_quads: Some("0".into()), ..SpecFlags::default() },
            SpecFlags { target_quads: Some("1000000000".into()), ..SpecFlags::default() },
            SpecFlags { target_quads: Some("2.5".into()), ..SpecFlags::default() },
            SpecFlags { edge_length: Some("NaN".into()), ..SpecFlags::default() },
            SpecFlags { deadline: Some("-1".into()), ..SpecFlags::default() },
            SpecFlags { method: Some("magic".into()), ..SpecFlags::default() },
            SpecFlags { symmetry: vec!["w".into()], ..SpecFlags::default() },
            SpecFlags { spec: Some("no/such/file.json".into()), ..SpecFlags::default() },
        ];
        for flags in wrong {
            assert_eq!(flags.resolve().expect_err("refused").exit_code(), 2, "{flags:?}");
        }
    }
}
