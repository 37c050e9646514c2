//! A singularity graph over HTTP: exactly its quads, its own words where it cannot be, and back from the report.

use quadrille::engine::mesh::TriangleSoup;
use serde_json::{Value, json as value};

use crate::client::{json, problem};
use crate::meshes::{obj, surface};
use crate::server::Server;

/// The sides of a box, counter-clockwise seen from outside; bit k of a corner's number is its side of axis k.
const SIDES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The graph of a box around the surface with these grid units along its axes; meta-vertices are input vertices by number.
fn box_graph(soup: &TriangleSoup, units: [i64; 3]) -> Value {
    let half = soup.positions.iter().fold(glam::DVec3::ZERO, |most, p| most.max(p.abs()));
    let corner = |k: usize| {
        let sign = glam::DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let reach = |&i: &usize| (soup.positions[i] / half).dot(sign);
        (0..soup.positions.len()).max_by(|a, b| reach(a).total_cmp(&reach(b)).then(b.cmp(a))).unwrap()
    };
    let tag = |from: usize, to: usize| {
        let side = |side: &[usize; 4]| (0..4).find(|&k| (side[k], side[(k + 1) % 4]) == (from, to));
        ["u", "v", "-u", "-v"][SIDES.iter().find_map(side).unwrap()]
    };
    let pairs = (0..8usize).flat_map(|a| (0..3).map(move |axis| (a, a ^ (1 << axis), axis))).filter(|(a, b, _)| a < b);
    let edges = pairs.map(|(a, b, axis)| {
        let tags = [tag(a, b), tag(b, a)];
        let extent = if tags[0].ends_with('u') { "du" } else { "dv" };
        value!({"ends": [a, b], "tags": tags, (extent): units[axis]})
    });
    value!({"vertices": (0..8).map(corner).collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>()})
}

#[tokio::test(flavor = "multi_thread")]
async fn cube_and_ellipsoid_have_exactly_the_quads_of_a_given_graph() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let units = [4i64, 7, 5];
    let quads = 2 * (units[0] * units[1] + units[1] * units[2] + units[2] * units[0]);
    let mut ellipsoid = surface("sphere", 1500);
    ellipsoid.positions.iter_mut().for_each(|p| *p *= glam::DVec3::new(1.0, 1.8, 1.3));
    for (name, soup) in [("cube", surface("cube", 1200)), ("ellipsoid", ellipsoid)] {
        let graph = box_graph(&soup, units);
        let spec = |graph: &Value| value!({"method": "harmonic", "target": {"quads": quads}, "params": {"graph": graph}, "effort": "fast"});
        let mesh = obj(&soup);
        let done = client.finished(&client.submit("in.obj", &mesh, &spec(&graph)).await).await;
        assert_eq!(done["status"], "succeeded", "{name}: {done}");
        let report = json(client.get(done["urls"]["report"].as_str().unwrap()).await).await.1;
        assert_eq!((&report["quads"]["count"], &report["level"]), (&value!(quads), &value!("L0")), "{name}: {report}");
        assert_eq!(report["quads"]["irregular_interior"], 8, "{name}");
        // Edited and sent back: every meta-edge along the first axis one unit longer.
        let mut edited = report["map"]["details"][0]["graph"].clone();
        for edge in edited["edges"].as_array_mut().unwrap() {
            for d in ["du", "dv"] {
                if edge[d] == units[0] {
                    edge[d] = value!(units[0] + 1);
                }
            }
        }
        let done = client.finished(&client.submit("in.obj", &mesh, &spec(&edited)).await).await;
        let report = json(client.get(done["urls"]["report"].as_str().unwrap()).await).await.1;
        assert_eq!(report["quads"]["count"], quads + 2 * (units[1] + units[2]), "{name}: {done}");

        // What does not close is refused with the face and the equation.
        let mut open = graph.clone();
        let d = if open["edges"][0]["du"].is_null() { "dv" } else { "du" };
        open["edges"][0][d] = value!(9);
        let done = client.finished(&client.submit("in.obj", &mesh, &spec(&open)).await).await;
        assert_eq!(done["problem"]["type"], "urn:quadrille:problem:no-quad-mesh-found", "{name}: {done}");
        let detail = done["problem"]["detail"].as_str().unwrap();
        assert!(detail.contains("meta-face") && detail.contains("is not closed: Σ D"), "{detail}");

        // What cannot be a graph is refused at once.
        let mut unknown = graph.clone();
        unknown["edges"][3]["ends"] = value!([0, 8]);
        unknown["edges"][4]["tags"] = value!(["u", "w"]);
        let refused = client.submission("in.obj", &mesh, &spec(&unknown)).send().await.unwrap();
        let refused = problem(refused, 422, "invalid-spec").await;
        let pointers: Vec<&Value> = refused["errors"].as_array().unwrap().iter().map(|e| &e["pointer"]).collect();
        assert_eq!(pointers, ["/params/graph/edges/3/ends", "/params/graph/edges/4/tags"]);
    }
    server.stop().await;
}
