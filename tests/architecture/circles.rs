//! No two files import each other, not even through others.

use crate::imports::Imports;
use crate::{Source, check, sources};

#[test]
fn no_files_import_each_other_in_a_circle() {
    let sources = sources();
    let imports = Imports::of(&sources);
    let circles = imports.circles();
    let mut breaches = Vec::new();
    for circle in &circles {
        breaches.push(format!("{} files in a circle:", circle.len()));
        breaches.extend(imports.inside(circle));
    }
    check("circles", breaches);
}

#[test]
fn the_test_sees_seeded_breaches() {
    let circles = |files: &[(&str, &str)]| {
        let lists = ["a/mod.rs", "b/mod.rs"].into_iter().filter(|list| files.iter().all(|(path, _)| path != list));
        let files = files.iter().copied().chain(lists.map(|list| (list, "")));
        let sources: Vec<Source> =
            files.map(|(path, text)| Source { path: format!("src/{path}"), text: text.into() }).collect();
        let imports = Imports::of(&sources);
        let paths = imports.circles().concat().into_iter().map(|path| path["src/".len()..].to_owned());
        paths.collect::<Vec<_>>().join(" ")
    };
    let to_b = ("a/x.rs", "use crate::b::{self, y::{Y, Z as Other}};\nstruct X;");
    assert_eq!(circles(&[to_b, ("b/y.rs", "use crate::a::x::X;")]), "a/x.rs b/y.rs");
    assert_eq!(circles(&[to_b, ("b/y.rs", "fn f() { crate::a::x::g() }")]), "a/x.rs b/y.rs");
    // Through a third file.
    let third = ("b/z.rs", "use crate::a::x;\nfn f() { x::g() }");
    assert_eq!(circles(&[to_b, ("b/y.rs", "use super::z::Z;"), third]), "a/x.rs b/y.rs b/z.rs");
    // A list of modules hands on what its files define, and is in the circle only if it defines something itself.
    let list = ("a/mod.rs", "mod x;\nmod y;\npub use x::X;\npub(in crate::a) use y::{\n    Y,\n};");
    let (x, y) = (("a/x.rs", "use super::Y;\nstruct X;"), ("a/y.rs", "use crate::a::X;\nstruct Y;"));
    assert_eq!(circles(&[list, x, y]), "a/x.rs a/y.rs");
    assert_eq!(circles(&[list, x, ("a/y.rs", "pub(in crate::a) struct Y;")]), "");
    assert_eq!(circles(&[("a/mod.rs", "mod x;\nfn f() { x::g() }"), ("a/x.rs", "use super::f;")]), "a/mod.rs a/x.rs");
    // Unit tests may use what stands above.
    let tests = "struct Y;\n#[cfg(test)]\nmod tests {\n    use crate::a::x::X;\n}";
    assert_eq!(circles(&[to_b, ("b/y.rs", tests)]), "");
    assert_eq!(circles(&[to_b, ("b/y.rs", "// crate::a::x::X\nuse a::x::X;")]), "");
}
