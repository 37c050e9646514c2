//! The spec on the command line: `--spec FILE.json`, and flags that override single fields of it.
//!
//! The flags follow from the table of fields, and their texts become JSON, so that there is one judge of specs and one
//! wording of its refusals.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Args, Command, FromArgMatches, value_parser};

use crate::engine::pipeline::{GivenBranchPoints, GivenField};
use crate::service::cli::failure::Failure;
use crate::service::cli::files;
use crate::service::formats::{FieldFormat, read_field, read_matchings};
use crate::service::wire::{
    FIELDS, Field, Flag, FlagText, Problem, ResolvedSpec, SPEC_BYTES, SpecTable, json_of_field,
};

const SPEC: &str = "spec";
/// Stands for a list without names.
const NONE: &str = "none";

/// Fields of the spec.
#[derive(Debug, Default)]
pub(super) struct SpecFlags {
    /// JSON file with any fields of the spec.
    spec: Option<PathBuf>,
    /// JSON texts by the names of their fields.
    fields: BTreeMap<&'static str, String>,
    /// Files with given fields by the names of their fields.
    files: BTreeMap<&'static str, PathBuf>,
}

impl SpecFlags {
    /// Whether a density is asked for on the command line.
    pub(super) fn names_target(&self) -> bool {
        self.spec.is_some() || self.fields.contains_key("target")
    }

    /// The judged spec.
    pub(super) fn resolve(&self) -> Result<ResolvedSpec, Failure> {
        let text = match &self.spec {
            None => Vec::new(),
            Some(path) => files::read(path, SPEC_BYTES as u64)
                .map_err(|failure| Failure::Usage(failure.line().unwrap_or_default()))?,
        };
        let mut fields = self.fields.clone();
        for (&name, path) in &self.files {
            fields.insert(name, field_json(path)?);
        }
        Ok(ResolvedSpec::with_flags(&text, &fields).map_err(Problem::invalid_spec)?)
    }
}

impl Args for SpecFlags {
    fn augment_args(command: Command) -> Command {
        let spec = Arg::new(SPEC)
            .long(SPEC)
            .value_name("FILE.json")
            .value_parser(value_parser!(PathBuf))
            .help("JSON file with any fields of the spec");
        let mut command = command.next_help_heading("Spec").arg(spec);
        for field in FIELDS {
            command = command.args(field.flags.iter().map(|flag| arg(field, flag)));
            if field.flags.len() > 1 {
                command = command.group(ArgGroup::new(field.name).args(field.flags.iter().map(|flag| flag.name)));
            }
        }
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SpecFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut flags = Self::default();
        flags.update_from_arg_matches(matches)?;
        Ok(flags)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.spec = matches.get_one(SPEC).cloned();
        for field in FIELDS {
            for flag in field.flags {
                if matches.value_source(flag.name) == Some(ValueSource::CommandLine) {
                    let texts: Vec<&String> = matches.get_many(flag.name).into_iter().flatten().collect();
                    if field.values.flag_text() == FlagText::FieldFile {
                        self.files.extend(texts.first().map(|path| (field.name, PathBuf::from(path.as_str()))));
                        continue;
                    }
                    let json = json(field.values.flag_text(), &texts);
                    let json = flag.member.map_or_else(|| json.clone(), |member| format!("{{\"{member}\": {json}}}"));
                    self.fields.insert(field.name, json);
                }
            }
        }
        Ok(())
    }
}

/// Most bytes of a file with a field: 10 million faces.
const FIELD_BYTES: u64 = 2 << 30;

/// The JSON of a field from its file; matchings are read from the file of the same name that ends in `.matching`, where
/// there is one beside a `.rawfield`.
fn field_json(path: &Path) -> Result<String, Failure> {
    let usage = |text: String| Failure::Usage(format!("{}: {text}", path.display()));
    let read =
        |path: &Path| files::read(path, FIELD_BYTES).map_err(|failure| usage(failure.line().unwrap_or_default()));
    let format = files::extension(path)
        .and_then(FieldFormat::from_extension)
        .ok_or_else(|| usage(format!("fields are read from {}", FieldFormat::ENDINGS)))?;
    let vectors = read_field(&read(path)?, format).map_err(|error| usage(error.to_string()))?;
    let beside = path.with_extension("matching");
    let matchings = match format == FieldFormat::RawField && beside.is_file() {
        true => read_matchings(&read(&beside)?).map_err(|error| usage(error.to_string()))?,
        false => Vec::new(),
    };
    let field = GivenField { vectors, matchings, branch_points: GivenBranchPoints::Keep };
    json_of_field(field).map_err(|error| usage(error.to_string()))
}

/// `quadrille spec`: the table of fields.
pub(super) fn print_table() -> Result<(), Failure> {
    files::print(SpecTable.to_string().into_bytes())
}

fn arg(field: &Field, flag: &Flag) -> Arg {
    let kind = field.values.flag_text();
    let choices = field.values.choices();
    let mut help = flag.help.unwrap_or(field.help).trim_end_matches('.').to_owned();
    if choices.is_empty() && kind == FlagText::Number && flag.member.is_none() {
        help += &format!(", {}", field.values.allowed());
    }
    let default = field.default_text();
    let default = match flag.member {
        None => default,
        Some(member) => default.and_then(|text| {
            let value: serde_json::Value = serde_json::from_str(&text).ok()?;
            value.get(member).map(ToString::to_string)
        }),
    };
    if let Some(default) = default {
        help += &format!(" [default: {default}]");
    }
    let arg = Arg::new(flag.name).long(flag.name).value_name(flag.value).help(help).allow_negative_numbers(true);
    let values = || choices.iter().map(|&(name, help)| PossibleValue::new(name).help(help));
    match kind {
        FlagText::Number | FlagText::FieldFile => arg,
        FlagText::Switch => arg
            .num_args(0..=1)
            .require_equals(true)
            .default_missing_value("true")
            .value_parser(PossibleValuesParser::new(["true", "false"])),
        FlagText::Name => arg.value_parser(PossibleValuesParser::new(values())),
        FlagText::Names | FlagText::NamesOr(_) => {
            let none = PossibleValue::new(NONE).help("No one of these.");
            arg.action(ArgAction::Append)
                .value_delimiter(',')
                .value_parser(PossibleValuesParser::new(values().chain([none])))
        }
        FlagText::Members => arg.action(ArgAction::Append),
    }
}

/// The JSON of what a flag says.
fn json(kind: FlagText, texts: &[&String]) -> String {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let text = texts.first().map(|text| text.as_str()).unwrap_or_default();
    match kind {
        FlagText::Switch => text.to_owned(),
        FlagText::Name | FlagText::FieldFile => quoted(text),
        FlagText::NamesOr(name) if text == name && texts.len() == 1 => quoted(text),
        FlagText::Names | FlagText::NamesOr(_) => {
            let names: Vec<String> = texts.iter().filter(|name| **name != NONE).map(|name| quoted(name)).collect();
            format!("[{}]", names.join(","))
        }
        FlagText::Members => {
            let member = |text: &&String| {
                let (name, value) = text.split_once('=').unwrap_or((text, ""));
                let value = if serde_json::from_str::<serde_json::Value>(value).is_ok() {
                    value.to_owned()
                } else {
                    quoted(value)
                };
                format!("{}: {value}", quoted(name))
            };
            format!("{{{}}}", texts.iter().map(member).collect::<Vec<_>>().join(","))
        }
        // What is no number of JSON is refused as text by the judge.
        FlagText::Number => match text.parse::<serde_json::Number>() {
            Ok(number) => number.to_string(),
            Err(_) => quoted(text),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::methods::Value;
    use crate::engine::pipeline::{Align, Effort, GivenMatching, Symmetry, Target};
    use crate::service::wire::LevelName;

    fn flags(line: &[&str]) -> Result<SpecFlags, clap::Error> {
        let command = SpecFlags::augment_args(Command::new("test").no_binary_name(true));
        SpecFlags::from_arg_matches(&command.try_get_matches_from(line)?)
    }

    fn resolved(line: &[&str]) -> ResolvedSpec {
        flags(line).unwrap().resolve().unwrap()
    }

    #[test]
    fn flags_override_the_file_even_where_it_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("spec.json");
        let text = r#"{"target": {"quads": 10}, "seed": 3, "align": 7, "features": {"materials": false, "angle": -1}}"#;
        std::fs::write(&path, text).unwrap();
        let spec = path.to_str().unwrap();
        let line = ["--spec", spec, "--edge-length", "0.25", "--feature-angle", "30", "--align", "smooth"];
        let spec = resolved(&line).spec;
        assert_eq!(spec.target, Target::EdgeLength(0.25));
        assert_eq!((spec.seed, spec.align), (3, Align::Smooth));
        assert_eq!((spec.features.angle_degrees, spec.features.materials), (30.0, false));
    }

    #[test]
    fn every_field_that_is_no_list_of_its_own_and_shapes_the_result_is_a_flag() {
        let without: Vec<&str> = FIELDS.iter().filter(|f| f.flags.is_empty()).map(|f| f.name).collect();
        assert_eq!(without, ["features.edges", "strokes", "tags", "priority"]);
        let spec = resolved(&[
            "--method=triangle-pairs",
            "--param=fidelity=loose",
            "--effort=fast",
            "--target-quads=7",
            "--adapt-count=false",
            "--adaptive-size=10",
            "--density-from-vertex-colour",
            "--feature-normals",
            "--feature-materials=false",
            "--boundary=align",
            "--smoothing=0.25",
            "--optimise=relocate",
            "--symmetry=z,x",
            "--output=pure",
            "--working-mesh=input",
            "--preserve=none",
            "--non-orientable=cut",
            "--seed=9",
            "--deadline=2.5",
            "--accept-level=L1",
            "--accept-count=0.1",
            "--accept-distance=0.01",
        ]);
        assert_eq!((spec.spec.target, spec.spec.adapt_count, spec.spec.seed), (Target::Quads(7), false, 9));
        assert!(spec.spec.density_from_vertex_colour && spec.spec.features.normals && !spec.spec.features.materials);
        assert_eq!((spec.spec.symmetry, spec.spec.preserve.uv), (Symmetry::Across(vec![0, 2]), false));
        assert_eq!(spec.options.deadline_s, 2.5);
        assert_eq!((spec.spec.method.name(), spec.spec.effort), ("triangle-pairs", Effort::Fast));
        let parameters = &spec.spec.parameters;
        assert_eq!(parameters.get(&spec.spec.method.0.parameters()[0]), Value::Choice("loose"));
        assert_eq!(spec.accept.level, Some(LevelName::L1));
        assert_eq!((spec.accept.count, spec.accept.distance), (Some(0.1), Some(0.01)));
    }

    #[test]
    fn a_field_is_read_from_its_file_with_the_matchings_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.rawfield");
        std::fs::write(&path, "4 1\n1 0 0 0 2 0 -1 0 0 0 -2 0\n").unwrap();
        std::fs::write(path.with_extension("matching"), "4 1\n0 3 7 8 1\n").unwrap();
        let field = resolved(&["--field", path.to_str().unwrap()]).spec.field.unwrap();
        assert_eq!(field.vectors.len(), 1);
        assert_eq!(field.matchings, [GivenMatching { from: 0, to: 3, quarters: 1 }]);
        for name in ["none.rosy", "model.matching", "model"] {
            let path = folder.path().join(name);
            let failure = flags(&["--field", path.to_str().unwrap()]).unwrap().resolve().expect_err("refused");
            assert_eq!(failure.exit_code(), 2, "{name}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_exit_code_2() {
        let wrong = [
            ["--target-quads", "0"],
            ["--target-quads", "1000000000"],
            ["--target-quads", "2.5"],
            ["--edge-length", "NaN"],
            ["--deadline", "-1"],
            ["--spec", "no/such/file.json"],
            ["--accept-count", "-0.1"],
            ["--param", "fidelity=loose"],
            ["--param", "branch_price"],
        ];
        for line in wrong {
            assert_eq!(flags(&line).unwrap().resolve().expect_err("refused").exit_code(), 2, "{line:?}");
        }
        for line in
            [["--method", "magic"], ["--symmetry", "w"], ["--output", "dominant"], ["--adapt-count=7", "--seed=1"]]
        {
            assert_eq!(flags(&line).expect_err("refused").exit_code(), 2, "{line:?}");
        }
        assert!(flags(&["--target-quads", "7", "--edge-length", "1"]).is_err());
    }
}
