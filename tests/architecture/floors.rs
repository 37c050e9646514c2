//! The floor plans of the two halves: a floor may use itself and those before it.

use std::fs;
use std::path::Path;

use crate::imports::Imports;
use crate::{Source, check, sources};

/// One half of the crate.
struct Half {
    /// Its folder below `src`, which is its module as well.
    name: &'static str,
    /// What lies directly below it, folders and files, lowest first.
    floors: &'static [&'static str],
}

const ENGINE: Half = Half {
    name: "engine",
    floors: &[
        "run",
        "numerics",
        "mesh",
        "topology",
        "calculus",
        "field",
        "parameterize",
        "quad",
        "problem",
        "methods",
        "attributes",
        "certify",
        "mend",
        "render",
        "pipeline",
    ],
};

const SERVICE: Half = Half {
    name: "service",
    floors: &[
        "time_left",
        "preview",
        "formats",
        "wire",
        "config",
        "telemetry",
        "store",
        "jobs",
        "run",
        "http",
        "app",
        "cli",
    ],
};

/// Modules of the engine below its floors that the service may name: the samples that the program comes with.
const MODULES_FOR_SERVICE: &[&str] = &["mesh::shapes"];

impl Half {
    /// The floor that a file belongs to; `None` for files of the other half and for the list of floors itself.
    fn floor<'a>(&self, source: &'a Source) -> Option<&'a str> {
        let rest = source.path.strip_prefix("src/")?.strip_prefix(self.name)?.strip_prefix('/')?;
        let floor = rest.split_once('/').map_or_else(|| rest.strip_suffix(".rs"), |(folder, _)| Some(folder));
        floor.filter(|floor| *floor != "mod")
    }

    fn rank(&self, floor: &str) -> Option<usize> {
        self.floors.iter().position(|known| *known == floor)
    }

    /// What the files use of floors above their own.
    fn breaches(&self, sources: &[Source]) -> Vec<String> {
        let module = format!("crate::{}::", self.name);
        let mut breaches = Vec::new();
        for source in sources {
            let Some(floor) = self.floor(source) else { continue };
            let Some(own) = self.rank(floor) else {
                breaches.push(format!("{}: {floor} is no floor of the plan", source.path));
                continue;
            };
            for (n, line) in source.code() {
                let full = line.split(&module).skip(1);
                // A relative path that leaves the floor names another one.
                let relative = line.split("super::super::").skip(1).map(|rest| rest.trim_start_matches("super::"));
                let relative = relative.filter(|rest| self.rank(first_name(rest)).is_some());
                for used in full.chain(relative).map(first_name) {
                    if self.rank(used).is_none_or(|other| other > own) {
                        breaches.push(format!("{}:{n}: {floor} may not use {used:?}", source.path));
                    }
                }
            }
        }
        breaches
    }

    /// The modules in `mod.rs` that have no place in the plan.
    fn unknown(&self) -> Vec<String> {
        let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(self.name).join("mod.rs");
        let text = fs::read_to_string(list).expect("text");
        let modules = text.lines().filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod "));
        let modules = modules.filter_map(|rest| rest.strip_suffix(';'));
        modules.filter(|floor| self.rank(floor).is_none()).map(str::to_owned).collect()
    }
}

/// The first name of a path.
fn first_name(path: &str) -> &str {
    path.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
}

#[test]
fn the_engine_uses_floors_below_only() {
    check("floor plan of the engine", ENGINE.breaches(&sources()));
}

#[test]
fn the_service_uses_floors_below_only() {
    check("floor plan of the service", SERVICE.breaches(&sources()));
}

#[test]
fn every_floor_is_in_its_plan() {
    check("floors that are not in the plan", [ENGINE.unknown(), SERVICE.unknown()].concat());
}

#[test]
fn the_service_uses_what_the_floors_of_the_engine_give_out() {
    let sources = sources();
    check("modules inside the engine", inner_modules(&Imports::of(&sources)));
}

/// The paths of the service that lead past the list of a floor of the engine into one of its modules.
fn inner_modules(imports: &Imports) -> Vec<String> {
    let mut breaches = Vec::new();
    for (file, path) in imports.paths().filter(|(file, _)| file.starts_with("src/service/")) {
        let Some(path) = path.strip_prefix("crate::engine::") else { continue };
        let is_given = MODULES_FOR_SERVICE.iter().any(|module| path.starts_with(module));
        let mut names = path.split("::").skip(1);
        let is_module = names.next().is_some_and(|name| name.starts_with(char::is_lowercase)) && names.next().is_some();
        if is_module && !is_given {
            breaches.push(format!("{file}: {path}"));
        }
    }
    breaches
}

#[test]
fn the_test_sees_seeded_breaches() {
    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let n = |half: &Half, path: &str, text: &str| half.breaches(&[source(path, text)]).len();
    assert_eq!(ENGINE.floor(&source("src/engine/mesh/a/b.rs", "")), Some("mesh"));
    assert_eq!(ENGINE.floor(&source("src/service/run/a.rs", "")), None);
    assert_eq!(SERVICE.floor(&source("src/service/time_left.rs", "")), Some("time_left"));
    assert_eq!(SERVICE.floor(&source("src/service/mod.rs", "")), None);
    assert_eq!(n(&ENGINE, "src/engine/mesh/a.rs", "use crate::engine::run::X;\n// crate::engine::field\n"), 0);
    assert_eq!(n(&ENGINE, "src/engine/mesh/a.rs", "use crate::engine::field::X;"), 1);
    assert_eq!(n(&ENGINE, "src/engine/mesh/a.rs", "use crate::engine::elsewhere::X;"), 1);
    assert_eq!(n(&ENGINE, "src/engine/elsewhere/a.rs", ""), 1);
    assert_eq!(n(&SERVICE, "src/service/jobs/a.rs", "use crate::service::store::X;\nuse super::super::a::X;"), 0);
    assert_eq!(n(&SERVICE, "src/service/store/a.rs", "    let x = crate::service::jobs::x();"), 1);
    assert_eq!(n(&SERVICE, "src/service/store/a.rs", "use super::super::jobs::X;"), 1);
    assert_eq!(n(&SERVICE, "src/service/preview.rs", "use crate::service::http::X;"), 1);
    let inner = |text: &str| inner_modules(&Imports::of(&[source("src/service/run/a.rs", text)])).len();
    assert_eq!(inner("use crate::engine::mesh::{TriMesh, shapes::sample};\nuse crate::engine::methods;"), 0);
    assert_eq!(inner("use crate::engine::certify::certify;\nlet x = crate::engine::run::StopReason::Client;"), 0);
    assert_eq!(inner("use crate::engine::quad::{QuadMesh, improve::improve};"), 1);
    assert_eq!(inner("let x = crate::engine::mesh::condition::weld(y);"), 1);
}
