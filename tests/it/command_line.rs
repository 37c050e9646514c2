//! The program on files: what lies beside them, batches, what exists already, and what it says.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::meshes::{gltf, obj, surface};

/// The program in a folder, without a terminal.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_quadrille"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("no signal ended it")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn cube(folder: &Path, name: &str) {
    fs::write(folder.join(name), obj(&surface("cube", 300))).expect("a file");
}

/// A cube as `cube.gltf` that names its buffer so.
fn cube_with_buffer(folder: &Path, uri: &str) -> Vec<u8> {
    let (mut document, buffer) = gltf(&surface("cube", 300));
    document["buffers"][0]["uri"] = uri.into();
    fs::write(folder.join("cube.gltf"), document.to_string()).expect("a file");
    buffer
}

const FAST: [&str; 5] = ["--target-quads", "60", "--optimise", "none", "--force"];

#[test]
fn a_gltf_is_read_with_what_lies_beside_it() {
    let outer = tempfile::tempdir().expect("a folder");
    let folder = outer.path().join("in");
    fs::create_dir_all(folder.join("data")).expect("a folder");
    let buffer = cube_with_buffer(&folder, "data/my%20cube.bin");
    fs::write(folder.join("data/my cube.bin"), &buffer).expect("a file");
    // From its own folder and from another one.
    for (from, input) in [(folder.as_path(), "cube.gltf"), (outer.path(), "in/cube.gltf")] {
        let made = run(from, &[&["remesh", input, "-o", "out.obj"], &FAST[..]].concat());
        assert_eq!(code(&made), 0, "{}", said(&made));
        assert_eq!(code(&run(from, &["check", input, "out.obj"])), 0);
    }
    // Nothing above the folder, by no name.
    fs::write(outer.path().join("cube.bin"), &buffer).expect("a file");
    let absolute = outer.path().join("cube.bin");
    for uri in ["../cube.bin", "data/../../cube.bin", absolute.to_str().expect("text"), "file:cube.bin", "missing.bin"]
    {
        cube_with_buffer(&folder, uri);
        let refused = run(&folder, &["remesh", "cube.gltf", "-o", "no.obj"]);
        assert_eq!(code(&refused), 3, "{uri}");
        assert!(!folder.join("no.obj").exists());
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&absolute, folder.join("link.bin")).expect("a link");
        cube_with_buffer(&folder, "link.bin");
        assert_eq!(code(&run(&folder, &["remesh", "cube.gltf", "-o", "no.obj"])), 3);
    }
}

#[test]
fn a_batch_goes_on_after_a_failure_and_ends_with_the_worst_code() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    cube(folder, "a.obj");
    fs::write(folder.join("b.obj"), b"nothing").expect("a file");
    cube(folder, "c.obj");
    let batch = ["remesh", "a.obj", "b.obj", "c.obj", "--report", "{stem}.json", "-o", "quads/"];
    let made = run(folder, &[&batch, &FAST[..4]].concat());
    assert_eq!(code(&made), 3, "{}", said(&made));
    for (name, is_there) in [("quads/a.quads.obj", true), ("quads/b.quads.obj", false), ("quads/c.quads.obj", true)] {
        assert_eq!(folder.join(name).exists(), is_there, "{name}");
    }
    assert!(folder.join("a.json").exists() && !folder.join("b.json").exists());
    let said = said(&made);
    for name in ["a.obj", "b.obj", "c.obj"] {
        let start = format!("quadrille: {name}: ");
        assert_eq!(said.lines().filter(|line| line.starts_with(&start)).count(), 1, "{said}");
    }
    // What exists is a failure of its own, and the others are made.
    fs::remove_file(folder.join("quads/c.quads.obj")).expect("a file");
    fs::remove_file(folder.join("c.json")).expect("a file");
    let again =
        run(folder, &[&["remesh", "a.obj", "c.obj", "--report", "{stem}.json", "-o", "quads/"], &FAST[..4]].concat());
    assert_eq!(code(&again), 2);
    assert!(folder.join("quads/c.quads.obj").exists());
}

#[test]
fn a_batch_whose_files_have_no_place_each_is_refused_before_any_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    cube(folder, "a.obj");
    fs::create_dir(folder.join("other")).expect("a folder");
    cube(folder, "other/a.obj");
    cube(folder, "b.obj");
    for arguments in [
        &["remesh", "a.obj", "b.obj", "-o", "one.obj"][..],
        &["remesh", "a.obj", "other/a.obj", "-o", "out/"],
        &["remesh", "a.obj", "b.obj", "-o", "{stem}.ply", "--report", "one.json"],
        &["remesh", "a.obj", "-", "-o", "{stem}.ply"],
        &["remesh", "a.obj", "b.obj", "-o", "{stem}.fbx"],
    ] {
        assert_eq!(code(&run(folder, arguments)), 2, "{arguments:?}");
    }
    let files = fs::read_dir(folder).expect("a folder").flatten().filter(|entry| entry.path().is_file());
    assert_eq!(files.count(), 2);
}

#[cfg(unix)]
#[test]
fn an_interruption_ends_the_whole_batch() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for name in ["a.obj", "b.obj"] {
        fs::write(folder.join(name), obj(&surface("genus5", 30_000))).expect("a file");
    }
    let mut process = command(folder, &["remesh", "a.obj", "b.obj", "-o", "{stem}.ply", "--progress", "json"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    // Its first line says that the first run has begun.
    let mut first = String::new();
    let mut lines = std::io::BufReader::new(process.stderr.take().expect("a pipe"));
    std::io::BufRead::read_line(&mut lines, &mut first).expect("a line");
    assert!(first.contains("event"), "{first}");
    assert!(Command::new("kill").args(["-INT", &process.id().to_string()]).status().expect("kill").success());
    std::io::copy(&mut lines, &mut std::io::sink()).expect("all it says");
    assert_eq!(process.wait().expect("its end").code(), Some(130));
    assert!(!folder.join("a.ply").exists() && !folder.join("b.ply").exists());
}

#[test]
fn files_that_exist_are_replaced_only_by_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    cube(folder, "a.obj");
    fs::write(folder.join("out.obj"), b"precious").expect("a file");
    let remesh = |options: &[&str]| {
        code(&run(
            folder,
            &[&["remesh", "a.obj", "-o", "out.obj", "--report", "out.json"], &FAST[..4], options].concat(),
        ))
    };
    assert_eq!(remesh(&[]), 2);
    assert_eq!(fs::read(folder.join("out.obj")).expect("a file"), b"precious");
    assert!(!folder.join("out.json").exists());
    assert_eq!(remesh(&["--force"]), 0);
    assert!(fs::read(folder.join("out.obj")).expect("a file").starts_with(b"# quads"));
    // A report alone is enough to be asked about.
    fs::remove_file(folder.join("out.obj")).expect("a file");
    assert_eq!(remesh(&[]), 2);
    assert!(!folder.join("out.obj").exists());
    assert_eq!(code(&run(folder, &["sample", "cube", "-o", "a.obj"])), 2);
    assert_eq!(code(&run(folder, &["sample", "cube", "-o", "a.obj", "--force"])), 0);
}

#[test]
fn how_much_is_said_can_be_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    cube(folder, "a.obj");
    let lines = |options: &[&str]| {
        let made = run(folder, &[&["remesh", "a.obj", "-o", "out.obj"], &FAST[..], options].concat());
        assert_eq!(code(&made), 0, "{}", said(&made));
        said(&made).lines().count()
    };
    assert_eq!(lines(&["-q"]), 0);
    assert_eq!(lines(&["-q", "--progress", "json"]), 0);
    assert!(lines(&[]) >= 1 && lines(&["-v"]) > lines(&[]));
    let wrong = run(folder, &["remesh", "missing.obj", "-o", "no.obj", "-q"]);
    assert_eq!((code(&wrong), said(&wrong).lines().count()), (3, 1));
}

#[test]
fn a_file_is_inspected_for_people_and_for_programs() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let buffer = cube_with_buffer(folder, "cube.bin");
    fs::write(folder.join("cube.bin"), &buffer).expect("a file");
    let found = run(folder, &["inspect", "cube.gltf", "--json"]);
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    assert_eq!((&found["format"], &found["holds"]["polygons"]), (&"glTF".into(), &found["holds"]["triangles"]));
    let surface = &found["surface"];
    assert_eq!((&surface["components"], &surface["boundaries"], &surface["genus"]), (&1.into(), &0.into(), &0.into()));
    let text = run(folder, &["inspect", "cube.gltf"]);
    assert_eq!(code(&text), 0);
    assert!(String::from_utf8_lossy(&text.stdout).lines().count() >= 4);
    // A surface that is refused is described all the same.
    fs::write(folder.join("flat.obj"), b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").expect("a file");
    let refused = run(folder, &["inspect", "flat.obj", "--json"]);
    assert_eq!(code(&refused), 3);
    let refused: Value = serde_json::from_slice(&refused.stdout).expect("JSON");
    assert!(refused["surface"].is_null() && refused["problem"]["type"].is_string());
    assert_eq!(code(&run(folder, &["inspect", "missing.obj"])), 3);
}

#[test]
fn packages_get_completions_and_manual_pages() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = run(folder, &["completions", shell]);
        assert!(code(&script) == 0 && String::from_utf8_lossy(&script.stdout).contains("target-quads"), "{shell}");
    }
    assert_eq!(code(&run(folder, &["completions", "tcl"])), 2);
    let page = run(folder, &["man"]);
    assert!(code(&page) == 0 && String::from_utf8_lossy(&page.stdout).contains(".TH quadrille 1"));
    assert_eq!(code(&run(folder, &["man", "-o", "pages"])), 0);
    let page = fs::read_to_string(folder.join("pages/quadrille-remesh.1")).expect("a page");
    assert!(page.contains("force"));
}
