//! Specs that are read, refused and written.

use glam::DVec3;
use serde_json::{Value, json};

use utoipa::openapi::schema::Object;

use super::*;
use crate::engine::methods::{Range, STANDARD};
use crate::engine::pipeline::{
    Boundary, GivenBranchPoints, GivenMatching, GivenVectors, Preserve, RemeshSpec, Symmetry, Target,
};
use crate::service::wire::{LevelName, Violation};

fn resolve(spec: &Value) -> Result<ResolvedSpec, Vec<Violation>> {
    ResolvedSpec::from_json(spec.to_string().as_bytes()).map_err(|problem| problem.errors)
}

fn pointers(spec: Value) -> Vec<String> {
    let mut found: Vec<_> = resolve(&spec).expect_err("must be refused").into_iter().map(|v| v.pointer).collect();
    found.sort();
    found
}

#[test]
fn an_empty_spec_is_the_engines_default() {
    for text in ["", " \n", "{}", "null", r#"{"features": null, "seed": null, "accept": {}}"#] {
        let resolved = ResolvedSpec::from_json(text.as_bytes()).unwrap();
        assert_eq!(resolved.spec, RemeshSpec::default());
        assert_eq!(resolved, ResolvedSpec::default());
    }
}

#[test]
fn all_violations_are_reported_at_once() {
    let spec = json!({
        "target": {"quads": 0}, "smoothing": 2, "colour": 1, "features": {"angle": -1, "corner": true},
        "seed": "x", "tags": ["", "good", "x".repeat(65)], "method": "layout", "symmetry": ["w"],
        "strokes": [[[0, 0, 0]]], "accept": {"level": "L7", "count": -1}, "params": {"fidelity": "loose"}, "field": {}
    });
    let expected = [
        "/accept/count",
        "/accept/level",
        "/colour",
        "/features/angle",
        "/features/corner",
        "/field",
        "/method",
        "/params/fidelity",
        "/seed",
        "/smoothing",
        "/strokes/0",
        "/symmetry",
        "/tags/0",
        "/tags/2",
        "/target/quads",
    ];
    assert_eq!(pointers(spec), expected);
}

#[test]
fn what_comes_twice_is_refused() {
    let cases = [
        (r#"{"seed": 1, "seed": 1}"#, "/seed"),
        (r#"{"seed": 1, "s\u0065ed": 1}"#, "/seed"),
        (r#"{"features": {"angle": 1, "angle": 2}}"#, "/features/angle"),
        (r#"{"target": {"quads": 1, "quads": 2}}"#, "/target/quads"),
        (r#"{"accept": {}, "accept": {}}"#, "/accept"),
    ];
    for (text, pointer) in cases {
        let violations = ResolvedSpec::from_json(text.as_bytes()).unwrap_err().errors;
        assert_eq!(violations.iter().map(|v| v.pointer.as_str()).collect::<Vec<_>>(), [pointer], "{text}");
    }
}

#[test]
fn what_this_version_cannot_do_is_refused_by_name() {
    let cases = [("output", json!("dominant")), ("webhook", json!("http://127.0.0.1/")), ("method", json!("layout"))];
    for (field, value) in cases {
        let violations = resolve(&json!({ field: value })).unwrap_err();
        assert_eq!(violations.len(), 1);
        assert_eq!(violations[0].pointer, format!("/{field}"));
        assert!(violations[0].message.contains("not available in this version"), "{}", violations[0].message);
    }
}

#[test]
fn sizes_strokes_and_symmetry_reach_the_engine() {
    let strokes = json!([[[0, 0, 0], [1, 0, 0.5]]]);
    let spec = json!({"adaptive_size": 40, "density_from_vertex_colour": true, "strokes": strokes});
    let spec = resolve(&spec).unwrap().spec;
    assert_eq!((spec.adaptive_size, spec.density_from_vertex_colour), (40.0, true));
    assert_eq!(spec.strokes, [[DVec3::ZERO, DVec3::new(1.0, 0.0, 0.5)]]);
    let spec = resolve(&json!({"symmetry": ["z", "x", "z"]})).unwrap().spec;
    assert_eq!(spec.symmetry, Symmetry::Across(vec![0, 2]));
    let spec = resolve(&json!({"symmetry": "auto"})).unwrap();
    assert_eq!(spec.spec.symmetry, Symmetry::Auto);
    assert_eq!(resolve(&serde_json::to_value(&spec).unwrap()).unwrap().spec.symmetry, Symmetry::Auto);
    assert_eq!(pointers(json!({"symmetry": "x"})), ["/symmetry"]);
    for size in [-1.0, 100.5] {
        assert_eq!(pointers(json!({ "adaptive_size": size })), ["/adaptive_size"]);
    }
}

#[test]
fn parameters_are_judged_by_their_method_and_have_its_defaults() {
    let parameters = |spec: Value| serde_json::to_value(resolve(&spec).unwrap().summary()).unwrap()["params"].clone();
    assert_eq!(parameters(json!({})), json!({"branch_price": 0.3}));
    assert_eq!(parameters(json!({"params": {"branch_price": 1}})), json!({"branch_price": 1.0}));
    assert_eq!(parameters(json!({"method": "triangle-split"})), json!({"fidelity": "strict"}));
    for (params, pointer) in [
        (json!({"branch_price": -1}), "/params/branch_price"),
        (json!({"branch_price": "1"}), "/params/branch_price"),
        (json!({"fidelity": "loose"}), "/params/fidelity"),
        (json!(7), "/params"),
    ] {
        assert_eq!(pointers(json!({ "params": params })), [pointer]);
    }
    assert_eq!(pointers(json!({"method": "triangle-pairs", "params": {"fidelity": "no"}})), ["/params/fidelity"]);
}

#[test]
fn structured_parameters_declare_schemas_of_openapi_and_may_be_left_out() {
    let all = STANDARD.iter().flat_map(|method| method.parameters());
    let shapes = all.filter_map(|parameter| match parameter.range {
        Range::Data(shape) => Some(shape),
        _ => None,
    });
    let mut found = 0;
    for shape in shapes {
        let schema: Object = serde_json::from_str(shape.schema).unwrap();
        assert!(!schema.properties.is_empty());
        assert!(schema.required.iter().all(|name| schema.properties.contains_key(name)));
        found += 1;
    }
    assert!(found > 0);
    let graph =
        |spec: Value| serde_json::to_value(resolve(&spec).unwrap().summary()).unwrap()["params"]["graph"].clone();
    assert_eq!(graph(json!({"method": "harmonic"})), Value::Null);
    assert_eq!(graph(json!({"method": "harmonic", "params": {"graph": null}})), Value::Null);
    let edge = json!({"ends": [0, 1], "tags": ["u", "-u"]});
    let short = json!({"method": "harmonic", "params": {"graph": {"vertices": [0, 5, 7], "edges": [edge]}}});
    assert_eq!(graph(short), json!({"vertices": 3, "edges": 1}), "jobs do not carry the whole of it");
    let wrong = json!({"method": "harmonic", "params": {"graph": {"vertices": [0], "edges": [{"ends": [0, 1]}]}}});
    assert_eq!(pointers(wrong), ["/params/graph/edges/0/ends"]);
}

#[test]
fn a_free_boundary_cannot_be_a_cut_of_symmetry() {
    assert_eq!(resolve(&json!({"boundary": "free"})).unwrap().spec.boundary, Boundary::Free);
    assert_eq!(pointers(json!({"boundary": "free", "symmetry": ["x"]})), ["/boundary"]);
}

#[test]
fn a_given_field_is_read_judged_and_written() {
    let spec = json!({"field": {"crosses": [[1, 0, 0], [0, 2, 0.5]], "matchings": [[0, 1, 3]]}});
    let resolved = resolve(&spec).unwrap();
    let field = resolved.spec.field.clone().unwrap();
    assert_eq!(field.vectors, GivenVectors::Crosses(vec![DVec3::X, DVec3::new(0.0, 2.0, 0.5)]));
    assert_eq!(field.matchings, [GivenMatching { from: 0, to: 1, quarters: 3 }]);
    assert_eq!(field.branch_points, GivenBranchPoints::Keep);
    let text = serde_json::to_value(&resolved).unwrap();
    assert_eq!(resolve(&text).unwrap().spec.field, resolved.spec.field);
    assert_eq!(serde_json::to_value(resolved.summary()).unwrap()["field"], json!({"count": 2}));
    let frames = json!({"frames": [[[1, 0, 0], [0, 1, 0]]], "branch_points": "optimise"});
    let field = resolve(&json!({ "field": frames })).unwrap().spec.field.unwrap();
    assert_eq!(field.vectors, GivenVectors::Frames(vec![[DVec3::X, DVec3::Y]]));
    assert_eq!(field.branch_points, GivenBranchPoints::Optimise);
    for (field, pointer) in [
        (json!({}), "/field"),
        (json!({"crosses": [], "frames": []}), "/field"),
        (json!({"crosses": [[1, 0]]}), "/field/crosses"),
        (json!({"crosses": [[1, 0, 0], [0, 0, 0]]}), "/field/crosses/1"),
        (json!({"frames": [[[1, 0, 0], [0, 0, 0]]]}), "/field/frames/0"),
        (json!({"crosses": [[1, 0, 0]], "matchings": [[0, 1, 4]]}), "/field/matchings/0"),
        (json!({"crosses": [[1, 0, 0]], "branch_points": "move"}), "/field/branch_points"),
        (json!({"crosses": [[1, 0, 0]], "faces": 1}), "/field/faces"),
        (json!([[1, 0, 0]]), "/field"),
    ] {
        assert_eq!(pointers(json!({ "field": field })), [pointer]);
    }
    let strokes = json!([[[0, 0, 0], [1, 0, 0]]]);
    assert_eq!(pointers(json!({"field": {"crosses": [[1, 0, 0]]}, "strokes": strokes})), ["/strokes"]);
    let sizes = json!({"field": frames, "adaptive_size": 5, "density_from_vertex_colour": true});
    assert_eq!(pointers(sizes), ["/adaptive_size", "/density_from_vertex_colour"]);
}

#[test]
fn a_share_of_the_count_needs_a_count() {
    let accept = json!({"level": "L1", "count": 0.1, "distance": 0.01});
    let accepted = resolve(&json!({ "accept": accept })).unwrap().accept;
    assert_eq!(accepted, Accept { level: Some(LevelName::L1), count: Some(0.1), distance: Some(0.01) });
    assert_eq!(pointers(json!({"accept": accept, "target": {"edge_length": 1}})), ["/accept/count"]);
}

#[test]
fn every_attribute_is_carried_unless_some_are_named() {
    let preserve = |spec: Value| resolve(&spec).unwrap().spec.preserve;
    let none = Preserve { materials: false, vertex_colours: false, uv: false, skin: false };
    assert_eq!(preserve(json!({})), Preserve::default());
    let all = json!({"preserve": ["uv", "skin", "materials", "vertex_colours", "uv"]});
    assert_eq!(preserve(all), Preserve::default());
    assert_eq!(preserve(json!({"preserve": []})), none);
    assert_eq!(preserve(json!({"preserve": ["vertex_colours"]})), Preserve { vertex_colours: true, ..none });
}

#[test]
fn absurd_targets_are_refused() {
    let targets = [
        json!({"quads": 0}),
        json!({"quads": 1_000_000_000}),
        json!({"quads": -1}),
        json!({"quads": 2.5}),
        json!(7),
        json!({}),
        json!({"quads": 1, "edge_length": 1}),
        json!({"edges": 1}),
    ];
    for target in targets {
        assert!(!pointers(json!({ "target": target })).is_empty(), "{target}");
    }
    for length in [0.0, -1.0] {
        assert_eq!(pointers(json!({"target": {"edge_length": length}})), ["/target/edge_length"]);
    }
}

#[test]
fn the_filled_in_spec_resolves_to_itself() {
    let spec = json!({
        "target": {"edge_length": 0.5}, "features": {"edges": [[0, 1]]}, "tags": ["a"], "seed": 7, "symmetry": ["y"],
        "strokes": [[[0, 0, 0], [1, 2, 3]]], "accept": {"level": "L2"}, "preserve": ["uv"], "non_orientable": "cut"
    });
    let first = resolve(&spec).unwrap();
    let document = SpecDocument::of(&first).unwrap();
    assert_eq!(ResolvedSpec::from_json(document.text.as_bytes()).unwrap(), first);
    assert_eq!(first.spec.target, Target::EdgeLength(0.5));
    let written: Value = serde_json::from_str(&document.text).unwrap();
    for (name, value) in spec.as_object().unwrap() {
        if !matches!(name.as_str(), "features" | "accept" | "strokes") {
            assert_eq!(&written[name], value, "{name}");
        }
    }
    let summary = serde_json::to_value(&document.summary).unwrap();
    assert_eq!((&summary["features"]["edges"], &summary["strokes"]), (&json!({"count": 1}), &json!({"count": 1})));
    assert_eq!((&summary["features"]["angle"], &summary["seed"]), (&json!(40.0), &json!(7)));
}

#[test]
fn only_edges_and_strokes_make_a_spec_longer_than_a_mebibyte() {
    let edges = |n: usize| format!("[{}]", vec!["[0,1]"; n].join(","));
    let with = |edges: &str| ResolvedSpec::from_json(format!("{{\"features\": {{\"edges\": {edges}}}}}").as_bytes());
    assert_eq!(with(&edges(1_000_000)).unwrap().spec.features.edges.len(), 1_000_000);
    assert_eq!(with(&edges(1_000_001)).unwrap_err().errors[0].pointer, "/features/edges");
    assert!(with(&" ".repeat(17 << 20)).is_err());
    let tags = format!("{{\"tags\": [{}]}}", vec!["[0]"; 1 << 20].join(","));
    let misplaced = format!("{{\"edges\": {}}}", edges(1 << 20));
    for text in [tags, misplaced, " ".repeat((1 << 20) + 1) + "{}", "[".repeat(2 << 20)] {
        let problem = ResolvedSpec::from_json(text.as_bytes()).unwrap_err();
        let told: usize = problem.errors.iter().map(|v| v.pointer.len() + v.message.len()).sum();
        assert!(!problem.errors.is_empty() && told < 10_000);
    }
}

#[test]
fn strokes_have_a_limit_in_all() {
    let stroke = format!("[{}]", vec!["[0,0,0]"; 50_001].join(","));
    let text = format!("{{\"strokes\": [{stroke},{stroke}]}}");
    assert_eq!(ResolvedSpec::from_json(text.as_bytes()).unwrap_err().errors[0].pointer, "/strokes");
    let text = format!("{{\"strokes\": [{}]}}", vec!["[]"; 100_000].join(","));
    assert_eq!(ResolvedSpec::from_json(text.as_bytes()).unwrap_err().errors[0].pointer, "/strokes");
}

#[test]
fn fields_of_a_group_stand_together_and_names_are_unique() {
    let groups: Vec<_> = FIELDS.iter().map(|field| field.path().0).collect();
    for group in table::GROUPS {
        let place = |found: Option<usize>| found.expect("a group has fields");
        let first = place(groups.iter().position(|own| *own == Some(group.name)));
        let last = place(groups.iter().rposition(|own| *own == Some(group.name)));
        assert!(groups[first..=last].iter().all(|own| *own == Some(group.name)), "{}", group.name);
    }
    let mut names: Vec<_> = FIELDS.iter().map(|field| field.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), FIELDS.len());
}

#[test]
fn the_readme_has_the_table() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
    assert!(readme.contains(&SpecTable.to_string()), "put what `quadrille spec` prints into the README");
}
