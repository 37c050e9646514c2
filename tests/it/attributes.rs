//! What the input carries besides its shape goes the whole road to the files.

use quadrille::service::formats::{Format, QuadFormat, ReadLimits, read_quads, read_soup};
use reqwest::StatusCode;
use serde_json::{Value, json as value};

use crate::client::Client;
use crate::meshes::{obj, surface};
use crate::server::Server;

/// Files of a job that has to succeed.
async fn files(client: &Client, mesh: &[u8], spec: &Value) -> Vec<(QuadFormat, Vec<u8>)> {
    let job = client.submit("cube.obj", mesh, spec).await;
    let done = client.finished(&job).await;
    assert_eq!(done["status"], "succeeded", "{}", done["problem"]);
    let mut files = Vec::new();
    for format in QuadFormat::ALL {
        let path = format!("{}?format={}", done["urls"]["quad_mesh"].as_str().unwrap(), format.extension());
        let response = client.get(&path).await;
        assert_eq!(response.status(), StatusCode::OK, "{path}");
        files.push((format, response.bytes().await.unwrap().to_vec()));
    }
    files
}

/// The side of a cube around the origin that these corners lie on.
fn side(corners: &[glam::DVec3]) -> usize {
    let centre = corners.iter().sum::<glam::DVec3>();
    let axis = centre.abs().max_position();
    2 * axis + usize::from(centre[axis] > 0.0)
}

/// A cube as OBJ: colours linear in position, one material per side, and per side coordinates of its own: u is the number
/// of the side plus a number between 0.1 and 0.9.
fn painted() -> Vec<u8> {
    let cube = surface("cube", 300);
    let mut text = String::new();
    for p in &cube.positions {
        let [r, g, b] = p.to_array().map(|x| 0.5 + 0.5 * x);
        text += &format!("v {} {} {} {r} {g} {b}\n", p.x, p.y, p.z);
    }
    let mut n = 0;
    for polygon in cube.polygons() {
        let corners: Vec<_> = polygon.iter().map(|&v| cube.positions[v as usize]).collect();
        let (axis, side) = (side(&corners) / 2, side(&corners));
        text += &format!("usemtl side {side}\nf");
        let mut coordinates = String::new();
        for (v, p) in polygon.iter().zip(&corners) {
            n += 1;
            coordinates += &format!("vt {} {}\n", side as f64 + 0.5 + 0.4 * p[(axis + 1) % 3], p[(axis + 2) % 3]);
            text += &format!(" {}/{n}", v + 1);
        }
        text += "\n";
        text += &coordinates;
    }
    text.into_bytes()
}

#[tokio::test(flavor = "multi_thread")]
async fn materials_colours_and_texture_coordinates_come_out_of_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::real(folder.path()).await;
    let client = &server.client;
    let spec = value!({"target": {"quads": 150}});
    for (format, bytes) in files(client, &painted(), &spec).await {
        let quads = read_quads(&bytes, format).unwrap();
        if format == QuadFormat::Usda {
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(text.matches("def GeomSubset").count(), 6);
            assert!(text.contains("primvars:st") && text.contains("primvars:displayColor"));
            continue;
        }
        let soup = read_soup(&bytes, Format::from_extension(format.extension()), &ReadLimits::default()).unwrap();
        assert_eq!(soup.colours.len(), quads.positions.len(), "{format:?}");
        let tolerance = if format == QuadFormat::Ply { 0.51 / 255.0 } else { 1e-6 };
        for (p, colour) in soup.positions.iter().zip(&soup.colours) {
            for k in 0..3 {
                assert!((f64::from(colour[k]) - (0.5 + 0.5 * p[k])).abs() < tolerance, "{format:?}: {p} {colour:?}");
            }
        }
        if format == QuadFormat::Ply {
            continue;
        }
        assert_eq!(soup.uv.len(), soup.indices.len());
        for p in 0..soup.n_polygons() {
            let corners: Vec<_> = soup.polygon(p).iter().map(|&v| soup.positions[v as usize]).collect();
            let (side, axis) = (side(&corners), side(&corners) / 2);
            assert_eq!(soup.material_names[soup.materials[p] as usize], format!("side {side}"));
            for (uv, p) in soup.uv[soup.corners_of(p)].iter().zip(&corners) {
                let expected = [side as f64 + 0.5 + 0.4 * p[(axis + 1) % 3], p[(axis + 2) % 3]];
                let far = (0..2).map(|k| (f64::from(uv[k]) - expected[k]).abs()).fold(0.0, f64::max);
                assert!(far < 1e-5, "{format:?}: {uv:?} instead of {expected:?}");
            }
        }
    }
    let mut nothing = spec.clone();
    nothing["preserve"] = value!([]);
    let plain = obj(&surface("cube", 300));
    let bare = files(client, &painted(), &nothing).await;
    assert_eq!(files(client, &plain, &spec).await, files(client, &plain, &nothing).await);
    assert!(!String::from_utf8_lossy(&bare[0].1).contains("usemtl"));
    server.stop().await;
}
