//! Which file imports which, read from the paths in the sources. A path is followed through the re-exports of `mod.rs`
//! files to the file that defines the item; unit tests at the end of a file are not read.

use std::collections::{BTreeMap, BTreeSet};

use crate::Source;

/// How many re-exports a path may go through before it is given up.
const MOST_STEPS: usize = 20;

/// The files of `src` as modules, and which of them import which.
pub(crate) struct Imports {
    files: Vec<File>,
    /// The files by the paths of their modules, such as `service::wire::spec`.
    modules: BTreeMap<String, usize>,
}

struct File {
    path: String,
    module: String,
    /// The paths that a `use` gives a name to, by that name.
    named: BTreeMap<String, String>,
    /// The paths that the file depends on, as they are written.
    used: BTreeSet<String>,
}

impl Imports {
    pub(crate) fn of(sources: &[Source]) -> Self {
        let files: Vec<File> = sources.iter().filter_map(File::read).collect();
        let modules = files.iter().enumerate().map(|(i, file)| (file.module.clone(), i)).collect();
        Self { files, modules }
    }

    /// All files with the paths that they depend on, as they are written.
    pub(crate) fn paths(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().flat_map(|file| file.used.iter().map(|used| (file.path.as_str(), used.as_str())))
    }

    /// The files that import each other in circles: every group of files from each of which all of the group are
    /// reached.
    pub(crate) fn circles(&self) -> Vec<Vec<&str>> {
        let edges: Vec<BTreeSet<usize>> = (0..self.files.len()).map(|i| self.imported_by(i)).collect();
        let reached: Vec<BTreeSet<usize>> = (0..edges.len()).map(|i| reachable(i, &edges)).collect();
        let mut circles = Vec::new();
        for i in (0..edges.len()).filter(|&i| reached[i].contains(&i)) {
            let group: Vec<usize> = reached[i].iter().copied().filter(|&j| reached[j].contains(&i)).collect();
            if group[0] == i {
                circles.push(group.iter().map(|&j| self.files[j].path.as_str()).collect());
            }
        }
        circles
    }

    /// What the files of a group name of each other, for the message of a test.
    pub(crate) fn inside(&self, group: &[&str]) -> Vec<String> {
        let mut names: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
        for file in self.files.iter().filter(|file| group.contains(&file.path.as_str())) {
            for used in &file.used {
                let other = self.definer(file, used).map(|i| self.files[i].path.as_str());
                let Some(other) = other.filter(|other| *other != file.path && group.contains(other)) else { continue };
                names.entry((&file.path, other)).or_default().insert(used.rsplit("::").next().unwrap_or_default());
            }
        }
        names.iter().map(|((file, other), names)| format!("  {file} uses {names:?} of {other}")).collect()
    }

    fn imported_by(&self, i: usize) -> BTreeSet<usize> {
        let file = &self.files[i];
        file.used.iter().filter_map(|used| self.definer(file, used)).filter(|&j| j != i).collect()
    }

    /// The file that defines what `path` means in `file`, if it is a file of ours.
    fn definer(&self, file: &File, path: &str) -> Option<usize> {
        let (mut file, mut path) = (file, path.to_owned());
        for _ in 0..MOST_STEPS {
            let (module, rest) = self.module_at(file, &path)?;
            file = &self.files[module];
            // A whole module is only a name; what is used of it has a path of its own.
            let name = rest.first()?;
            // What another file gave a name to there; otherwise it is defined there.
            let Some(named) = file.named.get(*name) else { return Some(module) };
            path = [&[named.as_str()], &rest[1..]].concat().join("::");
        }
        None
    }

    /// The deepest module on the path, and what is left of the path inside it.
    fn module_at<'a>(&self, file: &File, path: &'a str) -> Option<(usize, Vec<&'a str>)> {
        let mut module = file.module.clone();
        let mut segments: Vec<&str> = path.split("::").collect();
        let mut first = true;
        while let Some(&segment) = segments.first() {
            let next = match segment {
                "crate" => String::new(),
                "self" => module.clone(),
                "super" => module.rsplit_once("::").map_or("", |(parent, _)| parent).to_owned(),
                name if module.is_empty() => name.to_owned(),
                name => format!("{module}::{name}"),
            };
            let is_relative = ["crate", "self", "super"].contains(&segment);
            if !is_relative && !self.modules.contains_key(&next) {
                // A first name that is no module and has no meaning in the file is another crate.
                if first && !file.named.contains_key(segment) {
                    return None;
                }
                break;
            }
            module = next;
            segments.remove(0);
            first = false;
        }
        Some((*self.modules.get(&module)?, segments))
    }
}

impl File {
    fn read(source: &Source) -> Option<Self> {
        let module = source.path.strip_prefix("src/")?.strip_suffix(".rs")?;
        let module = module.strip_suffix("/mod").unwrap_or(module).replace('/', "::");
        let module = if module == "lib" { String::new() } else { module };
        let lines: Vec<&str> = source.code().map(|(_, line)| line).collect();
        let tests = lines.windows(2).position(|pair| pair[0] == "#[cfg(test)]" && pair[1].ends_with("mod tests {"));
        let mut code = lines[..tests.unwrap_or(lines.len())].join("\n");
        let (mut named, mut used, mut handed_on) = (BTreeMap::new(), BTreeSet::new(), Vec::new());
        while let Some((start, end, is_public)) = next_use(&code) {
            let statement: String = code[start..end].split_whitespace().collect::<Vec<_>>().join(" ");
            let tree = statement.split_once("use ").map_or("", |(_, tree)| tree);
            for (path, name) in leaves("", tree) {
                if is_public {
                    handed_on.push((path.clone(), name.clone()));
                } else {
                    used.insert(path.clone());
                }
                named.insert(name, path);
            }
            code.replace_range(start..=end, "");
        }
        // Who may use an item, and which modules there are, is no import either.
        let lines = code.lines().filter(|line| !(line.contains("mod ") && line.ends_with(';')));
        let code: String = lines.map(without_visibility).collect::<Vec<_>>().join("\n");
        let words: BTreeSet<&str> = code.split(|c| !is_of_path(c)).collect();
        for path in words.iter().filter(|word| word.contains("::")) {
            used.insert(path.trim_end_matches("::").to_owned());
        }
        // What is only handed on to others is no import; what the file uses itself as well is one.
        let firsts: BTreeSet<&str> = words.iter().filter_map(|word| word.split("::").next()).collect();
        used.extend(handed_on.into_iter().filter(|(_, name)| firsts.contains(name.as_str())).map(|(path, _)| path));
        Some(Self { path: source.path.clone(), module, named, used })
    }
}

fn is_of_path(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == ':'
}

/// The line without the path of `pub(in …)`.
fn without_visibility(line: &str) -> &str {
    line.split_once("pub(in ").and_then(|(_, rest)| rest.split_once(')')).map_or(line, |(_, rest)| rest)
}

/// Where the next `use` begins and where its `;` is, and whether it is a re-export.
fn next_use(code: &str) -> Option<(usize, usize, bool)> {
    let mut at = 0;
    for line in code.split_inclusive('\n') {
        let visible = line.strip_prefix("pub(").and_then(|rest| rest.split_once(") ")).map(|(_, rest)| rest);
        let visible = visible.or_else(|| line.strip_prefix("pub "));
        if visible.unwrap_or(line).starts_with("use ") {
            return Some((at, at + code[at..].find(';')?, visible.is_some()));
        }
        at += line.len();
    }
    None
}

/// The paths of a tree of `use`, with the names they get.
fn leaves(prefix: &str, tree: &str) -> Vec<(String, String)> {
    let tree = tree.trim();
    let join = |rest: &str| if prefix.is_empty() { rest.to_owned() } else { format!("{prefix}::{rest}") };
    if let Some((before, group)) = tree.split_once('{') {
        let group = group.strip_suffix('}').unwrap_or(group);
        let before = before.trim_end_matches("::");
        let prefix = if before.is_empty() { prefix.to_owned() } else { join(before) };
        return parts(group).into_iter().flat_map(|part| leaves(&prefix, part)).collect();
    }
    let (path, name) = tree.split_once(" as ").map_or((tree, None), |(path, name)| (path, Some(name)));
    let path = if path == "self" { prefix.to_owned() } else { join(path) };
    let last = path.rsplit("::").next().unwrap_or_default().to_owned();
    vec![(path, name.map_or(last, str::to_owned))]
}

/// The parts of a group between the commas that stand in no inner group.
fn parts(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    found.push(&group[start..]);
    found.retain(|part| !part.trim().is_empty());
    found
}

fn reachable(from: usize, edges: &[BTreeSet<usize>]) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut open: Vec<usize> = edges[from].iter().copied().collect();
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(&edges[next]);
        }
    }
    found
}
