//! A method of one's own: this file is all that it takes, from the field to the download.

use std::f64::consts::TAU;

use quadrille::engine::field::{BranchSearch, CrossField, Frames};
use quadrille::engine::methods::{
    BoundaryLines, Data, Level, MapProduct, Method, MethodError, Parameter, Parameters, Product, Range, register,
};
use quadrille::engine::parameterize::{MapSystem, measure_map};
use quadrille::engine::problem::Problem;
use quadrille::engine::run::{RunContext, Stage};
use reqwest::StatusCode;
use serde_json::json as value;

use crate::client::{json, problem};
use crate::meshes::{obj, surface};
use crate::server::Server;

const TURN: Parameter = Parameter {
    name: "turn",
    help: "Angle in degrees between the crosses and the circles of latitude.",
    range: Range::Number { least: 0.0, most: 45.0, default: 0.0 },
};

/// A field that keeps its angle to the circles around the z axis, as a torus has one without singularities.
#[derive(Debug)]
struct ConstantField;

impl Method for ConstantField {
    fn name(&self) -> &'static str {
        "constant-field"
    }

    fn summary(&self) -> &'static str {
        "A field along the circles around the z axis."
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[TURN]
    }

    fn level(&self) -> Level {
        Level::L0
    }

    fn stages(&self) -> &'static [Stage] {
        &[Stage::Map, Stage::Round, Stage::Extract]
    }

    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError> {
        let nothing = |cause: String| MethodError::Nothing { cause, map: None };
        let mesh = &problem.surface.mesh;
        let frames = Frames::new(mesh);
        let angle = |f: usize| {
            let [a, b, c] = mesh.triangle(f);
            let centre = (a + b + c) / 3.0;
            let along = frames.coordinates(f, glam::DVec3::Z.cross(centre));
            along.y.atan2(along.x) + parameters.number(&TURN) / 360.0 * TAU
        };
        let field = CrossField::from_angles(mesh, &frames, (0..mesh.n_faces()).map(angle).collect());
        let flags = problem.surface.features.halfedge_flags(mesh);
        let weight = vec![1.0; mesh.n_faces()];
        let scale = 1.0 / problem.edge_length;
        let system = MapSystem::new(ctx, mesh, &frames, &field, &flags, &problem.surface.features.corners, weight)
            .map_err(|error| nothing(error.to_string()))?;
        let rounded = system.round(ctx, mesh, scale).map_err(|error| nothing(error.to_string()))?;
        let grid = system.map(mesh, &rounded).map_err(|error| nothing(error.to_string()))?;
        let measures = measure_map(mesh, &frames, &grid, scale);
        Ok(Product::Map(Box::new(MapProduct {
            surface: problem.surface.as_ref().clone(),
            corner_of: problem.surface.features.corners.iter().map(|&v| (v, v)).collect(),
            grid,
            boundary: BoundaryLines::OnGrid,
            scale,
            singularities: field.singularities(),
            n_integers: system.n_integers(),
            measures,
            branch_search: BranchSearch::default(),
            curl_energy: Some(rounded.curl_energy),
            rounding_energy: Some(rounded.rounding_energy),
            search_left_out: None,
            details: Data::None,
        })))
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_method_in_one_file_has_its_parameters_its_report_and_its_quads() {
    assert!(register(&ConstantField) && !register(&ConstantField), "a name is taken once");
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;

    let (_, methods) = json(client.get("/v1/methods").await).await;
    let own = methods["methods"].as_array().unwrap().iter().find(|m| m["name"] == "constant-field").unwrap();
    assert_eq!(own["parameters"]["properties"]["params"]["properties"]["turn"]["maximum"], 45.0);
    assert_eq!(own["defaults"]["params"], value!({"turn": 0.0}));

    let torus = obj(&surface("torus", 4000));
    let spec = value!({"method": "constant-field", "target": {"quads": 600}});
    let refused = client.submission("torus.obj", &torus, &value!({"method": "constant-field", "params": {"turn": 50}}));
    let refused = problem(refused.send().await.unwrap(), 422, "invalid-spec").await;
    assert_eq!(refused["errors"][0]["pointer"], "/params/turn");

    let job = client.submit("torus.obj", &torus, &spec).await;
    let done = client.finished(&job).await;
    assert_eq!((&done["status"], &done["spec"]["params"]["turn"]), (&value!("succeeded"), &value!(0.0)), "{done}");
    assert_eq!((&done["result"]["level"], &done["result"]["irregular_vertices"]), (&value!("L0"), &value!(0)));
    let (status, report) = json(client.get(done["urls"]["report"].as_str().unwrap()).await).await;
    assert_eq!((status, &report["method"]), (StatusCode::OK, &value!("constant-field")));
    assert_eq!(report["map"]["singularities"], value!([]));
    let count = report["quads"]["count"].as_f64().unwrap();
    assert!((count / 600.0 - 1.0).abs() < 0.1, "{count}");
    let listed = json(client.get("/v1/jobs?method=constant-field").await).await.1;
    assert_eq!(listed["jobs"].as_array().map(Vec::len), Some(1));
    server.stop().await;
}
