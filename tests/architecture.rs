//! The floor plan and the habits of the house, read from the sources.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "architecture/circles.rs"]
mod circles;
#[path = "architecture/floors.rs"]
mod floors;
#[path = "architecture/imports.rs"]
mod imports;

/// What the engine must not know: the network, files, the environment, clocks, wire formats, and anything whose order
/// differs from run to run.
const FORBIDDEN_IN_ENGINE: &[&str] = &[
    "tokio",
    "axum",
    "serde",
    "std::fs",
    "std::env",
    "Instant",
    "SystemTime",
    "println!",
    "eprintln!",
    "HashMap",
    "HashSet",
    "crate::service",
];

/// Never in the sources; written in two parts so that this file passes its own test.
const FORBIDDEN: &[&str] = &[concat!("TO", "DO"), concat!("FIX", "ME"), concat!("to", "do!("), concat!("db", "g!(")];

const MAX_LINES: usize = 500;

struct Source {
    path: String,
    text: String,
}

impl Source {
    /// The lines of code with their numbers, without comments.
    fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        lines.filter(|(_, line)| !line.starts_with("//"))
    }
}

fn sources() -> Vec<Source> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    let mut folders = vec![root.join("src"), root.join("tests")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the folder can be read").map(|entry| entry.expect("an entry")) {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name =
                    |path: &Path| path.strip_prefix(&root).expect("below the root").to_string_lossy().into_owned();
                found.push(Source { text: fs::read_to_string(&path).expect("text"), path: name(&path) });
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    assert!(found.len() > 20, "the sources were not found");
    found
}

/// All breaches at once, so that one run shows what is to be done.
fn check(name: &str, breaches: Vec<String>) {
    assert!(breaches.is_empty(), "{name}:\n{}", breaches.join("\n"));
}

#[test]
fn the_engine_knows_no_outside() {
    let mut breaches = Vec::new();
    for source in sources().iter().filter(|source| source.path.starts_with("src/engine/")) {
        for (n, line) in source.code() {
            let words = FORBIDDEN_IN_ENGINE.iter().filter(|word| contains_word(line, word));
            breaches.extend(words.map(|word| format!("{}:{n}: {word}", source.path)));
        }
    }
    check("words that the engine must not know", breaches);
}

/// Whether `word` stands in `line` and is not a part of a longer name.
fn contains_word(line: &str, word: &str) -> bool {
    let part_of_name = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    line.match_indices(word).any(|(at, _)| {
        let before = part_of_name(line[..at].chars().next_back());
        let after = !word.ends_with('!') && part_of_name(line[at + word.len()..].chars().next());
        !before && !after
    })
}

#[test]
fn methods_do_not_use_each_other() {
    let mut breaches = Vec::new();
    let sources = sources();
    // The folder of a method; files beside the folders are what all methods share.
    let folder = |source: &Source| {
        let rest = source.path.strip_prefix("src/engine/methods/")?;
        rest.split_once('/').map(|(own, _)| own.to_owned())
    };
    let mut folders: Vec<String> = sources.iter().filter_map(folder).collect();
    folders.dedup();
    for source in &sources {
        let Some(own) = folder(source) else { continue };
        // Their tests may run several of them.
        if source.path.ends_with("/tests.rs") {
            continue;
        }
        for (n, line) in source.code() {
            let is_other = |used: &&str| folders.iter().any(|f| *f != own && used.starts_with(&format!("{f}::")));
            let used = line.split("engine::methods::").skip(1).filter(is_other);
            breaches.extend(used.map(|used| format!("{}:{n}: methods::{used}", source.path)));
        }
    }
    check("methods that use methods", breaches);
}

#[test]
fn imports_can_be_read_by_this_test() {
    let mut breaches = Vec::new();
    for source in sources() {
        for (n, line) in source.code() {
            let grouped =
                ["", "engine::", "service::"].iter().any(|half| line.contains(&format!("use crate::{half}{{")));
            let words = FORBIDDEN.iter().filter(|word| line.contains(**word) && !line.contains("concat!"));
            breaches.extend(words.map(|word| format!("{}:{n}: {word}", source.path)));
            // In the engine a relative path could hide a floor.
            let relative = line.contains("super::super::") && source.path.starts_with("src/engine/");
            if (grouped || relative) && !source.path.starts_with("tests/") {
                breaches.push(format!("{}:{n}: one floor per use line, by its full path", source.path));
            }
        }
    }
    check("imports and leftovers", breaches);
}

#[test]
fn files_are_short_and_say_what_they_are() {
    let mut breaches = Vec::new();
    for source in sources() {
        let lines = source.text.lines().count();
        if lines > MAX_LINES {
            breaches.push(format!("{}: {lines} lines are more than {MAX_LINES}", source.path));
        }
        let tests_beside = source.path.ends_with("/tests.rs");
        if !source.text.starts_with("//!") && !tests_beside {
            breaches.push(format!("{}: no module documentation", source.path));
        }
    }
    check("files", breaches);
}

/// The keys of papers, such as `[kaelberer_2007]` or `[bommes_2009, section 6]`, in a line, and whether each stands in
/// a code span of its own.
fn citations(line: &str) -> impl Iterator<Item = (&str, bool)> {
    let brackets = line.match_indices('[').filter_map(|(at, _)| {
        let (inside, after) = line[at + 1..].split_once(']')?;
        let key = inside.split_once(',').map_or(inside, |(key, _)| key);
        Some((key, line[..at].ends_with('`') && after.starts_with('`')))
    });
    brackets.filter(|(key, _)| {
        key.rsplit_once('_').is_some_and(|(name, year)| {
            let is_name = name.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            is_name && year.len() == 4 && year.parse::<u16>().is_ok()
        })
    })
}

/// The documents of the repository, with their paths.
fn documents() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pages = ["", "docs", "docs/methods"].map(|folder| root.join(folder));
    let files = pages.iter().flat_map(|folder| fs::read_dir(folder).expect("a folder of documents"));
    let paths = files.map(|entry| entry.expect("an entry").path());
    let documents = paths.filter(|path| path.extension().is_some_and(|end| end == "md"));
    documents.map(|path| (path.clone(), fs::read_to_string(path).expect("text"))).collect()
}

#[test]
fn every_paper_that_is_cited_is_in_the_bibliography_and_no_link() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bibliography = fs::read_to_string(root.join("bibliography.bib")).expect("bibliography.bib");
    let is_known = |key: &str| bibliography.contains(&format!("{{{key},"));
    let mut breaches = Vec::new();
    for source in sources() {
        for (i, line) in source.text.lines().enumerate().filter(|(_, line)| line.trim().starts_with("//")) {
            for (key, is_code) in citations(line) {
                if !is_known(key) {
                    breaches.push(format!("{}:{}: {key} is not in the bibliography", source.path, i + 1));
                }
                // Without it rustdoc takes the citation for a link.
                if !is_code {
                    breaches.push(format!("{}:{}: [{key}] is to stand in a code span", source.path, i + 1));
                }
            }
        }
    }
    for (path, text) in documents() {
        let unknown = text.lines().flat_map(citations).filter(|(key, _)| !is_known(key));
        breaches.extend(unknown.map(|(key, _)| format!("{}: {key} is not in the bibliography", path.display())));
    }
    check("citations", breaches);
}

#[test]
fn documents_lead_somewhere_and_every_method_has_its_page() {
    let mut breaches = Vec::new();
    for (path, text) in documents() {
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
        let files = links.filter(|link| !link.contains("://")).map(|link| link.split('#').next().unwrap_or_default());
        let folder = path.parent().expect("a folder");
        let lost = files.filter(|file| !file.is_empty() && !folder.join(file).exists());
        breaches.extend(lost.map(|file| format!("{}: {file}", path.display())));
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let index = fs::read_to_string(root.join("docs/README.md")).expect("docs/README.md");
    let mut methods = 0;
    for source in sources().iter().filter(|source| source.path.starts_with("src/engine/methods/")) {
        let names = source.text.split("fn name(&self) -> &'static str {").skip(1);
        for name in names.filter_map(|rest| rest.split('"').nth(1)) {
            methods += 1;
            let page = format!("methods/{name}.md");
            if !root.join("docs").join(&page).exists() || !index.contains(&page) {
                breaches.push(format!("{}: no docs/{page}, or no link to it in docs/README.md", source.path));
            }
        }
    }
    assert!(methods >= 4, "{methods}");
    check("documents", breaches);
}

/// A field of a schema of the OpenAPI document.
struct SchemaField<'a> {
    name: &'a str,
    is_list: bool,
    /// The schema that it or its elements have, where that has a name.
    of: Option<&'a str>,
}

/// The fields of a schema; none if it is no object with names. The document is read as it is written: indented by two.
fn schema_fields<'a>(document: &'a str, schema: &str) -> Vec<SchemaField<'a>> {
    let block = |text: &'a str, opening: &str, indent: usize| {
        let (_, rest) = text.split_once(&format!("\n{}{opening}: {{\n", " ".repeat(indent)))?;
        rest.split_once(&format!("\n{}}}", " ".repeat(indent))).map(|(inside, _)| inside)
    };
    let properties = block(document, &format!("\"{schema}\""), 6).and_then(|text| block(text, "\"properties\"", 8));
    let mut fields: Vec<SchemaField<'a>> = Vec::new();
    for line in properties.unwrap_or_default().lines() {
        let text = line.trim_start();
        let depth = line.len() - text.len();
        if let (10, Some(name)) = (depth, text.strip_prefix('"').and_then(|rest| rest.strip_suffix("\": {"))) {
            fields.push(SchemaField { name, is_list: false, of: None });
        } else if let Some(field) = fields.last_mut() {
            field.is_list |= depth == 12 && text.starts_with("\"type\": \"array\"");
            if let Some(rest) = text.strip_prefix("\"$ref\": \"#/components/schemas/") {
                field.of = rest.split('"').next();
            }
        }
    }
    fields
}

/// The paths of the fields below a schema: those that have no fields themselves, and those that have some.
fn schema_paths(document: &str, schema: &str, above: &str, leaves: &mut Vec<String>, inner: &mut Vec<String>) {
    for field in schema_fields(document, schema) {
        let path = format!("{above}{}", field.name);
        let of = field.of.filter(|of| !schema_fields(document, of).is_empty());
        let Some(of) = of else {
            leaves.push(path);
            continue;
        };
        let path = if field.is_list { format!("{path}[]") } else { path };
        schema_paths(document, of, &format!("{path}."), leaves, inner);
        inner.push(path);
    }
}

#[test]
fn every_field_of_the_report_has_its_line_in_the_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    let (document, page) = (read("api/openapi.json"), read("docs/report.md"));
    let (mut leaves, mut inner) = (Vec::new(), Vec::new());
    schema_paths(&document, "ReportBody", "", &mut leaves, &mut inner);
    assert!(leaves.len() > 40 && inner.contains(&"map.singularities[]".to_owned()), "{leaves:?} {inner:?}");
    let rows = page.lines().filter(|line| line.starts_with("| `"));
    let rows: Vec<Vec<&str>> = rows.map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect()).collect();
    let mut breaches = Vec::new();
    let has_line = |path: &String| rows.iter().any(|row| row[0] == format!("`{path}`"));
    breaches.extend(leaves.iter().filter(|path| !has_line(path)).map(|path| format!("{path}: no line")));
    for row in &rows {
        let path = row[0].trim_matches('`').to_owned();
        if !leaves.contains(&path) && !inner.contains(&path) {
            breaches.push(format!("{path}: no such field"));
        }
        let [_, unit, meaning, place] = row.as_slice() else {
            breaches.push(format!("{path}: a line has field, unit, meaning and source"));
            continue;
        };
        if unit.is_empty() || meaning.is_empty() || !root.join("src").join(place.trim_matches('`')).exists() {
            breaches.push(format!("{path}: no unit, no meaning, or no such source as {place}"));
        }
    }
    for source in sources().iter().filter(|source| source.path.starts_with("src/engine/mesh/condition/")) {
        let names = source.text.split("tally.add(\"").skip(1).filter_map(|rest| rest.split('"').next());
        let unknown = names.filter(|name| !page.contains(&format!("`{name}`")));
        breaches.extend(unknown.map(|name| format!("{}: the repair {name} is not in the page", source.path)));
    }
    check("docs/report.md", breaches);
}

#[test]
fn the_test_sees_seeded_breaches() {
    assert!(contains_word("let t = Instant::now();", "Instant"));
    assert!(contains_word("use std::collections::HashMap;", "HashMap"));
    assert!(!contains_word("let instantiate = AnInstantaneous;", "Instant"));
    assert!(contains_word("eprintln!(\"x\")", "eprintln!") && !contains_word("eprintln!(\"x\")", "println!"));
    let cited: Vec<_> = citations("[a_2001], `[b_c_2002]`, `[d_2003, section 6]`, [0, 1), `x[i]`, [e_04]").collect();
    assert_eq!(cited, [("a_2001", false), ("b_c_2002", true), ("d_2003", true)]);
    let source = Source { path: "src/engine/mesh/a/b.rs".into(), text: "// x\nuse y;\n".into() };
    assert_eq!(source.code().collect::<Vec<_>>(), [(2, "use y;")]);
}
